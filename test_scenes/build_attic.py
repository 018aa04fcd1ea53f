"""`attic`: sun through a closed window, as in many rooms.

The pane is a sheet of glass, 4 mm thick, that refracts (no shader trick lets shadow rays pass). A path from the eye finds the sun behind it only by
chance, and all light of the room comes from the patch of sun on the boards and the trunk. X points right, Y from the eye to the window.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

from mathutils import Matrix

sys.path.insert(0, str(Path(__file__).resolve().parent))

import scene_tools as tools
from furniture import book, bottle, bowl, chair, put, vase
from shapes import Shape, block, cylinder, sphere

WIDE, NEAR, FAR = 2.0, -2.5, 2.5     # the inside; the roof begins at KNEE and meets at RIDGE
KNEE, RIDGE = 1.0, 3.0
WINDOW = (-0.32, 0.32, 1.05, 1.80)   # left, right, low, high


def build() -> None:
    scene = tools.start_scene(640, 480)
    tools.background(scene, (0.45, 0.62, 1.0), 4.0)
    lime = tools.principled("Limewash", (0.68, 0.65, 0.58), roughness=0.85)
    boards = tools.principled("Roof boards", (0.55, 0.42, 0.29), roughness=0.6)
    beams = tools.principled("Beams", (0.26, 0.16, 0.09), roughness=0.65)
    planks = tools.principled("Planks", (0.46, 0.31, 0.19), roughness=0.45)
    build_shell(lime, boards, planks)
    build_timber(beams)
    build_window(tools.principled("Window paint", (0.72, 0.70, 0.64), roughness=0.4))
    build_things()
    tools.sun_light("Sun", (-0.42, -2.3, -1.5), 320.0, (1.0, 0.90, 0.76), angle=math.radians(0.5))
    tools.camera((0.62, -2.3, 1.5), (-0.22, 1.2, 1.0), lens=24.0)


def build_shell(lime, boards, planks) -> None:
    floor = Shape()
    for k in range(24):
        x = -2.04 + 0.17 * k
        floor += block((x + 0.0015, NEAR - 0.1, -0.04), (x + 0.1685, FAR + 0.1, 0.0), 0.003)
    put("Planks", floor + block((-2.4, NEAR - 0.3, -0.3), (2.4, FAR + 0.3, -0.03)), planks)
    long = math.hypot(WIDE, RIDGE - KNEE) + 0.4
    for side, name in ((-1, "Roof, left"), (1, "Roof, right")):
        slope = block((-0.2, NEAR - 0.3, 0.0), (long, FAR + 0.3, 0.15))
        turned = slope.placed(Matrix.Rotation(math.atan2(RIDGE - KNEE, WIDE), 4, "Y"))
        if side < 0:
            turned = turned.placed(Matrix.Rotation(math.pi, 4, "Z"))
        put(name, turned.moved(0.0, 0.0, RIDGE), boards)
        put("Knee wall", block((side * WIDE - 0.1 + 0.1 * side, NEAR - 0.2, -0.1), (side * WIDE + 0.1 + 0.1 * side, FAR + 0.2, KNEE + 0.2)), lime)
    put("Gable behind the eye", block((-2.3, NEAR - 0.2, -0.1), (2.3, NEAR, RIDGE)), lime)
    left, right, low, high = WINDOW
    around = block((-2.3, FAR, -0.1), (left, FAR + 0.2, RIDGE)) + block((right, FAR, -0.1), (2.3, FAR + 0.2, RIDGE))
    put("Gable", around + block((left, FAR, -0.1), (right, FAR + 0.2, low)) + block((left, FAR, high), (right, FAR + 0.2, RIDGE)), lime)


def build_timber(beams) -> None:
    timber = block((-0.05, NEAR, RIDGE - 0.37), (0.05, FAR, RIDGE - 0.19), 0.006)
    angle = math.atan2(RIDGE - KNEE, WIDE)
    for y in (-2.0, -1.2, -0.4, 0.4, 1.2, 2.0):
        rafter = block((0.1, -0.045, -0.14), (3.0, 0.045, -0.001), 0.006).placed(Matrix.Rotation(angle, 4, "Y"))
        timber += rafter.moved(0.0, y, RIDGE) + rafter.placed(Matrix.Rotation(math.pi, 4, "Z")).moved(0.0, y, RIDGE)
    for y in (-1.12, 0.48, 2.08):
        timber += block((-0.85, y - 0.03, 2.04), (0.85, y + 0.03, 2.19), 0.006)
    for side in (-1, 1):
        timber += block((side * 1.08 - 0.06, NEAR, 1.54), (side * 1.08 + 0.06, FAR, 1.70), 0.008)
        for y in (-1.24, 0.36):
            timber += block((side * 1.08 - 0.06, y - 0.06, 0.0), (side * 1.08 + 0.06, y + 0.06, 1.55), 0.008)
    put("Timber", timber, beams)


def build_window(paint) -> None:
    left, right, low, high = WINDOW
    y0, y1 = FAR + 0.09, FAR + 0.14
    wood = block((-0.38, FAR - 0.10, low - 0.03), (0.38, FAR + 0.05, low), 0.006)
    for x in (left + 0.02, 0.0, right - 0.02):
        wide = 0.011 if x == 0.0 else 0.02
        wood += block((x - wide, y0, low), (x + wide, y1, high), 0.004)
    for z in (low + 0.02, 0.5 * (low + high), high - 0.02):
        wood += block((left, y0 + 0.001, z - 0.02), (right, y1 - 0.001, z + 0.02), 0.004)
    put("Window", wood, paint)
    y = 0.5 * (y0 + y1)
    put("Pane", block((left + 0.01, y - 0.002, low + 0.01), (right - 0.01, y + 0.002, high - 0.01)),
        tools.principled("Glass", (1.0, 1.0, 1.0), roughness=0.0, transmission=1.0, ior=1.5))


def build_things() -> None:
    leather = tools.principled("Leather", (0.25, 0.12, 0.06), roughness=0.45)
    iron = tools.principled("Iron", (0.35, 0.34, 0.33), roughness=0.4, metallic=1.0)
    brass = tools.principled("Brass", (0.80, 0.58, 0.25), roughness=0.25, metallic=1.0)
    trunk = block((-0.45, -0.25, 0.0), (0.45, 0.25, 0.42), 0.012) + block((-0.46, -0.26, 0.425), (0.46, 0.26, 0.54), 0.03)
    bands = Shape()
    for x in (-0.3, 0.3):
        bands += block((x - 0.025, -0.265, 0.0), (x + 0.025, 0.265, 0.555), 0.004)
    put("Trunk", trunk.moved(-1.0, 1.2, 0.0, 18), leather)
    put("Trunk bands", bands.moved(-1.0, 1.2, 0.0, 18), iron)
    put("Globe", sphere(0.14, 48, 24).moved(-1.0, 1.2, 0.74), tools.principled("Globe", (0.12, 0.28, 0.45), roughness=0.25), True)
    put("Globe foot", cylinder(0.09, 0.0, 0.012).moved(-1.0, 1.2, 0.556) + cylinder(0.016, 0.012, 0.08).moved(-1.0, 1.2, 0.556), brass)
    card = tools.principled("Cardboard", (0.45, 0.31, 0.18), roughness=0.8)
    cartons = block((-0.25, -0.2, 0.0), (0.25, 0.2, 0.35), 0.004).moved(1.45, 1.7, 0.0, 12)
    cartons += block((-0.2, -0.175, 0.0), (0.2, 0.175, 0.28), 0.004).moved(1.42, 1.72, 0.351, -9)
    put("Cartons", cartons + block((-0.22, -0.17, 0.0), (0.22, 0.17, 0.3), 0.004).moved(1.55, 0.95, 0.0, 28), card)
    put("Chair", chair().moved(0.75, 1.55, 0.0, 150), tools.principled("Chair", (0.30, 0.17, 0.08), roughness=0.35))
    cover, pages = book(0.035, 0.17, 0.24)
    flat = Matrix.Rotation(math.radians(90.0), 4, "Y")
    put("Book", cover.placed(flat).moved(0.30, 0.75, 0.036, 17), tools.principled("Cover", (0.40, 0.06, 0.05), roughness=0.5))
    put("Pages", pages.placed(flat).moved(0.30, 0.75, 0.036, 17), tools.diffuse("Paper", (0.75, 0.72, 0.62)))
    zinc = tools.principled("Zinc", (0.62, 0.64, 0.66), roughness=0.3, metallic=1.0)
    put("Bowl", bowl(0.13).moved(-0.15, 1.75), zinc, True)
    put("Vase", vase(0.26).moved(0.16, 2.47, WINDOW[2]), tools.principled("Vase", (0.70, 0.68, 0.62), roughness=0.15), True)
    put("Bottle", bottle(0.26).moved(-0.18, 2.47, WINDOW[2]),
        tools.principled("Green glass", (0.35, 0.75, 0.42), roughness=0.0, transmission=1.0, ior=1.5), True)


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
