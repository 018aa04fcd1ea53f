#!/usr/bin/python3
"""Compares the noise of one sample of Ajar and Cycles in small set-ups, each with one kind of light and one kind of material:

    benchmarks/noise.py [PART_OF_A_NAME ...] [--zip ZIP] [--wheel 5.2.3] [--samples 16] [--seeds 4]

Both use path tracing with the same number of samples. Prints a line for each set-up. Without names, writes docs/benchmarks/noise.md.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import machine
from scenes import PROJECT

sys.path.insert(0, str(PROJECT / "tests" / "compatibility"))
import compatibility

INSIDE = Path(__file__).resolve().parent / "noise_render.py"
PAGE = PROJECT / "docs" / "benchmarks" / "noise.md"
LEAST = 1e-3   # noise below it does not matter


def measured(wheel: compatibility.Blender, options: argparse.Namespace) -> list[dict]:
    found = []
    with tempfile.TemporaryDirectory() as folder:
        process = subprocess.Popen([wheel.command[0], INSIDE, wheel.zip, f"{folder}/image.exr", str(options.samples), str(options.seeds), *options.parts], stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True, errors="replace", env=os.environ | {"BLENDER_USER_RESOURCES": f"{folder}/profile"})
        others = []
        for line in process.stdout or ():
            if line.startswith("NOISE "):
                found.append(json.loads(line.removeprefix("NOISE ")))
                print(row(found[-1]), flush=True)
            else:
                others.append(line)
        if process.wait():
            raise SystemExit("".join(others[-20:]))
    return found


def variance_ratio(found: dict) -> float:
    return (max(found["AJAR"]["deviation"], LEAST) / max(found["CYCLES"]["deviation"], LEAST)) ** 2


def row(found: dict) -> str:
    ours, theirs = found["AJAR"], found["CYCLES"]
    return (f"| {found['name']} | {ours['mean'] / theirs['mean']:.3f} | {theirs['deviation']:.3f} | {ours['deviation']:.3f} | {variance_ratio(found):.2f} | "
            f"{ours['cpu'] / theirs['cpu']:.2f} |")


def page(found: list[dict], wheel: str, options: argparse.Namespace) -> str:
    ratios = [variance_ratio(f) for f in found]
    lines = ["# Noise of one sample", "",
             f"Variance of Ajar over that of Cycles {wheel}, path tracing, equal samples: geometric mean {math.exp(sum(map(math.log, ratios)) / len(ratios)):.2f} of {len(found)} small "
             "set-ups.", "",
             "| set-up | ratio of means | deviation, Cycles | deviation, Ajar | variance, Ajar over Cycles | CPU |", "|---|---|---|---|---|---|", *map(row, found), "",
             "## Method", "",
             f"`benchmarks/noise.py` writes this page; do not edit it. Images of 48 × 48 pixels, {options.samples} samples, {options.seeds} seeds. The deviation is that between seeds, times the "
             "root of the samples, over the mean of the image. It contains what stratification gains. Deviations below 0.001 count as 0.001. CPU times contain export, build and the start "
             "of a render, which are most of the time of such small images. Means with a deviation above 1 are uncertain.", "", "## Machine", ""]
    lines += [f"* {key}: {value}" for key, value in machine.describe(os.cpu_count() or 1).items()]
    return "\n".join(lines) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*")
    parser.add_argument("--zip", type=Path, help="the extension; without it, that in out/")
    parser.add_argument("--wheel", default="5.2.3", choices=compatibility.WHEELS)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--seeds", type=int, default=4)
    options = parser.parse_args()
    found = measured(compatibility.wheel(options.wheel, (options.zip or compatibility.zips()[0]).resolve()), options)
    if not options.parts:
        PAGE.write_text(page(found, options.wheel, options))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
