"""Runs in the Python of a bpy wheel: exports the scenes of .blend files by the add-on.

    PYTHONPATH=<unpacked extension> PYTHON benchmarks/wheel_export.py [--percentage 30] [--as-it-is] BLEND OUT.ajar [BLEND OUT.ajar ...]

Without --as-it-is, nothing is clamped and all caustics are on.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from python_addon import properties
from python_addon.ajar_module import ajar
from python_addon.export import export_scene
from python_addon.headless import Options


def export(blend: str, out: str, percentage: int, as_it_is: bool) -> None:
    bpy.ops.wm.open_mainfile(filepath=blend, load_ui=False)
    scene = bpy.context.scene
    if not as_it_is:
        scene.ajar.clamp_direct = scene.ajar.clamp_indirect = 0.0
        scene.ajar.reflective_caustics = scene.ajar.refractive_caustics = True
    scene.render.resolution_percentage = percentage or scene.render.resolution_percentage
    frame = scene.frame_current
    context = export_scene(bpy.context.evaluated_depsgraph_get(), Options({"samples": 1}), ["Combined"], scene.camera, lambda: False, lambda step: None,
                           lambda at, part: scene.frame_set(at, subframe=part))
    scene.frame_set(frame)
    for name, message in context.warnings:
        print(f"{name}: {message}")
    ajar.save_description(context.description, out)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+", help="pairs of a .blend file and a scene file")
    parser.add_argument("--percentage", type=int, default=0, help="of the resolution; that of the file by default")
    parser.add_argument("--as-it-is", action="store_true", help="keep the clamping and the caustics of the file")
    options = parser.parse_args()
    if "cycles" not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="cycles")
    properties.register()
    for blend, out in zip(options.files[::2], options.files[1::2], strict=True):
        export(blend, out, options.percentage, options.as_it_is)


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)
