#!/usr/bin/python3
"""Writes the benchmark page: tables, plots and images from build/bench/results.json. Can run alone to write the page again."""

from __future__ import annotations

import json
import math
import statistics
import subprocess
import sys
from pathlib import Path

import images
import metrics
import numpy as np
import renderers
from plots import loglog_plot

OURS, THEIRS = "Ajar, path", "Cycles"


def curves_of(found: dict, repeat: int | None = None, error: str = "relmse") -> dict[str, tuple[list[float], list[float]]]:
    """Seconds and error by technique: of one repeat, or of all repeats (median time, mean error) at each sample count."""
    curves = {}
    for technique in dict.fromkeys(run["technique"] for run in found["runs"]):
        groups: dict[float, list[dict]] = {}
        for run in found["runs"]:
            if run["technique"] == technique and repeat in (None, run["repeat"]):
                groups.setdefault(run["samples"], []).append(run)
        points = [(statistics.median(r["seconds"] for r in runs), statistics.mean(r[error] for r in runs)) for runs in groups.values()]
        points = sorted(point for point in points if min(point) > 0)
        curves[technique] = ([p[0] for p in points], [p[1] for p in points])
    return curves


def speedup(found: dict, repeat: int | None = None, error: str = "relmse") -> float:
    """The time of Cycles divided by that of Ajar at equal errors."""
    curves = curves_of(found, repeat, error)
    if not (curves.get(OURS, ([], []))[0] and curves.get(THEIRS, ([], []))[0]):
        return math.nan
    return metrics.equal_error_speedup(metrics.ErrorCurve(*curves[OURS]), metrics.ErrorCurve(*curves[THEIRS]))


def speedup_with_spread(found: dict) -> tuple[float, float, float]:
    """The speedup of all runs, and the minimum and maximum of single repeats."""
    repeats = [speedup(found, seed) for seed in sorted({run["repeat"] for run in found["runs"]})]
    repeats = [value for value in repeats if math.isfinite(value)] or [math.nan]
    return speedup(found), min(repeats), max(repeats)


def error_after(curve: tuple[list[float], list[float]], seconds: float) -> float:
    """relMSE at a time, on log-log axes; nan outside the curve."""
    x, y = np.log(curve[0]), np.log(curve[1])
    return float(np.exp(np.interp(math.log(seconds), x, y, left=math.nan, right=math.nan)))


def error_at_samples(found: dict, technique: str, samples: float) -> float:
    errors = [run["relmse"] for run in found["runs"] if run["technique"] == technique and run["samples"] == samples]
    return statistics.mean(errors) if errors else math.nan


def number(value: float | None, form: str = ".3g") -> str:
    return format(value, form) if value is not None and math.isfinite(value) else "–"


def one_line(found: dict) -> str:
    """The line of progress in the terminal."""
    if "failure" in found:
        return f"{found['scene']}: failed: {found['failure']}"
    value, low, high = speedup_with_spread(found)
    ratio, error = found["mean_ratio"]
    return (f"{found['scene']}: {number(value)} times as fast as Cycles at equal error (repeats {number(low)} to {number(high)}); "
            f"mean {ratio:.4f} ± {error:.4f} of Cycles'")


def comparison_table(scenes: list[dict]) -> list[str]:
    lines = ["| scene | size | seconds | relMSE Ajar | relMSE Cycles | same spp | Ajar | Cycles | faster at equal relMSE (repeats) | without the worst 0.1 % | mean, Ajar over Cycles |",
             "|---|---|---|---|---|---|---|---|---|---|---|"]
    for found in scenes:
        curves = curves_of(found)
        seconds = min(curves[OURS][0][-1], curves[THEIRS][0][-1])
        counts = [{run["samples"] for run in found["runs"] if run["technique"] == name} for name in (OURS, THEIRS)]
        samples = max(counts[0] & counts[1], default=math.nan)
        value, low, high = speedup_with_spread(found)
        ratio, error = found["mean_ratio"]
        lines.append(
            f"| {found['scene']} | {found['width']}×{found['height']} | {seconds:.2f} | {number(error_after(curves[OURS], seconds))} | "
            f"{number(error_after(curves[THEIRS], seconds))} | {number(samples, 'g')} | {number(error_at_samples(found, OURS, samples))} | "
            f"{number(error_at_samples(found, THEIRS, samples))} | **{number(value, '.2f')}** ({number(low, '.2f')} to {number(high, '.2f')}) | "
            f"{number(speedup(found, error='relmse_trimmed'), '.2f')} | {ratio:.4f} ± {error:.4f} |")
    return lines


def build_table(scenes: list[dict]) -> list[str]:
    lines = ["| scene | triangles (instanced) | export s | export s per M triangles | build s | Mrays/s | of bare Embree | of bare Embree, default flags | peak MiB |",
             "|---|---|---|---|---|---|---|---|---|"]
    for found in scenes:
        export, bare = found.get("export", {}), found.get("bare_embree") or {}
        ours = [run["statistics"] for run in found["runs"] if run["technique"] == OURS and "rays_per_second" in run["statistics"]]
        scene = ours[0].get("scene", {}) if ours else {}
        triangles = scene.get("triangles", 0)
        rate = statistics.median(run["rays_per_second"] for run in ours[-len(ours) // 2 :]) / 1e6 if ours else math.nan
        export_seconds = export.get("export_seconds")
        lines.append(
            f"| {found['scene']} | {triangles:,} ({scene.get('instanced_triangles', 0):,}) | {number(export_seconds, '.2f')} | "
            f"{number(export_seconds / triangles * 1e6 if export_seconds and triangles else None, '.2f')} | {number(export.get('build_seconds'), '.2f')} | "
            f"{number(rate, '.2f')} | {number(bare.get('share_of_bare'), '.0%')} | {number(bare.get('share_of_bare_default_flags'), '.0%')} | "
            f"{number((export.get('peak_memory_bytes') or math.nan) / 2**20, '.0f')} |")
    return lines


def strip_of(found: dict, work: Path) -> np.ndarray:
    """Reference, Cycles and Ajar side by side, each from its longest render."""
    folder = work / found["scene"]
    panels = [np.load(folder / "reference_Ajar.npz")["mean"]]
    for technique in (THEIRS, OURS):
        longest = max((run for run in found["runs"] if run["technique"] == technique), key=lambda run: run["samples"])
        panels.append(images.read_exr(longest["path"]))
    gap = np.ones((panels[0].shape[0], 4, 3))
    return images.srgb_bytes(np.concatenate([panels[0], gap, panels[1], gap, panels[2]], axis=1))


def write_jpegs(pngs: list[Path]) -> None:
    """Convert PNG strips to JPEG files with Blender, and delete the PNG files."""
    script = ("import bpy\n"
              "settings = bpy.context.scene.render.image_settings\n"
              "settings.file_format, settings.quality = 'JPEG', 88\n"
              "bpy.context.scene.view_settings.view_transform = 'Standard'\n"
              f"for path in {[str(path) for path in pngs]!r}:\n"
              "    bpy.data.images.load(path).save_render(path[:-4] + '.jpg', scene=bpy.context.scene)\n")
    subprocess.run([renderers.BLENDER, "-b", "--factory-startup", "--python-exit-code", "1", "--python-expr", script], check=True,
                   stdout=subprocess.DEVNULL)
    for path in pngs:
        path.unlink()


def write_page(results: dict, work: Path, docs: Path) -> None:
    docs.mkdir(parents=True, exist_ok=True)
    scenes = [found for found in results["scenes"] if "failure" not in found]
    failed = [found for found in results["scenes"] if "failure" in found]
    speedups = [value for value in (speedup(found) for found in scenes) if math.isfinite(value)]
    size = "at full size" if results["full"] else "at 30 % of their size, a quick look: `make bench-full` renders at full size and longer"
    lines = ["# Path tracing against Cycles", ""]
    if speedups:
        lines += [f"**Median speed-up at equal relMSE: {statistics.median(speedups):.2f}** "
                  f"(minimum {min(speedups):.2f}, maximum {max(speedups):.2f}, {len(speedups)} scenes).", ""]
    lines += comparison_table(scenes)
    lines += ["", "## Method", "",
        "`make bench` writes this page; do not edit it.", "",
        f"Ajar's path tracer against Cycles in the same Blender, {results['machine']['threads']} threads, {size}. "
        f"Cycles has its best settings for the same problem: caustics on, no clamping, no denoising, adaptive sampling off. "
        f"Renders of up to {results['longest_render']:g} s in turn, {results['repeats']} repeats with new seeds. Seconds are path tracing alone; "
        "scene export and build are listed separately. relMSE is mean((I−R)²/(R²+0.01)), against a reference of the same program "
        f"({results['reference_seconds']:g} s, other seeds), whose noise is subtracted.", "",
    ]
    lines += ["The table states errors at equal time and at equal samples, and the ratio of times at equal error; the spread is over single repeats. The last "
              "column is the ratio of the references' mean luminances with one standard error; `tests/render` compares block by block.", ""]
    lines += ["## Machine", ""] + [f"* {key}: {value}" for key, value in results["machine"].items()]
    lines += ["", "## Rays, memory, export", "", "Fraction of bare Embree: a loop traces the same recorded rays and does nothing else, in the same process, in turn.", ""]
    lines += build_table(scenes)
    if failed:
        lines += ["", "## Not measured", ""] + [f"* {found['scene']}: {found['failure']}" for found in failed]
    lines += ["", "## Error over time, and images", "", "Left to right: reference, Cycles, Ajar, each at its longest render.", ""]
    pngs = []
    for found in scenes:
        name = found["scene"].replace("/", "_")
        (docs / f"{name}.svg").write_text(loglog_plot(found["scene"], curves_of(found)))
        pngs.append(docs / f"{name}.png")
        images.write_png(pngs[-1], strip_of(found, work))
        lines += [f"### {found['scene']}", "", f"![error over time]({name}.svg)", "", f"![reference, Cycles, Ajar]({name}.jpg)", ""]
    write_jpegs(pngs)
    (docs / "index.md").write_text("\n".join(lines).rstrip() + "\n")


if __name__ == "__main__":
    work_folder = renderers.PROJECT / "build" / "bench"
    write_page(json.loads((work_folder / "results.json").read_text()), work_folder, renderers.PROJECT / "docs" / "benchmarks")
    sys.exit(0)
