#!/usr/bin/python3
"""Measures how long an artist waits for a clean picture: wall time of Ajar and of Cycles, from the start of the process to the saved file.

    benchmarks/clean_picture.py [NAME ...] [--height 1080] [--limit 300] [--reference-seconds 1200] [--write PAGE]

NAME: a scene of test_scenes, a file of ../shared/scenes, or the path of another .blend file. Without any: all of test_scenes and ../shared/scenes.
Each render is a process with the bpy wheel of a newer Blender. It starts, reads the file, exports, builds, renders with adaptive sampling, denoises and saves (clean_render.py). The settings are those of the file; the time limit
is doubled until the picture is clean or more than LIMIT seconds. Clean: the mean of the perceptual difference FLIP [Andersson et al. 2020] of the sRGB
pictures is at most CLEAN. The time is interpolated between two renders (log-log). Engines that are not clean are compared at the smallest FLIP that both reached.

The reference of an engine is its own denoised picture after REFERENCE_SECONDS, so that different materials do not count as noise. In scenes whose light
Cycles does not find (`denoised.REFERENCES`), it is Ajar's for both. Results are in build/clean; a scene that has one is measured again if named.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import images
import machine
import numpy as np
import renderers
from denoised import REFERENCES
from scenes import PROJECT, SHARED

sys.path.insert(0, str(PROJECT / "tests" / "compatibility"))
import compatibility

WORK = PROJECT / "build" / "clean"
INSIDE = Path(__file__).resolve().parent / "clean_render.py"
ENGINES = {"Ajar": "AJAR", "Cycles": "CYCLES"}
CLEAN = 0.03
FIRST_SECONDS = 0.25
FLIP = "flip-evaluator==1.7"   # NVIDIA's own implementation
SLOWEST, MEDIAN = 1.25, 0.7    # bars, in times of Cycles


@dataclass(frozen=True)
class Rung:
    """A render: its time limit, wall and CPU seconds of the process, bytes, and its FLIP."""

    limit: float
    seconds: float
    cpu: float
    memory: int
    flip: float


def files() -> dict[str, Path]:
    found = {path.stem: path for path in sorted((PROJECT / "test_scenes").glob("*.blend"))}
    return found | {f"{path.parent.name}_{path.stem}": path for path in sorted(SHARED.rglob("*.blend"))}


@cache
def import_flip():
    """The package is installed below the work folder at the first use."""
    folder = WORK / "python"
    if not (folder / "flip_evaluator").exists():
        subprocess.run([sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--target", folder, FLIP], check=True)
    sys.path.insert(0, str(folder))
    import flip_evaluator
    return flip_evaluator


def flip_of(image: np.ndarray, reference: np.ndarray) -> float:
    """The mean over the pixels, for the pictures as a display shows them."""
    shown = [images.srgb_bytes(picture).astype(np.float32) / 255.0 for picture in (reference, image)]
    return float(import_flip().evaluate(*shown, "LDR", applyMagma=False)[1])


class Renders:
    """Renders of a file in the wheel."""

    def __init__(self, blend: Path, height: int, wheel: compatibility.Blender, folder: Path) -> None:
        self.blend, self.height, self.python, self.folder = blend, height, wheel.command[0], folder
        folder.mkdir(parents=True, exist_ok=True)

    def picture(self, engine: str, limit: float, seed: int) -> tuple[np.ndarray, float, dict]:
        """The picture, the wall seconds of the process, and what it printed."""
        out = self.folder / f"{engine}.exr"
        job = {"blend": str(self.blend), "engine": ENGINES[engine], "seconds": limit, "seed": seed, "height": self.height, "out": str(out)}
        start = time.monotonic()
        log = renderers.run([self.python, str(INSIDE), json.dumps(job)], f"{engine} on {self.blend.name}",
                            os.environ | {"BLENDER_USER_RESOURCES": str(WORK / "profile")})
        seconds = time.monotonic() - start
        return images.read_exr(out).astype(np.float64), seconds, json.loads(log.split("RESULT ")[1].splitlines()[0])

    def ladder(self, engine: str, reference: np.ndarray, limit: float, seed: int) -> list[Rung]:
        rungs: list[Rung] = []
        time_limit = FIRST_SECONDS
        while time_limit <= limit and (not rungs or rungs[-1].flip > CLEAN):
            image, seconds, used = self.picture(engine, time_limit, seed)
            rungs.append(Rung(time_limit, seconds, used["cpu"], used["memory"], flip_of(image, reference)))
            print(f"{self.blend.stem} {engine} {time_limit:g} s: {seconds:.1f} s, {used['cpu']:.1f} CPU s, FLIP {rungs[-1].flip:.4f}", flush=True)
            time_limit *= 2.0
        return rungs


def time_until(rungs: list[Rung], flip: float, key: str = "seconds") -> float:
    """Seconds until this FLIP; infinite if no render reached it. The first render is the least that an engine takes."""
    for number, rung in enumerate(rungs):
        if rung.flip > flip:
            continue
        if number == 0:
            return getattr(rung, key)
        before = rungs[number - 1]
        part = math.log(before.flip / flip) / math.log(before.flip / max(rung.flip, 1e-6))
        return getattr(before, key) * (getattr(rung, key) / getattr(before, key)) ** part
    return math.inf


def measure(name: str, blend: Path, wheel: compatibility.Blender, options: argparse.Namespace) -> dict:
    renders = Renders(blend, options.height, wheel, WORK / name)
    references = {engine: renders.picture(engine, options.reference_seconds, 99)[0] for engine in (("Ajar",) if name in REFERENCES else ENGINES)}
    ladders: dict[str, list[list[Rung]]] = {engine: [] for engine in ENGINES}
    for seed in range(1, options.repeats + 1):
        for engine, found in ladders.items():
            found.append(renders.ladder(engine, references.get(engine, references["Ajar"]), options.limit, seed))
    return {"name": name, "height": options.height, "limit": options.limit, "reference": options.reference_seconds,
            "ladders": {engine: [[asdict(rung) for rung in rungs] for rungs in found] for engine, found in ladders.items()}}


def ladders_of(found: dict, engine: str) -> list[list[Rung]]:
    return [[Rung(**rung) for rung in rungs] for rungs in found["ladders"][engine]]


def level_of(found: dict) -> float:
    """The FLIP at which the engines are compared: CLEAN, or the least that all ladders of both have reached."""
    return max(CLEAN, *(min(rung.flip for rung in rungs) for engine in ENGINES for rungs in ladders_of(found, engine)))


def median_time(found: dict, engine: str, flip: float, key: str = "seconds") -> float:
    return statistics.median(time_until(rungs, flip, key) for rungs in ladders_of(found, engine))


def ratio(found: dict) -> float:
    """Time of Ajar over that of Cycles."""
    level = level_of(found)
    return median_time(found, "Ajar", level) / median_time(found, "Cycles", level)


def row(found: dict) -> str:
    level = level_of(found)
    cells = [f"{median_time(found, engine, level):.1f} ({median_time(found, engine, level, 'cpu'):.1f})" for engine in ENGINES]
    memory = [f"{max(rung.memory for rungs in ladders_of(found, engine) for rung in rungs) / 2**20:.0f}" for engine in ENGINES]
    return f"| {found['name']} | {level:.3f} | {cells[0]} | {cells[1]} | {ratio(found):.2f} | {' / '.join(memory)} |"


def page(results: list[dict], version: str) -> str:
    ratios = [ratio(found) for found in results]
    clean = [found for found in results if level_of(found) == CLEAN]
    references = [f"{seconds:g}" for seconds in sorted({found["reference"] for found in results})]
    firsts = [f"{seconds:g}" for seconds in sorted({ladders_of(found, engine)[0][0].limit for found in results for engine in ENGINES})]
    described = machine.describe(os.cpu_count() or 1)
    heights = sorted({found["height"] for found in results})
    return "\n".join([
        "# Time to a clean picture", "",
        f"**Median of the times of Ajar over those of Cycles {version}: {statistics.median(ratios):.2f} (bar {MEDIAN}); {sum(value > SLOWEST for value in ratios)} of "
        f"{len(ratios)} files take more than {SLOWEST} times as long (bar: none).** In {len(clean)} files both engines reached a clean picture in the time that was tried. "
        "The others are compared at the smallest FLIP that both reached.", "",
        "| file | FLIP | Ajar: s (CPU s) | Cycles: s (CPU s) | ratio | MiB |", "|---" * 6 + "|", *map(row, results), "",
        "## Method", "",
        "`benchmarks/clean_picture.py` writes this page; do not edit it. Each render is a process of its own, with the bpy wheel of Blender: it starts, reads the file, "
        f"exports, builds, renders {' or '.join(map(str, heights))} rows, denoises and saves. The seconds are wall time of that process on {os.cpu_count()} threads. Both engines have the settings of "
        "the file, and adaptive sampling and denoising as a new scene has them; Ajar's technique is `auto`. The time limit is doubled from "
        f"{' or '.join(firsts)} s on, up to {max(found['limit'] for found in results):g} s, until the mean FLIP [Andersson et al. 2020] of the sRGB picture is at most {CLEAN} (clean), and the time is interpolated. "
        f"Ajar's time limit includes denoising, that of Cycles does not. The reference of an engine is its own denoised picture with a time limit of {' or '.join(references)} s; in "
        f"{', '.join(sorted(REFERENCES))} it is Ajar's for both, because Cycles does not find all of the light.",
        "", "## Machine", "", *(f"* {key}: {value}" for key, value in described.items())]) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("--height", type=int, default=1080, help="rows of the picture")
    parser.add_argument("--limit", type=float, default=300.0, help="longest time limit of a render, in seconds")
    parser.add_argument("--reference-seconds", type=float, default=1200.0)
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--wheel", default="5.2.3", choices=compatibility.WHEELS)
    parser.add_argument("--zip", type=Path, help="the extension; without it, that in out/")
    parser.add_argument("--write", type=Path, default=PROJECT / "docs" / "benchmarks" / "clean_picture.md", help="the page")
    options = parser.parse_args()
    others = {Path(name).stem: Path(name).resolve() for name in options.names if name.endswith(".blend")}
    known = files() | others
    options.names = [Path(name).stem if name.endswith(".blend") else name for name in options.names]
    for name in options.names:
        if name not in known:
            parser.error(f"no file '{name}'; there are {', '.join(known)}")
    wheel = compatibility.wheel(options.wheel, (options.zip or compatibility.zips()[0]).resolve())
    WORK.mkdir(parents=True, exist_ok=True)
    renderers.run([wheel.command[0], "-c", INSTALL, str(wheel.zip)], "the installation", os.environ | {"BLENDER_USER_RESOURCES": str(WORK / "profile")})
    kept_file = WORK / "results.json"
    results = json.loads(kept_file.read_text()) if kept_file.exists() else {}
    for name in options.names or [name for name in known if name not in results]:
        try:
            results[name] = measure(name, known[name], wheel, options)
        except renderers.RenderFailed as reason:
            print(f"{name}: {reason}", file=sys.stderr)
            continue
        kept_file.write_text(json.dumps(results, indent=1))
        print(row(results[name]), flush=True)
        options.write.write_text(page([results[each] for each in known if each in results], options.wheel))
    return 0


INSTALL = """
import os, sys, bpy
bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
sys.stdout.flush()
os._exit(0)
"""

if __name__ == "__main__":
    sys.exit(main())
