"""Runs in the Python of a bpy wheel, as linking_inside.py: suns of all sizes and with Light Falloff, and a colour ramp that is steep.

    python suns_inside.py ZIP OUT
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
import linking_inside as stage


def small_sun(scene: bpy.types.Scene) -> None:
    stage.lamp("SUN", 2.0, rotation=(0.6, 0.7, 0.0), size=0.3)


def large_sun(scene: bpy.types.Scene) -> None:
    stage.lamp("SUN", 2.0, rotation=(0.6, 0.7, 0.0), size=2.5)


def sun_of_half_the_sky(scene: bpy.types.Scene) -> None:
    stage.lamp("SUN", 2.0, rotation=(1.9, 0.2, 0.0), size=math.pi)


def suns_with_falloff(scene: bpy.types.Scene) -> None:
    """Suns of three directions, each with an output of Light Falloff. In 4.2 the sun of Quadratic alone shines, from 4.5 on all three do."""
    for turn, output in enumerate(("Quadratic", "Linear", "Constant")):
        sun = stage.lamp("SUN", 1.0, rotation=(0.7, 0.0, 2.0 * turn))
        sun.data.use_nodes = True
        tree = sun.data.node_tree
        falloff = tree.nodes.new("ShaderNodeLightFalloff")
        falloff.inputs["Strength"].default_value, falloff.inputs["Smooth"].default_value = 2.0, 0.5
        tree.links.new(falloff.outputs[output], next(node for node in tree.nodes if node.type == "EMISSION").inputs["Strength"])


def steep_ramp(scene: bpy.types.Scene) -> None:
    """Bright bands of the generated coordinates, between two entries of the table of the ramp."""
    tree = stage.named("Floor").data.materials[0].node_tree
    place, ramp, emission = (tree.nodes.new(kind) for kind in ("ShaderNodeTexCoord", "ShaderNodeValToRGB", "ShaderNodeEmission"))
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.3005, 0.3015
    ramp.color_ramp.elements.new(0.303).color = (0.0, 0.0, 0.0, 1.0)
    emission.inputs["Strength"].default_value = 20.0
    tree.links.new(place.outputs["Generated"], ramp.inputs[0])
    tree.links.new(ramp.outputs["Color"], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL").inputs["Surface"])


if __name__ == "__main__":
    stage.main((small_sun, large_sun, sun_of_half_the_sky, suns_with_falloff, steep_ramp))
