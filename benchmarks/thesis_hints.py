#!/usr/bin/python3
"""Measures the gain of light hints (thesis, figure 4.3), and that wrong hints cause no bias:

    PYTHONPATH=build/release/python benchmarks/thesis_hints.py SCENE.ajar [--integrator metropolis] [--spp 48] [--seeds 8] [--scale 0.15]
    PYTHONPATH=build/release/python benchmarks/thesis_hints.py SCENE.ajar --wrong --seeds 200 --spp 4 --scale 0.08

SCENE.ajar comes from --ajar-dump-scene and contains the hints. Renders with and without hints alternate, seed by seed; T is the CPU time of the
process, one thread. The variance is that between seeds, weighted as relMSE by the mean of all renders. Both use the same seeds, so that rare bright
samples, most of which occur in both, have little influence. `--wrong` replaces the hints by others from the same light in random directions, with
very wide to very narrow cones, and compares the means of 4 x 3 blocks and three colours by t-tests, with other seeds. `--useless` replaces them by one
narrow one in a random direction, whose cost T shows.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from pathlib import Path

import numpy as np

import ajar

EPSILON = 0.01
SPREADS = {"wrong": (3.1, 3.1, 0.5, 0.5, 0.1, 0.1, 1e-4, 1e-4), "useless": (0.1,)}


def add_wrong(description: ajar.SceneDescription, numbers: np.random.Generator, spreads: tuple[float, ...]) -> None:
    """Add hints with the start points of the scene's hints, in random directions to the first surface, one for each spread."""
    start = np.array(description.hints[0].points[0], dtype=np.float32)
    step = 0.1 * max(np.linalg.norm(hint.points - start, axis=1).max() for hint in description.hints)
    for number, spread in enumerate(spreads):
        direction = numbers.standard_normal(3)
        points = [start, start + step * direction / np.linalg.norm(direction)]
        description.add_hint(name=f"Wrong {number + 1}", points=np.array(points, dtype=np.float32), spread=spread)


def render(options: argparse.Namespace, hints: str, seed: int) -> tuple[np.ndarray, float, dict]:
    """Image, CPU seconds, statistics. `hints`: own, none, wrong or useless."""
    description = ajar.load_description(options.scene)
    if hints != "own":
        for hint in description.hints:
            hint.enabled = False
    if hints in SPREADS:
        add_wrong(description, np.random.default_rng(1), SPREADS[hints])
    settings = description.settings
    settings.width, settings.height = width, height = int(settings.width * options.scale), int(settings.height * options.scale)
    settings.region = [0, 0, 0, 0]
    settings.integrator, settings.samples, settings.seconds, settings.target_error = options.integrator, options.spp, 0.0, 0.0
    settings.seed, settings.threads, settings.vertex_merging = seed, 1, options.vertex_merging
    start = time.process_time()
    session = ajar.Session()
    session.start(description)
    while not session.wait(0.05):
        pass
    cpu = time.process_time() - start
    if error := session.take_error():
        raise RuntimeError(error)
    image = np.asarray(session.snapshot("Combined"), dtype=np.float64).reshape(height, width, 4)[..., :3]
    return image, cpu, json.loads(session.statistics_json())


def blocks_of(image: np.ndarray) -> np.ndarray:
    return np.array([part.mean(axis=(0, 1)) for row in np.array_split(image, 3, axis=0) for part in np.array_split(row, 4, axis=1)]).ravel()


def compare_means(a: np.ndarray, b: np.ndarray) -> str:
    """Welch's t-tests of every block. There are enough seeds for the normal distribution."""
    difference = a.mean(axis=0) - b.mean(axis=0)
    error = np.sqrt(a.var(axis=0, ddof=1) / len(a) + b.var(axis=0, ddof=1) / len(b))
    p = np.array([math.erfc(abs(t) / math.sqrt(2.0)) for t in difference / error])
    whole = a.mean(axis=1), b.mean(axis=1)
    shift = whole[0].mean() / whole[1].mean() - 1.0
    of_shift = math.sqrt(whole[0].var(ddof=1) / len(a) + whole[1].var(ddof=1) / len(b)) / whole[1].mean()
    return f"{len(p)} block means, minimum p {p.min():.3g} ({len(p) * p.min():.2g} by Bonferroni); whole image {100 * shift:+.2f} % with a standard error of {100 * of_shift:.2f} %"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--integrator", default="metropolis")
    parser.add_argument("--spp", type=int, default=48)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--scale", type=float, default=0.15)
    parser.add_argument("--vertex-merging", choices=["on", "off"], default="off")
    parser.add_argument("--wrong", action="store_true")
    parser.add_argument("--useless", action="store_true")
    options = parser.parse_args()

    kinds = ("wrong" if options.wrong else "useless" if options.useless else "own", "none")
    images: dict[str, list[np.ndarray]] = {kind: [] for kind in kinds}
    seconds: dict[str, list[float]] = {kind: [] for kind in kinds}
    statistics = {}
    for seed in range(1, options.seeds + 1):
        for kind in kinds:
            image, cpu, statistics[kind] = render(options, kind, 10**6 + seed if kind == "wrong" else seed)
            images[kind].append(image)
            seconds[kind].append(cpu)
    hinted, plain = (np.array(images[kind]) for kind in kinds)
    reports = statistics[kinds[0]]["hints"]
    print(f"{Path(options.scene).stem} {options.integrator}, {plain.shape[2]} x {plain.shape[1]}, {options.spp} samples, {options.seeds} seeds; "
          f"{sum(report['attached'] for report in reports)} of {len(reports)} light hints attached")
    if options.wrong:
        print("means:", compare_means(np.array([blocks_of(image) for image in hinted]), np.array([blocks_of(image) for image in plain])))
    # Weighted by the mean of both, since a render that misses light would seem to have no noise. The epsilon is relative, for dark images.
    brightness = 0.5 * (hinted.mean(axis=0) + plain.mean(axis=0)).mean(axis=-1, keepdims=True)
    weight = brightness**2 + EPSILON * brightness.mean() ** 2
    variances = [np.sort((stack.var(axis=0, ddof=1) / weight).mean(axis=-1), axis=None) for stack in (hinted, plain)]
    kept = variances[0].size - math.ceil(0.001 * variances[0].size)
    ratio, trimmed = variances[0].mean() / variances[1].mean(), variances[0][:kept].mean() / variances[1][:kept].mean()
    t = float(np.mean(seconds[kinds[0]]) / np.mean(seconds["none"]))
    print(f"with over without: variance {ratio:.2f} ({trimmed:.2f} without the worst 0.1 % of pixels), T {t:.2f}, time to the same variance {ratio * t:.2f}")


if __name__ == "__main__":
    main()
