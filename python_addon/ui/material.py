"""The material tab."""

from __future__ import annotations

import bpy
from bpy.types import Panel

from .. import compat
from .common import AjarPanel, draw_node


class MaterialPanel(AjarPanel):
    bl_context = "material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.material is not None and not context.material.grease_pencil


class AJAR_MATERIAL_PT_slots(AjarPanel, Panel):
    """The material slots of the object, and the material of the active slot."""

    bl_label = ""
    bl_context = "material"
    bl_options = {"HIDE_HEADER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        thing, material = context.object, context.material
        is_grease_pencil = (thing is not None and thing.type in ("GPENCIL", "GREASEPENCIL")) or (material is not None and bool(material.grease_pencil))
        return super().poll(context) and (thing is not None or material is not None) and not is_grease_pencil

    def draw(self, context: bpy.types.Context) -> None:
        layout, thing, slot = self.layout, context.object, context.material_slot
        if thing is None:
            layout.template_ID(context.space_data, "pin_id")
            return
        several = len(thing.material_slots) > 1
        row = layout.row()
        row.template_list("MATERIAL_UL_matslots", "", thing, "material_slots", thing, "active_material_index", rows=5 if several else 3)
        buttons = row.column(align=True)
        buttons.operator("object.material_slot_add", icon="ADD", text="")
        buttons.operator("object.material_slot_remove", icon="REMOVE", text="")
        buttons.separator()
        buttons.menu("MATERIAL_MT_context_menu", icon="DOWNARROW_HLT", text="")
        if several:
            buttons.separator()
            buttons.operator("object.material_slot_move", icon="TRIA_UP", text="").direction = "UP"
            buttons.operator("object.material_slot_move", icon="TRIA_DOWN", text="").direction = "DOWN"
        row = layout.row()
        row.template_ID(thing, "active_material", new="material.new")
        if slot is not None:
            row.prop(slot, "link", text="", icon="MESH_DATA" if slot.link == "DATA" else "OBJECT_DATA", icon_only=True)
        if thing.mode == "EDIT":
            row = layout.row(align=True)
            for action in ("assign", "select", "deselect"):
                row.operator(f"object.material_slot_{action}", text=action.capitalize())


class AJAR_MATERIAL_PT_preview(MaterialPanel, Panel):
    bl_label = "Preview"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.template_preview(context.material)


class AJAR_MATERIAL_PT_surface(MaterialPanel, Panel):
    bl_label = "Surface"

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        if not draw_node(self.layout, context.material, "Surface"):
            self.layout.prop(context.material, "diffuse_color")


class MaterialNodePanel(MaterialPanel):
    """The node that is linked to the input of the output with the name of the panel."""

    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and compat.node_tree(context.material) is not None

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        draw_node(self.layout, context.material, self.bl_label)


class AJAR_MATERIAL_PT_volume(MaterialNodePanel, Panel):
    bl_label = "Volume"


class AJAR_MATERIAL_PT_displacement(MaterialNodePanel, Panel):
    bl_label = "Displacement"


class AJAR_MATERIAL_PT_settings(MaterialPanel, Panel):
    bl_label = "Settings"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = self.column()
        column.prop(context.material, "pass_index")
        column.prop(compat.displacement_owner(context.material), "displacement_method", text="Displacement")
        column.prop(compat.transparency_owner(context.material), "use_transparent_shadow")
        if compat.has_bump_correction():
            column.prop(context.material.ajar, "use_bump_map_correction")


CLASSES = (AJAR_MATERIAL_PT_slots, AJAR_MATERIAL_PT_preview, AJAR_MATERIAL_PT_surface, AJAR_MATERIAL_PT_volume, AJAR_MATERIAL_PT_displacement,
           AJAR_MATERIAL_PT_settings)
