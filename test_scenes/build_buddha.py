"""A seated Buddha: dense, detailed geometry in soft light (thesis, figures 5.2 and 6.1).

Each part of the figure is a signed distance function with its own material: skin, robe, hair and lotus seat. The file stores the surface nets; a
Subdivision modifier makes them dense for the render. The camera is on the side of -Y. Heights are measured from the seat.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import numpy as np
import scene_tools as tools
from implicit_mesh import Array, Shape, axis, carve, common, ellipsoid, join, limb, surface_net

SEAT = 0.46  # Height of the seat above the plinth.
HEAD = (0.0, -0.01, 1.27)
HEAD_RADII = (0.200, 0.222, 0.255)


# --- The figure ------------------------------------------------------------------------------------------------------

def torso(x: Array, y: Array, z: Array) -> Array:
    d = ellipsoid(x, y, z, (0, 0.08, 0.20), (0.44, 0.33, 0.26))
    d = join(d, ellipsoid(x, y, z, (0, 0.07, 0.48), (0.300, 0.215, 0.36)), 0.10)
    d = join(d, ellipsoid(x, y, z, (0, 0.06, 0.76), (0.350, 0.205, 0.20)), 0.12)
    for side in (-1, 1):
        d = join(d, limb(x, y, z, (0, 0.08, 0.94), (0.37 * side, 0.08, 0.84), 0.105, 0.118), 0.10)
        d = join(d, ellipsoid(x, y, z, (0.15 * side, -0.08, 0.79), (0.13, 0.07, 0.09)), 0.08)
    return d


def arm(x: Array, y: Array, z: Array, side: int) -> Array:
    shoulder, elbow, wrist = (0.405 * side, 0.08, 0.82), (0.52 * side, 0.03, 0.43), (0.19 * side, -0.37, 0.28)
    return join(limb(x, y, z, shoulder, elbow, 0.120, 0.098), limb(x, y, z, elbow, wrist, 0.100, 0.062), 0.04)


def legs(x: Array, y: Array, z: Array) -> Array:
    d = ellipsoid(x, y, z, (0, -0.10, 0.05), (0.72, 0.42, 0.08))
    for side in (-1, 1):
        knee = (0.70 * side, -0.20, 0.135)
        d = join(d, limb(x, y, z, (0.20 * side, 0.08, 0.18), knee, 0.20, 0.135), 0.06)
        d = join(d, limb(x, y, z, knee, (-0.02 * side, -0.42, 0.13 + 0.02 * side), 0.135, 0.095), 0.06)
    return d


def hands(x: Array, y: Array, z: Array) -> Array:
    """The right hand lies in the left one, palms up, thumbs touching."""
    d = ellipsoid(x, y, z, (0.08, -0.42, 0.255), (0.17, 0.10, 0.035))
    d = join(d, ellipsoid(x, y, z, (-0.08, -0.42, 0.295), (0.16, 0.09, 0.032)), 0.02)
    for finger in range(4):
        forward = -0.485 + 0.042 * finger
        d = join(d, limb(x, y, z, (-0.10, forward, 0.308), (0.10 - 0.012 * abs(finger - 1), forward, 0.318), 0.023,
                         0.018), 0.012)
        d = join(d, limb(x, y, z, (0.10, forward - 0.02, 0.262), (-0.12, forward - 0.02, 0.265), 0.023, 0.019), 0.012)
    for side in (-1, 1):
        d = join(d, limb(x, y, z, (0.14 * side, -0.43, 0.315), (0.085 * side, -0.44, 0.372), 0.028, 0.023), 0.02)
        d = join(d, limb(x, y, z, (0.085 * side, -0.44, 0.372), (0.006 * side, -0.445, 0.392), 0.023, 0.017), 0.012)
    return d


def head(x: Array, y: Array, z: Array) -> Array:
    d = ellipsoid(x, y, z, HEAD, HEAD_RADII)
    d = join(d, ellipsoid(x, y, z, (0, -0.07, 1.155), (0.150, 0.135, 0.125)), 0.06)
    d = join(d, ellipsoid(x, y, z, (0, -0.175, 1.075), (0.050, 0.035, 0.036)), 0.05)
    for side in (-1, 1):
        d = join(d, ellipsoid(x, y, z, (0.100 * side, -0.165, 1.185), (0.055, 0.040, 0.055)), 0.06)
        # Brow: an arch that runs into the nose.
        arch = [(0.018, -0.238, 1.300), (0.045, -0.236, 1.338), (0.095, -0.216, 1.352), (0.150, -0.172, 1.330)]
        for a, b in zip(arch, arch[1:]):
            d = join(d, limb(x, y, z, (a[0] * side, *a[1:]), (b[0] * side, *b[1:]), 0.009, 0.008), 0.022)
        # Socket, lowered lid, and the line where the lids meet.
        d = carve(d, ellipsoid(x, y, z, (0.085 * side, -0.250, 1.298), (0.062, 0.036, 0.032)), 0.03)
        d = join(d, ellipsoid(x, y, z, (0.083 * side, -0.184, 1.283), (0.056, 0.036, 0.030)), 0.012)
        slit = [(0.032, -0.216, 1.268), (0.060, -0.226, 1.262), (0.090, -0.221, 1.262), (0.132, -0.190, 1.270)]
        for a, b in zip(slit, slit[1:]):
            d = carve(d, limb(x, y, z, (a[0] * side, *a[1:]), (b[0] * side, *b[1:]), 0.0055), 0.006)
        # Ear with a long lobe.
        ear = ellipsoid(x, y, z, (0.205 * side, 0.015, 1.225), (0.028, 0.058, 0.095))
        ear = carve(ear, ellipsoid(x, y, z, (0.240 * side, 0.000, 1.240), (0.022, 0.030, 0.055)), 0.015)
        ear = join(ear, limb(x, y, z, (0.207 * side, 0.010, 1.18), (0.190 * side, 0.000, 1.045), 0.026, 0.024), 0.03)
        d = join(d, ear, 0.015)
    # Nose: bridge, tip and wings.
    d = join(d, limb(x, y, z, (0, -0.228, 1.315), (0, -0.258, 1.212), 0.017, 0.023), 0.03)
    for side in (-1, 1):
        d = join(d, ellipsoid(x, y, z, (0.026 * side, -0.236, 1.203), (0.019, 0.022, 0.015)), 0.014)
    # Lips, drawn up at the corners.
    for side in (-1, 1):
        d = join(d, limb(x, y, z, (0.008 * side, -0.226, 1.149), (0.058 * side, -0.196, 1.151), 0.0145, 0.006), 0.012)
        d = join(d, limb(x, y, z, (0.004 * side, -0.220, 1.124), (0.046 * side, -0.198, 1.136), 0.0165, 0.007), 0.012)
        d = carve(d, limb(x, y, z, (0, -0.243, 1.1365), (0.064 * side, -0.201, 1.147), 0.0045), 0.006)
    return join(d, ellipsoid(x, y, z, (0, -0.231, 1.362), (0.013, 0.011, 0.013)), 0.006)


def skin(x: Array, y: Array, z: Array) -> Array:
    d = join(torso(x, y, z), arm(x, y, z, -1), 0.07)
    d = join(d, arm(x, y, z, 1), 0.07)
    d = join(d, limb(x, y, z, (0, 0.06, 0.90), (0, 0.02, 1.12), 0.112, 0.100), 0.07)
    d = join(d, head(x, y, z), 0.035)
    return join(d, hands(x, y, z), 0.03)


def robe(x: Array, y: Array, z: Array) -> Array:
    """Cloth over the left shoulder and arm, waist and legs: the body, thickened and with folds."""
    left = join(torso(x, y, z), arm(x, y, z, 1), 0.07)
    # The sleeve hangs down and closes the gap between arm and side.
    left = join(left, ellipsoid(x, y, z, (0.40, 0.04, 0.56), (0.13, 0.09, 0.24)), 0.06)
    # From the shoulder the folds hang in widening curves; over the legs they run round the hands.
    hang = np.sqrt((x - 0.42) ** 2 + 0.6 * (y - 0.05) ** 2 + (z - 1.02) ** 2)
    wave = np.sin(hang * 2.0 * math.pi / 0.088 + 0.9 * np.sin(5.0 * x + 4.0 * z))
    upper = left - 0.020 - 0.009 * wave
    # Its edge runs from the right hip to the left of the neck; the back is covered as high as that.
    edge = 0.80 * (x + 0.27) - 0.60 * (z - 0.44) + 0.02 * np.sin(9.0 * z)
    upper = common(upper, -np.where(y > 0.10, np.maximum(edge, x + 0.2), edge), 0.02)
    # The sleeve leaves the wrist free.
    upper = carve(upper, ellipsoid(x, y, z, (0.08, -0.52, 0.30), (0.27, 0.24, 0.14)), 0.02)

    around = np.sqrt(0.55 * x * x + (y + 0.36) ** 2 + 1.2 * (z - 0.30) ** 2)
    wave = np.sin(around * 2.0 * math.pi / 0.098 + 1.2 * np.sin(4.0 * x + 1.0))
    lower = join(legs(x, y, z), torso(x, y, np.maximum(z, 0.2)), 0.06) - 0.020 - 0.010 * wave
    lower = common(lower, z - 0.40 - 0.05 * np.cos(4.0 * x), 0.03)
    lower = carve(lower, ellipsoid(x, y, z, (0.0, -0.44, 0.345), (0.25, 0.13, 0.10)), 0.02)
    # The hem fans out in front.
    pleats = np.sin(np.arctan2(x, 0.25 - y) * 26.0)
    hem = ellipsoid(x, y, z, (0, -0.30, 0.025), (0.46, 0.34, 0.045)) - 0.009 * pleats
    return join(join(upper, lower, 0.03), hem, 0.03)


def curls() -> np.ndarray:
    """Positions of the curls: a spiral over the head where hair grows, and a smaller one over the knot on the crown."""
    places = []
    turn = math.pi * (3.0 - math.sqrt(5.0))
    for centre, radii, count in ((HEAD, np.array(HEAD_RADII) + 0.006, 620), ((0, 0.03, 1.505), (0.105,) * 3, 150)):
        for i in range(count):
            up = 1.0 - 2.0 * (i + 0.5) / count
            ring = math.sqrt(1.0 - up * up)
            places.append(np.multiply((ring * math.cos(i * turn), ring * math.sin(i * turn), up), radii) + centre)
    places = np.array(places)
    return places[hair_line(places[:, 0], places[:, 1], places[:, 2]) > 0.0]


def hair_line(x: Array, y: Array, z: Array) -> Array:
    """Positive where hair grows: above the brow in front, down to the neck behind, not at the ears."""
    return z - 1.412 + 1.10 * np.clip(y + 0.20, 0.0, 0.30) - 0.04 * np.clip(-y - 0.1, 0, 1) + 0.05 * np.abs(x)


def hair(x: Array, y: Array, z: Array) -> Array:
    cap = ellipsoid(x, y, z, HEAD, np.array(HEAD_RADII) + 0.008)
    cap = common(cap, -hair_line(x, y, z), 0.015)
    d = join(cap, ellipsoid(x, y, z, (0, 0.03, 1.505), (0.100, 0.100, 0.100)), 0.03)
    x, y, z = np.broadcast_arrays(x, y, z)
    near = np.full(d.shape, 1.0)
    for place in curls():
        # Only the few grid planes near a curl are affected by it.
        around = tuple(slice(*np.searchsorted(line, (c - 0.05, c + 0.05)))
                       for line, c in zip((x[:, 0, 0], y[0, :, 0], z[0, 0, :]), place))
        u, v, w = x[around] - place[0], y[around] - place[1], z[around] - place[2]
        near[around] = np.minimum(near[around], np.sqrt(u * u + v * v + w * w) - 0.0205)
    return join(d, near, 0.006)


def lotus(x: Array, y: Array, z: Array) -> Array:
    """A double row of petals on a stepped foot. It is oval and therefore computed in scaled coordinates."""
    x, y, z = x / 0.95, (y + 0.07) / 0.74, z + 0.0
    radius, angle = np.sqrt(x * x + y * y), np.arctan2(y, x)

    def disc(height: float, half: float, wide: float, rounding: float) -> Array:
        u, v = radius - wide + rounding, np.abs(z - height) - half + rounding
        return np.sqrt(np.maximum(u, 0) ** 2 + np.maximum(v, 0) ** 2) + np.minimum(np.maximum(u, v), 0) - rounding

    def around(count: int, offset: float) -> tuple[Array, Array]:
        step = 2.0 * math.pi / count
        folded = np.mod(angle + offset * step, step) - step / 2.0
        return radius * np.cos(folded), radius * np.sin(folded)

    d = disc(-0.03, 0.03, 0.97, 0.02)
    d = join(d, disc(-0.13, 0.11, 0.90, 0.05), 0.03)
    d = join(d, disc(-0.26, 0.07, 0.86, 0.03), 0.03)
    d = join(d, disc(-0.38, 0.035, 0.98, 0.015), 0.02)
    d = join(d, disc(-0.435, 0.025, 1.06, 0.012), 0.012)
    for offset, lean, height, out, high in ((0.0, 0.42, -0.125, 0.925, 0.120), (0.5, 0.30, -0.115, 0.890, 0.125),
                                            (0.5, -0.45, -0.295, 0.915, 0.075)):
        along, across = around(18, offset)
        # Leaning out towards the tip, and pointed there.
        tip = np.clip((z - height) / high * np.sign(lean), 0.0, 1.0)
        petal = ellipsoid(along - lean * (z - height), across * (1.0 + 0.35 * tip ** 2), z,
                          (out, 0, height), (0.058, 0.150, high))
        rib = -0.006 * np.exp(-(across / 0.012) ** 2)
        d = join(d, petal + rib, 0.010)
    along, across = around(72, 0.0)
    return join(d, np.sqrt((along - 0.965) ** 2 + across ** 2 + (z + 0.005) ** 2) - 0.030, 0.006)


# --- The scene -------------------------------------------------------------------------------------------------------

def add_part(name: str, shape: Shape, xs: Array, ys: Array, zs: Array, material: bpy.types.Material) -> bpy.types.Object:
    vertices, quads = surface_net(shape, xs, ys, zs)
    vertices = np.round(vertices * 8192.0) / 8192.0  # Finer than any detail; rounded numbers are compressed better.
    part = tools.add_mesh(name, vertices.tolist(), quads.tolist(), material, smooth=True)
    part.location.z = SEAT
    smooth = part.modifiers.new("Smooth", "SMOOTH")
    smooth.factor = 0.5
    smooth.iterations = 1
    dense = part.modifiers.new("Dense", "SUBSURF")
    dense.levels = dense.render_levels = 1
    return part


def add_figure() -> None:
    ivory = tools.principled("Ivory", (0.70, 0.56, 0.40), roughness=0.42, specular=0.4)
    gold = tools.principled("Gilding", (0.83, 0.50, 0.15), roughness=0.32, metallic=1.0)
    lacquer = tools.principled("Lacquer", (0.025, 0.035, 0.075), roughness=0.25)
    bronze = tools.principled("Bronze", (0.42, 0.22, 0.10), roughness=0.38, metallic=0.85)

    # The skin is left open below, inside the robe.
    add_part("Skin", skin, axis(-0.70, 0.70, 0.021, (-0.25, 0.25, 0.0100)),
             axis(-0.60, 0.42, 0.019, (-0.30, -0.13, 0.0093)), axis(0.19, 1.56, 0.020, (1.02, 1.40, 0.009)), ivory)
    add_part("Robe", robe, axis(-0.95, 0.95, 0.019), axis(-0.80, 0.48, 0.019), axis(-0.10, 1.10, 0.016), gold)
    add_part("Hair", hair, axis(-0.27, 0.27, 0.0100), axis(-0.29, 0.29, 0.0100), axis(1.05, 1.65, 0.0100), lacquer)
    add_part("Lotus", lotus, axis(-1.10, 1.10, 0.022), axis(-0.98, 0.84, 0.022), axis(-0.50, 0.07, 0.0155), bronze)


def add_backdrop() -> None:
    """A plinth in front of a wall with a smooth transition to the floor."""
    cloth = tools.diffuse("Backdrop", (0.13, 0.19, 0.21))
    bend, wall, floor, half = 1.4, 3.2, -0.5, 9.0
    profile = [(-9.0, floor)]
    profile += [(wall - bend + bend * math.sin(a), floor + bend - bend * math.cos(a))
                for a in (math.pi / 2.0 * i / 24 for i in range(25))]
    profile.append((wall, 8.0))
    verts = [(x, y, z) for y, z in profile for x in (-half, half)]
    faces = [(2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2) for i in range(len(profile) - 1)]
    tools.add_mesh("Backdrop", verts, faces, cloth, smooth=True)
    stone = tools.principled("Plinth", (0.62, 0.59, 0.55), roughness=0.5)
    tools.add_box("Plinth", (-1.30, -1.10, floor), (1.30, 1.00, 0.0), stone, bevel=0.02)


def main() -> None:
    scene = tools.start_scene(512, 512)
    tools.background(scene, (0.55, 0.70, 1.0), 0.06)
    add_figure()
    add_backdrop()
    tools.area_light("Key light", (-3.0, -3.2, 4.2), (0, 0, 0.9), 1.6, 460.0, (1.0, 0.86, 0.70))
    tools.camera((0.35, -7.2, 1.45), (0, -0.05, 0.965), lens=98.0)
    tools.save(tools.output_path(__file__))


if __name__ == "__main__":
    main()
