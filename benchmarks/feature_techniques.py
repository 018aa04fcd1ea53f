#!/usr/bin/python3
"""Tests whether all techniques show every feature in the same way: scenes of one feature each (test_scenes/features.py), exported by a bpy wheel:

    benchmarks/feature_techniques.py [NAME ...] [--techniques bdpt,erpt,...] [--kinds hair,volume] [--seconds 0.5] --wheel PYTHON

Path tracing is the reference. The means of 8 x 8-pixel blocks of 64 x 64-pixel images, over eight independent seeds each, must agree within 1 % plus three
standard errors of the difference, and so must the mean of the image. The standard errors come from the scatter of the block means, because the pixels of chains and photons are correlated.
Eight seeds know them within 27 %, so that some blocks exceed this at random. Such a feature is rendered again, and only blocks that exceed it again disagree: with 24 new seeds and three times the time,
or, for a consistent technique, whose bias vanishes with the time, with eight new seeds and twelve times the time.
Each render has one thread; --seconds are those of one render. The extension is unpacked in build/extension (`make extension`). The table at the end counts the features that agree.
"""

from __future__ import annotations

import argparse
import collections
import json
import os
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import agreement
import in_process
import machine
import numpy as np
from feature_agreement import BLOCK, features, places, write_scenes
from renderers import wheel_export
from scenes import PROJECT

import ajar

TECHNIQUES = ["bdpt", "erpt", "metropolis", "pmc_pt", "photon_map", "mps", "irradiance_cache"]
REPLICATES = 8
AGAIN = {True: (24, 3), False: (8, 12)}   # of unbiased and other techniques: seeds, times the time

# Kinds of features that all techniques take from the same code: the graph of a material, evaluated at a point.
SHARED = {"node"}


@dataclass(frozen=True)
class Render:
    scene: Path
    technique: str
    seed: int
    seconds: float

    def image(self) -> np.ndarray:
        description = ajar.load_description(str(self.scene))
        settings = description.settings
        settings.integrator, settings.seed, settings.seconds, settings.samples, settings.threads = self.technique, self.seed, self.seconds, 1 << 20, 1
        settings.image, settings.passes = "uniform", ["Combined"]
        session = ajar.Session()
        session.start(description)
        in_process.finish(session)
        return np.asarray(session.snapshot("Combined")).astype(np.float64)


@dataclass(frozen=True)
class Found:
    """`ratio`: of the means of the images; `uncertainty`: its standard error; `outside`: blocks that disagree twice; `worst`: the first of them."""

    name: str
    technique: str
    ratio: float
    uncertainty: float
    outside: int
    blocks: int
    worst: str


def blocks_and_whole(pictures: list[np.ndarray]) -> tuple[agreement.Blocks, agreement.Blocks]:
    return agreement.blocks_of_replicates(pictures, BLOCK), agreement.blocks_of_replicates(pictures, max(pictures[0].shape[:2]))


def compare(pool, scene: Path, techniques: list[str], seconds: float) -> list[Found]:
    """Each technique against path tracing in one scene."""
    def pictures_of(technique: str, seeds: range, factor: int):
        renders = [Render(scene, technique, seed, seconds * factor) for seed in seeds]
        return blocks_and_whole(list(pool.map(Render.image, renders)))

    unbiased = {info.name: info.bias == ajar.Bias.Unbiased for info in ajar.integrator_list()}
    reference, long_references = pictures_of("path", range(1001, 1001 + REPLICATES), 1), {}
    results = []
    for technique in techniques:
        ours, theirs = pictures_of(technique, range(1, 1 + REPLICATES), 1), reference
        found = [agreement.disagreements(o, t) for o, t in zip(ours, theirs, strict=True)]
        outside = []
        if any(found):
            replicates, factor = AGAIN[unbiased[technique]]
            if factor not in long_references:
                long_references[factor] = pictures_of("path", range(2001, 2001 + replicates), factor)
            ours, theirs = pictures_of(technique, range(101, 101 + replicates), factor), long_references[factor]
            for before, o, t in zip(found, ours, theirs, strict=True):
                outside += [d for d in agreement.disagreements(o, t) if (d.row, d.column, d.channel) in places(before)]
        whole, reference_whole = ours[1].means[..., :3].mean(), max(theirs[1].means[..., :3].mean(), 1e-12)
        error = np.hypot(ours[1].standard_errors[..., :3].mean(), theirs[1].standard_errors[..., :3].mean()) / reference_whole
        results.append(Found(scene.stem, technique, float(whole / reference_whole), float(error), len({(d.row, d.column) for d in outside}),
                             ours[0].means[..., 0].size, str(outside[0]) if outside else ""))
    return results


def table(results: list[Found], known: dict[str, dict[str, str]], seconds: float) -> str:
    """Agreeing features of each kind by technique, and every pair that differs."""
    techniques = list(dict.fromkeys(found.technique for found in results))
    counts = collections.Counter((known[f.name]["kind"], f.technique, f.outside == 0) for f in results)
    lines = [f"| kind | {' | '.join(f'`{t}`' for t in techniques)} |", "|---|" + "---|" * len(techniques)]
    for kind in dict.fromkeys(known[f.name]["kind"] for f in results):
        cells = [f"{counts[kind, t, True]} of {counts[kind, t, True] + counts[kind, t, False]}" for t in techniques]
        lines.append(f"| {kind} | {' | '.join(cells)} |")
    lines += ["", "| differs | technique | blocks outside | ratio of means |", "|---|---|---|---|"]
    lines += [f"| {f.name} | `{f.technique}` | {f.outside} of {f.blocks} | {f.ratio:.4f} ± {f.uncertainty:.4f} |" for f in results if f.outside]
    about = machine.describe(1)
    return f"{about['processor']}, {about['commit']}, {seconds:g} s with one thread for each render.\n\n" + "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="names of features; all by default, but for nodes, which all techniques share")
    parser.add_argument("--kinds", default="", help="of features, separated by commas")
    parser.add_argument("--techniques", default=",".join(TECHNIQUES))
    parser.add_argument("--seconds", type=float, default=0.5, help="of each render with one thread")
    parser.add_argument("--keep", type=Path, help="folder for scenes and results, instead of a temporary one; what is there is not made again")
    parser.add_argument("--wheel", required=True, help="Python of a bpy wheel")
    parser.add_argument("--extension", type=Path, default=PROJECT / "build" / "extension" / "package")
    options = parser.parse_args()
    known = features()
    kinds = set(options.kinds.split(",")) if options.kinds else {entry["kind"] for entry in known.values()} - SHARED
    names = options.names or [name for name, entry in known.items() if entry["kind"] in kinds]
    if unknown := [name for name in names if name not in known]:
        parser.error(f"no feature {', '.join(unknown)}; there are {', '.join(known)}")
    results = []
    with tempfile.TemporaryDirectory() as temporary, ProcessPoolExecutor(os.cpu_count()) as pool:
        folder = options.keep or Path(temporary)
        if missing := [name for name in names if not (folder / f"{name}.ajar").exists()]:
            write_scenes(folder, missing)
            wheel_export([(folder / f"{name}.blend", folder / f"{name}.ajar") for name in missing], options.wheel, options.extension, ["--as-it-is"])
        for name in names:
            for found in compare(pool, folder / f"{name}.ajar", options.techniques.split(","), options.seconds):
                results.append(found)
                state = f"DISAGREES, {found.outside} of {found.blocks} blocks outside" if found.outside else "agrees"
                print(f"{name}, {found.technique}: {state}, ratio {found.ratio:.4f} ± {found.uncertainty:.4f} {found.worst}", flush=True)
            (folder / "techniques.json").write_text(json.dumps([vars(found) for found in results], indent=1))
    print(table(results, known, options.seconds))
    return 0 if not any(found.outside for found in results) else 1


if __name__ == "__main__":
    sys.exit(main())
