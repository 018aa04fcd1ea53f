"""`room`: a furnished room whose only light comes from a back room through a door that is ajar.

The scene is similar to Eric Veach's door scene, in which almost no path from the eye finds the lamp. Y points from the eye to the door.
"""

from __future__ import annotations

import sys
from pathlib import Path

from mathutils import Matrix

sys.path.insert(0, str(Path(__file__).resolve().parent))

import scene_tools as tools
from furniture import chair, door, door_handles, frame, put, put_image, table, teapot, wine_glass
from images import cloth, landscape, pack, wood
from light_hints import aimed_light_hint
from shapes import Shape, block, sphere

LEFT, RIGHT, NEAR, FAR, CEILING = -2.3, 2.4, -3.3, 2.0, 2.6  # the front room
WALL = 0.12
BACK_LEFT, BACK_RIGHT, BACK_FAR = -0.2, 4.3, 4.6  # the back room
DOOR_LEFT, DOOR_RIGHT, DOOR_HEIGHT = 0.72, 1.60, 2.05
OPENING = 27.0  # degrees
LAMP = (3.35, 3.90, 2.05)
TABLE = (-0.55, 0.80)
TABLE_HEIGHT = 0.74


def build(lamp: tools.Point = LAMP) -> None:
    tools.start_scene(640, 480)
    wall = tools.diffuse("Wall", (0.70, 0.67, 0.61))
    ceiling = tools.diffuse("Ceiling", (0.80, 0.79, 0.77))
    white = tools.principled("White paint", (0.78, 0.76, 0.72), roughness=0.35)
    brass = tools.principled("Brass", (0.83, 0.61, 0.26), roughness=0.18, metallic=1.0)

    build_rooms(wall, ceiling, white)
    build_door(white, brass)
    build_table()
    build_picture()
    tools.area_light("Lamp", lamp, (0.75, 1.85, 1.0), 0.40, 1600.0, (1.0, 0.89, 0.74))
    tools.camera((0.40, -2.15, 1.52), (-0.14, 1.3, 0.94), lens=31.0)


def build_rooms(wall, ceiling, white) -> None:
    planks = tools.principled("Planks", (1, 1, 1), roughness=0.28)
    tools.image_texture(
        planks, pack("Planks", wood((0.36, 0.22, 0.13), (0.70, 0.50, 0.32), 512, boards=8)), socket="Base Color"
    )
    put("Floor", block((LEFT, NEAR, -0.1), (BACK_RIGHT, BACK_FAR, 0.0)), planks, metres=1.3)
    put(
        "Ceiling",
        block((LEFT - WALL, NEAR - WALL, CEILING), (BACK_RIGHT + WALL, BACK_FAR + WALL, CEILING + 0.1)),
        ceiling,
    )
    top = CEILING
    walls = (
        block((LEFT - WALL, NEAR - WALL, -0.1), (LEFT, FAR + WALL, top))
        + block((RIGHT, NEAR - WALL, -0.1), (RIGHT + WALL, FAR, top))
        + block((LEFT, NEAR - WALL, -0.1), (RIGHT, NEAR, top))
        + block((LEFT, FAR, -0.1), (DOOR_LEFT, FAR + WALL, top))
        + block((DOOR_RIGHT, FAR, -0.1), (BACK_RIGHT, FAR + WALL, top))
        + block((DOOR_LEFT, FAR, DOOR_HEIGHT), (DOOR_RIGHT, FAR + WALL, top))
        + block((BACK_LEFT - WALL, FAR + WALL, -0.1), (BACK_LEFT, BACK_FAR, top))
        + block((BACK_RIGHT, FAR, -0.1), (BACK_RIGHT + WALL, BACK_FAR, top))
        + block((BACK_LEFT - WALL, BACK_FAR, -0.1), (BACK_RIGHT + WALL, BACK_FAR + WALL, top))
    )
    put("Walls", walls, wall)

    skirting = Shape()
    for low, high in (
        ((LEFT, NEAR), (LEFT + 0.018, FAR)),
        ((RIGHT - 0.018, NEAR), (RIGHT, FAR)),
        ((LEFT, FAR - 0.018), (DOOR_LEFT - 0.09, FAR)),
        ((DOOR_RIGHT + 0.09, FAR - 0.018), (RIGHT, FAR)),
        ((BACK_LEFT, BACK_FAR - 0.018), (BACK_RIGHT, BACK_FAR)),
    ):
        skirting += block((*low, 0.0), (*high, 0.11), 0.005)
    for side in (FAR - 0.022, FAR + WALL):  # the architrave, on both sides of the wall
        skirting += block((DOOR_LEFT - 0.09, side, 0.0), (DOOR_LEFT, side + 0.022, DOOR_HEIGHT + 0.09), 0.005)
        skirting += block((DOOR_RIGHT, side, 0.0), (DOOR_RIGHT + 0.09, side + 0.022, DOOR_HEIGHT + 0.09), 0.005)
        skirting += block((DOOR_LEFT, side, DOOR_HEIGHT), (DOOR_RIGHT, side + 0.022, DOOR_HEIGHT + 0.09), 0.005)
    put("Woodwork", skirting, white)

    carpet = tools.diffuse("Carpet", (1, 1, 1))
    tools.image_texture(carpet, pack("Carpet", cloth((0.50, 0.20, 0.16), (0.72, 0.52, 0.38), (0.26, 0.20, 0.24))))
    put_image("Carpet", (-1.80, -0.20, 0.012), (2.4, 0, 0), (0, 1.7, 0), carpet)
    put(
        "Carpet edge", block((-1.80, -0.20, 0.0), (0.60, 1.50, 0.011)), tools.diffuse("Carpet edge", (0.05, 0.03, 0.03))
    )


def build_door(white, brass) -> None:
    width = DOOR_RIGHT - DOOR_LEFT - 0.01
    for name, shape, material, smooth in (
        ("Door", door(width, DOOR_HEIGHT - 0.005), white, False),
        ("Handles", door_handles(width), brass, True),
    ):
        put(name, shape.moved(DOOR_RIGHT - 0.005, FAR - 0.021, 0.0, OPENING), material, smooth)


def build_table() -> None:
    walnut = tools.principled("Walnut", (1, 1, 1), roughness=0.22)
    tools.image_texture(
        walnut, pack("Walnut", wood((0.34, 0.18, 0.10), (0.58, 0.36, 0.21), 256, seed=5)), socket="Base Color"
    )
    x, y = TABLE
    put("Table", table(1.30, 0.80, TABLE_HEIGHT).moved(x, y), walnut, metres=0.8)
    put("Chair", chair().moved(-1.38, 0.26, 0.012, 125), walnut, metres=0.8)

    china = tools.principled("China", (0.10, 0.26, 0.38), roughness=0.06, specular=0.6)
    put("Teapot", teapot(0.25).moved(x - 0.26, y + 0.02, TABLE_HEIGHT, 200), china, True)
    put("Glass", wine_glass(0.24).moved(x + 0.13, y - 0.10, TABLE_HEIGHT), tools.glass("Glass", ior=1.5), True)
    put(
        "Ball",
        sphere(0.10, 64, 32).moved(x + 0.42, y + 0.08, TABLE_HEIGHT + 0.10),
        tools.glossy("Gold", (0.90, 0.62, 0.28), 0.08),
        True,
    )
    apple = tools.principled("Apple", (0.52, 0.05, 0.03), roughness=0.3)
    put(
        "Apple",
        sphere(0.036, 32, 16).placed(Matrix.Diagonal((1, 1, 0.92, 1))).moved(x - 0.02, y - 0.27, TABLE_HEIGHT + 0.033),
        apple,
        True,
    )


def build_picture() -> None:
    gilt = tools.principled("Gilt", (0.55, 0.38, 0.16), roughness=0.3, metallic=1.0)
    x, z, width, height = -0.62, 1.62, 1.05, 0.70
    canvas = tools.diffuse("Painting", (1, 1, 1))
    evening = landscape(
        sky_low=(1.0, 0.86, 0.60), sky_high=(0.45, 0.66, 0.82), near=(0.24, 0.34, 0.28), far=(0.72, 0.72, 0.74)
    )
    tools.image_texture(canvas, pack("Painting", evening))
    put_image("Painting", (x - width / 2, FAR - 0.012, z - height / 2), (width, 0, 0), (0, 0, height), canvas)
    put("Frame", frame(width, height).moved(x, FAR, z), gilt, metres=0.5)


def add_light_hints(lamp: tools.Point = LAMP, omitted: tuple[int, ...] = ()) -> None:
    """Ten light hints from the lamp through the gap to visible surfaces: some straight, some with a bounce in the back room."""
    for k, targets in enumerate(PATHS, 1):
        if k not in omitted:
            aimed_light_hint(f"Light path {k}", lamp, targets)


# The bounces of each light hint.
PATHS = [
    [(-0.30, 0.98, TABLE_HEIGHT)],  # the table
    [(0.30, 1.60, 0.0)],  # the floor behind the door
    [(-1.00, 0.10, 0.0)],  # the carpet
    [(LEFT, -0.40, 1.1), (-0.60, FAR, 1.1)],  # left wall, far wall
    [(-0.30, 0.98, TABLE_HEIGHT), (0.30, FAR, 1.7)],  # table, far wall
    [(LEFT, -0.40, 1.1), (1.20, 1.76, 1.3)],  # left wall, the near side of the door
    [(0.30, 1.60, 0.0), (0.10, FAR, 0.6)],  # floor, far wall
    [(2.60, 2.39, 0.0), (LEFT, 1.27, 1.5)],  # the floor of the back room, left wall
    [(2.90, 2.45, 0.0), (LEFT, 1.27, 0.9)],  # the same, lower
    [(1.25, 1.84, 1.3), (LEFT, 1.30, 1.7)],  # the far side of the door, left wall
]

if __name__ == "__main__":
    build()
    add_light_hints()
    tools.save(tools.output_path(__file__))
