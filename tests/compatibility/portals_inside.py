"""Runs in the Python of a bpy wheel of Blender 4.2 or later: as linking_inside.py, with ray portals, and from Blender 5.2 on with attributes that Raycast
samples at the hit.

    python portals_inside.py ZIP OUT        ZIP: of the extension; "-": the add-on of the profile
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
import linking_inside as stage


def sheet(place: tuple[float, float, float], size: tuple[float, float, float]) -> bpy.types.NodeTree:
    """A thin box whose material is empty. Returns its tree."""
    tree = stage.box("Sheet", place, size, (0.8, 0.8, 0.8)).data.materials[0].node_tree
    tree.nodes.remove(tree.nodes["Diffuse BSDF"])
    return tree


def plane(place: tuple[float, float, float], size: float, tilt: float) -> bpy.types.NodeTree:
    """A square, upright if `tilt` is a right angle. Returns the tree of its empty material."""
    tree = sheet(place, (size, size, 1.0))
    thing = stage.named("Sheet")
    mesh = bpy.data.meshes.new("Square")
    mesh.from_pydata([(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)], [], [(0, 1, 2, 3)])
    mesh.materials.append(thing.data.materials[0])
    thing.data = mesh
    thing.rotation_euler = (tilt, 0.0, 0.0)
    return tree


def output(tree: bpy.types.NodeTree, socket: bpy.types.NodeSocket) -> None:
    tree.links.new(socket, tree.nodes["Material Output"].inputs["Surface"])


def portal(tree: bpy.types.NodeTree, offset: tuple[float, float, float] | None = None, turn: float = 0.0,
           color: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> bpy.types.Node:
    """A Ray Portal to the same place moved by `offset`; rays are turned about the z axis by `turn`."""
    node, geometry = tree.nodes.new("ShaderNodeBsdfRayPortal"), tree.nodes.new("ShaderNodeNewGeometry")
    node.inputs["Color"].default_value = (*color, 1.0)
    if offset is not None:
        moved = tree.nodes.new("ShaderNodeVectorMath")
        moved.inputs[1].default_value = offset
        tree.links.new(geometry.outputs["Position"], moved.inputs[0])
        tree.links.new(moved.outputs[0], node.inputs["Position"])
    if turn:
        back, turned = tree.nodes.new("ShaderNodeVectorMath"), tree.nodes.new("ShaderNodeVectorRotate")
        back.operation = "SCALE"
        back.inputs["Scale"].default_value = -2.0   # the length of a direction does not matter
        turned.inputs["Angle"].default_value = turn
        tree.links.new(geometry.outputs["Incoming"], back.inputs[0])
        tree.links.new(back.outputs[0], turned.inputs["Vector"])
        tree.links.new(turned.outputs[0], node.inputs["Direction"])
    return node


def lit() -> None:
    stage.lamp("SUN", 1.5, rotation=(0.6, 0.7, 0.0), size=0.1)
    stage.lamp("AREA", 250.0, (3.0, -1.0, 4.0), (0.0, math.radians(40.0), 0.0), 2.0)


def another_place(scene: bpy.types.Scene) -> None:
    lit()
    tree = plane((0.0, -2.0, 1.2), 2.6, math.radians(90.0))
    output(tree, portal(tree, (2.0, 0.5, 0.3)).outputs[0])


def another_direction(scene: bpy.types.Scene) -> None:
    lit()
    tree = plane((0.0, -2.0, 1.2), 2.6, math.radians(90.0))
    output(tree, portal(tree, (-4.0, -1.0, 0.5), -0.8).outputs[0])


def direction_alone(scene: bpy.types.Scene) -> None:
    lit()
    tree = plane((0.0, -2.0, 1.2), 2.6, math.radians(90.0))
    output(tree, portal(tree, None, 0.35).outputs[0])


def tinted(scene: bpy.types.Scene) -> None:
    lit()
    tree = sheet((0.0, -2.0, 1.2), (1.6, 1.0, 1.6))
    output(tree, portal(tree, None, 0.0, (0.9, 0.5, 0.2)).outputs[0])


def mixed(scene: bpy.types.Scene) -> None:
    """Two portals and a diffuse closure. With a Transparent BSDF, Cycles lets shadow rays pass as well, and counts light behind the surface twice."""
    lit()
    tree = plane((0.0, -2.0, 1.2), 2.6, math.radians(90.0))
    diffuse, first, second = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfDiffuse", "MixShader", "MixShader"))
    diffuse.inputs["Color"].default_value = (0.2, 0.7, 0.3, 1.0)
    first.inputs[0].default_value, second.inputs[0].default_value = 0.4, 0.3
    tree.links.new(portal(tree, (2.0, 0.5, 0.3)).outputs[0], first.inputs[1])
    tree.links.new(portal(tree, None, 0.35, (0.9, 0.6, 0.3)).outputs[0], first.inputs[2])
    tree.links.new(first.outputs[0], second.inputs[1])
    tree.links.new(diffuse.outputs[0], second.inputs[2])
    output(tree, second.outputs[0])


def between_lamp_and_floor(scene: bpy.types.Scene) -> None:
    stage.lamp("AREA", 300.0, (0.0, 0.0, 6.0), size=3.0)
    stage.lamp("POINT", 200.0, (-3.0, -2.0, 3.0), size=0.0)
    tree = plane((0.3, -1.0, 2.6), 3.0, 0.0)
    output(tree, portal(tree).outputs[0])


def depth_on_transparent_film(scene: bpy.types.Scene) -> None:
    lit()
    scene.render.film_transparent = True
    tree = sheet((0.0, -2.0, 1.2), (1.6, 1.0, 1.6))
    output(tree, portal(tree, (0.0, 0.5, 3.0)).outputs[0])
    tree = stage.named("Left").data.materials[0].node_tree
    path, emission = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeEmission")
    tree.links.new(path.outputs["Portal Depth"], emission.inputs["Strength"])
    output(tree, emission.outputs[0])


def attributes_at_the_hit(scene: bpy.types.Scene) -> None:
    """The floor shows colours of what is above it: a colour with its alpha, a number, an integer and a vector."""
    lit()
    for name, shift in (("Left", 0.0), ("Right", 0.3)):
        mesh = stage.named(name).data
        tint, heat = mesh.attributes.new("tint", "FLOAT_COLOR", "CORNER"), mesh.attributes.new("heat", "FLOAT", "POINT")
        count, way = mesh.attributes.new("count", "INT", "FACE"), mesh.attributes.new("way", "FLOAT_VECTOR", "POINT")
        for i, item in enumerate(tint.data):
            item.color = (0.2 + 0.1 * (i % 4), shift, 0.5, 0.25 + shift)
        for i, item in enumerate(heat.data):
            item.value = 0.1 * i
        for i, item in enumerate(count.data):
            item.value = i
        for i, item in enumerate(way.data):
            item.vector = (0.1 * i, 0.5, shift)
    tree = stage.named("Floor").data.materials[0].node_tree
    tree.nodes.remove(tree.nodes["Diffuse BSDF"])
    cast = tree.nodes.new("ShaderNodeRaycast")
    cast.inputs["Length"].default_value = 5.0
    for kind, name in (("RGBA", "tint"), ("FLOAT", "heat"), ("FLOAT", "count"), ("VECTOR", "way"), ("FLOAT", "unknown"), ("FLOAT", "tint")):
        cast.sample_attribute_items.new(kind, name)
    names = ("tint", "heat", "count", "way", "unknown", "tint")
    for i, name in enumerate(names):
        cast.inputs[f"Value_{i}"].default_value = name
    total = None
    for socket in cast.outputs:
        if not socket.identifier.startswith("Attribute_"):
            continue
        added = tree.nodes.new("ShaderNodeVectorMath")
        added.operation = "MULTIPLY_ADD"
        tree.links.new(socket, added.inputs[0])
        added.inputs[1].default_value = (0.3, 0.3, 0.3)
        if total is not None:
            tree.links.new(total, added.inputs[2])
        total = added.outputs[0]
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(total, emission.inputs["Color"])
    output(tree, emission.outputs[0])


SCENES: tuple[Callable[[bpy.types.Scene], None], ...] = (another_place, another_direction, tinted, mixed, between_lamp_and_floor)
if bpy.app.version >= (5, 0, 0):
    # Blender 4.2 has no output Portal Depth, and shows another image where only the direction is linked (docs/agreement.md).
    SCENES += (direction_alone, depth_on_transparent_film)
if hasattr(bpy.types, "NodeRaycastSampleAttributeItems"):
    SCENES += (attributes_at_the_hit,)

if __name__ == "__main__":
    stage.main(SCENES)
