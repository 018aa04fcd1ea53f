"""A view of a plane from x, y = 0 to 1 whose pixels are single points, as OpenEXR. Also used by tests/compatibility/images_inside.py."""

from pathlib import Path

import bpy
import numpy as np


def look_at_plane(scene: bpy.types.Scene, size: int) -> None:
    """Let the scene's camera see the plane in `size` x `size` pixels, each by one sample at its centre, in both engines."""
    scene.camera.location, scene.camera.data.type, scene.camera.data.ortho_scale = (0.5, 0.5, 3.0), "ORTHO", 1.0
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.cycles.samples = scene.ajar.samples = 1
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", 0.01
    scene.render.use_compositing = scene.render.use_sequencer = False
    image = scene.render.image_settings
    if hasattr(image, "media_type"):   # 5.0
        image.media_type = "IMAGE"
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGBA", "32"


def render(scene: bpy.types.Scene, engine: str, folder: Path) -> np.ndarray:
    """The colours of the pixels, rows from the bottom up."""
    scene.render.engine, scene.render.filepath = engine, str(folder / "picture.exr")
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(scene.render.filepath)
    picture.colorspace_settings.name = "Non-Color"
    pixels = np.empty(len(picture.pixels), dtype=np.float32)
    picture.pixels.foreach_get(pixels)
    bpy.data.images.remove(picture)
    return pixels.reshape(-1, 4)[:, :3]


def difference(scene: bpy.types.Scene, folder: Path) -> tuple[float, float]:
    """The largest difference of a channel, relative where it is above 1, and the mean of the image of Cycles. Ajar emits no negative light."""
    cycles, ajar = (np.maximum(render(scene, engine, folder), 0.0) for engine in ("CYCLES", "AJAR"))
    return float((np.abs(cycles - ajar) / np.maximum(cycles, 1.0)).max()), float(cycles.mean())
