"""Images of texture nodes. Files are exported as paths, packed files as bytes, painted and generated images as pixels."""

from __future__ import annotations

import os

import bpy
import numpy as np

from .. import compat
from ..ajar_module import ajar
from .context import ExportContext

MISSING = -1

_ALPHA_MODES = {
    "STRAIGHT": ajar.AlphaMode.Straight,
    "PREMUL": ajar.AlphaMode.Premultiplied,
    "CHANNEL_PACKED": ajar.AlphaMode.ChannelPacked,
    "NONE": ajar.AlphaMode.None_,
}


def export(context: ExportContext, image: bpy.types.Image | None, image_user: bpy.types.ImageUser | None) -> int:
    """Index of the image at the current frame; MISSING for None. Never fails: the core reports images that it cannot read."""
    if image is None:
        return MISSING
    path = _path(image, image_user)
    color_space = image.colorspace_settings.name
    key = (image.as_pointer(), path, color_space, image.alpha_mode)
    if key not in context.images:
        context.check_cancelled()
        context.images[key] = _add(context, image, path, color_space)
    return context.images[key]


def _add(context: ExportContext, image: bpy.types.Image, path: str, color_space: str) -> int:
    common = {"name": image.name, "alpha_mode": _ALPHA_MODES[image.alpha_mode]}
    if image.source == "TILED":
        context.warn(image.name, "tiled images (UDIM) are not yet supported: the first tile is used everywhere")
    if image.source == "GENERATED" or image.is_dirty:
        width, height = image.size
        if width > 0 and height > 0 and image.channels > 0:
            pixels = np.empty(width * height * 4, dtype=np.float32)
            image.pixels.foreach_get(pixels)
            # Blender stores float pixels in the linear space of the scene and multiplied by alpha, for all file formats.
            if image.is_float and image.alpha_mode == "STRAIGHT":
                common["alpha_mode"] = ajar.AlphaMode.Premultiplied
            return context.description.add_image(
                pixels=pixels, width=width, height=height, color_space="Linear" if image.is_float else color_space, **common)
    packed = compat.packed_bytes(image)
    return context.description.add_image(path="" if packed else path, packed=packed, color_space=color_space, **common)


def _path(image: bpy.types.Image, image_user: bpy.types.ImageUser | None) -> str:
    if not image.filepath:
        return ""
    if image_user is not None and image.source in ("SEQUENCE", "MOVIE", "TILED"):
        path = image.filepath_from_user(image_user=image_user)
    else:
        path = image.filepath
    return os.path.normpath(bpy.path.abspath(path, library=image.library))
