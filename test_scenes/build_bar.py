"""`bar`: a polished bar at night, which three bulbs in globes of clear glass illuminate.

No lamp can be connected to a surface by a straight line: all light passes glass before it reaches a surface, and many of these surfaces are glossy or
glass. Y points from the eye to the shelves.
"""

from __future__ import annotations

import math
import random
import sys
from pathlib import Path

from mathutils import Matrix

sys.path.insert(0, str(Path(__file__).resolve().parent))

import scene_tools as tools
from furniture import bottle, bowl, put, tumbler, wine_glass
from images import pack, wood
from shapes import Shape, block, cylinder, four_walls, lathe, sphere

LEFT, RIGHT, NEAR, FAR, CEILING = -2.4, 2.4, -2.9, 1.55, 2.7
COUNTER_NEAR, COUNTER_FAR, COUNTER = -0.05, 0.58, 1.06
GLOBES = [(-0.86, 0.30, 1.79), (0.02, 0.30, 1.79), (0.90, 0.30, 1.79)]
GLOBE, GLASS_WALL, BULB = 0.115, 0.0025, 0.022
SHELVES = (1.22, 1.63, 2.04)
SHELF_NEAR = FAR - 0.24


def build() -> None:
    tools.start_scene(640, 480)
    oak = tools.principled("Oak", (1, 1, 1), roughness=0.16)
    tools.image_texture(oak, pack("Oak", wood((0.24, 0.12, 0.06), (0.48, 0.28, 0.15), 256, seed=11)), socket="Base Color")
    chrome = tools.principled("Chrome", (0.78, 0.78, 0.80), roughness=0.10, metallic=1.0)
    brass = tools.principled("Brass", (0.83, 0.61, 0.26), roughness=0.16, metallic=1.0)
    clear = tools.glass("Clear glass", ior=1.5)

    build_room(oak)
    build_counter(oak, brass)
    build_shelves(oak, clear)
    build_things(clear, chrome)
    build_globes(clear, brass)
    tools.camera((0.40, -1.50, 1.62), (0.05, 0.6, 1.40), lens=30.0)


def build_room(oak) -> None:
    plaster = tools.diffuse("Plaster", (0.56, 0.46, 0.38))
    floor = tools.principled("Floor", (0.16, 0.15, 0.15), roughness=0.14)
    put("Floor", block((LEFT, NEAR, -0.1), (RIGHT, FAR, 0.0)), floor)
    put("Ceiling", block((LEFT, NEAR, CEILING), (RIGHT, FAR, CEILING + 0.1)), tools.diffuse("Ceiling", (0.60, 0.56, 0.50)))
    put("Walls", four_walls((LEFT, NEAR), (RIGHT, FAR), CEILING), plaster)
    glaze = tools.principled("Glazed tiles", (0.05, 0.16, 0.14), roughness=0.09)
    wide, high, joint = 0.20, 0.10, 0.004
    tiles = Shape()
    for row in range(int(CEILING / high)):
        for column in range(-13, 13):
            low = max(LEFT, column * wide + (wide / 2 if row % 2 else 0.0))
            right = min(RIGHT, (column + 1) * wide + (wide / 2 if row % 2 else 0.0))
            if right - low > 0.02:
                tiles += block((low, FAR - 0.012, row * high), (right - joint, FAR, (row + 1) * high - joint), 0.003)
    put("Tiles", tiles, glaze)


def build_counter(oak, brass) -> None:
    put("Counter", block((LEFT, COUNTER_NEAR, COUNTER - 0.05), (RIGHT, COUNTER_FAR, COUNTER), 0.008), oak, metres=0.9)
    panels = block((LEFT, COUNTER_NEAR + 0.10, 0.0), (RIGHT, COUNTER_FAR - 0.05, COUNTER - 0.05))
    for k in range(8):
        x = LEFT + 0.05 + 0.59 * k
        panels += block((x, COUNTER_NEAR + 0.075, 0.15), (x + 0.49, COUNTER_NEAR + 0.10, COUNTER - 0.12), 0.012)
    put("Front", panels, oak, metres=0.9)
    rail = cylinder(0.02, LEFT, RIGHT).placed(Matrix.Rotation(math.pi / 2, 4, "Y"))
    put("Rail", rail.moved(0.0, COUNTER_NEAR + 0.02, 0.22), brass, True)


def build_shelves(oak, clear) -> None:
    boards = Shape()
    for z in SHELVES:
        boards += block((-1.75, SHELF_NEAR, z - 0.025), (1.75, FAR - 0.012, z), 0.004)
    for x in (-1.775, 0.0, 1.75):
        boards += block((x, SHELF_NEAR, 0.96), (x + 0.025, FAR - 0.012, SHELVES[-1]), 0.004)
    put("Shelves", boards, oak, metres=0.9)
    glasses = [
        tools.glass("Green glass", (0.42, 0.80, 0.50), ior=1.5),
        tools.glass("Brown glass", (0.80, 0.48, 0.20), ior=1.5),
        tools.glass("Blue glass", (0.45, 0.62, 0.88), ior=1.5),
        clear,
    ]
    sizes = [(0.25, 0.046, 0.52), (0.31, 0.037, 0.62), (0.29, 0.043, 0.58)]  # height, radius, shoulder
    designs = [(radius, put(f"{glass.name} bottle {k}", bottle(height, radius, shoulder, 40), glass, True))
               for glass in glasses for k, (height, radius, shoulder) in enumerate(sizes, 1)]
    dice = random.Random(7)
    unused = set(range(len(designs)))
    for z in SHELVES:
        x = -1.62
        while x < 1.60:
            kind = dice.choice(sorted(unused)) if unused else dice.randrange(len(designs))
            radius, first = designs[kind]
            x += radius
            if abs(x) > radius + 0.03 and x < 1.70 - radius:
                at = Matrix.Translation((x, SHELF_NEAR + 0.11 + dice.uniform(-0.02, 0.02), z))
                if kind in unused:
                    first.matrix_world = at
                    unused.remove(kind)
                else:
                    tools.add_instance(first.name, first.data, at)
            x += radius + dice.uniform(0.015, 0.09)


def build_things(clear, chrome) -> None:
    for k, (x, y) in enumerate(((-0.40, 0.16), (-0.27, 0.27), (-0.47, 0.30))):
        put(f"Wine glass {k + 1}", wine_glass(0.21).moved(x, y, COUNTER), clear, True)
    put("Tumbler", tumbler(0.040, 0.105).moved(0.66, 0.14, COUNTER), clear, True)
    wine = tools.glass("Green bottle glass", (0.42, 0.80, 0.50), ior=1.5)
    put("Bottle", bottle(0.31, 0.040, 0.60).moved(0.50, 0.28, COUNTER), wine, True)
    shaker = lathe([(0.0, 0.0), (0.032, 0.0), (0.034, 0.004), (0.043, 0.150), (0.041, 0.155), (0.026, 0.185), (0.026, 0.215), (0.022, 0.222), (0.0, 0.224)], 64)
    put("Shaker", shaker.moved(-0.12, 0.34, COUNTER), chrome, True)
    put("Bowl", bowl(0.14).moved(0.16, 0.20, COUNTER), chrome, True)
    lemon = tools.principled("Lemon", (0.80, 0.58, 0.05), roughness=0.35)
    lime = tools.principled("Lime", (0.22, 0.42, 0.05), roughness=0.30)
    fruit = sphere(0.034, 32, 16).placed(Matrix.Diagonal((1.25, 1.0, 1.0, 1.0)))
    put("Lemons", fruit.moved(0.12, 0.18, COUNTER + 0.050, 25) + fruit.moved(0.205, 0.215, COUNTER + 0.052, 100), lemon, True)
    put("Limes", fruit.moved(0.145, 0.255, COUNTER + 0.055, 60) + fruit.moved(-0.06, 0.08, COUNTER + 0.034, 140), lime, True)


def build_globes(clear, brass) -> None:
    glow = tools.emission("Bulb", (1.0, 0.72, 0.42), 3200.0)
    holder = lathe([(0.0, 0.0), (0.030, 0.0), (0.030, 0.05), (0.006, 0.07), (0.006, 0.075), (0.0, 0.075)], 32)
    for k, (x, y, z) in enumerate(GLOBES, 1):
        inside = sphere(GLOBE - GLASS_WALL, 64, 32)
        hollow = Shape(inside.verts, [face[::-1] for face in inside.faces])
        put(f"Globe {k}", (sphere(GLOBE, 64, 32) + hollow).moved(x, y, z), clear, True)
        put(f"Bulb {k}", sphere(BULB, 32, 16).moved(x, y, z), glow, True)
        put(f"Holder {k}", holder.moved(x, y, z + GLOBE - 0.002), brass, True)
        put(f"Cord {k}", cylinder(0.004, z + GLOBE + 0.07, CEILING, 12).moved(x, y), tools.diffuse(f"Cord {k}", (0.03, 0.03, 0.03)))


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
