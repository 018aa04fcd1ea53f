"""Runs in the Python of a bpy wheel: renders a .blend file once, as F12 does, with Ajar or Cycles. benchmarks/clean_picture.py starts it.

    clean_render.py JOB     JSON: {"blend", "engine", "seconds", "seed", "height", "out"}

The settings are those of the file. In both engines, adaptive sampling and denoising are on (both are defaults), and the time limit ends the render after `seconds`. Prints
the CPU seconds of the process, start and reading of the file included, and writes a linear EXR file with `height` rows.
"""

from __future__ import annotations

import json
import os
import resource
import sys

import bpy
from cycles_render import set_if_known

ENDLESS = 1 << 20   # samples; the time limit ends the render


def render(job: dict) -> None:
    if job["engine"] == "AJAR":
        bpy.ops.preferences.addon_enable(module="bl_ext.user_default.ajar_render")
    bpy.ops.preferences.addon_enable(module="cycles")
    bpy.ops.wm.open_mainfile(filepath=job["blend"], load_ui=False)
    scene, settings = bpy.context.scene, bpy.context.scene.render
    settings.engine = job["engine"]
    scale = job["height"] / settings.resolution_y
    settings.resolution_percentage = 100
    settings.resolution_x, settings.resolution_y = max(1, round(settings.resolution_x * scale)), job["height"]
    set_if_known(settings, use_border=False, use_compositing=False, use_sequencer=False, use_multiview=False, use_stamp=False, use_persistent_data=False,
                 threads_mode="AUTO")
    for layer in scene.view_layers:
        layer.use = layer == bpy.context.view_layer
        layer.samples = 0
        if hasattr(layer, "cycles"):
            set_if_known(layer.cycles, use_denoising=True)
    set_if_known(scene.cycles, device="CPU", samples=ENDLESS, seed=job["seed"], use_animated_seed=False, use_adaptive_sampling=True, adaptive_threshold=0.01,
                 adaptive_min_samples=0, use_denoising=True, denoiser="OPENIMAGEDENOISE", denoising_input_passes="RGB_ALBEDO_NORMAL", denoising_prefilter="ACCURATE",
                 denoising_quality="HIGH", denoising_use_gpu=False, time_limit=job["seconds"], use_sample_subset=False)
    if job["engine"] == "AJAR":
        for name in scene.ajar.bl_rna.properties.keys():
            scene.ajar.property_unset(name)   # a file may have another technique than a new scene
        scene.ajar.use_cycles_settings, scene.ajar.seed = True, job["seed"]
    image = settings.image_settings
    set_if_known(image, media_type="IMAGE")
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGBA", "32", "ZIP"
    settings.filepath = job["out"]
    bpy.ops.render.render(write_still=True)
    used = resource.getrusage(resource.RUSAGE_SELF)
    print("RESULT " + json.dumps({"cpu": used.ru_utime + used.ru_stime, "memory": used.ru_maxrss * 1024}), flush=True)


if __name__ == "__main__":
    render(json.loads(sys.argv[1]))
    os._exit(0)
