"""Tests of the export of objects: shared meshes, instances, materials of slots, visibility and cancellation."""

import sys

import bpy
import numpy as np
import pytest
from ajar_render.ajar_module import ajar
from ajar_render.export import ExportCancelled, objects
from ajar_render.export.context import ExportContext


def test_objects_of_one_mesh_share_it(build, export):
    mesh = build.mesh()
    for x in range(3):
        build.object(mesh, f"Object {x}", (x, 0, 0))
    out = export()
    assert len(out.meshes) == 1
    assert sorted(i.world_from_object[3] for i in out.instances) == [0, 1, 2]


def test_modified_object_has_its_own_mesh(build, export):
    mesh = build.mesh()
    build.object(mesh, "Plain")
    build.object(mesh, "Solid").modifiers.new("Solidify", "SOLIDIFY")
    assert sorted(len(m.triangles) for m in export().meshes) == [2, 12]


def test_matrix_has_the_rows_of_world_from_object(build, export):
    thing = build.object(build.mesh(), location=(1, 2, 3))
    thing.scale = (-2, 1, 0)
    thing.rotation_euler.z = 0.5
    out = export()
    matrix = np.array(thing.matrix_world)[:3]
    np.testing.assert_allclose(np.reshape(out.instances[0].world_from_object, (3, 4)), matrix, atol=1e-6)


def test_collection_instances_share_the_mesh(build, export, scene):
    collection = bpy.data.collections.new("Pair")
    mesh = build.mesh()
    for x in range(2):
        thing = bpy.data.objects.new("Member", mesh)
        thing.location.x = x
        collection.objects.link(thing)
    for y in range(3):
        empty = build.object(None, "Instance", (0, y, 0))
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
    out = export()
    assert len(out.meshes) == 1 and len(out.instances) == 6
    places = sorted((i.world_from_object[3], i.world_from_object[7]) for i in out.instances)
    assert places == [(x, y) for x in range(2) for y in range(3)]


def test_setting_hides_the_instancer_of_instances_on_vertices(build, export):
    parent = build.object(build.mesh("Ground"), "Ground")
    child = build.object(build.mesh("Leaf", ((0, 0, 0), (1, 0, 0), (0, 1, 0)), ((0, 1, 2),)), "Leaf")
    child.parent = parent
    parent.instance_type = "VERTS"
    parent.show_instancer_for_viewport = parent.show_instancer_for_render = False
    out = export()
    names = [out.objects[i.object].name for i in out.instances]
    assert names == ["Leaf"] * 5  # unlike a render, the viewport also shows the child at its own position
    assert len({i.random for i in out.instances}) == 5
    assert all(0.0 <= i.random <= 1.0 for i in out.instances)


def test_random_value_of_an_object_is_that_of_cycles(build, export):
    """The expected values of Object Info > Random were rendered by Cycles of Blender 3.4.1 for these names."""
    expected = {"Cube": 0.313141942, "Suzanne.001": 0.457976639, "Bäume": 0.407352567}
    for name in expected:
        build.object(build.mesh(), name)
    out = export()
    assert {out.objects[i.object].name: i.random for i in out.instances} == pytest.approx(expected, abs=1e-7)


def test_particles_become_instances(build, export):
    leaf = build.object(build.mesh("Leaf", ((0, 0, 0), (1, 0, 0), (0, 1, 0)), ((0, 1, 2),)), "Leaf")
    ground = build.object(build.mesh("Ground"), "Ground")
    settings = ground.modifiers.new("Particles", "PARTICLE_SYSTEM").particle_system.settings
    settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 20, 0, 1, 1000
    settings.physics_type, settings.render_type, settings.instance_object = "NO", "OBJECT", leaf
    bpy.context.scene.frame_set(5)
    out = export()
    names = [out.objects[i.object].name for i in out.instances]
    assert names.count("Leaf") == 21 and names.count("Ground") == 1
    assert len(out.meshes) == 2


def geometry_nodes(thing):
    tree = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
    if bpy.app.version >= (4, 0):
        tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    thing.modifiers.new("Nodes", "NODES").node_group = tree
    return tree, tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")


def test_geometry_nodes_instances_of_bare_meshes(build, export):
    material = build.material("Set by nodes")
    thing = build.object(build.mesh(), "Scatter")
    tree, inside, outside = geometry_nodes(thing)
    cube, place, paint = (tree.nodes.new(f"GeometryNode{name}") for name in ("MeshCube", "InstanceOnPoints", "SetMaterial"))
    paint.inputs["Material"].default_value = material
    tree.links.new(cube.outputs[0], paint.inputs["Geometry"])
    tree.links.new(paint.outputs[0], place.inputs["Instance"])
    tree.links.new(inside.outputs[0], place.inputs["Points"])
    tree.links.new(place.outputs[0], outside.inputs[0])
    out = export()
    assert len(out.instances) == 4 and len(out.meshes) == 1
    assert len(out.meshes[0].triangles) == 12
    slots = out.objects[out.instances[0].object].materials
    assert slots
    assert [out.materials[slot].name for slot in slots] == ["Set by nodes"] * len(slots)


def test_slot_of_the_object_replaces_that_of_the_mesh_and_empty_slots_are_grey(build, export):
    mesh = build.mesh()
    mesh.materials.append(build.material("Of mesh"))
    mesh.materials.append(None)
    build.object(mesh, "First")
    second = build.object(mesh, "Second")
    second.material_slots[0].link = "OBJECT"
    second.material_slots[0].material = build.material("Of object")
    out = export()
    names = {o.name: [out.materials[i].name if i >= 0 else None for i in o.materials] for o in out.objects}
    assert names == {"First": ["Of mesh", None], "Second": ["Of object", None]}
    assert len(out.meshes) == 1


def test_object_without_material_has_no_slots(build, export):
    build.object(build.mesh())
    assert export().objects[0].materials == []


@pytest.mark.parametrize("kind, bit", [("camera", ajar.VISIBLE_CAMERA), ("diffuse", ajar.VISIBLE_DIFFUSE), ("shadow", ajar.VISIBLE_SHADOW)])
def test_ray_visibility(build, export, kind, bit):
    setattr(build.object(build.mesh()), f"visible_{kind}", False)
    assert export().objects[0].visibility == ajar.VISIBLE_ALL & ~bit


def test_instance_is_visible_only_to_rays_that_see_its_instancer(build, export):
    collection = bpy.data.collections.new("One")
    thing = bpy.data.objects.new("Member", build.mesh())
    thing.visible_glossy = False
    collection.objects.link(thing)
    for name, visible in (("Seen", True), ("Unseen", False)):
        empty = build.object(None, name)
        empty.instance_type, empty.instance_collection, empty.visible_camera = "COLLECTION", collection, visible
    out = export()
    masks = sorted(o.visibility for o in out.objects)
    no_glossy = ajar.VISIBLE_ALL & ~ajar.VISIBLE_GLOSSY
    assert masks == sorted([no_glossy, no_glossy & ~ajar.VISIBLE_CAMERA])


def test_instance_has_the_colour_and_the_shadow_catcher_of_its_instancer(build, export):
    """As in Cycles (measured in 3.4.1, 4.2.23 and 5.2.3)."""
    collection = bpy.data.collections.new("One")
    thing = bpy.data.objects.new("Member", build.mesh())
    thing.color, thing.pass_index = (0.8, 0.1, 0.1, 1.0), 1
    collection.objects.link(thing)
    for name, color, catches in (("Green", (0.1, 0.8, 0.1, 1.0), False), ("Blue", (0.1, 0.1, 0.8, 1.0), True)):
        empty = build.object(None, name)
        empty.instance_type, empty.instance_collection, empty.color, empty.is_shadow_catcher = "COLLECTION", collection, color, catches
        empty.pass_index = 2
    found = sorted((tuple(round(number, 3) for number in o.color), o.shadow_catcher, o.pass_index) for o in export().objects)
    assert found == [((0.1, 0.1, 0.8, 1.0), True, 1), ((0.1, 0.8, 0.1, 1.0), False, 1)]


def test_instances_of_particles_have_the_colour_of_the_emitter(build, export):
    thing = build.object(build.mesh(), location=(5.0, 0.0, 0.0))
    thing.color = (0.8, 0.1, 0.1, 1.0)
    emitter = build.object(build.mesh(), "Emitter")
    emitter.color = (0.1, 0.8, 0.1, 1.0)
    system = emitter.modifiers.new("Particles", "PARTICLE_SYSTEM").particle_system.settings
    system.type, system.count, system.render_type, system.instance_object = "HAIR", 5, "OBJECT", thing
    emitter.show_instancer_for_render = emitter.show_instancer_for_viewport = False
    out = export()
    count = {}
    for instance in out.instances:
        color = tuple(round(number, 3) for number in out.objects[instance.object].color)
        count[color] = count.get(color, 0) + 1
    assert count == {(0.8, 0.1, 0.1, 1.0): 1, (0.1, 0.8, 0.1, 1.0): 5}


@pytest.mark.parametrize("own, found", [("", "Keys"), ("Fills", "Fills")])
def test_instance_without_a_light_group_has_that_of_its_instancer(build, export, scene, own, found):
    for name in ("Keys", "Fills"):
        scene.view_layers[0].lightgroups.add(name=name)
    collection = bpy.data.collections.new("One")
    for thing in (bpy.data.objects.new("Member", build.mesh()), bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))):
        thing.lightgroup = own
        collection.objects.link(thing)
    empty = build.object(None, "Instancer")
    empty.instance_type, empty.instance_collection, empty.lightgroup = "COLLECTION", collection, "Keys"
    out = export()
    assert [o.light_group for o in out.objects] == [found]
    assert [light.light_group for light in out.lights] == [found]


def test_cancel_ends_the_export(build, export_context):
    build.object(build.mesh())
    with pytest.raises(ExportCancelled):
        export_context(is_cancelled=lambda: True)


def test_hidden_objects_are_not_exported(build, export):
    build.object(build.mesh(), "Hidden").hide_viewport = True
    assert not export().objects


def test_instances_need_no_python_object_each(build):
    """Only arrays of numbers grow with the number of instances."""
    side = 300
    parent = build.object(build.mesh("Points", [(x, y, 0) for x in range(side) for y in range(side)], ()))
    build.object(build.mesh("Leaf"), "Leaf").parent = parent
    parent.instance_type = "VERTS"
    depsgraph = bpy.context.evaluated_depsgraph_get()
    depsgraph.update()
    context, collected = ExportContext(depsgraph, lambda: False, lambda step: None), objects.Collected()
    before = sys.getallocatedblocks()
    objects._collect(context, collected)
    blocks = sys.getallocatedblocks() - before
    assert len(collected.geometry_of) > side * side
    assert blocks < 1000
