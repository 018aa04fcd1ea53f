"""Tests of the export of smoke: the voxels of a gas domain become the grids of a volume."""

import bpy
import numpy as np
import pytest

from test_export_volumes import dense

pytestmark = pytest.mark.skipif(not bpy.app.build_options.fluid, reason="this Blender cannot simulate fluids")


@pytest.fixture
def domain(build, tmp_path, monkeypatch):
    """Makes the smoke of a box, simulated for three frames on at most 20 voxels along an axis."""
    monkeypatch.chdir(tmp_path)   # noise writes a file there
    def make(adaptive=False, bake=True, colour=(1.0, 1.0, 1.0), material=None, noise=False):
        corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        flow = build.object(build.mesh("Flow", [tuple(0.3 * c for c in p) for p in corners], faces), "Flow")
        owner = build.object(build.mesh("Domain", corners, faces), "Domain")
        owner.scale = (1.0, 1.0, 2.0)
        owner.data.materials.append(material or build.material("Smoke"))
        emits = flow.modifiers.new("Fluid", "FLUID")
        emits.fluid_type = "FLOW"
        emits.flow_settings.flow_type, emits.flow_settings.flow_behavior = "BOTH", "INFLOW"
        emits.flow_settings.smoke_color = colour
        modifier = owner.modifiers.new("Fluid", "FLUID")
        modifier.fluid_type = "DOMAIN"
        settings = modifier.domain_settings
        settings.domain_type, settings.cache_type = "GAS", "ALL"
        settings.cache_directory = str(tmp_path / "cache")
        settings.resolution_max, settings.cache_frame_end, settings.use_adaptive_domain = 20, 3, adaptive
        settings.use_noise = noise
        bpy.context.scene.frame_end = 3
        bpy.context.view_layer.objects.active = owner
        if bake:
            with bpy.context.temp_override(scene=bpy.context.scene, active_object=owner, object=owner):
                bpy.ops.fluid.bake_all()
        bpy.context.scene.frame_set(3)
        return owner
    return make


def evaluated(owner):
    found = owner.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return found, found.modifiers[-1].domain_settings


@pytest.mark.parametrize("adaptive", [False, True])
def test_voxels_keep_their_values_and_places(domain, export, adaptive):
    owner = domain(adaptive)
    mesh, = [mesh for mesh in export().meshes if mesh.grids]
    grid, = mesh.grids
    assert grid[0] == "density" and not mesh.density_in_object_space
    thing, settings = evaluated(owner)
    shape = tuple(settings.domain_resolution)
    values = np.array(settings.density_grid, dtype=np.float32).reshape(shape[::-1]).transpose()
    assert values.max() > 0.5
    assert np.array_equal(dense(grid, shape)[..., 0], np.where(values >= settings.clipping, values, 0.0))
    # The first and the last voxel touch the sides of the domain.
    box = np.array([vertex.co for vertex in thing.data.vertices])
    rows = np.array(grid[1]).reshape(3, 4)
    assert np.allclose(rows[:, :3] @ box.min(axis=0) + rows[:, 3], -0.5, atol=1e-4)
    assert np.allclose(rows[:, :3] @ box.max(axis=0) + rows[:, 3], np.array(shape) - 0.5, atol=1e-4)


def test_other_grids_are_exported_if_materials_ask_for_them(domain, build, export):
    material = build.material("Smoke")
    tree = material.node_tree
    volume = tree.nodes.new("ShaderNodeVolumePrincipled")
    volume.inputs["Color Attribute"].default_value = "color"
    asked = tree.nodes.new("ShaderNodeAttribute")
    asked.attribute_name = "heat"
    tree.links.new(asked.outputs["Fac"], volume.inputs["Emission Strength"])
    tree.links.new(volume.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Volume"])
    owner = domain(colour=(0.2, 0.5, 1.0), material=material)
    mesh, = [mesh for mesh in export().meshes if mesh.grids]
    grids = {grid[0]: grid for grid in mesh.grids}
    assert list(grids) == ["density", "color", "heat", "temperature"]   # Principled Volume asks for the temperature
    settings = evaluated(owner)[1]
    shape = tuple(settings.domain_resolution)
    raw = np.array(settings.color_grid, dtype=np.float32).reshape(*shape[::-1], 4).transpose(2, 1, 0, 3)
    assert raw[..., 3].max() > 0.5 and np.array_equal(dense(grids["color"], shape), raw)   # multiplied by alpha
    assert dense(grids["heat"], shape).max() > 0.0


@pytest.mark.parametrize("noise", [False, True])
def test_smoke_flows_with_motion_blur(domain, export, export_blurred, noise):
    owner = domain(noise=noise)
    render = bpy.context.scene.render
    still, = [mesh for mesh in export().meshes if mesh.grids]
    assert still.flow[0] == "" and [grid[0] for grid in still.grids] == ["density"]
    render.motion_blur_shutter, render.fps, render.fps_base = 0.5, 25, 1.0
    mesh, = [mesh for mesh in export_blurred().description.meshes if mesh.grids]
    thing, settings = evaluated(owner)
    assert mesh.flow == ("velocity", pytest.approx(settings.velocity_scale * 0.5 / 25), 0.5)
    grids = {grid[0]: grid for grid in mesh.grids}
    shape = tuple(settings.domain_resolution)
    raw = np.array(settings.velocity_grid, dtype=np.float32).reshape(*shape[::-1], 3).transpose(2, 1, 0, 3)
    assert np.abs(raw).max() > 0.0 and np.array_equal(dense(grids["velocity"], shape), raw)
    # Noise multiplies the resolution of the density alone; both fill the domain.
    box = np.array([vertex.co for vertex in thing.data.vertices])
    for name, factor in (("density", settings.noise_scale if noise else 1), ("velocity", 1)):
        rows = np.array(grids[name][1]).reshape(3, 4)
        assert np.allclose(rows[:, :3] @ box.max(axis=0) + rows[:, 3], factor * np.array(shape) - 0.5, atol=1e-3)
    room = np.abs(raw).reshape(-1, 3).max(axis=0) * mesh.flow[1] * 0.5
    assert np.allclose(mesh.positions.max(axis=0) - still.positions.max(axis=0), room, atol=1e-5)


def test_smoke_that_is_not_simulated_is_reported(domain, export_context):
    domain(bake=False)
    context = export_context()
    assert [text for name, text in context.warnings if name == "Domain"] == [
        "its smoke is empty in this frame and does not render; an unbaked simulation has to be baked or played first"]
    assert not any(mesh.grids for mesh in context.description.meshes)
