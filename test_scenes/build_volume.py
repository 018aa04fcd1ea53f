"""`volume`: a cellar with thin smoke, which is lit through the keyhole of its door.

The lamp is behind the door. Its beam falls on a glass ball, which refracts it. A dim blue lamp out of view illuminates the room, also in a renderer
without media: the smoke is a box whose surface is a Transparent BSDF. Y points from the eye to the door.
"""

from __future__ import annotations

import math
import random
import sys
from pathlib import Path

from mathutils import Matrix, Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy

import scene_tools as tools
from furniture import book, put, table, wine_glass
from images import mottled, pack, wood
from light_hints import aimed_light_hint
from shapes import Shape, block, cylinder, lathe, smooth_profile, sphere, tube

LEFT, RIGHT, NEAR, FAR, CEILING = -1.55, 1.65, -2.6, 1.9, 2.3
DOOR_LEFT, DOOR_RIGHT, DOOR_HEIGHT = -1.10, -0.20, 1.95
KEYHOLE = Vector((-0.50, FAR + 0.09, 1.42))
BEAM = Vector((0.48, -0.58, -0.45)).normalized()
LAMP = KEYHOLE - 2.3 * BEAM
TABLE_HEIGHT = 0.72
SMOKE = 0.13  # scattering events per metre


def build() -> None:
    tools.start_scene(640, 480)
    stone = tools.diffuse("Stone", (1, 1, 1))
    tools.image_texture(stone, pack("Stone", mottled((0.42, 0.39, 0.35), (0.66, 0.62, 0.56), 256, 5, 21)))
    build_cellar(stone)
    build_door()
    build_table()
    build_barrel()
    tools.point_light("Lamp", LAMP, 34000.0, (1.0, 0.80, 0.52), radius=0.025)
    tools.area_light("Night", (1.35, -2.2, 2.1), (-0.3, 1.5, 0.7), 0.6, 150.0, (0.55, 0.70, 1.0))
    tools.camera((0.40, -1.55, 1.62), (0.00, 1.2, 0.93), lens=33.0)
    add_light_hints()
    build_smoke()  # last, since the rays that find the light hints would stop at its faces


def add_light_hints() -> None:
    """Light hints through the keyhole to the table, and further to the walls."""
    through = KEYHOLE + Vector((0.0, 0.0, -0.10)) - LAMP
    on_table = LAMP + through * ((LAMP.z - TABLE_HEIGHT) / -through.z)
    for k, onward in enumerate(([], [(-0.80, FAR, 1.3)], [(0.50, FAR, 1.3)]), 1):
        aimed_light_hint(f"Light path {k}", LAMP, [on_table, *onward])


def courses(
    width: float, height: float, rows: int, seed: int, opening: tuple[float, float, float] | None = None
) -> Shape:
    """A wall of dressed stones from the origin along X and Z, which faces -Y. `opening` is its left, right and top."""
    rng = random.Random(seed)
    shape = Shape()
    tall = height / rows
    for row in range(rows):
        spans = [(0.0, width)]
        if opening and (row + 0.5) * tall < opening[2]:
            spans = [(0.0, opening[0]), (opening[1], width)]
        for start, end in spans:
            count = max(1, round((end - start) / (2.1 * tall)))
            cuts = (
                [start]
                + sorted(
                    start + (end - start) * (k + 0.5 * (row % 2) + rng.uniform(-0.15, 0.15)) / count
                    for k in range(1 - row % 2, count)
                )
                + [end]
            )
            for a, b in zip(cuts, cuts[1:]):
                if b - a > 0.03:
                    shape += block(
                        (a + 0.004, -rng.uniform(0.0, 0.018), row * tall + 0.004),
                        (b - 0.004, 0.06, (row + 1) * tall - 0.004),
                        0.012,
                    )
    return shape


def build_cellar(stone) -> None:
    back = courses(RIGHT - LEFT, CEILING, 9, 1, (DOOR_LEFT - LEFT, DOOR_RIGHT - LEFT, DOOR_HEIGHT)).moved(
        LEFT, FAR, 0.0
    )
    side = courses(FAR - NEAR, CEILING, 9, 2)
    left = side.placed(Matrix.Translation((LEFT, NEAR, 0)) @ Matrix.Rotation(math.pi / 2, 4, "Z"))
    right = side.placed(Matrix.Translation((RIGHT, FAR, 0)) @ Matrix.Rotation(-math.pi / 2, 4, "Z"))
    put("Stones", back + left + right, stone, metres=1.1)

    # Mortar behind the stones, which blocks all light, and the chamber of the lamp behind the door.
    out, face, top = 0.35, FAR + 0.03, CEILING + 1.5
    west, north = LEFT - 1.4, FAR + 4.0
    mortar = (
        block((LEFT - out, NEAR - out, -0.2), (LEFT - 0.03, face, CEILING))
        + block((RIGHT + 0.03, NEAR - out, -0.2), (RIGHT + out, face, CEILING))
        + block((LEFT - 0.03, NEAR - out, -0.2), (RIGHT + 0.03, NEAR, CEILING))
        + block((LEFT - out, NEAR - out, CEILING), (RIGHT + out, face, CEILING + 0.2))
    )
    wall = (
        block((west - 0.2, face, -0.2), (DOOR_LEFT, face + 0.2, top))
        + block((DOOR_RIGHT, face, -0.2), (RIGHT + out, face + 0.2, top))
        + block((DOOR_LEFT, face, DOOR_HEIGHT), (DOOR_RIGHT, face + 0.2, top))
    )
    chamber = (
        block((west - 0.2, north, -0.2), (RIGHT + out, north + 0.2, top))
        + block((west - 0.2, face + 0.2, -0.2), (west, north, top))
        + block((RIGHT + out - 0.2, face + 0.2, -0.2), (RIGHT + out, north, top))
        + block((west - 0.2, face, top), (RIGHT + out, north + 0.2, top + 0.2))
    )
    mortar += wall + chamber
    put("Mortar", mortar, tools.diffuse("Mortar", (0.30, 0.28, 0.25)))
    flags = courses(FAR + 0.2 - NEAR, RIGHT - LEFT, 6, 4)
    floor = flags.placed(
        Matrix.Translation((RIGHT, NEAR, -0.018))
        @ Matrix.Rotation(math.pi / 2, 4, "Z")
        @ Matrix.Rotation(-math.pi / 2, 4, "X")
    )
    put("Flags", floor, worn_stone(stone), metres=1.1)
    put("Ground", block((west, NEAR, -0.2), (RIGHT + out - 0.2, north, -0.06)), stone)
    beams = sum(
        (block((LEFT, y - 0.07, CEILING - 0.16), (RIGHT, y + 0.07, CEILING), 0.01) for y in (-1.4, -0.2, 1.0)), Shape()
    )
    put("Beams", beams, planks("Beams", (0.22, 0.15, 0.10), (0.36, 0.26, 0.18), 31), metres=0.9)


def worn_stone(stone) -> bpy.types.Material:
    """The same stone with a worn surface: a diffuse base below a rough glossy lobe."""
    material = tools.principled("Worn stone", (1, 1, 1), roughness=0.38)
    tools.image_texture(material, bpy.data.images["Stone"], socket="Base Color")
    return material


def planks(name: str, dark, light, seed: int, roughness: float = 0.55) -> bpy.types.Material:
    material = tools.principled(name, (1, 1, 1), roughness=roughness)
    tools.image_texture(material, pack(name, wood(dark, light, 256, seed=seed)), socket="Base Color")
    return material


def keyhole_radius(angle: float) -> float:
    """The distance from the centre of a keyhole to its edge: a round head above a slot that widens downwards."""

    def inside(r: float) -> bool:
        x, z = r * math.cos(angle), r * math.sin(angle)
        slot = 0.028 + 0.032 * min(1.0, max(0.0, (0.02 - z) / 0.20))
        return x * x + (z - 0.065) ** 2 < 0.080**2 or (-0.17 < z < 0.04 and abs(x) < slot)

    low, high = 0.0, 0.3
    for step in range(400):  # the edge has a corner between head and slot: a search in steps, then bisection
        if not inside(0.0005 * step):
            low, high = 0.0005 * (step - 1), 0.0005 * step
            break
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if inside(middle) else (low, middle)
    return low


def pierced(left: float, right: float, low: float, high: float, front: float, back: float) -> Shape:
    """A plate with the keyhole, around the origin of X and Z."""
    corners = [math.atan2(z, x) for z in (low, high) for x in (left, right)]
    angles = sorted(set([2 * math.pi * k / 128 - math.pi for k in range(128)] + corners))
    verts: list[Vector] = []
    for y in (front, back):
        for angle in angles:
            c, s = math.cos(angle), math.sin(angle)
            reach = min(
                [side / c for side in (left, right) if side * c > 1e-9]
                + [side / s for side in (low, high) if side * s > 1e-9]
            )
            verts += [
                Vector((reach * c, y, reach * s)),
                Vector((keyhole_radius(angle) * c, y, keyhole_radius(angle) * s)),
            ]
    n = len(angles)
    faces = []
    for k in range(n):
        a, b = 2 * k, 2 * ((k + 1) % n)
        c, d = a + 2 * n, b + 2 * n
        faces += [(a, b, b + 1, a + 1), (c, c + 1, d + 1, d), (a, c, d, b), (a + 1, b + 1, d + 1, c + 1)]
    return Shape(verts, faces)


def build_door() -> None:
    oak = planks("Old oak", (0.26, 0.17, 0.11), (0.46, 0.32, 0.21), 23)
    iron = tools.principled("Iron", (0.16, 0.15, 0.15), roughness=0.38, metallic=1.0)
    x, y, z = KEYHOLE
    front, back = y - 0.035, y + 0.035
    left, right, low, high = x - 0.19, x + 0.19, z - 0.28, z + 0.26
    leaf = pierced(left - x, right - x, low - z, high - z, front, back).moved(x, 0.0, z)
    edges = [DOOR_LEFT - 0.02, -0.89, left, right, DOOR_RIGHT + 0.02]
    for a, b in zip(edges, edges[1:]):
        if a == left:
            leaf += block((a, front, -0.01), (b, back, low)) + block((a, front, high), (b, back, DOOR_HEIGHT + 0.02))
        else:
            leaf += block((a, front, -0.01), (b, back, DOOR_HEIGHT + 0.02), 0.004)
    put("Door", leaf, oak, metres=0.9)
    fittings = pierced(-0.135, 0.135, -0.24, 0.21, -0.045, -0.034).moved(x, y, z)
    for height in (0.38, 1.70):
        fittings += block((DOOR_LEFT, front - 0.010, height - 0.035), (DOOR_RIGHT - 0.08, front, height + 0.035), 0.003)
        for k in range(6):
            fittings += sphere(0.014, 12, 6).moved(DOOR_LEFT + 0.06 + 0.14 * k, front - 0.010, height)
    ring = [
        (0.055 * math.sin(a), -0.012 * math.cos(a), 0.055 * math.cos(a)) for a in (math.pi * k / 8 for k in range(17))
    ]
    fittings += tube(ring, 0.008, 12, 4).moved(x + 0.02, front - 0.03, z - 0.43) + cylinder(
        0.02, 0.0, 0.035, 16
    ).placed(Matrix.Translation((x + 0.02, front, z - 0.375)) @ Matrix.Rotation(math.pi / 2, 4, "X"))
    put("Fittings", fittings, iron)
    frame = planks("Door frame", (0.20, 0.13, 0.09), (0.34, 0.24, 0.16), 29)
    put(
        "Frame",
        block((DOOR_LEFT - 0.02, FAR - 0.03, -0.02), (DOOR_LEFT + 0.05, FAR + 0.055, DOOR_HEIGHT), 0.006)
        + block((DOOR_RIGHT - 0.05, FAR - 0.03, -0.02), (DOOR_RIGHT + 0.02, FAR + 0.055, DOOR_HEIGHT), 0.006)
        + block(
            (DOOR_LEFT - 0.08, FAR - 0.035, DOOR_HEIGHT - 0.06),
            (DOOR_RIGHT + 0.08, FAR + 0.055, DOOR_HEIGHT + 0.08),
            0.006,
        ),
        frame,
        metres=0.9,
    )


def build_table() -> None:
    # The point at which the centre of the beam hits the table.
    spot = KEYHOLE + BEAM * ((KEYHOLE.z - 0.09 - TABLE_HEIGHT) / -BEAM.z)
    x, y = spot.x + 0.02, spot.y
    put(
        "Table",
        table(1.15, 0.72, TABLE_HEIGHT, 0.09).moved(x + 0.12, y - 0.02, 0.0),
        planks("Table oak", (0.30, 0.19, 0.12), (0.54, 0.37, 0.24), 25, 0.35),
        metres=0.8,
    )
    brass = tools.principled("Brass", (0.80, 0.58, 0.24), roughness=0.2, metallic=1.0)
    stand = lathe(
        smooth_profile(
            [
                (0.0, 0.0),
                (0.055, 0.0),
                (0.058, 0.006),
                (0.030, 0.016),
                (0.022, 0.028),
                (0.036, 0.040),
                (0.040, 0.044),
                (0.030, 0.042),
                (0.0, 0.036),
            ],
            4,
        ),
        48,
    )
    put("Stand", stand.moved(x, y, TABLE_HEIGHT), brass, True)
    put("Glass ball", sphere(0.082, 96, 48).moved(x, y, TABLE_HEIGHT + 0.114), tools.glass("Glass", ior=1.5), True)
    put(
        "Goblet",
        wine_glass(0.20, 48).moved(x + 0.46, y + 0.13, TABLE_HEIGHT),
        tools.principled("Silver", (0.80, 0.78, 0.75), roughness=0.22, metallic=1.0),
        True,
    )
    paper = tools.diffuse("Paper", (0.78, 0.70, 0.54))
    pages, at = Shape(), TABLE_HEIGHT
    for name, colour, thick, turn in (
        ("Wine leather", (0.26, 0.05, 0.05), 0.05, 14),
        ("Green leather", (0.06, 0.16, 0.09), 0.042, -9),
        ("Tan leather", (0.45, 0.27, 0.13), 0.034, 27),
    ):
        cover, leaves = book(thick, 0.17, 0.24)
        lying = (
            Matrix.Translation((x - 0.31, y - 0.01, at))
            @ Matrix.Rotation(math.radians(turn), 4, "Z")
            @ Matrix.Rotation(math.pi / 2, 4, "Y")
            @ Matrix.Translation((-thick, -0.085, -0.12))
        )
        put(name, cover.placed(lying), tools.principled(name, colour, roughness=0.5))
        pages += leaves.placed(lying)
        at += thick + 0.0005
    put("Pages", pages, paper)
    put(
        "Candle",
        lathe([(0.0, 0.0), (0.020, 0.0), (0.020, 0.13), (0.016, 0.134), (0.0, 0.130)], 32).moved(
            x + 0.30, y - 0.17, TABLE_HEIGHT + 0.022
        ),
        tools.principled("Wax", (0.80, 0.72, 0.56), roughness=0.4),
    )
    put(
        "Candlestick",
        lathe(
            smooth_profile(
                [
                    (0.0, 0.0),
                    (0.058, 0.0),
                    (0.062, 0.012),
                    (0.050, 0.010),
                    (0.024, 0.012),
                    (0.024, 0.026),
                    (0.0, 0.024),
                ],
                4,
            ),
            48,
        ).moved(x + 0.30, y - 0.17, TABLE_HEIGHT),
        brass,
        True,
    )


def build_barrel() -> None:
    staves = planks("Staves", (0.28, 0.18, 0.11), (0.48, 0.33, 0.21), 27)
    iron = bpy.data.materials["Iron"]
    profile = [
        (0.0, 0.03),
        (0.235, 0.03),
        (0.24, 0.0),
        (0.26, 0.0),
        (0.295, 0.22),
        (0.305, 0.40),
        (0.295, 0.58),
        (0.26, 0.80),
        (0.24, 0.80),
        (0.235, 0.77),
        (0.0, 0.77),
    ]
    x, y = 1.28, 1.46
    put("Barrel", lathe(profile, 28).moved(x, y), staves, metres=0.8)
    hoops = Shape()
    for height, radius in ((0.07, 0.274), (0.24, 0.300), (0.56, 0.300), (0.73, 0.274)):
        hoops += lathe(
            [
                (radius - 0.01, height - 0.02),
                (radius + 0.003, height - 0.02),
                (radius + 0.003, height + 0.02),
                (radius - 0.01, height + 0.02),
            ],
            56,
        )
    put("Hoops", hoops.moved(x, y), iron)


def build_smoke() -> None:
    material = tools.fog("Smoke", (0.92, 0.92, 0.92), SMOKE, 0.35)
    # Its faces lie inside the stones and the door.
    smoke = put("Smoke", block((LEFT - 0.025, NEAR - 0.1, -0.05), (RIGHT + 0.025, KEYHOLE.y, CEILING + 0.1)), material)
    smoke.display_type = "WIRE"


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
