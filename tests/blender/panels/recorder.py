"""Lists the properties that the panels of the Properties editor show, for any render engine: each panel draws into a layout that only records.

It needs no window and also runs in a `bpy` module. The caller sets the context of the panels (`context.material` and so on) for each object.
"""

from __future__ import annotations

import inspect
import types
from collections.abc import Iterator

import bpy

Shown = tuple[str, str]   # the struct of the property, and the name of the property


class Notes:
    """Replaces the layout of a panel. It has all methods of UILayout."""

    def __init__(self, shown: set[Shown]) -> None:
        object.__setattr__(self, "_shown", shown)

    def __setattr__(self, name: str, value: object) -> None:
        if name not in bpy.types.UILayout.bl_rna.properties:
            raise AttributeError(f"UILayout has no property {name}")

    def __getattr__(self, name: str):
        functions = bpy.types.UILayout.bl_rna.functions
        if name in bpy.types.UILayout.bl_rna.properties:
            return True
        if name not in functions and not hasattr(bpy.types.UILayout, name):
            raise AttributeError(f"UILayout has no function {name}")

        def call(*arguments: object, **named: object) -> object:
            self._note(name, arguments, named)
            if name in ("panel", "panel_prop"):   # these return a header and a body
                return self._part(), self._part()
            return self._button(arguments[0] if arguments else named["operator"]) if name == "operator" else self._part()
        return call

    def _part(self) -> Notes:
        """The object that stands for a row or a column."""
        return Notes(self._shown)

    def _button(self, operator: str) -> OperatorProperties:
        return OperatorProperties(operator)

    def _note(self, name: str, arguments: tuple, named: dict) -> None:
        data = arguments[0] if arguments else named.get("data")
        prop = arguments[1] if len(arguments) > 1 else named.get("property")
        if name == "menu" and not hasattr(bpy.types, arguments[0] if arguments else named["menu"]):
            raise AttributeError(f"there is no menu {arguments[0]}")
        if name == "template_node_view":
            self._shown.add((name, (arguments[2] if len(arguments) > 2 else named["socket"]).name))
        elif name in ("template_preview", "template_ID"):
            self._shown.add((name, prop if isinstance(prop, str) else type(data).__name__))
        elif isinstance(prop, str) and hasattr(data, "bl_rna"):
            if prop not in data.bl_rna.properties:
                raise AttributeError(f"{data.bl_rna.identifier} has no property {prop}")
            self._shown.add((_owner(data, prop), prop))


class OperatorProperties:
    """The properties with which a button calls its operator. The operator and its properties must exist."""

    def __init__(self, operator: str) -> None:
        category, name = operator.split(".")
        self.__dict__["known"] = getattr(getattr(bpy.ops, category), name).get_rna_type().properties.keys()

    def __setattr__(self, name: str, value: object) -> None:
        if name not in self.known:
            raise AttributeError(f"the operator has no property {name}")


def _owner(data: bpy.types.bpy_struct, name: str) -> str:
    """The most general struct with that property: `visible_camera` belongs to Object, `color` to Light for all kinds of lights."""
    struct = data.bl_rna
    while struct.base is not None and name in struct.base.properties:
        struct = struct.base
    return struct.identifier


class Context:
    """`bpy.context` with some members replaced."""

    def __init__(self, **members: object) -> None:
        self.__dict__.update(members)

    def __getattr__(self, name: str):
        return getattr(bpy.context, name, None)


def panels() -> Iterator[type]:
    def below(kind: type) -> Iterator[type]:
        for panel in kind.__subclasses__():
            yield panel
            yield from below(panel)
    for panel in below(bpy.types.Panel):
        if getattr(panel, "bl_space_type", "") == "PROPERTIES" and panel.is_registered:
            yield panel


class Self:
    """An instance of a panel without a window."""

    def __init__(self, panel: type, layout: Notes) -> None:
        self._panel, self.layout, self.is_popover, self.bl_space_type = panel, layout, False, getattr(panel, "bl_space_type", "PROPERTIES")
        self.bl_idname = getattr(panel, "bl_idname", panel.__name__)

    def __getattr__(self, name: str):
        if isinstance(inspect.getattr_static(self._panel, name), types.FunctionType):
            return types.MethodType(getattr(self._panel, name), self)
        return getattr(self._panel, name)


def shown(tab: str, engine: str, **members: object) -> tuple[set[Shown], list[str]]:
    """The properties that the panels of a tab show with this engine, and the names of these panels. A panel is shown only if its parents are."""
    found: set[Shown] = set()
    drawn: list[str] = []
    context = Context(engine=engine, **{"space_data": types.SimpleNamespace(type="PROPERTIES", pin_id=None, use_pin_id=False)} | members)
    asked: dict[str, bool] = {}
    by_name = {panel.__name__: panel for panel in panels()}

    def is_shown(panel: type) -> bool:
        name = panel.__name__
        if name not in asked:
            parent = getattr(panel, "bl_parent_id", "")
            asked[name] = (not parent or parent not in by_name or is_shown(by_name[parent])) and (not hasattr(panel, "poll") or bool(panel.poll(context)))
        return asked[name]

    def tab_of(panel: type) -> str:
        """The tab of its parent panel, or its own."""
        parent = by_name.get(getattr(panel, "bl_parent_id", ""))
        return tab_of(parent) if parent is not None else getattr(panel, "bl_context", "")

    for panel in by_name.values():
        if tab_of(panel) != tab or panel.draw.__module__ == "rna_prop_ui" or not is_shown(panel):   # custom properties are shown with every engine
            continue
        drawn.append(panel.__name__)
        for part in ("draw_header", "draw"):
            if part in vars(panel) or (hasattr(panel, part) and part == "draw"):
                getattr(panel, part)(Self(panel, Notes(found)), context)
    return found, drawn
