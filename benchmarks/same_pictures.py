#!/usr/bin/python3
"""Tests whether a change leaves all images unchanged: two builds render the same scenes with the same seeds, and all floats must be equal:

    benchmarks/same_pictures.py BEFORE AFTER [--scenes NAME ...] [--samples N]

BEFORE and AFTER are build trees or copies of their program `ajar-render`. Each integrator, direct light method, guiding and vertex merging is
rendered. If a compiler contracts products and sums differently, images differ slightly: the maximum relative difference is printed, and --tolerance
is its accepted maximum. Ends with an error if an image differs.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

import images
import numpy as np
import renderers
from scenes import PROJECT, find_scenes

SCENES = ["checker", "box", "rooms", "room", "lantern", "buddha", "plant", "outdoor", "many_lights", "volume", "keyhole", "bar", "room_fog", "room_hair",
          "room_motion", "room_skin", "rooms_panorama"]
PERCENTAGE = 8
INTEGRATORS = ["path", "bdpt", "erpt", "metropolis", "pmc_pt", "photon_map", "mps", "irradiance_cache"]
DIRECT = ["pmc_hi", "ocv_progressive", "ocv", "pmc_hi_paper", "ocv_paper", "correlated", "ris", "mis_balance", "light", "bsdf", "mis"]


def variants() -> dict[str, list[str]]:
    """The name of each image and its options."""
    options = {name: ["--integrator", name] for name in INTEGRATORS}
    options |= {f"direct {method} {samples}": ["--integrator", "path", "--direct", method, "--direct-samples", str(samples)]
                for method in DIRECT for samples in (1, 16)}
    options["guided"] = ["--integrator", "path", "--guiding", "on", "--samples", "32"]
    options["bdpt merging"] = ["--integrator", "bdpt", "--vertex-merging", "on"]
    return options


def program_of(build: Path) -> Path:
    return build / "ajar-render" if build.is_dir() else build


def render(program: Path, scene: Path, options: list[str], samples: int, path: Path) -> np.ndarray:
    """RGBA of a render with one seed."""
    subprocess.run([str(program), str(scene), str(path), "--samples", str(samples), "--seed", "7", *options], check=True, capture_output=True)
    return images.read_exr(path)


def difference(before: np.ndarray, after: np.ndarray) -> float:
    """The maximum relative difference of two images; 0 if all floats are equal, including NaNs at the same positions. Differences of values below the
    mean of the first image are relative to this mean."""
    if before.shape != after.shape:
        return float("inf")
    if np.array_equal(before, after, equal_nan=True):
        return 0.0
    scale = np.maximum(np.abs(before), max(float(np.abs(before).mean()), 1e-20))
    return float(np.nan_to_num(np.abs(after - before) / scale, nan=np.inf).max())


def main() -> int:
    parser = argparse.ArgumentParser(description="Compare the images of two builds.")
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--scenes", nargs="+", default=SCENES)
    parser.add_argument("--variants", nargs="+", default=None, help="names of images, as printed")
    parser.add_argument("--samples", type=int, default=3)
    parser.add_argument("--tolerance", type=float, default=0.0)
    options = parser.parse_args()
    before, after = program_of(options.before), program_of(options.after)
    folder = PROJECT / "build" / "same_pictures"
    ajar = renderers.AjarBuild.default()
    count = differ = 0
    for scene in find_scenes(options.scenes):
        own = folder / scene.name
        file = own / "scene.ajar"
        if not file.exists():
            file, _ = ajar.dump(scene.path, own, PERCENTAGE)
        for name, chosen in variants().items():
            if options.variants and name not in options.variants:
                continue
            first = render(before, file, chosen, options.samples, own / "before.exr")
            second = render(after, file, chosen, options.samples, own / "after.exr")
            count += 1
            found = difference(first, second)
            if found > options.tolerance:
                differ += 1
                print(f"{scene.name}, {name}: differs by {found:.3g}", flush=True)
    print(f"{count} pictures, {differ} differ")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
