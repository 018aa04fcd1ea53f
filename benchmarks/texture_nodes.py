#!/usr/bin/python3
"""Times texture nodes beside Cycles of a newer Blender and writes docs/benchmarks/texture_nodes.md.

    benchmarks/texture_nodes.py [--zip ZIP] [--wheel 5.2.3] [--only-write]

The results are in build/texture_nodes.json.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import machine
from scenes import PROJECT

sys.path.insert(0, str(PROJECT / "tests" / "compatibility"))
import compatibility

INSIDE = Path(__file__).resolve().parent / "texture_nodes_render.py"
RESULTS = PROJECT / "build" / "texture_nodes.json"
PAGE = PROJECT / "docs" / "benchmarks" / "texture_nodes.md"
NEGLIGIBLE = 0.15   # of the time of the picture without a texture: too little to compare


def page(found: dict, version: str) -> str:
    times = found["seconds"]
    base = times.pop("none")
    lines = ["# Texture nodes", "",
             f"What a texture node costs in Ajar and in Cycles {version}: CPU seconds for {found['samples']} samples in each of {found['size']} × {found['size']} pixels, without "
             f"those of the same picture without a texture ({base['AJAR']:.2f} s and {base['CYCLES']:.2f} s). Less than 1: Ajar is faster.", "",
             "| node | Ajar, s | Cycles, s | Ajar over Cycles |", "|---|---|---|---|"]
    for name, seconds in times.items():
        ours, theirs = seconds["AJAR"] - base["AJAR"], seconds["CYCLES"] - base["CYCLES"]
        ratio = f"{ours / theirs:.2f}" if theirs > NEGLIGIBLE * base["CYCLES"] else "–"
        lines.append(f"| {name} | {ours:.2f} | {theirs:.2f} | {ratio} |")
    lines += ["", "## Method", "",
              "`benchmarks/texture_nodes.py` writes this page; do not edit it. A plane with an Emission of the node's colour fills the picture. Both engines render it in the bpy wheel in "
              "turn; the fastest of three renders counts. Inputs that are not named have Blender's values.", "", "## Machine", ""]
    return "\n".join(lines + [f"* {name}: {value}" for name, value in machine.describe(os.cpu_count() or 1).items()]) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--zip", type=Path, help="the extension; without it, that in out/")
    parser.add_argument("--wheel", default="5.2.3", choices=compatibility.WHEELS)
    parser.add_argument("--only-write", action="store_true", help="write the page from stored results")
    options = parser.parse_args()
    if not options.only_write:
        wheel = compatibility.wheel(options.wheel, (options.zip or compatibility.zips()[0]).resolve())
        with tempfile.TemporaryDirectory() as profile:
            subprocess.run([wheel.command[0], INSIDE, wheel.zip, RESULTS], env=os.environ | {"BLENDER_USER_RESOURCES": profile}, check=True)
    PAGE.write_text(page(json.loads(RESULTS.read_text()), options.wheel))
    return 0


if __name__ == "__main__":
    sys.exit(main())
