"""Runs inside Blender, started by render.sh: renders the current frame with AJAR into exactly one file.

    blender -b --addons ajar_render FILE.blend --python tools/render_to_file.py -- --output OUT.png|OUT.exr [--ajar-options]

`.png` has the view transform applied, `.exr` is linear 32-bit float. Other formats are refused.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import bpy

EXIT_FAILED = 1
FORMATS = {".png": ("PNG", "8"), ".exr": ("OPEN_EXR", "32")}


def main() -> None:
    parser = argparse.ArgumentParser(prog="render_to_file.py", allow_abbrev=False, add_help=False)
    parser.add_argument("--output", type=Path, nargs="?")
    # The other options are the add-on's.
    output = parser.parse_known_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])[0].output
    if output is None:
        leave("name the picture to write: -- --output OUT.png")
    out = output.expanduser().absolute()
    ending = out.suffix.lower()
    if ending not in FORMATS:
        leave(f'"{out.name}": the name must end in {" or ".join(FORMATS)}')
    if not out.parent.is_dir():
        leave(f'cannot write "{out}": there is no folder "{out.parent}"')

    scene = bpy.context.scene
    try:
        scene.render.engine = "AJAR"
    except TypeError:
        leave("the add-on ajar_render is not enabled")
    image_settings = scene.render.image_settings
    image_settings.file_format, image_settings.color_depth = FORMATS[ending]
    if ending == ".exr":
        image_settings.color_mode = "RGBA"
        image_settings.exr_codec = "ZIP"
    scene.render.use_file_extension = False
    scene.render.filepath = str(out)
    pictures = [out]
    if scene.render.use_multiview and image_settings.views_format == "INDIVIDUAL":   # Blender writes a file for each view
        pictures = [out.with_name(f"{out.stem}{view.file_suffix}{out.suffix}") for view in scene.render.views if view.use and (
            scene.render.views_format == "MULTIVIEW" or view.name in ("left", "right"))]
    written_before = {picture: picture.stat().st_mtime_ns for picture in pictures if picture.exists()}
    try:
        bpy.ops.render.render(write_still=True)
    except RuntimeError as error:
        leave(str(error).strip().removeprefix("Error: "))
    for picture in pictures:
        if not picture.exists() or picture.stat().st_mtime_ns == written_before.get(picture):
            leave(f'"{picture}" was not written')
    from ajar_render import last_render

    found = last_render.of(scene) or {}
    size = "{} x {}".format(*found.get("resolution", (0, 0)))
    print(f"\nThe picture is in {', '.join(map(str, pictures))}: {size} pixels, {found.get('samples_per_pixel', {}).get('mean', 0):.0f} samples a pixel in {found.get('render_seconds', 0):.0f} s.")


def leave(message: str) -> None:
    """End Blender with a message and an exit code. An exception in a script would not set an exit code."""
    print(f"Ajar: error: {message}", file=sys.stderr)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(EXIT_FAILED)


main()
