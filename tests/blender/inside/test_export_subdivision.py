"""Tests of the export of adaptive subdivision: faces, creases, settings."""

import bpy
import numpy as np
import pytest
from ajar_render.ajar_module import ajar
from ajar_render.export import subdivision


def cube(build, name="Cube"):
    vertices = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return build.mesh(name, vertices, faces)


@pytest.fixture
def adaptive(build, scene):
    """An object with adaptive subdivision. Without levels, the mesh that the modifier makes is the original one."""
    scene.cycles.feature_set = "EXPERIMENTAL"

    def make(mesh=None, levels=0, other=False):
        thing = build.object(mesh or cube(build))
        if other:
            thing.modifiers.new("Other", "CAST")
        modifier = thing.modifiers.new("Subdivision", "SUBSURF")
        modifier.levels = modifier.render_levels = levels
        thing.cycles.use_adaptive_subdivision = True
        return thing, modifier
    return make


def test_faces_are_exported_instead_of_triangles(adaptive, export):
    adaptive()
    mesh = export().meshes[0]
    faces = mesh.subdivision
    assert len(mesh.triangles) == 0 and faces["scheme"] == ajar.SubdivisionScheme.CatmullClark
    assert faces["face_sizes"].tolist() == [4] * 6
    assert faces["corner_vertices"].reshape(-1, 4)[0].tolist() == [0, 1, 3, 2]
    assert faces["flat_faces"].tolist() == [1] * 6
    assert faces["in_pixels"] and faces["edge_length"] == pytest.approx(8.0)   # of the viewport
    assert not faces["keep_corners"] and faces["uv_smoothing"] == ajar.UvSmoothing.KeepBoundaries


def test_divided_meshes_keep_the_offset_of_shadows(adaptive, export):
    # Displaced faces lean away from their smooth normals by any angle, however small they are.
    adaptive()
    assert export().objects[0].shadow_terminator_offset == pytest.approx(0.1)


def test_versions_before_4_5_divide_what_the_modifier_has_made(adaptive, export):
    adaptive(levels=2)
    assert len(export().meshes[0].subdivision["face_sizes"]) == 6 * 16


def test_newer_versions_divide_the_original_mesh(adaptive, export, monkeypatch):
    from ajar_render import compat
    thing, _ = adaptive(levels=2)
    monkeypatch.setattr(compat, "adapts_before_modifier", lambda: True)
    assert len(export().meshes[0].subdivision["face_sizes"]) == 6
    bpy.data.objects.remove(thing)
    adaptive(levels=2, other=True)
    smoothed = export().meshes[0].subdivision   # a viewport cannot see the mesh between the modifiers
    assert len(smoothed["face_sizes"]) == 6 * 16 and smoothed["scheme"] == ajar.SubdivisionScheme.Simple


def test_without_the_setting_the_modifier_counts(adaptive, export, scene):
    thing, _modifier = adaptive(levels=1)
    thing.cycles.use_adaptive_subdivision = False
    assert len(export().meshes[0].triangles) == 48 and export().meshes[0].subdivision is None
    thing.ajar.use_adaptive_subdivision = True
    scene.cycles.feature_set = "SUPPORTED"   # a setting of Ajar does not need it
    assert export().meshes[0].subdivision is not None
    thing.modifiers.new("Last", "CAST")
    assert export().meshes[0].subdivision is None


def test_settings_of_cycles_need_its_experimental_features(adaptive, export, scene):
    adaptive(levels=1)
    scene.cycles.feature_set = "SUPPORTED"
    assert export().meshes[0].subdivision is None


def test_settings_of_the_modifier(adaptive, export):
    thing, modifier = adaptive()
    modifier.subdivision_type, modifier.boundary_smooth, modifier.uv_smooth = "SIMPLE", "PRESERVE_CORNERS", "SMOOTH_ALL"
    thing.cycles.dicing_rate = 2.0
    thing.data.polygons.foreach_set("use_smooth", [True] * 6)
    mesh = export().meshes[0]
    faces = mesh.subdivision
    assert faces["scheme"] == ajar.SubdivisionScheme.Simple and faces["keep_corners"] and faces["uv_smoothing"] == ajar.UvSmoothing.All
    assert faces["edge_length"] == pytest.approx(16.0) and len(faces["flat_faces"]) == 0
    assert len(mesh.normals) == 8 and mesh.normal_domain == ajar.Domain.Vertex


def test_creases(adaptive, export):
    thing, modifier = adaptive()
    thing.data.edges[3].crease = 0.5
    faces = export().meshes[0].subdivision
    assert faces["creased_edges"].tolist() == [list(thing.data.edges[3].vertices)]
    assert faces["edge_sharpness"].tolist() == pytest.approx([5.0], abs=0.03)
    modifier.use_creases = False
    assert len(export().meshes[0].subdivision["creased_edges"]) == 0


def test_data_of_faces_and_corners(adaptive, export):
    thing, _ = adaptive()
    mesh = thing.data
    for name in ("First", "Second"):
        mesh.materials.append(bpy.data.materials.new(name))
    mesh.polygons.foreach_set("material_index", [0, 1, 0, 1, 0, 1])
    layer = mesh.uv_layers.new(name="Map")
    layer.data.foreach_set("uv", np.arange(48, dtype=np.float32))
    colors = mesh.color_attributes.new("Colors", "FLOAT_COLOR", "POINT")
    colors.data.foreach_set("color", np.arange(32, dtype=np.float32))
    out = export().meshes[0]
    assert out.material_slots.tolist() == [0, 1, 0, 1, 0, 1]
    found = {attribute.name: attribute for attribute in out.attributes}
    np.testing.assert_array_equal(found["Map"].values.ravel(), np.arange(48))
    assert found["Map"].domain == ajar.Domain.Corner and out.active_uv == "Map"
    np.testing.assert_array_equal(found["Colors"].values.ravel(), np.arange(32))


def test_settings_of_the_scene(adaptive, export, scene, build):
    adaptive()
    scene.cycles.max_subdivisions, scene.cycles.offscreen_dicing_scale = 5, 2.0
    dicing = export().dicing
    assert dicing.max_subdivisions == 5 and dicing.offscreen_scale == 2.0 and not dicing.camera.present
    thing = build.object(bpy.data.cameras.new("Dicing"), location=(1, 2, 3))
    scene.cycles.dicing_camera = thing
    camera = export().dicing.camera
    assert camera.present and [camera.world_from_camera[i] for i in (3, 7, 11)] == [1, 2, 3]
    scene.ajar.max_subdivisions = 7
    assert export().dicing.max_subdivisions == 7


def test_meshes_without_faces_are_left_out(adaptive, export, build):
    adaptive(build.mesh("Edge", ((0, 0, 0), (1, 0, 0)), ()))
    assert len(export().meshes) == 0


def test_a_modifier_that_is_switched_off_is_not_used(adaptive, export_context):
    _, modifier = adaptive()
    modifier.show_viewport = False
    assert export_context().description.meshes[0].subdivision is None


def test_the_scene_is_evaluated_without_the_modifier(adaptive, scene, monkeypatch):
    """A final render evaluates the scene again if there are other modifiers; the modifier stays switched on."""
    from ajar_render import compat
    from ajar_render.export import ExportContext
    monkeypatch.setattr(compat, "adapts_before_modifier", lambda: True)
    thing, modifier = adaptive(levels=2, other=True)
    calls = []
    context = ExportContext(bpy.context.evaluated_depsgraph_get(), lambda: False, lambda step: None)
    subdivision.prepare(context, lambda frame, subframe: calls.append(modifier.show_render))
    assert calls == [False] and modifier.show_render
    assert context.base_is_evaluated == {thing.as_pointer()}
    modifier.show_viewport = False   # as in the evaluated scene
    assert subdivision.wanted(context, thing) is not None
