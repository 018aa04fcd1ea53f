"""Tests of the export of volume objects: their OpenVDB grids become bricks of voxels."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from ajar_render.export import volumes

vdb = volumes.library()
pytestmark = pytest.mark.skipif(vdb is None, reason="this Blender has no Python module of OpenVDB")


def a_grid(values, first=(0, 0, 0), name="density", kind="FloatGrid"):
    grid = getattr(vdb, kind)()
    grid.name = name
    grid.copyFromArray(np.ascontiguousarray(values), ijk=first)
    grid.transform = vdb.createLinearTransform([[0.5, 0, 0, 0], [0, 0.25, 0, 0], [0, 0, 1, 0], [1, 2, 3, 1]])
    return grid


@pytest.fixture
def cloud(build, tmp_path):
    """Makes a volume object from grids."""
    def make(*grids):
        volume = bpy.data.volumes.new("Cloud")
        volume.filepath = str(tmp_path / "cloud.vdb")
        if grids:
            vdb.write(volume.filepath, grids=list(grids))
        thing = build.object(volume, "Sky", (3, 2, 1))
        thing.data.materials.append(build.material("Fog"))
        return thing
    return make


@pytest.fixture
def warnings(export_context):
    def find():
        context = export_context()
        return context.description, [text for name, text in context.warnings if name == "Sky"]
    return find


def dense(found, shape, first=(0, 0, 0)):
    """The voxels of a box, by the bricks of a grid: [x, y, z] or [x, y, z, component]."""
    _name, _matrix, bricks, values = found
    cells = {tuple(brick): value for brick, value in zip(bricks, values.reshape(len(bricks), 8, 8, 8, -1))}
    result = np.zeros((*shape, values.shape[1] // 512), dtype=np.float32)
    for index in np.ndindex(*shape):
        place = np.add(index, first)
        brick = cells.get(tuple(place // 8))
        if brick is not None:
            result[index] = brick[tuple(place[::-1] % 8)]
    return result


def test_voxels_keep_their_values_and_places(cloud, export):
    values = np.random.default_rng(1).random((11, 9, 10)).astype(np.float32)
    first = (-5, 126, 3)
    cloud(a_grid(values, first))
    description = export()
    mesh, = description.meshes
    grid, = mesh.grids
    assert grid[0] == "density"
    assert np.array_equal(dense(grid, values.shape, first)[..., 0], values)
    assert np.count_nonzero(grid[3]) == np.count_nonzero(values)
    assert np.allclose(np.array(grid[1]).reshape(3, 4), [[2, 0, 0, -2], [0, 4, 0, -8], [0, 0, 1, -3]])
    # One voxel more on each side, where values are interpolated.
    assert np.allclose(mesh.positions.min(axis=0), (1 - 6 * 0.5, 2 + 125 * 0.25, 3 + 2))
    assert np.allclose(mesh.positions.max(axis=0), (1 + 6 * 0.5, 2 + 135 * 0.25, 3 + 13))
    assert mesh.density_in_object_space == (bpy.data.volumes["Cloud"].render.space == "OBJECT")
    assert description.objects[0].name == "Sky" and len(description.instances) == 1


def test_vectors_keep_their_components(cloud, export):
    values = np.random.default_rng(2).random((4, 3, 2, 3)).astype(np.float32)
    cloud(a_grid(values, name="color", kind="Vec3SGrid"), a_grid(np.ones((2, 2, 2), dtype=np.float32)))
    grids = {grid[0]: grid for grid in export().meshes[0].grids}
    assert sorted(grids) == ["color", "density"]
    assert np.array_equal(dense(grids["color"], (4, 3, 2)), values)


def test_a_grid_of_enormous_extent_costs_only_its_voxels(cloud, export):
    grid = a_grid(np.ones((2, 2, 2), dtype=np.float32), (-50_000, -50_000, -50_000))
    grid.copyFromArray(np.full((2, 2, 2), 2.0, dtype=np.float32), ijk=(50_000, 50_000, 50_000))
    cloud(grid)
    found, = export().meshes[0].grids
    assert len(found[2]) == 2 and found[3].sum() == 8 + 16


def test_an_enormous_grid_of_zeros_is_empty(cloud, warnings):
    grid = a_grid(np.ones((1, 1, 1), dtype=np.float32))
    grid.fill((0, 0, 0), (24 * 4096 - 1,) * 3, 0.0, True)
    cloud(grid)
    description, texts = warnings()
    assert not description.instances and texts == ["all its grids are empty and it does not render"]


def test_a_volume_that_a_modifier_made_is_read(build, export):
    square = build.object(build.mesh(), "Square", (0, 0, 0))
    square.scale = (2, 2, 2)
    volume = bpy.data.volumes.new("Fog")
    thing = build.object(volume, "Sky", (0, 0, 0))
    modifier = thing.modifiers.new("Volume", "MESH_TO_VOLUME")
    modifier.object, modifier.density, modifier.voxel_amount = square, 3.0, 16
    if hasattr(modifier, "exterior_band_width"):
        modifier.exterior_band_width = 0.3
    if hasattr(modifier, "interior_band_width"):
        modifier.interior_band_width = 0.3
    found = [mesh for mesh in export().meshes if mesh.grids]
    assert [grid[0] for mesh in found for grid in mesh.grids] == ["density"]
    assert found[0].grids[0][3].max() > 0.5


@pytest.mark.parametrize("way", ["collection", "particles"])
def test_instances_of_a_volume_share_its_grids(cloud, build, export, way):
    thing = cloud(a_grid(np.ones((2, 2, 2), dtype=np.float32)))
    if way == "collection":
        collection = bpy.data.collections.new("Clouds")
        collection.objects.link(thing)
        bpy.context.scene.collection.objects.unlink(thing)
        for x in range(3):
            empty = build.object(None, f"There {x}", (x, 0, 0))
            empty.instance_type, empty.instance_collection = "COLLECTION", collection
    else:
        settings = build.object(build.mesh(), "Where").modifiers.new("Show", "PARTICLE_SYSTEM").particle_system.settings
        settings.type, settings.count, settings.frame_start, settings.frame_end = "EMITTER", 3, 1, 1
        settings.physics_type, settings.render_type, settings.instance_object = "NO", "OBJECT", thing
        bpy.context.scene.frame_set(2)
        thing.hide_viewport = thing.hide_render = True
    description = export()
    number, = (i for i, mesh in enumerate(description.meshes) if mesh.grids)
    assert sum(description.objects[instance.object].mesh == number for instance in description.instances) == 3


def blurred(thing, position="CENTER"):
    """Motion blur of half a frame at 25 frames a second; the volume's own settings."""
    render = bpy.context.scene.render
    render.motion_blur_shutter, render.fps, render.fps_base = 0.5, 25, 1.0
    owner = render if hasattr(render, "motion_blur_position") else bpy.context.scene.cycles
    owner.motion_blur_position = position
    thing.data.grids.load()
    thing.data.velocity_unit = "SECOND"
    thing.data.update_tag()
    return thing.data


def with_velocity(cloud, name="velocity"):
    values = np.zeros((5, 4, 3, 3), dtype=np.float32)
    values[2, 1, 1] = (8.0, -2.0, 1.0)
    return cloud(a_grid(np.ones((5, 4, 3), dtype=np.float32)), a_grid(values, name=name, kind="Vec3SGrid"))


@pytest.mark.parametrize("position, frame", [("START", 0.0), ("CENTER", 0.5), ("END", 1.0)])
def test_a_volume_flows_with_motion_blur(cloud, export, export_blurred, position, frame):
    thing = with_velocity(cloud)
    still, = export().meshes
    assert still.flow[0] == ""
    blurred(thing, position)
    mesh, = export_blurred().description.meshes
    assert mesh.flow == ("velocity", pytest.approx(0.5 / 25), frame)
    # The box has room for what flows out of its grids.
    room = np.array((8.0, 2.0, 1.0)) * 0.5 / 25 * max(frame, 1.0 - frame)
    assert np.allclose(mesh.positions.max(axis=0) - still.positions.max(axis=0), room, atol=1e-6)
    assert np.allclose(still.positions.min(axis=0) - mesh.positions.min(axis=0), room, atol=1e-6)


def test_velocities_per_frame_and_their_scale(cloud, export_blurred):
    volume = blurred(with_velocity(cloud))
    volume.velocity_unit, volume.velocity_scale = "FRAME", 0.25
    assert export_blurred().description.meshes[0].flow == ("velocity", pytest.approx(0.25), 0.5)   # as in Cycles, without the shutter
    volume.velocity_scale = 0.0
    volume.update_tag()
    assert export_blurred().description.meshes[0].flow[0] == ""


def test_a_volume_without_motion_blur_of_its_shape_does_not_flow(cloud, export_blurred):
    blurred(with_velocity(cloud))
    bpy.data.objects["Sky"].cycles.use_deform_motion = False
    assert export_blurred().description.meshes[0].flow[0] == ""


def test_the_grid_of_velocities_can_have_another_name(cloud, export_blurred):
    blurred(with_velocity(cloud, "wind")).velocity_grid = "wind"
    assert export_blurred().description.meshes[0].flow[0] == "wind"


def test_three_grids_are_joined_to_velocities(cloud, export_blurred):
    part = np.zeros((9, 4, 3), dtype=np.float32)
    part[1, 1, 1] = 3.0
    more = np.zeros((9, 4, 3), dtype=np.float32)
    more[8, 2, 0] = -5.0
    blurred(cloud(a_grid(np.ones((9, 4, 3), dtype=np.float32)), a_grid(part, name="velocity_x"), a_grid(0.0 * part, name="velocity_y"),
                  a_grid(more, name="velocity_z")))
    mesh, = export_blurred().description.meshes
    assert mesh.flow[0] == "velocity"
    grid, = [grid for grid in mesh.grids if grid[0] == "velocity"]
    found = dense(grid, part.shape)
    assert np.array_equal(found[..., 0], part) and np.array_equal(found[..., 2], more) and not found[..., 1].any()


def test_velocities_that_do_not_fit_together_are_reported(cloud, export_blurred):
    other = a_grid(np.ones((2, 2, 2), dtype=np.float32), name="velocity_y")
    other.transform = vdb.createLinearTransform(0.1)
    same = [a_grid(np.ones((2, 2, 2), dtype=np.float32), name=name) for name in ("density", "velocity_x", "velocity_z")]
    blurred(cloud(*same, other))
    context = export_blurred()
    assert [text for name, text in context.warnings if name == "Sky"] == ["the grids of its velocity do not fit together; its motion is not blurred"]
    assert context.description.meshes[0].flow[0] == ""


def test_a_file_that_ends_early_is_reported(cloud, export_context, tmp_path):
    thing = cloud(a_grid(np.random.default_rng(3).random((20, 20, 20)).astype(np.float32)))
    whole = (tmp_path / "cloud.vdb").read_bytes()
    # Blender 3.4 itself ends when it reads such a file, so that this is a stand-in for its data.
    short = SimpleNamespace(filepath=str(tmp_path / "short.vdb"), packed_file=None, grids=SimpleNamespace(frame_filepath=str(tmp_path / "short.vdb")))
    for part in (0.3, 0.75):
        (tmp_path / "short.vdb").write_bytes(whole[:int(part * len(whole))])
        context = export_context()   # a new one: both parts can have the same message, which is reported once
        assert volumes._read(context, vdb, thing, short) == []
        assert [name for name, text in context.warnings if "cannot be read and the volume does not render" in text] == ["Sky"]


def test_missing_and_damaged_files_are_reported_and_the_rest_renders(cloud, build, warnings, tmp_path):
    build.object(build.mesh(), "Square", (0, 0, 0))
    thing = cloud()
    description, texts = warnings()
    assert len(description.instances) == 1 and len(texts) == 1 and "cannot be read" in texts[0]
    # Blender 3.4 itself aborts if a file ends in its header.
    for number, content in enumerate((b"", b"no volume")):
        path = tmp_path / f"damaged{number}.vdb"
        path.write_bytes(content)
        thing.data.filepath = str(path)
        description, texts = warnings()
        assert len(description.instances) == 1, number
        assert texts and "does not render" in texts[0], number


def test_the_names_of_a_principled_volume_are_sent(graph_of, build):
    material = build.material("Fog")
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeVolumePrincipled")
    node.inputs["Density Attribute"].default_value = "smoke"
    output = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], output.inputs["Volume"])
    sent = next(node for node in graph_of(material).nodes if node.type == "ShaderNodeVolumePrincipled")
    assert {item.name: item.text for item in sent.properties}["Density Attribute"] == "smoke"


def test_a_volume_without_material_is_a_principled_volume_and_one_without_volume_shader_is_invisible(cloud, export, build):
    thing = cloud(a_grid(np.ones((2, 2, 2), dtype=np.float32)))
    surface = thing.data.materials[0]
    tree = surface.node_tree
    tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], tree.nodes[0].inputs["Surface"])

    def graph():
        description = export()
        index, = description.objects[0].materials
        return description.materials[index].graph

    invisible = graph()
    assert invisible.surface.node < 0 <= invisible.volume.node
    assert [item.value[0] for item in invisible.nodes[0].inputs if item.socket == "Density"] == [0.0]
    thing.data.materials.clear()
    default = graph()
    assert default.surface.node < 0 <= default.volume.node
    assert [item.value[0] for item in default.nodes[0].inputs if item.socket == "Density"] == [1.0]
