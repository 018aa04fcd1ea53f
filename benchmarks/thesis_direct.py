#!/usr/bin/python3
"""The thesis's comparisons of direct light (tables 5.2 and 6.1), at equal samples, with efficiencies:

    PYTHONPATH=build/release/python benchmarks/thesis_direct.py SCENE.ajar --spp 12 --direct-samples 16 [--width 160] [--seeds 5]

SCENE.ajar comes from --ajar-dump-scene. Direct light only, one thread, methods interleaved seed by seed; T is the process's own
CPU time, since a shared machine's wall time says little. Err is the mean of e^2 / tvi(L), so ratios equal those of the thesis's sums. The reference
is `mis` with many samples; its own noise is taken off relMSE by its variance.
"""

from __future__ import annotations

import argparse
import time

import metrics
import numpy as np

import ajar

METHODS = ("mis", "mis_balance", "bsdf", "light", "ris", "correlated", "pmc_hi_paper", "pmc_hi", "ocv_paper", "ocv", "ocv_progressive")


def render(path: str, width: int, method: str, direct_samples: int, samples: int, seed: int) -> tuple[np.ndarray, float]:
    """Image and CPU seconds of building and rendering."""
    description = ajar.load_description(path)
    settings = description.settings
    settings.height = max(1, round(settings.height * width / settings.width))
    settings.width, height = width, settings.height
    settings.region = [0, 0, width, height]
    bounces = settings.bounces
    bounces.total = 0
    settings.bounces = bounces
    settings.direct, settings.direct_samples, settings.samples, settings.seconds = method, direct_samples, samples, 0.0
    settings.target_error, settings.seed, settings.threads, settings.passes = 0.0, seed, 1, ["Combined"]
    session = ajar.Session()
    start = time.process_time()
    session.start(description)
    while not session.wait(0.05):
        pass
    seconds = time.process_time() - start
    if error := session.take_error():
        raise RuntimeError(error)
    return np.asarray(session.snapshot("Combined")).reshape(height, width, 4)[..., :3].astype(np.float64), seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--spp", type=int, default=12)
    parser.add_argument("--direct-samples", type=int, default=16)
    parser.add_argument("--width", type=int, default=160)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--reference-spp", type=int, default=1024)
    options = parser.parse_args()

    halves = [render(options.scene, options.width, "mis", 1, options.reference_spp // 2, 10_000 + i)[0] for i in range(2)]
    reference, variance = (halves[0] + halves[1]) / 2, (halves[0] - halves[1]) ** 2 / 4
    true = metrics.luminance(reference)
    threshold = metrics.tvi(true * metrics.CANDELAS_PER_UNIT) / metrics.CANDELAS_PER_UNIT
    rows: dict[str, list[tuple[float, float, float, float, float]]] = {method: [] for method in METHODS}
    for seed in range(1, options.seeds + 1):
        for method in METHODS:
            image, seconds = render(options.scene, options.width, method, options.direct_samples, options.spp, seed)
            error = metrics.luminance(image) - true
            rows[method].append((seconds, float((error**2 / threshold).mean()), float(np.sqrt(((error / threshold) ** 2).mean())),
                                 metrics.relmse(image, reference, variance, 0.001), float(image.mean() / reference.mean() - 1.0)))
    base = np.median(rows["mis"], axis=0)
    print(f"{options.scene}: {options.width} pixels wide, {options.spp} spp x {options.direct_samples} direct samples, {options.seeds} seeds")
    print("| method | T (s) | Err / MIS | spread | P-Eff / MIS | RMS(e/tvi) / MIS | relMSE (trimmed) / MIS | mean |")
    print("|---|---|---|---|---|---|---|---|")
    for method in METHODS:
        values = np.array(rows[method])
        t, err, rms, relmse, mean = np.median(values, axis=0)
        ratios = values[:, 1] / np.array(rows["mis"])[:, 1]
        print(f"| {method} | {t:.2f} | {err / base[1]:.3f} | {ratios.min():.2f} to {ratios.max():.2f} | {base[0] * base[1] / (t * err):.2f} | "
              f"{rms / base[2]:.3f} | {relmse / base[3]:.3f} | {100 * mean:+.2f} % |")


if __name__ == "__main__":
    main()
