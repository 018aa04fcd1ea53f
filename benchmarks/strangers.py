#!/usr/bin/python3
"""Renders files of strangers by Ajar and Cycles in a newer Blender, as F12 does, and compares the images.

    benchmarks/strangers.py LIST [--zip ZIP] [--wheel 5.2.3] [--samples 32] [--longest 256] [--only PART] [--write DOCS] [--sheets all|far]

LIST has a path on each line, and after a tab where the file is from. Results are in build/strangers; files that have one are not rendered again unless
--only names them. Prints a line for each file; --write writes a page with a table and sheets of images: Cycles, Ajar, and their difference.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import agreement
import images
import numpy as np
from report import write_jpegs
from scenes import PROJECT

sys.path.insert(0, str(PROJECT / "tests" / "compatibility"))
import compatibility

WORK = PROJECT / "build" / "strangers"
INSIDE = Path(__file__).resolve().parent / "strangers_render.py"
TIMEOUT_SECONDS = 900
FAR = 0.05   # a mean that differs by more has to be explained
BLOCK = 16


@dataclass(frozen=True)
class File:
    path: Path
    source: str

    @property
    def name(self) -> str:
        """A short name that is also that of the folder of results."""
        return re.sub(r"[^A-Za-z0-9_.-]+", "_", f"{self.source.split('/')[-1]}_{self.path.stem}".strip("_"))


@dataclass(frozen=True)
class Comparison:
    file: File
    ratio: float = float("nan")     # of the means of all channels
    error: float = float("nan")     # its standard error
    mean: float = 0.0               # of Cycles
    blocks_out: int = 0
    blocks: int = 0
    cpu: float = float("nan")       # CPU seconds of Ajar over those of Cycles
    noise: float = float("nan")     # variance of a pixel of Ajar over that of Cycles, as noise_of
    failure: str = ""
    messages: tuple[str, ...] = ()

    @property
    def is_far(self) -> bool:
        return bool(self.failure) or abs(self.ratio - 1.0) > FAR + 3.0 * self.error


def read_list(path: Path) -> list[File]:
    rows = [line.split("\t") for line in path.read_text().splitlines() if line.strip()]
    return [File(Path(row[0]), row[1] if len(row) > 1 else "") for row in rows]


def render(file: File, wheel: compatibility.Blender, samples: int, longest: int) -> None:
    out = WORK / file.name
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    with open(out / "log.txt", "w") as log:
        try:
            subprocess.run([wheel.command[0], INSIDE, wheel.zip, file.path, out, str(samples), str(longest)], stdout=log, stderr=subprocess.STDOUT,
                           env=os.environ | {"BLENDER_USER_RESOURCES": str(out / "profile")}, timeout=TIMEOUT_SECONDS, check=False)
        except subprocess.TimeoutExpired:
            (out / "result.json").write_text(json.dumps({"error": f"not done after {TIMEOUT_SECONDS} s"}))
    shutil.rmtree(out / "profile", ignore_errors=True)
    if not (out / "result.json").exists():
        (out / "result.json").write_text(json.dumps({"error": "the process ended: " + (out / "log.txt").read_text()[-300:]}))


def pictures(file: File) -> dict[str, list[np.ndarray]]:
    """The images of both engines, between black and twice the 99.5th percentile of Cycles: without fireflies and negative light."""
    stored = np.load(WORK / file.name / "images.npz")
    limit = 2.0 * max(np.percentile(stored[f"CYCLES_{seed}"], 99.5) for seed in (1, 2)) + 1e-6
    return {engine: [np.clip(stored[f"{engine}_{seed}"], 0.0, limit).astype(np.float64) for seed in (1, 2)] for engine in ("CYCLES", "AJAR")}


def noise_of(found: dict[str, list[np.ndarray]]) -> float:
    """The mean relative variance of a pixel of Ajar over that of Cycles, between two seeds, without the worst 1 % of the pixels of each."""
    mean = np.mean([image for images_ in found.values() for image in images_], axis=0)
    means = []
    for first, second in (found["AJAR"], found["CYCLES"]):
        variance = np.sort((0.5 * (first - second) ** 2 / (mean**2 + 0.01 * mean.mean() ** 2 + 1e-8)).mean(axis=2), axis=None)
        means.append(variance[: variance.size * 99 // 100].mean())
    return float(means[0] / means[1]) if means[1] > 0.0 else float("nan")


def compare(file: File) -> Comparison:
    result = json.loads((WORK / file.name / "result.json").read_text())
    log = (WORK / file.name / "log.txt").read_text(errors="replace") if (WORK / file.name / "log.txt").exists() else ""
    messages = tuple(dict.fromkeys(line.strip() for line in log.splitlines() if line.startswith(("Warning: ", "Error: "))))
    if "error" in result:
        return Comparison(file, failure=result["error"].strip().splitlines()[-1], messages=messages)
    found = pictures(file)
    if not all(np.isfinite(picture).all() for picture in found["AJAR"]):
        return Comparison(file, failure="an image has values that are not finite", messages=messages)
    mean = {engine: agreement.mean_and_variance(images_) for engine, images_ in found.items()}
    ours, theirs = (agreement.blocks_of_pixels(*mean[engine], 2, BLOCK) for engine in ("AJAR", "CYCLES"))
    totals = {engine: mean[engine][0].mean() for engine in mean}
    errors = [np.sqrt(variance.sum()) / variance.size / max(totals[engine], 1e-9) for engine, (_, variance) in mean.items()]
    cpu = {engine: min(seconds[1] for seconds in result["seconds"][engine]) for engine in totals}
    ratio = totals["AJAR"] / totals["CYCLES"] if totals["CYCLES"] > 1e-6 else 1.0 if totals["AJAR"] < 1e-6 else float("inf")
    return Comparison(file, float(ratio), float(np.hypot(*errors)), float(totals["CYCLES"]), len({(d.row, d.column) for d in agreement.disagreements(ours, theirs)}),
                      int(ours.means[..., 0].size), cpu["AJAR"] / cpu["CYCLES"], noise_of(found), "", messages)


def line_of(c: Comparison) -> str:
    if c.failure:
        return f"{c.file.name}: FAILED: {c.failure}"
    return (f"{'FAR ' if c.is_far else ''}{c.file.name}: {c.ratio:.3f} ± {c.error:.3f}, {c.blocks_out} of {c.blocks} blocks, CPU {c.cpu:.2f}, noise {c.noise:.2f}, mean {c.mean:.3g}")


# ---- The page -----------------------------------------------------------------------------------------------------------

def strip(file: File) -> np.ndarray:
    """Cycles, Ajar, and half grey plus the relative difference, 8-bit sRGB from the top down."""
    mean = {engine: np.mean(found, axis=0)[::-1] for engine, found in pictures(file).items()}
    exposure = 1.0 / max(np.percentile(mean["CYCLES"], 98), 1e-6)
    scale = mean["CYCLES"].mean(axis=2, keepdims=True) + 0.02 * mean["CYCLES"].mean() + 1e-9
    difference = np.clip(0.5 + (mean["AJAR"] - mean["CYCLES"]) / scale, 0.0, 1.0)
    gap = np.full((scale.shape[0], 4, 3), 255, dtype=np.uint8)
    return np.concatenate([images.srgb_bytes(mean["CYCLES"], exposure), gap, images.srgb_bytes(mean["AJAR"], exposure), gap,
                           (255.0 * difference).astype(np.uint8)], axis=1)


def sheet(strips: list[np.ndarray]) -> np.ndarray:
    """Strips below each other in two columns."""
    width, height = max(s.shape[1] for s in strips), max(s.shape[0] for s in strips)
    padded = []
    for s in strips:
        cell = np.full((height + 6, width + 12, 3), 255, dtype=np.uint8)
        cell[: s.shape[0], : s.shape[1]] = s
        padded.append(cell)
    if len(padded) % 2:
        padded.append(np.full_like(padded[0], 255))
    return np.concatenate([np.concatenate(padded[i : i + 2], axis=1) for i in range(0, len(padded), 2)])


def write_page(found: list[Comparison], docs: Path, samples: int, version: str, sheets: str, on_sheet: int = 12) -> None:
    docs.mkdir(parents=True, exist_ok=True)
    shown = [c for c in found if not c.failure]
    far = [c for c in found if c.is_far]
    lines = ["# Files of strangers", "",
             f"**{len(found) - len(far)} of {len(found)} files have a mean within {FAR:.0%} of that of Cycles {version}**; "
             f"{sum(abs(c.ratio - 1.0) <= 0.01 + 3.0 * c.error for c in shown)} are within 1 % plus three standard errors. "
             f"Medians of Ajar over Cycles, at equal samples: CPU time {np.median([c.cpu for c in shown]):.2f}, variance {np.nanmedian([c.noise for c in shown]):.2f}, "
             f"their product {np.nanmedian([c.cpu * c.noise for c in shown]):.2f}.", "",
             "| file | from | ratio of means | blocks outside | CPU time | variance |", "|---|---|---|---|---|---|"]
    lines += [f"| {c.file.path.stem} | {c.file.source} | " + (f"{c.failure} | | | |" if c.failure else
              f"{'**' if c.is_far else ''}{c.ratio:.3f} ± {c.error:.3f}{'**' if c.is_far else ''} | {c.blocks_out} of {c.blocks} | {c.cpu:.2f} | {c.noise:.2f} |") for c in found]
    lines += ["", "## Method", "",
              f"`benchmarks/strangers.py` opens each file in the bpy wheel of Blender {version} and renders it as F12 does, with the path tracer, {samples} samples, two "
              "seeds, without clamping, Filter Glossy and denoising. Values are limited to 0 (Cycles emits negative light) and twice the 99.5th percentile of Cycles. A block of 16 × 16 pixels "
              "is outside if it differs by more than 1 % plus three standard errors. CPU times include export and build. The variance is that of a pixel, relative to its squared "
              "value, without the worst 1 % of the pixels; times the CPU time, it says how long Ajar takes for the noise of Cycles.", "", "## Sheets", "",
              ("The files that are far from Cycles, in" if sheets == "far" else "In") + " the order of the table, in rows: Cycles, Ajar, difference (grey: none; black and "
              "white: as large as the light).", ""]
    pngs = []
    drawn = [c for c in shown if c.is_far or sheets == "all"]
    for first in range(0, len(drawn), on_sheet):
        pngs.append(docs / f"sheet_{first // on_sheet + 1}.png")
        images.write_png(pngs[-1], sheet([strip(c.file) for c in drawn[first : first + on_sheet]]))
        lines += [f"![sheet](sheet_{first // on_sheet + 1}.jpg)", ""]
    write_jpegs(pngs)
    page = docs / "index.md"
    kept = page.read_text().split(compatibility.REMARKS)[1] if page.exists() and compatibility.REMARKS in page.read_text() else "\n"
    page.write_text("\n".join(lines) + "\n" + compatibility.REMARKS + kept)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("list", type=Path)
    parser.add_argument("--zip", type=Path, help="the extension; without it, that in out/")
    parser.add_argument("--wheel", default="5.2.3", choices=compatibility.WHEELS)
    parser.add_argument("--samples", type=int, default=32)
    parser.add_argument("--longest", type=int, default=256, help="pixels of the longer side")
    parser.add_argument("--only", help="a part of the names of the files to render again")
    parser.add_argument("--write", type=Path, help="folder of the page")
    parser.add_argument("--sheets", choices=("all", "far"), default="all", help="which files the page shows")
    options = parser.parse_args()
    wheel = compatibility.wheel(options.wheel, (options.zip or compatibility.zips()[0]).resolve())
    found = []
    for file in read_list(options.list):
        again = options.only is not None and options.only in file.name
        if options.only and not again and not options.write:
            continue
        if again or not (WORK / file.name / "result.json").exists():
            render(file, wheel, options.samples, options.longest)
        found.append(compare(file))
        print(line_of(found[-1]), flush=True)
    if options.write:
        write_page(found, options.write, options.samples, options.wheel, options.sheets)
    print(f"{sum(c.is_far for c in found)} of {len(found)} files are far from Cycles.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
