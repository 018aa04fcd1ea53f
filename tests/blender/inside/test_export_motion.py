"""Tests of motion blur: only objects that move while the shutter is open have keys."""

import bpy
import numpy as np
import pytest
from ajar_render.export import export_scene
from ajar_render.headless import Options


@pytest.fixture
def export_blurred(scene):
    def run():
        scene.render.use_motion_blur = True
        depsgraph = bpy.context.evaluated_depsgraph_get()
        depsgraph.update()
        return export_scene(depsgraph, Options(), ["Combined"], depsgraph.scene_eval.camera, lambda: False, lambda step: None,
                            lambda frame, subframe: scene.frame_set(frame, subframe=subframe))
    return run


def slide(thing, path="location", index=0):
    """Animates a property with a speed of one unit per frame; it is 0 at frame 0."""
    for frame in (-10, 20):
        value = getattr(thing, path)
        value[index] = frame
        setattr(thing, path, value)
        thing.keyframe_insert(path, index=index, frame=frame)
    for point in thing.animation_data.action.fcurves[0].keyframe_points:
        point.interpolation = "LINEAR"


def keys_of(context):
    return {context.description.objects[instance.object].name: instance.motion_key_count for instance in context.description.instances}


@pytest.mark.parametrize("position, first", [("START", 5.0), ("CENTER", 4.75), ("END", 4.5)])
def test_keys_of_objects_cover_the_time_of_the_open_shutter(build, scene, export_blurred, position, first):
    mover = build.object(build.mesh(), "Mover")
    build.object(build.mesh(), "Still")
    slide(mover)
    scene.frame_set(5)
    scene.cycles.motion_blur_position = position
    context = export_blurred()
    assert keys_of(context) == {"Mover": 3, "Still": 0}
    rows = np.array(context.description.motion_keys)
    np.testing.assert_allclose(rows[:, 3], [first, first + 0.25, first + 0.5], atol=1e-5)
    assert (scene.frame_current, scene.frame_subframe) == (5, 0.0)
    assert context.description.camera.motion == [] and context.description.camera.shutter == []


def test_no_object_has_keys_without_motion_blur(build, scene, export_context):
    slide(build.object(build.mesh(), "Mover"))
    assert keys_of(export_context()) == {"Mover": 0}


def test_motion_settings_of_objects_are_those_of_cycles(build, scene, export_blurred):
    mover, stubborn = build.object(build.mesh(), "Mover"), build.object(build.mesh(), "Stubborn")
    slide(mover)
    slide(stubborn)
    mover.cycles.motion_steps = 3
    stubborn.cycles.use_motion_blur = False
    assert keys_of(export_blurred()) == {"Mover": 9, "Stubborn": 0}


def test_cameras_have_keys_and_shutters_have_curves(scene, export_blurred):
    slide(scene.camera)
    curve = scene.render.motion_blur_shutter_curve.curves[0]
    curve.points[0].location, curve.points[1].location = (0.0, 0.0), (1.0, 1.0)
    for point in curve.points:
        point.handle_type = "VECTOR"
    scene.render.motion_blur_shutter_curve.update()
    camera = export_blurred().description.camera
    np.testing.assert_allclose(np.array(camera.motion)[:, 3], [0.75, 1.0, 1.25], atol=1e-5)
    # The transmission of the shutter is proportional to time: half of the light has arrived at sqrt(1/2).
    assert camera.shutter[len(camera.shutter) // 2] == pytest.approx(0.5**0.5, abs=0.01)


def test_instances_are_matched_between_times(build, scene, export_blurred):
    collection = bpy.data.collections.new("Leaves")
    collection.objects.link(bpy.data.objects.new("Leaf", build.mesh()))
    for name in ("Tree", "Rock"):
        empty = build.object(None, name)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        if name == "Tree":
            slide(empty, index=1)
    context = export_blurred()
    assert sorted(instance.motion_key_count for instance in context.description.instances) == [0, 3]
    np.testing.assert_allclose(np.array(context.description.motion_keys)[:, 7], [0.75, 1.0, 1.25], atol=1e-5)


def test_deforming_meshes_are_reported(build, scene, export_blurred):
    thing = build.object(build.mesh(), "Jelly")
    thing.shape_key_add(name="Basis")
    key = thing.shape_key_add(name="Grown")
    key.data[2].co = (5, 5, 0)
    for frame in (0, 10):
        key.value = frame / 10
        key.keyframe_insert("value", frame=frame)
    context = export_blurred()
    assert [name for name, message in context.warnings if "deforms" in message] == ["Jelly"]
