"""Images of texture nodes. Files are exported as paths, packed files as bytes, painted and generated images as pixels."""

from __future__ import annotations

import os

import bpy
import numpy as np

from .. import compat, plain
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
    color_space = "Non-Color" if image.colorspace_settings.is_data else image.colorspace_settings.name
    tiled = image.source == "TILED" and not _has_pixels(image)
    path = "" if tiled else _path(image, image_user)
    frame = image_user.frame_current if image_user is not None and image.source == "MOVIE" else 0
    key = (image.as_pointer(), path, color_space, image.alpha_mode, frame)
    if key not in context.images:
        context.check_cancelled()
        if image.source == "MOVIE" and context.meshes is None:
            _load_frame(image, frame)
        context.images[key] = _add_tiles(context, image, color_space) if tiled else _add(context, image, path, color_space)
    return context.images[key]


def export_color_spaces(context: ExportContext) -> None:
    """The OpenColorIO configuration and the working space, which give all colours their meaning."""
    context.description.set_color_spaces(*compat.color_spaces())


def _load_frame(image: bpy.types.Image, frame: int) -> None:
    """Let Blender decode a frame of a movie, whose pixels the image then has. Only textures can ask for one."""
    texture = bpy.data.textures.new(".ajar", "IMAGE")
    try:
        texture.image = image
        texture.image_user.use_auto_refresh = False
        texture.image_user.frame_current = frame
        texture.evaluate((0.0, 0.0, 0.0))
    finally:
        bpy.data.textures.remove(texture)


def _has_pixels(image: bpy.types.Image) -> bool:
    """Whether the pixels in memory are the only or the newest ones, or, of packed files, those that Cycles uses."""
    if image.source == "TILED":
        return False
    return image.source in ("GENERATED", "MOVIE") or image.is_dirty or (
        (image.is_float or image.alpha_mode == "PREMUL") and compat.packed_bytes(image) != b"")


def _alpha_mode(image: bpy.types.Image) -> ajar.AlphaMode:
    """The alpha mode of a file. Since 5.2, Cycles follows that of the image; before, the file decides whether it is multiplied by alpha."""
    if compat.image_decides_about_alpha() and image.alpha_mode in ("STRAIGHT", "PREMUL"):
        return ajar.AlphaMode.AlwaysStraight if image.alpha_mode == "STRAIGHT" else ajar.AlphaMode.AlwaysPremultiplied
    return _ALPHA_MODES[image.alpha_mode]


def _alpha_mode_of_pixels(image: bpy.types.Image) -> ajar.AlphaMode:
    """Blender stores float pixels multiplied by alpha, and bytes straight. Cycles 5.2 multiplies both if the mode is Straight, float pixels twice."""
    if image.alpha_mode not in ("STRAIGHT", "PREMUL") or compat.image_decides_about_alpha():
        return _ALPHA_MODES[image.alpha_mode]
    return ajar.AlphaMode.Premultiplied if image.is_float else ajar.AlphaMode.Straight


def _add(context: ExportContext, image: bpy.types.Image, path: str, color_space: str) -> int:
    if _has_pixels(image):
        width, height = image.size
        if width > 0 and height > 0 and image.channels > 0:
            pixels = np.empty(width * height * 4, dtype=np.float32)
            image.pixels.foreach_get(pixels)
            # Blender stores float pixels in the linear space of the scene, for all file formats.
            if image.is_float and color_space != "Non-Color":
                color_space = "scene_linear"
            return context.description.add_image(name=image.name, alpha_mode=_alpha_mode_of_pixels(image), pixels=pixels, width=width, height=height,
                                                 color_space=color_space, **_size_of_textures(context))
    packed = compat.packed_bytes(image)
    return context.description.add_image(name=image.name, alpha_mode=_alpha_mode(image), path="" if packed else path, packed=packed, color_space=color_space,
                                         **_size_of_textures(context))


def _size_of_textures(context: ExportContext) -> dict[str, float]:
    """What Simplify leaves of images."""
    if not context.scene.render.use_simplify:
        return {}
    ours = plain.of(context.scene.ajar)
    limit, resolution = (ours.texture_limit, ours.texture_resolution) if context.is_view else (ours.texture_limit_render, ours.texture_resolution_render)
    return {"size_limit": 0 if limit == "OFF" else int(limit), "resolution": resolution}


def _add_tiles(context: ExportContext, image: bpy.types.Image, color_space: str) -> int:
    """An image of tiles (UDIM): one image for each tile, and one that lists them."""
    if image.is_dirty:
        context.warn(image.name, "it has unsaved changes: the files of its tiles are used")
    packed = compat.packed_tiles(image)
    path = _absolute(image, image.filepath)
    tiles = []
    for tile in image.tiles:
        column, row = (tile.number - 1001) % 10, (tile.number - 1001) // 10
        of_tile = path.replace("<UDIM>", str(tile.number)).replace("<UVTILE>", f"u{column + 1}_v{row + 1}")
        content = packed.get(tile.number, b"")
        tiles.append((tile.number, context.description.add_image(
            name=f"{image.name} {tile.number}", path="" if content else of_tile, packed=content, color_space=color_space,
            alpha_mode=_alpha_mode(image), **_size_of_textures(context))))
    return context.description.add_tiled_image(image.name, tiles)


def _path(image: bpy.types.Image, image_user: bpy.types.ImageUser | None) -> str:
    if not image.filepath:
        return ""
    if image_user is not None and image.source in ("SEQUENCE", "MOVIE"):
        return _absolute(image, image.filepath_from_user(image_user=image_user))
    return _absolute(image, image.filepath)


def _absolute(image: bpy.types.Image, path: str) -> str:
    return os.path.normpath(bpy.path.abspath(path, library=image.library)) if path else ""
