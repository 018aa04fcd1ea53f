"""Tests of the operators that mark, check and suggest light hints."""

from __future__ import annotations

import bpy
import pytest
from ajar_render import hints
from mathutils import Vector


@pytest.fixture
def halves(build, scene):
    """A closed room, divided by a wall with a gap at the floor. The lamp is in one half, the camera in the other."""
    for name, size, place in (("Room", (2, 2, 2), (0, 0, 0)), ("Wall", (0.02, 2, 1.9), (0, 0, 0.05))):
        bpy.ops.mesh.primitive_cube_add(size=1, location=place)
        bpy.context.object.name, bpy.context.object.scale = name, size
    lamp = build.object(bpy.data.lights.new("Lamp", "POINT"), "Lamp", (-0.8, 0, 0.7))
    lamp.data.energy, lamp.data.shadow_soft_size = 100, 0.05
    scene.camera.location, scene.camera.rotation_euler = (0.9, -0.9, 0.3), (1.4, 0, 0.3)
    scene.camera.data.clip_start, scene.camera.data.lens = 0.01, 20
    scene.render.resolution_x = scene.render.resolution_y = 16
    return scene


def path(points, name="Path"):
    curve = hints.new_path(bpy.context, [Vector(point) for point in points], name)
    bpy.context.view_layer.update()
    return curve


def test_marking_creates_the_collection_and_unmarking_keeps_the_curve(scene):
    data = bpy.data.curves.new("Arc", "CURVE")
    arc = bpy.data.objects.new("Arc", data)
    scene.collection.objects.link(arc)
    arc.select_set(True)
    assert hints.curves_of(scene) == []
    assert bpy.ops.ajar.mark_light_hint() == {"FINISHED"}
    assert hints.curves_of(scene) == [arc]
    assert bpy.ops.ajar.unmark_light_hint() == {"FINISHED"}
    assert hints.curves_of(scene) == [] and arc.name in scene.collection.objects


def test_the_status_of_each_path_is_shown_until_the_path_changes(halves):
    good = path([(-0.8, 0, 0.7), (-0.3, 0.1, -1), (0.5, 0.3, -0.95)], "Good")
    blocked = path([(-0.8, 0, 0.7), (0.9, 0, 0.7)], "Blocked")
    assert hints.status_of(good) == hints.NOT_CHECKED
    assert bpy.ops.ajar.check_light_hints() == {"FINISHED"}
    assert hints.attachment_of(good).attached and hints.status_of(good).startswith("Attached")
    assert not hints.attachment_of(blocked).attached and "Wall" in hints.status_of(blocked)
    good.data.splines[0].points[1].co.x += 0.1
    assert hints.attachment_of(good) is None
    blocked.ajar.hint_enabled = False
    assert hints.status_of(blocked) == "Not used"


def test_suggested_paths_are_curves_that_attach_and_start_at_the_lamp(halves):
    assert bpy.ops.ajar.suggest_light_hints(count=3, samples=8000) == {"FINISHED"}
    curves = hints.curves_of(halves)
    assert 1 <= len(curves) <= 3
    for curve in curves:
        assert hints.attachment_of(curve).attached
        assert curve.ajar.hint_light == bpy.data.objects["Lamp"]


def test_a_scene_that_cannot_be_rendered_is_reported(halves):
    path([(0, 0, 0), (1, 0, 0)])
    halves.camera.data.clip_start = halves.camera.data.clip_end = 1.0
    with pytest.raises(RuntimeError, match="Camera"):
        bpy.ops.ajar.check_light_hints()
