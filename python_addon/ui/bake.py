"""The panel Bake of the render tab. The settings are those of Blender, except the type, which Cycles keeps in its add-on."""

from __future__ import annotations

import bpy
from bpy.types import Panel

from .common import AjarPanel, draw_inherited

LIGHT = {"DIFFUSE", "GLOSSY", "TRANSMISSION"}


class AJAR_RENDER_PT_bake(AjarPanel, Panel):
    bl_label = "Bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        column.operator("object.bake", icon="RENDER_STILL").type = context.scene.ajar.bake_type
        draw_inherited(column, context.scene.ajar, "bake_type")


class AJAR_RENDER_PT_bake_influence(AjarPanel, Panel):
    bl_label = "Influence"
    bl_parent_id = "AJAR_RENDER_PT_bake"

    def draw(self, context: bpy.types.Context) -> None:
        bake, kind = context.scene.render.bake, context.scene.ajar.bake_type
        column = self.column()
        column.prop(bake, "view_from")
        if kind == "NORMAL":
            column.prop(bake, "normal_space", text="Space")
            for number, name in enumerate("rgb"):
                column.prop(bake, f"normal_{name}", text="Swizzle R" if number == 0 else name.upper())
        elif kind == "COMBINED" or kind in LIGHT:
            lighting = self.layout.column(heading="Lighting" if kind == "COMBINED" else "Contributions", align=True)
            for name in ("direct", "indirect") + (() if kind == "COMBINED" else ("color",)):
                lighting.prop(bake, f"use_pass_{name}")
            if kind == "COMBINED":
                parts = self.layout.column(heading="Contributions", align=True)
                parts.active = bake.use_pass_direct or bake.use_pass_indirect
                for name in ("diffuse", "glossy", "transmission", "emit"):
                    parts.prop(bake, f"use_pass_{name}")


class AJAR_RENDER_PT_bake_selected_to_active(AjarPanel, Panel):
    bl_label = "Selected to Active"
    bl_parent_id = "AJAR_RENDER_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.scene.render.bake, "use_selected_to_active", text="")

    def draw(self, context: bpy.types.Context) -> None:
        bake = context.scene.render.bake
        column = self.column()
        column.active = bake.use_selected_to_active
        column.prop(bake, "use_cage", text="Cage")
        if bake.use_cage:
            column.prop(bake, "cage_object")
        column.prop(bake, "cage_extrusion", text="Extrusion")
        if not bake.use_cage:
            column.prop(bake, "max_ray_distance")


class AJAR_RENDER_PT_bake_output(AjarPanel, Panel):
    bl_label = "Output"
    bl_parent_id = "AJAR_RENDER_PT_bake"

    def draw(self, context: bpy.types.Context) -> None:
        bake = context.scene.render.bake
        column = self.column()
        column.prop(bake, "target")
        if bake.target == "IMAGE_TEXTURES":
            column.prop(bake, "use_clear", text="Clear Image")
            column.prop(bake, "margin_type", text="Margin Type")
            column.prop(bake, "margin", text="Size")


CLASSES = (AJAR_RENDER_PT_bake, AJAR_RENDER_PT_bake_influence, AJAR_RENDER_PT_bake_selected_to_active, AJAR_RENDER_PT_bake_output)
