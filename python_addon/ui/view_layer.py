"""The view layer tab."""

from __future__ import annotations

import bpy
from bpy.types import Panel

from .. import passes
from .common import AjarPanel


class AJAR_VIEWLAYER_PT_filter(AjarPanel, Panel):
    bl_label = "Filter"
    bl_context = "view_layer"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column, layer = self.column(), context.view_layer
        include = column.column(heading="Include")
        include.prop(layer, "use_sky", text="Environment")
        include.prop(layer, "use_solid", text="Surfaces")
        include.prop(layer, "use_strand", text="Hair")
        include.prop(layer, "use_volumes", text="Volumes")
        if hasattr(layer, "use_grease_pencil"):   # 5.0; Blender draws it over the image
            include.prop(layer, "use_grease_pencil", text="Grease Pencil")
        use = column.column(heading="Use")
        use.active = context.scene.render.use_motion_blur
        use.prop(layer, "use_motion_blur", text="Motion Blur")


class AJAR_VIEWLAYER_PT_override(AjarPanel, Panel):
    bl_label = "Override"
    bl_context = "view_layer"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        column.prop(context.view_layer, "material_override")
        if hasattr(context.view_layer, "world_override"):
            column.prop(context.view_layer, "world_override")
        column.prop(context.view_layer, "samples")


class AJAR_VIEWLAYER_PT_passes(AjarPanel, Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context: bpy.types.Context) -> None:
        view_layer = context.view_layer
        column = self.column()
        for name in ("use_pass_combined", *passes.BUILT_IN):
            row = column.row()
            row.active = name != "use_pass_vector" or not context.scene.render.use_motion_blur
            row.prop(view_layer, name)
        for name in passes.OWN:
            column.prop(view_layer.ajar, name)
        column.prop(view_layer.ajar, "use_pass_denoising")
        row = column.row()
        row.active = context.scene.ajar.use_denoise
        row.prop(view_layer.ajar, "use_pass_denoising_error")
        column.prop(view_layer, "pass_alpha_threshold")


class AJAR_VIEWLAYER_PT_cryptomatte(AjarPanel, Panel):
    bl_label = "Cryptomatte"
    bl_context = "view_layer"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        view_layer, column = context.view_layer, self.column()
        for name, label in zip(passes.MATTES, ("Object", "Material", "Asset")):
            column.prop(view_layer, name, text=label)
        levels = column.row()
        levels.active = any(getattr(view_layer, name) for name in passes.MATTES)
        levels.prop(view_layer, "pass_cryptomatte_depth", text="Levels")


class AJAR_VIEWLAYER_PT_aovs(AjarPanel, Panel):
    bl_label = "Shader AOV"
    bl_context = "view_layer"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        view_layer, column = context.view_layer, self.column()
        row = column.row()
        row.template_list("VIEWLAYER_UL_aov", "ajar_aovs", view_layer, "aovs", view_layer, "active_aov_index", rows=3)
        buttons = row.column(align=True)
        buttons.operator("scene.view_layer_add_aov", icon="ADD", text="")
        buttons.operator("scene.view_layer_remove_aov", icon="REMOVE", text="")
        if view_layer.active_aov is not None and not view_layer.active_aov.is_valid:
            column.label(text="Conflicts with another render pass with the same name", icon="ERROR")


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


CLASSES = (AJAR_VIEWLAYER_PT_filter, AJAR_VIEWLAYER_PT_override, AJAR_VIEWLAYER_PT_passes, AJAR_VIEWLAYER_PT_cryptomatte, AJAR_VIEWLAYER_PT_aovs,
           AJAR_VIEWLAYER_PT_light_groups)
