#!/usr/bin/python3
"""Measures how long both engines prepare a scene, in the Python of a bpy wheel, as F12 does:

    BLENDER_USER_RESOURCES=FOLDER build/compat/bpy-5.2.3/bin/python benchmarks/preparation.py ZIP BLEND

Both render 16 pixels in the longer direction with one sample, twice in turn, so that nearly all time is export, build and start. Prints the smaller CPU
time of each. ZIP: of the extension.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import bpy
from small_render import make_small

ROUNDS = 2


def main(zip_file: str, blend: str) -> None:
    bpy.ops.extensions.package_install_files(filepath=zip_file, repo="user_default", enable_on_install=True)
    bpy.ops.wm.open_mainfile(filepath=blend, load_ui=False)
    if "cycles" not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="cycles")
    scene = bpy.context.scene
    make_small(scene)
    seconds: dict[str, list[float]] = {"AJAR": [], "CYCLES": []}
    for _ in range(ROUNDS):
        for engine, times in seconds.items():
            scene.render.engine = engine
            start = time.process_time()
            bpy.ops.render.render()
            times.append(time.process_time() - start)
    ajar, cycles = min(seconds["AJAR"]), min(seconds["CYCLES"])
    print(f"preparation of {Path(blend).stem}: Ajar {ajar:.3f} s, Cycles {cycles:.3f} s, ratio {ajar / cycles:.2f}", flush=True)
    os._exit(0)


main(sys.argv[1], sys.argv[2])
