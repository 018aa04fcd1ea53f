#!/usr/bin/python3
"""Compares all techniques with Cycles at equal CPU time, on scenes whose light is hard to find:

    benchmarks/techniques.py [SCENE ...] [--seconds 3] [--repeats 5] [--reference-seconds 240] [--techniques NAMES] [--wheel PYTHON]

All techniques of a scene are compared with one reference: the mean of independent `metropolis` renders, checked by the mean of an independent `bdpt`
render. The remaining noise of the reference is subtracted from every error. Techniques are rendered in turn, with new seeds in every turn. The result
is the efficiency, 1 / (CPU seconds * relMSE), as a multiple of the median of Cycles: 10 means the same error in a tenth of the time if the variance falls
as 1 / time. CPU seconds are those of rendering, without export and build. References are stored in build/techniques and rendered again when the .blend changes. Writes docs/benchmarks/techniques.md and
build/techniques/results.json.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import statistics
import sys
from dataclasses import dataclass
from pathlib import Path
from collections.abc import Callable

import agreement
import images
import machine
import metrics
import numpy as np
import renderers
from scenes import PROJECT, Scene, find_scenes

HARD_SCENES = ["box", "room", "rooms", "lantern", "keyhole", "bar", "kitchen"]
REFERENCE_REPLICATES = 8
ENDLESS = 1 << 20  # samples; the time limit stops the render

# Name on the page, and options of ajar-render.
AJAR_TECHNIQUES = {
    "path": ["--integrator", "path"],
    "path, guided": ["--integrator", "path", "--guiding", "on"],
    "path, guiding auto": ["--integrator", "path", "--guiding", "auto"],
    "path, uniform": ["--integrator", "path", "--image", "uniform"],
    "bdpt": ["--integrator", "bdpt"],
    "metropolis": ["--integrator", "metropolis"],
    "erpt": ["--integrator", "erpt"],
    "pmc_pt": ["--integrator", "pmc_pt"],
    "photon_map": ["--integrator", "photon_map"],
    "mps": ["--integrator", "mps"],
    "auto": ["--integrator", "auto"],
}
CYCLES = "Cycles"
UNBIASED = ["--vertex-merging", "off"]  # options without which the references would be only consistent


@dataclass(frozen=True)
class Reference:
    mean: np.ndarray
    variance: np.ndarray  # variance of the mean
    check: float          # mean luminance of an independent bdpt render over that of `mean`

    @property
    def noise(self) -> float:
        """relMSE of the reference itself."""
        return float((self.variance / (self.mean**2 + 0.01)).mean())


def ajar_image(ajar: renderers.AjarBuild, scene: Path, out: Path, seconds: float, seed: int, threads: int, options: list[str]) -> renderers.Render:
    return ajar.render(scene, out, [ENDLESS], [seed], threads, ["--seconds", str(seconds), *options])[0]


def reference_of(ajar: renderers.AjarBuild, blend: Scene, scene: Path, folder: Path, seconds: float, threads: int) -> Reference:
    """The reference of the scene file `scene`, which was exported from `blend`."""
    kept = folder / "reference.npz"
    key = f"{hashlib.sha256(blend.path.read_bytes()).hexdigest()} at {blend.percentage} %"
    if kept.exists():
        data = np.load(kept)
        if str(data["key"]) == key and float(data["seconds"]) >= seconds:
            return Reference(data["mean"], data["variance"], float(data["check"]))
    each = seconds / (REFERENCE_REPLICATES + 2)
    replicates = [ajar_image(ajar, scene, folder / "reference", each, 1001 + i, threads, [*AJAR_TECHNIQUES["metropolis"], *UNBIASED]).image()
                  for i in range(REFERENCE_REPLICATES)]
    mean, variance = agreement.mean_and_variance(replicates)
    other = ajar_image(ajar, scene, folder / "reference", 2 * each, 2001, threads, [*AJAR_TECHNIQUES["bdpt"], *UNBIASED]).image()
    check = float(metrics.luminance(other).mean() / metrics.luminance(mean).mean())
    np.savez_compressed(kept, mean=mean.astype(np.float32), variance=variance.astype(np.float32), check=check, key=key, seconds=seconds)
    return Reference(mean, variance, check)


def cycles_technique(scene: Scene, folder: Path, seconds: float, threads: int, **settings) -> Callable[[int], renderers.Render]:
    """Cycles with the number of samples that takes about `seconds` with all threads. Its CPU time is without that of an image of no samples."""
    trial = renderers.render_cycles(scene.path, folder, [1, 17], [99], threads, scene.percentage, **settings)
    cpu = [render.statistics["cpu_seconds"] for render in trial]
    per_sample = max((cpu[1] - cpu[0]) / 16, 1e-5)
    start = max(0.0, cpu[0] - per_sample)
    samples = max(1, round(threads * seconds / per_sample))

    def render(seed: int) -> renderers.Render:
        done = renderers.render_cycles(scene.path, folder, [samples], [seed], threads, scene.percentage, **settings)[0]
        done.statistics["render_cpu_seconds"] = max(done.statistics["cpu_seconds"] - start, 1e-5)
        return done
    return render


def measure_scene(scene: Scene, ajar: renderers.AjarBuild, work: Path, options: argparse.Namespace) -> dict:
    folder = work / scene.name
    scene_file, _ = ajar.dump(scene.path, folder, scene.percentage)
    reference = reference_of(ajar, scene, scene_file, folder, options.reference_seconds, options.threads)
    techniques: dict[str, Callable[[int], renderers.Render]] = {CYCLES: cycles_technique(scene, folder / "cycles", options.seconds, options.threads)}
    if options.wheel:
        for name, guiding in (("Cycles wheel", False), ("Cycles wheel, guided", True)):
            techniques[name] = cycles_technique(scene, folder / "wheel", options.seconds, options.threads, python=options.wheel, guiding=guiding)
    for name in options.techniques.split(";"):
        arguments = AJAR_TECHNIQUES[name]
        def render_by_ajar(seed: int, name: str = name, arguments: list[str] = arguments) -> renderers.Render:
            return ajar_image(ajar, scene_file, folder / name.replace(", ", "_"), options.seconds, seed, options.threads, arguments)
        techniques[name] = render_by_ajar
    runs, failures = [], {}
    for repeat in range(1, options.repeats + 1):
        for name, render in techniques.items():
            if name in failures:
                continue
            try:
                done = render(repeat)
            except renderers.RenderFailed as failure:
                failures[name] = str(failure).splitlines()[-1]
                continue
            image = done.image()
            runs.append({"technique": name, "repeat": repeat, "seconds": done.seconds,
                         "cpu_seconds": done.statistics["render_cpu_seconds"], "samples": done.samples, "path": str(done.path),
                         "relmse": metrics.relmse(image, reference.mean, reference.variance),
                         "trimmed": metrics.relmse(image, reference.mean, reference.variance, discard=0.001),
                         "mean": float(metrics.luminance(image).mean() / metrics.luminance(reference.mean).mean()),
                         "refused": done.statistics.get("refused_samples", 0)})
    return {"scene": scene.name, "width": reference.mean.shape[1], "height": reference.mean.shape[0], "runs": runs, "failures": failures,
            "reference_noise": reference.noise, "reference_check": reference.check}


def efficiencies(found: dict, technique: str, error: str) -> list[float]:
    """1 / (T * relMSE) of every repeat, with T in CPU seconds. Repeats with an error below the noise of the reference are omitted."""
    return [metrics.efficiency(run["cpu_seconds"], run[error]) for run in found["runs"] if run["technique"] == technique and run[error] > 0.0]


def technique_row(found: dict, technique: str) -> str | None:
    runs = [run for run in found["runs"] if run["technique"] == technique]
    if not runs:
        return None
    cells = []
    for error in ("relmse", "trimmed"):
        ours, theirs = efficiencies(found, technique, error), efficiencies(found, CYCLES, error)
        if ours and theirs:
            base = statistics.median(theirs)
            cells.append(f"**{statistics.median(ours) / base:.3g}** ({min(ours) / base:.3g} to {max(ours) / base:.3g})")
        else:
            cells.append("–")
    median = {key: statistics.median(run[key] for run in runs) for key in ("seconds", "cpu_seconds", "relmse", "trimmed")}
    mean = [run["mean"] for run in runs]
    return (f"| {technique} | {median['seconds']:.2f} | {median['cpu_seconds']:.2f} | {median['relmse']:.3g} | {median['trimmed']:.3g} | {cells[0]} | {cells[1]} | "
            f"{statistics.mean(mean):.4f} ± {statistics.stdev(mean) / len(mean) ** 0.5 if len(mean) > 1 else float('nan'):.4f} |")


def best_row(found: dict) -> str:
    """The most efficient technique of a scene, for all pixels and without the worst ones."""
    cells = []
    for error in ("relmse", "trimmed"):
        theirs = efficiencies(found, CYCLES, error)
        ours = {name: efficiencies(found, name, error) for name in AJAR_TECHNIQUES}
        best = max((name for name in ours if ours[name]), key=lambda name: statistics.median(ours[name]), default=None)
        cells.append(f"`{best}` **{statistics.median(ours[best]) / statistics.median(theirs):.3g}**" if best and theirs else "–")
    return f"| {found['scene']} | {cells[0]} | {cells[1]} |"


def page(results: dict) -> str:
    lines = ["# Techniques against Cycles where light is hard to find", "",
             "The most efficient technique of each scene, with its efficiency 1/(T·relMSE) over that of Cycles.", "",
             "| scene | all pixels | trimmed |", "|---|---|---|", *(best_row(found) for found in results["scenes"]), "", "## Method", "",
             "`benchmarks/techniques.py` (part of `make bench`) writes this page; do not edit it.", "",
             f"{results['machine']['threads']} threads, {results['seconds']:g} s a render, {results['repeats']} seeds, at 30 % of the scenes' size. Errors are "
             "relMSE, mean((I−R)²/(R²+0.01)), medians over seeds; *trimmed* omits the worst 0.1 % of pixels. Multiples are of Cycles' efficiency "
             "1/(T·relMSE) with T in CPU seconds, its median over the same number of seeds, in brackets the minimum and the maximum of single seeds. Seconds are the time "
             "of rendering, without export and build. A reference should have at most a tenth of the error that it judges; its own error is stated. "
             "The last column is the mean of the image over that of the reference with one standard error.", ""]
    lines += ["## Machine", ""] + [f"* {key}: {value}" for key, value in results["machine"].items()]
    for found in results["scenes"]:
        lines += ["", f"## {found['scene']}", "",
                  f"{found['width']}×{found['height']}. The reference's own relMSE is {found['reference_noise']:.2g}; an independent bidirectional render has "
                  f"{found['reference_check']:.4f} of its mean.", "",
                  "| technique | s | CPU s | relMSE | trimmed | times Cycles | times Cycles, trimmed | mean |", "|---|---|---|---|---|---|---|---|"]
        names = list(dict.fromkeys(run["technique"] for run in found["runs"]))
        lines += [row for row in (technique_row(found, name) for name in names) if row]
        lines += [f"\n{name} was not measured: {why}" for name, why in found["failures"].items()]
        lines += ["", f"![{', '.join(names)}]({found['scene']}_techniques.jpg)", "", f"Left to right, top to bottom: reference, {', '.join(names)}."]
    return "\n".join(lines) + "\n"


def sheet_of(found: dict, folder: Path) -> np.ndarray:
    """The reference and the last image of each technique, four in a row."""
    panels = [np.load(folder / "reference.npz")["mean"]]
    for name in dict.fromkeys(run["technique"] for run in found["runs"]):
        panels.append(images.read_exr([run for run in found["runs"] if run["technique"] == name][-1]["path"]))
    blank = np.ones_like(panels[0])
    panels += [blank] * (-len(panels) % 4)
    return images.srgb_bytes(np.concatenate([np.concatenate(panels[i:i + 4], axis=1) for i in range(0, len(panels), 4)], axis=0))


def write_pages(results: dict, work: Path, docs: Path) -> None:
    from report import write_jpegs

    pngs = []
    for found in results["scenes"]:
        pngs.append(docs / f"{found['scene']}_techniques.png")
        images.write_png(pngs[-1], sheet_of(found, work / found["scene"]))
    write_jpegs(pngs)
    (docs / "techniques.md").write_text(page(results))


def main() -> int:
    parser = argparse.ArgumentParser(description="Measure all techniques against Cycles at equal time.")
    parser.add_argument("scenes", nargs="*", default=[], help=f"names; without any, {', '.join(HARD_SCENES)}")
    parser.add_argument("--build", type=Path, default=PROJECT / "build" / "release")
    parser.add_argument("--seconds", type=float, default=3.0, help="of every render")
    parser.add_argument("--reference-seconds", type=float, default=240.0, help="for each scene's reference")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--techniques", default=";".join(AJAR_TECHNIQUES), help="names of Ajar's techniques, with semicolons between them")
    parser.add_argument("--wheel", help="a Python with the bpy wheel of a newer Blender, as another competitor")
    parser.add_argument("--references-only", action="store_true", help="make the references and stop")
    options = parser.parse_args()
    ajar = renderers.AjarBuild(options.build.resolve())
    work = PROJECT / "build" / "techniques"
    scenes = find_scenes(options.scenes or HARD_SCENES)
    if options.references_only:
        for scene in scenes:
            scene_file, _ = ajar.dump(scene.path, work / scene.name, scene.percentage)
            reference = reference_of(ajar, scene, scene_file, work / scene.name, options.reference_seconds, options.threads)
            print(f"{scene.name}: relMSE of the reference {reference.noise:.2g}, bdpt has {reference.check:.4f} of its mean", flush=True)
        return 0
    results = {"machine": machine.describe(options.threads), "seconds": options.seconds, "repeats": options.repeats, "scenes": []}
    for scene in scenes:
        found = measure_scene(scene, ajar, work, options)
        results["scenes"].append(found)
        (work / "results.json").write_text(json.dumps(results, indent=1))
        print(f"\n{scene.name}", *[row for name in dict.fromkeys(run["technique"] for run in found["runs"]) if (row := technique_row(found, name))],
              sep="\n", flush=True)
    write_pages(results, work, PROJECT / "docs" / "benchmarks")
    return 0


if __name__ == "__main__":
    sys.exit(main())
