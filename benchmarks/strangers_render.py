"""Runs in the Python of a bpy wheel: renders a .blend file as F12 does, with Cycles and with Ajar in turn, and writes OUT/result.json and OUT/images.npz.

    python strangers_render.py ZIP BLEND OUT SAMPLES LONGEST

Both have the bounces and caustics of the file. Clamping, Filter Glossy, denoising and adaptive sampling are off, and the longest side has LONGEST pixels.
"""

from __future__ import annotations

import json
import os
import sys
import time
import traceback
from pathlib import Path
from typing import Any

import bpy
import numpy as np

MODULE = "bl_ext.user_default.ajar_render"
SEEDS = (1, 2)


def set_known(settings: bpy.types.bpy_struct, **values: object) -> None:
    for name, value in values.items():
        if hasattr(settings, name):
            setattr(settings, name, value)


def prepare(scene: bpy.types.Scene, samples: int, longest: int) -> None:
    render = scene.render
    width, height = (size * render.resolution_percentage / 100 for size in (render.resolution_x, render.resolution_y))
    scale = min(1.0, longest / max(width, height))
    render.resolution_percentage = 100
    render.resolution_x, render.resolution_y = max(16, round(width * scale)), max(16, round(height * scale))
    set_known(render, use_border=False, use_compositing=False, use_sequencer=False, use_multiview=False, use_stamp=False, use_persistent_data=False)
    for layer in scene.view_layers:
        layer.use = layer == bpy.context.view_layer
        if hasattr(layer, "cycles"):
            set_known(layer.cycles, use_denoising=False)
    set_known(scene.cycles, device="CPU", samples=samples, use_adaptive_sampling=False, use_denoising=False, sample_clamp_direct=0.0,
              sample_clamp_indirect=0.0, blur_glossy=0.0, time_limit=0.0, use_sample_subset=False, use_animated_seed=False)
    scene.ajar.use_cycles_settings = True
    scene.ajar.integrator = "path"
    set_known(scene.ajar, samples=samples, use_denoise=False, noise_target=0.0, time_limit=0.0)
    image = render.image_settings
    set_known(image, media_type="IMAGE")
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGBA", "32"


def render_with(engine: str, seed: int, path: Path) -> tuple[np.ndarray, float, float]:
    """Linear RGB with rows from the bottom up, wall seconds and CPU seconds."""
    scene = bpy.context.scene
    scene.render.engine = engine
    (scene.ajar if engine == "AJAR" else scene.cycles).seed = seed
    scene.render.filepath = str(path)
    wall, cpu = time.perf_counter(), time.process_time()
    bpy.ops.render.render(write_still=True)
    seconds = time.perf_counter() - wall, time.process_time() - cpu
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    pixels = np.empty(width * height * 4, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)[..., :3], *seconds


def main(zip_file: str, blend: str, out: Path, samples: int, longest: int) -> None:
    result: dict = {}
    try:
        bpy.ops.extensions.package_install_files(filepath=zip_file, repo="user_default", enable_on_install=True)
        bpy.ops.wm.open_mainfile(filepath=blend, load_ui=False)
        if "cycles" not in bpy.context.preferences.addons:
            bpy.ops.preferences.addon_enable(module="cycles")
        scene = bpy.context.scene
        if scene.camera is None:
            raise ValueError("it has no camera")
        prepare(scene, samples, longest)
        images: dict[str, Any] = {}
        seconds: dict[str, list] = {"CYCLES": [], "AJAR": []}
        for seed in SEEDS:
            for engine in seconds:
                pixels, *times = render_with(engine, seed, out / "image.exr")
                images[f"{engine}_{seed}"] = pixels.astype(np.float32)
                seconds[engine].append(times)
        (out / "image.exr").unlink()
        np.savez_compressed(out / "images.npz", **images)
        result = {"seconds": seconds}
    except BaseException:
        result = {"error": traceback.format_exc(limit=3)}
    (out / "result.json").write_text(json.dumps(result))
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]), int(sys.argv[4]), int(sys.argv[5]))
