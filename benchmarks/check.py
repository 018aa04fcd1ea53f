#!/usr/bin/python3
"""Tests whether a change has made a scene slower: compares the instructions for a sample of every pixel, counted by Valgrind, with a record:

    benchmarks/check.py [SCENE ...] [--record] [--build BUILD]

Instruction counts have less noise than times: one thread, the same seed, and the build of the scene is subtracted (a render of three samples minus
one of one sample). They do not include the effect of caches, and little of Embree's wide instructions, so that a change that passes can still be
slower. A change that fails executes more work. Ends with an error if a scene needs more than 5 % over its record. --record appends to
docs/benchmarks/instructions.json, whose last entry is the record; the others are the history.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path

import machine
import renderers
from scenes import PROJECT, Scene, find_scenes

SCENES = ["checker", "box", "rooms", "room", "lantern", "buddha", "plant", "outdoor", "many_lights"]
RECORD = PROJECT / "docs" / "benchmarks" / "instructions.json"
MAX_RATIO = 1.05
PERCENTAGE = 10
SAMPLES = (1, 3)


def count(program: Path, scene: Path, samples: int, folder: Path) -> int:
    """Instructions of a render by path tracing, without the search for goals of adaptive sampling, which three samples cannot pay for."""
    command = ["valgrind", "--tool=cachegrind", "--cache-sim=no", f"--cachegrind-out-file={folder / 'cachegrind.out'}", str(program), str(scene),
               str(folder / "check.exr"), "--integrator", "path", "--image", "uniform", "--samples", str(samples), "--seed", "1", "--threads", "1"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    found = re.search(r"I\s+refs:\s+([\d,]+)", result.stderr)
    if result.returncode != 0 or found is None:
        raise renderers.RenderFailed(f"valgrind on {scene} ended with code {result.returncode}:\n{result.stderr[-2000:]}")
    return int(found[1].replace(",", ""))


def instructions_of(ajar: renderers.AjarBuild, scene: Scene, folder: Path) -> float:
    """Millions of instructions for one sample of every pixel."""
    file, _ = ajar.dump(scene.path, folder, PERCENTAGE)
    few, many = (count(ajar.build / "ajar-render", file, samples, folder) for samples in SAMPLES)
    return (many - few) / (SAMPLES[1] - SAMPLES[0]) / 1e6


def verdicts(found: dict[str, float], record: dict[str, float]) -> list[tuple[str, float, bool]]:
    """Scene, ratio to the record, and whether it is within bounds. Scenes without a record are omitted."""
    return [(name, value / record[name], value <= MAX_RATIO * record[name]) for name, value in found.items() if name in record]


def main() -> int:
    parser = argparse.ArgumentParser(description="Count instructions against those on record.")
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--record", action="store_true", help="append what is found to the record")
    parser.add_argument("--build", type=Path, default=None)
    options = parser.parse_args()
    ajar = renderers.AjarBuild(options.build.resolve()) if options.build else renderers.AjarBuild.default()
    history = json.loads(RECORD.read_text()) if RECORD.exists() else []
    found = {}
    for scene in find_scenes(options.scenes or SCENES):
        found[scene.name] = instructions_of(ajar, scene, PROJECT / "build" / "check" / scene.name)
        print(f"{scene.name}: {found[scene.name]:.2f} million instructions a sample", flush=True)
    failed = False
    for name, ratio, fine in verdicts(found, history[-1]["scenes"] if history else {}):
        print(f"{name}: {ratio:.3f} of the record{'' if fine else ', TOO SLOW'}")
        failed |= not fine
    if options.record:
        history.append({"commit": machine.commit(), "scenes": {name: round(value, 3) for name, value in found.items()}})
        RECORD.write_text(json.dumps(history, indent=1) + "\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
