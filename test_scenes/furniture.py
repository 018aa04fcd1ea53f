"""Furniture and small objects as shapes, and two functions that add shapes to a scene."""

from __future__ import annotations

import math
import random

import bpy
import numpy as np
from mathutils import Matrix, Vector

import scene_tools
from shapes import Shape, block, cushion, cylinder, lathe, smooth_profile, tube


def put(
    name: str, shape: Shape, material: bpy.types.Material, smooth: bool = False, metres: float = 1.0
) -> bpy.types.Object:
    """Add the shape with texture coordinates. Each part is projected along its faces, with U along its longest side and one repetition of the image per `metres`."""
    obj = scene_tools.add_mesh(name, [tuple(v) for v in shape.verts], shape.faces, material, smooth)
    mesh = obj.data
    part = _parts(shape)
    places = np.array([tuple(v) for v in shape.verts])
    layer = mesh.uv_layers.new(name="UVMap") if not mesh.uv_layers else mesh.uv_layers[0]
    sizes = {p: np.ptp(places[part == p], axis=0) for p in set(part)}
    shift = (
        {p: random.Random(k).random() for k, p in enumerate(sorted(sizes))}
        if len(sizes) > 1
        else dict.fromkeys(sizes, 0.0)
    )
    for polygon in mesh.polygons:
        p = part[polygon.vertices[0]]
        across = int(np.argmax(np.abs(polygon.normal)))
        u, v = sorted((axis for axis in range(3) if axis != across), key=lambda axis: -sizes[p][axis])
        for loop in polygon.loop_indices:
            place = places[mesh.loops[loop].vertex_index]
            layer.data[loop].uv = (place[u] / metres + shift[p], place[v] / metres + 0.618 * shift[p])
    return obj


def _parts(shape: Shape) -> np.ndarray:
    """The number of the connected part of each vertex."""
    parent = list(range(len(shape.verts)))

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    for face in shape.faces:
        for i in face[1:]:
            parent[root(i)] = root(face[0])
    return np.array([root(i) for i in range(len(parent))])


def put_image(
    name: str,
    corner: tuple[float, float, float],
    right: tuple[float, float, float],
    up: tuple[float, float, float],
    material: bpy.types.Material,
) -> bpy.types.Object:
    """A rectangle, given from its lower left corner. The image covers it exactly once."""
    c, r, u = Vector(corner), Vector(right), Vector(up)
    obj = scene_tools.add_mesh(
        name, [tuple(c), tuple(c + r), tuple(c + r + u), tuple(c + u)], [(0, 1, 2, 3)], material, False
    )
    layer = obj.data.uv_layers.new(name="UVMap") if not obj.data.uv_layers else obj.data.uv_layers[0]
    for loop, uv in zip(layer.data, ((0, 0), (1, 0), (1, 1), (0, 1))):
        loop.uv = uv
    return obj


# Furniture, standing on z = 0 with its front towards -Y.


def table(width: float, depth: float, height: float, leg: float = 0.07) -> Shape:
    x, y = width / 2, depth / 2
    shape = block((-x, -y, height - 0.035), (x, y, height), 0.008)
    for sx in (-1, 1):
        for sy in (-1, 1):
            cx, cy = sx * (x - 0.08), sy * (y - 0.08)
            shape += taper(cx, cy, 0.0, height - 0.035, 0.6 * leg, leg)
        shape += block(
            (sx * (x - 0.08) - 0.012, -y + 0.08, height - 0.125), (sx * (x - 0.08) + 0.012, y - 0.08, height - 0.035)
        )
    for sy in (-1, 1):
        shape += block(
            (-x + 0.08, sy * (y - 0.08) - 0.012, height - 0.125), (x - 0.08, sy * (y - 0.08) + 0.012, height - 0.035)
        )
    return shape


def taper(x: float, y: float, low: float, high: float, foot: float, head: float) -> Shape:
    """A square leg that is thinner at the foot."""
    leg = block((-1, -1, low), (1, 1, high))
    return Shape(
        [
            Vector((x + v.x * (foot if v.z == low else head) / 2, y + v.y * (foot if v.z == low else head) / 2, v.z))
            for v in leg.verts
        ],
        leg.faces,
    )


def chair() -> Shape:
    """A wooden chair with a seat 0.45 m high and a tilted back at +Y."""
    lean = 0.10
    shape = block((-0.22, -0.22, 0.43), (0.22, 0.21, 0.46), 0.01)
    for sx in (-1, 1):
        shape += taper(sx * 0.19, -0.19, 0.0, 0.43, 0.026, 0.040)
        post = block((sx * 0.20 - 0.018, 0.175, 0.0), (sx * 0.20 + 0.018, 0.211, 0.94), 0.005)
        shape += Shape(
            [
                v + Vector((0, lean * max(0.0, v.z - 0.45) ** 1.0 / 0.5 + 0.06 * max(0.0, 0.43 - v.z), 0))
                for v in post.verts
            ],
            post.faces,
        )
        shape += block((sx * 0.19 - 0.009, -0.18, 0.20), (sx * 0.19 + 0.009, 0.19, 0.235))
    for height, size in ((0.86, 0.085), (0.73, 0.045), (0.61, 0.045)):
        y = 0.182 + lean * (height - 0.45) / 0.5
        shape += block((-0.185, y, height - size / 2), (0.185, y + 0.018, height + size / 2), 0.004)
    shape += block((-0.18, -0.20, 0.375), (0.18, -0.182, 0.43))
    return shape


def door(width: float, height: float, thickness: float = 0.042) -> Shape:
    """A door with four raised panels: the hinge is along Z at x = 0, the leaf towards -X, its central plane at y = 0."""
    t = thickness / 2
    rail, panels = 0.115, ((0.20, 0.92), (1.06, height - 0.13))
    shape = Shape()
    edges = [0.0, rail, width / 2 - rail / 2, width / 2 + rail / 2, width - rail, width]
    for left, right in ((0, 1), (2, 3), (4, 5)):
        shape += block((-edges[right], -t, 0.008), (-edges[left], t, height), 0.003)
    for low, high in ((0.008, panels[0][0]), (panels[0][1], panels[1][0]), (panels[1][1], height)):
        for left, right in ((1, 2), (3, 4)):
            shape += block((-edges[right], -t, low), (-edges[left], t, high))
    for low, high in panels:
        for left, right in ((1, 2), (3, 4)):
            shape += block((-edges[right], -t + 0.014, low), (-edges[left], t - 0.014, high))
            shape += block(
                (-edges[right] + 0.035, -t + 0.003, low + 0.035), (-edges[left] - 0.035, t - 0.003, high - 0.035), 0.010
            )
    return shape


def door_handles(width: float, thickness: float = 0.042) -> Shape:
    """Two lever handles with round plates, at the free edge of `door`."""
    shape = Shape()
    for side in (-1, 1):
        y = side * thickness / 2
        plate = cylinder(0.026, 0.0, 0.008, 24).placed(
            Matrix.Translation((-width + 0.06, y, 1.0)) @ Matrix.Rotation(side * -math.pi / 2, 4, "X")
        )
        shape += plate + tube(
            [
                (-width + 0.06, y, 1.0),
                (-width + 0.06, y + side * 0.04, 1.0),
                (-width + 0.075, y + side * 0.052, 1.0),
                (-width + 0.12, y + side * 0.054, 1.0),
                (-width + 0.18, y + side * 0.05, 0.998),
            ],
            [0.009, 0.009, 0.010, 0.010, 0.008],
            12,
            6,
        )
    return shape


def frame(width: float, height: float, wide: float = 0.05, deep: float = 0.03) -> Shape:
    """A picture frame around the origin for a picture of the given size, with its back at y = 0."""
    x, z = width / 2, height / 2
    return (
        block((-x - wide, -deep, z), (x + wide, 0, z + wide), 0.006)
        + block((-x - wide, -deep, -z - wide), (x + wide, 0, -z), 0.006)
        + block((-x - wide, -deep, -z), (-x, 0, z), 0.006)
        + block((x, -deep, -z), (x + wide, 0, z), 0.006)
    )


def sofa(width: float = 1.9, cells: int = 12) -> tuple[Shape, Shape]:
    """Frame with legs, and upholstery."""
    x = width / 2
    legs = Shape()
    for sx in (-1, 1):
        for y in (-0.38, 0.38):
            legs += taper(sx * (x - 0.08), y, 0.0, 0.13, 0.03, 0.05)
    soft = cushion(width, 0.88, 0.22, 12, cells).moved(z=0.23)
    for sx in (-1, 1):
        soft += cushion(0.18, 0.90, 0.46, 7, cells).moved(x=sx * (x - 0.09), z=0.38)
        soft += cushion(x - 0.17, 0.70, 0.18, 7, cells).moved(x=sx * (x - 0.18) / 2, y=-0.06, z=0.40)
        back = cushion(x - 0.17, 0.20, 0.50, 6, cells).placed(Matrix.Rotation(math.radians(-12), 4, "X"))
        soft += back.moved(x=sx * (x - 0.18) / 2, y=0.24, z=0.66)
    soft += cushion(width - 0.1, 0.20, 0.62, 9, cells).moved(y=0.38, z=0.44)
    return legs, soft


def shelf(width: float, depth: float, height: float, boards: int, board: float = 0.025) -> Shape:
    """An open bookcase with its back at y = 0, which faces -Y."""
    shape = block((-width / 2, -0.012, 0.0), (width / 2, 0.0, height))
    for sx in (-1, 1):
        shape += block((sx * width / 2 - board / 2, -depth, 0.0), (sx * width / 2 + board / 2, 0.0, height), 0.003)
    for k in range(boards + 1):
        z = 0.06 + (height - 0.06 - board) * k / boards
        shape += block((-width / 2, -depth, z), (width / 2, -0.012, z + board), 0.003)
    return shape


def book(thick: float, depth: float, high: float) -> tuple[Shape, Shape]:
    """Cover and pages from x = 0, with the spine towards -Y."""
    cover = (
        block((0, 0, 0), (0.003, depth, high))
        + block((thick - 0.003, 0, 0), (thick, depth, high))
        + block((0, -0.003, 0), (thick, 0, high), 0.001)
    )
    return cover, block((0.003, 0, 0.004), (thick - 0.003, depth - 0.005, high - 0.004))


# Things to put on a table, standing on z = 0.


def teapot(size: float = 0.15, segments: int = 64, steps: int = 8) -> Shape:
    """Body, lid and knob, with the spout towards +X and the handle towards -X. `size` is the height, `steps` the number of steps of curves."""
    s = size / 0.15
    body = lathe(
        smooth_profile(
            [
                (0.0, 0.0),
                (0.035, 0.001),
                (0.048, 0.004),
                (0.056, 0.012),
                (0.076, 0.038),
                (0.082, 0.062),
                (0.073, 0.092),
                (0.055, 0.112),
                (0.050, 0.116),
                (0.047, 0.114),
                (0.0, 0.108),
            ],
            steps,
        ),
        segments,
    )
    lid = lathe(
        smooth_profile(
            [
                (0.0, 0.110),
                (0.046, 0.112),
                (0.047, 0.117),
                (0.036, 0.127),
                (0.014, 0.134),
                (0.007, 0.138),
                (0.010, 0.144),
                (0.014, 0.149),
                (0.010, 0.155),
                (0.0, 0.156),
            ],
            steps,
        ),
        segments,
    )
    spout = tube(
        [(0.060, 0, 0.040), (0.092, 0, 0.048), (0.112, 0, 0.076), (0.124, 0, 0.104), (0.140, 0, 0.116)],
        [0.021, 0.019, 0.013, 0.0095, 0.0085],
        segments // 2,
        steps,
    )
    handle = tube(
        [
            (-0.066, 0, 0.098),
            (-0.092, 0, 0.108),
            (-0.122, 0, 0.098),
            (-0.128, 0, 0.068),
            (-0.108, 0, 0.040),
            (-0.074, 0, 0.030),
        ],
        [0.008, 0.0075, 0.007, 0.007, 0.0075, 0.009],
        segments // 3,
        steps,
    )
    return (body + lid + spout + handle).placed(Matrix.Scale(s, 4))


def wine_glass(height: float = 0.19, segments: int = 64) -> Shape:
    """One closed surface, so that light is refracted by a wall 1.5 mm thick."""
    outside = smooth_profile(
        [
            (0.0, 0.0),
            (0.030, 0.0),
            (0.0335, 0.002),
            (0.031, 0.0045),
            (0.012, 0.009),
            (0.0045, 0.020),
            (0.0038, 0.055),
            (0.0050, 0.082),
            (0.018, 0.094),
            (0.033, 0.112),
            (0.0385, 0.135),
            (0.0355, 0.165),
            (0.0320, 0.190),
        ],
        6,
    )
    inside = smooth_profile(
        [(0.0305, 0.190), (0.0340, 0.165), (0.0370, 0.135), (0.0315, 0.113), (0.017, 0.0965), (0.0, 0.0915)], 6
    )
    return lathe(outside + inside, segments).placed(Matrix.Scale(height / 0.19, 4))


def tumbler(radius: float = 0.036, height: float = 0.10, segments: int = 64) -> Shape:
    return lathe(
        [
            (0.0, 0.0),
            (0.90 * radius, 0.0),
            (0.93 * radius, 0.002),
            (radius, height - 0.001),
            (radius - 0.0008, height),
            (radius - 0.0018, height),
            (radius - 0.0025, height - 0.001),
            (0.93 * radius - 0.003, 0.012),
            (0.88 * radius - 0.003, 0.009),
            (0.0, 0.009),
        ],
        segments,
    )


def bottle(height: float = 0.30, radius: float = 0.038, shoulder: float = 0.62, segments: int = 48) -> Shape:
    """One closed surface with walls 3 mm thick and a thick foot. The neck begins at the fraction `shoulder` of the height."""
    neck, lip, wall = 0.38 * radius, 0.45 * radius, 0.003
    outside = [
        (0.0, 0.006),
        (0.6 * radius, 0.003),
        (0.86 * radius, 0.0),
        (radius, 0.006),
        (radius, 0.3 * height),
        (radius, (shoulder - 0.06) * height),
        (0.93 * radius, shoulder * height),
        (neck, (shoulder + 0.15) * height),
        (neck, 0.94 * height),
        (lip, 0.95 * height),
        (lip, height - 0.002),
        (lip - 0.0015, height),
    ]
    inside = [
        (neck - wall, height),
        (neck - wall, (shoulder + 0.15) * height),
        (0.93 * radius - wall, shoulder * height),
        (radius - wall, (shoulder - 0.06) * height),
        (radius - wall, 0.3 * height),
        (radius - wall, 0.018),
        (0.8 * radius, 0.011),
        (0.0, 0.014),
    ]
    return lathe(smooth_profile(outside, 5) + smooth_profile(inside, 5), segments)


def vase(height: float = 0.30, segments: int = 48, steps: int = 6) -> Shape:
    k = height / 0.30
    return lathe(
        [
            (r * k, z * k)
            for r, z in smooth_profile(
                [
                    (0.0, 0.0),
                    (0.045, 0.0),
                    (0.055, 0.012),
                    (0.088, 0.10),
                    (0.085, 0.16),
                    (0.045, 0.235),
                    (0.030, 0.262),
                    (0.042, 0.30),
                    (0.038, 0.299),
                    (0.025, 0.262),
                    (0.040, 0.23),
                    (0.0, 0.20),
                ],
                steps,
            )
        ],
        segments,
    )


def bowl(radius: float = 0.13, segments: int = 64, steps: int = 6) -> Shape:
    k = radius / 0.13
    return lathe(
        [
            (r * k, z * k)
            for r, z in smooth_profile(
                [
                    (0.0, 0.0),
                    (0.045, 0.0),
                    (0.052, 0.006),
                    (0.095, 0.030),
                    (0.128, 0.072),
                    (0.130, 0.076),
                    (0.125, 0.075),
                    (0.092, 0.037),
                    (0.05, 0.015),
                    (0.0, 0.011),
                ],
                steps,
            )
        ],
        segments,
    )


def plant(leaves: int = 26, seed: int = 4) -> tuple[Shape, Shape]:
    """A pot plant: the pot with its soil, and long bent leaves."""
    rng = random.Random(seed)
    pot = lathe(
        [(0.0, 0.0), (0.11, 0.0), (0.15, 0.26), (0.16, 0.26), (0.16, 0.30), (0.14, 0.30), (0.135, 0.27), (0.0, 0.27)],
        48,
    )
    green = Shape()
    for k in range(leaves):
        angle = 2.4 * k + rng.uniform(-0.3, 0.3)
        reach, rise, wide = rng.uniform(0.15, 0.46), rng.uniform(0.45, 0.95), rng.uniform(0.030, 0.045)
        out, side = Vector((math.cos(angle), math.sin(angle), 0)), Vector((-math.sin(angle), math.cos(angle), 0))
        verts, faces, cells = [], [], 14
        for c in range(cells + 1):
            t = c / cells
            middle = out * (0.04 + reach * t**1.6) + Vector((0, 0, 0.26 + rise * (t - 0.45 * t**3)))
            half = wide * (0.25 + 1.3 * t) * (1 - t) ** 0.6
            verts += [
                middle - side * half + Vector((0, 0, 0.4 * half)),
                middle,
                middle + side * half + Vector((0, 0, 0.4 * half)),
            ]
            if c:
                b = 3 * c
                faces += [(b - 3, b - 2, b + 1, b), (b - 2, b - 1, b + 2, b + 1)]
        green += Shape(verts, faces)
    return pot, green
