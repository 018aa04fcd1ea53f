#!/usr/bin/python3
"""Renders the images of the README: one scene by Cycles and by Ajar in the same time.

    benchmarks/side_by_side.py [SCENE] [--integrator auto] [--seconds 20] [--percentage 75] [--wheel PYTHON] [--build BUILD]

Both render with the settings of the file and without denoising. Ajar uses the integrator `auto` by default, and its time includes build and pilot.
Cycles takes the number of samples that lasts about as long. Writes docs/SCENE_cycles.jpg and docs/SCENE_ajar.jpg and prints the times for their
captions.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import images
import renderers
from report import write_jpegs
from scenes import PROJECT, find_scenes
from techniques import ajar_image, cycles_technique


def main() -> int:
    parser = argparse.ArgumentParser(description="Render a scene by Cycles and by Ajar in the same time.")
    parser.add_argument("scene", nargs="?", default="room")
    parser.add_argument("--integrator", default="auto", help="of Ajar")
    parser.add_argument("--seconds", type=float, default=20.0, help="of each")
    parser.add_argument("--percentage", type=int, default=75, help="of the scene's size")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--wheel", help="a Python with the bpy wheel of a newer Blender, whose Cycles renders instead")
    parser.add_argument("--build", type=Path, default=PROJECT / "build" / "release")
    options = parser.parse_args()
    scene = replace(find_scenes([options.scene])[0], percentage=options.percentage)
    ajar = renderers.AjarBuild(options.build.resolve())
    work = PROJECT / "build" / "side_by_side" / scene.name
    file, _ = ajar.dump(scene.path, work, options.percentage)
    settings = {"python": options.wheel} if options.wheel else {}
    cycles = cycles_technique(scene, work / "cycles", options.seconds, options.threads, **settings)(1)
    ours = ajar_image(ajar, file, work / "ajar", options.seconds, 1, options.threads, ["--integrator", options.integrator])
    pngs = []
    for name, render in (("cycles", cycles), ("ajar", ours)):
        pngs.append(PROJECT / "docs" / f"{scene.name}_{name}.png")
        images.write_png(pngs[-1], images.srgb_bytes(render.image()))
    write_jpegs(pngs)
    print(f"Cycles: {cycles.seconds:.1f} s, {cycles.samples:.0f} samples a pixel. "
          f"Ajar: {ours.seconds:.1f} s, by {ours.statistics['integrator']}.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
