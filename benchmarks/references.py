#!/usr/bin/python3
"""Renders the reference images:

    benchmarks/references.py [SCENE ...] [--seconds 60 | --samples 1024] [--replicates 16] [--threads 2]

Cycles renders each scene with independent seeds, so that the variance of every mean is known. Two files are written:
`test_scenes/references/SCENE.npz` has the means of 16 x 16-pixel blocks with standard errors and is part of the project; `build/references/SCENE.npz`
has the mean and variance of every pixel. SCENE.json beside the first file describes its origin. --seconds is divided equally between the replicates;
the number of samples is the largest power of two that fits. --samples is per replicate and does not depend on the load of the machine.
"""

from __future__ import annotations

import argparse
import datetime
import hashlib
import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import agreement
import numpy as np
import renderers
from scenes import ALL_SCENES, PROJECT, Scene, find_scenes

BLOCK_SIZE = 16


@dataclass(frozen=True)
class Reference:
    """A committed reference. `origin` is its JSON."""

    blocks: agreement.Blocks
    origin: dict

    @property
    def noise(self) -> float:
        """Three standard errors divided by the mean, of the median block. The tests require less than 3 %."""
        lit = self.blocks.means > 0.0
        return float(np.median(3.0 * self.blocks.standard_errors[lit] / self.blocks.means[lit])) if lit.any() else 0.0


def file_hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def load_reference(scene: Scene) -> Reference:
    data = np.load(scene.reference)
    origin = json.loads(scene.reference.with_suffix(".json").read_text())
    blocks = agreement.Blocks(data["means"].astype(np.float64), data["standard_errors"].astype(np.float64),
                              origin["replicates"], origin["block_size"])
    return Reference(blocks, origin)


def samples_within(scene: Scene, seconds: float, threads: int, folder: Path) -> int:
    """The power of two of samples per pixel that takes about `seconds`, from a short trial."""
    trial = renderers.render_cycles(scene.path, folder, [1, 8], [99], threads, scene.percentage)
    per_sample = max((trial[1].seconds - trial[0].seconds) / 7, 1e-5)
    return 2 ** max(2, min(16, int(np.log2(max(seconds / per_sample, 1.0)))))


def make_reference(scene: Scene, seconds: float, samples: int | None, replicates: int, threads: int) -> str:
    """Render and write both files. Returns one line about the quality of the reference."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        samples = samples or samples_within(scene, seconds / replicates, threads, folder)
        seeds = list(range(1, replicates + 1))
        renders = renderers.render_cycles(scene.path, folder, [samples], seeds, threads, scene.percentage)
        replicate_images = [render.image() for render in renders]
    mean, variance = agreement.mean_and_variance(replicate_images)
    blocks = agreement.blocks_of_pixels(mean, variance, replicates, BLOCK_SIZE)
    commit = subprocess.run(["git", "-C", str(PROJECT), "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False)
    origin = {
        "scene": scene.name, "blend_sha256": file_hash(scene.path), "renderer": renders[0].renderer,
        "settings": "benchmarks/cycles_render.py, adaptive sampling off", "samples_per_pixel": samples, "seeds": f"{seeds[0]}-{seeds[-1]}",
        "replicates": replicates, "percentage": scene.percentage, "width": mean.shape[1], "height": mean.shape[0],
        "frame": renders[0].statistics["frame"], "block_size": BLOCK_SIZE, "commit": commit.stdout.strip(),
        "date": datetime.date.today().isoformat(), "render_seconds": round(sum(render.seconds for render in renders), 2),
        "threads": threads,
    }
    scene.reference.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(scene.reference, means=blocks.means.astype(np.float32), standard_errors=blocks.standard_errors.astype(np.float32))
    scene.reference.with_suffix(".json").write_text(json.dumps(origin, indent=1) + "\n")
    scene.pixel_reference.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(scene.pixel_reference, mean=mean.astype(np.float32), variance=variance.astype(np.float32), origin=json.dumps(origin))
    scatter = agreement.blocks_of_replicates(replicate_images, BLOCK_SIZE).standard_errors
    correlation = np.sqrt((scatter**2).sum() / max((blocks.standard_errors**2).sum(), 1e-300))
    return (f"{scene.name}: {replicates} x {samples} spp, {origin['render_seconds']} s; 3 standard errors of the median block "
            f"{Reference(blocks, origin).noise:.2%}; scatter of blocks / scatter of pixels {correlation:.2f}")


def main() -> int:
    parser = argparse.ArgumentParser(description="Make reference renders with Cycles.")
    parser.add_argument("scenes", nargs="*", help="names; without any, all that exist")
    parser.add_argument("--seconds", type=float, default=60.0, help="of path tracing per scene (default 60)")
    parser.add_argument("--samples", type=int, help="per pixel and replicate, instead of --seconds")
    parser.add_argument("--replicates", type=int, default=16, help="independent seeds (default 16)")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--missing", action="store_true", help="only scenes without a reference of the present file")
    options = parser.parse_args()
    scenes = find_scenes(options.scenes) if options.scenes else [scene for scene in ALL_SCENES if scene.path.exists()]
    for scene in scenes:
        if options.missing and scene.reference.exists() and load_reference(scene).origin["blend_sha256"] == file_hash(scene.path):
            continue
        print(make_reference(scene, options.seconds, options.samples, options.replicates, options.threads), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
