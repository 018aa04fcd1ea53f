"""A view of a plane from x, y = 0 to 1 whose pixels are single points, as OpenEXR. Also used by tests/compatibility/images_inside.py."""

import bpy


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
