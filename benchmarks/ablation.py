#!/usr/bin/python3
"""Measures what each part of a default render is worth: the error without the part over the error with it, at equal CPU time.

    benchmarks/ablation.py [SCENE ...] [--seconds 10] [--repeats 3] --wheel PYTHON --extension build/extension/package

The default is `auto` with adaptive pixels (PMC-IP), the hints of the scene, and the combination of the denoised picture with the rendered one (OCV).
Other estimators of the thesis are rendered in place of the technique that `auto` takes. References and times are those of denoised.py. Writes
docs/benchmarks/ablation.md and build/denoised/ablation.json.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import denoised
import machine
import metrics
import numpy as np
import renderers
from scenes import PROJECT, Scene, find_scenes

SCENES = ["box", "room", "rooms", "lantern", "keyhole", "bar", "kitchen", "many_lights", "checker", "plant", "outdoor", "buddha"]
WORTH = 1.2   # a part that is worth less does not count


@dataclass(frozen=True)
class Variant:
    """A render that differs from the default in one setting."""

    name: str
    what: str
    integrator: str = "auto"
    setting: tuple[str, str] | None = None
    without_hints: bool = False
    combined: bool = True

    def change(self, description: Any) -> None:
        description.settings.image = "pmc_ip"
        if self.setting:
            setattr(description.settings, *self.setting)
        if self.without_hints:
            description.hints = []


DEFAULT = Variant("default", "`auto`, adaptive pixels, hints, combination")
PARTS = (Variant("no OCV", "the picture of the denoiser alone, not combined with the rendered one", combined=False),
         Variant("no PMC-IP", "the same number of samples in all pixels", setting=("image", "uniform")),
         Variant("no hints", "the hints of the scene are removed", without_hints=True),
         Variant("no choice", "path tracing, which is guided where that pays", "path", ("guiding", "auto")))
INSTEAD = (Variant("MPS", "Metropolis photon sampling", "mps"), Variant("PMC-PT", "population Monte Carlo path tracing", "pmc_pt"),
           Variant("PMC-HI", "path tracing with adaptive direct light", "path", ("direct", "pmc_hi")))


def measure_scene(scene: Scene, options: argparse.Namespace) -> dict:
    """The errors of all renders of a scene, before and after denoising."""
    folder = PROJECT / "build" / "denoised" / scene.name
    scene_file = renderers.export_by_wheel(scene.path, folder, options.wheel, options.extension, scene.percentage)
    reference = denoised.reference_of(scene, scene_file, options)
    load = denoised.Load(options.threads)
    denoising = denoised.denoising_seconds(scene_file, load, options.seconds)
    import ajar

    has_hints = any(hint.enabled for hint in ajar.load_description(str(scene_file)).hints)
    runs = []
    for seed in range(1, options.repeats + 1):
        for variant in (DEFAULT, *PARTS, *INSTEAD):
            if variant.without_hints and not has_hints:
                continue
            if variant.combined:   # otherwise, the render is that of the default
                found, stats, _ = denoised.whole_render(scene_file, variant.integrator, max(0.1, options.seconds - denoising), seed, load, change=variant.change)
            image, _ = denoised.denoise(found, stats["rays"], options.threads, variant.combined, ajar.denoiser.biased_of(stats))
            noisy = found["Combined"][..., :3].astype(np.float64)
            runs.append({"name": variant.name, "seed": seed, "technique": stats["integrator"],
                         "relmse": metrics.relmse(image, reference.mean, reference.variance), "noisy": metrics.relmse(noisy, reference.mean, reference.variance)})
            print("{name}: {technique}, relMSE {relmse:.3g}, noisy {noisy:.3g}".format(**runs[-1]), flush=True)
    return {"scene": scene.name, "runs": runs}


def ratio(found: dict, name: str, key: str) -> float:
    """The median error of a variant over that of the default; not a number without the variant, or where a reference is not precise enough."""
    median = {of: statistics.median([run[key] for run in found["runs"] if run["name"] == of] or [math.nan]) for of in (name, DEFAULT.name)}
    return median[name] / median[DEFAULT.name] if min(median.values()) > 0.0 else math.nan


def table(scenes: list[dict], variants: tuple[Variant, ...], key: str) -> list[str]:
    lines = ["| scene | technique | " + " | ".join(variant.name for variant in variants) + " |", "|---" * (len(variants) + 2) + "|"]
    ratios = {variant.name: [ratio(found, variant.name, key) for found in scenes] for variant in variants}
    for i, found in enumerate(scenes):
        techniques = dict.fromkeys(run["technique"] for run in found["runs"] if run["name"] == DEFAULT.name)
        cells = (ratios[variant.name][i] for variant in variants)
        lines.append(f"| {found['scene']} | {', '.join(techniques)} | " + " | ".join("–" if math.isnan(cell) else f"{cell:.2f}" for cell in cells) + " |")
    worth = (f"{sum(cell >= WORTH for cell in ratios[variant.name])} of {sum(not math.isnan(cell) for cell in ratios[variant.name])}" for variant in variants)
    return [*lines, f"| at least {WORTH} | | " + " | ".join(worth) + " |"]


def page(results: dict) -> str:
    scenes = results["scenes"]
    seeds = sorted({max(run["seed"] for run in found["runs"]) for found in scenes})
    lines = ["# What each part of a default render is worth", "",
             "The relMSE without a part over that of the default render, at equal CPU time. More than 1: the part makes the error smaller.", "",
             "## The picture that the artist keeps, denoised", "", *table(scenes, PARTS, "relmse"), "",
             "### Before denoising", "", *table(scenes, PARTS[1:], "noisy"), "",
             "## Estimators of the thesis in place of the default, denoised", "", "More than 1: the default has the smaller error.", "", *table(scenes, INSTEAD, "relmse"), "",
             "### Before denoising", "", *table(scenes, INSTEAD, "noisy"), "", "## Method", "",
             f"`benchmarks/ablation.py` writes this page; do not edit it. {results['seconds']:g} CPU seconds for rendering and denoising, without export and build, on "
             f"{results['machine']['threads']} threads; {' or '.join(map(str, seeds))} seeds, medians: differences of 15 % are noise. relMSE is mean((I−R)²/(R²+0.01)), from which the variance of the reference is subtracted. "
             "*technique* is what `auto` took in the default renders. The variants:", "",
             *(f"* **{variant.name}**: {variant.what}." for variant in (DEFAULT, *PARTS, *INSTEAD)), "", "## Machine", "",
             *(f"* {key}: {value}" for key, value in results["machine"].items())]
    return "\n".join(lines) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description="Measure what each part of a default render is worth.")
    parser.add_argument("scenes", nargs="*", default=[], help=f"names; without any: {', '.join(SCENES)}")
    parser.add_argument("--build", type=Path, default=PROJECT / "build" / "release")
    parser.add_argument("--seconds", type=float, default=10.0, help="CPU seconds of a render")
    parser.add_argument("--reference-seconds", type=float, default=120.0, help="of each scene's reference, if it is not there")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--wheel", required=True, help="a Python with the bpy wheel of a newer Blender, which exports the scenes")
    parser.add_argument("--extension", type=Path, required=True, help="an unpacked extension for that Python")
    options = parser.parse_args()
    sys.path.insert(0, str(options.build.resolve() / "python"))
    if not denoised.load_denoiser():
        return 2
    file, start = PROJECT / "build" / "denoised" / "ablation.json", time.monotonic()
    results = {"machine": machine.describe(options.threads), "seconds": options.seconds, "scenes": []}
    if file.exists() and (kept := json.loads(file.read_text()))["seconds"] == options.seconds:
        results["scenes"] = kept["scenes"]
    for scene in find_scenes(options.scenes or SCENES):
        print(f"{scene.name}:", flush=True)
        results["scenes"] = [found for found in results["scenes"] if found["scene"] != scene.name] + [measure_scene(scene, options)]
        file.write_text(json.dumps(results, indent=1))
        (PROJECT / "docs" / "benchmarks" / "ablation.md").write_text(page(results))
    print(f"{time.monotonic() - start:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
