"""The data tab of lamps."""

from __future__ import annotations

import bpy
from bpy.types import Panel

from .. import compat
from .common import AjarPanel, draw_node


class LightPanel(AjarPanel):
    bl_context = "data"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.light is not None


class AJAR_LIGHT_PT_light(LightPanel, Panel):
    bl_label = "Light"

    def draw(self, context: bpy.types.Context) -> None:
        light = context.light
        self.layout.row().prop(light, "type", expand=True)
        self.layout.use_property_split = True
        column = self.layout.column()
        if hasattr(light, "use_temperature"):   # 4.5
            row = column.row(align=True, heading="Temperature")
            row.prop(light, "use_temperature", text="")
            value = row.row()
            value.active = light.use_temperature
            value.prop(light, "temperature", text="")
        column.prop(light, "color", text="Tint" if getattr(light, "use_temperature", False) else "Color")
        column.prop(light, "energy")
        for name in ("exposure", "normalize"):   # 4.5
            if hasattr(light, name):
                column.prop(light, name)
        column.separator()
        _draw_size(column, light)
        column.separator()
        column.prop(light.ajar, "max_bounces")
        column.prop(*compat.shadow_owner(light), text="Cast Shadow")
        column.prop(light.ajar, "use_multiple_importance_sampling")
        if light.type == "AREA":
            column.prop(light.ajar, "is_portal")


def _draw_size(column: bpy.types.UILayout, light: bpy.types.Light) -> None:
    if light.type == "SUN":
        column.prop(light, "angle")
    elif light.type == "AREA":
        column.prop(light, "shape")
        two_sizes = light.shape in ("RECTANGLE", "ELLIPSE")
        sizes = column.column(align=True)
        sizes.prop(light, "size", text="Size X" if two_sizes else "Size")
        if two_sizes:
            sizes.prop(light, "size_y", text="Y")
    else:
        column.prop(light, "shadow_soft_size", text="Radius")
        if hasattr(light, "use_soft_falloff"):
            column.prop(light, "use_soft_falloff")


class BeamPanel(LightPanel):
    """Has the poll function of a panel and of its copy for the shader editor, which is not a subclass of the panel."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.light.type in ("SPOT", "AREA")


class AJAR_LIGHT_PT_beam(BeamPanel, Panel):
    bl_label = "Beam Shape"
    bl_parent_id = "AJAR_LIGHT_PT_light"

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        column, light = self.layout.column(), context.light
        if light.type == "SPOT":
            column.prop(light, "spot_size", text="Angle")
            column.prop(light, "spot_blend", text="Blend", slider=True)
            column.prop(light, "show_cone")
        else:
            column.prop(light, "spread")


class AJAR_LIGHT_PT_nodes(LightPanel, Panel):
    bl_label = "Nodes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        draw_node(self.layout, context.light, "Surface")


CLASSES = (AJAR_LIGHT_PT_light, AJAR_LIGHT_PT_beam, AJAR_LIGHT_PT_nodes)
