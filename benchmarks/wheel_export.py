"""Runs in the Python of a bpy wheel: exports the scene of a .blend file by the add-on, without clamping and with all caustics.

    PYTHONPATH=<unpacked extension> PYTHON benchmarks/wheel_export.py BLEND OUT.ajar [PERCENTAGE]
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from python_addon import properties
from python_addon.ajar_module import ajar
from python_addon.export import export_scene
from python_addon.headless import Options


def main(blend: str, out: str, percentage: int) -> None:
    bpy.ops.wm.open_mainfile(filepath=blend, load_ui=False)
    if "cycles" not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="cycles")
    properties.register()
    scene = bpy.context.scene
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


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 0)
    sys.stdout.flush()
    os._exit(0)
