"""The world tab."""

from __future__ import annotations

import bpy
from bpy.types import Panel

from .. import compat
from .common import AjarPanel, choose_light_group, draw_node


class WorldPanel(AjarPanel):
    bl_context = "world"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.world is not None


class AJAR_WORLD_PT_preview(WorldPanel, Panel):
    bl_label = "Preview"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.template_preview(context.world)


class AJAR_WORLD_PT_surface(WorldPanel, Panel):
    bl_label = "Surface"

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        if not draw_node(self.layout, context.world, "Surface"):
            self.layout.prop(context.world, "color")


class AJAR_WORLD_PT_volume(WorldPanel, Panel):
    bl_label = "Volume"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and compat.node_tree(context.world) is not None

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        draw_node(self.layout, context.world, "Volume")


class AJAR_WORLD_PT_mist(WorldPanel, Panel):
    bl_label = "Mist Pass"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and any(layer.use_pass_mist for layer in context.scene.view_layers)

    def draw(self, context: bpy.types.Context) -> None:
        column, mist = self.column(), context.world.mist_settings
        for name in ("start", "depth", "falloff"):
            column.prop(mist, name)


class AJAR_WORLD_PT_ray_visibility(WorldPanel, Panel):
    bl_label = "Ray Visibility"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        for kind in ("camera", "diffuse", "glossy", "transmission", "volume_scatter"):
            column.prop(context.world.ajar, f"visible_{kind}")


class AJAR_WORLD_PT_settings(WorldPanel, Panel):
    bl_label = "Settings"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        column.prop(context.world.ajar, "max_bounces")
        choose_light_group(column, context.world, context.view_layer)


CLASSES = (AJAR_WORLD_PT_preview, AJAR_WORLD_PT_surface, AJAR_WORLD_PT_volume, AJAR_WORLD_PT_mist, AJAR_WORLD_PT_ray_visibility, AJAR_WORLD_PT_settings)
