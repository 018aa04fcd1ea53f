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
    found: dict[str, Callable[[Any], Any]] = {}
    for name, declared in group.__annotations__.items():
        get = declared.keywords.get("get")
        if get is None:
            continue
        items = declared.keywords.get("items")
        found[name] = _reader(get, _KINDS[declared.function] if items is None else {item[3]: item[0] for item in items}.__getitem__)
    return found


def _reader(get: Callable[[Any], Any], kind: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda settings: kind(get(settings))


class Plain:
    """Reads like the property group it stands for."""

    __slots__ = ("_group",)

    def __init__(self, group: bpy.types.PropertyGroup) -> None:
        self._group = group

    def __getattr__(self, name: str):
        group: type = type(self._group)
        reader = _readers(group).get(name)
        return getattr(self._group, name) if reader is None else reader(self._group)


def of(struct: bpy.types.bpy_struct) -> bpy.types.bpy_struct | Plain:
    """A group of ours without Blender's getters; any other struct as it is."""
    return Plain(struct) if isinstance(struct, bpy.types.PropertyGroup) and hasattr(type(struct), "__annotations__") else struct
