"""Tests of the export of node graphs: links after groups, reroutes and muted nodes are resolved; images; special values."""

import bpy
import numpy as np
import pytest
from ajar_render.ajar_module import ajar
from ajar_render.export import node_graph


@pytest.fixture
def shader(build):
    """A material with an emission node linked to its output."""
    material = build.material()
    nodes, links = material.node_tree.nodes, material.node_tree.links
    emission = nodes.new("ShaderNodeEmission")
    links.new(emission.outputs[0], nodes["Material Output"].inputs["Surface"])

    class Shader:
        pass
    shader = Shader()
    shader.material, shader.nodes, shader.links, shader.emission = material, nodes, links, emission
    return shader


def value(graph, node, socket):
    return next(i for i in graph.nodes[node].inputs if i.socket == socket).value


def source(graph, node, socket):
    link = next(i for i in graph.nodes[node].inputs if i.socket == socket).link
    return (graph.nodes[link.node].type, link.socket) if link.node >= 0 else None


def property_of(graph, node, name):
    return next(p for p in graph.nodes[node].properties if p.name == name)


def node_of(graph, type_):
    return next(i for i, node in enumerate(graph.nodes) if node.type == type_)


def float_group(name="Group"):
    """A group with one Math node (addition) between a Value input and a Value output."""
    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    if bpy.app.version >= (4, 0):
        tree.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketFloat")
        tree.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketFloat")
    else:
        tree.inputs.new("NodeSocketFloat", "In")
        tree.outputs.new("NodeSocketFloat", "Out")
    inside, outside, math = (tree.nodes.new(t) for t in ("NodeGroupInput", "NodeGroupOutput", "ShaderNodeMath"))
    tree.links.new(inside.outputs[0], math.inputs[0])
    tree.links.new(math.outputs[0], outside.inputs[0])
    return tree


def test_surface_is_the_node_linked_to_the_output(shader, graph_of):
    shader.emission.inputs["Strength"].default_value = 3.0
    graph = graph_of(shader.material)
    assert len(graph.nodes) == 1
    assert (graph.surface.node, graph.surface.socket) == (0, "Emission")
    assert value(graph, 0, "Strength")[0] == 3.0


def test_unused_nodes_are_not_exported(shader, graph_of):
    shader.nodes.new("ShaderNodeTexNoise")
    assert len(graph_of(shader.material).nodes) == 1


def test_reroutes_are_removed(shader, graph_of):
    number = shader.nodes.new("ShaderNodeValue")
    number.outputs[0].default_value = 0.25
    first, second = shader.nodes.new("NodeReroute"), shader.nodes.new("NodeReroute")
    shader.links.new(number.outputs[0], first.inputs[0])
    shader.links.new(first.outputs[0], second.inputs[0])
    shader.links.new(second.outputs[0], shader.emission.inputs["Strength"])
    graph = graph_of(shader.material)
    assert source(graph, 0, "Strength") == ("ShaderNodeValue", "Value")
    assert property_of(graph, 1, "value").numbers == [0.25]


def test_reroute_without_input_is_zero(shader, graph_of):
    reroute = shader.nodes.new("NodeReroute")
    shader.links.new(reroute.outputs[0], shader.emission.inputs["Color"])
    graph = graph_of(shader.material)
    assert source(graph, 0, "Color") is None


def test_groups_are_flattened_and_each_use_has_its_own_nodes(shader, graph_of):
    tree = float_group()
    add = shader.nodes.new("ShaderNodeMath")
    for i, number in enumerate((2.0, 5.0)):
        use = shader.nodes.new("ShaderNodeGroup")
        use.node_tree = tree
        use.name = f"Use {i}"
        use.inputs[0].default_value = number
        shader.links.new(use.outputs[0], add.inputs[i])
    shader.links.new(add.outputs[0], shader.emission.inputs["Strength"])
    graph = graph_of(shader.material)
    assert sorted(node.name for node in graph.nodes if node.type == "ShaderNodeMath") == ["Math", "Use 0/Math", "Use 1/Math"]
    numbers = {node.name: value(graph, i, node.inputs[0].socket)[0] for i, node in enumerate(graph.nodes) if "/" in node.name}
    assert numbers == {"Use 0/Math": 2.0, "Use 1/Math": 5.0}


def test_link_into_a_nested_group_is_resolved(shader, graph_of):
    inner = float_group("Inner")
    outer = float_group("Outer")
    math = next(node for node in outer.nodes if node.type == "MATH")
    use = outer.nodes.new("ShaderNodeGroup")
    use.node_tree = inner
    outer.links.new(math.outputs[0], use.inputs[0])
    outer.links.new(use.outputs[0], next(node for node in outer.nodes if node.bl_idname == "NodeGroupOutput").inputs[0])
    top = shader.nodes.new("ShaderNodeGroup")
    top.node_tree = outer
    number = shader.nodes.new("ShaderNodeValue")
    shader.links.new(number.outputs[0], top.inputs[0])
    shader.links.new(top.outputs[0], shader.emission.inputs["Strength"])
    graph = graph_of(shader.material)
    assert sorted(node.name for node in graph.nodes) == ["Emission", "Group/Group/Math", "Group/Math", "Value"]
    assert source(graph, node_of(graph, "ShaderNodeEmission"), "Strength")[0] == "ShaderNodeMath"


def test_group_without_a_tree_is_zero_and_reported(shader, build, export_context):
    use = shader.nodes.new("ShaderNodeGroup")
    tree = float_group()
    use.node_tree = tree
    shader.links.new(use.outputs[0], shader.emission.inputs["Strength"])
    bpy.data.node_groups.remove(tree)
    mesh = build.mesh()
    mesh.materials.append(shader.material)
    build.object(mesh)
    graph = export_context().description.materials[0].graph
    assert source(graph, 0, "Strength") is None


def test_muted_node_is_replaced_by_its_internal_link(shader, graph_of):
    math, number = shader.nodes.new("ShaderNodeMath"), shader.nodes.new("ShaderNodeValue")
    shader.links.new(number.outputs[0], math.inputs[0])
    shader.links.new(math.outputs[0], shader.emission.inputs["Strength"])
    math.mute = True
    graph = graph_of(shader.material)
    assert source(graph, 0, "Strength") == ("ShaderNodeValue", "Value")


def test_constant_of_a_muted_node_is_converted(shader, graph_of):
    math = shader.nodes.new("ShaderNodeMath")
    math.inputs[0].default_value = 0.25
    shader.links.new(math.outputs[0], shader.emission.inputs["Color"])
    math.mute = True
    graph = graph_of(shader.material)
    assert source(graph, 0, "Color") is None
    assert value(graph, 0, "Color") == (0.25, 0.25, 0.25, 1.0)


def test_muted_link_is_not_exported(shader, graph_of):
    number = shader.nodes.new("ShaderNodeValue")
    link = shader.links.new(number.outputs[0], shader.emission.inputs["Strength"])
    link.is_muted = True
    shader.emission.inputs["Strength"].default_value = 7.0
    graph = graph_of(shader.material)
    assert source(graph, 0, "Strength") is None and value(graph, 0, "Strength")[0] == 7.0


def test_loops_of_links_are_cut(shader, graph_of):
    a, b = shader.nodes.new("ShaderNodeMath"), shader.nodes.new("ShaderNodeMath")
    shader.links.new(a.outputs[0], b.inputs[0])
    shader.links.new(b.outputs[0], a.inputs[0])
    shader.links.new(a.outputs[0], shader.emission.inputs["Strength"])
    assert len(graph_of(shader.material).nodes) <= 3


def test_a_chain_of_a_thousand_nodes_is_exported(shader, graph_of):
    last = shader.emission.inputs["Strength"]
    for _ in range(1000):
        node = shader.nodes.new("ShaderNodeMath")
        shader.links.new(node.outputs[0], last)
        last = node.inputs[0]
    assert len(graph_of(shader.material).nodes) == 1001


def test_properties_are_names_and_numbers(shader, graph_of):
    math, image = shader.nodes.new("ShaderNodeMath"), shader.nodes.new("ShaderNodeTexImage")
    math.operation, math.use_clamp = "POWER", True
    shader.links.new(math.outputs[0], shader.emission.inputs["Strength"])
    image.interpolation, image.extension = "Closest", "CLIP"
    shader.links.new(image.outputs["Color"], shader.emission.inputs["Color"])
    graph = graph_of(shader.material)
    math_index, image_index = node_of(graph, "ShaderNodeMath"), node_of(graph, "ShaderNodeTexImage")
    assert property_of(graph, math_index, "operation").text == "POWER"
    assert property_of(graph, math_index, "use_clamp").numbers == [1.0]
    assert property_of(graph, image_index, "interpolation").text == "Closest"
    assert property_of(graph, image_index, "extension").text == "CLIP"
    assert property_of(graph, image_index, "image").numbers == [-1.0]


def test_ramp_is_a_table(shader, graph_of):
    ramp = shader.nodes.new("ShaderNodeValToRGB")
    shader.links.new(ramp.outputs["Color"], shader.emission.inputs["Color"])
    graph = graph_of(shader.material)
    table = np.reshape(property_of(graph, 1, "ramp").numbers, (256, 4))
    np.testing.assert_allclose(table[:, 0], np.linspace(0, 1, 256), atol=1e-6)
    assert property_of(graph, 1, "ramp_interpolation").text == "LINEAR"


@pytest.mark.parametrize("kind", ["RGBCurve", "VectorCurve", "FloatCurve"])
def test_curves_are_tables(shader, graph_of, kind):
    curve = shader.nodes.new(f"ShaderNode{kind}")
    shader.links.new(curve.outputs[0], shader.emission.inputs["Color"])
    graph = graph_of(shader.material)
    low, high = property_of(graph, 1, "curve_range").numbers
    table = np.reshape(property_of(graph, 1, "curve").numbers, (256, 4))
    np.testing.assert_allclose(table[:, 0], np.linspace(low, high, 256), atol=1e-3)


def test_images_are_shared_between_nodes(shader, build, export, tmp_path):
    generated = bpy.data.images.new("Generated", 4, 2)
    generated.pixels.foreach_set(np.linspace(0, 1, 32, dtype=np.float32))
    missing = bpy.data.images.load(str(write_image(tmp_path / "x.png")))
    missing.filepath = str(tmp_path / "gone.png")
    mix = shader.nodes.new("ShaderNodeMixRGB")
    first, second, third = (shader.nodes.new("ShaderNodeTexImage") for _ in range(3))
    first.image = second.image = generated
    third.image = missing
    for i, node in enumerate((first, second, third)):
        shader.links.new(node.outputs["Color"], mix.inputs[i])
    shader.links.new(mix.outputs[0], shader.emission.inputs["Color"])
    mesh = build.mesh()
    mesh.materials.append(shader.material)
    build.object(mesh)
    images = {image.name: image for image in export().images}
    assert len(images) == 2
    assert (images["Generated"].width, images["Generated"].height) == (4, 2)
    np.testing.assert_allclose(images["Generated"].pixels.ravel(), np.linspace(0, 1, 32), atol=0.003)
    assert images["Generated"].color_space == "sRGB"
    assert images["x.png"].path == str(tmp_path / "gone.png")


def test_packed_image_is_exported_as_bytes(shader, build, export, tmp_path):
    path = write_image(tmp_path / "x.png")
    image = bpy.data.images.load(str(path))
    image.pack()
    image.colorspace_settings.name = "Non-Color"
    node = shader.nodes.new("ShaderNodeTexImage")
    node.image = image
    shader.links.new(node.outputs["Color"], shader.emission.inputs["Color"])
    mesh = build.mesh()
    mesh.materials.append(shader.material)
    build.object(mesh)
    out = export().images[0]
    assert out.packed_size == path.stat().st_size and out.path == ""
    assert out.color_space == "Non-Color"


def write_image(path):
    ajar.write_image(str(path), np.full((2, 2, 4), 0.5, np.float32))
    return path


def test_material_without_nodes_is_diffuse_with_its_colour(build, graph_of):
    material = bpy.data.materials.new("Plain")
    material.use_nodes = False
    material.diffuse_color = (0.1, 0.2, 0.3, 1.0)
    graph = graph_of(material)
    assert graph.nodes[0].type == "ShaderNodeBsdfDiffuse"
    np.testing.assert_allclose(value(graph, 0, "Color"), (0.1, 0.2, 0.3, 1.0), rtol=1e-6)


def test_output_without_links_is_black(build, graph_of):
    graph = graph_of(build.material())
    assert graph.nodes[graph.surface.node].type == "ShaderNodeBsdfDiffuse"
    assert value(graph, 0, "Color")[:3] == (0.0, 0.0, 0.0)


def test_output_with_only_a_volume_has_no_surface(build, graph_of):
    material = build.material()
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    links.new(nodes.new("ShaderNodeVolumeScatter").outputs["Volume"], nodes.new("ShaderNodeOutputMaterial").inputs["Volume"])
    graph = graph_of(material)
    assert graph.surface.node < 0 <= graph.volume.node


def test_output_for_cycles_is_preferred(shader, graph_of):
    other = shader.nodes.new("ShaderNodeOutputMaterial")
    other.target = "CYCLES"
    glossy = shader.nodes.new("ShaderNodeBsdfGlossy")
    shader.links.new(glossy.outputs[0], other.inputs["Surface"])
    graph = graph_of(shader.material)
    assert graph.nodes[graph.surface.node].type in ("ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic")


def test_coordinates_of_an_object_have_its_inverse_matrix(shader, build, graph_of):
    empty = build.object(None, "Origin", (1, 2, 3))
    coordinates = shader.nodes.new("ShaderNodeTexCoord")
    coordinates.object = empty
    shader.links.new(coordinates.outputs["Object"], shader.emission.inputs["Color"])
    graph = graph_of(shader.material)
    rows = np.reshape(property_of(graph, 1, "object").numbers, (3, 4))
    np.testing.assert_allclose(rows[:, 3], (-1, -2, -3))


LAMP = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 1 0 0 0\n1 1 1\n0 90\n0\n100 50\n"


def ies_node(shader, **settings):
    node = shader.nodes.new("ShaderNodeTexIES")
    for name, content in settings.items():
        setattr(node, name, content)
    shader.links.new(node.outputs["Fac"], shader.emission.inputs["Strength"])
    return node


def test_ies_of_a_text_block(shader, graph_of):
    text = bpy.data.texts.new("lamp.ies")
    text.write(LAMP)
    ies_node(shader, mode="INTERNAL", ies=text, filepath="//elsewhere.ies")
    graph = graph_of(shader.material)
    assert property_of(graph, node_of(graph, "ShaderNodeTexIES"), "ies").text.strip() == LAMP.strip()


def test_ies_of_a_file(shader, graph_of, tmp_path):
    (tmp_path / "lamp.ies").write_bytes(b"[MANUFAC] Stra\xdfenlampe\r\n" + LAMP.encode())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    ies_node(shader, mode="EXTERNAL", filepath="//lamp.ies")
    graph = graph_of(shader.material)
    assert property_of(graph, node_of(graph, "ShaderNodeTexIES"), "ies").text == "[MANUFAC] Straßenlampe\r\n" + LAMP


def test_ies_files_that_cannot_be_read_are_reported_by_path(shader, graph_of, tmp_path):
    ies_node(shader, mode="EXTERNAL", filepath=str(tmp_path / "gone.ies"))
    graph = graph_of(shader.material)
    index = node_of(graph, "ShaderNodeTexIES")
    assert property_of(graph, index, "unreadable").text == f"{tmp_path}/gone.ies: No such file or directory"
    assert "ies" not in [p.name for p in graph.nodes[index].properties]


def test_an_ies_node_without_a_source_exports_no_text(shader, graph_of):
    ies_node(shader, mode="INTERNAL")
    graph = graph_of(shader.material)
    assert not {"ies", "unreadable"} & {p.name for p in graph.nodes[node_of(graph, "ShaderNodeTexIES")].properties}


@pytest.mark.parametrize("method", ["BUMP", "DISPLACEMENT", "BOTH"])
def test_the_method_of_displacement_is_exported(shader, build, export_context, method):
    displacement = shader.nodes.new("ShaderNodeDisplacement")
    shader.links.new(shader.nodes.new("ShaderNodeTexNoise").outputs["Fac"], displacement.inputs["Height"])
    shader.links.new(displacement.outputs[0], shader.nodes["Material Output"].inputs["Displacement"])
    shader.material.cycles.displacement_method = method
    mesh = build.mesh()
    mesh.materials.append(shader.material)
    build.object(mesh)
    context = export_context()
    assert context.description.materials[0].graph.displacement.node >= 0
    assert context.description.materials[0].displacement_method.name.upper() == method
    assert context.warnings == []


def test_meshes_without_a_material_have_the_default_of_this_blender(build, export, monkeypatch):
    from ajar_render import compat
    for _ in range(2):
        build.object(build.mesh())
    out = export()
    assert len(out.materials) == 0 and all(list(thing.materials) in ([], [-1]) for thing in out.objects)
    monkeypatch.setattr(compat, "default_is_principled", lambda: True)
    meshes = [thing.data for thing in bpy.context.scene.objects if thing.type == "MESH"]
    meshes[0].materials.append(None)   # one mesh with an empty slot and one without slots
    out = export()
    assert [material.name for material in out.materials] == ["default_surface"]
    assert out.materials[0].graph.nodes[0].type == "ShaderNodeBsdfPrincipled"
    assert [list(thing.materials) for thing in out.objects] == [[0], [0]]


def mapping_of(graph):
    """The values of the Mapping node of a texture, and the source of its vector."""
    index = node_of(graph, "ShaderNodeMapping")
    inputs = {i.socket: tuple(i.value[:3]) for i in graph.nodes[index].inputs if i.socket != "Vector"}
    return inputs, property_of(graph, index, "vector_type").text, source(graph, index, "Vector")


@pytest.mark.parametrize("type_, coordinates", [("ShaderNodeTexNoise", ("ShaderNodeTexCoord", "Generated")), ("ShaderNodeTexImage", ("ShaderNodeTexCoord", "UV")),
                                                ("ShaderNodeTexEnvironment", ("ShaderNodeNewGeometry", "Position"))])
def test_the_texture_mapping_of_a_node_becomes_a_mapping_node(shader, graph_of, type_, coordinates):
    texture = shader.nodes.new(type_)
    shader.links.new(texture.outputs["Color"], shader.emission.inputs["Color"])
    assert not any(node.type == "ShaderNodeMapping" for node in graph_of(shader.material).nodes)
    texture.texture_mapping.translation, texture.texture_mapping.scale, texture.texture_mapping.vector_type = (1.0, 2.0, 3.0), (2.0, 1.0, 0.5), "TEXTURE"
    graph = graph_of(shader.material)
    assert source(graph, node_of(graph, type_), "Vector") == ("ShaderNodeMapping", "Vector")
    inputs, kind, fed_by = mapping_of(graph)
    assert inputs == {"Location": (1.0, 2.0, 3.0), "Rotation": (0.0, 0.0, 0.0), "Scale": (2.0, 1.0, 0.5)} and kind == "TEXTURE" and fed_by == coordinates


def test_the_texture_mapping_of_a_node_transforms_its_linked_vector(shader, graph_of):
    texture, normal = shader.nodes.new("ShaderNodeTexNoise"), shader.nodes.new("ShaderNodeNewGeometry")
    shader.links.new(texture.outputs["Color"], shader.emission.inputs["Color"])
    shader.links.new(normal.outputs["Normal"], texture.inputs["Vector"])
    texture.texture_mapping.rotation = (0.0, 0.0, 0.5)
    assert mapping_of(graph_of(shader.material))[2] == ("ShaderNodeNewGeometry", "Normal")


def test_the_environment_of_a_world_is_mapped_by_its_direction(export, scene):
    scene.world = bpy.data.worlds.new("Sky")
    scene.world.use_nodes = True
    nodes = scene.world.node_tree.nodes
    texture = nodes.new("ShaderNodeTexEnvironment")
    scene.world.node_tree.links.new(texture.outputs["Color"], nodes["Background"].inputs["Color"])
    texture.texture_mapping.rotation = (0.0, 0.0, 0.5)
    assert mapping_of(export().world.graph)[2] == ("ShaderNodeTexCoord", "Generated")


def test_links_of_nodes_that_cycles_does_not_have_are_ignored_and_reported(shader, build, export_context):
    odd = shader.nodes.new("ShaderNodeShaderToRGB")
    odd.name = "Toon"
    shader.links.new(shader.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], odd.inputs[0])
    shader.links.new(odd.outputs["Color"], shader.emission.inputs["Color"])
    shader.emission.inputs["Color"].default_value = (0.2, 0.5, 0.7, 1.0)
    mesh = build.mesh()
    mesh.materials.append(shader.material)
    build.object(mesh)
    context = export_context()
    assert [text for name, text in context.warnings if name == shader.material.name] == [
        'node "Toon" is not a node of Cycles: its links are ignored, as in Cycles']
    node = next(node for node in context.description.materials[0].graph.nodes if node.type == "ShaderNodeEmission")
    color = next(item for item in node.inputs if item.socket == "Color")
    assert color.link.node < 0
    assert tuple(color.value) == pytest.approx((0.2, 0.5, 0.7, 1.0))


def test_the_projection_of_a_texture_mapping_is_reported(shader, build, export_context):
    texture = shader.nodes.new("ShaderNodeTexNoise")
    texture.name = "Clouds"
    shader.links.new(texture.outputs["Color"], shader.emission.inputs["Color"])
    texture.texture_mapping.mapping_x = "Z"
    mesh = build.mesh()
    mesh.materials.append(shader.material)
    build.object(mesh)
    assert [(name, text) for name, text in export_context().warnings if "'Clouds'" in text and "Projection" in text] == [
        (shader.material.name, "node 'Clouds' (ShaderNodeTexNoise): the Projection of its Texture Mapping is not supported: X, Y and Z are used")]


def test_a_group_that_contains_itself_is_cut_and_reported(shader, build, export_context, monkeypatch):
    """Blender 3.4 refuses such groups, or crashes. So the inner tree only says that it is the outer one."""
    outer, inner = float_group("Outer"), float_group("Inner")
    nested = outer.nodes.new("ShaderNodeGroup")
    nested.name, nested.node_tree = "Snake", inner
    outer.links.new(nested.outputs[0], next(node for node in outer.nodes if node.type == "MATH").inputs[1])
    group = shader.nodes.new("ShaderNodeGroup")
    group.node_tree = outer
    shader.links.new(group.outputs[0], shader.emission.inputs["Strength"])
    mesh = build.mesh()
    mesh.materials.append(shader.material)
    build.object(mesh, "Rope")
    monkeypatch.setattr(node_graph, "is_same_tree", lambda a, b: {a.name, b.name} <= {"Outer", "Inner"})
    context = export_context()
    assert [(name, text) for name, text in context.warnings if "contains itself" in text] == [
        ("Material", 'node group "Group/Snake" contains itself: it is left out inside itself (object "Rope")')]
    graph = context.description.materials[0].graph
    assert [node.type for node in graph.nodes].count("ShaderNodeMath") == 1
