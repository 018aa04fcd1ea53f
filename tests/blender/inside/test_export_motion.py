"""Tests of motion blur: only objects that move while the shutter is open have keys."""

import bpy
import numpy as np
import pytest


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


def test_each_object_has_keys_for_its_own_steps(build, scene, export_blurred):
    quick, slow = build.object(build.mesh(), "Quick"), build.object(build.mesh(), "Slow")
    slide(quick)
    slide(slow)
    quick.cycles.motion_steps = 3
    context = export_blurred()
    assert keys_of(context) == {"Quick": 9, "Slow": 3}
    keys = np.array(context.description.motion_keys)[:, 3]
    expected = {9: np.linspace(0.75, 1.25, 9), 3: np.linspace(0.75, 1.25, 3)}
    np.testing.assert_allclose(np.sort(keys), np.sort(np.concatenate(list(expected.values()))), atol=1e-5)


def shapes_of(context, name):
    """[times, vertices, 3]: the shapes of a mesh while the shutter is open; None if it has only one."""
    mesh = next(mesh for mesh in context.description.meshes if mesh.name.startswith(name))
    return mesh.motion_positions.reshape(-1, *mesh.positions.shape) if len(mesh.motion_positions) else None


def grow(thing):
    """Moves vertex 2 by one unit per frame along x, by a shape key."""
    thing.shape_key_add(name="Basis")
    key = thing.shape_key_add(name="Grown")
    key.data[2].co.x += 10.0
    key.slider_max = 10.0
    for frame in (0, 10):
        key.value = frame / 10
        key.keyframe_insert("value", frame=frame)
    for point in thing.data.shape_keys.animation_data.action.fcurves[0].keyframe_points:
        point.interpolation = "LINEAR"


def test_shape_keys_deform(build, scene, export_blurred):
    thing = build.object(build.mesh(), "Jelly")
    grow(thing)
    context = export_blurred()
    shapes = shapes_of(context, thing.data.name)
    np.testing.assert_allclose(np.diff(shapes[:, 2, 0]), [0.25, 0.25], atol=1e-5)
    assert np.ptp(shapes[:, :2], axis=0).max() == 0.0
    assert context.warnings == []


def test_meshes_deform_only_if_their_object_asks_for_it(build, scene, export_blurred):
    thing = build.object(build.mesh(), "Jelly")
    grow(thing)
    thing.cycles.use_deform_motion = False
    assert shapes_of(export_blurred(), thing.data.name) is None
    thing.cycles.use_deform_motion, thing.cycles.use_motion_blur = True, False
    assert shapes_of(export_blurred(), thing.data.name) is None


def test_modifiers_and_armatures_deform_and_instances_of_them(build, scene, export_blurred):
    bones = bpy.data.objects.new("Bones", bpy.data.armatures.new("Bones"))
    scene.collection.objects.link(bones)
    bpy.context.view_layer.objects.active = bones
    bpy.ops.object.mode_set(mode="EDIT")
    bone = bones.data.edit_bones.new("Bone")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    pose = bones.pose.bones["Bone"]
    pose.rotation_mode = "XYZ"
    for frame, angle in ((0, 0.0), (2, 1.0)):
        pose.rotation_euler.z = angle
        pose.keyframe_insert("rotation_euler", index=2, frame=frame)
    skin = build.object(build.mesh(), "Skin")
    group = skin.vertex_groups.new(name="Bone")
    group.add([0, 1, 2], 1.0, "REPLACE")
    skin.modifiers.new("Armature", "ARMATURE").object = bones
    collection = bpy.data.collections.new("Shown")
    collection.objects.link(skin)
    scene.collection.objects.unlink(skin)
    empty = build.object(None, "There")
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    context = export_blurred()
    shapes = shapes_of(context, skin.data.name)
    assert shapes.shape[0] == 3 and np.ptp(shapes, axis=0).max() > 0.1
    assert keys_of(context)["Skin"] == 0


def test_meshes_of_other_topology_keep_the_shape_of_the_frame_and_are_reported(build, scene, export_blurred):
    thing = build.object(build.mesh(), "Builder")
    modifier = thing.modifiers.new("Array", "ARRAY")
    modifier.count = 2
    for frame, count in ((0, 1), (2, 9)):
        modifier.count = count
        modifier.keyframe_insert("count", frame=frame)
    scene.frame_set(1)
    context = export_blurred()
    assert shapes_of(context, thing.data.name) is None
    assert [name for name, message in context.warnings if "number of its vertices" in message] == ["Builder"]


def test_vertices_with_a_velocity_move_straight(build, scene, export_blurred):
    thing = build.object(build.mesh(), "Water")
    modifier = thing.modifiers.new("Array", "ARRAY")   # its vertices change
    for frame, count in ((0, 1), (2, 9)):
        modifier.count = count
        modifier.keyframe_insert("count", frame=frame)
    velocity = thing.data.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
    for item in velocity.data:
        item.vector = (0.0, 24.0, 0.0)
    scene.render.fps, scene.render.fps_base = 24, 1.0
    context = export_blurred()
    shapes = shapes_of(context, thing.data.name)
    np.testing.assert_allclose(np.diff(shapes[:, :, 1], axis=0), 0.25, atol=1e-5)
    assert context.warnings == []


def test_hair_and_points_deform(build, scene, export_blurred):
    # Curves, through geometry nodes that move their points with time.
    tree = bpy.data.node_groups.new("Blow", "GeometryNodeTree")
    if hasattr(tree, "interface"):
        tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    nodes, links = tree.nodes, tree.links
    entry, leave = nodes.new("NodeGroupInput"), nodes.new("NodeGroupOutput")
    move, vector, time, cloud = (nodes.new(kind) for kind in ("GeometryNodeSetPosition", "ShaderNodeCombineXYZ", "GeometryNodeInputSceneTime", "GeometryNodeMeshToPoints"))
    links.new(time.outputs["Frame"], vector.inputs["X"])
    links.new(entry.outputs[0], cloud.inputs[0])
    links.new(cloud.outputs[0], move.inputs["Geometry"])
    links.new(vector.outputs[0], move.inputs["Offset"])
    links.new(move.outputs[0], leave.inputs[0])
    thing = build.object(build.mesh(), "Cloud")
    thing.modifiers.new("Blow", "NODES").node_group = tree
    context = export_blurred()
    shapes = shapes_of(context, "Cloud")
    np.testing.assert_allclose(np.diff(shapes[:, :, 0], axis=0), 0.25, atol=1e-5)


def test_cameras_zoom(scene, export_blurred):
    camera = scene.camera.data
    for frame, lens in ((0, 50.0), (2, 25.0)):
        camera.lens = lens
        camera.keyframe_insert("lens", frame=frame)
    scene.frame_set(1)
    out = export_blurred().description.camera
    assert len(out.window_motion) == 3 and out.motion == []
    widths = [right - left for left, right, _, _ in out.window_motion]
    assert widths[0] < widths[1] < widths[2]
    assert widths[1] == pytest.approx(out.screen_window[1] - out.screen_window[0], rel=1e-5)


def test_rolling_shutters_expose_rows_one_after_another(build, scene, export_blurred):
    scene.cycles.rolling_shutter_type, scene.cycles.rolling_shutter_duration = "TOP", 0.25
    mover = build.object(build.mesh(), "Mover")
    assert export_blurred().description.camera.row_exposure == 1.0   # nothing moves
    slide(mover)
    assert export_blurred().description.camera.row_exposure == 0.25
