"""Renders a .blend with Cycles to linear EXR files, with its best settings for the scene. Runs inside Blender or the bpy wheel:

    blender -b --factory-startup --debug-cycles FILE.blend --python cycles_render.py -- --out DIR [options]
    python3 cycles_render.py -- --blend FILE.blend --out DIR [options]

One start of Blender renders all pairs of --samples and --seeds. Each render writes DIR/<samples>_<seed>.exr and prints one line `CYCLES {json}` with
its times. `seconds` is the time of path tracing as Cycles counts it: the render time minus scene synchronisation, shader compilation, texture loading
and BVH building, which are `sync_seconds`. All versions of Cycles write both to the metadata of the file, with a precision of 0.01 s. With
--debug-cycles (not in the wheel), Cycles also prints `Path Tracing <wall>` in microseconds, which renderers.py prefers; for box.blend the two differ
by less than the rounding.

"Best settings" are those with which Cycles solves the problem of an unbiased path tracer as fast as possible: caustics on, no clamping, no filtering
of glossy bounces, no denoising (unless --denoise on), no fast GI, light tree and guiding if the version has them. Bounce limits, pixel filter, light thresholds and all
other settings are those of the file.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
from images import read_exr_text


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="cycles_render.py", description="Render with Cycles for comparison.")
    parser.add_argument("--blend", help="file to open; without it the one Blender has opened")
    parser.add_argument("--out", type=Path, required=True, help="directory of the images")
    parser.add_argument("--samples", default="64", help="per pixel, comma-separated")
    parser.add_argument("--seeds", default="0", help="comma-separated")
    parser.add_argument("--percentage", type=int, help="of the file's resolution")
    parser.add_argument("--threads", type=int, default=0, help="0: all")
    parser.add_argument("--adaptive", choices=["off", "on"], default="off", help="adaptive sampling")
    parser.add_argument("--noise-threshold", type=float, default=0.01, help="of adaptive sampling")
    parser.add_argument("--guiding", choices=["off", "on"], default="off", help="path guiding, where the version has it")
    parser.add_argument("--denoise", choices=["off", "on"], default="off", help="Open Image Denoise with albedo, normal and accurate prefilter")
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])


def set_if_known(settings, **values) -> None:
    """Set the properties that this version has, since properties differ between versions."""
    for name, value in values.items():
        if hasattr(settings, name):
            setattr(settings, name, value)


def apply_settings(scene, options: argparse.Namespace) -> None:
    scene.render.engine = "CYCLES"
    set_if_known(
        scene.cycles, device="CPU", caustics_reflective=True, caustics_refractive=True, blur_glossy=0.0, sample_clamp_direct=0.0,
        sample_clamp_indirect=0.0, use_denoising=options.denoise == "on", use_fast_gi=False, use_light_tree=True, use_animated_seed=False,
        time_limit=0.0, use_auto_tile=False, use_adaptive_sampling=options.adaptive == "on",
        adaptive_threshold=options.noise_threshold, adaptive_min_samples=0, use_guiding=options.guiding == "on",
        use_sample_subset=False)
    if options.denoise == "on":
        scene.cycles.denoiser, scene.cycles.denoising_prefilter, scene.cycles.denoising_input_passes = "OPENIMAGEDENOISE", "ACCURATE", "RGB_ALBEDO_NORMAL"
        set_if_known(scene.cycles, denoising_quality="HIGH", denoising_use_gpu=False)
    render = scene.render
    set_if_known(render, use_compositing=False, use_sequencer=False, use_persistent_data=False, use_stamp=False,
                 use_overwrite=True, use_file_extension=True, use_multiview=False)
    if options.percentage:
        render.resolution_percentage = options.percentage
    render.threads_mode = "FIXED" if options.threads else "AUTO"
    if options.threads:
        render.threads = options.threads
    image = render.image_settings
    set_if_known(image, media_type="IMAGE")
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGBA", "32", "ZIP"


def clock_seconds(text: str) -> float:
    """Seconds of Blender's [hours:]minutes:seconds.hundredths."""
    total = 0.0
    for part in text.split(":"):
        total = total * 60.0 + float(part)
    return total


def cycles_times(path: Path) -> dict[str, float]:
    """The times of all view layers from the metadata of a file."""
    text = read_exr_text(path)
    return {kind: sum(clock_seconds(value) for name, value in text.items() if name.startswith("cycles.") and name.endswith(key))
            for kind, key in (("seconds", ".render_time"), ("sync_seconds", ".synchronization_time"))}


def main() -> None:
    options = parse_arguments()
    if options.blend:
        bpy.ops.wm.open_mainfile(filepath=options.blend)
    scene = bpy.context.scene
    apply_settings(scene, options)
    options.out.mkdir(parents=True, exist_ok=True)
    for seed in map(int, options.seeds.split(",")):
        for samples in map(int, options.samples.split(",")):
            path = options.out / f"{samples}_{seed}.exr"
            scene.cycles.samples, scene.cycles.seed = samples, seed
            scene.render.filepath = str(path)
            start = time.process_time()
            bpy.ops.render.render(write_still=True)
            record = {"path": str(path), "samples": samples, "seed": seed, "threads": scene.render.threads, "cpu_seconds": time.process_time() - start,
                      "frame": scene.frame_current, "renderer": f"Cycles {bpy.app.version_string}", **cycles_times(path)}
            print("CYCLES " + json.dumps(record), flush=True)


if __name__ == "__main__":
    main()
