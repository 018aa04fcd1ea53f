"""Settings of Ajar, stored in the .blend.

A setting that was not changed has the value of the same setting of Cycles, if any setting of Cycles was set in the scene, so that unmodified scenes
render in the same way. The user interface shows the effective value.
"""

# No `from __future__ import annotations`: Blender needs the annotations as objects, not as text.

import bpy

from . import compat, data_properties, hints, inherited
from .ajar_module import ajar

# The numbers are stored in files and must not change.
INTEGRATOR_NUMBERS = {"auto": 0, "path": 1, "pmc_pt": 2, "erpt": 3, "mps": 4, "metropolis": 5, "photon_map": 6, "bdpt": 7,
                      "irradiance_cache": 8}
DIRECT_NUMBERS = {"mis": 0, "bsdf": 1, "light": 2, "ris": 3, "correlated": 4, "pmc_hi": 5, "ocv": 6, "ocv_paper": 7,
                  "ocv_progressive": 8, "mis_balance": 9, "pmc_hi_paper": 10}
DIRECT_ITEMS = [(info.name, info.label, info.sentence + (" Biased" if info.biased else ""), DIRECT_NUMBERS[info.name])
                for info in ajar.direct_method_list() if info.name in DIRECT_NUMBERS]
FILTER_ITEMS = [
    ("BOX", "Box", "The square of the pixel", 0),
    ("GAUSSIAN", "Gaussian", "Soft", 1),
    ("BLACKMAN_HARRIS", "Blackman-Harris", "Soft, with more contrast at edges", 2),
]

# Blender has the last one since 5.0.
CURVE_SHAPES = [("RIBBONS", "Rounded Ribbons", "Flat, with the shading of a tube. Fast", 0), ("THICK", "3D Curves", "Tubes along smooth curves", 1),
                ("THICK_LINEAR", "Linear 3D Curves", "Tubes of straight pieces", 2)]


def integrator_items() -> list[tuple[str, str, str, int]]:
    """The integrators of this build."""
    return [(info.name, info.label, info.sentence, INTEGRATOR_NUMBERS[info.name])
            for info in ajar.integrator_list() if info.name in INTEGRATOR_NUMBERS]


# Name -> relative mean squared error. The percentage that artists see is its square root.
NOISE_LEVELS = {"OFF": 0.0, "DRAFT": 1e-2, "GOOD": 1e-3, "CLEAN": 1e-4, "FINAL": 2.5e-5}
NOISE_ITEMS = [("OFF", "Any", "The noise does not end the render", 0), ("DRAFT", "Draft", "10 %: for a first look", 1),
               ("GOOD", "Good", "3 %: little grain, or clean after denoising", 2), ("CLEAN", "Clean", "1 %: no grain at normal size", 3),
               ("FINAL", "Final", "0.5 %: no grain in close-ups", 4), ("CUSTOM", "Custom", "The number below", 5)]


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


class AjarSceneSettings(bpy.types.PropertyGroup):
    use_cycles_settings: bpy.props.BoolProperty(
        name="Use Cycles' Settings", description="Settings that were not changed in Ajar have the value that the scene has for Cycles. They are shown in grey",
        get=_get_use_cycles_settings, set=_set_use_cycles_settings)
    show_advanced: bpy.props.BoolProperty(name="Advanced", description="Show methods that exist only for comparison. No scene renders faster with them", default=False)
    use_checkpoint: bpy.props.BoolProperty(
        name="Checkpoint", description="Save the samples in a file during the render, so that a render that was stopped can continue", default=False)
    checkpoint_path: bpy.props.StringProperty(name="File", description="File of the checkpoint. The number of the frame is added to its name", default="//ajar.checkpoint", subtype="FILE_PATH")
    checkpoint_interval: bpy.props.IntProperty(name="Every", description="Seconds between two checkpoints", default=30, min=1, max=86400, subtype="TIME_ABSOLUTE")
    use_resume: bpy.props.BoolProperty(
        name="Resume", description="Continue from the checkpoint of this frame, if there is one. Its samples count towards the number of samples", default=False)
    integrator: bpy.props.EnumProperty(name="Integrator", description="Rendering technique of the final render", items=integrator_items(),
                                       default="auto")
    direct: bpy.props.EnumProperty(name="Direct Light", description="How direct light is sampled",
                                   items=DIRECT_ITEMS, default="mis")
    direct_samples: bpy.props.IntProperty(name="Direct Samples", description="Direct light samples at each surface that the camera sees",
                                          default=1, min=1, max=256)
    guiding: bpy.props.EnumProperty(
        name="Path Guiding", description="Learn where light comes from during the render, and send more paths there", default="off",
        items=[("off", "Off", "Directions come from the materials only", 0),
               ("on", "On", "Directions come from the materials and from what earlier samples found", 1),
               ("auto", "Automatic", "Measure in the first 16 samples whether guiding reduces the noise", 2)])
    carry_learning: bpy.props.BoolProperty(
        name="Carry Learning", description="Each frame of an animation starts with what earlier frames have learned. Does not change the mean of the picture",
        default=True)
    vertex_merging: bpy.props.EnumProperty(
        name="Vertex Merging", description="Render caustics that are seen in mirrors and through glass with photons. No other light path reaches them",
        default="on",
        items=[("off", "Off", "Path tracing finds them rarely, as very bright pixels. Unbiased", 0),
               ("on", "On", "From photons, whose blur shrinks as the render goes on. Consistent", 1)])
    image: bpy.props.EnumProperty(
        name="Image Sampling", description="How samples are distributed over the pixels", default="uniform",
        items=[("uniform", "Uniform", "All pixels get the same number of samples", 0),
               ("pmc_ip", "Adaptive (PMC-IP)", "Noisy pixels get more samples", 1)])
    image_error: bpy.props.EnumProperty(
        name="Noise Measure", description="Which error adaptive sampling reduces", default="relative",
        items=[("relative", "Relative Error", "Relative to the brightness of each pixel", 0),
               ("perceptual", "Visible Error", "Relative to the smallest difference that an eye can see", 1)])
    importance_factor: bpy.props.FloatProperty(
        name="Region Importance", description="Pixels in the region get this many times more samples. Does not change the mean of the picture", default=1.0, min=0.0, soft_max=10.0)
    importance_min: bpy.props.FloatVectorProperty(name="Region From", description="Lower left corner of the region, as a fraction of the frame", size=2,
                                                  default=(0.0, 0.0), min=0.0, max=1.0)
    importance_max: bpy.props.FloatVectorProperty(name="To", description="Upper right corner of the region, as a fraction of the frame", size=2,
                                                  default=(1.0, 1.0), min=0.0, max=1.0)
    samples: inherited.integer("samples", "Samples", "Samples per pixel", 64, "samples", 1, 2**24)
    use_denoise: inherited.boolean(
        "use_denoise", "Denoise", "Remove the remaining noise with Blender's Open Image Denoise when the render is done. The noisy picture is kept as a pass. Biased",
        False, "use_denoising")
    use_viewport_denoise: bpy.props.BoolProperty(
        name="Denoise Viewport", description="Denoise the rendered 3D view whenever the number of samples has doubled. Biased", default=False)
    viewport_samples: inherited.integer("viewport_samples", "Viewport Samples", "Samples per pixel in the rendered 3D view", 1024, "preview_samples",
                           1, 2**24)
    viewport_integrator: bpy.props.EnumProperty(name="Viewport Integrator", description="Rendering technique of the rendered 3D view",
                                                items=integrator_items(), default="path")
    time_limit: inherited.number("time_limit", "Time Limit", "Stop after this time, which includes denoising. 0 for no limit", 0.0, "time_limit", 0.0, 1e7,
                       subtype="TIME_ABSOLUTE")
    noise_target: bpy.props.FloatProperty(
        name="Noise Target", description="Stop when the estimated relative mean squared error is below this. 0 for never", default=0.0, min=0.0, max=1.0, precision=5,
        step=0.1, **inherited.accessors("noise_target", 0.0, "adaptive_threshold", read=inherited.noise_of_cycles))
    noise_level: bpy.props.EnumProperty(name="Noise", description="Noise at which the render stops", items=NOISE_ITEMS, get=_get_noise_level, set=_set_noise_level)
    seed: inherited.integer("seed", "Seed", "A different seed gives a different noise pattern", 0, "seed", 0, 2**31 - 1)
    bounces_total: inherited.integer("bounces_total", "Total", "Maximum number of bounces of all kinds together", 12, "max_bounces", 0, 1024)
    bounces_diffuse: inherited.integer("bounces_diffuse", "Diffuse", "Maximum number of diffuse bounces", 4, "diffuse_bounces", 0, 1024)
    bounces_glossy: inherited.integer("bounces_glossy", "Glossy", "Maximum number of glossy bounces", 4, "glossy_bounces", 0, 1024)
    bounces_transmission: inherited.integer("bounces_transmission", "Transmission", "Maximum number of bounces through glass", 12, "transmission_bounces", 0, 1024)
    bounces_transparent: inherited.integer("bounces_transparent", "Transparent", "Transparent surfaces that a path may cross", 8, "transparent_max_bounces", 0, 1024)
    bounces_volume: inherited.integer("bounces_volume", "Volume", "Maximum number of bounces in volumes. 0 scatters light once", 0, "volume_bounces", 0, 1024)
    clamp_direct: inherited.number("clamp_direct", "Clamp Direct", "Maximum brightness of a direct light sample. A limit darkens the picture. 0 for no limit", 0.0, "sample_clamp_direct", 0.0, 1e8)
    clamp_indirect: inherited.number("clamp_indirect", "Clamp Indirect", "Maximum brightness of an indirect light sample. A limit darkens the picture. 0 for no limit", 0.0,
                           "sample_clamp_indirect", 0.0, 1e8)
    reflective_caustics: inherited.boolean("reflective_caustics", "Reflective Caustics", "Light reflected by glossy surfaces onto diffuse surfaces", True,
                               "caustics_reflective")
    refractive_caustics: inherited.boolean("refractive_caustics", "Refractive Caustics", "Light refracted by glass onto diffuse surfaces", True,
                               "caustics_refractive")
    filter: bpy.props.EnumProperty(
        name="Pixel Filter", description="How samples near a pixel are weighted", items=FILTER_ITEMS, default="BLACKMAN_HARRIS",
        **inherited.accessors("filter", "BLACKMAN_HARRIS", "pixel_filter_type", {item[0]: item[3] for item in FILTER_ITEMS}))
    filter_width: inherited.number("filter_width", "Width", "Full width of the filter in pixels", 1.5, "filter_width", 0.01, 10.0)
    gather_rays: bpy.props.IntProperty(name="Gather Rays", description="Rays per sample that look up the photon map from the first rough surface. The irradiance cache uses ten times as many per record",
                                       default=8, min=1, max=1024)
    photons: bpy.props.IntProperty(name="Photons", description="Photons emitted per sample of the picture. 0 to choose by the size of the picture",
                                   default=0, min=0, max=10**8)
    photon_radius: bpy.props.FloatProperty(name="Photon Radius", description="Radius of the first pass. 0 to choose it from the photon density",
                                           default=0.0, min=0.0, subtype="DISTANCE")
    memory_limit: bpy.props.IntProperty(
        name="Memory Limit (MiB)", description="Refuse to start a render that needs more memory, and report what needs most. 0 for no limit",
        default=0, min=0, max=2**31 - 1)
    show_photons: bpy.props.BoolProperty(
        name="Show Photons", description="After a render, or while a view is rendered, draw the photons of the last pass as points in the 3D views",
        default=False, update=lambda self, context: hints.redraw_views(context))
    show_sample_density: bpy.props.BoolProperty(
        name="Sample Density", description="Show how many samples each pixel has, from dark (fewest) to bright (most). It can be switched on while a render runs", default=False)
    hint_collection: bpy.props.StringProperty(name="Light Hints", description="Collection whose curves show where light goes",
                                              default="Light Hints")
    motion_blur_position: inherited.enum(
        "motion_blur_position", "Position", "When the shutter opens, relative to the frame", "CENTER", "motion_blur_position",
        [("START", "Start on Frame", "The shutter opens at the frame", 0), ("CENTER", "Center on Frame", "The shutter is half open at the frame", 1),
         ("END", "End on Frame", "The shutter closes at the frame", 2)])
    curve_shape: inherited.enum(
        "curve_shape", "Shape", "How hair and curves are shown", "RIBBONS", "shape", CURVE_SHAPES, group="cycles_curves")
    curve_subdivisions: inherited.integer("curve_subdivisions", "Curve Subdivisions", "Subdivisions of each segment of a ribbon", 2, "subdivisions", 0, 24,
                                          group="cycles_curves")
    exposure: inherited.number("exposure", "Exposure", "Brightness multiplier", 1.0, "film_exposure", 0.0, 10.0)


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
    use_pass_sample_count: bpy.props.BoolProperty(name="Sample Count", description="Samples that each pixel received")
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
