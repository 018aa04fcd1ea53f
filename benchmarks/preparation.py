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

LONGEST, ROUNDS = 16, 2


def make_small(scene: bpy.types.Scene) -> None:
    render = scene.render
    scale = LONGEST / max(render.resolution_x, render.resolution_y)
    render.resolution_percentage = 100
    render.resolution_x, render.resolution_y = (max(4, round(size * scale)) for size in (render.resolution_x, render.resolution_y))
    render.use_compositing = render.use_sequencer = render.use_border = False
    scene.cycles.samples, scene.cycles.device = 1, "CPU"
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.ajar.use_cycles_settings, scene.ajar.integrator, scene.ajar.samples, scene.ajar.use_denoise = True, "path", 1, False
    for layer in scene.view_layers:
        layer.use = layer == bpy.context.view_layer


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
