"""Light hints: the list in the render tab and the 3D view, and the settings of one curve."""

from __future__ import annotations

import bpy
from bpy.types import Panel

from .. import checks, documentation, hints, last_render
from ..ajar_module import ajar
from ..translations import interface
from .common import ENGINE, AjarPanel, say


def draw_hints(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """Draw the list of the light hints of the scene with their states."""
    scene = context.scene
    layout.prop_search(scene.ajar, "hint_collection", bpy.data, "collections", text="Collection")
    for curve in hints.curves_of(scene):
        known = hints.attachment_of(curve)
        row = layout.row()
        row.use_property_split = False
        row.active = curve.ajar.hint_enabled
        icon = "CURVE_DATA" if known is None else "CHECKMARK" if known.attached else "ERROR"
        row.prop(curve.ajar, "hint_enabled", text="")
        row.label(text=curve.name, icon=icon, translate=False)
        worth = last_render.of_hint(scene, curve.name)
        if worth is not None and _worth(worth):
            row = layout.row()
            row.label(icon="BLANK1")
            say(row, _worth(worth), context)
        if known is not None and not known.attached:
            say(layout, known.reason, context)
    buttons = layout.column(align=True)
    buttons.operator("ajar.draw_light_hint", icon="GREASEPENCIL")
    buttons.operator("ajar.mark_light_hint", icon="ADD")
    buttons.operator("ajar.unmark_light_hint", icon="REMOVE")
    buttons.operator("ajar.check_light_hints", icon="VIEWZOOM")
    buttons.operator("ajar.suggest_light_hints", icon="LIGHT")


def _worth(worth: dict) -> str:
    """The statistics of a light hint in the last render, as text."""
    words = []
    if worth.get("proposed"):
        words.append(interface("{number:,.0f} proposed", number=worth["proposed"]))
        if "accepted" in worth:
            words.append(interface("{share:.0%} accepted", share=worth["accepted"] / worth["proposed"]))
    if "energy_share" in worth:
        words.append(interface("{share:.1%} of the light", share=worth["energy_share"]))
    return ", ".join(words)


class AJAR_RENDER_PT_hints(AjarPanel, Panel):
    bl_label = "Light Hints"

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.ajar
        column = self.column()
        if not {settings.integrator, settings.viewport_integrator} & checks.HINT_INTEGRATORS:
            names = [interface(info.label) for info in ajar.integrator_list() if info.name in checks.HINT_INTEGRATORS]
            say(column, interface("The chosen integrator does not use them. These do: {names}", names=", ".join(names)), context)
        draw_hints(column, context)


class AJAR_VIEW3D_PT_hints(Panel):
    bl_label = "Light Hints"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Ajar"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine == ENGINE

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        documentation.draw_button(self.layout, type(self))

    def draw(self, context: bpy.types.Context) -> None:
        draw_hints(self.layout.column(), context)


class AJAR_OBJECT_PT_light_hint(AjarPanel, Panel):
    """Settings of a curve in the collection of light hints."""
    bl_label = "Light Hint"
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
        say(column, hints.status_of(context.object), context)
        worth = last_render.of_hint(context.scene, context.object.name)
        if worth is not None:
            column.label(text=interface("Last render: {worth}", worth=_worth(worth)))


CLASSES = (AJAR_RENDER_PT_hints, AJAR_OBJECT_PT_light_hint, AJAR_VIEW3D_PT_hints)
