"""Render settings of the scene. Options of the command line override them."""

from __future__ import annotations

import bpy

from .. import compat, inherited, plain, unsupported
from ..ajar_module import ajar
from ..headless import Options
from .context import ExportContext

_FILTERS = {"BOX": ajar.FilterKind.Box, "GAUSSIAN": ajar.FilterKind.Gaussian, "BLACKMAN_HARRIS": ajar.FilterKind.BlackmanHarris}

_FALLOFFS = {"QUADRATIC": 2.0, "LINEAR": 1.0, "INVERSE_QUADRATIC": 0.5}  # exponents
_DEFAULT_FILTER_GLOSSY = 1.0


def export(context: ExportContext, options: Options, passes: list[str]) -> None:
    out = context.description.settings
    render, ours = context.scene.render, plain.of(context.scene.ajar)
    out.width, out.height = resolution(render)
    out.region = region(render)
    out.filter = _FILTERS[ours.filter]
    out.filter_width = ours.filter_width
    out.exposure = ours.exposure
    out.transparent_film = render.film_transparent
    out.clamp_direct, out.clamp_indirect = ours.clamp_direct, ours.clamp_indirect
    out.reflective_caustics, out.refractive_caustics = ours.reflective_caustics, ours.refractive_caustics
    out.bump_terminator = ajar.BumpTerminator.Microfacet if compat.softens_bumps_by_microfacets() else ajar.BumpTerminator.Cubic
    for kind in ("total", "diffuse", "glossy", "transmission", "transparent", "volume"):
        setattr(out.bounces, kind, getattr(ours, f"bounces_{kind}"))
    out.integrator = _first(options.integrator, ours.integrator)
    out.direct = _first(options.direct, ours.direct)
    out.direct_samples = _first(options.direct_samples, ours.direct_samples)
    out.guiding = _first(options.guiding, ours.guiding)
    out.vertex_merging = _first(options.vertex_merging, ours.vertex_merging)
    out.image = _first(options.image, ours.image)
    out.image_error = ours.image_error
    out.importance_region = (*ours.importance_min, *ours.importance_max)
    out.importance_factor = ours.importance_factor
    out.samples = _first(options.samples, _samples_of_layer(context) or ours.samples)
    out.seconds = _first(options.time, ours.time_limit)
    # A number of samples or a time on the command line replaces the noise target, unless it was set in Ajar.
    is_asked = inherited.is_own(context.scene.ajar, "noise_target") or (options.samples is None and options.time is None)
    out.target_error = _first(options.error, ours.noise_target if is_asked else 0.0)
    out.seed = _first(options.seed, ours.seed)
    out.photons, out.photon_radius, out.gather_rays = ours.photons, ours.photon_radius, ours.gather_rays
    out.threads = _first(options.threads, render.threads if render.threads_mode == "FIXED" else 0)
    out.memory_limit = _first(options.memory_limit, ours.memory_limit)
    out.passes = passes
    if context.world is not None:
        mist = context.world.mist_settings
        out.mist = (mist.start, mist.depth, _FALLOFFS[mist.falloff])
    context.warn_all(context.scene.name, unsupported.asked_of(context.scene, unsupported.SCENE))
    context.warn_all(context.view_layer.name, unsupported.of_view_layer(context.view_layer))
    if _filters_glossy(context.scene):
        context.warn(context.scene.name, "Filter Glossy is ignored: glossy surfaces seen after a diffuse bounce keep their roughness")


def _filters_glossy(scene: bpy.types.Scene) -> bool:
    """Whether Filter Glossy of Cycles is larger than its default, which is not a choice of the artist.

    Without the add-on of Cycles, this setting does not exist.
    """
    return getattr(getattr(scene, "cycles", None), "blur_glossy", 0.0) > _DEFAULT_FILTER_GLOSSY


def _samples_of_layer(context: ExportContext) -> int:
    """Samples of the view layer that replace those of the scene; 0: none."""
    samples, use = context.view_layer.samples, compat.cycles_value(context.scene, "use_layer_samples", "USE")
    if use == "BOUNDED":
        return min(samples, plain.of(context.scene.ajar).samples)
    return samples if use == "USE" else 0


def resolution(render: bpy.types.RenderSettings) -> tuple[int, int]:
    """Resolution of the full frame in pixels, rounded as in Blender."""
    return tuple(max(1, side * render.resolution_percentage // 100) for side in (render.resolution_x, render.resolution_y))


def region(render: bpy.types.RenderSettings) -> tuple[int, int, int, int]:
    """The border in pixels, truncated as in Blender, or the full frame if there is none."""
    width, height = resolution(render)
    if not render.use_border:
        return (0, 0, width, height)
    return (int(render.border_min_x * width), int(render.border_min_y * height),
            int(render.border_max_x * width), int(render.border_max_y * height))


def _first(override, value):
    return value if override is None else override
