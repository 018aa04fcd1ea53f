#!/usr/bin/python3
"""PMC-IP against uniform sampling (thesis, table 5.1), and both at equal time:

    PYTHONPATH=build/release/python benchmarks/thesis_image.py SCENE.ajar REFERENCE.npz --spp 10 16 32 [--against 16] [--scale 0.3] [--seeds 3]

SCENE.ajar comes from --ajar-dump-scene. REFERENCE.npz holds `image` and the `variance` of its pixel means, rows bottom up; `--make-reference
SECONDS` renders it first. One thread, methods interleaved seed by seed; T is the process's CPU time from the first sample on, since a
shared machine's wall time says little. Err is the mean of e^2 / tvi(L), so its ratios equal those of the thesis's sums; P-Eff = 1 / (T Err).
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import metrics
import numpy as np

import ajar


def render(options: argparse.Namespace, image: str, samples: int, seed: int, seconds: float = 0.0) -> tuple[dict[str, np.ndarray], float, dict]:
    """Passes, CPU seconds of rendering, statistics."""
    description = ajar.load_description(options.scene)
    settings = description.settings
    settings.width, settings.height = int(settings.width * options.scale), int(settings.height * options.scale)
    settings.region = [0, 0, settings.width, settings.height]
    settings.integrator, settings.image, settings.image_error = options.integrator, image, options.measure
    settings.samples, settings.seconds, settings.target_error = samples, seconds, 0.0
    settings.seed, settings.threads, settings.passes = seed, 1, ["Combined", "Variance"]
    if options.direct_only:
        bounces = settings.bounces
        bounces.total = 0
        settings.bounces = bounces
    session = ajar.Session()
    session.start(description)
    while session.progress().phase in (ajar.Progress.Phase.Idle, ajar.Progress.Phase.Building):
        time.sleep(0.001)
    start = time.process_time()
    while not session.wait(0.05):
        pass
    cpu = time.process_time() - start
    if error := session.take_error():
        raise RuntimeError(error)
    passes = {name: np.asarray(session.snapshot(name), dtype=np.float64) for name in ("Combined", "Variance")}
    return passes, cpu, json.loads(session.statistics_json())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("reference", type=Path)
    parser.add_argument("--spp", type=int, nargs="+", default=[16, 64])
    parser.add_argument("--against", type=int, help="samples of uniform sampling; else the same as of PMC-IP")
    parser.add_argument("--scale", type=float, default=0.3)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--integrator", default="path")
    parser.add_argument("--measure", default="relative", choices=["relative", "perceptual"])
    parser.add_argument("--direct-only", action="store_true")
    parser.add_argument("--make-reference", type=float, metavar="SECONDS")
    options = parser.parse_args()

    if options.make_reference:
        passes, _, statistics = render(options, "uniform", 2**30, 99991, options.make_reference)
        np.savez(options.reference, image=passes["Combined"][..., :3], variance=passes["Variance"].reshape(passes["Combined"].shape[:2]))
        print(f"reference: {statistics['samples_per_pixel']['mean']:.0f} spp, estimated relMSE {statistics['estimated_error'][-1][2]:.2e}")
    stored = np.load(options.reference)
    reference = stored["image"]
    variance = np.repeat(stored["variance"][..., None], 3, axis=2) if "variance" in stored else None
    print(f"{Path(options.scene).stem} {options.integrator} {options.measure}, {reference.shape[1]} x {reference.shape[0]}, {options.seeds} seeds")
    print("| samples | T ratio | Err ratio | P-Eff gain | relMSE ratio | trimmed | gain at equal time | trimmed | range | estimate / true, uniform | adaptive |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for samples in options.spp:
        rows = []
        for seed in range(1, options.seeds + 1):
            row = []
            for image, count in (("uniform", options.against or samples), ("pmc_ip", samples)):
                passes, cpu, statistics = render(options, image, count, seed)
                picture = passes["Combined"][..., :3]
                relmse = metrics.relmse(picture, reference, variance)
                row.append((cpu, metrics.perceptual_error(picture, reference), relmse, metrics.relmse(picture, reference, variance, 0.001),
                            statistics["estimated_error"][-1][2] / relmse))
            rows.append(row)
        values = np.array(rows)
        ratios = values[:, 0, :4] / values[:, 1, :4]   # uniform over adaptive
        t, err, rel, trimmed = np.median(ratios, axis=0)
        gains = ratios[:, 0] * ratios[:, 2]
        print(f"| {samples} | {1 / t:.2f} | {1 / err:.3f} | {np.median(ratios[:, 0] * ratios[:, 1]):.2f} | {1 / rel:.3f} | {1 / trimmed:.3f} | "
              f"{np.median(gains):.2f} | {np.median(ratios[:, 0] * ratios[:, 3]):.2f} | {gains.min():.2f} to {gains.max():.2f} | "
              f"{np.median(values[:, 0, 4]):.2f} | {np.median(values[:, 1, 4]):.2f} |", flush=True)


if __name__ == "__main__":
    main()
