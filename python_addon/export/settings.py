"""Render settings of the scene. Options of the command line override them."""

from __future__ import annotations

import bpy

from .. import compat, core_settings, inherited, plain, unsupported
from ..ajar_module import ajar
from ..headless import Options
from ..passes import HALVES, types_of_aovs
from .context import ExportContext

_FILTERS = {"box": ajar.FilterKind.Box, "gaussian": ajar.FilterKind.Gaussian, "blackman_harris": ajar.FilterKind.BlackmanHarris}

_FALLOFFS = {"QUADRATIC": 2.0, "LINEAR": 1.0, "INVERSE_QUADRATIC": 0.5}  # exponents
_DEFAULT_FILTER_GLOSSY = 1.0


def export(context: ExportContext, options: Options, passes: list[str]) -> None:
    out = context.description.settings
    render, ours = context.scene.render, plain.of(context.scene.ajar)
    out.width, out.height = resolution(render)
    out.region = region(render)
    values = {prop: getattr(ours, prop) for prop in core_settings.SETTINGS} | _texture_cache(context.scene) | _asked(context) | options.settings
    for prop, value in values.items():
        _set(out, core_settings.SETTINGS[prop].name, _FILTERS[value.lower()] if prop == "filter" else value)
    # A number of samples or a time on the command line replaces the noise target, unless it was set in Ajar.
    replaced = not inherited.is_own(context.scene.ajar, "noise_target") and options.settings.keys() & {"samples", "time_limit"}
    if replaced and "noise_target" not in options.settings:
        out.target_error = 0.0
    out.texture_cache_folder = compat.texture_cache_folder(context.scene)
    out.view_exposure = view_exposure(context.scene)
    out.transparent_film = render.film_transparent
    out.bump_terminator = ajar.BumpTerminator.Microfacet if compat.softens_bumps_by_microfacets() else ajar.BumpTerminator.Cubic
    out.importance_region = (*ours.importance_min, *ours.importance_max)
    out.threads = options.threads if options.threads is not None else render.threads if render.threads_mode == "FIXED" else 0
    out.passes, out.denoised = passes, HALVES in passes
    context.aovs = types_of_aovs(passes)
    out.pass_alpha_threshold = context.view_layer.pass_alpha_threshold
    if context.world is not None:
        mist = context.world.mist_settings
        out.ao_distance = context.world.light_settings.distance
        out.mist = (mist.start, mist.depth, _FALLOFFS[mist.falloff])
    context.warn_all(context.scene.name, unsupported.asked_of(context.scene, unsupported.SCENE))
    context.warn_all(context.view_layer.name, unsupported.of_view_layer(context.view_layer))
    if _filters_glossy(context.scene):
        context.warn(context.scene.name, "Filter Glossy is ignored: glossy surfaces seen after a diffuse bounce keep their roughness")


def view_exposure(scene: bpy.types.Scene) -> float:
    """The factor on light by which Blender displays the image."""
    return 2.0 ** scene.view_settings.exposure


def _filters_glossy(scene: bpy.types.Scene) -> bool:
    """Whether Filter Glossy of Cycles is larger than its default, which is not a choice of the artist.

    Without the add-on of Cycles, this setting does not exist.
    """
    return getattr(getattr(scene, "cycles", None), "blur_glossy", 0.0) > _DEFAULT_FILTER_GLOSSY


def _set(out: ajar.RenderSettings, name: str, value: object) -> None:
    """`name`: as in the core's table. "bounces.total" is a field of a field."""
    *owners, name = name.split(".")
    for owner in owners:
        out = getattr(out, owner)
    setattr(out, name, value)


def _texture_cache(scene: bpy.types.Scene) -> dict[str, bool]:
    owner = compat.texture_cache_owner(scene)
    return {name: getattr(owner, name) for name in ("use_texture_cache", "use_auto_generate_texture_cache")}


def _asked(context: ExportContext) -> dict[str, int]:
    """Settings of the view layer, which replace those of the scene."""
    samples = _samples_of_layer(context)
    return {"samples": samples} if samples else {}


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
