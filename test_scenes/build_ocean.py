"""`ocean`: a buoy in the open sea.

The sea is a grid of 64 faces that adaptive subdivision divides to the size of a pixel and that waves displace: a swell of 14 m, wind waves, and
ripples down to 20 cm. A rock is a box that adaptive subdivision makes round and a noise makes rough. Y points away from the eye.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))

import scene_tools as tools
from furniture import put
from images import pack, sky
from shapes import cylinder, lathe

TO_SUN = (-0.7, -0.35, 0.55)
# Wavelength and height in metres, direction in degrees, distortion of each train of waves.
WAVES = ((14.0, 0.55, 80.0, 0.6), (6.5, 0.22, 110.0, 1.2), (2.7, 0.09, 60.0, 2.0), (1.1, 0.035, 95.0, 3.0), (0.42, 0.011, 75.0, 4.0), (0.2, 0.004, 120.0, 5.0))
FROM_TEXTURE = 2.0 * math.pi / 20.0   # wavelength of a wave texture of scale 1


def build() -> None:
    scene = tools.start_scene(640, 360)
    scene.cycles.feature_set = "EXPERIMENTAL"   # adaptive subdivision before Blender 5
    tools.environment(scene, pack("Sky", sky(TO_SUN), hdr=True), 0.9)
    tools.sun_light("Sun", [-c for c in TO_SUN], 8.0, (1.0, 0.82, 0.6), angle=math.radians(1.5))
    build_sea()
    build_rock()
    build_buoy()
    tools.camera((0.0, -9.0, 2.4), (0.6, 14.0, 0.7), lens=28.0)


def subdivide(thing: bpy.types.Object, kind: str) -> None:
    modifier = thing.modifiers.new("Subdivision", "SUBSURF")
    modifier.subdivision_type = kind
    modifier.levels = modifier.render_levels = 0   # Blender before 4.5 divides what the levels leave
    thing.cycles.use_adaptive_subdivision = True
    thing.data.polygons.foreach_set("use_smooth", [True] * len(thing.data.polygons))


def displace(material: bpy.types.Material, height: bpy.types.NodeSocket, scale: float) -> None:
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeDisplacement")
    node.inputs["Midlevel"].default_value, node.inputs["Scale"].default_value = 0.0, scale
    tree.links.new(height, node.inputs["Height"])
    tree.links.new(node.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Displacement"])
    material.cycles.displacement_method = "DISPLACEMENT"


def build_sea() -> None:
    water = tools.principled("Water", (0.012, 0.035, 0.04), roughness=0.12)
    tree = water.node_tree
    place = tree.nodes.new("ShaderNodeTexCoord").outputs["Object"]
    total = None
    for length, height, direction, distortion in WAVES:
        turned, wave, scaled = (tree.nodes.new(kind) for kind in ("ShaderNodeMapping", "ShaderNodeTexWave", "ShaderNodeMath"))
        turned.inputs["Rotation"].default_value = (0.0, 0.0, math.radians(-direction))
        wave.wave_profile = "SIN"
        wave.inputs["Scale"].default_value = FROM_TEXTURE / length
        wave.inputs["Distortion"].default_value = distortion
        wave.inputs["Detail"].default_value = 1.0
        wave.inputs["Detail Scale"].default_value = 1.5
        scaled.operation = "MULTIPLY_ADD"
        scaled.inputs[1].default_value, scaled.inputs[2].default_value = height, -0.5 * height
        tree.links.new(place, turned.inputs["Vector"])
        tree.links.new(turned.outputs["Vector"], wave.inputs["Vector"])
        tree.links.new(wave.outputs["Fac"], scaled.inputs[0])
        if total is not None:
            tree.links.new(total, scaled.inputs[2])
        total = scaled.outputs[0]
    displace(water, total, 1.0)
    edges = [-400.0, -120.0, -40.0, -12.0, 0.0, 12.0, 40.0, 120.0, 400.0]
    vertices = [(x, y, 0.0) for y in (-60.0, -25.0, -8.0, 4.0, 18.0, 45.0, 110.0, 300.0, 800.0) for x in edges]
    faces = [(9 * j + i, 9 * j + i + 1, 9 * j + i + 10, 9 * j + i + 9) for j in range(8) for i in range(8)]
    subdivide(tools.add_mesh("Sea", vertices, faces, water), "SIMPLE")


def build_rock() -> None:
    stone = tools.diffuse("Stone", (0.22, 0.19, 0.17))
    tree = stone.node_tree
    noise = tree.nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = 0.9, 6.0
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], noise.inputs["Vector"])
    displace(stone, noise.outputs["Fac"], 2.2)
    rock = tools.add_box("Rock", (-1.8, -1.2, -1.6), (1.8, 1.4, 1.2), stone)
    subdivide(rock, "CATMULL_CLARK")
    rock.location, rock.rotation_euler = (-4.6, 8.0, -0.6), (0.1, -0.15, 0.5)


def build_buoy() -> None:
    paint = tools.principled("Red paint", (0.55, 0.035, 0.02), roughness=0.3)
    body = lathe([(0.0, -0.5), (0.55, -0.4), (0.75, -0.05), (0.75, 0.25), (0.55, 0.42), (0.16, 0.5), (0.1, 1.7), (0.0, 1.75)], 48)
    put("Buoy", body.moved(2.3, 3.5, 0.1), paint, True)
    lamp = tools.principled("Lantern", (0.85, 0.8, 0.6), roughness=0.2)
    put("Lantern", cylinder(0.17, 1.75, 2.05, 32).moved(2.3, 3.5, 0.1), lamp, True)


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
