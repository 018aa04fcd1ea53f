#!/usr/bin/python3
"""The comparisons of direct light of the thesis (tables 5.2 and 6.1) at equal samples, with efficiencies:

    PYTHONPATH=build/release/python benchmarks/thesis_direct.py SCENE.ajar --keep FILE --spp 12 --direct-samples 16 [--width 500]

SCENE.ajar comes from --ajar-dump-scene. Direct light only, one thread, methods in turn for each seed. Finished results are stored in FILE.json, the
reference in FILE.npz: the same command continues from there, and --budget SECONDS stops it before this time is over. T is the user CPU time from the
first sample, including pilots, without the build of the scene. Err is the mean of e^2 / tvi(L), so that ratios equal those of the sums in the thesis.
The reference is the mean of renders by `mis` with other seeds; its variance is subtracted from every squared error.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import metrics
import numpy as np
from in_process import direct_light

import ajar

METHODS = ("mis", "mis_balance", "bsdf", "light", "ris", "correlated", "pmc_hi_paper", "pmc_hi", "ocv_paper", "ocv", "ocv_progressive")


def render(options: argparse.Namespace, method: str, direct_samples: int, samples: int, seed: int) -> tuple[np.ndarray, float]:
    """Image and user CPU seconds of its samples."""
    description = ajar.load_description(options.scene)
    settings = description.settings
    settings.height = max(1, round(settings.height * options.width / settings.width))
    settings.width = options.width
    settings.region = [0, 0, options.width, settings.height]
    if options.one_place:
        settings.filter_width = 0.01
    return direct_light(description, method, direct_samples, samples, seed)


class Reference:
    """The mean of independent renders, and the variance of this mean, for colours and luminance."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.sums = dict(np.load(path)) if path.exists() else {}

    @property
    def pieces(self) -> int:
        return int(self.sums.get("pieces", 0))

    def add(self, image: np.ndarray) -> None:
        y = metrics.luminance(image)
        for name, value in (("sum", image), ("squares", image**2), ("y", y), ("y_squares", y**2), ("pieces", 1)):
            self.sums[name] = self.sums.get(name, 0) + value
        np.savez(self.path, **self.sums)

    def _variance(self, total: np.ndarray, squares: np.ndarray) -> np.ndarray:
        n = self.pieces
        return np.maximum(squares / n - (total / n) ** 2, 0.0) / (n - 1)

    def judge(self, image: np.ndarray) -> dict[str, float]:
        mean, variance = self.sums["sum"] / self.pieces, self._variance(self.sums["sum"], self.sums["squares"])
        true, y_variance = metrics.luminance(mean), self._variance(self.sums["y"], self.sums["y_squares"])
        threshold = metrics.tvi(true * metrics.CANDELAS_PER_UNIT) / metrics.CANDELAS_PER_UNIT
        squared = (metrics.luminance(image) - true) ** 2 - y_variance
        return {"err": float((squared / threshold).mean()), "rms": float(np.sqrt(max((squared / threshold**2).mean(), 0.0))),
                "relmse": metrics.relmse(image, mean, variance), "trimmed": metrics.relmse(image, mean, variance, 0.001),
                "mean": float(image.mean() / mean.mean() - 1.0), "reference": float((variance / (mean**2 + 0.01)).mean())}


def table(options: argparse.Namespace, done: dict[str, dict]) -> None:
    def column(method: str, name: str) -> np.ndarray:
        return np.array([done[f"{method} {seed}"][name] for seed in range(1, options.seeds + 1) if f"{method} {seed}" in done])

    names = ("seconds", "err", "rms", "relmse", "trimmed", "mean", "reference")
    seeds = len(column("mis", "err"))
    if not seeds:
        return
    base = {name: np.median(column("mis", name)) for name in names}
    print(f"{Path(options.scene).stem}: {options.width} pixels wide, {options.spp} spp x {options.direct_samples} direct samples, {seeds} seeds; "
          f"relMSE of `mis` {base['relmse']:.3g}, of the reference {base['reference']:.2g}, subtracted")
    print("| method | T (s) | Err / MIS | spread | P-Eff / MIS | RMS(e/tvi) / MIS | relMSE / MIS | trimmed | mean |")
    print("|---|---|---|---|---|---|---|---|---|")
    for method in options.methods:
        if len(column(method, "err")) < seeds:
            continue
        m = {name: np.median(column(method, name)) for name in names}
        ratios = column(method, "err") / column("mis", "err")
        print(f"| `{method}` | {m['seconds']:.1f} | {m['err'] / base['err']:.3f} | {ratios.min():.2f} to {ratios.max():.2f} | "
              f"{base['seconds'] * base['err'] / (m['seconds'] * m['err']):.2f} | {m['rms'] / base['rms']:.3f} | {m['relmse'] / base['relmse']:.3f} | "
              f"{m['trimmed'] / base['trimmed']:.3f} | {100 * m['mean']:+.2f} % |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--keep", type=Path, required=True)
    parser.add_argument("--spp", type=int, default=12)
    parser.add_argument("--direct-samples", type=int, default=16)
    parser.add_argument("--width", type=int, default=160)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--methods", nargs="+", default=METHODS)
    parser.add_argument("--reference-spp", type=int, default=128, help="samples of each render of the reference")
    parser.add_argument("--reference-pieces", type=int, default=8)
    parser.add_argument("--one-place", action="store_true", help="all samples of a pixel at its centre: the error of estimates without that of edges")
    parser.add_argument("--budget", type=float, default=float("inf"))
    options = parser.parse_args()

    start, longest = time.monotonic(), 0.0
    keep, reference = options.keep.with_suffix(".json"), Reference(options.keep.with_suffix(".npz"))
    done: dict[str, dict] = json.loads(keep.read_text()) if keep.exists() else {}
    jobs = [("reference", piece) for piece in range(reference.pieces, options.reference_pieces)]
    jobs += [(method, seed) for seed in range(1, options.seeds + 1) for method in options.methods if f"{method} {seed}" not in done]
    for method, number in jobs:
        begun = time.monotonic()
        if begun + longest - start > options.budget:
            print(f"{len(jobs)} jobs were left")
            return
        if method == "reference":
            reference.add(render(options, "mis", 1, options.reference_spp, 10_000 + number)[0])
        else:
            image, seconds = render(options, method, options.direct_samples, options.spp, number)
            done[f"{method} {number}"] = {"seconds": seconds, **reference.judge(image)}
            keep.write_text(json.dumps(done, indent=0))
        longest = max(longest, time.monotonic() - begun)
    table(options, done)


if __name__ == "__main__":
    main()
