"""Settings of Ajar, stored in the .blend.

A setting that was not changed has the value of the same setting of Cycles, if any setting of Cycles was set in the scene, so that unmodified scenes
render in the same way. The user interface shows the effective value. The table of the core defines the settings of the core (core_settings.py).
"""

# No `from __future__ import annotations`: Blender needs the annotations as objects, not as text.

import bpy

from . import compat, core_settings, data_properties, hints, inherited

# Blender has the last one since 5.0.
CURVE_SHAPES = [("RIBBONS", "Rounded Ribbons", "Flat, with the shading of a tube. Fast", 0), ("THICK", "3D Curves", "Tubes along smooth curves", 1),
                ("THICK_LINEAR", "Linear 3D Curves", "Tubes of straight pieces", 2)]


# Name -> relative mean squared error. The percentage that artists see is its square root.
NOISE_LEVELS = {"OFF": 0.0, "DRAFT": 1e-2, "GOOD": 1e-3, "CLEAN": 1e-4, "FINAL": 2.5e-5}
NOISE_ITEMS = [("OFF", "Any", "The noise does not end the render", 0), ("DRAFT", "Draft", "10 %: for a first look", 1),
               ("GOOD", "Good", "3 %: little grain", 2), ("CLEAN", "Clean", "1 %: no grain at normal size", 3),
               ("FINAL", "Final", "0.5 %: no grain in close-ups", 4), ("CUSTOM", "Custom", "The number below", 5)]

BAKE_TYPES = [   # with the numbers that they have in Blender
    ("COMBINED", "Combined", "Light that leaves the surface, in the parts that are switched on", 0),
    ("AO", "Ambient Occlusion", "How open the surface is", 1),
    ("POSITION", "Position", "Places in world space", 3),
    ("NORMAL", "Normal", "Normals, bent by bumps", 4),
    ("UV", "UV", "Coordinates of the UV map", 5),
    ("ROUGHNESS", "Roughness", "The mean roughness of the surface", 6),
    ("EMIT", "Emit", "Light that the surface emits", 7),
    ("ENVIRONMENT", "Environment", "The world in the direction of each place from the origin", 8),
    ("DIFFUSE", "Diffuse", "Light that the surface scatters diffusely", 9),
    ("GLOSSY", "Glossy", "Light that the surface reflects", 10),
    ("TRANSMISSION", "Transmission", "Light that the surface lets through", 11),
]


def _get_noise_level(settings: bpy.types.PropertyGroup) -> int:
    target = settings.noise_target
    return next((i for i, level in enumerate(NOISE_LEVELS.values()) if abs(target - level) <= 1e-3 * level), len(NOISE_LEVELS))


def _set_noise_level(settings: bpy.types.PropertyGroup, number: int) -> None:
    if number < len(NOISE_LEVELS):
        settings.noise_target = list(NOISE_LEVELS.values())[number]


def _get_use_cycles_settings(settings: bpy.types.PropertyGroup) -> bool:
    stored = settings.get("use_cycles_settings_")
    return compat.has_cycles_settings(settings.id_data) if stored is None else bool(stored)


def _set_use_cycles_settings(settings: bpy.types.PropertyGroup, value: bool) -> None:
    settings["use_cycles_settings_"] = value


TEXTURE_LIMITS = [("OFF", "No Limit", "Textures keep the size of their images", 0),
                  *((str(size), str(size), "Larger images are halved until they have no more texels along a side", number) for number, size in
                    enumerate((128, 256, 512, 1024, 2048, 4096, 8192), 1))]


class AjarSceneSettings(bpy.types.PropertyGroup):
    use_cycles_settings: bpy.props.BoolProperty(
        name="Use Cycles' Settings", description="Settings that were not changed in Ajar have the value that the scene has for Cycles. They are shown in grey",
        get=_get_use_cycles_settings, set=_set_use_cycles_settings)
    show_advanced: bpy.props.BoolProperty(name="Advanced", description="Show methods that exist only for comparison. No scene renders faster with them", default=False)
    use_checkpoint: bpy.props.BoolProperty(
        name="Checkpoint", description="Save the samples in a file during the render, so that a render that was stopped can continue", default=False)
    checkpoint_path: bpy.props.StringProperty(name="File", description="File of the checkpoint. The number of the frame is added to its name", default="//ajar.checkpoint", subtype="FILE_PATH")
    checkpoint_interval: bpy.props.FloatProperty(
        name="Every", description="Seconds between two checkpoints", default=30.0, min=1.0, max=86400.0, precision=0, step=100, subtype="TIME_ABSOLUTE")
    use_resume: bpy.props.BoolProperty(
        name="Resume", description="Continue from the checkpoint of this frame, if there is one. Its samples count towards the number of samples", default=False)
    integrator: core_settings.definition("integrator")
    direct: core_settings.definition("direct")
    direct_samples: core_settings.definition("direct_samples")
    guiding: core_settings.definition("guiding")
    carry_learning: bpy.props.BoolProperty(
        name="Carry Learning", description="Each frame of an animation starts with what earlier frames have learned. Does not change the mean of the picture",
        default=True)
    vertex_merging: core_settings.definition("vertex_merging")
    image: core_settings.definition("image")
    image_error: core_settings.definition("image_error")
    importance_factor: core_settings.definition("importance_factor")
    importance_min: bpy.props.FloatVectorProperty(name="Region From", description="Lower left corner of the region, as a fraction of the frame", size=2,
                                                  default=(0.0, 0.0), min=0.0, max=1.0)
    importance_max: bpy.props.FloatVectorProperty(name="To", description="Upper right corner of the region, as a fraction of the frame", size=2,
                                                  default=(1.0, 1.0), min=0.0, max=1.0)
    samples: core_settings.definition("samples", "samples")
    use_denoise: inherited.boolean(
        "use_denoise", "Denoise", "Remove the remaining noise with Open Image Denoise when the render is done. The noisy picture is kept as a pass. Consistent",
        False, "use_denoising")
    use_viewport_denoise: inherited.boolean(
        "use_viewport_denoise", "Denoise Viewport", "Denoise the rendered 3D view whenever the number of samples has doubled. Consistent",
        False, "use_preview_denoising")
    viewport_samples: inherited.integer("viewport_samples", "Viewport Samples", "Samples per pixel in the rendered 3D view", 1024, "preview_samples",
                           1, 2**24)
    viewport_integrator: bpy.props.EnumProperty(name="Viewport Integrator", description="Rendering technique of the rendered 3D view",
                                                items=core_settings.integrator_items(), default="auto")
    time_limit: core_settings.definition("time_limit", "time_limit")
    noise_target: core_settings.definition(
        "noise_target", precision=5, step=0.1, **inherited.accessors("noise_target", 0.0, "adaptive_threshold", read=inherited.noise_of_cycles))
    noise_level: bpy.props.EnumProperty(name="Noise", description="Noise at which the render stops", items=NOISE_ITEMS, get=_get_noise_level, set=_set_noise_level)
    seed: core_settings.definition("seed", "seed")
    bounces_total: core_settings.definition("bounces_total", "max_bounces")
    bounces_diffuse: core_settings.definition("bounces_diffuse", "diffuse_bounces")
    bounces_glossy: core_settings.definition("bounces_glossy", "glossy_bounces")
    bounces_transmission: core_settings.definition("bounces_transmission", "transmission_bounces")
    bounces_transparent: core_settings.definition("bounces_transparent", "transparent_max_bounces")
    bounces_volume: core_settings.definition("bounces_volume", "volume_bounces")
    clamp_direct: core_settings.definition("clamp_direct", "sample_clamp_direct")
    clamp_indirect: core_settings.definition("clamp_indirect", "sample_clamp_indirect")
    reflective_caustics: core_settings.definition("reflective_caustics", "caustics_reflective")
    refractive_caustics: core_settings.definition("refractive_caustics", "caustics_refractive")
    filter: core_settings.definition("filter", "pixel_filter_type", capitals=True)
    filter_width: core_settings.definition("filter_width", "filter_width")
    gather_rays: core_settings.definition("gather_rays")
    photons: core_settings.definition("photons")
    photon_radius: core_settings.definition("photon_radius")
    memory_limit: core_settings.definition("memory_limit")
    compact_bvh: core_settings.definition("compact_bvh")
    use_texture_cache: core_settings.definition("use_texture_cache")
    use_auto_generate_texture_cache: core_settings.definition("use_auto_generate_texture_cache")
    texture_cache_directory: bpy.props.StringProperty(
        name="Folder", description="Folder of the texture cache. If it is empty, the files are beside the images. Images without a file of their own need a folder", default="",
        subtype="DIR_PATH")
    texture_cache_size: core_settings.definition("texture_cache_size")
    show_photons: bpy.props.BoolProperty(
        name="Show Photons", description="After a render, or while a view is rendered, draw the photons of the last pass as points in the 3D views",
        default=False, update=lambda self, context: hints.redraw_views(context))
    show_sample_density: bpy.props.BoolProperty(
        name="Sample Density", description="Show how many samples each pixel has, from dark (fewest) to bright (most). It can be switched on while a render runs", default=False)
    hint_collection: bpy.props.StringProperty(name="Light Hints", description="Collection whose curves show where light goes",
                                              default="Light Hints")
    rolling_shutter_type: inherited.enum(
        "rolling_shutter_type", "Shutter Type", "How the rows of the picture are exposed", "NONE", "rolling_shutter_type",
        [("NONE", "None", "All rows together", 0), ("TOP", "Top-Bottom", "One row after another, from the top to the bottom", 1)])
    rolling_shutter_duration: inherited.number(
        "rolling_shutter_duration", "Rolling Shutter Duration", "Part of the time of the open shutter during which one row is exposed", 0.1,
        "rolling_shutter_duration", 0.0, 1.0)
    motion_blur_position: inherited.enum(
        "motion_blur_position", "Position", "When the shutter opens, relative to the frame", "CENTER", "motion_blur_position",
        [("START", "Start on Frame", "The shutter opens at the frame", 0), ("CENTER", "Center on Frame", "The shutter is half open at the frame", 1),
         ("END", "End on Frame", "The shutter closes at the frame", 2)])
    use_camera_cull: inherited.boolean("use_camera_cull", "Camera Cull", "Leave out objects outside the view of the camera, if they allow it", False, "use_camera_cull")
    camera_cull_margin: inherited.number("camera_cull_margin", "Margin", "Margin around the frame in which objects stay, as a fraction of the frame", 0.1,
                                         "camera_cull_margin", 0.0, 5.0)
    use_distance_cull: inherited.boolean("use_distance_cull", "Distance Cull", "Leave out objects far from the camera, if they allow it", False, "use_distance_cull")
    distance_cull_margin: inherited.number("distance_cull_margin", "Distance", "Distance from the camera beyond which objects are left out", 50.0,
                                           "distance_cull_margin", 0.0, 1e9, subtype="DISTANCE")
    texture_limit: inherited.enum("texture_limit", "Viewport Limit", "Most texels along the longer side of a texture, in the rendered 3D view", "OFF", "texture_limit", TEXTURE_LIMITS)
    texture_limit_render: inherited.enum("texture_limit_render", "Render Limit", "Most texels along the longer side of a texture, in final renders", "OFF",
                                         "texture_limit_render", TEXTURE_LIMITS)
    texture_resolution: inherited.number("texture_resolution", "Viewport Resolution", "Part of the sides of images that textures keep in the rendered 3D view, rounded down "
                                         "to a half, a quarter and so on", 1.0, "texture_resolution", 1e-5, 1.0)
    texture_resolution_render: inherited.number("texture_resolution_render", "Render Resolution", "Part of the sides of images that textures keep in final renders, rounded "
                                                "down to a half, a quarter and so on", 1.0, "texture_resolution_render", 1e-5, 1.0)
    curve_shape: inherited.enum(
        "curve_shape", "Shape", "How hair and curves are shown", "RIBBONS", "shape", CURVE_SHAPES, group="cycles_curves")
    curve_subdivisions: inherited.integer("curve_subdivisions", "Curve Subdivisions", "Subdivisions of each segment of a ribbon", 2, "subdivisions", 0, 24,
                                          group="cycles_curves")
    exposure: core_settings.definition("exposure", "film_exposure")
    transparent_glass: core_settings.definition("transparent_glass", "film_transparent_glass")
    transparent_glass_roughness: core_settings.definition("transparent_glass_roughness", "film_transparent_roughness")
    dicing_rate: inherited.number("dicing_rate", "Dicing Rate", "Size of the triangles of adaptive subdivision in pixels, in final renders", 1.0, "dicing_rate", 0.1, 1000.0)
    preview_dicing_rate: inherited.number("preview_dicing_rate", "Viewport Dicing Rate", "Size of the triangles of adaptive subdivision in pixels, in the rendered 3D view",
                                          8.0, "preview_dicing_rate", 0.1, 1000.0)
    offscreen_dicing_scale: inherited.number("offscreen_dicing_scale", "Offscreen Scale", "How much larger the triangles become with the distance from the camera's view", 4.0,
                                             "offscreen_dicing_scale", 1.0, 1e6)
    max_subdivisions: inherited.integer("max_subdivisions", "Max Subdivisions", "An edge is halved at most this many times", 12, "max_subdivisions", 0, 16)
    dicing_camera: bpy.props.PointerProperty(
        name="Dicing Camera", description="Camera whose pixels adaptive subdivision follows. Without one, that of the scene", type=bpy.types.Object,
        poll=lambda self, thing: thing.type == "CAMERA")
    bake_type: inherited.enum("bake_type", "Bake Type", "What is baked", "COMBINED", "bake_type", BAKE_TYPES)


class AjarShadingSettings(bpy.types.PropertyGroup):
    show_sample_density: bpy.props.BoolProperty(
        name="Sample Density", description="Show how many samples each pixel of this view has, from dark (fewest) to bright (most), instead of the picture", default=False,
        update=lambda self, context: hints.redraw_views(context))


class AjarCollectionSettings(bpy.types.PropertyGroup):
    importance: bpy.props.FloatProperty(**data_properties.IMPORTANCE)


class AjarLightGroup(bpy.types.PropertyGroup):
    """The importance of a light group of a view layer, by its name."""
    importance: bpy.props.FloatProperty(name="Importance", description="Importance of the light group that has this name", default=1.0)


def _active_light_group(settings: bpy.types.PropertyGroup) -> tuple[bpy.types.ViewLayer, str]:
    """The view layer of these settings, and the name of its active light group or an empty text."""
    layer = next(layer for layer in settings.id_data.view_layers if layer.ajar == settings)
    index = layer.active_lightgroup_index
    return layer, layer.lightgroups[index].name if 0 <= index < len(layer.lightgroups) else ""


def _get_importance(settings: bpy.types.PropertyGroup) -> float:
    group = settings.light_groups.get(_active_light_group(settings)[1])
    return group.importance if group is not None else 1.0


def _set_importance(settings: bpy.types.PropertyGroup, importance: float) -> None:
    """Set the importance. Only existing groups whose importance is not 1 are stored."""
    layer, name = _active_light_group(settings)
    kept = {group.name: group.importance for group in settings.light_groups if group.name in layer.lightgroups}
    kept[name] = importance
    settings.light_groups.clear()
    for name, importance in kept.items():
        if name and importance != 1.0:
            group = settings.light_groups.add()
            group.name, group.importance = name, importance


class AjarViewLayerSettings(bpy.types.PropertyGroup):
    light_groups: bpy.props.CollectionProperty(type=AjarLightGroup, name="Light Groups", description="Light groups of the view layer whose importance is not 1")
    light_group_importance: bpy.props.FloatProperty(
        name="Importance", description="Adaptive sampling gives a pixel this many times more samples if all its light comes from the active light group, and proportionally fewer if "
        "only a part does. Does not change the mean of the picture", default=1.0, min=0.0, soft_max=10.0, get=_get_importance, set=_set_importance)
    use_pass_albedo: bpy.props.BoolProperty(name="Albedo", description="Colour of the first surface without its light")
    use_pass_volume_direct: bpy.props.BoolProperty(name="Volume Direct", description="Light of lamps and sky that volumes scatter directly to the camera")
    use_pass_volume_indirect: bpy.props.BoolProperty(name="Volume Indirect", description="Light that volumes scatter to the camera after earlier bounces")
    use_pass_shadow_catcher: inherited.boolean("use_pass_shadow_catcher", "Shadow Catcher", "Light of shadow catchers relative to their light without other objects",
                                               False, "use_pass_shadow_catcher")
    use_pass_sample_count: bpy.props.BoolProperty(name="Sample Count", description="Samples that each pixel received")
    use_pass_render_time: inherited.boolean("use_pass_render_time", "Render Time", "Time that a processor core has spent on each pixel, in milliseconds", False, "pass_render_time")
    use_pass_denoising: bpy.props.BoolProperty(
        name="Denoising Data", description="Albedo, normal and depth for a denoiser: those of the first rough surface or volume, seen through mirrors and glass")
    use_pass_denoising_error: bpy.props.BoolProperty(
        name="Denoising Error", description="Estimated error of the denoised picture, relative to its brightness: where not to trust it. Needs Denoise")
    use_pass_variance: bpy.props.BoolProperty(name="Variance", description="Estimated variance of each pixel's mean")
    use_pass_error: bpy.props.BoolProperty(name="Error", description="Estimated standard deviation of each pixel, relative to its brightness")
    use_pass_perceptual_error: bpy.props.BoolProperty(
        name="Perceptual Error", description="Estimated standard deviation of each pixel, in units of the smallest difference that an eye can see")


CLASSES = (AjarSceneSettings, *data_properties.GROUPS.values(), AjarShadingSettings, AjarCollectionSettings, AjarLightGroup, AjarViewLayerSettings)


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(CLASSES)


def register() -> None:
    _register_classes()
    bpy.types.Scene.ajar = bpy.props.PointerProperty(type=AjarSceneSettings)
    for name, group in data_properties.GROUPS.items():
        getattr(bpy.types, name).ajar = bpy.props.PointerProperty(type=group)
    bpy.types.Collection.ajar = bpy.props.PointerProperty(type=AjarCollectionSettings)
    bpy.types.View3DShading.ajar = bpy.props.PointerProperty(type=AjarShadingSettings)
    bpy.types.ViewLayer.ajar = bpy.props.PointerProperty(type=AjarViewLayerSettings)


def unregister() -> None:
    del bpy.types.ViewLayer.ajar
    del bpy.types.View3DShading.ajar
    del bpy.types.Collection.ajar
    for name in data_properties.GROUPS:
        del getattr(bpy.types, name).ajar
    del bpy.types.Scene.ajar
    _unregister_classes()
