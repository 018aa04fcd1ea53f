"""The object and collection tabs."""

from __future__ import annotations

import bpy
from bpy.types import Panel

from .. import compat
from .common import AjarPanel, choose_light_group, say

VISIBLE = {"MESH", "CURVE", "CURVES", "SURFACE", "META", "FONT", "POINTCLOUD", "VOLUME"}
LIT = VISIBLE | {"LIGHT"}   # types of objects that can emit light


class ObjectPanel(AjarPanel):
    bl_context = "object"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object is not None


class AJAR_OBJECT_PT_motion_blur(ObjectPanel, Panel):
    bl_label = "Motion Blur"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object.type in VISIBLE | {"CAMERA", "EMPTY"}

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.object.ajar, "use_motion_blur", text="")

    def draw(self, context: bpy.types.Context) -> None:
        column, settings = self.column(), context.object.ajar
        column.active = settings.use_motion_blur and context.scene.render.use_motion_blur
        column.prop(settings, "motion_steps")
        if context.object.type in VISIBLE:
            column.prop(settings, "use_deform_motion")


class AJAR_OBJECT_PT_shading(ObjectPanel, Panel):
    bl_label = "Shading"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object.type in VISIBLE

    def draw(self, context: bpy.types.Context) -> None:
        self.column().prop(compat.terminator_owner(context.object), "shadow_terminator_geometry_offset", text="Shadow Terminator Offset")


class AJAR_OBJECT_PT_subdivision(ObjectPanel, Panel):
    """Since 5.0, the modifier has these settings."""

    bl_label = "Adaptive Subdivision"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object.type == "MESH" and not compat.adapts_by_modifier()

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.object.ajar, "use_adaptive_subdivision", text="")

    def draw(self, context: bpy.types.Context) -> None:
        column, settings = self.column(), context.object.ajar
        column.active = settings.use_adaptive_subdivision
        column.prop(settings, "dicing_rate")
        modifiers = context.object.modifiers
        if settings.use_adaptive_subdivision and (len(modifiers) == 0 or modifiers[-1].type != "SUBSURF"):
            say(column, "The last modifier must be a Subdivision Surface", context, "ERROR")


class AJAR_OBJECT_PT_visibility(ObjectPanel, Panel):
    bl_label = "Visibility"

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        thing = context.object
        self.layout.prop(thing, "hide_select", text="Selectable", invert_checkbox=True, toggle=False)
        if hasattr(thing, "hide_surface_pick"):   # 5.0
            self.layout.prop(thing, "hide_surface_pick", text="Surface Picking", invert_checkbox=True, toggle=False)
        column = self.layout.column(heading="Show In")
        column.prop(thing, "hide_viewport", text="Viewports", invert_checkbox=True, toggle=False)
        column.prop(thing, "hide_render", text="Renders", invert_checkbox=True, toggle=False)
        if thing.type in VISIBLE | {"LIGHT"}:
            column = self.layout.column(heading="Mask")
            column.prop(thing, "is_shadow_catcher")
            column.prop(thing, "is_holdout")


class AJAR_OBJECT_PT_ray_visibility(ObjectPanel, Panel):
    bl_label = "Ray Visibility"
    bl_parent_id = "AJAR_OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object.type in VISIBLE | {"LIGHT"}

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        column = self.layout.column()
        for kind in ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow"):
            if kind != "shadow" or context.object.type != "LIGHT":
                column.prop(context.object, f"visible_{kind}", text=kind.replace("_", " ").title(), toggle=False)


class AJAR_OBJECT_PT_culling(ObjectPanel, Panel):
    bl_label = "Culling"
    bl_parent_id = "AJAR_OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object.type in LIT

    def draw(self, context: bpy.types.Context) -> None:
        column, scene = self.column(), context.scene
        for name in ("use_camera_cull", "use_distance_cull"):
            row = column.row()
            row.active = scene.render.use_simplify and getattr(scene.ajar, name)
            row.prop(context.object.ajar, name)


def _links_itself(thing: bpy.types.Object) -> bool:
    """Whether Ajar shows light linking: in Blender 4.0 to 4.2, whose own panels are of Cycles only."""
    return thing.type in LIT and compat.light_linking(thing) is not None and not hasattr(bpy.types, "OBJECT_PT_light_linking")


def _draw_links(layout: bpy.types.UILayout, thing: bpy.types.Object, kind: str) -> None:
    links, name = compat.light_linking(thing), f"{kind}_collection"
    layout.template_ID(links, name, new=f"object.light_linking_{kind}_collection_new")
    if getattr(links, name) is not None:
        layout.template_light_linking_collection(layout.row(), links, name)


class AJAR_OBJECT_PT_light_linking(ObjectPanel, Panel):
    bl_label = "Light Linking"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and _links_itself(context.object)

    def draw(self, context: bpy.types.Context) -> None:
        _draw_links(self.column(), context.object, "receiver")


class AJAR_OBJECT_PT_shadow_linking(ObjectPanel, Panel):
    bl_label = "Shadow Linking"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and _links_itself(context.object)

    def draw(self, context: bpy.types.Context) -> None:
        _draw_links(self.column(), context.object, "blocker")


class AJAR_OBJECT_PT_importance(ObjectPanel, Panel):
    bl_label = "Sampling"

    def draw(self, context: bpy.types.Context) -> None:
        column, thing = self.column(), context.object
        column.prop(thing.ajar, "importance")
        if thing.type in LIT:
            choose_light_group(column, thing, context.view_layer)


class AJAR_COLLECTION_PT_importance(AjarPanel, Panel):
    bl_label = "Sampling"
    bl_context = "collection"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.collection is not None

    def draw(self, context: bpy.types.Context) -> None:
        self.column().prop(context.collection.ajar, "importance")


CLASSES = (AJAR_OBJECT_PT_motion_blur, AJAR_OBJECT_PT_shading, AJAR_OBJECT_PT_subdivision, AJAR_OBJECT_PT_visibility, AJAR_OBJECT_PT_ray_visibility,
           AJAR_OBJECT_PT_culling, AJAR_OBJECT_PT_light_linking, AJAR_OBJECT_PT_shadow_linking, AJAR_OBJECT_PT_importance,
           AJAR_COLLECTION_PT_importance)
