#!/usr/bin/python3
"""Compares Ajar's methods of direct light with Cycles at equal error:

    PYTHONPATH=build/release/python benchmarks/direct_against_cycles.py [--wheel PYTHON] [--seeds 5] [--percentage 20] [--budget SECONDS]

The scenes are `checker` and soft shadows of one large unoccluded area light (direct_scenes.py). One thread. T is CPU time; for Cycles, the time of a
render of one sample is subtracted, which is nearly only preparation. Errors of a program are relative to its own reference (other seeds), whose
variance is subtracted. The result is the time of Cycles divided by that of Ajar at equal relMSE: the geometric mean over the errors that both curves
reach, for each seed, then the median; also at the minimum error of Cycles. Finished jobs are stored in build/direct_against_cycles: the same command
continues from there, and --budget stops it before this time is over.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import agreement
import metrics
import numpy as np
import renderers
from images import read_exr
from in_process import direct_light

import ajar

WORK = renderers.PROJECT / "build" / "direct_against_cycles"
# Method, direct samples, samples per pixel.
PLAIN, COUNTS = ("mis", 1, (4, 16, 64, 256)), (2, 8, 32, 128)
OURS = {"soft_shadows": {"mis": PLAIN, "light, 4 direct samples": ("light", 4, COUNTS), "pmc_hi, 4 direct samples": ("pmc_hi", 4, COUNTS)},
        "checker": {"mis": PLAIN, "pmc_hi, 4 direct samples": ("pmc_hi", 4, COUNTS), "ocv_progressive, 4 direct samples": ("ocv_progressive", 4, COUNTS)}}
THEIRS = (4, 16, 64, 256)
REFERENCE_SAMPLES, REFERENCE_SEEDS = 512, (101, 102, 103, 104)


def our_image(scene: Path, method: str, direct_samples: int, samples: int, seed: int) -> tuple[np.ndarray, float]:
    """Image and user CPU seconds of its samples."""
    return direct_light(ajar.load_description(str(scene)), method, direct_samples, samples, seed)


def cycles_images(blend: Path, out: Path, percentage: int, samples: list[int], seeds: list[int], python: str | None) -> dict[tuple[int, int], tuple[np.ndarray, float]]:
    """Image and CPU seconds of the whole render, by samples and seed."""
    script = [str(Path(__file__).with_name("cycles_render.py")), "--", "--out", str(out), "--samples", ",".join(map(str, samples)), "--seeds", ",".join(map(str, seeds)),
              "--percentage", str(percentage), "--threads", "1"]
    command = [python, *script, "--blend", str(blend)] if python else [renderers.BLENDER, "-b", "--factory-startup", str(blend), "--python", *script]
    log = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    records = [json.loads(line.removeprefix("CYCLES ")) for line in log.splitlines() if line.startswith("CYCLES ")]
    return {(record["samples"], record["seed"]): (read_exr(record["path"]).astype(np.float64)[..., :3], record["cpu_seconds"]) for record in records}


class Measured:
    """The runs of one scene: a reference for each program, and seconds and error by samples and seed."""

    def __init__(self, name: str, options: argparse.Namespace) -> None:
        self.name, self.options, self.folder = name, options, WORK / name
        self.folder.mkdir(parents=True, exist_ok=True)
        self.path = self.folder / "runs.json"
        self.runs: dict[str, list] = json.loads(self.path.read_text()) if self.path.exists() else {}

    def _reference(self, program: str) -> Path:
        return self.folder / f"{program}.npz"

    def _keep(self, key: str, program: str, pictures: dict[tuple[int, int], tuple[np.ndarray, float]], preparing: float = 0.0) -> None:
        reference = np.load(self._reference(program))
        self.runs[key] = [[samples, seed, seconds - preparing, metrics.relmse(image, reference["mean"], reference["variance"])]
                          for (samples, seed), (image, seconds) in pictures.items()]
        self.path.write_text(json.dumps(self.runs))

    def jobs(self) -> list[tuple[str, Callable[[], None]]]:
        """The jobs that are not finished."""
        options, seeds = self.options, list(range(1, self.options.seeds + 1))
        blend, scene = WORK / f"{self.name}.blend", self.folder / "scene.ajar"
        left: list[tuple[str, Callable[[], None]]] = []

        def reference(program: str, pictures: list[np.ndarray]) -> None:
            mean, variance = agreement.mean_and_variance(pictures)
            np.savez(self._reference(program), mean=mean, variance=variance)

        def ours(key: str, method: str, direct_samples: int, counts: Sequence[int]) -> None:
            self._keep(key, "Ajar", {(samples, seed): our_image(scene, method, direct_samples, samples, seed) for seed in seeds for samples in counts})

        for program, python in [("Cycles", None)] + ([("Cycles wheel", options.wheel)] if options.wheel else []):
            def refer(program: str = program, python: str | None = python) -> None:
                reference(program, [image for image, _ in cycles_images(blend, self.folder / "reference", options.percentage, [REFERENCE_SAMPLES], list(REFERENCE_SEEDS), python).values()])

            def measure(program: str = program, python: str | None = python) -> None:
                pictures = cycles_images(blend, self.folder / "cycles", options.percentage, [1, *THEIRS], seeds, python)
                preparing = float(np.median([seconds for (samples, _), (_, seconds) in pictures.items() if samples == 1]))
                self._keep(program, program, {key: value for key, value in pictures.items() if key[0] > 1}, preparing)
            if not self._reference(program).exists():
                left.append((f"{self.name}: reference of {program}", refer))
            if program not in self.runs:
                left.append((f"{self.name}: {program}", measure))
        if not self._reference("Ajar").exists():
            left.append((f"{self.name}: reference of Ajar", lambda: reference("Ajar", [our_image(scene, "mis", 1, REFERENCE_SAMPLES, seed)[0] for seed in REFERENCE_SEEDS])))
        for key, (method, direct_samples, counts) in OURS[self.name].items():
            if key not in self.runs:
                left.append((f"{self.name}: {key}", partial(ours, key, method, direct_samples, counts)))
        return left

    def curve(self, key: str, seed: int) -> metrics.ErrorCurve:
        points = [(seconds, error) for _, s, seconds, error in self.runs[key] if s == seed and seconds > 0 and error > 0]
        return metrics.ErrorCurve(*zip(*points))

    def faster_at(self, key: str, program: str, samples: int) -> float:
        """The ratio of times at the error of `program` with this number of samples, by curves through medians over seeds; nan if Ajar does not reach this error."""
        points = [(float(np.median([run[2] for run in self.runs[key] if run[0] == s])), float(np.median([run[3] for run in self.runs[key] if run[0] == s])))
                  for s in sorted({run[0] for run in self.runs[key]})]
        theirs = [run for run in self.runs[program] if run[0] == samples]
        seconds, error = (float(np.median([run[k] for run in theirs])) for k in (2, 3))
        return seconds / metrics.ErrorCurve(*zip(*points)).time_to(error)

    def table(self) -> None:
        means = {program: float(np.load(self._reference(program))["mean"].mean()) for program in ("Ajar", *(p for p in ("Cycles", "Cycles wheel") if p in self.runs))}
        size = np.load(self._reference("Ajar"))["mean"].shape
        print(f"\n`{self.name}`, {size[1]} x {size[0]}; mean of Ajar's reference over that of " + ", ".join(f"{program} {means['Ajar'] / mean:.4f}" for program, mean in means.items() if program != "Ajar"))
        programs = [program for program in means if program != "Ajar"]
        print("| | T (s), relMSE | " + " | ".join(f"faster than {program} | at its error with {THEIRS[-1]} samples" for program in programs) + " |")
        print("|---|---|" + "---|---|" * len(programs))
        for key, runs in self.runs.items():
            points = [tuple(float(np.median([run[k] for run in runs if run[0] == samples])) for k in (2, 3)) for samples in sorted({run[0] for run in runs})]
            row = "; ".join(f"{seconds:.2f}, {error:.2g}" for seconds, error in points)
            cells = []
            for program in programs:
                faster = [metrics.equal_error_speedup(self.curve(key, seed), self.curve(program, seed)) for seed in range(1, self.options.seeds + 1)]
                cells.append(f"{np.median(faster):.2f} ({min(faster):.2f} to {max(faster):.2f}) | {self.faster_at(key, program, THEIRS[-1]):.2f}")
            print(f"| {key} | {row} | " + " | ".join(cells) + " |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--wheel", help="a Python with the bpy wheel of a newer Blender, as another competitor")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--percentage", type=int, default=20, help="of the scenes' size")
    parser.add_argument("--budget", type=float, default=float("inf"))
    options = parser.parse_args()
    start, longest = time.monotonic(), 0.0
    if not all((WORK / name / "scene.ajar").exists() for name in OURS):
        renderers.run([renderers.BLENDER, "-b", "--factory-startup", "--python-exit-code", "1", "--python", str(Path(__file__).with_name("direct_scenes.py")), "--", str(WORK)], "scenes")
        for name in OURS:
            renderers.AjarBuild.default().dump(WORK / f"{name}.blend", WORK / name, options.percentage)
    measured = [Measured(name, options) for name in OURS]
    jobs = sorted([job for scene in measured for job in scene.jobs()], key=lambda job: "wheel" in job[0])
    for index, (name, job) in enumerate(jobs):
        begun = time.monotonic()
        if begun + longest - start > options.budget:
            print(f"{len(jobs) - index} of the jobs are left")
            return
        job()
        longest = max(longest, time.monotonic() - begun)
        print(f"{name}: {time.monotonic() - begun:.0f} s", flush=True)
    for scene in measured:
        scene.table()


if __name__ == "__main__":
    main()
