"""The settings of the core as properties of Blender: names, texts, ranges, defaults and choices come from the core's own table (`ajar.setting_list()`).

Where Cycles has the same setting, the property inherits from it (inherited.py).
"""

from __future__ import annotations

from typing import Any

import bpy

from . import inherited
from .ajar_module import ajar

SETTINGS: dict[str, Any] = {info.property: info for info in ajar.setting_list() if info.property}
UNBOUNDED = float("inf")


def integrator_items() -> list[tuple[str, str, str, int]]:
    return [(info.name, info.label, info.sentence, info.number) for info in ajar.integrator_list()]


def names(prop: str) -> tuple[str, ...]:
    """Of the choices of a property, in the order of the user interface."""
    return tuple(item[0] for item in items(prop))


def items(prop: str) -> list[tuple[str, str, str, int]]:
    info = SETTINGS[prop]
    return integrator_items() if info.type == "name" else list(info.choices)


def _range(info) -> dict[str, Any]:
    """Of a number, as arguments of a property."""
    kind = int if info.type == "int" else float
    bounds = {"min": info.property_minimum, "max": info.property_maximum, "soft_max": info.property_soft_maximum}
    return {key: kind(value) for key, value in bounds.items() if abs(value) < UNBOUNDED}


def definition(prop: str, cycles: str = "", capitals: bool = False, **more):
    """The property for the setting. `cycles`: the property of Cycles from which it inherits. `capitals`: the names of choices are in capitals, as those of
    Cycles."""
    info = SETTINGS[prop]
    common = {"name": info.label, "description": info.description, "default": info.property_default}
    numbers = None
    if info.type in ("choice", "name"):
        make = bpy.props.EnumProperty
        common["items"] = [(name.upper() if capitals else name, *rest) for name, *rest in items(prop)]
        if capitals:
            common["default"] = common["default"].upper()
        numbers = {item[0]: item[3] for item in common["items"]}
    elif info.type == "bool":
        make = bpy.props.BoolProperty
    else:
        make = bpy.props.IntProperty if info.type == "int" else bpy.props.FloatProperty
        common |= _range(info) | {"subtype": info.subtype}
    if cycles and "get" not in more:
        more |= inherited.accessors(prop, common["default"], cycles, numbers)
    return make(**common, **more)
