"""Settings of Ajar as a render thread reads them: what Blender gives, without its detour.

Blender keeps one flag for all threads that says whether Python may write. While the Python getter of a property runs, writing is allowed; then the flag is restored. A panel that is drawn in the
main thread at that moment has forbidden it for as long as it draws. What a render thread restores is then the panel's state, which has ended, and every operator that a timer or a handler calls
later is refused ("can't modify blend data in this state"). So render threads call the getters themselves.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import bpy

_KINDS = {bpy.props.BoolProperty: bool, bpy.props.IntProperty: int, bpy.props.FloatProperty: float}


@cache
def _readers(group: type) -> dict[str, Callable[[bpy.types.PropertyGroup], Any]]:
    """The getter of each property that has one, giving what Blender would."""
    found = {}
    for name, declared in group.__annotations__.items():
        get = declared.keywords.get("get")
        if get is None:
            continue
        items = declared.keywords.get("items")
        if items is None:
            kind = _KINDS[declared.function]
            found[name] = lambda settings, get=get, kind=kind: kind(get(settings))
        else:
            names = {item[3]: item[0] for item in items}
            found[name] = lambda settings, get=get, names=names: names[get(settings)]
    return found


class Plain:
    """Reads like the property group it stands for."""

    __slots__ = ("_group",)

    def __init__(self, group: bpy.types.PropertyGroup) -> None:
        self._group = group

    def __getattr__(self, name: str):
        reader = _readers(type(self._group)).get(name)
        return getattr(self._group, name) if reader is None else reader(self._group)


def of(struct: bpy.types.bpy_struct) -> bpy.types.bpy_struct | Plain:
    """A group of ours without Blender's getters; any other struct as it is."""
    return Plain(struct) if isinstance(struct, bpy.types.PropertyGroup) and hasattr(type(struct), "__annotations__") else struct
