"""Particle Info and From Instancer: instances that emit what these nodes give are rendered with both engines, which differ by at most 1e-3."""

import bpy
import numpy as np
import pytest
from plane_view import look_at_plane, render

SIZE, MOST = 48, 1e-3
PARTICLE_OUTPUTS = ("Index", "Random", "Age", "Lifetime", "Location", "Size", "Velocity", "Angular Velocity")


def emitting(tree, output):
    """Let the material emit the value, with negative values shifted to be visible."""
    emission, shift = (tree.nodes.new(f"ShaderNode{name}") for name in ("Emission", "VectorMath"))
    shift.operation = "MULTIPLY_ADD"
    shift.inputs[1].default_value, shift.inputs[2].default_value = (0.1,) * 3, (1.5,) * 3
    tree.links.new(output, shift.inputs[0])
    tree.links.new(shift.outputs[0], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])


@pytest.fixture
def leaf(build):
    """A square with a UV map, outside the view."""
    mesh = build.mesh("Leaf", ((-0.1, -0.1, 0), (0.1, -0.1, 0), (0.1, 0.1, 0), (-0.1, 0.1, 0)), ((0, 1, 2, 3),))
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    mesh.materials.append(build.material())
    return build.object(mesh, "Leaf", (5.0, 0.0, 0.0))


def particles(build, leaf, **settings):
    """Moving particles of a square that does not render itself, born in frames 0 to 5. Their leaves have different sizes."""
    mesh = build.mesh("Ground", ((0.1, 0.1, 0), (0.9, 0.1, 0), (0.9, 0.9, 0), (0.1, 0.9, 0)), ((0, 1, 2, 3),))
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", [0.2, 0.1, 0.9, 0.1, 0.9, 0.8, 0.2, 0.8])
    ground = build.object(mesh, "Ground")
    system = ground.modifiers.new("Particles", "PARTICLE_SYSTEM").particle_system.settings
    defaults = {"count": 12, "frame_start": 0, "frame_end": 5, "lifetime": 40, "lifetime_random": 0.5, "render_type": "OBJECT", "instance_object": leaf,
                "particle_size": 0.6, "size_random": 0.7, "use_rotations": True, "use_dynamic_rotation": True, "angular_velocity_mode": "GLOBAL_Z",
                "angular_velocity_factor": 2.0, "normal_factor": 0.2, "factor_random": 0.3, "rotation_mode": "NONE"}
    for name, value in (defaults | settings).items():
        setattr(system, name, value)
    ground.show_instancer_for_render = False
    look_at_plane(bpy.context.scene, SIZE)
    bpy.context.scene.frame_set(6)


def compared(folder):
    """Whether the leaves have the same colours in both engines, and the number of different colours. Two pixels at edges may see a leaf in one engine only."""
    cycles, ajar = (render(bpy.context.scene, engine, folder) for engine in ("CYCLES", "AJAR"))
    seen, seen_by_one = (cycles > 0).any(1) & (ajar > 0).any(1), (cycles > 0).any(1) ^ (ajar > 0).any(1)
    assert seen.sum() > 50
    equal = seen_by_one.sum() <= 2 and bool((np.abs(cycles - ajar)[seen] <= MOST).all())
    return equal, len(np.unique(np.round(ajar[seen], 3), axis=0))


@pytest.mark.parametrize("output", PARTICLE_OUTPUTS)
def test_particle_info_is_as_in_cycles(build, leaf, output, tmp_path):
    particles(build, leaf)
    tree = leaf.data.materials[0].node_tree
    emitting(tree, tree.nodes.new("ShaderNodeParticleInfo").outputs[output])
    equal, values = compared(tmp_path)
    assert equal and values > (0 if output == "Angular Velocity" else 5)


def test_children_of_particles_have_the_values_of_no_particle(build, leaf, tmp_path):
    particles(build, leaf, child_type="SIMPLE", child_nbr=3, rendered_child_count=3)
    tree = leaf.data.materials[0].node_tree
    emitting(tree, tree.nodes.new("ShaderNodeParticleInfo").outputs["Index"])
    assert compared(tmp_path)[0]


@pytest.mark.parametrize("node_type, output", (("ShaderNodeTexCoord", "Generated"), ("ShaderNodeTexCoord", "UV"), ("ShaderNodeUVMap", "UV")))
def test_coordinates_of_the_instancer_are_as_in_cycles(build, leaf, node_type, output, tmp_path):
    particles(build, leaf, physics_type="NO")
    tree = leaf.data.materials[0].node_tree
    node = tree.nodes.new(node_type)
    node.from_instancer = True
    emitting(tree, node.outputs[output])
    equal, values = compared(tmp_path)
    assert equal and values > 5


def test_without_an_instancer_all_values_are_zero(build, leaf, tmp_path):
    look_at_plane(bpy.context.scene, SIZE)
    leaf.location = (0.5, 0.5, 0.0)
    tree = leaf.data.materials[0].node_tree
    emitting(tree, tree.nodes.new("ShaderNodeParticleInfo").outputs["Random"])
    assert compared(tmp_path)[0]


def test_values_of_instancers_are_read_only_for_materials_that_use_them(build, leaf, export_context):
    particles(build, leaf)
    assert not export_context().uses_origins
    leaf.data.materials[0].node_tree.nodes.new("ShaderNodeParticleInfo")
    assert export_context().uses_origins
