"""Properties that have Cycles' value until the artist sets one of their own.

Cycles keeps settings of lamps, objects and so on in its add-on. A file that was made for Cycles is read as it is, and works without that add-on.
"""

from __future__ import annotations

import bpy

from . import compat


def accessors(name: str, default, cycles: str, numbers: dict[str, int] | None = None, group: str = "cycles") -> dict:
    """A getter that falls back to the property `cycles` in Cycles' group, and a setter that ends that. `numbers`: of an enum's items.

    A scene inherits nothing until something of Cycles was set in it: Cycles' own defaults say nothing about the scene.
    """
    key = f"{name}_"

    def get(self):
        stored = self.get(key)
        if stored is not None:
            return stored
        owner = self.id_data
        is_set = not isinstance(owner, bpy.types.Scene) or group != "cycles" or compat.has_cycles_settings(owner)
        value = compat.cycles_value(owner, cycles, default, group) if is_set else default
        return value if numbers is None else numbers.get(value, numbers[default])

    def set_(self, value):
        self[key] = value

    return {"get": get, "set": set_}


def boolean(name: str, label: str, tip: str, default: bool, cycles: str, group: str = "cycles"):
    return bpy.props.BoolProperty(name=label, description=tip, default=default, **accessors(name, default, cycles, None, group))


def integer(name: str, label: str, tip: str, default: int, cycles: str, low: int, high: int, group: str = "cycles"):
    return bpy.props.IntProperty(name=label, description=tip, default=default, min=low, max=high, **accessors(name, default, cycles, None, group))


def number(name: str, label: str, tip: str, default: float, cycles: str, low: float, high: float, group: str = "cycles", **more):
    return bpy.props.FloatProperty(name=label, description=tip, default=default, min=low, max=high, **more,
                                   **accessors(name, default, cycles, None, group))


def enum(name: str, label: str, tip: str, default: str, cycles: str, items: list[tuple[str, str, str, int]], group: str = "cycles"):
    return bpy.props.EnumProperty(name=label, description=tip, default=default, items=items,
                                  **accessors(name, default, cycles, {item[0]: item[3] for item in items}, group))
