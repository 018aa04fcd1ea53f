"""Runs inside a Blender or in the Python of a bpy wheel: installs Ajar from a zip, renders, and writes the results.

    python inside.py JOB.json
    blender -b --factory-startup --python inside.py -- JOB.json

With "panels" in the job, out/panels.json contains what Properties shows with Cycles and with Ajar.
The job: {"zip", "out", "renders": [{"blend", "engine", "samples", "seed", "percentage", "denoise", "time_limit"}]}, where "denoise" is "", "library" or
"compositor", and the last two can be omitted. Writes out/<number>.npy, linear RGBA from the bottom up, and out/result.json. Every use of a deprecated function of the API is an error.
Ends by os._exit: Blender's own clean-up is not tested, and its exit code would be 0 after an exception.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
import traceback
import warnings
from pathlib import Path

import bpy
import numpy as np

ADDON = "ajar_render"
EXTENSION = f"bl_ext.user_default.{ADDON}"
OURS = r"(bl_ext\.user_default\.)?ajar_render"


def install(path: str | None) -> str:
    """Installs the add-on and returns the name of its module. None: the profile already has it."""
    warnings.filterwarnings("error", module=OURS)
    if path is None:
        bpy.ops.preferences.addon_enable(module=ADDON)
        return ADDON
    if bpy.app.version >= (4, 2):
        bpy.ops.extensions.package_install_files(filepath=path, repo="user_default", enable_on_install=True)
        return EXTENSION
    bpy.ops.preferences.addon_install(filepath=path)
    bpy.ops.preferences.addon_enable(module=ADDON)
    return ADDON


def render(job: dict, path: Path) -> np.ndarray:
    """Linear RGBA of the current frame, rows from the bottom up."""
    if bpy.data.filepath != job["blend"]:
        bpy.ops.wm.open_mainfile(filepath=job["blend"])
    scene = bpy.context.scene
    scene.render.engine = job["engine"]
    settings = scene.ajar if job["engine"] == "AJAR" else scene.cycles
    settings.samples, settings.seed = job["samples"], job["seed"]
    denoise = job.get("denoise", "")
    if job["engine"] == "AJAR":
        settings.integrator = "path"
        settings.use_denoise, settings.time_limit = denoise == "library", job.get("time_limit", 0.0)
    else:
        settings.use_adaptive_sampling = settings.use_denoising = False
    scene.render.resolution_percentage = job["percentage"]
    scene.render.use_compositing, scene.render.use_sequencer = denoise == "compositor", False
    if denoise == "compositor":
        bpy.ops.ajar.denoise_in_compositor()
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGBA", "32"
    scene.render.filepath = str(path.with_suffix(".exr"))
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(str(path.with_suffix(".exr")))
    width, height = picture.size
    pixels = np.empty(width * height * 4, dtype=np.float32)
    picture.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, 4)


def mapped_libraries() -> list[str]:
    """The files of the libraries in this process."""
    lines = Path("/proc/self/maps").read_text().splitlines()
    return sorted({line.split(None, 5)[5] for line in lines if len(line.split(None, 5)) == 6 and ".so" in line.split(None, 5)[5]})


def main() -> None:
    parser = argparse.ArgumentParser(prog="inside.py", description=__doc__.splitlines()[0])
    parser.add_argument("job", type=Path, help="JSON file")
    job = json.loads(parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else None).job.read_text())
    out = Path(job["out"])
    result = {"blender": bpy.app.version_string, "python": sys.version.split()[0], "renders": []}
    try:
        module = install(job["zip"])
        result["self_check"] = sys.modules[f"{module}.self_check"].lines()
        ajar = sys.modules[f"{module}.ajar_module"].ajar
        result |= {"module": module, "instruction_set": ajar.instruction_set, "libraries": ajar.library_versions(), "file": ajar._ajar.__file__}
        for number, item in enumerate(job["renders"]):
            started = time.monotonic()
            pixels = render(item, out / str(number))
            seconds = time.monotonic() - started
            np.save(out / f"{number}.npy", pixels)
            result["renders"].append(item | {"seconds": seconds, "mean": pixels[..., :3].mean(axis=(0, 1)).tolist(), "finite": bool(np.isfinite(pixels).all())})
        if job.get("panels"):
            sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "blender" / "panels"))
            import compare

            compare.main(str(out / "panels.json"))
        result["mapped"] = mapped_libraries()
    except BaseException:
        result["error"] = traceback.format_exc()
    (out / "result.json").write_text(json.dumps(result, indent=2))
    sys.stdout.flush()
    os._exit(1 if "error" in result else 0)


if __name__ == "__main__":
    main()
