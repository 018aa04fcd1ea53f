"""`lantern`: a bright small bulb inside a carved lantern on a table, in a dark room.

Most of the light stays inside the lantern; the rest projects its carving on the walls.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path

from mathutils import Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))

import scene_tools as tools
from furniture import bowl, chair, put, table, vase
from images import pack, wood
from shapes import Shape, block, lathe, smooth_curve, smooth_profile, sphere, tube

LEFT, RIGHT, NEAR, FAR, CEILING = -1.75, 2.3, -2.6, 1.55, 2.45
TABLE_HEIGHT = 0.68
COLUMNS = 24
THICKNESS = 0.005
SIDE = 4  # vertices along one side of a cell
BULB = 0.205  # height of the bulb above the table

BODY = [
    (0.070, 0.022),
    (0.118, 0.055),
    (0.158, 0.125),
    (0.168, 0.205),
    (0.148, 0.285),
    (0.108, 0.345),
    (0.070, 0.395),
    (0.050, 0.430),
]


# Holes: the radius as a fraction of half the side of the cell, for each direction from its centre.


def star(points: int, outer: float, inner: float) -> Callable[[float], float]:
    def radius(angle: float) -> float:
        part = abs((angle * points / (2 * math.pi)) % 1.0 - 0.5) * 2.0
        return inner + (outer - inner) * part

    return radius


def petals(count: int, outer: float, inner: float) -> Callable[[float], float]:
    return lambda angle: inner + (outer - inner) * abs(math.cos(count * angle / 2))


def disc(size: float) -> Callable[[float], float]:
    return lambda angle: size


def lozenge(size: float) -> Callable[[float], float]:
    return lambda angle: size / (abs(math.cos(angle)) / 0.62 + abs(math.sin(angle)))


# From the foot to the neck; every second row is shifted by half a cell.
ROWS = [
    disc(0.30),
    lozenge(0.62),
    petals(4, 0.66, 0.22),
    lozenge(0.62),
    star(8, 0.76, 0.36),
    lozenge(0.62),
    star(8, 0.76, 0.36),
    lozenge(0.62),
    petals(4, 0.66, 0.22),
    lozenge(0.62),
    disc(0.34),
    lozenge(0.5),
    disc(0.30),
]


def carved_body() -> Shape:
    """The wall of the lantern as cells with one hole each. It is closed and has a constant thickness."""
    line = smooth_curve([Vector(p) for p in BODY], 24)
    lengths = [0.0]
    for a, b in zip(line, line[1:]):
        lengths.append(lengths[-1] + (b - a).length)

    def point(column: float, row: float, depth: float) -> Vector:
        """`column` and `row` count cells; `depth` inwards, metres."""
        along = min(max(row / len(ROWS), 0.0), 1.0) * lengths[-1]
        k = min(max(next((i for i, length in enumerate(lengths) if length >= along), len(line) - 1), 1), len(line) - 1)
        step = line[k] - line[k - 1]
        place = line[k - 1] + step * ((along - lengths[k - 1]) / (lengths[k] - lengths[k - 1]))
        place += depth * Vector((-step.y, step.x)).normalized()
        angle = 2 * math.pi * column / COLUMNS
        return Vector((place.x * math.cos(angle), place.x * math.sin(angle), place.y))

    # The outline of a cell, anticlockwise from its lower left corner, as seen from outside.
    walk = [k / SIDE * 2 - 1 for k in range(SIDE)]
    outline = (
        [(t, -1.0) for t in walk] + [(1.0, t) for t in walk] + [(-t, 1.0) for t in walk] + [(-1.0, -t) for t in walk]
    )
    verts: list[Vector] = []
    numbers: dict[tuple[int, ...], int] = {}

    def vertex(column: float, row: float, depth: float) -> int:
        key = (round(column * 1e4) % (COLUMNS * 10000), round(row * 1e4), round(depth * 1e6))
        if key not in numbers:
            numbers[key] = len(verts)
            verts.append(point(column, row, depth))
        return numbers[key]

    faces: list[tuple[int, ...]] = []
    refine = 3  # vertices of a hole for each vertex of the cell outline
    for row, hole in enumerate(ROWS):
        for column in range(COLUMNS):
            middle = (column + 0.5 * (row % 2), row + 0.5)
            rims, borders = [], []
            for depth in (0.0, THICKNESS):
                borders.append([vertex(middle[0] + x / 2, middle[1] + y / 2, depth) for x, y in outline])
                rim = []
                for k, (x, y) in enumerate(outline):
                    after = outline[(k + 1) % len(outline)]
                    for j in range(refine):
                        t = j / refine
                        angle = math.atan2(y + (after[1] - y) * t, x + (after[0] - x) * t)
                        size = hole(angle)
                        rim.append(
                            vertex(
                                middle[0] + size * math.cos(angle) / 2, middle[1] + size * math.sin(angle) / 2, depth
                            )
                        )
                rims.append(rim)
            count = len(outline)
            for k in range(count):
                for side, order in ((0, 1), (1, -1)):
                    inner = [rims[side][(k * refine + j) % (count * refine)] for j in range(refine + 1)]
                    faces.append((borders[side][k], borders[side][(k + 1) % count], *inner[::-1])[::order])
            for k in range(count * refine):
                n = (k + 1) % (count * refine)
                faces.append((rims[0][k], rims[0][n], rims[1][n], rims[1][k]))
    for row, order in ((0, -1), (len(ROWS), 1)):  # close the wall at the foot and at the neck
        shift = 0.5 * ((row - 1 if row else 0) % 2)
        for k in range(COLUMNS * SIDE):
            a, b = shift + k / SIDE, shift + (k + 1) / SIDE
            faces.append(
                (vertex(a, row, 0.0), vertex(b, row, 0.0), vertex(b, row, THICKNESS), vertex(a, row, THICKNESS))[
                    ::order
                ]
            )
    return Shape(verts, faces)


def build() -> None:
    tools.start_scene(684, 513)
    build_room()
    x, y = 0.0, 0.25
    oak = tools.principled("Oak", (1, 1, 1), roughness=0.35)
    tools.image_texture(
        oak, pack("Oak", wood((0.42, 0.26, 0.15), (0.66, 0.46, 0.29), 256, seed=7)), socket="Base Color"
    )
    put("Table", table(1.15, 0.80, TABLE_HEIGHT).moved(x + 0.05, y), oak, metres=0.8)
    put("Chair", chair().moved(-0.98, -0.12, 0.0, 112), oak, metres=0.8)

    clay = tools.principled("Clay", (0.74, 0.50, 0.32), roughness=0.45)
    brass = tools.principled("Brass", (0.80, 0.56, 0.22), roughness=0.25, metallic=1.0)
    put("Lantern", carved_body().moved(x, y, TABLE_HEIGHT), clay)
    foot = lathe(
        smooth_profile(
            [
                (0.0, 0.001),
                (0.085, 0.001),
                (0.090, 0.006),
                (0.082, 0.014),
                (0.072, 0.024),
                (0.066, 0.024),
                (0.0, 0.018),
            ],
            4,
        ),
        64,
    )
    top = lathe(
        smooth_profile(
            [
                (0.0, 0.428),
                (0.053, 0.428),
                (0.058, 0.436),
                (0.050, 0.448),
                (0.030, 0.470),
                (0.014, 0.480),
                (0.010, 0.488),
                (0.016, 0.500),
                (0.009, 0.512),
                (0.0, 0.514),
            ],
            5,
        ),
        64,
    )
    ring = [(0.045 * math.sin(a), 0.0, 0.555 - 0.045 * math.cos(a)) for a in (math.pi * k / 8 for k in range(17))]
    put("Lantern fittings", (foot + top + tube(ring, 0.004, 12, 4)).moved(x, y, TABLE_HEIGHT), brass, True)
    tools.point_light("Bulb", (x, y, TABLE_HEIGHT + BULB), 190.0, (1.0, 0.74, 0.46), radius=0.002)

    put(
        "Glass ball",
        sphere(0.065, 64, 32).moved(x + 0.36, y - 0.20, TABLE_HEIGHT + 0.065),
        tools.glass("Glass", ior=1.5),
        True,
    )
    put(
        "Vase",
        vase(0.27).moved(x + 0.44, y + 0.17, TABLE_HEIGHT),
        tools.principled("Blue glaze", (0.06, 0.16, 0.30), roughness=0.12),
        True,
    )
    put(
        "Bowl",
        bowl(0.11).moved(x - 0.33, y - 0.17, TABLE_HEIGHT),
        tools.principled("White glaze", (0.72, 0.70, 0.66), roughness=0.15),
        True,
    )
    tools.camera((0.80, -1.72, 1.38), (-0.09, 0.5, 1.04), lens=27.0)


def build_room() -> None:
    plaster = tools.diffuse("Plaster", (0.74, 0.69, 0.62))
    tiles = tools.principled("Boards", (1, 1, 1), roughness=0.4)
    tools.image_texture(
        tiles, pack("Boards", wood((0.30, 0.20, 0.14), (0.52, 0.38, 0.27), 512, boards=6, seed=9)), socket="Base Color"
    )
    put("Floor", block((LEFT, NEAR, -0.1), (RIGHT, FAR, 0.0)), tiles, metres=1.2)
    put("Ceiling", block((LEFT, NEAR, CEILING), (RIGHT, FAR, CEILING + 0.1)), plaster)
    w = 0.1
    put(
        "Walls",
        block((LEFT - w, NEAR - w, -0.1), (LEFT, FAR + w, CEILING))
        + block((RIGHT, NEAR - w, -0.1), (RIGHT + w, FAR + w, CEILING))
        + block((LEFT, NEAR - w, -0.1), (RIGHT, NEAR, CEILING))
        + block((LEFT, FAR, -0.1), (RIGHT, FAR + w, CEILING)),
        plaster,
    )
    put(
        "Skirting",
        block((LEFT, NEAR, 0.0), (LEFT + 0.016, FAR, 0.09), 0.004)
        + block((LEFT, FAR - 0.016, 0.0), (RIGHT, FAR, 0.09), 0.004),
        tools.principled("Paint", (0.45, 0.36, 0.28), roughness=0.4),
    )


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
