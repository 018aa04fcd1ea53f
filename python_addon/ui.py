"""Panels: ours, and Blender's own where they apply to Ajar too."""

from __future__ import annotations

import bpy
from bpy.types import Panel

ENGINE = "AJAR"
PHOTON_INTEGRATORS = {"photon_map", "mps"}
HINT_INTEGRATORS = {"mps", "metropolis", "pmc_pt"}

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


class AJAR_RENDER_PT_sampling(AjarPanel, Panel):
    bl_label = "Sampling"

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


class AJAR_RENDER_PT_integrator(AjarPanel, Panel):
    bl_label = "Integrator"

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        settings = context.scene.ajar
        column.prop(settings, "integrator")
        column.prop(settings, "direct")
        column.prop(settings, "direct_samples")
        if settings.integrator in PHOTON_INTEGRATORS:
            photons = column.column(align=True)
            for name in ("photons", "photon_radius", "gather_rays"):
                photons.prop(settings, name)
        if settings.integrator in HINT_INTEGRATORS:
            column.prop_search(settings, "hint_collection", bpy.data, "collections", text="Light Path Curves")


class AJAR_RENDER_PT_light_paths(AjarPanel, Panel):
    bl_label = "Light Paths"

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.ajar
        column = self.column()
        bounces = column.column(heading="Bounces", align=True)
        for kind in ("total", "diffuse", "glossy", "transmission", "transparent"):
            bounces.prop(settings, f"bounces_{kind}")
        column.separator()
        clamping = column.column(align=True)
        clamping.prop(settings, "clamp_direct")
        clamping.prop(settings, "clamp_indirect")
        column.separator()
        column.prop(settings, "reflective_caustics")
        column.prop(settings, "refractive_caustics")


class AJAR_OBJECT_PT_light_path(AjarPanel, Panel):
    """Of a curve in the collection of light paths."""
    bl_label = "Light Path"
    bl_context = "object"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        collection = bpy.data.collections.get(context.scene.ajar.hint_collection)
        return (super().poll(context) and context.object is not None and context.object.type == "CURVE"
                and collection is not None and context.object.name in collection.all_objects)

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        for name in ("hint_enabled", "hint_spread", "hint_weight"):
            column.prop(context.object.ajar, name)


class AJAR_OBJECT_PT_importance(AjarPanel, Panel):
    bl_label = "Sampling"
    bl_context = "object"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object is not None

    def draw(self, context: bpy.types.Context) -> None:
        self.column().prop(context.object.ajar, "importance")


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


class AJAR_VIEWLAYER_PT_passes(AjarPanel, Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context: bpy.types.Context) -> None:
        view_layer = context.view_layer
        column = self.column()
        for name in ("use_pass_combined", "use_pass_z", "use_pass_position", "use_pass_normal", "use_pass_uv"):
            column.prop(view_layer, name)
        for name in ("use_pass_albedo", "use_pass_sample_count", "use_pass_variance", "use_pass_error", "use_pass_perceptual_error"):
            column.prop(view_layer.ajar, name)


CLASSES = (AJAR_RENDER_PT_sampling, AJAR_RENDER_PT_integrator, AJAR_RENDER_PT_light_paths, AJAR_OBJECT_PT_light_path, AJAR_OBJECT_PT_importance,
           AJAR_COLLECTION_PT_importance, AJAR_RENDER_PT_film,
           AJAR_RENDER_PT_performance, AJAR_VIEWLAYER_PT_passes)


def built_in_panels() -> list[type]:
    """Blender's panels for its generic renderers, without those excluded above."""
    return [panel for panel in Panel.__subclasses__()
            if "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ()) and panel.__name__ not in EXCLUDED]


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for panel in built_in_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister() -> None:
    for panel in built_in_panels():
        panel.COMPAT_ENGINES.discard(ENGINE)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
