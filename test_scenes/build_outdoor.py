"""`outdoor`: a lane under trees on a summer afternoon, at the edge of a village.

The light falls on two square kilometres, of which 50 metres are visible. Trees are collections of instances of one twig mesh; the grass is instances
of one patch of turf. Y points along the lane, away from the eye.
"""

from __future__ import annotations

import math
import random
import sys
from pathlib import Path

import bpy
from mathutils import Matrix, Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))

import scene_tools as tools
from furniture import put
from images import mottled, pack, sky, wood
from shapes import Shape, block, cylinder, lathe, tube

TO_SUN = (0.58, 0.62, 0.80)
LANE = 1.5  # half its width
TWIGS = 210  # on one tree


def build() -> None:
    scene = tools.start_scene(640, 360)
    tools.environment(scene, pack("Sky", sky(TO_SUN), hdr=True), 0.95)
    tools.sun_light("Sun", [-c for c in TO_SUN], 11.0, (1.0, 0.87, 0.68))
    build_ground()
    build_trees()
    build_turf()
    build_village()
    build_bench()
    tools.camera((0.55, -6.5, 1.55), (-0.15, 14.0, 2.75), lens=25.0)


def build_ground() -> None:
    for name, first, second, low, high, metres in (
        ("Meadow", (0.22, 0.30, 0.12), (0.42, 0.48, 0.20), (-700, -700, -1.0), (700, 700, 0.0), 9.0),
        ("Gravel", (0.46, 0.39, 0.31), (0.66, 0.58, 0.48), (-LANE, -300, -0.5), (LANE, 38.8, 0.015), 2.5),
    ):
        material = tools.diffuse(name, (1, 1, 1))
        tools.image_texture(material, pack(name, mottled(first, second, 128 if name == "Meadow" else 256)))
        put(name, block(low, high), material, metres=metres)
    dome = lathe([(math.cos(a), math.sin(a)) for a in (0.1 * math.pi * k for k in range(5))] + [(0.0, 1.0)], 20)
    hills = Shape()
    rng = random.Random(3)
    for k in range(26):  # low ridges all around
        angle = 2 * math.pi * k / 26
        far = rng.uniform(420, 620)
        mound = [Vector((v.x * rng.uniform(100, 170), v.y * 90, v.z * rng.uniform(18, 46))) for v in dome.verts]
        hills += Shape(mound, dome.faces).moved(
            far * math.cos(angle), far * math.sin(angle), -4.0, math.degrees(angle) + 90
        )
    put("Hills", hills, tools.diffuse("Wooded hills", (0.10, 0.16, 0.09)), True)


def leaf(length: float, width: float) -> Shape:
    """Folded along the midrib, tip along +X."""
    half, fold = width / 2, 0.25 * width
    return Shape(
        [
            Vector(p)
            for p in (
                (0, 0, 0),
                (0.30 * length, -half, fold),
                (0.68 * length, -0.8 * half, fold),
                (length, 0, -0.1 * length),
                (0.68 * length, 0.8 * half, fold),
                (0.30 * length, half, fold),
            )
        ],
        [(0, 1, 2, 3), (0, 3, 4, 5)],
    )


def twig(leaves: int, seed: int) -> tuple[Shape, Shape]:
    """Stem and leaves, 0.9 m along +X, drooping."""
    rng = random.Random(seed)
    stem = tube([(0, 0, 0), (0.3, 0, 0.04), (0.6, 0.02, 0.03), (0.88, 0, -0.04)], [0.012, 0.008, 0.005, 0.002], 5, 2)
    green = Shape()
    for k in range(leaves):
        t = 0.12 + 0.86 * k / leaves
        side = 1 if k % 2 else -1
        reach = 0.28 * math.sin(math.pi * min(1.0, 1.15 * (1 - t) + 0.12))
        place = Vector((0.88 * t, side * reach * rng.random(), 0.03 - 0.06 * t * t + rng.uniform(-0.10, 0.08)))
        turn = (
            Matrix.Rotation(side * rng.uniform(0.3, 1.3), 4, "Z")
            @ Matrix.Rotation(rng.uniform(-0.1, 0.7), 4, "Y")
            @ Matrix.Rotation(rng.uniform(-0.7, 0.7), 4, "X")
        )
        green += leaf(rng.uniform(0.12, 0.17), rng.uniform(0.07, 0.10)).placed(Matrix.Translation(place) @ turn)
    return stem, green


def grow(seed: int) -> tuple[Shape, list[tuple[Vector, Vector]]]:
    """Trunk and boughs of one tree about 9 m high, and the positions and directions of its twigs."""
    rng = random.Random(seed)
    lean = Vector((rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), 0))
    spine = [
        Vector((0, 0, -0.2)),
        Vector((0, 0, 0.35)),
        Vector((0, 0, 2.2)) + 0.4 * lean,
        Vector((0, 0, 4.6)) + 0.8 * lean,
        Vector((0, 0, 7.4)) + 1.6 * lean,
    ]
    wood_shape = tube([tuple(p) for p in spine], [0.33, 0.23, 0.19, 0.13, 0.04], 14, 5)
    boughs = []
    for k in range(15):
        t = k / 14
        height = 2.5 + 4.5 * t
        angle = 2.4 * k + rng.uniform(-0.4, 0.4)
        out = Vector((math.cos(angle), math.sin(angle), 0))
        start = Vector((0, 0, height)) + lean * (0.4 + 1.0 * t)
        reach = (3.1 - 1.7 * t) * rng.uniform(0.85, 1.15)
        rise = 0.75 + 0.9 * rng.random()
        boughs.append(
            [
                start,
                start + out * 0.45 * reach + Vector((0, 0, 0.55 * rise)),
                start + out * reach + Vector((0, 0, rise + 0.15)),
            ]
        )
        size = 0.075 - 0.035 * t
        wood_shape += tube([tuple(p) for p in boughs[-1]], [size, 0.7 * size, 0.25 * size], 7, 4)
        for j in range(3):
            t2 = (0.35, 0.55, 0.75)[j]
            base = boughs[k * 4][0].lerp(boughs[k * 4][2], t2) + Vector((0, 0, 0.25 * rise * math.sin(math.pi * t2)))
            sideways = out.cross(Vector((0, 0, 1))) * (1 if j % 2 else -1)
            end = (
                base
                + (sideways * rng.uniform(0.6, 1.0) + out * 0.5 + Vector((0, 0, rng.uniform(0.1, 0.7)))) * 0.45 * reach
            )
            boughs.append([base, base.lerp(end, 0.5) + Vector((0, 0, 0.08)), end])
            wood_shape += tube([tuple(p) for p in boughs[-1]], [0.5 * size, 0.35 * size, 0.15 * size], 5, 2)
    twigs = []
    for k in range(TWIGS):
        bough = boughs[k % len(boughs)]
        t = 0.35 + 0.65 * rng.random() ** 0.6
        place = bough[0].lerp(bough[1], 2 * t) if t < 0.5 else bough[1].lerp(bough[2], 2 * t - 1)
        along = (bough[2] - bough[0]).normalized()
        swing = Vector((rng.gauss(0, 0.7), rng.gauss(0, 0.7), rng.gauss(0.1, 0.4)))
        twigs.append((place, (along + swing).normalized()))
    return wood_shape, twigs


def along_x(place: Vector, direction: Vector, size: float) -> Matrix:
    """A transform with X along `direction` and Z as upright as possible."""
    y = Vector((0, 0, 1)).cross(direction).normalized()
    rotation = Matrix((direction, y, direction.cross(y))).transposed().to_4x4()
    return Matrix.Translation(place) @ rotation @ Matrix.Scale(size, 4)


def build_trees() -> None:
    bark = tools.diffuse("Bark", (1, 1, 1))
    tools.image_texture(bark, pack("Bark", wood((0.22, 0.17, 0.13), (0.46, 0.39, 0.32), 128, seed=13)))
    greens = [
        tools.mixed(
            f"Leaves {k + 1}",
            tools.principled("Leaf top", top, roughness=0.4),
            tools.translucent("Leaf below", below),
            0.42,
        )
        for k, (top, below) in enumerate(
            (((0.075, 0.19, 0.030), (0.26, 0.46, 0.05)), ((0.11, 0.22, 0.035), (0.36, 0.50, 0.06)))
        )
    ]
    twigs = []
    for k, green in enumerate(greens):
        stem, leaves = twig(46, k)
        shape = stem + leaves
        mesh = tools.mesh_data(f"Twig {k + 1}", shape.verts, shape.faces, bark)
        mesh.materials.append(green)
        mesh.polygons.foreach_set("material_index", [0] * len(stem.faces) + [1] * len(leaves.faces))
        twigs.append(mesh)
    trees = []
    for k in range(3):
        rng = random.Random(30 + k)
        tree = tools.collection(f"Tree {k + 1}", in_scene=False)
        shape, places = grow(20 + k)
        trunk = put(f"Trunk {k + 1}", shape, bark, True, metres=1.2)
        bpy.context.scene.collection.objects.unlink(trunk)
        tree.objects.link(trunk)
        for j, (place, direction) in enumerate(places):
            tools.add_instance(
                f"Twig {k + 1}.{j + 1}",
                twigs[(j + k) % 7 == 0],
                along_x(place, direction, rng.uniform(0.9, 1.35)),
                tree,
            )
        trees.append(tree)

    rng = random.Random(41)
    places = []
    for k in range(13):  # the avenue
        for side in (-1, 1):
            places.append((side * (3.7 + rng.uniform(-0.3, 0.3)), -9.5 + 5.6 * k + 1.5 * side + rng.uniform(-0.6, 0.6)))
    while len(places) < 64:  # a grove to both sides
        x, y = rng.uniform(-45, 45), rng.uniform(-10, 75)
        if abs(x) > 9 and all((x - a) ** 2 + (y - b) ** 2 > 22 for a, b in places):
            places.append((x, y))
    planted = tools.collection("Trees")
    for k, (x, y) in enumerate(places):
        turn = Matrix.Rotation(rng.uniform(0, 2 * math.pi), 4, "Z")
        tools.add_instance(
            f"Tree {k + 1}",
            trees[k % 3],
            Matrix.Translation((x, y, 0)) @ turn @ Matrix.Scale(rng.uniform(0.9, 1.15), 4),
            planted,
        )


def build_turf() -> None:
    rng = random.Random(51)
    verts, faces = [], []
    for _ in range(230):
        root = Vector((rng.uniform(-0.42, 0.42), rng.uniform(-0.42, 0.42), 0))
        angle, tall = rng.uniform(0, 2 * math.pi), rng.uniform(0.035, 0.115)
        side = Vector((-math.sin(angle), math.cos(angle), 0)) * rng.uniform(0.0025, 0.0045)
        lean = Vector((math.cos(angle), math.sin(angle), 0)) * tall * rng.uniform(0.1, 0.7)
        first = len(verts)
        middle = root + 0.35 * lean + Vector((0, 0, 0.6 * tall))
        verts += [
            root - side,
            root + side,
            middle + 0.8 * side,
            middle - 0.8 * side,
            root + lean + Vector((0, 0, tall)),
        ]
        faces += [(first, first + 1, first + 2, first + 3), (first + 3, first + 2, first + 4)]
    blades = Shape(verts, faces)
    grass = tools.mixed(
        "Grass", tools.diffuse("Blade", (0.13, 0.24, 0.045)), tools.translucent("Blade below", (0.26, 0.40, 0.06)), 0.35
    )
    mesh = tools.mesh_data("Turf", blades.verts, blades.faces, grass)
    turf = tools.collection("Turf")
    for k in range(1500):
        y = -7.5 + 34 * rng.random() ** 1.7
        x = rng.choice((-1, 1)) * (LANE - 0.1 + 9.0 * rng.random() ** 1.5)
        size = rng.uniform(0.8, 1.25)
        tools.add_instance(
            f"Turf {k + 1}",
            mesh,
            Matrix.Translation((x + math.copysign(0.42 * size, x), y, 0))
            @ Matrix.Rotation(rng.uniform(0, 6.28), 4, "Z")
            @ Matrix.Scale(size, 4),
            turf,
        )


def build_village() -> None:
    """One cottage at the end of the lane, and the same cottage two hundred times out of sight."""
    render = tools.diffuse("Limewash", (0.80, 0.76, 0.68))
    roof = tools.diffuse("Roof tiles", (1, 1, 1))
    tools.image_texture(roof, pack("Roof tiles", wood((0.40, 0.16, 0.10), (0.66, 0.32, 0.20), 128, boards=8, seed=15)))
    dark = tools.principled("Panes", (0.03, 0.035, 0.04), roughness=0.05)
    paint = tools.principled("Blue paint", (0.10, 0.22, 0.34), roughness=0.4)
    cottage = tools.collection("Cottage", in_scene=False)
    gable = Shape(
        [Vector(p) for p in ((-4.5, -3, 3), (4.5, -3, 3), (4.5, 3, 3), (-4.5, 3, 3), (-4.5, 0, 5.6), (4.5, 0, 5.6))],
        [(0, 3, 4), (1, 5, 2), (0, 4, 5, 1), (3, 2, 5, 4), (0, 1, 2, 3)],
    )
    slope = math.atan2(2.6, 3.0)
    tiles = Shape()
    for side in (0, 180):
        tiles += block((-4.9, -0.5, 0.0), (4.9, math.hypot(2.6, 3.0), 0.14)).placed(
            Matrix.Rotation(math.radians(side), 4, "Z")
            @ Matrix.Translation((0, -3, 3))
            @ Matrix.Rotation(slope, 4, "X")
        )
    panes, frames = Shape(), Shape()
    for x in (-3.0, 2.9):
        panes += block((x - 0.5, -3.02, 1.0), (x + 0.5, -2.9, 2.2))
        for a, b, low, high in (
            (x - 0.58, x + 0.58, 0.92, 1.0),
            (x - 0.58, x + 0.58, 2.2, 2.28),
            (x - 0.58, x - 0.5, 1.0, 2.2),
            (x + 0.5, x + 0.58, 1.0, 2.2),
            (x - 0.03, x + 0.03, 1.0, 2.2),
        ):
            frames += block((a, -3.06, low), (b, -2.9, high))
    frames += block((-0.5, -3.05, 0.0), (0.5, -2.9, 2.15))
    for name, shape, material in (
        ("Cottage walls", block((-4.5, -3, 0), (4.5, 3, 3)) + gable + block((2.6, -0.4, 4.4), (3.4, 0.4, 6.6)), render),
        ("Cottage roof", tiles, roof),
        ("Cottage panes", panes, dark),
        ("Cottage woodwork", frames, paint),
    ):
        part = put(name, shape, material, metres=2.0)
        bpy.context.scene.collection.objects.unlink(part)
        cottage.objects.link(part)
    rng = random.Random(61)
    village = tools.collection("Village")
    tools.add_instance(
        "Cottage 1", cottage, Matrix.Translation((-0.5, 42.0, 0)) @ Matrix.Rotation(-0.08, 4, "Z"), village
    )
    k = 1
    while k < 200:  # out of sight, behind the eye
        x, y = 22 * rng.randint(-13, 13) + rng.uniform(-4, 4), -40 - 24 * rng.randint(0, 12) + rng.uniform(-5, 5)
        if abs(x) > 12:
            k += 1
            tools.add_instance(
                f"Cottage {k}",
                cottage,
                Matrix.Translation((x, y, 0))
                @ Matrix.Rotation(rng.uniform(-0.3, 0.3) + math.pi * rng.randint(0, 1), 4, "Z"),
                village,
            )


def build_bench() -> None:
    oak = tools.principled("Weathered oak", (1, 1, 1), roughness=0.5)
    tools.image_texture(
        oak, pack("Weathered oak", wood((0.40, 0.32, 0.25), (0.62, 0.53, 0.43), 128, seed=17)), socket="Base Color"
    )
    bench = Shape()
    for k in range(4):
        bench += block((-0.85, -0.22 + 0.115 * k, 0.43), (0.85, -0.12 + 0.115 * k, 0.455), 0.006)
    for k in range(3):
        bench += block((-0.85, 0.255 + 0.02 * k, 0.56 + 0.12 * k), (0.85, 0.278 + 0.02 * k, 0.65 + 0.12 * k), 0.006)
    iron = Shape()
    for x in (-0.65, 0.65):
        iron += block((x - 0.03, -0.20, 0.0), (x + 0.03, -0.14, 0.43)) + block(
            (x - 0.03, 0.20, 0.0), (x + 0.03, 0.25, 0.62)
        )
        iron += block((x - 0.03, -0.22, 0.395), (x + 0.03, 0.25, 0.43)) + block(
            (x - 0.03, 0.28, 0.55), (x + 0.03, 0.31, 0.90)
        )
    put("Bench", bench.moved(-2.45, 1.1, 0.0, 72), oak, metres=0.8)
    put(
        "Bench irons", iron.moved(-2.45, 1.1, 0.0, 72), tools.principled("Cast iron", (0.03, 0.03, 0.03), roughness=0.4)
    )
    post = cylinder(0.05, 0.0, 0.95, 16)
    put("Posts", sum((post.moved(side * 1.75, -1.5 + 4.5 * k) for k in range(9) for side in (-1, 1)), Shape()), oak)


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
