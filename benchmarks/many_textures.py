#!/usr/bin/python3
"""Measures the memory and the time of a scene with many large textures, with and without the texture cache.

    benchmarks/many_textures.py FOLDER [--count 100] [--side 4096] [--small 256] [--rounds 3] [--limit 512] [--integrator path]

FOLDER, outside of the repository, gets the images (about 40 MB each, made once), their files of tiles, scenes and pictures. The scene is a hall
of textured squares, near and far, under a lamp: every picture shows every texture, and light bounces between them. The images of the small scene are the
large ones, averaged to `--small` texels, so that both scenes have the same light. Each round renders all variants in turn.

Prints for each variant the CPU seconds of the render and of the whole process, the peak memory of the process, and what the cache has read, and how much
pictures differ: blocks of pixels whose difference is above 1 % and three standard errors of it.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
BUILD = Path(os.environ.get("AJAR_BUILD", ROOT / "build" / "release"))
sys.path.insert(0, str(BUILD / "python"))

BLOCK = 32      # pixels along the sides of a block
DISTINCT = 10   # images


def make_image(number: int, side: int) -> np.ndarray:
    """Stripes, spots and grain of its own: an image that a PNG does not compress much, as a photograph."""
    random = np.random.default_rng(number)
    x = 2 * np.pi * np.arange(side, dtype=np.float32) / side
    pixels = np.empty((side, side, 3), np.uint8)
    for channel, color in enumerate(random.uniform(40, 160, 3)):
        across, along = (np.sin(random.integers(2, 40) * x + random.uniform(0, 6)).astype(np.float32) for _ in range(2))
        grain = random.integers(0, 40, (side, side), dtype=np.uint8)
        pixels[..., channel] = np.uint8(color * (1 + 0.3 * across)[None, :] * (1 + 0.05 * along)[:, None]) + grain // 2
    return pixels


def averaged(pixels: np.ndarray, side: int) -> np.ndarray:
    """The mean light of squares of pixels, in sRGB."""
    value = np.arange(256) / 255
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4).astype(np.float32)
    step = pixels.shape[0] // side
    light = linear[pixels].reshape(side, step, side, step, 3).mean(axis=(1, 3))
    return np.uint8(np.round(255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)))


def make_images(folder: Path, count: int, side: int, small: int) -> None:
    """Ten images of each size, and copies of them: a texture is one file, whatever it shows."""
    for number in range(count):
        for kind in ("large", "small"):
            path, first = folder / f"{kind}_{number:03}.png", folder / f"{kind}_{number % DISTINCT:03}.png"
            if path.exists():
                continue
            if number >= DISTINCT:
                shutil.copyfile(first, path)
            else:
                pixels = make_image(number, side)
                Image.fromarray(pixels if kind == "large" else averaged(pixels, small)).save(path, compress_level=1)


def textured(ajar, image: int):
    graph = ajar.NodeGraph()
    uv = graph.add_node("ShaderNodeUVMap", "UV")
    texture = graph.add_node("ShaderNodeTexImage", "Image")
    graph.add_property(texture, "image", numbers=[image])
    graph.add_input(texture, "Vector", (0, 0, 0, 0), ajar.NodeLink(uv, "UV"))
    diffuse = graph.add_node("ShaderNodeBsdfDiffuse", "Diffuse")
    graph.add_input(diffuse, "Color", (1, 1, 1, 1), ajar.NodeLink(texture, "Color"))
    graph.surface = ajar.NodeLink(diffuse, "BSDF")
    return graph


def make_scene(ajar, folder: Path, kind: str, count: int, samples: int, path: Path) -> None:
    """A floor and two walls of squares, seen along the hall."""
    d = ajar.SceneDescription()
    columns = 10
    things = []
    for number in range(count):
        image = d.add_image(name=f"{kind} {number}", path=str(folder / f"{kind}_{number:03}.png"))
        material = d.add_material(name=f"Material {number}", graph=textured(ajar, image))
        along, across = 2.0 * (number // columns), number % columns
        if across < 4:     # floor
            corners = [(2 * across - 4, along, 0), (2 * across - 2, along, 0), (2 * across - 2, along + 2, 0), (2 * across - 4, along + 2, 0)]
        elif across < 7:   # left wall
            z = 2 * (across - 4)
            corners = [(-4, along, z), (-4, along + 2, z), (-4, along + 2, z + 2), (-4, along, z + 2)]
        else:
            z = 2 * (across - 7)
            corners = [(4, along + 2, z), (4, along, z), (4, along, z + 2), (4, along + 2, z + 2)]
        uv = np.array([(0, 0), (1, 0), (1, 1), (0, 0), (1, 1), (0, 1)], np.float32)
        mesh = d.add_mesh(name=f"Square {number}", positions=np.array(corners, np.float32), triangles=np.array([(0, 1, 2), (0, 2, 3)], np.uint32),
                          attributes=[("UV", ajar.Domain.Corner, uv)], active_uv="UV")
        things.append(d.add_object(name=f"Square {number}", mesh=mesh, materials=[material]))
    d.add_instances(things, np.tile(np.eye(3, 4, dtype=np.float32).reshape(1, 12), (count, 1)))
    d.world.color = (0.3, 0.35, 0.4)
    lamp = ajar.LightDescription()
    lamp.kind, lamp.energy, lamp.area_size = ajar.LightKind.Area, 900.0, (3.0, 12.0)
    lamp.world_from_light = [1, 0, 0, 0, 0, 1, 0, 9, 0, 0, 1, 6]
    d.add_light(lamp)
    camera = d.camera
    camera.present = True
    camera.world_from_camera = [1, 0, 0, 0.5, 0, 0.17, -0.985, -1.5, 0, 0.985, 0.17, 2.5]
    s = d.settings
    s.width, s.height, s.region, s.samples, s.passes = 960, 540, [0, 0, 960, 540], samples, ["Combined"]
    s.bounces.diffuse = 4
    ajar.save_description(d, str(path))


def render(scene: Path, output: Path, options: list[str], seed: int) -> dict:
    statistics = output.with_suffix(".json")
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    done = subprocess.run([str(BUILD / "ajar-render"), str(scene), str(output), "--stats", str(statistics), "--seed", str(seed), *options],
                          capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0 or done.stderr.strip():
        print(done.stderr[:2000])
    values = json.loads(statistics.read_text())
    values["process_cpu_seconds"] = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    values["wall_seconds"] = time.monotonic() - start
    return values


def blocks(picture: np.ndarray) -> np.ndarray:
    height, width = (size // BLOCK * BLOCK for size in picture.shape[:2])
    return picture[:height, :width, :3].astype(np.float64).mean(axis=2).reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK).mean(axis=(1, 3))


def disagreement(first: list[np.ndarray], second: list[np.ndarray]) -> tuple[int, int, float]:
    """Blocks that differ by more than 1 % and three standard errors, of how many, and the difference of the means in per cent."""
    a, b = np.array([blocks(p) for p in first]), np.array([blocks(p) for p in second])
    difference = np.abs(a.mean(axis=0) - b.mean(axis=0))
    error = np.sqrt(a.var(axis=0, ddof=1) / len(a) + b.var(axis=0, ddof=1) / len(b)) if len(a) > 1 else np.zeros_like(difference)
    return int((difference > 0.01 * b.mean(axis=0) + 3 * error).sum()), difference.size, 100 * abs(a.mean() / b.mean() - 1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--side", type=int, default=4096)
    parser.add_argument("--small", type=int, default=256)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--limit", type=int, default=512, help="of the cache, in MiB")
    parser.add_argument("--integrator", default="path")
    parser.add_argument("--without-whole", action="store_true", help="skip the large scene without a cache, which needs much memory")
    parser.add_argument("--images-only", action="store_true")
    options = parser.parse_args()
    folder = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    make_images(folder, options.count, options.side, options.small)
    if options.images_only:
        return
    import ajar  # of the build
    scenes = {kind: folder / f"{kind}.ajar" for kind in ("large", "small")}
    for kind, path in scenes.items():
        make_scene(ajar, folder, kind, options.count, options.samples, path)
    cache = ["--texture-cache", "on", "--texture-cache-folder", str(folder / "tiles"), "--texture-cache-size", str(options.limit)]
    common = ["--integrator", options.integrator]
    missing = options.count - len(list((folder / "tiles").glob("large_*.ajar.tif"))) if (folder / "tiles").exists() else options.count
    first = render(scenes["large"], folder / "first.exr", [*common, *cache, "--texture-cache-generate", "on", "--samples", "1"], 1)
    print(f"first use: {missing} files made, {first['build_seconds']:.1f} s to build, peak {first['peak_memory_bytes'] / 2**20:.0f} MiB")
    variants = {"small": ("small", []), "large, cached": ("large", cache)} | ({} if options.without_whole else {"large, whole": ("large", [])})
    results: dict[str, list[dict]] = {name: [] for name in variants}
    pictures: dict[str, list[np.ndarray]] = {name: [] for name in variants}
    for round_ in range(options.rounds):
        for name, (kind, more) in variants.items():
            output = folder / "picture.exr"
            results[name].append(render(scenes[kind], output, [*common, *more], round_ + 1))
            pictures[name].append(ajar.read_image(str(output)))
    for name, all_values in results.items():
        print(f"{name}: render CPU {[round(v['render_cpu_seconds'], 2) for v in all_values]} s, process CPU {[round(v['process_cpu_seconds'], 2) for v in all_values]} s, "
              f"peak {max(v['peak_memory_bytes'] for v in all_values) / 2**20:.0f} MiB, cache {all_values[-1].get('texture_cache')}")
    for name in variants:
        if name != "small":
            ratios = [a["render_cpu_seconds"] / b["render_cpu_seconds"] for a, b in zip(results[name], results["small"], strict=True)]
            print(f"{name}: CPU of the render relative to small: {np.median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f})")
            if name != "large, whole":
                other = "small" if options.without_whole else "large, whole"
                print("blocks that differ from {}: {} of {}, mean {:.3f} %".format(other, *disagreement(pictures[name], pictures[other])))


if __name__ == "__main__":
    main()
