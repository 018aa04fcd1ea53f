"""Meshes as plain vertices and faces, independent of Blender.

A `Shape` is a value: `moved` and `+` return new shapes. The corners of faces are anticlockwise as seen from outside. Metres, Z up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from mathutils import Matrix, Vector

from scene_tools import box_geometry, lathe_geometry


@dataclass(frozen=True)
class Shape:
    verts: list[Vector] = field(default_factory=list)
    faces: list[tuple[int, ...]] = field(default_factory=list)

    def __add__(self, other: Shape) -> Shape:
        first = len(self.verts)
        return Shape(self.verts + other.verts, self.faces + [tuple(i + first for i in face) for face in other.faces])

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0, turn: float = 0.0) -> Shape:
        """The shape, rotated about the vertical axis by `turn` degrees and then moved."""
        return self.placed(Matrix.Translation((x, y, z)) @ Matrix.Rotation(math.radians(turn), 4, "Z"))

    def placed(self, matrix: Matrix) -> Shape:
        faces = [face[::-1] for face in self.faces] if matrix.determinant() < 0.0 else self.faces
        return Shape([matrix @ v for v in self.verts], faces)


def block(low: tuple[float, float, float], high: tuple[float, float, float], bevel: float = 0.0) -> Shape:
    """A box between two corners. With `bevel`, its edges and corners are cut at 45 degrees."""
    if bevel <= 0.0:
        verts, faces = box_geometry(low, high)
        return Shape([Vector(v) for v in verts], faces)
    # Three vertices at each corner: vertex 3 * corner + axis lies on the face perpendicular to this axis.
    verts = []
    for corner in range(8):
        side = [corner >> axis & 1 for axis in range(3)]
        for axis in range(3):
            verts.append(
                Vector(
                    [
                        (high if side[k] else low)[k] if k == axis else (high[k] - bevel if side[k] else low[k] + bevel)
                        for k in range(3)
                    ]
                )
            )
    faces: list[tuple[int, ...]] = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, 1):
            ring = [side << axis | a << u | b << v for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
            faces.append(tuple(3 * c + axis for c in (ring if side else ring[::-1])))
        for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):  # the edges along this axis
            start, end = a << u | b << v, 1 << axis | a << u | b << v
            strip = (3 * start + u, 3 * end + u, 3 * end + v, 3 * start + v)
            faces.append(strip[::-1] if a == b else strip)
    for corner in range(8):
        odd = bin(corner).count("1") % 2
        faces.append(tuple(3 * corner + k for k in ((0, 1, 2) if odd else (2, 1, 0))))
    return Shape(verts, faces)


def four_walls(low: tuple[float, float], high: tuple[float, float], height: float, thick: float = 0.1) -> Shape:
    """The walls of a room whose inside is the rectangle from `low` to `high`, from the floor at z = 0."""
    (left, near), (right, far) = low, high
    return (
        block((left - thick, near, 0.0), (left, far, height))
        + block((right, near, 0.0), (right + thick, far, height))
        + block((left, near - thick, 0.0), (right, near, height))
        + block((left, far, 0.0), (right, far + thick, height))
    )


def lathe(profile: list[tuple[float, float]], segments: int = 48) -> Shape:
    """A surface of revolution around Z. The profile has (radius, height) pairs from bottom to top on the outer side; radius zero is a pole."""
    verts, faces = lathe_geometry(profile, segments)
    return Shape([Vector(v) for v in verts], faces)


def sphere(radius: float, segments: int = 48, rings: int = 24) -> Shape:
    profile = [
        (radius * math.sin(math.pi * k / rings) if 0 < k < rings else 0.0, -radius * math.cos(math.pi * k / rings))
        for k in range(rings + 1)
    ]
    return lathe(profile, segments)


def cylinder(radius: float, low: float, high: float, segments: int = 32) -> Shape:
    return lathe([(0.0, low), (radius, low), (radius, high), (0.0, high)], segments)


def tube(
    points: list[tuple[float, float, float]], radii: float | list[float], segments: int = 16, steps: int = 8
) -> Shape:
    """A round tube with caps along a smooth curve through `points`. The radius is interpolated like the points."""
    if not isinstance(radii, list):
        radii = [radii] * len(points)
    knots = [Vector((*p, r)) for p, r in zip(points, radii)]
    line = smooth_curve(knots, steps)
    verts: list[Vector] = []
    normal = None
    for k, knot in enumerate(line):
        before, after = line[max(k - 1, 0)], line[min(k + 1, len(line) - 1)]
        along = (after - before).to_3d().normalized()
        if normal is None:
            normal = along.orthogonal()
        normal = (normal - along * normal.dot(along)).normalized()
        across = along.cross(normal)
        for s in range(segments):
            angle = 2 * math.pi * s / segments
            verts.append(knot.to_3d() + knot[3] * (math.cos(angle) * normal + math.sin(angle) * across))
    rings = [list(range(k * segments, (k + 1) * segments)) for k in range(len(line))]
    faces = [(a[k - 1], a[k], b[k], b[k - 1]) for a, b in zip(rings, rings[1:]) for k in range(segments)]
    return Shape(verts, faces + [tuple(rings[0][::-1]), tuple(rings[-1])])


def smooth_curve(knots: list[Vector], steps: int) -> list[Vector]:
    """A Catmull-Rom curve through the knots with `steps` points for each span."""
    line = []
    for k in range(len(knots) - 1):
        p0, p1, p2, p3 = knots[max(k - 1, 0)], knots[k], knots[k + 1], knots[min(k + 2, len(knots) - 1)]
        for s in range(steps):
            t = s / steps
            line.append(
                0.5
                * (
                    2 * p1
                    + t * (p2 - p0)
                    + t * t * (2 * p0 - 5 * p1 + 4 * p2 - p3)
                    + t * t * t * (3 * p1 - p0 - 3 * p2 + p3)
                )
            )
    return line + [knots[-1]]


def smooth_profile(profile: list[tuple[float, float]], steps: int = 6) -> list[tuple[float, float]]:
    """A profile for `lathe`, rounded by a smooth curve. Ends on the axis stay on the axis."""
    line = smooth_curve([Vector(p) for p in profile], steps)
    return [(p.x if p.x > 1e-6 else 0.0, p.y) for p in line]


def cushion(width: float, depth: float, height: float, bulge: float = 4.0, cells: int = 12) -> Shape:
    """A pillow: a superellipsoid around the origin, which is more box-like for a larger `bulge`."""

    def power(value: float, exponent: float) -> float:
        return math.copysign(abs(value) ** exponent, value)

    ball = sphere(1.0, 4 * cells, cells)
    verts = []
    for v in ball.verts:
        flat = math.hypot(v.x, v.y)
        level = power(flat, 2 / bulge)
        verts.append(
            Vector(
                (
                    width / 2 * level * power(v.x / flat if flat else 0.0, 2 / bulge),
                    depth / 2 * level * power(v.y / flat if flat else 0.0, 2 / bulge),
                    height / 2 * power(v.z, 0.8),
                )
            )
        )
    return Shape(verts, ball.faces)
