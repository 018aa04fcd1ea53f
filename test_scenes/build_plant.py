"""A pot plant on a table: complex soft shadows of glossy leaves (thesis, figure 5.8).

All leaves are instances of three leaf meshes, young to old. An area light causes the shadows; a packed environment image from this script illuminates
them.
"""

from __future__ import annotations

import math
import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import numpy as np
import scene_tools as tools
from mathutils import Matrix, Vector

POT_RADIUS, POT_HEIGHT = 0.105, 0.17
GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))


# --- Leaves ----------------------------------------------------------------------------------------------------------

def leaf_mesh(name: str, colour: tools.Colour, *, width: float, droop: float, fold: float,
              roughness: float) -> bpy.types.Mesh:
    """A pointed oval of length 1 along +Y with its face up, on a short stalk. It is bent down and folded along its rib."""
    face = tools.principled(f"{name} face", colour, roughness=roughness, specular=0.6)
    shine_through = tools.translucent(f"{name} inside", [min(1.0, 2.2 * colour[0]), min(1.0, 1.9 * colour[1]), 0.05])
    material = tools.mixed(name, face, shine_through, 0.22)

    along, across, stalk = 26, 10, 0.16
    verts, faces = [], []
    for i in range(along + 1):
        t = i / along
        half = width * (math.sin(math.pi * t ** 0.82) ** 0.85 * (1.0 - 0.35 * t) if 0 < i < along else 0.012)
        for j in range(across + 1):
            s = 2.0 * j / across - 1.0
            ripple = 0.012 * math.sin(9.0 * math.pi * t) * s * s
            veins = -0.006 * abs(math.sin((t * 9.0 - 1.1 * abs(s)) * math.pi)) * (1.0 - abs(s))
            verts.append((s * half, stalk + t * (1.0 - stalk), fold * abs(s) * half + ripple + veins))
    for i in range(along):
        for j in range(across):
            a = i * (across + 1) + j
            faces.append((a, a + 1, a + across + 2, a + across + 1))
    # The stalk: a three-sided tube from the stem to the blade.
    base = len(verts)
    for y in (0.0, stalk * 0.5, stalk + 0.06):
        verts += [(0.013 * math.sin(2.1 * k), y, 0.013 * math.cos(2.1 * k) - 0.010) for k in range(3)]
    for ring in (0, 1):
        for k in range(3):
            a, b = base + 3 * ring + k, base + 3 * ring + (k + 1) % 3
            faces.append((a, b, b + 3, a + 3))
    # Bend the whole leaf along an arc of a circle.
    bent = []
    for x, y, z in verts:
        angle = droop * y
        reach = math.sin(angle) / droop - z * -math.sin(angle)
        bent.append((x, reach, (math.cos(angle) - 1.0) / droop + z * math.cos(angle)))
    return tools.mesh_data(name, bent, faces, material, smooth=True)


def leaf_matrix(foot: Vector, direction: Vector, roll: float, length: float) -> Matrix:
    """The transform of a leaf: the stalk at `foot` along `direction`, the face as far up as possible, then rotated by `roll`."""
    y = direction.normalized()
    x = y.cross(Vector((0.0, 0.0, 1.0)))
    x = x.normalized() if x.length > 1e-4 else Vector((1.0, 0.0, 0.0))
    z = x.cross(y)
    frame = Matrix((x, y, z)).transposed().to_4x4()
    return Matrix.Translation(foot) @ frame @ Matrix.Rotation(roll, 4, "Y") @ Matrix.Scale(length, 4)


# --- The plant -------------------------------------------------------------------------------------------------------

def stem_points(pick: random.Random, angle: float, lean: float, length: float) -> list[Vector]:
    """A curve that starts in the soil, tilted outwards, and rises in equal steps."""
    foot = Vector((math.cos(angle), math.sin(angle), 0.0)) * 0.045 * lean + Vector((0, 0, POT_HEIGHT - 0.015))
    steps = 24
    points = [foot]
    for i in range(steps):
        tilt = lean * (0.95 - 0.45 * i / steps)
        turn = angle + 0.25 * math.sin(3.0 * i / steps + angle)
        step = Vector((math.sin(tilt) * math.cos(turn), math.sin(tilt) * math.sin(turn), math.cos(tilt)))
        points.append(points[-1] + step * length / steps + Vector((pick.gauss(0, 1), pick.gauss(0, 1), 0)) * 0.0008)
    return points


def add_stem(name: str, points: list[Vector], material: bpy.types.Material) -> None:
    sides = 8
    verts, faces = [], []
    for i, point in enumerate(points):
        tangent = (points[min(i + 1, len(points) - 1)] - points[max(i - 1, 0)]).normalized()
        u = tangent.cross(Vector((0.3, 0.9, 0.1))).normalized()
        v = tangent.cross(u)
        radius = 0.0058 * (1.0 - 0.65 * i / (len(points) - 1))
        verts += [point + radius * (math.cos(a) * u + math.sin(a) * v)
                  for a in (2.0 * math.pi * k / sides for k in range(sides))]
    for i in range(len(points) - 1):
        for k in range(sides):
            a, b = i * sides + k, i * sides + (k + 1) % sides
            faces.append((a, a + sides, b + sides, b))
    tools.add_mesh(name, verts, faces, material, smooth=True, into=tools.collection("Plant"))


def add_plant() -> int:
    """Stems with leaves in a spiral: large and old leaves below, small and young ones at the tip. Returns the number of leaves."""
    young = leaf_mesh("Young leaf", (0.17, 0.34, 0.04), width=0.19, droop=0.35, fold=0.35, roughness=0.26)
    grown = leaf_mesh("Grown leaf", (0.055, 0.19, 0.03), width=0.22, droop=0.75, fold=0.22, roughness=0.22)
    old = leaf_mesh("Old leaf", (0.03, 0.115, 0.03), width=0.24, droop=1.05, fold=0.12, roughness=0.20)
    bark = tools.principled("Stem", (0.16, 0.13, 0.05), roughness=0.5)
    plant = tools.collection("Plant")

    pick = random.Random(11)
    count = 0
    stems = [(0.0, 0.05, 0.43)]
    stems += [(i * 2 * math.pi / 5 + 0.5, 0.42, 0.37) for i in range(5)]
    stems += [(i * 2 * math.pi / 8, 0.88, 0.31) for i in range(8)]
    for number, (angle, lean, length) in enumerate(stems):
        points = stem_points(pick, angle + pick.uniform(-0.15, 0.15), lean, length * pick.uniform(0.88, 1.1))
        add_stem(f"Stem {number + 1:02}", points, bark)
        leaves = round(length * 78)
        for i in range(leaves):
            t = 0.22 + 0.78 * i / (leaves - 1)
            place = t * (len(points) - 1)
            k = min(int(place), len(points) - 2)
            foot = points[k].lerp(points[k + 1], place - k)
            tangent = (points[k + 1] - points[k]).normalized()
            u = tangent.cross(Vector((0.1, 0.2, 0.97))).normalized()
            v = tangent.cross(u)
            spin = i * GOLDEN_ANGLE + number
            side = math.cos(spin) * u + math.sin(spin) * v
            direction = side + tangent * (0.25 + 1.3 * t ** 4) + Vector((0, 0, 0.25))
            size = pick.uniform(0.9, 1.12) * (0.125 - 0.075 * t ** 2.5)
            mesh = young if t > 0.82 else grown if t > 0.45 else old
            count += 1
            tools.add_instance(f"Leaf {count:03}", mesh, leaf_matrix(foot, direction, pick.gauss(0, 0.25), size), plant)
    # Two have fallen.
    for x, y, turn, mesh in ((0.27, -0.13, 0.7, old), (-0.20, -0.24, 2.6, grown)):
        count += 1
        lying = Matrix.Translation((x, y, 0.010)) @ Matrix.Rotation(turn, 4, "Z") @ Matrix.Rotation(0.30, 4, "X")
        tools.add_instance(f"Fallen leaf {count:03}", mesh, lying @ Matrix.Scale(0.105, 4), plant)
    return count


# --- Pot, table and light --------------------------------------------------------------------------------------------

def add_pot() -> None:
    glaze = tools.principled("Glaze", (0.045, 0.13, 0.22), roughness=0.16, specular=0.6)
    clay = tools.principled("Clay", (0.42, 0.19, 0.10), roughness=0.6)
    soil = tools.diffuse("Soil", (0.045, 0.028, 0.018))
    r, h = POT_RADIUS, POT_HEIGHT
    tools.add_lathe("Pot", [(0.0, 0.012), (0.66 * r, 0.012), (0.70 * r, 0.016), (0.82 * r, 0.35 * h),
                            (0.95 * r, 0.80 * h), (0.97 * r, 0.84 * h), (1.05 * r, 0.86 * h), (1.07 * r, 0.88 * h),
                            (1.09 * r, 0.98 * h), (1.08 * r, h), (1.00 * r, h), (0.985 * r, 0.98 * h),
                            (0.95 * r, 0.80 * h)], glaze, sides=96)
    tools.add_lathe("Saucer", [(0.0, 0.0), (0.85 * r, 0.0), (0.90 * r, 0.003), (1.13 * r, 0.024), (1.15 * r, 0.027),
                               (1.12 * r, 0.028), (0.88 * r, 0.010), (0.0, 0.009)], clay, sides=96)
    pick = random.Random(3)
    rings, sides = 8, 40
    profile = [(0.0, 0.008)] + [(r * 0.98 * i / rings, 0.006 * (1 - (i / rings) ** 2)) for i in range(1, rings + 1)]
    verts, faces = tools.lathe_geometry(profile, sides)
    verts = [(x, y, z + pick.uniform(0, 0.006)) for x, y, z in verts]
    ground = tools.add_mesh("Soil", verts, [f[::-1] for f in faces], soil)
    ground.location.z = POT_HEIGHT * 0.86


def wood_image(size: int = 256) -> bpy.types.Image:
    """Boards of pale wood, grain along U; sRGB bytes."""
    rng = np.random.default_rng(5)
    boards = 5
    u, v = np.meshgrid(np.arange(size) / size, np.arange(size) / size)
    board = np.minimum((v * boards).astype(int), boards - 1)
    offset, tone = rng.uniform(0, 10, boards)[board], rng.uniform(-0.035, 0.035, boards)[board]
    # Growth rings cut along the trunk: fine lines that a slow wave across the grain bends.
    bend = 0.05 * np.sin(2 * np.pi * u + offset) + 0.03 * np.sin(4 * np.pi * u + 2.3 * offset)
    rings = np.sin((v * 9 + bend * 5 + offset) * 9) * 0.5 + np.sin((v * 23 + bend * 12 + offset) * 11) * 0.3
    fibre = rng.normal(0, 1, (size, 1)) + 0.4 * rng.normal(0, 1, (size, size))
    light = 0.0 + 0.022 * rings + 0.012 * fibre + tone
    joint = np.abs(v * boards - np.round(v * boards)) < 0.012
    light = np.where(joint, light - 0.16, light)
    pixels = np.ones((size, size, 4), np.float32)
    for channel, value in enumerate((0.80, 0.685, 0.545)):
        pixels[..., channel] = np.clip(value + light * (1.0 + 0.25 * channel), 0, 1)
    return tools.packed_image("Wood", size, size, pixels.ravel())


def sky_image(height: int = 64) -> bpy.types.Image:
    """A room around the plant: warm walls, a pale ceiling, and a soft bright window on the left."""
    width = 2 * height
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    azimuth, up = (u - 0.5) * 2.0 * np.pi, (v - 0.5) * np.pi
    blend = (1.0 / (1.0 + np.exp(-up * 5.0)))[..., None]
    colour = (1.0 - blend) * np.array([0.16, 0.20, 0.21]) + blend * np.array([0.55, 0.66, 0.72])
    window = np.exp(-((azimuth + 1.9) / 0.45) ** 4 - ((up - 0.45) / 0.35) ** 4)[..., None]
    colour = colour + window * np.array([3.2, 4.0, 5.0])
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = colour
    return tools.packed_image("Room", width, height, pixels.ravel(), hdr=True)


def main() -> None:
    scene = tools.start_scene(720, 405)
    tools.environment(scene, sky_image(), 0.30)
    wood = tools.principled("Table", (0.6, 0.45, 0.3), roughness=0.38, specular=0.35)
    tools.image_texture(wood, wood_image(), socket="Base Color")
    tools.add_plane("Table top", (0.1, 0.1, 0.0), (2.2, 1.3), wood)
    rim = tools.principled("Table edge", (0.45, 0.30, 0.18), roughness=0.5)
    tools.add_box("Table edge", (-1.0, -0.55, -0.04), (1.2, 0.75, -0.001), rim)
    add_pot()
    leaves = add_plant()
    tools.area_light("Area light", (-1.75, 1.15, 1.75), (0.10, -0.05, 0.15), 0.30, 185.0, (1.0, 0.84, 0.64))
    tools.camera((0.22, -1.95, 0.86), (0.15, 0, 0.248), lens=54.0)
    print(f"{leaves} leaves")
    tools.save(tools.output_path(__file__))


main()
