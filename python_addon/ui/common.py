"""Code that the panels of Ajar share."""

from __future__ import annotations

import blf
import bpy

from .. import compat, documentation, inherited
from ..translations import interface

ENGINE = "AJAR"
MARGINS, ICON = 72, 20   # in pixels: space beside a text in a panel, including the scroll bar; width of an icon


class WithManual:
    """Base class of panels whose header has a button that opens the manual at the panel."""

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        documentation.draw_button(self.layout, type(self))


class AjarPanel(WithManual):
    """Base class of panels of the Properties editor."""

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


def _wrapped(text: str, context: bpy.types.Context, icon: bool = False) -> list[str]:
    """Split a sentence into lines that fit the panel, since labels of Blender have one line. With `icon`, each line leaves space for an icon."""
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


def say(layout: bpy.types.UILayout, text: str, context: bpy.types.Context, icon: str = "NONE") -> None:
    """Draw a sentence in the language of the artist, with an icon before its first line."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, line in enumerate(_wrapped(interface(text), context, icon != "NONE")):
        column.label(text=line, icon=icon if number == 0 or icon == "NONE" else "BLANK1", translate=False)


def draw_inherited(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup, name: str, **more) -> None:
    """Draw a setting of the scene, in grey while its value is that of Cycles."""
    row = layout.row()
    row.active = not settings.use_cycles_settings or inherited.is_own(settings, name)
    row.prop(settings, name, **more)


def choose_light_group(layout: bpy.types.UILayout, source: bpy.types.Object | bpy.types.World, view_layer: bpy.types.ViewLayer) -> None:
    row = layout.row(align=True)
    row.prop_search(source, "lightgroup", view_layer, "lightgroups", text="Light Group", results_are_suggestions=True)
    add = row.row(align=True)
    add.enabled = bool(source.lightgroup) and source.lightgroup not in view_layer.lightgroups
    add.operator("scene.view_layer_add_lightgroup", icon="ADD", text="").name = source.lightgroup


def draw_node(layout: bpy.types.UILayout, owner: bpy.types.Material | bpy.types.World | bpy.types.Light, name: str) -> bool:
    """Draw the node that is linked to the input `name` of the output, with Blender's menu of links. Returns False if `owner` uses no nodes."""
    tree = compat.node_tree(owner)
    if tree is None:
        layout.prop(owner, "use_nodes", icon="NODETREE")
        return False
    output = tree.get_output_node("CYCLES")   # the exported output
    socket = output.inputs.get(name) if output is not None else None
    if socket is None:
        layout.label(text="No output node")
    else:
        layout.template_node_view(tree, output, socket)
    return True


def in_node_editor(panel: type) -> type:
    """A copy of a panel for the tab Options in the sidebar of the shader editor."""
    values = {name: value for name, value in vars(panel).items() if name != "bl_rna"}
    values |= {"bl_space_type": "NODE_EDITOR", "bl_region_type": "UI", "bl_category": "Options"}
    if "bl_parent_id" in values:
        values["bl_parent_id"] = f"NODE_{values['bl_parent_id']}"
    return type(f"NODE_{panel.__name__}", panel.__bases__, values)
