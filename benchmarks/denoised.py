#!/usr/bin/python3
"""Compares the denoised pictures of Ajar and Cycles at equal CPU time, denoising included:

    benchmarks/denoised.py [SCENE ...] [--seconds 10] [--factors 1,4,16] [--techniques auto,path,...] [--repeats 1] --wheel PYTHON

Cycles is that of a bpy wheel with its own denoiser (albedo, normal, accurate prefilter, high quality), without clamping: plain, with path guiding, and
with adaptive sampling; the best of the three counts. Ajar denoises with the library of the extension (`make extension`) or AJAR_DENOISER. Both use two threads. T is CPU
seconds of rendering and denoising, without export and build.

A reference is the mean of independent renders by the technique that is best for the scene. The variance of that mean is subtracted from every error.
References are stored in build/denoised and rendered again when the .blend changes. Earlier results of other scenes,
times and techniques are kept. Writes docs/benchmarks/denoised.md and build/denoised/results.json.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import os
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import agreement
import images
import machine
import metrics
import numpy as np
import renderers
from scenes import PROJECT, Scene, find_scenes

# The technique of a reference: the one that converges fastest. Vertex merging is on where it has caustics in mirrors.
REFERENCES = {"kitchen": "bdpt", "attic": "bdpt", "room": "erpt", "rooms": "erpt", "lantern": "erpt", "bar": "erpt", "keyhole": "erpt", "box": "bdpt"}
REPLICATES = 10
TRIALS = 4          # of a render that got another CPU time than it should
ENOUGH = 0.93       # of the CPU time
CHOICE = "Choosing a technique"   # the step after the build
ENDLESS = 1 << 20   # samples; the time stops the render
DENOISER = PROJECT / "build" / "extension" / "package" / "ajar" / "lib" / "libajar_OpenImageDenoise.so"
CYCLES = {"Cycles": {}, "Cycles, guided": {"guiding": True}, "Cycles, adaptive": {"adaptive": True}}
MOST_SAMPLES = 32   # of a render with adaptive sampling, over those without it


@dataclass(frozen=True)
class Reference:
    mean: np.ndarray
    variance: np.ndarray   # of the mean

    @property
    def noise(self) -> float:
        return float((self.variance / (self.mean**2 + 0.01)).mean())


@dataclass
class Picture:
    """The same render before and after denoising."""

    noisy: np.ndarray | None
    denoised: np.ndarray
    cpu: float
    samples: float
    technique: str


def cpu_seconds() -> float:
    used = os.times()
    return used.user + used.system


@dataclass
class Load:
    """The number of processors that this process gets for its threads. Other work of the machine makes it smaller."""

    threads: int
    processors: float = 0.0

    def __post_init__(self) -> None:
        self.processors = self.processors or self.threads


Change = Callable[[Any], None]   # of the ajar.SceneDescription before a render


def render(scene_file: Path, integrator: str, cpu: float, seed: int, load: Load, denoised: bool = True,
           change: Change | None = None) -> tuple[dict[str, np.ndarray], dict, float]:
    """Passes (top row first), statistics and CPU seconds of a render in this process. It ends after `cpu` CPU seconds, the choice of a technique included.

    The engine is told the wall time that this takes at the present load, because techniques plan by it.
    """
    import ajar

    description = ajar.load_description(str(scene_file))
    settings = description.settings
    settings.integrator, settings.samples, settings.seconds, settings.target_error = integrator, ENDLESS, cpu / load.processors, 0.0
    settings.seed, settings.threads, settings.denoised = seed, load.threads, denoised
    passes = ["Combined", "Halves", "Direct Halves", "Denoising Albedo", "Denoising Normal"] if denoised else ["Combined"]
    settings.passes = passes
    if change:
        change(description)
    session = ajar.Session()
    session.start(description)
    started, clock = cpu_seconds(), time.monotonic()
    while not session.wait(0.01):
        progress = session.progress()
        if progress.phase == ajar.Progress.Phase.Building and progress.step != CHOICE:
            started, clock = cpu_seconds(), time.monotonic()
        elif cpu_seconds() - started > cpu and progress.samples >= 1.0:   # a time limit does not cut the first pass either
            session.cancel()
    used = cpu_seconds() - started
    load.processors = min(load.threads, max(0.1 * load.threads, used / max(1e-3, time.monotonic() - clock)))
    if error := session.take_error():
        raise renderers.RenderFailed(error)
    return {name: np.asarray(session.snapshot(name))[::-1].copy() for name in passes}, json.loads(session.statistics_json()), used


def whole_render(scene_file: Path, integrator: str, cpu: float, seed: int, load: Load, denoised: bool = True,
                 change: Change | None = None) -> tuple[dict[str, np.ndarray], dict, float]:
    """As `render`. Repeats a render whose time limit came before its CPU time was used, because other work of the machine began meanwhile."""
    for _ in range(TRIALS):
        found, stats, used = render(scene_file, integrator, cpu, seed, load, denoised, change)
        if used > ENOUGH * cpu:
            break
    else:
        print(f"{scene_file}: {integrator} used only {used:.1f} of {cpu:.1f} CPU seconds.", file=sys.stderr)
    return found, stats, used


def denoise(found: dict[str, np.ndarray], rays: float, threads: int, combined: bool = True, biased: Sequence[bool] = ()) -> tuple[np.ndarray, float]:
    """The denoised picture and its CPU seconds. `biased`: of each technique that has rendered it. `combined`: of the denoiser's picture and the rendered one, as artists get it."""
    import ajar

    started = cpu_seconds()
    noisy = found["Combined"]
    quality = ajar.denoiser.quality_for(rays, ajar.denoiser.pixels_of(found["Halves"], noisy))
    image, _ = ajar.denoise(noisy, found["Halves"] if combined else None, found["Denoising Albedo"], found["Denoising Normal"], quality, threads,
                            direct_halves=found.get("Direct Halves") if combined else None, biased=list(biased))
    return image[..., :3].astype(np.float64), cpu_seconds() - started


def ajar_picture(scene_file: Path, integrator: str, cpu: float, seed: int, load: Load, denoising: float, change: Change | None = None) -> Picture:
    import ajar

    found, stats, used = whole_render(scene_file, integrator, max(0.1, cpu - denoising), seed, load, change=change)
    image, extra = denoise(found, stats["rays"], load.threads, biased=ajar.denoiser.biased_of(stats))
    technique = ", ".join(part["integrator"] for part in stats.get("techniques", [stats]))
    return Picture(found["Combined"][..., :3].astype(np.float64), image, used + extra, stats["samples_per_pixel"]["mean"], technique)


def denoising_seconds(scene_file: Path, load: Load, cpu: float) -> float:
    """CPU seconds that denoising takes after a render of `cpu` CPU seconds."""
    import ajar

    warm, _, _ = render(scene_file, "path", 1.0, 1, load)
    return min(denoise(warm, cpu / ajar.denoiser.SECONDS_PER_RAY, load.threads)[1] for _ in range(2))


def load_denoiser() -> bool:
    """Load AJAR_DENOISER, or the library of the extension. Says why if it is not there."""
    import ajar

    os.environ.setdefault(ajar.denoiser.VARIABLE, str(DENOISER))
    if ajar.denoiser.load():
        return True
    print(f"{ajar.denoiser.reason()}. `make extension` makes {DENOISER}.", file=sys.stderr)
    return False


class CyclesRenders:
    """Cycles of a wheel at given CPU times, without its preparation: the number of samples follows from short trials, and from the time of a first render.
    `options`: `guiding`, `adaptive` of render_cycles."""

    def __init__(self, scene: Scene, folder: Path, wheel: str, threads: int, options: dict[str, bool]) -> None:
        self.scene, self.folder, self.wheel, self.threads, self.options = scene, folder, wheel, threads, options
        few, some = (self._render(samples, 99) for samples in (1, 33))
        clean = renderers.render_cycles(scene.path, folder, [1], [99], threads, scene.percentage, python=wheel, **options)[0]
        self.per_sample = max(1e-4, (some.statistics["cpu_seconds"] - few.statistics["cpu_seconds"]) / 32)
        self.denoising = max(0.0, few.statistics["cpu_seconds"] - clean.statistics["cpu_seconds"])
        self.preparing = max(0.0, clean.statistics["cpu_seconds"] - self.per_sample)

    def _render(self, samples: int, seed: int) -> renderers.Render:
        return renderers.render_cycles(self.scene.path, self.folder, [samples], [seed], self.threads, self.scene.percentage, python=self.wheel,
                                       denoise=True, **self.options)[0]

    def reference(self, cpu: float) -> Reference:
        """Two renders without denoising, kept until the .blend changes."""
        def replicates() -> list[np.ndarray]:
            samples = max(1, round(0.5 * cpu / self.per_sample))
            return [done.image().astype(np.float64) for done in
                    renderers.render_cycles(self.scene.path, self.folder / "reference", [samples], [5, 6], self.threads, self.scene.percentage,
                                            python=self.wheel, **self.options)]
        return kept_reference(self.folder / "reference.npz", f"{file_key(self.scene)}, {self.wheel}", cpu, replicates)

    def picture(self, cpu: float, seed: int) -> Picture:
        expected = samples = max(1, round((cpu - self.denoising) / self.per_sample))
        done = self._render(samples, seed)
        # With adaptive sampling, pixels stop at Blender's default threshold: more samples take little more time.
        for _ in range(TRIALS):
            used = done.statistics["cpu_seconds"] - self.preparing
            factor = min(4.0, (cpu - self.denoising) / max(0.01, used - self.denoising))
            wanted = min(MOST_SAMPLES * expected, max(1, round(samples * factor)))
            if ENOUGH * cpu <= used <= cpu / ENOUGH or wanted == samples:
                break
            samples = wanted
            done = self._render(samples, seed)
        return Picture(None, done.image().astype(np.float64), done.statistics["cpu_seconds"] - self.preparing, samples, "Cycles")


def file_key(scene: Scene) -> str:
    return f"{hashlib.sha256(scene.path.read_bytes()).hexdigest()} at {scene.percentage} %"


def kept_reference(file: Path, key: str, seconds: float, replicates: Callable[[], list[np.ndarray]]) -> Reference:
    """The reference in the file if that has the key and took at least these seconds; else the mean of replicates, which is stored there."""
    if file.exists():
        data = np.load(file)
        if str(data["key"]) == key and float(data["seconds"]) >= seconds:
            return Reference(data["mean"].astype(np.float64), data["variance"].astype(np.float64))
    mean, variance = agreement.mean_and_variance(replicates())
    np.savez_compressed(file, mean=mean.astype(np.float32), variance=variance.astype(np.float32), key=key, seconds=seconds)
    return Reference(mean, variance)


def reference_of(scene: Scene, scene_file: Path, options: argparse.Namespace) -> Reference:
    seconds, threads = options.reference_seconds, options.threads
    exporter = f", exported by {options.wheel}" if options.extension else ""
    integrator = REFERENCES.get(scene.name, "path")
    load = Load(threads)

    def replicates() -> list[np.ndarray]:
        return [whole_render(scene_file, integrator, seconds * threads / REPLICATES, 5000 + i, load, denoised=False)[0]["Combined"][..., :3]
                for i in range(REPLICATES)]
    return kept_reference(scene_file.parent / "reference.npz", file_key(scene) + exporter, seconds, replicates)


def measures(image: np.ndarray, reference: Reference) -> dict[str, float]:
    """relMSE, structural similarity, energy of the whole picture, and the worst relative error of its sixteenths."""
    ours, true = metrics.luminance(image), metrics.luminance(reference.mean)
    parts = [(a.mean(), b.mean()) for rows in zip(np.array_split(ours, 4), np.array_split(true, 4), strict=True)
             for a, b in zip(np.array_split(rows[0], 4, axis=1), np.array_split(rows[1], 4, axis=1), strict=True)]
    return {"relmse": metrics.relmse(image, reference.mean, reference.variance), "ssim": metrics.structural_similarity(image, reference.mean),
            "energy": float(ours.mean() / true.mean()), "worst_part": float(max(abs(a - b) / max(b, 1e-4) for a, b in parts)),
            "worst_block": metrics.worst_block(image, reference.mean)}


def measure_scene(scene: Scene, ajar_build: renderers.AjarBuild, work: Path, options: argparse.Namespace) -> dict:
    folder = work / scene.name
    if options.extension:
        scene_file = renderers.export_by_wheel(scene.path, folder, options.wheel, options.extension, scene.percentage)
    else:
        scene_file, _ = ajar_build.dump(scene.path, folder, scene.percentage)
    reference = reference_of(scene, scene_file, options)
    load = Load(options.threads)
    rivals = {name: CyclesRenders(scene, folder / name.replace(", ", "_"), options.wheel, options.threads, flags) for name, flags in CYCLES.items()}
    own = rivals["Cycles"].reference(2.0 * options.reference_seconds) if scene.name not in REFERENCES else reference
    runs = []
    for factor in options.factors:
        cpu = options.seconds * factor
        denoised: dict[str, list[np.ndarray]] = {}
        denoising = denoising_seconds(scene_file, load, cpu)
        for seed in range(1, options.repeats + 1):
            pictures = {name: rival.picture(cpu, seed) for name, rival in rivals.items()}
            for name in options.techniques:
                pictures[name] = ajar_picture(scene_file, name, cpu, seed, load, denoising)
            for name, picture in pictures.items():
                run = {"name": name, "factor": factor, "seed": seed, "cpu": picture.cpu, "samples": picture.samples, "technique": picture.technique,
                       **measures(picture.denoised, own if name in rivals else reference)}
                if picture.noisy is not None:
                    run["noisy"] = metrics.relmse(picture.noisy, reference.mean, reference.variance)
                runs.append(run)
                denoised.setdefault(name, []).append(picture.denoised)
                print(f"{scene.name} {factor}T {name}: {run['cpu']:.1f} s, relMSE {run['relmse']:.3g}, noisy {run.get('noisy', float('nan')):.3g}, "
                      f"energy {run['energy']:.3f}, worst part {run['worst_part']:.3f}, {run['technique']}", flush=True)
        if options.repeats > 1:
            for run in runs:
                if run["factor"] == factor:
                    run["flicker"] = float((np.var(denoised[run["name"]], axis=0, ddof=1) / (reference.mean**2 + 0.01)).mean())
        write_sheet(folder / f"{factor}T.png", reference, pictures)
    return {"scene": scene.name, "width": reference.mean.shape[1], "height": reference.mean.shape[0], "reference_noise": reference.noise,
            "denoising_seconds": denoising, "runs": runs}


def write_sheet(path: Path, reference: Reference, pictures: dict[str, Picture]) -> None:
    """The reference, then the denoised pictures."""
    panels = [reference.mean, *(picture.denoised for picture in pictures.values())]
    panels += [np.ones_like(reference.mean)] * (-len(panels) % 3)
    rows = [np.concatenate(panels[i:i + 3], axis=1) for i in range(0, len(panels), 3)]
    images.write_png(path, images.srgb_bytes(np.concatenate(rows)))


def median(found: dict, name: str, factor: int, key: str) -> float:
    values = [run[key] for run in found["runs"] if run["name"] == name and run["factor"] == factor and key in run]
    return statistics.median(values) if values else float("nan")


def best_cycles(found: dict, factor: int) -> float:
    errors = [median(found, name, factor, "relmse") for name in CYCLES]
    return min((error for error in errors if not math.isnan(error)), default=float("nan"))


def merged(known: list[dict], new: dict) -> list[dict]:
    """The scenes with the runs of `new`, which replace those of the same renderer and time."""
    measured = {(run["name"], run["factor"]) for run in new["runs"]}
    before = [run for found in known if found["scene"] == new["scene"] for run in found["runs"] if (run["name"], run["factor"]) not in measured]
    return [found for found in known if found["scene"] != new["scene"]] + [new | {"runs": before + new["runs"]}]


def page(results: dict) -> str:
    factors = sorted({run["factor"] for found in results["scenes"] for run in found["runs"]})
    seeds = max(run["seed"] for found in results["scenes"] for run in found["runs"])
    lines = ["# Denoised pictures at equal CPU time", "",
             "The relMSE of Cycles over that of Ajar's `auto`, both denoised. More than 1: Ajar has the smaller error.", "",
             "| scene | " + " | ".join(f"{factor}T" for factor in factors) + " |", "|---" * (len(factors) + 1) + "|"]
    for found in results["scenes"]:
        ratios = [best_cycles(found, factor) / median(found, "auto", factor, "relmse") for factor in factors]
        lines.append(f"| {found['scene']} | " + " | ".join("–" if math.isnan(ratio) else f"{ratio:.2f}" for ratio in ratios) + " |")
    lines += ["", "## Method", "",
              f"`benchmarks/denoised.py` writes this page; do not edit it. T is {results['seconds']:g} CPU seconds for rendering and denoising, without export and "
              f"build, on {results['machine']['threads']} threads; {seeds} seeds at most, medians. Cycles is that of the bpy wheel with its own denoiser "
              "(albedo, normal, accurate prefilter, high quality), without clamping; the best of plain, guided and adaptive (Blender's default threshold, its limit of samples raised until the time is used) counts. Errors are relMSE, "
              "mean((I−R)²/(R²+0.01)), from which the variance of the reference is subtracted. "
              + ("The wheel exports the scenes, so that both engines have the materials of its Blender. " if results["exported_by_wheel"] else
                 "Blender 3.4 exports the scenes. Newer versions of Cycles shade some materials differently. ")
              + "Cycles has its own reference (not denoised) in scenes where it converges: all but the hard ones. A render ends by its CPU time, so that other work of the "
              "machine does not shorten it. Cycles is rendered again with another number of samples, up to four times, until its *CPU s* differ from T by at most 7 %. *noisy* is the error before denoising. *energy* is the mean of "
              "the picture over that of the reference, *worst part* the largest relative error of the mean of a sixteenth of the picture, *worst block* that of "
              "the relMSE of a block of 16 × 16 pixels. *flicker* is the variance of a pixel over the seeds, relative as the error: that of the frames of an animation "
              "without movement. *SSIM* is the structural similarity of the sRGB luminance.", "", "## Machine", ""]
    lines += [f"* {key}: {value}" for key, value in results["machine"].items()]
    for found in results["scenes"]:
        lines += ["", f"## {found['scene']}", "",
                  f"{found['width']}×{found['height']}. The reference's own relMSE is {found['reference_noise']:.2g}. Ajar's denoising took "
                  f"{found['denoising_seconds']:.2f} CPU seconds.", "",
                  "| time | renderer | technique | CPU s | noisy | relMSE | SSIM | energy | worst part | worst block | flicker |", "|---" * 11 + "|"]
        for factor in factors:
            for name in dict.fromkeys(run["name"] for run in found["runs"] if run["factor"] == factor):
                chosen = next(run["technique"] for run in found["runs"] if run["name"] == name and run["factor"] == factor)
                cells = [median(found, name, factor, key) for key in ("cpu", "noisy", "relmse", "ssim", "energy", "worst_part", "worst_block", "flicker")]
                form = ("{:.1f}", "{:.2e}", "{:.2e}", "{:.4f}", "{:.4f}", "{:.3f}", "{:.3f}", "{:.2e}")
                lines.append(f"| {factor}T | {name} | {chosen if chosen != name else ''} | "
                             + " | ".join("–" if np.isnan(cell) else text.format(cell) for text, cell in zip(form, cells, strict=True)) + " |")
    return "\n".join(lines) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description="Measure denoised pictures against Cycles at equal CPU time.")
    parser.add_argument("scenes", nargs="*", default=[], help="names; without any, the hard scenes")
    parser.add_argument("--build", type=Path, default=PROJECT / "build" / "release")
    parser.add_argument("--seconds", type=float, default=10.0, help="T, in CPU seconds")
    parser.add_argument("--factors", type=lambda text: [int(item) for item in text.split(",")], default=[1, 4, 16])
    parser.add_argument("--techniques", type=lambda text: text.split(","), default=["auto", "path", "bdpt", "erpt"], help="`auto` is compared")
    parser.add_argument("--reference-seconds", type=float, default=300.0, help="of each scene's reference")
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--wheel", required=True, help="a Python with the bpy wheel of a newer Blender")
    parser.add_argument("--extension", type=Path, help="an unpacked extension: the wheel exports the scenes, so that both engines have the materials of its Blender")
    options = parser.parse_args()
    sys.path.insert(0, str(options.build.resolve() / "python"))
    import ajar

    if not load_denoiser():
        return 2
    work, start = PROJECT / "build" / "denoised", time.monotonic()
    results = {"machine": machine.describe(options.threads) | {"denoiser": f"Open Image Denoise {ajar.denoiser_version()}"},
               "seconds": options.seconds, "exported_by_wheel": bool(options.extension), "scenes": []}
    kept = json.loads((work / "results.json").read_text()) if (work / "results.json").exists() else {}
    if all(kept.get(key) == results[key] for key in ("seconds", "exported_by_wheel")):
        results["scenes"] = kept["scenes"]
    for scene in find_scenes(options.scenes or ["room", "rooms", "lantern", "bar", "keyhole", "box"]):
        found = measure_scene(scene, renderers.AjarBuild(options.build.resolve()), work, options)
        results["scenes"] = merged(results["scenes"], found)
        (work / "results.json").write_text(json.dumps(results, indent=1))
        (PROJECT / "docs" / "benchmarks" / "denoised.md").write_text(page(results))
    print(f"{time.monotonic() - start:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
