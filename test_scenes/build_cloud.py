"""`cloud`: a cumulus above a plain, lit by the sun and the sky.

The script computes the density of the cloud and writes it to `cloud.vdb` beside the scene, with the OpenVDB module of Blender or of the distribution
(`python3-openvdb`). Blender cannot pack volumes into its files.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import scene_tools as tools

VOXEL = 2.0  # metres
SIZE = np.array((128, 96, 80))  # voxels
DENSITY = 0.12  # scattering events per metre inside
ALBEDO = 0.98
BASE = 130.0  # height of the lower side of the cloud, in metres


def noise(rng: np.random.Generator, frequency: float) -> np.ndarray:
    """Smooth numbers around 0: random values on a coarse lattice, interpolated by smooth steps."""
    cells = np.ceil(SIZE * frequency).astype(int) + 2
    lattice = rng.uniform(-1.0, 1.0, cells)
    result = lattice
    for dimension, count in enumerate(SIZE):
        place = np.arange(count) * frequency
        first = place.astype(int)
        part = place - first
        weight = (part * part * (3.0 - 2.0 * part)).reshape([-1 if k == dimension else 1 for k in range(3)])
        result = np.take(result, first, dimension) * (1.0 - weight) + np.take(result, first + 1, dimension) * weight
    return result


def density() -> np.ndarray:
    """Between 0 and 1. Balls above a flat base, with an outline of noise."""
    rng = np.random.default_rng(7)
    x, y, z = np.meshgrid(*(np.arange(n) - 0.5 * n for n in SIZE), indexing="ij")
    z = z + 0.5 * SIZE[2]
    inside = np.full(SIZE, -1.0)
    for _ in range(26):
        radius = rng.uniform(9.0, 20.0)
        centre = rng.normal(0.0, (17.0, 12.0, 0.0)) + (0.0, 0.0, 14.0 + rng.uniform(0.0, 30.0))
        away = np.sqrt((x - centre[0]) ** 2 + (y - centre[1]) ** 2 + (z - centre[2]) ** 2)
        inside = np.maximum(inside, 1.0 - away / radius)
    outline = sum(noise(rng, 0.06 * 2.0**octave) * 0.5**octave for octave in range(4))
    inside += 0.45 * outline
    inside -= np.maximum(0.0, (12.0 - z) / 6.0)  # the base
    border = np.minimum.reduce([np.minimum(np.arange(n), n - 1 - np.arange(n)).reshape([-1 if k == d else 1 for k in range(3)]) * np.ones(SIZE)
                                for d, n in enumerate(SIZE)])
    return np.clip(inside * 3.0, 0.0, 1.0) * (border > 1.5)


def write_grid(path: Path) -> None:
    try:
        vdb = importlib.import_module("openvdb")
    except ImportError:
        vdb = importlib.import_module("pyopenvdb")
    grid = vdb.FloatGrid()
    values = np.round(density() * 255.0) / 255.0  # Rounded numbers are compressed better.
    grid.copyFromArray(values.astype(np.float32), tolerance=1e-4)
    grid.transform = vdb.createLinearTransform(VOXEL)
    grid.transform.translate(tuple(float(v) for v in (-0.5 * VOXEL * SIZE[0], -0.5 * VOXEL * SIZE[1], BASE)))
    grid.name = "density"
    grid.gridClass = vdb.GridClass.FOG_VOLUME
    grid.saveFloatAsHalf = True
    vdb.write(str(path), grids=[grid])


def build(folder: Path) -> None:
    write_grid(folder / "cloud.vdb")
    scene = tools.start_scene(640, 480, bounces=32)
    tools.background(scene, (0.35, 0.55, 0.9), 0.8)
    tools.sun_light("Sun", (0.7, 0.5, -0.8), 3.0, (1.0, 0.95, 0.88))
    camera = tools.camera((-40.0, -420.0, 230.0), (0.0, 0.0, 165.0), lens=60)
    camera.data.clip_end = 10000.0
    tools.add_plane("Plain", (0, 0, 0), (4000, 4000), tools.diffuse("Grass", (0.20, 0.26, 0.10)))
    data = bpy.data.volumes.new("Cloud")
    data.filepath = "//cloud.vdb"
    tools.link(bpy.data.objects.new("Cloud", data))
    material = bpy.data.materials.new("Cloud")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    inside, output = tree.nodes.new("ShaderNodeVolumePrincipled"), tree.nodes.new("ShaderNodeOutputMaterial")
    tools.set_input(inside, "Color", (ALBEDO, ALBEDO, ALBEDO))
    tools.set_input(inside, "Density", DENSITY)
    tools.set_input(inside, "Anisotropy", 0.6)
    tree.links.new(inside.outputs["Volume"], output.inputs["Volume"])
    data.materials.append(material)


if __name__ == "__main__":
    path = tools.output_path(__file__)
    build(path.resolve().parent)
    tools.save(path)
