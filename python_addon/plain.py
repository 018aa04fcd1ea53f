"""Settings of Ajar for render threads: the values that Blender returns, read without Blender's getters.

Blender has one flag for all threads that tells whether Python may write. While the Python getter of a property runs, writing is allowed; then the old
value of the flag is restored. A panel forbids writing while the main thread draws it. If a render thread calls a getter at this time, it later
restores the state of the panel, whose drawing has ended. Then every operator that a timer or a handler calls is refused ("can't modify blend data in
this state"). Render threads therefore call the getters directly.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import bpy

_KINDS = {bpy.props.BoolProperty: bool, bpy.props.IntProperty: int, bpy.props.FloatProperty: float}


@cache
def _readers(group: type) -> dict[str, Callable[[bpy.types.PropertyGroup], Any]]:
    """The getters of the properties that have one. They return the values that Blender would return."""
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
    """Has the same attributes as its property group."""

    __slots__ = ("_group",)

    def __init__(self, group: bpy.types.PropertyGroup) -> None:
        self._group = group

    def __getattr__(self, name: str):
        group: type = type(self._group)
        reader = _readers(group).get(name)
        return getattr(self._group, name) if reader is None else reader(self._group)


def of(struct: bpy.types.bpy_struct) -> bpy.types.bpy_struct | Plain:
    """A group of Ajar without Blender's getters; any other struct is returned unchanged."""
    return Plain(struct) if isinstance(struct, bpy.types.PropertyGroup) and hasattr(type(struct), "__annotations__") else struct
