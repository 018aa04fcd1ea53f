#!/usr/bin/python3
"""make bench: measures scenes and techniques at equal time and at equal samples.

Every technique renders each scene with increasing sample counts, in turn with the others, and again with new seeds. Errors are relative to a
reference of the *same program* with other seeds, so that they contain only variance. tests/render tests whether the two programs show the same image;
the page has the ratio of the means of the references. Results are written to build/bench/results.json, from which report.py writes the page
docs/benchmarks/index.md.

A quick run (default) takes about a quarter of an hour for ten scenes at 30 % of their size, nine minutes with --seconds 1; --full renders at full size and longer.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from collections.abc import Callable

import agreement
import machine
import metrics
import numpy as np
import renderers
import report
from scenes import PROJECT, PROJECT_SCENES, Scene, find_scenes

REFERENCE_REPLICATES = 8
REFERENCE_SEED, TRIAL_SEED = 1001, 999


@dataclass(frozen=True)
class Technique:
    """A technique: `render(samples, seeds)` renders one scene. `program` is the program whose reference is used."""

    name: str
    program: str
    render: Callable[[list[int], list[int]], list[renderers.Render]]


@dataclass(frozen=True)
class Budget:
    """Seconds of path tracing per scene, and the distribution of the measurements."""

    reference_seconds: float
    longest_render: float
    repeats: int
    threads: int
    percentage: int | None


def samples_for(technique: Technique, seconds: float) -> int:
    """The power of two of samples that takes at most `seconds`, from a short trial."""
    short, long = technique.render([1, 5], [TRIAL_SEED])
    per_sample = max((long.seconds - short.seconds) / 4, 1e-6)
    return 2 ** max(0, int(np.log2(max(seconds / per_sample, 1.0))))


def make_reference(technique: Technique, budget: Budget) -> tuple[np.ndarray, np.ndarray]:
    """The mean image and the variance of its pixels."""
    samples = samples_for(technique, budget.reference_seconds / REFERENCE_REPLICATES)
    renders = technique.render([samples], list(range(REFERENCE_SEED, REFERENCE_SEED + REFERENCE_REPLICATES)))
    return agreement.mean_and_variance([render.image() for render in renders])


def measure(technique: Technique, repeat: int, render: renderers.Render, reference: tuple[np.ndarray, np.ndarray]) -> dict:
    """The numbers of one render. Images are not kept in memory."""
    image = render.image()
    mean, variance = reference
    return {
        "technique": technique.name, "repeat": repeat, "samples": render.samples, "seed": render.seed, "seconds": render.seconds,
        "sync_seconds": render.sync_seconds, "relmse": metrics.relmse(image, mean, variance),
        "relmse_trimmed": metrics.relmse(image, mean, variance, discard=0.001),
        "perceptual_error": metrics.perceptual_error(image, mean), "path": str(render.path),
        "statistics": {key: render.statistics[key] for key in ("rays_per_second", "peak_memory_bytes", "refused_samples", "scene")
                       if key in render.statistics},
    }


def mean_ratio(references: dict[str, tuple[np.ndarray, np.ndarray]]) -> list[float]:
    """Mean of Ajar's reference over the mean of Cycles', and its standard error; channels count as fully correlated."""
    means = {program: float(metrics.luminance(mean).mean()) for program, (mean, _) in references.items()}
    errors = {program: float(np.sqrt(((np.sqrt(variance) @ metrics.LUMINANCE_WEIGHTS) ** 2).sum())) / variance[..., 0].size
              for program, (_, variance) in references.items()}
    ratio = means["Ajar"] / means["Cycles"]
    return [ratio, ratio * float(np.hypot(errors["Ajar"] / means["Ajar"], errors["Cycles"] / means["Cycles"]))]


def bench_scene(scene: Scene, techniques: list[Technique], budget: Budget, folder: Path) -> dict:
    """All measurements of one scene, interleaved technique by technique."""
    references = {}
    for technique in techniques:
        if technique.program not in references:
            references[technique.program] = make_reference(technique, budget)
    largest = {technique.name: samples_for(technique, budget.longest_render) for technique in techniques}
    runs = []
    for repeat in range(1, budget.repeats + 1):
        for step in (64, 16, 4, 1):
            for technique in techniques:
                if (samples := largest[technique.name] // step) >= 1:
                    render = technique.render([samples], [repeat])[0]
                    runs.append(measure(technique, repeat, render, references[technique.program]))
    for program, (mean, variance) in references.items():
        np.savez_compressed(folder / f"reference_{program}.npz", mean=mean.astype(np.float32), variance=variance.astype(np.float32))
    height, width = next(iter(references.values()))[0].shape[:2]
    return {"scene": scene.name, "width": width, "height": height, "runs": runs, "mean_ratio": mean_ratio(references)}


def bare_embree(build: Path, scene_file: Path, threads: int) -> dict:
    """The rays per second as a fraction of those of bare Embree; empty if the program was not built."""
    program = build / "benchmarks" / "bare_embree"
    if not program.exists():
        return {}
    return json.loads(renderers.run([str(program), str(scene_file), "--samples", "4", "--threads", str(threads)], f"bare_embree on {scene_file}"))


def techniques_for(scene: Scene, ajar: renderers.AjarBuild, scene_file: Path, folder: Path, budget: Budget, wheel: str | None) -> list[Technique]:
    def cycles(name: str, **settings) -> Callable:
        return lambda samples, seeds: renderers.render_cycles(scene.path, folder / name, samples, seeds, budget.threads,
                                                              budget.percentage or scene.percentage, **settings)

    found = [Technique("Ajar, path", "Ajar", lambda samples, seeds: ajar.render(scene_file, folder / "ajar", samples, seeds, budget.threads,
                                                                                             ["--integrator", "path"])),
             Technique("Cycles", "Cycles", cycles("cycles"))]
    if wheel:
        found += [Technique("Cycles wheel", "Cycles wheel", cycles("wheel", python=wheel)),
                  Technique("Cycles wheel, guided", "Cycles wheel", cycles("wheel_guided", python=wheel, guiding=True))]
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description="Benchmark Ajar against Cycles.")
    parser.add_argument("scenes", nargs="*", help="names; without any, the ten test scenes")
    parser.add_argument("--full", action="store_true", help="full size, long references")
    parser.add_argument("--build", type=Path, default=PROJECT / "build" / "release")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeats", type=int, help="times every measurement is repeated with new seeds")
    parser.add_argument("--seconds", type=float, help="of the longest render")
    parser.add_argument("--wheel", help="a Python with the bpy wheel of a newer Blender, as another competitor")
    parser.add_argument("--no-report", action="store_true", help="measure only; leave docs/benchmarks as it is")
    options = parser.parse_args()
    seconds = options.seconds or (60.0 if options.full else 3.0)
    budget = Budget(reference_seconds=seconds * (20 if options.full else 4), longest_render=seconds,
                    repeats=options.repeats or (5 if options.full else 3), threads=options.threads,
                    percentage=100 if options.full else None)
    ajar = renderers.AjarBuild(options.build.resolve())
    work = PROJECT / "build" / "bench"
    scenes = find_scenes(options.scenes) if options.scenes else [scene for scene in PROJECT_SCENES if scene.path.exists()]
    started = time.monotonic()
    results = {"machine": machine.describe(budget.threads), "full": options.full, "repeats": budget.repeats,
               "longest_render": seconds, "reference_seconds": budget.reference_seconds, "scenes": []}
    for scene in scenes:
        folder = work / scene.name
        folder.mkdir(parents=True, exist_ok=True)
        try:
            scene_file, export = ajar.dump(scene.path, folder, budget.percentage or scene.percentage)
            found = bench_scene(scene, techniques_for(scene, ajar, scene_file, folder, budget, options.wheel), budget, folder)
            found["bare_embree"] = bare_embree(ajar.build, scene_file, budget.threads)
            found["export"] = {key: export.get(key) for key in ("export_seconds", "build_seconds", "peak_memory_bytes")}
        except renderers.RenderFailed as failure:
            print(f"{scene.name}: {failure}", file=sys.stderr)
            found = {"scene": scene.name, "failure": str(failure).splitlines()[0]}
        results["scenes"].append(found)
        results["seconds"] = time.monotonic() - started
        (work / "results.json").write_text(json.dumps(results, indent=1))
        print(report.one_line(found), flush=True)
    if not options.no_report:
        report.write_page(results, work, PROJECT / "docs" / "benchmarks")
    return 0


if __name__ == "__main__":
    sys.exit(main())
