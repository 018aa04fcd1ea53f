"""The render tab."""

from __future__ import annotations

import math

import bpy
from bpy.types import Menu, Panel

from .. import checks, compat, denoise, last_render, photon_overlay
from ..ajar_module import ajar
from ..translations import interface
from .common import AjarPanel, draw_inherited, say

GATHERING_INTEGRATORS = {*photon_overlay.INTEGRATORS, "irradiance_cache"}
MAX_MESSAGES = 20
COMPARISON_METHODS = {"bsdf", "light", "ris", "correlated", "pmc_hi_paper", "ocv_paper"}   # no scene renders faster with them
BIAS_LABELS = {ajar.Bias.Unbiased: "Unbiased", ajar.Bias.Consistent: "Consistent", ajar.Bias.Biased: "Biased"}


class AJAR_RENDER_PT_checks(AjarPanel, Panel):
    bl_label = "Before Rendering"

    def draw(self, context: bpy.types.Context) -> None:
        scene = context.scene
        column = self.column()
        fixes = checks.found_in(scene)
        for fix in fixes:
            say(column, fix.text, context, "ERROR")
            column.operator("ajar.fix", text=fix.button).what = fix.name
        missing = checks.missing_images()
        if missing:
            say(column, interface("Missing images, which will be magenta: {names}", names=", ".join(missing)), context, "ERROR")
            column.operator("file.find_missing_files")
        messages = checks.messages_of(scene)
        for name, text in (messages or [])[:MAX_MESSAGES]:
            say(column, interface("{name}: {message}", name=name, message=text) if name else text, context, "ERROR")
        if messages and len(messages) > MAX_MESSAGES:
            column.label(text=interface("... and {number} more", number=len(messages) - MAX_MESSAGES))
        if messages == [] and not fixes and not missing:
            column.label(text="No problems found", icon="CHECKMARK")
        column.operator("ajar.check_scene", icon="VIEWZOOM")


class AJAR_RENDER_PT_sampling(AjarPanel, Panel):
    bl_label = "Sampling"

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        self.layout.emboss = "NONE"
        self.layout.menu("AJAR_MT_presets", text="", icon="PRESET")
        super().draw_header_preset(context)

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.ajar
        column = self.column()
        column.prop(settings, "use_cycles_settings")
        if settings.use_cycles_settings:
            say(column, "Values in grey come from Cycles", context)
            column.operator("ajar.inherit_settings", icon="LOOP_BACK")
        column.separator()
        column.prop(settings, "noise_level")
        if settings.noise_level in ("CUSTOM", "OFF") or settings.show_advanced:
            draw_inherited(column, settings, "noise_target")
        for name in ("samples", "time_limit", "seed"):
            draw_inherited(column, settings, name)
        column.separator()
        column.prop(settings, "image")
        if settings.image == "pmc_ip":
            column.prop(settings, "image_error")
            column.prop(settings, "importance_factor")
            region = column.column(align=True)
            region.active = settings.importance_factor != 1.0
            region.prop(settings, "importance_min")
            region.prop(settings, "importance_max")
        column.separator()
        if denoise.is_available():
            draw_inherited(column, settings, "use_denoise")
        else:
            column.operator("ajar.denoise_in_compositor", icon="NODE_COMPOSITING")
        column.separator()
        draw_inherited(column, settings, "viewport_samples")
        column.prop(settings, "viewport_integrator")
        if denoise.is_available():
            draw_inherited(column, settings, "use_viewport_denoise")


class AJAR_RENDER_PT_integrator(AjarPanel, Panel):
    bl_label = "Integrator"

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        settings = context.scene.ajar
        column.prop(settings, "integrator")
        info = next((item for item in ajar.integrator_list() if item.name == settings.integrator), None)
        if info is not None:
            merges = info.can_merge and settings.vertex_merging == "on"
            bias = ajar.Bias.Consistent if merges else info.bias
            say(column, interface("{kind}: {sentence}", kind=interface(BIAS_LABELS[bias]), sentence=interface(info.sentence)), context)
        if settings.integrator == "path":
            column.prop(settings, "guiding")
        can_merge = info is not None and info.can_merge
        if can_merge:
            column.prop(settings, "vertex_merging")
        column.prop(settings, "carry_learning")
        chosen = {settings.integrator, settings.viewport_integrator}
        gathering = column.column(align=True)
        if chosen & photon_overlay.INTEGRATORS or (can_merge and settings.vertex_merging == "on"):
            gathering.prop(settings, "photons")
            gathering.prop(settings, "photon_radius")
        if chosen & GATHERING_INTEGRATORS:
            gathering.prop(settings, "gather_rays")
        if chosen & {"auto", *photon_overlay.INTEGRATORS}:
            column.prop(settings, "show_photons")
            if settings.show_photons:
                column.label(text=photon_overlay.status_of(context.scene))


class AJAR_MT_direct(Menu):
    """The methods that can be faster in some scenes."""

    bl_label = "Direct Light"

    def draw(self, context: bpy.types.Context) -> None:
        for info in ajar.direct_method_list():
            if info.name not in COMPARISON_METHODS:
                self.layout.prop_enum(context.scene.ajar, "direct", info.name)


class AJAR_RENDER_PT_direct(AjarPanel, Panel):
    bl_label = "Direct Light"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        settings = context.scene.ajar
        info = next((item for item in ajar.direct_method_list() if item.name == settings.direct), None)
        if settings.show_advanced or settings.direct in COMPARISON_METHODS:
            column.prop(settings, "direct", text="Method")
        else:
            row = column.split(factor=0.4)
            row.alignment = "RIGHT"
            row.label(text="Method")
            row.menu("AJAR_MT_direct", text=info.label if info is not None else settings.direct)
        column.prop(settings, "direct_samples", text="Samples")
        column.prop(settings, "show_advanced")
        if info is not None:
            sentence = interface(info.sentence)
            say(column, interface("{kind}: {sentence}", kind=interface("Biased"), sentence=sentence) if info.biased else sentence, context)


class AJAR_RENDER_PT_light_paths(AjarPanel, Panel):
    bl_label = "Light Paths"

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.ajar
        column = self.column()
        bounces = column.column(align=True)
        draw_inherited(bounces, settings, "bounces_total", text="Bounces Total")
        for kind in ("diffuse", "glossy", "transmission", "volume", "transparent"):
            draw_inherited(bounces, settings, f"bounces_{kind}")
        column.separator()
        clamping = column.column(align=True)
        clamping.active = "path" in {settings.integrator, settings.viewport_integrator}
        for name in ("clamp_direct", "clamp_indirect"):
            draw_inherited(clamping, settings, name)
        if not clamping.active and max(settings.clamp_direct, settings.clamp_indirect) > 0.0:
            say(column, interface("Only Path Tracing clamps"), context)
        column.separator()
        for name in ("reflective_caustics", "refractive_caustics"):
            draw_inherited(column, settings, name)


class AJAR_RENDER_PT_film(AjarPanel, Panel):
    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.ajar
        column = self.column()
        draw_inherited(column, settings, "exposure")
        draw_inherited(column, settings, "filter")
        row = column.row()
        row.active = settings.filter != "BOX"
        row.prop(settings, "filter_width")
        column.prop(context.scene.render, "film_transparent", text="Transparent")
        glass = column.column()
        glass.active = context.scene.render.film_transparent
        draw_inherited(glass, settings, "transparent_glass")
        rough = glass.column()
        rough.active = settings.transparent_glass
        draw_inherited(rough, settings, "transparent_glass_roughness")


class AJAR_RENDER_PT_curves(AjarPanel, Panel):
    bl_label = "Curves"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column, settings = self.column(), context.scene.ajar
        column.prop(settings, "curve_shape")
        if settings.curve_shape == "RIBBONS":
            column.prop(settings, "curve_subdivisions")


class AJAR_RENDER_PT_subdivision(AjarPanel, Panel):
    bl_label = "Subdivision"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.ajar
        column = self.column()
        rates = column.column(align=True)
        draw_inherited(rates, settings, "dicing_rate", text="Dicing Rate Render")
        draw_inherited(rates, settings, "preview_dicing_rate", text="Viewport")
        draw_inherited(column, settings, "offscreen_dicing_scale")
        draw_inherited(column, settings, "max_subdivisions")
        column.prop(settings, "dicing_camera")


class AJAR_RENDER_PT_motion_blur(AjarPanel, Panel):
    bl_label = "Motion Blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw(self, context: bpy.types.Context) -> None:
        render = context.scene.render
        column = self.column()
        column.active = render.use_motion_blur
        column.prop(compat.shutter_owner(context.scene), "motion_blur_position", text="Position")
        column.prop(render, "motion_blur_shutter")
        settings = context.scene.ajar
        draw_inherited(column, settings, "rolling_shutter_type")
        duration = column.column()
        duration.active = settings.rolling_shutter_type != "NONE"
        draw_inherited(duration, settings, "rolling_shutter_duration")


class AJAR_RENDER_PT_shutter_curve(AjarPanel, Panel):
    bl_label = "Shutter Curve"
    bl_parent_id = "AJAR_RENDER_PT_motion_blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        render = context.scene.render
        self.layout.active = render.use_motion_blur
        self.layout.template_curve_mapping(render, "motion_blur_shutter_curve")
        row = self.layout.row(align=True)
        for shape, icon in (("SMOOTH", "SMOOTHCURVE"), ("ROUND", "SPHERECURVE"), ("ROOT", "ROOTCURVE"), ("SHARP", "SHARPCURVE"), ("LINE", "LINCURVE"),
                            ("MAX", "NOCURVE")):
            row.operator("render.shutter_curve_preset", icon=icon, text="").shape = shape


class AJAR_RENDER_PT_performance(AjarPanel, Panel):
    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        render = context.scene.render
        column = self.column()
        column.prop(render, "threads_mode")
        row = column.row()
        row.enabled = render.threads_mode == "FIXED"
        row.prop(render, "threads")
        column.prop(context.scene.ajar, "memory_limit")
        column.prop(context.scene.ajar, "compact_bvh")
        column.prop(render, "use_persistent_data", text="Persistent Data")


class AJAR_RENDER_PT_texture_cache(AjarPanel, Panel):
    bl_label = "Texture Cache"
    bl_parent_id = "AJAR_RENDER_PT_performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(compat.texture_cache_owner(context.scene), "use_texture_cache", text="")

    def draw(self, context: bpy.types.Context) -> None:
        column, settings, owner = self.column(), context.scene.ajar, compat.texture_cache_owner(context.scene)
        column.active = owner.use_texture_cache
        column.prop(owner, "use_auto_generate_texture_cache", text="Auto Generate")
        if owner == settings:
            column.prop(settings, "texture_cache_directory")
        column.prop(settings, "texture_cache_size")


class AJAR_RENDER_PT_compositor(AjarPanel, Panel):
    """Settings of Blender's compositor, which processes the images of all engines."""

    bl_label = "Compositor"
    bl_parent_id = "AJAR_RENDER_PT_performance"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and hasattr(context.scene.render, "compositor_device")

    def draw(self, context: bpy.types.Context) -> None:
        column, render = self.column(), context.scene.render
        for name in ("compositor_device", "compositor_precision", "compositor_denoise_device", "compositor_denoise_preview_quality", "compositor_denoise_final_quality"):
            if hasattr(render, name):
                column.prop(render, name)


class AJAR_RENDER_PT_checkpoint(AjarPanel, Panel):
    bl_label = "Checkpoint"
    bl_parent_id = "AJAR_RENDER_PT_performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.scene.ajar, "use_checkpoint", text="")

    def draw(self, context: bpy.types.Context) -> None:
        column, settings = self.column(), context.scene.ajar
        column.active = settings.use_checkpoint
        for name in ("checkpoint_path", "checkpoint_interval", "use_resume"):
            column.prop(settings, name)


class AJAR_RENDER_PT_statistics(AjarPanel, Panel):
    """Statistics of the last render."""
    bl_label = "Statistics"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and last_render.of(context.scene) is not None

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        values = last_render.of(context.scene)
        for name, value in _statistics(values) if values is not None else ():
            row = column.split(factor=0.36)
            row.label(text=name)
            row.label(text=value, translate=False)


class AJAR_RENDER_PT_plan(AjarPanel, Panel):
    """The render plan: what the last render needed, what it skipped, and why."""
    bl_label = "Render Plan"
    bl_parent_id = "AJAR_RENDER_PT_statistics"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and bool((last_render.of(context.scene) or {}).get("plan"))

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        for step in (last_render.of(context.scene) or {}).get("plan", ()):
            name = f"{step['step'][:1].upper()}{step['step'][1:]}"
            message = interface("{reason} ({cost})", reason=step["reason"], cost=step["cost"]) if step.get("cost") else step["reason"]
            say(column, interface("{name}: {message}", name=interface(name), message=message), context, "CHECKMARK" if step["used"] else "BLANK1")


class SimplifyPanel(AjarPanel):
    """Below Blender's panel Simplify. It is registered after the copy of that panel."""
    bl_context = "render"
    bl_parent_id = "AJAR_RENDER_PT_simplify"
    bl_options = {"DEFAULT_CLOSED"}

    def simplify_column(self, context: bpy.types.Context) -> bpy.types.UILayout:
        column = self.column()
        column.active = context.scene.render.use_simplify
        return column


class AJAR_RENDER_PT_culling(SimplifyPanel, Panel):
    bl_label = "Culling"

    def draw(self, context: bpy.types.Context) -> None:
        column, settings = self.simplify_column(context), context.scene.ajar
        for name, margin in (("use_camera_cull", "camera_cull_margin"), ("use_distance_cull", "distance_cull_margin")):
            row = column.row(heading="Camera Culling" if name == "use_camera_cull" else "Distance Culling")
            row.prop(settings, name, text="")
            value = row.row()
            value.active = getattr(settings, name)
            value.prop(settings, margin, text="")


class AJAR_RENDER_PT_texture_size(SimplifyPanel, Panel):
    bl_label = "Textures"

    def draw(self, context: bpy.types.Context) -> None:
        column, settings = self.simplify_column(context), context.scene.ajar
        for name in ("texture_limit", "texture_limit_render"):
            column.prop(settings, name)
        if compat.has_texture_resolution():
            for name in ("texture_resolution", "texture_resolution_render"):
                column.prop(settings, name)


def _statistics(values: dict) -> list[tuple[str, str]]:
    """Names and values as text. The panel translates the names."""
    labels = {info.name: info.label for info in ajar.integrator_list()}
    label = labels.get(values["integrator"], values["integrator"])
    for technique in values.get("techniques", ())[1:]:
        label = interface("{first} and {second}", first=interface(label), second=interface(labels.get(technique["integrator"], technique["integrator"])))
    words = [label, values["bias"].capitalize()] if values.get("bias") else [label]
    rows = [("Integrator", ", ".join(map(interface, words)))]
    if "samples_per_pixel" in values:
        rows.append(("Samples per pixel", f"{values['samples_per_pixel']['mean']:.4g}"))
    if "rays_per_second" in values:
        rows.append(("Rays per second", interface("{number:.3g} million", number=values["rays_per_second"] / 1e6)))
    if values.get("estimated_error"):
        relmse = values["estimated_error"][-1][2]
        rows.append(("Estimated error", interface("{percent:.2g} % of the brightness (relMSE {relmse:.2g})", percent=100.0 * math.sqrt(relmse), relmse=relmse)))
    if "denoising_error" in values:
        relmse = values["denoising_error"]
        rows.append(("Error after denoising", interface("{percent:.2g} % of the brightness (relMSE {relmse:.2g})", percent=100.0 * math.sqrt(relmse), relmse=relmse)))
    if "refused_samples" in values:
        rows.append(("Refused samples", f"{values['refused_samples']}"))
    rows.append(("Export and build", f"{values['export_seconds'] + values['build_seconds']:.2f} s"))
    rows.append(("Rendering", interface("{seconds:.2f} s with {threads} threads", seconds=values["render_seconds"], threads=values["threads"])))
    rows.append(("Peak memory", f"{values['peak_memory_bytes'] / 2**20:.0f} MiB"))
    if "scene" in values:
        scene = values["scene"]
        rows.append(("Triangles", interface("{triangles:,} in {meshes:,} meshes", triangles=scene["triangles"], meshes=scene["meshes"])))
        rows.append(("Instances", interface("{instances:,} with {triangles:,} triangles", instances=scene["instances"], triangles=scene["instanced_triangles"])))
        rows.append(("Lights", f"{scene['lights']:,}"))
    if "texture_cache" in values:
        cache = values["texture_cache"]
        rows.append(("Texture cache", interface("{peak:.0f} of {limit:.0f} MiB, {tiles:,} tiles read", peak=cache["peak_bytes"] / 2**20,
                                                limit=cache["limit_bytes"] / 2**20, tiles=cache["tiles_read"])))
    return rows


CLASSES = (AJAR_RENDER_PT_checks, AJAR_RENDER_PT_sampling, AJAR_RENDER_PT_integrator, AJAR_MT_direct, AJAR_RENDER_PT_direct, AJAR_RENDER_PT_light_paths, AJAR_RENDER_PT_film, AJAR_RENDER_PT_curves, AJAR_RENDER_PT_subdivision, AJAR_RENDER_PT_motion_blur, AJAR_RENDER_PT_shutter_curve, AJAR_RENDER_PT_performance, AJAR_RENDER_PT_texture_cache, AJAR_RENDER_PT_compositor, AJAR_RENDER_PT_checkpoint, AJAR_RENDER_PT_statistics, AJAR_RENDER_PT_plan)
