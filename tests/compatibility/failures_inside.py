"""Runs in the Python of a bpy wheel: renders that fail, into EXR files. Blender must go on, and the engine must say why.

    python failures_inside.py ZIP OUT
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
import inside


def fail(folder: Path, is_animation: bool, is_stereo: bool) -> str:
    """The error of a render whose scene camera is a mesh. Blender writes the file all the same."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "AJAR"
    scene.camera = next(thing for thing in scene.objects if thing.type == "MESH")
    scene.render.resolution_percentage, scene.frame_end = 2, 2
    scene.render.use_multiview = is_stereo
    image = scene.render.image_settings
    image.file_format = "OPEN_EXR"
    image.views_format = "MULTIVIEW" if is_stereo else "INDIVIDUAL"
    scene.render.filepath = str(folder / "frame_")
    try:
        bpy.ops.render.render(animation=is_animation, write_still=not is_animation)
    except RuntimeError as error:
        return str(error)
    return ""


def main(zip_file: str, out: Path) -> None:
    inside.install(zip_file)
    faults = []
    for is_animation in (False, True):
        for is_stereo in (False, True):
            error = fail(out.parent, is_animation, is_stereo)
            if "camera" not in error:
                faults.append(f"animation {is_animation}, stereo {is_stereo}: {error!r}")
    out.write_text(json.dumps(faults))


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
    sys.stdout.flush()
    os._exit(0)
