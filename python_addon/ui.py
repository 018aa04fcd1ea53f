"""Panels: ours, and Blender's own where they apply to Ajar too."""

from __future__ import annotations

import math

import blf
import bpy
from bpy.types import Panel

from . import checks, compat, denoise, hints, last_render, passes, photon_overlay
from .ajar_module import ajar

ENGINE = "AJAR"
GATHERING_INTEGRATORS = {*photon_overlay.INTEGRATORS, "irradiance_cache"}
MOST_MESSAGES = 20
MARGINS, ICON = 72, 20   # pixels: left and right of a text in a panel, scroll bar included; of an icon
PANORAMA_SETTINGS = {
    "EQUIRECTANGULAR": ("latitude_min", "latitude_max", "longitude_min", "longitude_max"), "FISHEYE_EQUIDISTANT": ("fisheye_fov",),
    "FISHEYE_EQUISOLID": ("fisheye_lens", "fisheye_fov"),
    "FISHEYE_LENS_POLYNOMIAL": ("fisheye_fov", *(f"fisheye_polynomial_k{i}" for i in range(5))),
}
LIT = {"LIGHT", "MESH", "CURVE", "SURFACE", "META", "FONT"}   # objects that may send light
HONESTY = {ajar.Honesty.Unbiased: "Unbiased", ajar.Honesty.Consistent: "Consistent", ajar.Honesty.Biased: "Biased"}

# Built-in panels that speak of what Ajar does not have, or shows in its own way.
EXCLUDED = {
    "VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes", "VIEWLAYER_PT_eevee_layer_passes_data", "VIEWLAYER_PT_eevee_next_layer_passes_data",
    "VIEWLAYER_PT_layer_passes_cryptomatte", "VIEWLAYER_PT_layer_passes_aov", "VIEWLAYER_PT_layer_passes_lightgroups",
    "RENDER_PT_simplify", "RENDER_PT_simplify_viewport", "RENDER_PT_simplify_render", "RENDER_PT_simplify_greasepencil",
    "RENDER_PT_freestyle", "MATERIAL_PT_freestyle_line", "RENDER_PT_opengl_render", "SCENE_PT_simplify",
}


class AjarPanel:
    """What our panels share; not a panel itself."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine in cls.COMPAT_ENGINES

    def column(self) -> bpy.types.UILayout:
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout.column()


class AJAR_RENDER_PT_checks(AjarPanel, Panel):
    bl_label = "Before Rendering"

    def draw(self, context: bpy.types.Context) -> None:
        scene = context.scene
        column = self.column()
        mends = checks.found_in(scene)
        for mend in mends:
            _say(column, mend.text, context, "ERROR")
            column.operator("ajar.mend", text=mend.button).what = mend.name
        missing = checks.missing_images()
        if missing:
            _say(column, f"Missing images, which will be magenta: {', '.join(missing)}", context, "ERROR")
            column.operator("file.find_missing_files")
        messages = checks.messages_of(scene)
        for name, text in (messages or [])[:MOST_MESSAGES]:
            _say(column, f"{name}: {text}" if name else text, context, "ERROR")
        if messages and len(messages) > MOST_MESSAGES:
            column.label(text=f"... and {len(messages) - MOST_MESSAGES} more")
        if messages == [] and not mends and not missing:
            column.label(text="Nothing to say against the scene", icon="CHECKMARK")
        column.operator("ajar.check_scene", icon="VIEWZOOM")


class AJAR_RENDER_PT_sampling(AjarPanel, Panel):
    bl_label = "Sampling"

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        self.layout.emboss = "NONE"
        self.layout.menu("AJAR_MT_presets", text="", icon="PRESET")

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.ajar
        column = self.column()
        for name in ("samples", "time_limit", "noise_target", "seed"):
            column.prop(settings, name)
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
            column.prop(settings, "use_denoise")
        else:
            column.operator("ajar.denoise_in_compositor", icon="NODE_COMPOSITING")
        column.separator()
        column.prop(settings, "viewport_samples")
        column.prop(settings, "viewport_integrator")
        if denoise.is_available():
            column.prop(settings, "use_viewport_denoise")


class AJAR_RENDER_PT_integrator(AjarPanel, Panel):
    bl_label = "Integrator"

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        settings = context.scene.ajar
        column.prop(settings, "integrator")
        info = next((item for item in ajar.integrator_list() if item.name == settings.integrator), None)
        if info is not None:
            merges = info.can_merge and settings.vertex_merging == "on"
            honesty = ajar.Honesty.Consistent if merges else info.honesty
            _say(column, f"{HONESTY[honesty]}: {info.sentence}", context)
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


class AJAR_RENDER_PT_direct(AjarPanel, Panel):
    bl_label = "Direct Light"

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        settings = context.scene.ajar
        column.prop(settings, "direct", text="Method")
        column.prop(settings, "direct_samples", text="Samples")
        info = next((item for item in ajar.direct_method_list() if item.name == settings.direct), None)
        if info is not None:
            _say(column, ("Biased: " if info.biased else "") + info.sentence, context)


class AJAR_RENDER_PT_light_paths(AjarPanel, Panel):
    bl_label = "Light Paths"

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.ajar
        column = self.column()
        bounces = column.column(align=True)
        bounces.prop(settings, "bounces_total", text="Bounces Total")
        for kind in ("diffuse", "glossy", "transmission", "transparent"):
            bounces.prop(settings, f"bounces_{kind}")
        column.separator()
        clamping = column.column(align=True)
        clamping.prop(settings, "clamp_direct")
        clamping.prop(settings, "clamp_indirect")
        column.separator()
        column.prop(settings, "reflective_caustics")
        column.prop(settings, "refractive_caustics")


def _draw_hints(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """The scene's light paths, each with what became of it."""
    scene = context.scene
    layout.prop_search(scene.ajar, "hint_collection", bpy.data, "collections", text="Collection")
    for curve in hints.curves_of(scene):
        known = hints.attachment_of(curve)
        row = layout.row()
        row.use_property_split = False
        row.active = curve.ajar.hint_enabled
        icon = "CURVE_DATA" if known is None else "CHECKMARK" if known.attached else "ERROR"
        row.prop(curve.ajar, "hint_enabled", text="")
        row.label(text=curve.name, icon=icon)
        worth = last_render.of_hint(scene, curve.name)
        if worth is not None and _worth(worth):
            row = layout.row()
            row.label(icon="BLANK1")
            _say(row, _worth(worth), context)
        if known is not None and not known.attached:
            _say(layout, known.reason, context)
    buttons = layout.column(align=True)
    buttons.operator("ajar.draw_light_path", icon="GREASEPENCIL")
    buttons.operator("ajar.mark_light_path", icon="ADD")
    buttons.operator("ajar.unmark_light_path", icon="REMOVE")
    buttons.operator("ajar.check_light_paths", icon="VIEWZOOM")
    buttons.operator("ajar.suggest_light_paths", icon="LIGHT")


def _worth(worth: dict) -> str:
    """Of a light path in the last render: what its statistics say, and no more."""
    words = []
    if worth.get("proposed"):
        words.append(f"{worth['proposed']:,.0f} proposed")
        if "accepted" in worth:
            words.append(f"{worth['accepted'] / worth['proposed']:.0%} accepted")
    if "energy_share" in worth:
        words.append(f"{worth['energy_share']:.1%} of the light")
    return ", ".join(words)


class AJAR_RENDER_PT_hints(AjarPanel, Panel):
    bl_label = "Drawn Light Paths"

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.ajar
        column = self.column()
        if not {settings.integrator, settings.viewport_integrator} & checks.HINT_INTEGRATORS:
            names = [info.label for info in ajar.integrator_list() if info.name in checks.HINT_INTEGRATORS]
            _say(column, f"The chosen integrator does not use them. These do: {', '.join(names)}", context)
        _draw_hints(column, context)


class AJAR_VIEW3D_PT_hints(Panel):
    bl_label = "Drawn Light Paths"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Ajar"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine == ENGINE

    def draw(self, context: bpy.types.Context) -> None:
        _draw_hints(self.layout.column(), context)


class AJAR_OBJECT_PT_light_path(AjarPanel, Panel):
    """Of a curve in the collection of light paths."""
    bl_label = "Light Path"
    bl_context = "object"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object is not None and context.object in hints.curves_of(context.scene)

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        for name in ("hint_enabled", "hint_spread", "hint_weight", "hint_light"):
            column.prop(context.object.ajar, name)
        row = column.row()
        row.active = context.object.ajar.hint_light is not None
        row.prop(context.object.ajar, "hint_offset")
        _say(column, hints.status_of(context.object), context)
        worth = last_render.of_hint(context.scene, context.object.name)
        if worth is not None:
            column.label(text=f"Last render: {_worth(worth)}")


class AJAR_OBJECT_PT_importance(AjarPanel, Panel):
    bl_label = "Sampling"
    bl_context = "object"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object is not None

    def draw(self, context: bpy.types.Context) -> None:
        column, thing = self.column(), context.object
        column.prop(thing.ajar, "importance")
        if thing.type in LIT:
            _choose_light_group(column, thing, context.view_layer)


class AJAR_WORLD_PT_light_group(AjarPanel, Panel):
    bl_label = "Light Group"
    bl_context = "world"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.world is not None

    def draw(self, context: bpy.types.Context) -> None:
        _choose_light_group(self.column(), context.world, context.view_layer)


def _choose_light_group(layout: bpy.types.UILayout, source: bpy.types.Object | bpy.types.World, view_layer: bpy.types.ViewLayer) -> None:
    row = layout.row(align=True)
    row.prop_search(source, "lightgroup", view_layer, "lightgroups", text="Light Group", results_are_suggestions=True)
    add = row.row(align=True)
    add.enabled = bool(source.lightgroup) and source.lightgroup not in view_layer.lightgroups
    add.operator("scene.view_layer_add_lightgroup", icon="ADD", text="").name = source.lightgroup


class AJAR_COLLECTION_PT_importance(AjarPanel, Panel):
    bl_label = "Sampling"
    bl_context = "collection"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.collection is not None

    def draw(self, context: bpy.types.Context) -> None:
        self.column().prop(context.collection.ajar, "importance")


class AJAR_RENDER_PT_film(AjarPanel, Panel):
    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.ajar
        column = self.column()
        column.prop(settings, "exposure")
        column.prop(settings, "filter")
        row = column.row()
        row.active = settings.filter != "BOX"
        row.prop(settings, "filter_width")
        column.prop(context.scene.render, "film_transparent", text="Transparent")


class AJAR_RENDER_PT_motion_blur(AjarPanel, Panel):
    bl_label = "Motion Blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        render, cycles = context.scene.render, getattr(context.scene, "cycles", None)
        column = self.column()
        column.prop(render, "use_motion_blur")
        column.prop(render, "motion_blur_shutter")
        owner = render if hasattr(render, "motion_blur_position") else cycles
        if owner is not None:
            column.prop(owner, "motion_blur_position")


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


class AJAR_RENDER_PT_statistics(AjarPanel, Panel):
    """Of the last render."""
    bl_label = "Statistics"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and last_render.of(context.scene) is not None

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        for name, value in _statistics(last_render.of(context.scene)):
            row = column.split(factor=0.36)
            row.label(text=name)
            row.label(text=value)


class AJAR_RENDER_PT_plan(AjarPanel, Panel):
    """What the last render needed, what it left out, and why."""
    bl_label = "Render Plan"
    bl_parent_id = "AJAR_RENDER_PT_statistics"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and bool((last_render.of(context.scene) or {}).get("plan"))

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        for step in last_render.of(context.scene)["plan"]:
            _say(column, f"{step['step'][:1].upper()}{step['step'][1:]}: {step['reason']}", context, "CHECKMARK" if step["used"] else "BLANK1")


def _statistics(values: dict) -> list[tuple[str, str]]:
    """Names and values for people."""
    label = next((info.label for info in ajar.integrator_list() if info.name == values["integrator"]), values["integrator"])
    rows = [("Integrator", f"{label}, {values.get('honesty', '')}".rstrip(", "))]
    if "samples_per_pixel" in values:
        rows.append(("Samples per pixel", f"{values['samples_per_pixel']['mean']:.4g}"))
    if "rays_per_second" in values:
        rows.append(("Rays per second", f"{values['rays_per_second'] / 1e6:.3g} million"))
    if values.get("estimated_error"):
        relmse = values["estimated_error"][-1][2]
        rows.append(("Estimated error", f"{100.0 * math.sqrt(relmse):.2g} % of the brightness (relMSE {relmse:.2g})"))
    if "refused_samples" in values:
        rows.append(("Refused samples", f"{values['refused_samples']}"))
    rows.append(("Export and build", f"{values['export_seconds'] + values['build_seconds']:.2f} s"))
    rows.append(("Rendering", f"{values['render_seconds']:.2f} s with {values['threads']} threads"))
    rows.append(("Peak memory", f"{values['peak_memory_bytes'] / 2**20:.0f} MiB"))
    if "scene" in values:
        scene = values["scene"]
        rows.append(("Triangles", f"{scene['triangles']:,} in {scene['meshes']:,} meshes"))
        rows.append(("Instances", f"{scene['instances']:,} with {scene['instanced_triangles']:,} triangles"))
        rows.append(("Lights", f"{scene['lights']:,}"))
    return rows


def _wrapped(text: str, context: bpy.types.Context, icon: bool = False) -> list[str]:
    """A sentence in lines that fit the panel: Blender's labels are of one line. `icon`: room for one is taken from each."""
    scale = context.preferences.system.ui_scale or 1.0
    width = (context.region.width if context.region is not None else 300) - (MARGINS + (ICON if icon else 0)) * scale
    font = compat.label_points(context.preferences.ui_styles[0])
    compat.font_size(0, round(font * scale))
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and blf.dimensions(0, longer)[0] <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


def _say(layout: bpy.types.UILayout, text: str, context: bpy.types.Context, icon: str = "NONE") -> None:
    """A sentence, with an icon before its first line."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, line in enumerate(_wrapped(text, context, icon != "NONE")):
        column.label(text=line, icon=icon if number == 0 or icon == "NONE" else "BLANK1")


class AJAR_DATA_PT_panorama(AjarPanel, Panel):
    """Settings that Blender shows for Cycles alone, before they became its own (5.0)."""

    bl_label = "Panorama"
    bl_context = "data"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        camera = getattr(context, "camera", None)
        return super().poll(context) and camera is not None and camera.type == "PANO" and not hasattr(camera, "panorama_type") and hasattr(camera, "cycles")

    def draw(self, context: bpy.types.Context) -> None:
        column, cycles = self.column(), context.camera.cycles
        column.prop(cycles, "panorama_type")
        for name in PANORAMA_SETTINGS.get(cycles.panorama_type, ()):
            column.prop(cycles, name)


class AJAR_VIEWLAYER_PT_passes(AjarPanel, Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context: bpy.types.Context) -> None:
        view_layer = context.view_layer
        column = self.column()
        for name in ("use_pass_combined", *passes.BUILT_IN):
            column.prop(view_layer, name)
        for name in passes.OWN:
            column.prop(view_layer.ajar, name)


class AJAR_VIEWLAYER_PT_light_groups(AjarPanel, Panel):
    bl_label = "Light Groups"
    bl_context = "view_layer"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        view_layer = context.view_layer
        column = self.column()
        row = column.row()
        row.template_list("UI_UL_list", "ajar_lightgroups", view_layer, "lightgroups", view_layer, "active_lightgroup_index", rows=3)
        buttons = row.column(align=True)
        buttons.operator("scene.view_layer_add_lightgroup", icon="ADD", text="")
        buttons.operator("scene.view_layer_remove_lightgroup", icon="REMOVE", text="")
        buttons.separator()
        buttons.menu("VIEWLAYER_MT_lightgroup_sync", icon="DOWNARROW_HLT", text="")
        if 0 <= view_layer.active_lightgroup_index < len(view_layer.lightgroups):
            row = column.row()
            row.active = context.scene.ajar.image == "pmc_ip"
            row.prop(view_layer.ajar, "light_group_importance")


CLASSES = (AJAR_DATA_PT_panorama, AJAR_RENDER_PT_checks, AJAR_RENDER_PT_sampling, AJAR_RENDER_PT_integrator, AJAR_RENDER_PT_direct, AJAR_RENDER_PT_light_paths, AJAR_RENDER_PT_hints,
           AJAR_OBJECT_PT_light_path, AJAR_OBJECT_PT_importance, AJAR_WORLD_PT_light_group, AJAR_COLLECTION_PT_importance, AJAR_RENDER_PT_film,
           AJAR_RENDER_PT_motion_blur, AJAR_RENDER_PT_performance, AJAR_RENDER_PT_statistics, AJAR_RENDER_PT_plan,
           AJAR_VIEWLAYER_PT_passes, AJAR_VIEWLAYER_PT_light_groups, AJAR_VIEW3D_PT_hints)


def built_in_panels() -> list[type]:
    """Blender's panels for its generic renderers, without those excluded above."""
    return [panel for panel in Panel.__subclasses__()
            if "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ()) and panel.__name__ not in EXCLUDED]


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(CLASSES)


def register() -> None:
    _register_classes()
    for panel in built_in_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister() -> None:
    for panel in built_in_panels():
        panel.COMPAT_ENGINES.discard(ENGINE)
    _unregister_classes()
