"""`rooms`: a furnished room and four others with many lights, behind walls 12 mm thick.

Light enters through one doorway in the right wall. The lights of the other rooms are coloured, so that light that leaks through a wall is visible by
its colour. Y points from the eye to the rear wall.
"""

from __future__ import annotations

import math
import random
import sys
from pathlib import Path

import bpy
from mathutils import Matrix

sys.path.insert(0, str(Path(__file__).resolve().parent))

import scene_tools as tools
from furniture import (
    book,
    bowl,
    chair,
    frame,
    plant,
    put,
    put_image,
    shelf,
    sofa,
    table,
    teapot,
    tumbler,
    vase,
)
from images import cloth, landscape, pack, wood
from light_hints import aimed_light_hint
from shapes import Shape, block, cushion, cylinder, sphere

LEFT, RIGHT, NEAR, REAR, CEILING = -2.6, 2.7, -2.4, 2.6, 2.6  # the room in view
WEST, EAST, NORTH, BETWEEN = -5.6, 5.6, 5.6, 0.6  # outer walls; the wall between the rooms behind
THIN = 0.012
DOOR = (1.10, 2.10)  # along Y, in the right wall
DOOR_HEIGHT = 2.05
TABLE = (0.85, 0.95)
TABLE_HEIGHT = 0.74
LAMPS = [(5.00, 1.65, 2.00), (3.70, 0.20, 2.58), (4.70, -0.80, 2.58), (3.60, -1.80, 2.58)]  # beyond the doorway


def build() -> None:
    tools.start_scene(720, 405)
    build_walls()
    build_lights()
    build_dining()
    build_seats()
    build_shelf()
    build_pictures()
    tools.camera((0.22, -2.20, 1.58), (0.10, 2.6, 0.90), lens=20.5)


def wall(start: tuple[float, float], end: tuple[float, float], openings: tuple[tuple[float, float], ...] = ()) -> Shape:
    """A thin wall along X or Y, centred on its line, with doorways given along it."""
    axis = 0 if start[1] == end[1] else 1

    def panel(a: float, b: float, low: float) -> Shape:
        if axis == 0:
            return block((a, start[1] - THIN / 2, low), (b, start[1] + THIN / 2, CEILING))
        return block((start[0] - THIN / 2, a, low), (start[0] + THIN / 2, b, CEILING))

    shape, at = Shape(), start[axis]
    for low, high in openings:
        shape += panel(at, low, 0.0) + panel(low, high, DOOR_HEIGHT)
        at = high
    return shape + panel(at, end[axis], 0.0)


def build_walls() -> None:
    planks = tools.principled("Planks", (1, 1, 1), roughness=0.3)
    tools.image_texture(
        planks,
        pack("Planks", wood((0.50, 0.36, 0.24), (0.78, 0.62, 0.45), 512, boards=8, seed=11)),
        socket="Base Color",
    )
    plaster = tools.diffuse("Plaster", (0.80, 0.78, 0.73))
    put("Floor", block((WEST, NEAR, -0.1), (EAST, NORTH, 0.0)), planks, metres=1.4)
    put(
        "Ceiling",
        block((WEST, NEAR, CEILING), (EAST, NORTH, CEILING + 0.1)),
        tools.diffuse("Ceiling", (0.82, 0.81, 0.79)),
    )
    put(
        "Side walls",
        wall((LEFT, NEAR), (LEFT, REAR))
        + wall((RIGHT, NEAR), (RIGHT, REAR), (DOOR,))
        + wall((BETWEEN, REAR), (BETWEEN, NORTH), ((4.3, 5.2),))
        + wall((WEST, NEAR), (EAST, NEAR))
        + wall((WEST, NORTH), (EAST, NORTH))
        + wall((WEST, NEAR), (WEST, NORTH))
        + wall((EAST, NEAR), (EAST, NORTH)),
        plaster,
    )
    put(
        "Rear wall",
        wall((WEST, REAR), (EAST, REAR), ((-4.7, -3.8), (3.6, 4.5))),
        tools.diffuse("Sage", (0.52, 0.64, 0.57)),
    )

    trim = Shape()
    for side in (RIGHT - THIN / 2 - 0.018, RIGHT + THIN / 2):
        for low, high in ((DOOR[0] - 0.08, DOOR[0]), (DOOR[1], DOOR[1] + 0.08)):
            trim += block((side, low, 0.0), (side + 0.018, high, DOOR_HEIGHT + 0.08), 0.004)
        trim += block((side, DOOR[0], DOOR_HEIGHT), (side + 0.018, DOOR[1], DOOR_HEIGHT + 0.08), 0.004)
    right, rear = RIGHT - THIN / 2, REAR - THIN / 2
    for low, high in ((NEAR, DOOR[0] - 0.08), (DOOR[1] + 0.08, rear)):
        trim += block((right - 0.014, low, 0.0), (right, high, 0.10), 0.004)
    trim += block((LEFT, rear - 0.014, 0.0), (RIGHT, rear, 0.10), 0.004)
    trim += block((LEFT + THIN / 2, NEAR, 0.0), (LEFT + THIN / 2 + 0.014, REAR, 0.10), 0.004)
    put("Trim", trim, tools.principled("White paint", (0.80, 0.79, 0.76), roughness=0.35))


def build_lights() -> None:
    tools.area_light("Lamp 1", LAMPS[0], (RIGHT, 1.55, 1.15), 0.45, 560.0, (1.0, 0.90, 0.74))
    for k, lamp in enumerate(LAMPS[1:], 2):
        tools.area_light(f"Lamp {k}", lamp, (lamp[0], lamp[1], 0.0), 0.5, 22.0, (1.0, 0.90, 0.74))
    rooms = (
        ("West", -5.1, -3.2, -1.8, 2.0, 2, 3, (1.0, 0.45, 0.30)),
        ("North-west", -4.9, -0.1, 3.2, 5.0, 4, 2, (1.0, 0.62, 0.30)),
        ("North-east", 1.4, 4.9, 3.3, 4.9, 3, 2, (0.35, 0.60, 1.0)),
    )
    for name, x0, x1, y0, y1, columns, rows, colour in rooms:
        for i in range(columns):
            for j in range(rows):
                place = (x0 + (x1 - x0) * i / (columns - 1), y0 + (y1 - y0) * j / (rows - 1), 2.2)
                tools.point_light(f"{name} {i + columns * j + 1}", place, 90.0, colour, radius=0.06)


def textured(name: str, colour_low, colour_high, seed: int, roughness: float):
    material = tools.principled(name, (1, 1, 1), roughness=roughness)
    tools.image_texture(material, pack(name, wood(colour_low, colour_high, 256, seed=seed)), socket="Base Color")
    return material


def build_dining() -> None:
    walnut = textured("Walnut", (0.32, 0.19, 0.12), (0.55, 0.36, 0.24), 5, 0.28)
    x, y = TABLE
    put("Table", table(1.55, 0.85, TABLE_HEIGHT).moved(x, y, 0.0), walnut, metres=0.8)
    for k, (dx, dy, turn) in enumerate(((-0.38, -0.62, 184), (0.52, -0.74, 150), (-0.36, 0.60, 2), (0.40, 0.66, -8))):
        put(f"Chair {k + 1}", chair().moved(x + dx, y + dy, 0.0, turn), walnut, metres=0.8)
    put(
        "Bowl",
        bowl(0.15, 32, 3).moved(x + 0.05, y + 0.08, TABLE_HEIGHT),
        tools.principled("Blue glaze", (0.08, 0.22, 0.42), roughness=0.1),
        True,
    )
    fruit = tools.principled("Oranges", (0.80, 0.30, 0.04), roughness=0.35)
    oranges = Shape()
    for dx, dy, dz in ((-0.04, 0.02, 0.055), (0.045, 0.035, 0.055), (0.005, -0.045, 0.055), (0.005, 0.01, 0.112)):
        oranges += sphere(0.038, 20, 10).moved(x + 0.05 + dx, y + 0.08 + dy, TABLE_HEIGHT + dz)
    put("Oranges", oranges, fruit, True)
    put(
        "Teapot",
        teapot(0.18, 24, 3).moved(x - 0.42, y + 0.05, TABLE_HEIGHT, 30),
        tools.principled("Silver", (0.80, 0.78, 0.75), roughness=0.12, metallic=1.0),
        True,
    )
    glasses = tumbler(0.036, 0.11, 40).moved(x - 0.16, y - 0.20, TABLE_HEIGHT) + tumbler(0.036, 0.11, 40).moved(
        x + 0.40, y - 0.16, TABLE_HEIGHT
    )
    put("Glasses", glasses, tools.glass("Glass", ior=1.5), True)
    white = tools.principled("Porcelain", (0.80, 0.79, 0.77), roughness=0.12)
    put(
        "Plate",
        bowl(0.12, 32, 3).placed(Matrix.Diagonal((1, 1, 0.35, 1))).moved(x + 0.50, y + 0.14, TABLE_HEIGHT),
        white,
        True,
    )


def build_seats() -> None:
    legs, soft = sofa(2.0, 9)
    put(
        "Sofa legs", legs.moved(-2.06, 0.95, 0.0, 90), tools.principled("Dark wood", (0.06, 0.035, 0.02), roughness=0.3)
    )
    put("Sofa", soft.moved(-2.06, 0.95, 0.0, 90), tools.diffuse("Blue wool", (0.13, 0.24, 0.34)), True)
    for name, y, turn, colour in (
        ("Ochre cushion", 1.58, 64, (0.72, 0.42, 0.09)),
        ("Red cushion", 0.34, 112, (0.55, 0.12, 0.08)),
    ):
        pillow = cushion(0.44, 0.44, 0.17, 3.2, 10).placed(Matrix.Rotation(math.radians(62), 4, "X"))
        put(name, pillow.moved(-1.98, y, 0.69, turn), tools.diffuse(name, colour), True)
    carpet = tools.diffuse("Carpet", (1, 1, 1))
    tools.image_texture(
        carpet, pack("Carpet", cloth((0.62, 0.52, 0.42), (0.82, 0.76, 0.66), (0.35, 0.20, 0.16), 256, 352))
    )
    put_image("Carpet", (-1.75, -0.25, 0.011), (1.60, 0, 0), (0, 2.4, 0), carpet)
    put(
        "Carpet edge",
        block((-1.75, -0.25, 0.0), (-0.15, 2.15, 0.010)),
        tools.diffuse("Carpet edge", (0.30, 0.22, 0.18)),
    )
    low = textured("Ash", (0.55, 0.42, 0.30), (0.75, 0.62, 0.48), 8, 0.25)
    put("Low table", table(0.62, 0.95, 0.38, 0.05).moved(-0.95, 0.90, 0.011), low, metres=0.8)
    put(
        "Green vase",
        vase(0.24, 32, 3).moved(-0.99, 1.10, 0.391),
        tools.principled("Green glaze", (0.10, 0.30, 0.20), roughness=0.1),
        True,
    )
    cover, pages = book(0.025, 0.16, 0.23)
    lying = (
        Matrix.Translation((-1.05, 0.62, 0.391))
        @ Matrix.Rotation(math.radians(25), 4, "Z")
        @ Matrix.Rotation(math.radians(90), 4, "Y")
        @ Matrix.Translation((-0.025, 0, 0))
    )
    put("Book", cover.placed(lying), tools.principled("Red cloth", (0.45, 0.07, 0.06), roughness=0.6))
    put("Book pages", pages.placed(lying), tools.diffuse("Paper", (0.80, 0.76, 0.66)))
    pot, leaves = plant(34)
    put("Pot", pot.moved(-2.22, 2.24, 0.0), tools.principled("Terracotta", (0.55, 0.26, 0.15), roughness=0.6), True)
    put("Leaves", leaves.moved(-2.22, 2.24, 0.0), tools.principled("Leaf", (0.07, 0.22, 0.06), roughness=0.35), True)


def made(name: str) -> bpy.types.Material:
    return bpy.data.materials[name]


def build_shelf() -> None:
    x, y, wide, high, boards = -0.95, REAR - THIN / 2 - 0.02, 1.55, 2.0, 5
    put("Shelf", shelf(wide, 0.30, high, boards).moved(x, y), made("Ash"), metres=0.8)
    rng = random.Random(12)
    colours = {
        "Wine cloth": (0.30, 0.05, 0.06),
        "Navy cloth": (0.05, 0.09, 0.20),
        "Moss cloth": (0.14, 0.19, 0.08),
        "Sand cloth": (0.62, 0.50, 0.32),
        "Rust cloth": (0.50, 0.18, 0.06),
        "Slate cloth": (0.22, 0.25, 0.27),
    }
    covers = {name: Shape() for name in colours}
    pages = Shape()
    pitch = (high - 0.085) / boards
    # Shelves from bottom to top; the parts of each with books, in metres from the centre.
    for level, spans in enumerate(
        (
            ((-0.74, 0.30),),
            ((-0.74, -0.10), (0.40, 0.74)),
            ((-0.40, 0.45),),
            ((-0.74, -0.35), (0.05, 0.74)),
            ((-0.20, 0.30),),
        )
    ):
        for start, end in spans:
            at = start
            while at < end - 0.045:
                thick, tall, deep = rng.uniform(0.018, 0.045), rng.uniform(0.18, 0.29), rng.uniform(0.15, 0.20)
                cover, leaf = book(thick, deep, tall)
                place = {
                    "x": x + at,
                    "y": y - 0.26 + rng.uniform(0.0, 0.02),
                    "z": 0.06 + 0.025 + pitch * level + 0.0005,
                }
                covers[rng.choice(list(colours))] += cover.moved(**place)
                pages += leaf.moved(**place)
                at += thick + 0.001
    for name, colour in colours.items():
        put(f"Books, {name.lower()}", covers[name], tools.principled(name, colour, roughness=0.55))
    put("Books, pages", pages, made("Paper"))

    def level(k: int) -> float:
        return 0.086 + pitch * k

    put("Shelf vase", vase(0.25, 32, 3).moved(x + 0.15, y - 0.15, level(1)), made("Blue glaze"), True)
    put("Shelf bowl", bowl(0.13, 32, 3).moved(x + 0.53, y - 0.16, level(0)), made("Porcelain"), True)
    put("Shelf teapot", teapot(0.17, 20, 3).moved(x - 0.58, y - 0.16, level(2), 200), made("Terracotta"), True)
    brass = tools.principled("Brass", (0.80, 0.58, 0.24), roughness=0.2, metallic=1.0)
    put(
        "Globe",
        (sphere(0.10, 28, 14).moved(z=0.16) + cylinder(0.012, 0.0, 0.07, 20) + cylinder(0.06, 0.0, 0.012, 32)).moved(
            x + 0.60, y - 0.16, level(2)
        ),
        brass,
        True,
    )
    put("Shelf vase 2", vase(0.20, 32, 3).moved(x - 0.16, y - 0.15, level(3)), made("Porcelain"), True)
    put(
        "Box",
        block((x - 0.70, y - 0.27, level(4)), (x - 0.32, y - 0.05, level(4) + 0.16), 0.006),
        made("Walnut"),
        metres=0.5,
    )
    put("Shelf glass", tumbler(0.06, 0.20, 40).moved(x + 0.52, y - 0.15, level(4)), made("Glass"), True)


def build_pictures() -> None:
    gilt = tools.principled("Gilt", (0.55, 0.38, 0.16), roughness=0.3, metallic=1.0)
    black = tools.principled("Black frame", (0.02, 0.02, 0.02), roughness=0.3)
    y = REAR - THIN / 2
    for name, seed, x, z, width, height, border in (
        ("Lake", 3, 0.62, 1.60, 0.92, 0.64, gilt),
        ("Hills", 21, 1.72, 1.60, 0.50, 0.64, black),
    ):
        canvas = tools.diffuse(name, (1, 1, 1))
        image = landscape(
            seed=seed,
            sky_low=(1.0, 0.86, 0.60),
            sky_high=(0.45, 0.66, 0.82),
            near=(0.24, 0.34, 0.28),
            far=(0.72, 0.72, 0.74),
        )
        tools.image_texture(canvas, pack(name, image))
        put_image(name, (x - width / 2, y - 0.012, z - height / 2), (width, 0, 0), (0, 0, height), canvas)
        put(f"{name} frame", frame(width, height, 0.04).moved(x, y, z), border, metres=0.5)


def add_light_hints(omitted: tuple[int, ...] = ()) -> None:
    for k, (lamp, targets) in enumerate(PATHS, 1):
        if k not in omitted:
            aimed_light_hint(f"Light path {k}", LAMPS[lamp], targets)


# Ten light hints through the doorway: the lamp, then the bounces of the hint.
PATHS = [
    (0, [(1.30, 1.15, TABLE_HEIGHT)]),  # the table
    (0, [(2.45, 1.50, 0.0)]),  # the floor inside the doorway
    (0, [(LEFT, 1.80, 1.6)]),  # the left wall
    (0, [(-1.95, 1.30, 0.485)]),  # the sofa
    (0, [(1.30, 1.15, TABLE_HEIGHT), (0.60, 1.90, CEILING)]),  # table, ceiling
    (0, [(LEFT, 1.80, 1.6), (-0.35, 1.65, 0.0)]),  # left wall, floor
    (0, [(2.45, 1.50, 0.0), (2.00, REAR, 1.4)]),  # floor, rear wall
    (0, [(2.45, 1.50, 0.0), (0.20, 1.90, CEILING)]),  # floor, ceiling
    (1, [(3.70, 0.90, 0.0), (0.80, REAR, 2.2)]),  # the floor beyond, rear wall
    (2, [(4.20, 1.00, 0.0), (-0.40, 2.10, CEILING)]),  # the floor beyond, ceiling
]


if __name__ == "__main__":
    build()
    add_light_hints()
    tools.save(tools.output_path(__file__))
