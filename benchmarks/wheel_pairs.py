#!/usr/bin/python3
"""Compares path tracing of Ajar with Cycles, both in the newer Blender of a bpy wheel: CPU time, memory and error at equal samples.

    benchmarks/wheel_pairs.py SCENE ... [--wheel 5.2.3] [--samples 64] [--reference-samples 1024] [--repeats 3] [--table PAGE]

Each render is a process of its own. The CPU time is that of the process during the render, with export and build, and the memory its highest resident
size. The error of each engine is measured against its own image of other seeds, whose noise is subtracted: mean of (a - b)^2 / (b^2 + 0.01). The
efficiency is 1 / (CPU seconds * relMSE). Adaptive sampling and denoising are off. The zip of Ajar is in out/. --table writes the results to a page.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

PROJECT = Path(__file__).resolve().parents[1]
ENGINES = {"Cycles": "CYCLES", "Ajar": "AJAR"}


def render_in_wheel(job: dict) -> None:
    """In the Python of the wheel: one image. Prints CPU seconds and bytes."""
    import bpy

    if job["engine"] == "AJAR":
        bpy.ops.extensions.package_install_files(filepath=job["zip"], repo="user_default", enable_on_install=True)
    else:
        bpy.ops.preferences.addon_enable(module="cycles")
    bpy.ops.wm.open_mainfile(filepath=job["blend"], load_ui=False)
    scene = bpy.context.scene
    scene.render.engine = job["engine"]
    scene.render.resolution_percentage = job["percentage"]
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    image = scene.render.image_settings
    if hasattr(image, "media_type"):   # 5.0
        image.media_type = "IMAGE"
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGBA", "32", "ZIP"
    settings = scene.ajar if job["engine"] == "AJAR" else scene.cycles
    settings.samples = job["samples"]
    settings.seed = job["seed"]
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.render.filepath = job["out"]
    started = time.process_time()
    bpy.ops.render.render(write_still=True)
    print("RESULT " + json.dumps({"cpu": time.process_time() - started, "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024}), flush=True)
    os._exit(0)


def measure(python: str, job: dict, folder: Path) -> tuple[dict, Any]:
    import images
    import renderers

    job = job | {"out": str(folder / f"{job['engine']}_{job['samples']}_{job['seed']}.exr")}
    log = renderers.run([python, __file__, "--job", json.dumps(job)], f"{job['engine']} on {job['blend']}", os.environ | {"BLENDER_USER_RESOURCES": str(folder / job["engine"])})
    return json.loads(log.split("RESULT ")[1].splitlines()[0]), images.read_exr(job["out"])[..., :3].astype(float)


def compare(scene, python: str, zip_file: Path, folder: Path, options: argparse.Namespace) -> list[str]:
    """The rows of a scene."""
    import metrics
    import numpy as np

    runs: dict[str, list[tuple[float, int, float, float]]] = {name: [] for name in ENGINES}
    jobs = {name: {"engine": engine, "zip": str(zip_file), "blend": str(scene.path), "percentage": options.percentage or scene.percentage}
            for name, engine in ENGINES.items()}
    half = options.reference_samples // 2
    halves = {name: [measure(python, job | {"samples": half, "seed": seed}, folder)[1] for seed in (901, 902)] for name, job in jobs.items()}
    references = {name: (np.mean(pair, axis=0), np.var(pair, axis=0, ddof=1) / 2) for name, pair in halves.items()}
    for seed in range(1, options.repeats + 1):
        for name, job in jobs.items():
            used, image = measure(python, job | {"samples": options.samples, "seed": seed}, folder)
            mean, variance = references[name]
            runs[name].append((used["cpu"], used["memory"], metrics.relmse(image, mean, variance), metrics.relmse(image, mean, variance, discard=0.001)))
    ratio = references["Ajar"][0].mean() / references["Cycles"][0].mean()
    rows = []
    for column, (what, show) in enumerate((("CPU seconds", "{:.2f}"), ("memory, MiB", "{:.0f}"), ("relMSE", "{:.3g}"), ("relMSE without the worst 0.1 %", "{:.3g}"))):
        unit = 2**20 if column == 1 else 1
        cells = []
        for name in ENGINES:
            values = [run[column] / unit for run in runs[name]]
            cells.append(f"{show.format(statistics.median(values))} ({show.format(min(values))} to {show.format(max(values))})")
        rows.append(f"| {scene.name} | {what} | {cells[0]} | {cells[1]} |")
    gains = [statistics.median(run[0] * run[column] for run in runs["Cycles"]) / statistics.median(run[0] * run[column] for run in runs["Ajar"]) for column in (2, 3)]
    rows.append(f"| {scene.name} | efficiency over Cycles, without the worst 0.1 % | 1 | **{gains[0]:.2f}**, **{gains[1]:.2f}** |")
    rows.append(f"| {scene.name} | ratio of the means | 1 | {ratio:.4f} |")
    return rows


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", help="names")
    parser.add_argument("--wheel", default="5.2.3")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--reference-samples", type=int, default=1024)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--percentage", type=int, help="of the resolution; that of the scene list by default")
    parser.add_argument("--table", type=Path, help="page to which the results are written")
    parser.add_argument("--job", type=json.loads, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.job:
        render_in_wheel(options.job)
    sys.path.insert(0, str(PROJECT / "tests" / "compatibility"))
    import compatibility
    from scenes import find_scenes

    wheel = compatibility.wheel(options.wheel, compatibility.zips()[0].resolve())
    lines = [f"| scene | | Cycles {options.wheel} | Ajar (`path`) |", "|---|---|---|---|"]
    for scene in find_scenes(options.scenes):
        with tempfile.TemporaryDirectory() as folder:
            rows = compare(scene, wheel.command[0], wheel.zip, Path(folder), options)
        print(*rows, sep="\n", flush=True)
        lines += rows
    if options.table:
        options.table.write_text("# Path tracing in a newer Blender\n\n" + "\n".join(lines) + "\n\n" +
                                 f"`benchmarks/wheel_pairs.py {' '.join(options.scenes)} --samples {options.samples}`: medians (minimum to maximum) of {options.repeats} renders, 2 threads.\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
