"""Meshes from signed distances: shapes, functions that combine them, and surface nets.

A shape is a function from point arrays (x, y, z) to distances, which are negative inside and need not be exact far from the surface. `surface_net`
evaluates it on a rectilinear grid, whose planes may be closer where more detail is needed, and returns quads with one vertex in each cell that the
surface crosses [Gibson 1998].
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

Array = np.ndarray
Shape = Callable[[Array, Array, Array], Array]


def ellipsoid(x: Array, y: Array, z: Array, centre: Sequence[float], radii: Sequence[float]) -> Array:
    u, v, w = x - centre[0], y - centre[1], z - centre[2]
    k0 = np.sqrt((u / radii[0]) ** 2 + (v / radii[1]) ** 2 + (w / radii[2]) ** 2)
    k1 = np.sqrt((u / radii[0] ** 2) ** 2 + (v / radii[1] ** 2) ** 2 + (w / radii[2] ** 2) ** 2)
    return k0 * (k0 - 1.0) / np.maximum(k1, 1e-6)


def limb(x: Array, y: Array, z: Array, a: Sequence[float], b: Sequence[float], ra: float,
         rb: float | None = None) -> Array:
    """A capsule from a to b whose radius runs from ra to rb."""
    rb = ra if rb is None else rb
    d = np.subtract(b, a)
    u, v, w = x - a[0], y - a[1], z - a[2]
    t = np.clip((u * d[0] + v * d[1] + w * d[2]) / np.dot(d, d), 0.0, 1.0)
    return np.sqrt((u - t * d[0]) ** 2 + (v - t * d[1]) ** 2 + (w - t * d[2]) ** 2) - (ra + (rb - ra) * t)


def join(a: Array, b: Array, k: float) -> Array:
    """The union of a and b with a fillet of width k."""
    h = np.maximum(k - np.abs(a - b), 0.0) / k
    return np.minimum(a, b) - h * h * k * 0.25


def carve(a: Array, b: Array, k: float) -> Array:
    """a without b; the edge is rounded by k."""
    return -join(-a, b, k)


def common(a: Array, b: Array, k: float) -> Array:
    """The intersection of a and b; the edge is rounded by k."""
    return -join(-a, -b, k)


def axis(low: float, high: float, step: float, fine: tuple[float, float, float] | None = None) -> Array:
    """Grid planes from low to high with distance `step`. With fine = (from, to, step), they are closer in this interval."""
    def stretch(a: float, b: float, h: float) -> Array:
        return np.linspace(a, b, max(1, round((b - a) / h)), endpoint=False)

    if fine is None:
        return np.append(stretch(low, high, step), high)
    a, b, h = fine
    return np.concatenate([stretch(low, a, step), stretch(a, b, h), stretch(b, high, step), [high]])


def surface_net(shape: Shape, xs: Array, ys: Array, zs: Array) -> tuple[Array, Array]:
    """Vertices (n, 3) and quads (m, 4) with outward normals. The surface must not touch the border of the grid."""
    values = shape(*np.meshgrid(xs, ys, zs, indexing="ij", sparse=True))
    inside = values < 0.0
    counts = np.array(values.shape)

    # The cells that the surface crosses, and the index of the vertex of each.
    corner_sum = sum(inside[i:counts[0] - 1 + i, j:counts[1] - 1 + j, k:counts[2] - 1 + k].astype(np.int8)
                     for i in (0, 1) for j in (0, 1) for k in (0, 1))
    cells = np.argwhere((corner_sum > 0) & (corner_sum < 8))
    index = np.full(corner_sum.shape, -1, np.int64)
    index[tuple(cells.T)] = np.arange(len(cells))

    # The vertex of a cell is the mean of the crossings on its twelve edges.
    total = np.zeros((len(cells), 3))
    crossings = np.zeros(len(cells))
    planes = (xs, ys, zs)
    for along in range(3):
        p, q = (along + 1) % 3, (along + 2) % 3
        for i in (0, 1):
            for j in (0, 1):
                start = cells.copy()
                start[:, p] += i
                start[:, q] += j
                end = start.copy()
                end[:, along] += 1
                a, b = values[tuple(start.T)], values[tuple(end.T)]
                cut = (a < 0.0) != (b < 0.0)
                t = np.where(cut, a / np.where(cut, a - b, 1.0), 0.0)
                for d in range(3):
                    first, last = planes[d][start[:, d]], planes[d][end[:, d]]
                    total[:, d] += np.where(cut, first + t * (last - first), 0.0)
                crossings += cut
    vertices = total / crossings[:, None]

    # Each crossed edge gives a quad of the vertices of the four cells around it.
    quads = []
    for along in range(3):
        p, q = (along + 1) % 3, (along + 2) % 3
        low = [slice(None)] * 3
        high = [slice(None)] * 3
        low[along], high[along] = slice(0, -1), slice(1, None)
        cut = inside[tuple(low)] != inside[tuple(high)]
        edges = np.argwhere(cut)
        edges = edges[(edges[:, p] > 0) & (edges[:, q] > 0) & (edges[:, p] < counts[p] - 1)
                      & (edges[:, q] < counts[q] - 1)]
        round_edge = []
        for i, j in ((-1, -1), (0, -1), (0, 0), (-1, 0)):
            cell = edges.copy()
            cell[:, p] += i
            cell[:, q] += j
            round_edge.append(index[tuple(cell.T)])
        quad = np.stack(round_edge, axis=1)
        leaving = inside[tuple(edges.T)]
        quads.append(np.where(leaving[:, None], quad, quad[:, ::-1]))
    return vertices, np.concatenate(quads)
