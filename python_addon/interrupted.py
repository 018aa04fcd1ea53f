"""Animations that were stopped while a frame was written. With Overwrite switched off, Blender skips every frame whose file exists, even if the file is
not complete. Before a render from the command line, such files are removed, so that their frames are rendered again."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.app.handlers import persistent

from . import headless
from .ajar_module import ajar

PNG_END, JPEG_END = b"IEND\xaeB`\x82", b"\xff\xd9"
TAIL_BYTES = 64


def is_damaged(path: Path, has_placeholders: bool) -> bool:
    """Whether the file is the beginning of a picture only. An empty file is a placeholder of a render that another process may be doing."""
    size = path.stat().st_size
    if size == 0:
        return not has_placeholders
    if path.suffix.lower() in (".png", ".jpg", ".jpeg"):
        with path.open("rb") as file:
            file.seek(max(0, size - TAIL_BYTES))
            return (PNG_END if path.suffix.lower() == ".png" else JPEG_END) not in file.read()
    if path.suffix.lower() == ".exr":
        try:
            ajar.read_channels(str(path))
        except (OSError, RuntimeError, ValueError):
            return True
    return False


def remove_damaged(scene: bpy.types.Scene) -> list[Path]:
    """Remove the incomplete files of the frames of the animation."""
    render, removed = scene.render, []
    for frame in range(scene.frame_start, scene.frame_end + 1, max(1, scene.frame_step)):
        path = Path(bpy.path.abspath(render.frame_path(frame=frame)))
        if path.is_file() and is_damaged(path, render.use_placeholder):
            path.unlink()
            removed.append(path)
    return removed


@persistent
def _before(scene: bpy.types.Scene, *_) -> None:
    if scene.render.engine == "AJAR" and not scene.render.use_overwrite and not scene.render.is_movie_format and headless.renders_from_command_line():
        for path in remove_damaged(scene):
            print(f"Ajar: {path} is not complete; its frame is rendered again", flush=True)


def register() -> None:
    bpy.app.handlers.render_init.append(_before)


def unregister() -> None:
    bpy.app.handlers.render_init.remove(_before)
