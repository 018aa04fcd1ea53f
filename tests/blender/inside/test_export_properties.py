"""Tests of the properties that Attribute nodes read from objects, instancers and the view layer, and of those that the Geometry node reads from meshes."""

import bpy
import numpy as np
import pytest
from ajar_render.ajar_module import ajar


@pytest.fixture
def asking(build):
    """A function that creates a material with the sum of these node outputs: (type, output, settings)."""

    def make(*shown):
        material = build.material()
        nodes, links = material.node_tree.nodes, material.node_tree.links
        end = nodes["Material Output"].inputs["Surface"]
        for kind, output, settings in shown:
            emission, add, node = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeAddShader"), nodes.new(kind)
            for name, content in settings.items():
                setattr(node, name, content)
            links.new(node.outputs[output], emission.inputs["Strength"])
            links.new(emission.outputs[0], add.inputs[0])
            links.new(add.outputs[0], end)
            end = add.inputs[1]
        return material
    return make


def attribute(type_, name):
    return "ShaderNodeAttribute", "Fac", {"attribute_type": type_, "attribute_name": name}


def of(description, name):
    return {(key, of_instancer): tuple(round(number, 5) for number in value)
            for thing in description.objects if thing.name == name for key, of_instancer, value, _ in thing.properties}


# The values that Cycles of Blender 3.4.1 rendered; None: black with an alpha of 0.
FOUND = {
    "number": (0.5, 0.5, 0.5, 1), "whole": (7, 7, 7, 1), "three": (0.1, 0.2, 0.3, 1), "four": (0.1, 0.2, 0.3, 0.4), "two": (1, 2, 0, 1),
    '["number"]': (0.5, 0.5, 0.5, 1), "text": None, "five": None, "nowhere": None, "": None,
    "color": (0.2, 0.4, 0.6, 0.8), "pass_index": (5, 5, 5, 1), "location": (9, 8, 7, 1), "delta_scale": (1, 1, 1, 1), "hide_render": (0, 0, 0, 1),
    "scale[1]": None, "name": None, "matrix_world": None, "rotation_mode": None, "modifiers": None, "data": None,
    "of mesh": (2.5, 2.5, 2.5, 1), "both": (1.5, 1.5, 1.5, 1), "material_slots[0].material.pass_index": (3, 3, 3, 1),
}


def test_properties_of_objects(build, export, asking):
    mesh = build.mesh()
    mesh.materials.append(asking(*(attribute("OBJECT", name) for name in FOUND)))
    mesh.materials[0].pass_index = 3
    mesh["of mesh"], mesh["both"] = 2.5, 7.5
    thing = build.object(mesh, "Thing", location=(1, 2, 3))
    thing.color, thing.pass_index = (0.2, 0.4, 0.6, 0.8), 5
    thing["number"], thing["whole"], thing["three"], thing["four"] = 0.5, 7, [0.1, 0.2, 0.3], [0.1, 0.2, 0.3, 0.4]
    thing["two"], thing["text"], thing["five"], thing["both"] = [1, 2], "text", [0.1] * 5, 1.5
    thing["location"] = [9.0, 8.0, 7.0]     # has precedence over Blender's property
    found = of(export(), "Thing")
    assert {name: found.get((name, False)) for name in FOUND} == FOUND
    assert set(found) == {(name, False) for name, value in FOUND.items() if value}


def test_properties_that_no_material_reads_are_not_exported(build, export, asking):
    mesh = build.mesh()
    mesh.materials.append(asking(attribute("GEOMETRY", "color")))
    build.object(mesh, "Thing")["color"] = 1.0
    assert of(export(), "Thing") == {}


def shown_by_empty(name, collection, **properties):
    empty = bpy.data.objects.new(name, None)
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    for key, value in properties.items():
        empty[key] = value
    bpy.context.scene.collection.objects.link(empty)
    return empty


def test_properties_of_instancers_have_precedence_over_those_of_the_object(build, export, asking):
    mesh = build.mesh()
    mesh.materials.append(asking(attribute("INSTANCER", "tint"), attribute("INSTANCER", "size"), attribute("OBJECT", "tint")))
    hidden, thing = bpy.data.collections.new("Hidden"), bpy.data.objects.new("Thing", mesh)
    hidden.objects.link(thing)
    thing["tint"], thing["size"] = 1.0, 4.0
    shown_by_empty("A", hidden, tint=2.0)
    shown_by_empty("B", hidden, tint=3.0, size=5.0)
    shown_by_empty("C", hidden, tint=2.0)
    shown_by_empty("D", hidden)
    build.object(mesh, "Alone")["tint"] = 6.0
    out = export()
    values = [(out.objects[i.object].name, {(key, of_instancer): value[0] for key, of_instancer, value, _ in out.objects[i.object].properties})
              for i in out.instances]
    things = [found for name, found in values if name == "Thing"]
    assert all(found[("tint", False)] == 1.0 for found in things)
    assert sorted((found[("tint", True)], found[("size", True)]) for found in things) == [(1, 4), (2, 4), (2, 4), (3, 5)]
    assert [found for name, found in values if name == "Alone"] == [{("tint", False): 6.0, ("tint", True): 6.0}]
    assert len(out.meshes) == 1 and len([o for o in out.objects if o.name == "Thing"]) == 3   # A and C are equal


def test_properties_of_particle_settings_have_precedence_over_those_of_their_object(build, export, asking):
    leaf_mesh = build.mesh("Leaf", ((0, 0, 0), (1, 0, 0), (0, 1, 0)), ((0, 1, 2),))
    leaf_mesh.materials.append(asking(attribute("INSTANCER", "tint"), attribute("INSTANCER", "size")))
    leaf = build.object(leaf_mesh, "Leaf")
    ground = build.object(build.mesh("Ground"), "Ground")
    settings = ground.modifiers.new("Particles", "PARTICLE_SYSTEM").particle_system.settings
    settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 5, 0, 1, 1000
    settings.physics_type, settings.render_type, settings.instance_object = "NO", "OBJECT", leaf
    settings["tint"], ground["tint"], ground["size"] = 8.0, 9.0, 10.0
    bpy.context.scene.frame_set(5)
    out = export()
    found = [{key: value[0] for key, _, value, _ in out.objects[i.object].properties} for i in out.instances if out.objects[i.object].name == "Leaf"]
    assert sorted(map(str, found)) == sorted(map(str, [{}, *[{"size": 10.0, "tint": 8.0}] * 5]))


def test_properties_of_the_view_layer_the_scene_and_the_world(build, graph_of, asking):
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (0.3, 0.2, 0.1)
    scene["f"], scene["of scene"], scene.view_layers[0]["f"], scene.world["of scene"] = 0.25, 3.5, 0.75, 99.0
    expected = {"f": (0.75, 0.75, 0.75, 1), "of scene": (3.5, 3.5, 3.5, 1), "color": (0.3, 0.2, 0.1, 1), "gravity": (0, 0, -9.81, 1),
                "use_gravity": (1, 1, 1, 1), "frame_current": (1, 1, 1, 1), "nowhere": (0, 0, 0, 0), "name": (0, 0, 0, 0)}
    graph = graph_of(asking(*(attribute("VIEW_LAYER", name) for name in expected)))
    found = {}
    for node in graph.nodes:
        if node.type == "ShaderNodeAttribute":
            properties = {p.name: p for p in node.properties}
            found[properties["attribute_name"].text] = tuple(round(number, 5) for number in properties["value"].numbers)
    assert found == expected


def test_instance_attributes_of_geometry_nodes_are_reported_where_python_cannot_read_them(build, export_context, asking):
    mesh = build.mesh("Leaf")
    mesh.materials.append(asking(attribute("INSTANCER", "tint")))
    leaf, scatter = build.object(mesh, "Leaf"), build.object(build.mesh(), "Scatter")
    tree = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
    if bpy.app.version >= (4, 0):
        tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    scatter.modifiers.new("Nodes", "NODES").node_group = tree
    inside, outside, place, info = (tree.nodes.new(name) for name in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeInstanceOnPoints", "GeometryNodeObjectInfo"))
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = leaf, True
    tree.links.new(info.outputs["Geometry"], place.inputs["Instance"])
    tree.links.new(inside.outputs[0], place.inputs["Points"])
    tree.links.new(place.outputs[0], outside.inputs[0])
    if hasattr(bpy.types.Object, "evaluated_geometry"):   # tests/compatibility/instances_inside.py compares the values
        return
    context = export_context()
    assert [name for name, message in context.warnings if '"tint", it cannot be read' in message] == ["Scatter"]
    scatter["tint"] = 1.0
    scatter.update_tag()
    assert not [message for _, message in export_context().warnings if "cannot be read" in message]


def test_islands_and_pointiness(build, export, asking):
    mesh = build.mesh("Two", ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (3, 0, 0), (3, 1, 1)), ((0, 1, 2, 3), (4, 5, 6)))
    mesh.materials.append(asking(("ShaderNodeNewGeometry", "Random Per Island", {}), ("ShaderNodeNewGeometry", "Pointiness", {})))
    build.object(mesh)
    found = {a.name: a for a in export().meshes[0].attributes}
    island, pointiness = found[ajar.RANDOM_PER_ISLAND], found[ajar.POINTINESS]
    assert (island.domain, pointiness.domain) == (ajar.Domain.Face, ajar.Domain.Vertex)
    random = np.ravel(island.values)
    assert len(random) == 3 and random[0] == random[1] != random[2]
    np.testing.assert_allclose(np.ravel(pointiness.values), 0.5, atol=1e-6)


def test_meshes_are_analysed_only_for_materials_that_need_it(build, export, asking):
    mesh = build.mesh()
    mesh.materials.append(asking(("ShaderNodeNewGeometry", "Backfacing", {})))
    build.object(mesh)
    assert export().meshes[0].attributes == []


def test_plain_settings_are_equal_to_those_of_blender():
    """Threads read settings without Blender's getters. The values are the same, whether inherited from Cycles or set in Ajar."""
    from ajar_render import plain
    scene = bpy.context.scene
    thing = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "AREA"))
    groups = [scene.ajar, thing.ajar, thing.data.ajar, bpy.data.worlds.new("world").ajar, bpy.data.cameras.new("camera").ajar, bpy.data.materials.new("material").ajar,
              scene.view_layers[0].ajar]

    def differences() -> list[str]:
        return [f"{type(group).__name__}.{name}" for group in groups for name in type(group).__annotations__
                if name not in ("light_groups", "hint_points") and not isinstance(getattr(group, name), bpy.types.bpy_struct) and not same(getattr(plain.of(group), name), getattr(group, name))]

    def same(ours, blenders) -> bool:
        if isinstance(blenders, float):
            return ours == pytest.approx(blenders, rel=1e-6)
        return list(ours) == list(blenders) if hasattr(blenders, "__len__") and not isinstance(blenders, str) else (ours == blenders and type(ours) is type(blenders))

    assert differences() == []
    scene.cycles.samples, scene.cycles.pixel_filter_type, scene.cycles.caustics_reflective, scene.cycles.sample_clamp_indirect = 7, "GAUSSIAN", False, 0.3
    thing.data.cycles.is_portal, thing.cycles.motion_steps = True, 3
    assert differences() == [] and plain.of(scene.ajar).filter == "GAUSSIAN" and plain.of(thing.data.ajar).is_portal is True
    scene.ajar.filter, scene.ajar.samples = "BOX", 9
    assert differences() == [] and plain.of(scene.ajar).filter == "BOX" and plain.of(scene.ajar).samples == 9
