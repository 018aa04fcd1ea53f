"""Tests of the export of light hints, which are curves."""

from __future__ import annotations

import bpy
import numpy as np
import pytest


def _curve(name: str, points, kind: str = "POLY", collection: str = "Light Paths") -> bpy.types.Object:
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    spline = data.splines.new(kind)
    target = spline.bezier_points if kind == "BEZIER" else spline.points
    target.add(len(points) - 1)
    for corner, place in zip(target, points):
        corner.co = place if kind == "BEZIER" else (*place, 1.0)
    thing = bpy.data.objects.new(name, data)
    home = bpy.data.collections.get(collection)
    if home is None:
        home = bpy.data.collections.new(collection)
        bpy.context.scene.collection.children.link(home)
    home.objects.link(thing)
    return thing


@pytest.mark.parametrize("kind", ["POLY", "BEZIER", "NURBS"])
def test_control_points_are_exported_in_world_space(export, kind):
    curve = _curve("Keyhole", [(0, 0, 0), (1, 0, 0), (1, 2, 0)], kind)
    curve.location = (0, 0, 3)
    curve.scale = (2, 1, 1)
    hint, = export().hints
    assert hint.name == "Keyhole"
    np.testing.assert_allclose(hint.points, [(0, 0, 3), (2, 0, 3), (2, 2, 3)], atol=1e-6)


def test_settings_of_a_curve_are_exported(export):
    curve = _curve("Keyhole", [(0, 0, 0), (1, 0, 0)])
    curve.ajar.hint_spread, curve.ajar.hint_weight, curve.ajar.hint_enabled = 0.2, 3.0, False
    hint, = export().hints
    assert (hint.spread, hint.weight, hint.enabled) == (pytest.approx(0.2), 3.0, False)


@pytest.mark.parametrize("kind", ["POLY", "BEZIER", "NURBS"])
def test_the_radius_of_a_point_scales_the_spread_of_the_segment_before_it(export, kind):
    curve = _curve("Keyhole", [(0, 0, 0), (1, 0, 0), (1, 2, 0), (3, 2, 0)], kind)
    curve.ajar.hint_spread = 0.2
    spline = curve.data.splines[0]
    points = spline.bezier_points if kind == "BEZIER" else spline.points
    points[1].radius, points[2].radius, points[3].radius = 0.5, 1.0, 100.0
    hint, = export().hints
    assert hint.spreads == pytest.approx([0.1, 0.2, np.pi])


def test_the_first_point_follows_its_lamp(build, export, scene):
    curve = _curve("Keyhole", [(0, 0, 3), (2, 0, 3), (2, 2, 3)])
    lamp = build.object(bpy.data.lights.new("Lamp", "POINT"), "Lamp")
    curve.ajar.hint_light, curve.ajar.hint_offset = lamp, (0, 0, -0.5)
    lamp.keyframe_insert("location", frame=1)
    lamp.location = (4, 0, 0)
    lamp.keyframe_insert("location", frame=2)
    for frame, place in ((1, (0, 0, -0.5)), (2, (4, 0, -0.5))):
        scene.frame_set(frame)
        hint, = export().hints
        np.testing.assert_allclose(hint.points[0], place, atol=1e-6)
        np.testing.assert_allclose(hint.points[1:], [(2, 0, 3), (2, 2, 3)], atol=1e-6)


def test_only_curves_of_the_chosen_collection_are_hints(export):
    _curve("Elsewhere", [(0, 0, 0), (1, 0, 0)], collection="Decoration")
    assert len(export().hints) == 0
    bpy.context.scene.ajar.hint_collection = "Decoration"
    assert [hint.name for hint in export().hints] == ["Elsewhere"]


def test_curves_hidden_from_renders_are_off_and_each_spline_is_a_path(export):
    curve = _curve("Two", [(0, 0, 0), (1, 0, 0)])
    second = curve.data.splines.new("POLY")
    second.points.add(2)
    hints = export().hints
    assert [(hint.name, len(hint.points)) for hint in hints] == [("Two, part 1", 2), ("Two, part 2", 3)]
    curve.hide_render = True
    assert not any(hint.enabled for hint in export().hints)
