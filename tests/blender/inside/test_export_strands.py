"""Tests of the export of hair: particle systems and hair curves become strands."""

import bpy
import numpy as np
import pytest
from ajar_render import compat
from ajar_render.ajar_module import ajar


@pytest.fixture
def head(build):
    """A square with upright hair: the particle settings and the object."""
    square = build.mesh()
    square.uv_layers.new(name="Scalp")
    for name in ("Skin", "Hair"):
        square.materials.append(build.material(name))
    thing = build.object(square, "Head", (3, 2, 1))
    settings = thing.modifiers.new("Hair", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count, settings.hair_length, settings.display_step = "HAIR", 9, 0.5, 3
    settings.material, settings.use_close_tip = 2, True
    settings.root_radius, settings.tip_radius, settings.radius_scale = 1.0, 0.5, 0.1
    return settings, thing


def strands_of(description: ajar.SceneDescription) -> list[ajar.MeshDescription]:
    return [mesh for mesh in description.meshes if len(mesh.strands)]


def test_particle_hair_is_strands_on_its_emitter(head, export):
    description = export()
    hair, = strands_of(description)
    assert len(description.meshes) == len(description.objects) == len(description.instances) == 2
    assert list(hair.strands) == [9 * i for i in range(9)]
    points = hair.positions.reshape(9, 9, 3)
    assert np.all((points[:, 0, :2] >= -1e-5) & (points[:, 0, :2] <= 1 + 1e-5)) and np.allclose(points[:, 0, 2], 0, atol=1e-5)   # in the local space of the emitter
    assert np.allclose(np.linalg.norm(points[:, -1] - points[:, 0], axis=1), 0.5, atol=0.05)
    assert np.allclose(hair.radii.reshape(9, 9)[:, 0], 0.05) and np.allclose(hair.radii.reshape(9, 9)[:, -1], 0.0)
    assert np.allclose(hair.radii.reshape(9, 9)[:, 4], 0.0375, atol=1e-3)
    assert list(hair.material_slots) == [1] * 9
    scalp, = hair.attributes
    assert (scalp.name, scalp.domain, hair.active_uv) == ("Scalp", ajar.Domain.Face, "Scalp")
    assert np.allclose(scalp.values.reshape(9, 2), points[:, 0, :2], atol=1e-3)   # the UV map of the square has the coordinates of its plane
    assert (hair.strand_shape, hair.strand_subdivisions) == (ajar.StrandShape.Ribbon, 2)
    rows = [np.array(instance.world_from_object).reshape(3, 4)[:, 3] for instance in description.instances]
    assert np.allclose(rows, [(3, 2, 1)] * 2)


def test_shape_of_hair_is_a_setting_of_the_scene(head, export, scene):
    if not hasattr(scene, "cycles_curves"):
        pytest.skip("Cycles is not enabled")
    scene.cycles_curves.shape, scene.cycles_curves.subdivisions = "THICK", 3
    hair, = strands_of(export())
    assert (hair.strand_shape, hair.strand_subdivisions) == (ajar.StrandShape.Round, 3)


def test_emitters_and_their_hair_can_be_hidden(head, export, scene):
    _, thing = head
    thing.show_instancer_for_viewport = False
    description = export()
    assert len(description.objects) == 1 and len(strands_of(description)) == 1
    thing.show_instancer_for_viewport = True
    scene.view_layers[0].use_strand = False
    assert not strands_of(export())
    scene.view_layers[0].use_strand = True
    thing.modifiers["Hair"].show_viewport = False
    assert not strands_of(export())


def test_child_hairs_replace_their_parents(head, export):
    settings, _ = head
    settings.child_type, settings.child_nbr = "SIMPLE", 4
    hair, = strands_of(export())
    assert len(hair.strands) == 36
    assert len(hair.attributes[0].values) == 36


def test_children_that_are_cut_end_at_their_tip(head, export):
    settings, _ = head
    settings.child_type, settings.child_nbr, settings.child_length = "SIMPLE", 4, 0.5   # Blender gives the points after the tip as the origin of the world
    settings.tip_radius, settings.use_close_tip = 0.25, False
    hair, = strands_of(export())
    first = [*hair.strands, len(hair.positions)]
    assert len(hair.strands) == len(hair.material_slots) == len(hair.attributes[0].values) == 36
    for begin, end in zip(first, first[1:], strict=False):
        points = hair.positions[begin:end]
        assert 2 <= end - begin < 9
        assert 0.2 < np.linalg.norm(np.diff(points, axis=0), axis=1).sum() < 0.35
        assert np.all(points[:, 2] >= -1e-4) and np.allclose(hair.radii[[begin, end - 1]], (0.05, 0.0125), atol=1e-5)


def test_children_without_a_length_are_nothing(head, export):
    settings, _ = head
    settings.child_type, settings.child_nbr, settings.child_length = "SIMPLE", 4, 0.0
    assert not strands_of(export())


def test_instances_share_their_hair(head, export, build):
    _, thing = head
    collection = bpy.data.collections.new("Heads")
    collection.objects.link(thing)
    bpy.context.scene.collection.objects.unlink(thing)
    for x in range(3):
        empty = build.object(None, f"There {x}", (x, 0, 0))
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
    description = export()
    assert len(description.meshes) == 2 and len(description.instances) == 6


def group(*names: str) -> list[bpy.types.Node]:
    """A chain of geometry nodes; the last is the output of the group."""
    tree = bpy.data.node_groups.new("Grow", "GeometryNodeTree")
    if hasattr(tree, "interface"):
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    made = [tree.nodes.new(name) for name in (*names, "NodeGroupOutput")]
    for here, there in zip(made, made[1:], strict=False):
        tree.links.new(here.outputs[0], there.inputs[0])
    return made


@pytest.fixture
def wig(build):
    """A hair curves object with one strand."""
    data = bpy.data.hair_curves.new("Hair")
    thing = build.object(data, "Wig")
    data.materials.append(build.material())
    _line, radius, _ = made = group("GeometryNodeCurvePrimitiveLine", "GeometryNodeSetCurveRadius")
    radius.inputs["Radius"].default_value = 0.25
    thing.modifiers.new("Grow", "NODES").node_group = made[0].id_data
    return thing


def shown_by_collection(thing, build):
    collection = bpy.data.collections.new("Wigs")
    collection.objects.link(thing)
    bpy.context.scene.collection.objects.unlink(thing)
    for x in range(3):
        empty = build.object(None, f"There {x}", (x, 0, 0))
        empty.instance_type, empty.instance_collection = "COLLECTION", collection


def shown_by_nodes(thing, build):
    line, *_ = made = group("GeometryNodeMeshLine", "GeometryNodeMeshToPoints", "GeometryNodeInstanceOnPoints")
    line.inputs["Count"].default_value = 3
    tree = line.id_data
    info = tree.nodes.new("GeometryNodeObjectInfo")
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = thing, True
    tree.links.new(info.outputs["Geometry"], made[2].inputs["Instance"])
    build.object(build.mesh(), "Where").modifiers.new("Show", "NODES").node_group = tree
    thing.hide_viewport = thing.hide_render = True


def shown_by_particles(thing, build):
    settings = build.object(build.mesh(), "Where").modifiers.new("Show", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count, settings.frame_start, settings.frame_end = "EMITTER", 3, 1, 1
    settings.physics_type, settings.render_type, settings.instance_object = "NO", "OBJECT", thing
    bpy.context.scene.frame_set(2)
    thing.hide_viewport = thing.hide_render = True


@pytest.mark.parametrize("show", [shown_by_collection, shown_by_nodes, shown_by_particles])
def test_instances_of_hair_curves_share_their_strands(wig, build, export, show):
    show(wig, build)
    description = export()
    hair, = strands_of(description)
    shown = [instance for instance in description.instances if description.meshes[description.objects[instance.object].mesh].name == hair.name]
    assert len(shown) == 3 and len({tuple(instance.world_from_object) for instance in shown}) == 3


def test_poly_curves_are_straight_as_in_cycles_since_5_0(wig, export, monkeypatch):
    line, radius, _ = group("GeometryNodeCurvePrimitiveLine", "GeometryNodeSetCurveRadius")
    wig.modifiers[0].node_group = line.id_data
    for straight, shape in ((False, ajar.StrandShape.Ribbon), (True, ajar.StrandShape.Linear)):
        monkeypatch.setattr(compat, "poly_curves_are_straight", lambda straight=straight: straight)
        hair, = strands_of(export())
        assert hair.strand_shape == shape
    tree = line.id_data
    smooth = tree.nodes.new("GeometryNodeCurveSplineType")
    smooth.spline_type = "CATMULL_ROM"
    tree.links.new(line.outputs[0], smooth.inputs[0])
    tree.links.new(smooth.outputs[0], radius.inputs[0])
    hair, = strands_of(export())
    assert hair.strand_shape == ajar.StrandShape.Ribbon


def test_a_million_strands_are_exported(wig, export):
    line, *_ = made = group("GeometryNodeMeshLine", "GeometryNodeMeshToPoints", "GeometryNodeInstanceOnPoints", "GeometryNodeRealizeInstances")
    line.inputs["Count"].default_value = 1_000_000
    tree = line.id_data
    tree.links.new(tree.nodes.new("GeometryNodeCurvePrimitiveLine").outputs[0], made[2].inputs["Instance"])
    wig.modifiers[0].node_group = tree
    hair, = strands_of(export())
    assert len(hair.strands) == 1_000_000 and hair.strands[-1] == 1_999_998


def test_a_wig_without_strands_is_nothing(build, export):
    build.object(bpy.data.hair_curves.new("Hair"), "Wig")
    assert not export().objects


def test_hair_curves_are_strands(wig, export):
    hair, = strands_of(export())
    assert list(hair.strands) == [0]
    assert np.allclose(hair.positions, [(0, 0, 0), (0, 0, 1)])
    assert np.allclose(hair.radii, 0.25)
