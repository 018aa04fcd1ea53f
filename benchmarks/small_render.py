"""The settings of a render that shows how long an engine prepares a scene: few pixels, one sample. For Python inside Blender."""

import bpy

LONGEST = 16   # pixels of the longer side


def make_small(scene: bpy.types.Scene) -> None:
    render = scene.render
    scale = LONGEST / max(render.resolution_x, render.resolution_y)
    render.resolution_percentage = 100
    render.resolution_x, render.resolution_y = (max(4, round(size * scale)) for size in (render.resolution_x, render.resolution_y))
    render.use_compositing = render.use_sequencer = render.use_border = False
    scene.cycles.samples, scene.cycles.device = 1, "CPU"
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.ajar.use_cycles_settings, scene.ajar.integrator, scene.ajar.samples, scene.ajar.use_denoise = True, "path", 1, False
    for layer in scene.view_layers:
        layer.use = layer == bpy.context.view_layer
