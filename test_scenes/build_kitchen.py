"""`kitchen`: brushed metal, polished stone and small lamps that shine on them.

Every surface in view is diffuse or a glossy surface of roughness 0.05 to 0.3. Two lamps below the hood and a strip below the cupboards face brushed
metal, and a pendant lamp hangs in a metal shade, so that much of the light reaches diffuse surfaces by glossy reflection only.
Y points from the eye to the rear wall.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

from mathutils import Matrix, Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))

import scene_tools as tools
from furniture import bowl, bottle, put, teapot, vase
from shapes import Shape, block, cylinder, four_walls, lathe, sphere, tube

LEFT, RIGHT, NEAR, FAR, CEILING = -2.2, 2.2, -2.8, 1.5, 2.6
TOP, TOP_NEAR = 0.92, 0.85      # the worktop and its edge
CUPBOARD, CUPBOARD_NEAR = 1.50, 1.15
HOOD_LEFT, HOOD_RIGHT = -0.45, 0.45
ISLAND = (-0.75, -0.75, 0.75, -0.15)
PENDANT = (0.0, -0.45, 1.78)


def build() -> None:
    tools.start_scene(640, 480)
    brushed = tools.principled("Brushed steel", (0.62, 0.61, 0.59), roughness=0.26, metallic=1.0)
    satin = tools.principled("Satin steel", (0.70, 0.69, 0.67), roughness=0.16, metallic=1.0)
    chrome = tools.principled("Chrome", (0.80, 0.80, 0.81), roughness=0.05, metallic=1.0)
    copper = tools.principled("Copper", (0.86, 0.48, 0.32), roughness=0.12, metallic=1.0)
    stone = tools.principled("Polished stone", (0.10, 0.10, 0.11), roughness=0.08, specular=0.6)
    build_room()
    build_counter(brushed, stone, chrome)
    build_cupboards(brushed, satin)
    build_island(stone, satin)
    build_things(chrome, copper, satin)
    build_lamps(satin, copper)
    tools.camera((0.85, -2.35, 1.58), (-0.12, 0.8, 1.02), lens=26.0)


def build_room() -> None:
    plaster = tools.diffuse("Plaster", (0.68, 0.64, 0.58))
    floor = tools.principled("Floor", (0.32, 0.24, 0.18), roughness=0.12)
    put("Floor", block((LEFT, NEAR, -0.1), (RIGHT, FAR, 0.0)), floor)
    put("Ceiling", block((LEFT, NEAR, CEILING), (RIGHT, FAR, CEILING + 0.1)), tools.diffuse("Ceiling", (0.78, 0.77, 0.75)))
    put("Walls", four_walls((LEFT, NEAR), (RIGHT, FAR), CEILING), plaster)


def build_counter(brushed, stone, chrome) -> None:
    put("Worktop", block((LEFT, TOP_NEAR, TOP - 0.04), (RIGHT, FAR, TOP), 0.006), stone)
    fronts, handles = Shape(), Shape()
    wide = (RIGHT - LEFT) / 7
    for k in range(7):
        x = LEFT + wide * k
        fronts += block((x + 0.004, TOP_NEAR + 0.03, 0.10), (x + wide - 0.004, TOP_NEAR + 0.06, TOP - 0.05), 0.004)
        handles += tube([(x + 0.12, TOP_NEAR - 0.01, TOP - 0.12), (x + wide - 0.12, TOP_NEAR - 0.01, TOP - 0.12)], 0.008, 12, 4)
    fronts += block((LEFT, TOP_NEAR + 0.06, 0.0), (RIGHT, FAR, TOP - 0.04))
    put("Fronts", fronts, brushed)
    put("Handles", handles, chrome, True)
    put("Splashback", block((LEFT, FAR - 0.006, TOP), (RIGHT, FAR, CUPBOARD)), brushed)
    spout = tube([(1.15, 1.32, TOP), (1.15, 1.32, TOP + 0.30), (1.15, 1.22, TOP + 0.38), (1.15, 1.08, TOP + 0.32)], 0.014, 20, 10)
    put("Tap", spout + cylinder(0.030, TOP, TOP + 0.05).moved(1.15, 1.32), chrome, True)


def build_cupboards(brushed, satin) -> None:
    doors = Shape()
    for left, right in ((LEFT, HOOD_LEFT - 0.05), (HOOD_RIGHT + 0.05, RIGHT)):
        doors += block((left, CUPBOARD_NEAR + 0.02, CUPBOARD), (right, FAR, 2.25))
        half = (left + right) / 2
        for a, b in ((left, half), (half, right)):
            doors += block((a + 0.004, CUPBOARD_NEAR, CUPBOARD + 0.004), (b - 0.004, CUPBOARD_NEAR + 0.02, 2.246), 0.003)
    put("Cupboards", doors, brushed)
    low, high, near = 1.62, 1.80, 1.00
    hood = Shape()   # a hollow pyramid without a base, and its duct
    corners = [(HOOD_LEFT, near), (HOOD_RIGHT, near), (HOOD_RIGHT, FAR), (HOOD_LEFT, FAR)]
    inner = [(-0.16, 1.20), (0.16, 1.20), (0.16, FAR), (-0.16, FAR)]
    verts = [Vector((x, y, low)) for x, y in corners] + [Vector((x, y, high)) for x, y in inner]
    hood += Shape(verts, [(k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k) for k in range(4)] + [(4, 5, 6, 7)])
    hood += block((-0.15, 1.21, high), (0.15, FAR, CEILING))
    put("Hood", hood, satin)


def build_island(stone, satin) -> None:
    x0, y0, x1, y1 = ISLAND
    put("Island", block((x0 - 0.05, y0 - 0.05, TOP - 0.04), (x1 + 0.05, y1 + 0.05, TOP), 0.006), stone)
    put("Island body", block((x0, y0, 0.0), (x1, y1, TOP - 0.04), 0.006), satin)


def build_things(chrome, copper, satin) -> None:
    white = tools.principled("Porcelain", (0.80, 0.78, 0.74), roughness=0.10)
    put("Bowl", bowl(0.15).moved(-0.38, -0.48, TOP), copper, True)
    for k, (x, y, radius) in enumerate(((-0.42, -0.52, 0.036), (-0.33, -0.45, 0.038), (-0.40, -0.42, 0.034))):
        fruit = tools.principled(f"Fruit {k}", ((0.62, 0.28, 0.04), (0.55, 0.07, 0.04), (0.50, 0.46, 0.08))[k], roughness=0.25)
        put(f"Fruit {k}", sphere(radius, 32, 16).moved(x, y, TOP + 0.055), fruit, True)
    put("Teapot", teapot(0.22).moved(0.36, -0.42, TOP, 150), chrome, True)
    put("Vase", vase(0.30).moved(0.05, -0.62, TOP), white, True)
    put("Bottle", bottle(0.30).moved(-1.55, 1.18, TOP), tools.principled("Bottle", (0.10, 0.22, 0.09), roughness=0.06), True)
    pot = lathe([(0.0, 0.0), (0.12, 0.0), (0.13, 0.015), (0.13, 0.17), (0.126, 0.17), (0.126, 0.02), (0.0, 0.018)], 64)
    put("Pot", pot.moved(-0.16, 1.20, TOP + 0.004), satin, True)
    put("Copper pot", pot.placed(Matrix.Scale(0.8, 4)).moved(0.19, 1.18, TOP + 0.004), copper, True)
    plates = Shape()
    for k in range(5):
        plates += lathe([(0.0, 0.0), (0.07, 0.0), (0.125, 0.016), (0.12, 0.02), (0.068, 0.006), (0.0, 0.006)], 64).moved(-0.95, 1.20, TOP + 0.012 * k)
    put("Plates", plates, white, True)


def build_lamps(satin, copper) -> None:
    """The strip and the hood's lamps face metal. The pendant's bulb is inside a shade of copper that is open below."""
    x, y, z = PENDANT
    profile = [(0.14, -0.10), (0.125, -0.04), (0.09, 0.02), (0.05, 0.06), (0.018, 0.08), (0.0, 0.08)]
    shade = lathe(profile, 64) + lathe([(r * 0.97, h - 0.004 if r else h - 0.006) for r, h in profile], 64)
    put("Shade", shade.moved(x, y, z), copper, True)
    put("Cord", cylinder(0.004, z + 0.08, CEILING).moved(x, y), satin, True)
    tools.point_light("Bulb", (x, y, z + 0.01), 110.0, (1.0, 0.86, 0.68), radius=0.012)
    for k, side in enumerate((-1, 1)):
        tools.spot_light(f"Hood lamp {k + 1}", (side * 0.24, 1.10, 1.64), (side * 0.12, FAR, 1.22), 130.0, (1.0, 0.90, 0.76),
                         angle=math.radians(75.0), radius=0.010)
    for k, centre in enumerate((-1.35, 1.35)):
        tools.area_light(f"Strip {k + 1}", (centre, 1.22, CUPBOARD - 0.012), (centre, FAR, CUPBOARD - 0.25), (1.3, 0.015), 45.0, (1.0, 0.92, 0.82))


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
