"""The manual inside the add-on: pages of HTML, and the links to them.

Right click > Online Manual and F1 use Blender's manual maps to find the page of a property or an operator. The map of Ajar has an anchor in the
settings page for each. The button in the header of each panel, the Help menu and the preferences of the add-on open the manual by
`AJAR_OT_open_manual`. `tools/manual/pages.py` builds the pages from docs/manual.
"""

# No `from __future__ import annotations`: Blender needs the annotations as objects, not as text.

import webbrowser
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy

from .translations import report

FOLDER = Path(__file__).parent / "manual"
FIRST_PAGE, SETTINGS_PAGE = "index.html", "settings.html"
OLD_NAME, NAME = "light_path", "light_hint"   # in the names of operators that are registered under two names


def anchor_of_id(rna_id: str) -> str:
    """The anchor of an id such as "bpy.types.AjarSceneSettings.samples" in the settings page, in the form of Blender's manual."""
    return rna_id.lower().replace(".", "-")


def anchor_of_panel(panel: type) -> str:
    """Copies of panels for the node editors share the anchor of the original."""
    return panel.__name__.removeprefix("NODE_").lower()


def own(kind: Any) -> Iterator[Any]:
    """The subclasses of `kind` that belong to the add-on."""
    return (found for found in kind.__subclasses__() if found.__module__.startswith(__package__))


def ids_of_properties() -> Iterator[str]:
    """The RNA ids of all settings of Ajar. `name` is omitted, since every property group has it."""
    for group in own(bpy.types.PropertyGroup):
        yield from (f"bpy.types.{group.__name__}.{name}" for name in group.bl_rna.properties.keys() if name not in ("rna_type", "name"))


def ids_of_operators() -> Iterator[str]:
    yield from (f"bpy.ops.{operator.bl_idname}" for operator in own(bpy.types.Operator))


def url_of(page: str) -> str:
    """The URL of a page, with or without an anchor."""
    return f"{FOLDER.as_uri()}/{page}"


def manual_map() -> tuple[str, list[tuple[str, str]]]:
    """The argument of bpy.utils.register_manual_map: a prefix, and pairs of a pattern and a suffix."""
    pairs = [(rna_id.lower(), f"{SETTINGS_PAGE}#{anchor_of_id(rna_id)}") for rna_id in ids_of_properties()]
    pairs += [(rna_id.lower(), f"{SETTINGS_PAGE}#{anchor_of_id(rna_id.replace(OLD_NAME, NAME))}") for rna_id in ids_of_operators()]
    return url_of(""), pairs


class AJAR_OT_open_manual(bpy.types.Operator):
    bl_idname = "ajar.open_manual"
    bl_label = "Ajar Manual"
    bl_description = "Open the manual of Ajar in the web browser"

    page: bpy.props.StringProperty(name="Page", description="File name of the page, with an anchor or without", default=FIRST_PAGE, options={"SKIP_SAVE"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        file = FOLDER / self.page.partition("#")[0]
        if not file.is_file():
            self.report({"ERROR"}, report("This page of the manual is missing: {file}", file=file))
            return {"CANCELLED"}
        webbrowser.open(url_of(self.page))
        return {"FINISHED"}


def draw_button(layout: bpy.types.UILayout, panel: type) -> None:
    """A button that opens the manual at a panel."""
    layout.operator(AJAR_OT_open_manual.bl_idname, text="", icon="HELP", emboss=False).page = f"{SETTINGS_PAGE}#{anchor_of_panel(panel)}"


def _draw_in_help_menu(self, context: bpy.types.Context) -> None:
    self.layout.separator()
    self.layout.operator(AJAR_OT_open_manual.bl_idname, icon="HELP")


def register() -> None:
    bpy.utils.register_class(AJAR_OT_open_manual)
    bpy.utils.register_manual_map(manual_map)
    bpy.types.TOPBAR_MT_help.append(_draw_in_help_menu)


def unregister() -> None:
    bpy.types.TOPBAR_MT_help.remove(_draw_in_help_menu)
    bpy.utils.unregister_manual_map(manual_map)
    bpy.utils.unregister_class(AJAR_OT_open_manual)
