"""Tests of the export of point clouds: objects of this type, and points that geometry nodes make."""

import bpy
import numpy as np
import pytest
from ajar_render.ajar_module import ajar


def group(*names: str) -> tuple[bpy.types.NodeTree, list[bpy.types.Node]]:
    """Geometry nodes in a chain that ends in the output of the group."""
    tree = bpy.data.node_groups.new("Points", "GeometryNodeTree")
    if hasattr(tree, "interface"):
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    nodes = [tree.nodes.new(name) for name in (*names, "NodeGroupOutput")]
    for here, there in zip(nodes, nodes[1:], strict=False):
        tree.links.new(here.outputs[0], there.inputs[0])
    return tree, nodes


@pytest.fixture
def cloud(build):
    """An object whose geometry nodes make four points on a line. The points, the stored attribute and the object."""
    tree, (points, attribute, _) = group("GeometryNodePoints", "GeometryNodeStoreNamedAttribute")
    points.inputs["Count"].default_value, points.inputs["Radius"].default_value = 4, 0.25
    index, place = tree.nodes.new("GeometryNodeInputIndex"), tree.nodes.new("ShaderNodeCombineXYZ")
    tree.links.new(index.outputs[0], place.inputs["X"])
    tree.links.new(place.outputs[0], points.inputs["Position"])
    attribute.data_type = "FLOAT"
    attribute.inputs["Name"].default_value = "heat"
    tree.links.new(index.outputs[0], next(socket for socket in attribute.inputs if socket.name == "Value" and socket.enabled))
    thing = build.object(bpy.data.meshes.new("Source"), "Source", (3, 2, 1))
    thing.modifiers.new("Points", "NODES").node_group = tree
    return tree, points, attribute, thing


def clouds_of(description: ajar.SceneDescription) -> list[ajar.MeshDescription]:
    return [mesh for mesh in description.meshes if len(mesh.radii) and not len(mesh.strands)]


def reading(build, name: str) -> bpy.types.Material:
    """A material that reads an attribute."""
    material = build.material()
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    attribute = nodes.new("ShaderNodeAttribute")
    attribute.attribute_name = name
    shader, output = nodes.new("ShaderNodeBsdfDiffuse"), next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
    links.new(attribute.outputs["Color"], shader.inputs["Color"])
    links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def assign(tree: bpy.types.NodeTree, material: bpy.types.Material) -> None:
    """Put a Set Material before the output."""
    out = next(node for node in tree.nodes if node.type == "GROUP_OUTPUT")
    before = out.inputs[0].links[0].from_socket
    node = tree.nodes.new("GeometryNodeSetMaterial")
    node.inputs["Material"].default_value = material
    tree.links.new(before, node.inputs[0])
    tree.links.new(node.outputs[0], out.inputs[0])


def test_points_of_geometry_nodes_are_a_point_cloud(cloud, export, build):
    tree, *_ = cloud
    assign(tree, reading(build, "heat"))
    description = export()
    mesh, = clouds_of(description)
    assert np.allclose(mesh.positions, [(x, 0, 0) for x in range(4)])
    assert np.allclose(mesh.radii, 0.25)
    heat, = mesh.attributes
    assert (heat.name, heat.domain) == ("heat", ajar.Domain.Vertex) and np.allclose(heat.values.reshape(-1), range(4))
    assert [material.name for material in description.materials] == [tree.nodes["Set Material"].inputs["Material"].default_value.name]
    shown, = description.instances
    assert np.allclose(np.array(shown.world_from_object).reshape(3, 4)[:, 3], (3, 2, 1))


def test_colors_that_a_material_reads_by_name_are_exported(cloud, export, build):
    tree, _points, attribute, _thing = cloud
    material = reading(build, "other")
    nodes = material.node_tree.nodes
    color = nodes.new("ShaderNodeVertexColor")
    color.layer_name = "heat"
    material.node_tree.links.new(color.outputs["Color"], next(node for node in nodes if node.type == "BSDF_DIFFUSE").inputs["Color"])
    attribute.data_type = "FLOAT_COLOR"
    assign(tree, material)
    mesh, = clouds_of(export())
    heat, = mesh.attributes
    assert heat.name == "heat" and np.array(heat.values).size == 4 * 4


def test_attributes_are_exported_only_if_a_material_reads_them(cloud, export):
    mesh, = clouds_of(export())
    assert not mesh.attributes


def test_points_without_a_radius_have_that_of_cycles(cloud, export):
    tree, _points, attribute, _thing = cloud
    out = next(node for node in tree.nodes if node.type == "GROUP_OUTPUT")
    remove = tree.nodes.new("GeometryNodeRemoveAttribute")
    remove.inputs["Name"].default_value = "radius"
    tree.links.new(attribute.outputs[0], remove.inputs[0])
    tree.links.new(remove.outputs[0], out.inputs[0])
    mesh, = clouds_of(export())
    assert np.allclose(mesh.radii, 0.01)


def test_an_empty_cloud_is_nothing(cloud, export):
    _tree, points, *_ = cloud
    points.inputs["Count"].default_value = 0
    assert not clouds_of(export())


def test_invalid_radii_are_reported_with_the_name_and_the_rest_renders(cloud, export, build):
    tree, points, *_ = cloud
    index = next(node for node in tree.nodes if node.bl_idname == "GeometryNodeInputIndex")
    root = tree.nodes.new("ShaderNodeMath")   # 0.3 - index: negative for all but the first point
    root.operation = "SUBTRACT"
    root.inputs[0].default_value = 0.3
    tree.links.new(index.outputs[0], root.inputs[1])
    tree.links.new(root.outputs[0], points.inputs["Radius"])
    mesh, = clouds_of(export())
    assert mesh.radii[0] == np.float32(0.3)   # Blender may change negative radii itself; the core leaves out what is left (test_points.cpp)


def test_instances_of_a_cloud_share_it(cloud, export):
    *_rest, thing = cloud
    collection = bpy.data.collections.new("Clouds")
    collection.objects.link(thing)
    bpy.context.scene.collection.objects.unlink(thing)
    for x in range(3):
        empty = bpy.data.objects.new(f"There {x}", None)
        empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", collection, (x, 0, 0)
        bpy.context.scene.collection.objects.link(empty)
    description = export()
    assert len(clouds_of(description)) == 1 and len(description.instances) == 3


def test_points_beside_a_mesh_in_one_geometry(cloud, export):
    """Both parts of the evaluated geometry are exported, each once."""
    tree, _points, attribute, _thing = cloud
    out = next(node for node in tree.nodes if node.type == "GROUP_OUTPUT")
    join, ball = tree.nodes.new("GeometryNodeJoinGeometry"), tree.nodes.new("GeometryNodeMeshUVSphere")
    for part in (attribute, ball):
        tree.links.new(part.outputs[0], join.inputs[0])
    tree.links.new(join.outputs[0], out.inputs[0])
    description = export()
    assert len(clouds_of(description)) == 1 and len(description.meshes) == 2


@pytest.mark.skipif(not hasattr(bpy.data, "pointclouds") or not hasattr(bpy.types.BlendDataPointClouds, "new"), reason="this Blender cannot make point clouds in Python")
def test_objects_of_this_type_are_point_clouds(build, export):
    data = bpy.data.pointclouds.new("Cloud")
    build.object(data, "Cloud")
    assert not export().meshes   # without points


def test_a_million_points_are_exported(cloud, export):
    _tree, points, *_ = cloud
    points.inputs["Count"].default_value = 1_000_000
    mesh, = clouds_of(export())
    assert len(mesh.positions) == 1_000_000 and mesh.positions[-1][0] == 999_999
