#!/usr/bin/python3
"""Compares PMC-IP with uniform sampling (thesis, table 5.1), measures the accuracy of estimated errors, and compares adaptive sampling of Cycles with
uniform sampling:

    PYTHONPATH=build/release/python benchmarks/thesis_image.py gains SCENE.ajar... [--spp 64] [--scale 0.2] [--seeds 4] [--integrator NAME]
    PYTHONPATH=build/release/python benchmarks/thesis_image.py estimates SCENE.ajar... --references DIR [--target 0.02] [--seconds 10]
    PYTHONPATH=build/release/python benchmarks/thesis_image.py cycles SCENE.blend... [--spp 64] [--percentage 20] [--seeds 2] [--blender blender]

SCENE.ajar comes from --ajar-dump-scene. One thread, methods in turn for each seed. T is the CPU time of rendering, since wall time depends on the
load of the machine.

gains: both samplings are unbiased, so that their error is the variance between seeds. It is weighted by the mean of all images: relMSE by 1 / (mean^2
+ 0.01), Err of the thesis by 1 / tvi(mean); P-Eff = 1 / (T Err). A gain is T times error of uniform sampling divided by that of PMC-IP. estimates:
renders until the estimated relMSE is below the target (or to a time limit), and divides the estimated error by the error against DIR/NAME.npz
(`image`, and the `variance` of its pixel means if it is known), which --make-references SECONDS renders. cycles: errors are those against the mean of
images of other seeds with 16 times the samples, and T is the CPU time between the log lines of the first and the last sample. Adaptive renders of up
to 8 times the samples, with a range of thresholds, are interpolated at the T of the uniform one. Means are relative to the reference, since in
adaptive sampling of Cycles the samples of a pixel influence their number, which causes a bias.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import tempfile
import time
from pathlib import Path

import metrics
import numpy as np

BASES = ("uniform", "pmc_ip")
CLOCK_TICKS = os.sysconf("SC_CLK_TCK")   # per second


def render(scene: str, options: argparse.Namespace, seed: int, **values) -> tuple[dict[str, np.ndarray], float, dict]:
    """Passes, CPU seconds of rendering, statistics."""
    import ajar

    description = ajar.load_description(scene)
    settings = description.settings
    settings.width, settings.height = int(settings.width * options.scale), int(settings.height * options.scale)
    settings.region = [0, 0, settings.width, settings.height]
    settings.integrator, settings.image_error, settings.vertex_merging = options.integrator, options.measure, "off"
    settings.samples, settings.seconds, settings.target_error = 0, 0.0, 0.0
    settings.seed, settings.threads, settings.passes = seed, 1, ["Combined", "Variance"]
    for name, value in values.items():
        setattr(settings, name, value)
    if options.direct_only:
        bounces = settings.bounces
        bounces.total = 0
        settings.bounces = bounces
    shape = (settings.height, settings.width, -1)
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
    passes = {name: np.asarray(session.snapshot(name), dtype=np.float64).reshape(shape) for name in ("Combined", "Variance")}
    return passes, cpu, json.loads(session.statistics_json())


def errors_between(pictures: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """relMSE, relMSE without the worst 0.1 % of pixels, and Err per pixel of one image, from the variance of several images."""
    relative = np.sort((pictures.var(axis=0, ddof=1) / (mean**2 + 0.01)).mean(axis=-1), axis=None)
    candelas = metrics.luminance(pictures) * metrics.CANDELAS_PER_UNIT
    seen = candelas.var(axis=0, ddof=1) / metrics.tvi(metrics.luminance(mean) * metrics.CANDELAS_PER_UNIT)
    return np.array([relative.mean(), relative[: int(0.999 * relative.size)].mean(), seen.mean()])


def print_gains(options: argparse.Namespace) -> None:
    print(f"{options.integrator}, {options.measure}, {options.spp} samples, scale {options.scale}, {options.seeds} seeds")
    print("| scene | T, uniform | T ratio | relMSE, uniform | relMSE ratio | trimmed | Err ratio | gain | trimmed | P-Eff gain | samples |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    gains = []
    for scene in options.scenes:
        pictures: dict[str, list] = {base: [] for base in BASES}
        ratios, counts, uniform_times = [], {}, []
        for seed in range(1, options.seeds + 1):
            times = {}
            for base in BASES:
                passes, times[base], statistics = render(scene, options, seed, image=base, samples=options.spp)
                pictures[base].append(passes["Combined"][..., :3])
                counts[base] = statistics["samples_per_pixel"]
            ratios.append(times["pmc_ip"] / times["uniform"])
            uniform_times.append(times["uniform"])
        mean = np.mean([picture for base in BASES for picture in pictures[base]], axis=0)
        uniform, adaptive = (errors_between(np.array(pictures[base]), mean) for base in BASES)
        t = float(np.median(ratios))
        ratio = adaptive / uniform
        gain = 1.0 / (ratio * t)
        gains.append(gain)
        least_most = f"{counts['pmc_ip']['min']} to {counts['pmc_ip']['max']}"
        print(f"| `{Path(scene).stem}` | {np.median(uniform_times):.2f} | {t:.2f} | {uniform[0]:.3g} | {ratio[0]:.3f} | {ratio[1]:.3f} | {ratio[2]:.3f} | {gain[0]:.2f} | {gain[1]:.2f} | "
              f"{gain[2]:.2f} | {least_most} |", flush=True)
    print("median gain, trimmed, P-Eff:", *(f"{value:.2f}" for value in np.median(gains, axis=0)), " minimum:", *(f"{value:.2f}" for value in np.min(gains, axis=0)))


def print_estimates(options: argparse.Namespace) -> None:
    print(f"{options.integrator}, {options.image}, until relMSE {options.target} or {options.seconds} s, scale {options.scale}, {options.seeds} seeds")
    print("| scene | samples | estimated | true | estimated / true, median | range |")
    print("|---|---|---|---|---|---|")
    for scene in options.scenes:
        path = options.references / f"{Path(scene).stem}.npz"
        if options.make_references:
            passes, _, statistics = render(scene, options, 99991, seconds=options.make_references)
            np.savez(path, image=passes["Combined"][..., :3], variance=passes["Variance"][..., 0])
            print(f"reference of {path.stem}: {statistics['samples_per_pixel']['mean']:.0f} samples", flush=True)
            continue
        stored = np.load(path)
        variance = np.repeat(stored["variance"][..., None], 3, axis=2) if "variance" in stored else None
        rows = []
        for seed in range(1, options.seeds + 1):
            passes, _, statistics = render(scene, options, seed, image=options.image, target_error=options.target, seconds=options.seconds)
            true = metrics.relmse(passes["Combined"][..., :3], stored["image"], variance)
            rows.append((statistics["samples_per_pixel"]["mean"], statistics["estimated_error"][-1][2], true))
        samples, estimated, true = np.array(rows).T
        ratios = estimated / true
        print(f"| `{path.stem}` | {np.median(samples):.0f} | {np.median(estimated):.3g} | {np.median(true):.3g} | {np.median(ratios):.2f} | "
              f"{ratios.min():.2f} to {ratios.max():.2f} |", flush=True)


def cycles(scene: str, options: argparse.Namespace, samples: int, *more: str, first_seed: int = 1) -> list[tuple[np.ndarray, float]]:
    """Images and CPU seconds of path tracing of each seed."""
    from images import read_exr

    with tempfile.TemporaryDirectory() as folder:
        command = [options.blender, "-b", "--factory-startup", scene, "--python", str(Path(__file__).with_name("cycles_render.py")), "--", "--out", folder, "--samples",
                   str(samples), "--seeds", ",".join(map(str, range(first_seed, first_seed + options.seeds))), "--percentage", str(options.percentage), "--threads", "1", *more]
        pictures, begun, seconds = [], 0.0, 0.0
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as blender:
            for line in blender.stdout or ():
                if "| Sample 0/" in line:
                    begun = cpu_seconds_of(blender.pid)
                elif line.rstrip().endswith("| Finished"):
                    seconds = max(cpu_seconds_of(blender.pid) - begun, 1.0 / CLOCK_TICKS)
                elif line.startswith("CYCLES "):
                    pictures.append((np.asarray(read_exr(json.loads(line.removeprefix("CYCLES "))["path"]), dtype=np.float64)[..., :3], seconds))
        if blender.returncode or len(pictures) < options.seeds:
            raise RuntimeError(f"Blender did not render {scene}")
        return pictures


def cpu_seconds_of(process: int) -> float:
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / CLOCK_TICKS


def print_cycles(options: argparse.Namespace) -> None:
    print(f"Cycles, {options.spp} samples, {options.percentage} %, {options.seeds} seeds")
    print("| scene | T | relMSE, uniform | mean | adaptive at equal T: gain | P-Eff gain | mean |")
    print("|---|---|---|---|---|---|---|")
    for scene in options.scenes:
        reference = np.mean([picture for picture, _ in cycles(scene, options, 16 * options.spp, first_seed=1001)], axis=0)

        def judged(pictures: list[tuple[np.ndarray, float]], reference: np.ndarray = reference) -> np.ndarray:
            return np.median([(cpu, metrics.relmse(picture, reference), metrics.perceptual_error(picture, reference), picture.mean() / reference.mean())
                              for picture, cpu in pictures], axis=0)
        uniform = judged(cycles(scene, options, options.spp))
        rows = np.array([judged(cycles(scene, options, 8 * options.spp, "--adaptive", "on", "--noise-threshold", str(threshold)))
                         for threshold in options.thresholds])
        rows = rows[np.argsort(rows[:, 0])]
        at_uniform = [float(np.exp(np.interp(np.log(uniform[0]), np.log(rows[:, 0]), np.log(rows[:, k])))) for k in (1, 2, 3)]
        outside = "" if rows[0, 0] <= uniform[0] <= rows[-1, 0] else " (outside)"
        print(f"| `{Path(scene).stem}` | {uniform[0]:.2f} | {uniform[1]:.3g} | {uniform[3]:.3f} | {uniform[1] / at_uniform[0]:.2f}{outside} | {uniform[2] / at_uniform[1]:.2f} | {at_uniform[2]:.3f} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    modes = parser.add_subparsers(dest="mode", required=True)
    for name, run in (("gains", print_gains), ("estimates", print_estimates), ("cycles", print_cycles)):
        mode = modes.add_parser(name)
        mode.set_defaults(run=run)
        mode.add_argument("scenes", nargs="+")
        mode.add_argument("--seeds", type=int, default=4)
        mode.add_argument("--spp", type=int, default=64)
        if name == "cycles":
            mode.add_argument("--blender", default="blender")
            mode.add_argument("--percentage", type=int, default=20)
            mode.add_argument("--thresholds", type=float, nargs="+", default=[2.0, 0.7, 0.2, 0.07])
            continue
        mode.add_argument("--scale", type=float, default=0.2)
        mode.add_argument("--integrator", default="path")
        mode.add_argument("--measure", default="relative", choices=["relative", "perceptual"])
        mode.add_argument("--direct-only", action="store_true")
        if name == "estimates":
            mode.add_argument("--references", type=Path, required=True)
            mode.add_argument("--make-references", type=float, metavar="SECONDS")
            mode.add_argument("--image", default="uniform", choices=BASES)
            mode.add_argument("--target", type=float, default=0.02)
            mode.add_argument("--seconds", type=float, default=10.0)
    options = parser.parse_args()
    options.run(options)


if __name__ == "__main__":
    main()
