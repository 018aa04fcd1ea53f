"""Tests of the export of meshes: triangles, normals, UV maps, colours and material slots."""

import bpy
import numpy as np
import pytest
from ajar_render.ajar_module import ajar


def smooth(mesh, flags=None):
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons) if flags is None else flags)


def cube(build, name="Cube"):
    vertices = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return build.mesh(name, vertices, faces)


def test_quad_becomes_two_triangles_with_its_area_and_orientation(build, export):
    build.object(build.mesh())
    mesh = export().meshes[0]
    a, b, c = (mesh.positions[mesh.triangles[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    assert mesh.triangles.shape == (2, 3)
    np.testing.assert_allclose(cross, [[0, 0, 1], [0, 0, 1]])


def test_flat_mesh_has_no_normals(build, export):
    build.object(cube(build))
    assert len(export().meshes[0].normals) == 0


def test_smooth_mesh_has_vertex_normals(build, export):
    mesh = cube(build)
    smooth(mesh)
    build.object(mesh)
    out = export().meshes[0]
    assert out.normal_domain == ajar.Domain.Vertex
    expected = (out.positions - 0.5) / np.linalg.norm(out.positions - 0.5, axis=1, keepdims=True)
    np.testing.assert_allclose(out.normals, expected, atol=1e-3)


def test_flat_faces_of_a_mixed_mesh_have_the_normals_of_their_triangles(build, export):
    mesh = cube(build)
    smooth(mesh, [False, True, True, True, True, True])
    build.object(mesh)
    out = export().meshes[0]
    assert out.normal_domain == ajar.Domain.Corner
    normals = out.normals.reshape(-1, 3, 3)
    a, b, c = (out.positions[out.triangles[:, k]] for k in range(3))
    geometric = np.cross(b - a, c - a)
    geometric /= np.linalg.norm(geometric, axis=1, keepdims=True)
    flat = np.abs(geometric[:, 0] + 1) < 1e-6  # the face at x = 0
    assert flat.sum() == 2
    np.testing.assert_allclose(normals[flat], np.repeat(geometric[flat][:, None], 3, 1), atol=1e-6)
    assert np.abs(normals[~flat] - geometric[~flat][:, None]).max() > 0.1


@pytest.mark.parametrize("method", ["BUMP", "DISPLACEMENT", "BOTH"])
def test_flat_faces_of_a_mixed_mesh_that_moves_are_marked(build, export, method):
    mesh = cube(build)
    smooth(mesh, [False, True, True, True, True, True])
    material = bpy.data.materials.new("Moved")
    material.cycles.displacement_method = method
    mesh.materials.append(material)
    build.object(mesh)
    marked = [attribute for attribute in export().meshes[0].attributes if attribute.name == ajar.FLAT_FACES]
    assert len(marked) == (method != "BUMP")
    for attribute in marked:
        assert attribute.domain == ajar.Domain.Face
        assert sorted(np.asarray(attribute.values).reshape(-1)) == [0.0] * 10 + [1.0] * 2


def test_split_normals_keep_edges_sharp(build, export):
    mesh = cube(build)
    smooth(mesh)
    if bpy.app.version >= (4, 1):
        mesh.set_sharp_from_angle(angle=0.5)
    else:
        mesh.use_auto_smooth = True
        mesh.auto_smooth_angle = 0.5
    build.object(mesh)
    out = export().meshes[0]
    a, b, c = (out.positions[out.triangles[:, k]] for k in range(3))
    np.testing.assert_allclose(out.normals.reshape(-1, 3, 3), np.repeat(np.cross(b - a, c - a)[:, None], 3, 1), atol=1e-3)


@pytest.mark.parametrize("split", [False, True])
def test_a_flat_face_has_the_normal_of_its_polygon_only_where_corners_have_normals(build, export, split):
    """A flat face that is not planar, beside a smooth one."""
    mesh = build.mesh("Bent", ((-1, -1, 0), (1, -1, 0), (1, 1, 1), (-1, 1, 0), (3, -1, 0), (3, 1, 0)), ((0, 1, 2, 3), (1, 4, 5, 2)))
    for polygon, is_smooth in zip(mesh.polygons, (False, True), strict=True):
        polygon.use_smooth = is_smooth
    if bpy.app.version < (4, 1):
        mesh.use_auto_smooth, mesh.auto_smooth_angle = split, 3.0
    elif split:
        mesh.edges[0].use_edge_sharp = True
    build.object(mesh)
    out = export().meshes[0]
    a, b, c = (out.positions[out.triangles[:, k]] for k in range(3))
    of_triangles = np.cross(b - a, c - a)
    of_triangles /= np.linalg.norm(of_triangles, axis=1, keepdims=True)
    of_polygon = np.tile(mesh.polygons[0].normal, (2, 1))
    expected = of_polygon if split or bpy.app.version >= (5, 1) else of_triangles[:2]
    np.testing.assert_allclose(out.normals.reshape(-1, 3, 3)[:2], np.repeat(expected[:, None], 3, 1), atol=1e-3)


def test_custom_normals_are_exported(build, export):
    mesh = build.mesh()
    smooth(mesh)
    if bpy.app.version < (4, 1):
        mesh.use_auto_smooth = True
    custom = np.array([0.6, 0.0, 0.8])
    mesh.normals_split_custom_set([tuple(custom)] * len(mesh.loops))
    build.object(mesh)
    np.testing.assert_allclose(export().meshes[0].normals, np.tile(custom, (6, 1)), atol=1e-3)


def test_every_uv_map_is_exported_by_corner_and_the_rendered_map_is_marked(build, export):
    mesh = build.mesh()
    first, second = mesh.uv_layers.new(name="First"), mesh.uv_layers.new(name="Second")
    corner_uv = np.array([(v.co.x, v.co.y) for loop in mesh.loops for v in [mesh.vertices[loop.vertex_index]]], dtype=np.float32)
    first.data.foreach_set("uv", corner_uv.ravel())
    second.data.foreach_set("uv", (corner_uv * 2 + 1).ravel())
    second.active_render = True
    build.object(mesh)
    out = export().meshes[0]
    attributes = {attribute.name: attribute.values for attribute in out.attributes}
    corners = out.positions[out.triangles.ravel()][:, :2]
    np.testing.assert_allclose(attributes["First"], corners)
    np.testing.assert_allclose(attributes["Second"], corners * 2 + 1)
    assert out.active_uv == "Second"


@pytest.mark.parametrize("kind", ["FLOAT_COLOR", "BYTE_COLOR"])
@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
def test_colour_attributes_are_linear_rgba(build, export, kind, domain):
    mesh = build.mesh()
    colors = mesh.color_attributes.new("Paint", kind, domain)
    colors.data.foreach_set("color", [0.25, 0.5, 1.0, 1.0] * len(colors.data))
    build.object(mesh)
    paint = next(attribute for attribute in export().meshes[0].attributes if attribute.name == "Paint")
    assert paint.domain == (ajar.Domain.Vertex if domain == "POINT" else ajar.Domain.Corner)
    assert paint.values.shape == (4 if domain == "POINT" else 6, 4)
    np.testing.assert_allclose(paint.values, np.tile([0.25, 0.5, 1.0, 1.0], (len(paint.values), 1)), atol=0.005)


def test_named_attribute_is_exported_only_for_a_material_that_reads_it(build, export):
    mesh = build.mesh()
    mesh.attributes.new("heat", "FLOAT", "FACE").data.foreach_set("value", [0.75])
    build.object(mesh)
    assert not export().meshes[0].attributes
    material = build.material()
    nodes, links = material.node_tree.nodes, material.node_tree.links
    node, emission = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeEmission")
    node.attribute_name = "heat"
    links.new(node.outputs["Fac"], emission.inputs["Strength"])
    links.new(emission.outputs[0], nodes["Material Output"].inputs["Surface"])
    mesh.materials.append(material)
    heat = export().meshes[0].attributes[0]
    assert (heat.name, heat.domain, heat.components) == ("heat", ajar.Domain.Face, 1)
    np.testing.assert_allclose(heat.values, [0.75, 0.75])


def test_triangles_have_the_material_slots_of_their_polygons(build, export):
    mesh = cube(build)
    for name in "AB":
        mesh.materials.append(build.material(name))
    mesh.polygons.foreach_set("material_index", [0, 1, 0, 0, 1, 0])
    build.object(mesh)
    out = export()
    assert list(out.meshes[0].material_slots) == [0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0]
    assert [out.materials[i].name for i in out.objects[0].materials] == ["A", "B"]


def test_modifiers_are_applied(build, export):
    thing = build.object(build.mesh())
    thing.modifiers.new("Subdivision", "SUBSURF").render_levels = 1
    thing.modifiers["Subdivision"].levels = 1
    array = thing.modifiers.new("Array", "ARRAY")
    array.count = 3
    assert len(export().meshes[0].triangles) == 3 * 4 * 2


def test_generated_coordinates_have_the_mesh_box(build, export):
    build.object(build.mesh(vertices=((0, 0, 0), (4, 0, 0), (4, 2, 0), (0, 2, 0))))
    mesh = export().meshes[0]
    np.testing.assert_allclose(mesh.texture_space_location, (2, 1, 0))
    np.testing.assert_allclose(mesh.texture_space_size[:2], (2, 1))


@pytest.mark.parametrize("kind", ["CURVE", "FONT", "META", "SURFACE"])
def test_other_kinds_of_surfaces_become_meshes(build, export, kind):
    if kind == "CURVE":
        curve = bpy.data.curves.new("Curve", "CURVE")
        curve.dimensions, curve.bevel_depth = "3D", 0.1
        spline = curve.splines.new("POLY")
        spline.points.add(2)
        for i, point in enumerate(spline.points):
            point.co = (i, i % 2, 0, 1)
        build.object(curve)
    elif kind == "FONT":
        text = bpy.data.curves.new("Text", "FONT")
        text.body = "A"
        build.object(text)
    elif kind == "META":
        ball = bpy.data.metaballs.new("Ball")
        ball.elements.new()
        build.object(ball)
    else:
        bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    out = export()
    assert len(out.meshes) == 1 and len(out.meshes[0].triangles) > 0
    assert len(out.instances) == 1


def test_objects_without_a_surface_are_not_exported(build, export):
    build.object(bpy.data.curves.new("Wire", "CURVE"))
    build.object(build.mesh("Empty mesh", (), ()))
    build.object(build.mesh("Points", ((0, 0, 0), (1, 0, 0)), ()))
    build.object(None, "Empty")
    out = export()
    assert not out.meshes and not out.objects and not out.instances


def test_invalid_numbers_are_exported_unchanged(build, export):
    build.object(build.mesh(vertices=((float("nan"), 0, 0), (1, 0, 0), (1, float("inf"), 0), (0, 1, 0))))
    positions = export().meshes[0].positions
    assert np.isnan(positions[0, 0]) and np.isinf(positions[2, 1])
