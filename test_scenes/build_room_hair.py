"""`room_hair`: the scene `room` with a furry toy on the floor and a wig of long hair on the table.

The fur is particle hair; the wig is a hair curves object. Both are in the direct light.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import build_buddha as buddha
import build_room as room
import scene_tools as tools
from furniture import put
from implicit_mesh import Array, axis, ellipsoid, join, limb
from mathutils import Matrix
from shapes import cylinder, sphere

TOY = Matrix.Translation((0.58, 1.50, 0.0)) @ Matrix.Rotation(math.radians(-5), 4, "Z") @ Matrix.Scale(1.1, 4)
WIG = (-0.86, 0.64, room.TABLE_HEIGHT + 0.30)  # the centre of the head
WIG_TURN = 215.0  # degrees
HEAD = 0.095  # its radius
STRANDS, POINTS = 2600, 10  # of the wig; points of each strand
LENGTH, RADIUS = 0.36, 0.0007  # of the strands of the wig, in metres


def build() -> None:
    room.build()
    build_toy()
    build_wig()
    room.add_light_hints()


# --- The toy ---------------------------------------------------------------------------------------------------------

def bear(x: Array, y: Array, z: Array) -> Array:
    """A sitting bear that faces -Y."""
    d = ellipsoid(x, y, z, (0, 0, 0.13), (0.10, 0.085, 0.125))
    d = join(d, ellipsoid(x, y, z, (0, -0.01, 0.31), (0.085, 0.08, 0.078)), 0.03)
    d = join(d, ellipsoid(x, y, z, (0, -0.085, 0.29), (0.038, 0.032, 0.030)), 0.02)
    for side in (-1, 1):
        d = join(d, ellipsoid(x, y, z, (0.068 * side, 0, 0.375), (0.034, 0.018, 0.034)), 0.01)
        d = join(d, limb(x, y, z, (0.085 * side, -0.02, 0.21), (0.135 * side, -0.09, 0.12), 0.036, 0.032), 0.02)
        d = join(d, limb(x, y, z, (0.06 * side, -0.03, 0.05), (0.10 * side, -0.18, 0.045), 0.045, 0.042), 0.02)
    return d


def build_toy() -> None:
    fur = tools.principled("Fur", (0.74, 0.52, 0.29), roughness=0.5)
    body = buddha.add_part("Bear", bear, axis(-0.2, 0.2, 0.01), axis(-0.26, 0.12, 0.01), axis(-0.03, 0.45, 0.01), fur)
    body.matrix_world = TOY
    settings = body.modifiers.new("Fur", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count, settings.hair_length, settings.hair_step = "HAIR", 5000, 0.03, 3
    settings.use_advanced_hair = True
    settings.brownian_factor, settings.effector_weights.gravity = 0.004, 0.1
    settings.child_type, settings.rendered_child_count, settings.child_radius = "SIMPLE", 6, 0.012
    settings.render_step = 2
    settings.root_radius, settings.tip_radius, settings.radius_scale = 1.0, 0.1, 0.0014
    black = tools.principled("Button", (0.02, 0.015, 0.015), roughness=0.1)
    buttons = sphere(0.015, 24, 12).moved(0, -0.122, 0.300)
    for side in (-1, 1):
        buttons += sphere(0.012, 24, 12).moved(0.034 * side, -0.088, 0.335)
    put("Buttons", buttons.placed(TOY), black, True)


# --- The wig ---------------------------------------------------------------------------------------------------------

def strands() -> np.ndarray:
    """The points of all strands [strands, points, 3] around the centre of the head, whose face is towards -Y. A strand follows the head down to its
    equator and then falls in a wave that it has in common with its neighbours."""
    rng = np.random.default_rng(7)
    azimuth = rng.uniform(-0.75 * np.pi, 0.75 * np.pi, (STRANDS, 1))  # from the back
    root = rng.uniform(0.0, 1.3, (STRANDS, 1))  # from the vertical
    layer = HEAD * (1.02 + 0.16 * rng.random((STRANDS, 1)))
    along = np.linspace(0.0, LENGTH, POINTS) * rng.uniform(0.85, 1.0, (STRANDS, 1))
    curved = np.maximum(0.5 * np.pi - root, 0.0) * layer  # the length that lies on the head
    angle = root + np.minimum(along, curved) / layer
    fallen = np.maximum(along - curved, 0.0)
    lock = np.round(azimuth * 6.0)
    wave = 0.012 * np.minimum(fallen / 0.1, 1.0) * np.sin(40.0 * along + 2.4 * lock)
    turn = azimuth + 0.15 * (lock / 6.0 - azimuth) * fallen / 0.1
    radius = layer * np.sin(angle) + wave + 0.06 * fallen
    return np.stack([radius * np.sin(turn), radius * np.cos(turn), layer * np.cos(angle) - fallen], axis=-1)


def build_wig() -> None:
    wood = tools.principled("Limewood", (0.72, 0.55, 0.36), roughness=0.4)
    head = sphere(HEAD, 48, 24) + cylinder(0.045, -0.28, -0.05)
    foot = cylinder(0.09, -0.30, -0.275)
    put("Wig stand", (head + foot).moved(*WIG, turn=WIG_TURN), wood, True)
    points = np.round(strands() * 8192.0) / 8192.0  # Rounded numbers are compressed better.
    guide = bpy.data.meshes.new("Strands")
    numbers = np.arange(STRANDS * POINTS).reshape(STRANDS, POINTS)
    edges = np.stack([numbers[:, :-1], numbers[:, 1:]], axis=-1)
    guide.from_pydata(points.reshape(-1, 3).tolist(), edges.reshape(-1, 2).tolist(), [])
    source = tools.link(bpy.data.objects.new("Strands", guide))
    source.hide_render = source.hide_viewport = True
    wig = tools.link(bpy.data.objects.new("Wig", bpy.data.hair_curves.new("Wig")))
    wig.matrix_world = Matrix.Translation(WIG) @ Matrix.Rotation(math.radians(WIG_TURN), 4, "Z")
    hair = tools.principled("Hair", (0.30, 0.10, 0.04), roughness=0.35)
    wig.data.materials.append(hair)
    wig.modifiers.new("Strands", "NODES").node_group = curves_of(source, hair)


def curves_of(source: bpy.types.Object, material: bpy.types.Material) -> bpy.types.NodeTree:
    """Geometry nodes that return the edges of a mesh as hair."""
    tree = bpy.data.node_groups.new("Strands", "GeometryNodeTree")
    if hasattr(tree, "interface"):
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    chain = [tree.nodes.new(kind) for kind in (
        "GeometryNodeObjectInfo", "GeometryNodeMeshToCurve", "GeometryNodeSetCurveRadius", "GeometryNodeSetMaterial", "NodeGroupOutput")]
    chain[0].inputs["Object"].default_value = source
    chain[2].inputs["Radius"].default_value = RADIUS
    chain[3].inputs["Material"].default_value = material
    for number, (here, there) in enumerate(zip(chain, chain[1:])):
        there.location.x = 200 * (number + 1)
        tree.links.new(here.outputs["Geometry" if number == 0 else 0], there.inputs[0])
    return tree


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
