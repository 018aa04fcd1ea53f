"""Properties that have the value of Cycles until the artist sets a value in Ajar.

Cycles stores settings of lamps, objects and other datablocks in its add-on. Files for Cycles can be rendered unchanged, also without this add-on.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy

from . import compat, plain

NAMES: set[str] = set()   # names of all properties that inherit
OWN_SUFFIX = "_"   # of the key under which a value of Ajar is stored


def accessors(name: str, default, cycles: str, numbers: dict[str, int] | None = None, group: str = "cycles", read: Callable | None = None) -> dict:
    """A getter that returns the property `cycles` of the group of Cycles until the setter was called. `numbers`: numbers of the items of an enum.
    `read(owner, default)` replaces the property if the value depends on several properties.

    A scene inherits while `use_cycles_settings` is on. By default it is on if a property of Cycles was set in the scene, since defaults of Cycles are
    not a choice of the artist.
    """
    key = name + OWN_SUFFIX
    NAMES.add(name)

    def get(self):
        stored = self.get(key)
        if stored is None:
            stored = self.get(name)   # from a file that is older than the inheritance of this property
        if stored is not None:
            return stored
        owner = self.id_data
        inherits = not isinstance(owner, bpy.types.Scene) or group != "cycles" or plain.of(owner.ajar).use_cycles_settings
        if inherits and read is not None:
            return read(owner, default)
        value = compat.cycles_value(owner, cycles, default, group) if inherits else default
        return value if numbers is None else numbers.get(value, numbers[default])

    def set_(self, value):
        self[key] = value

    return {"get": get, "set": set_}


def is_own(settings: bpy.types.PropertyGroup, name: str) -> bool:
    """Whether the artist has set the property in Ajar."""
    return settings.get(name + OWN_SUFFIX) is not None or settings.get(name) is not None


def forget_own(settings: bpy.types.PropertyGroup) -> None:
    """Remove the values of Ajar, so that all properties inherit again."""
    for name in NAMES & set(settings.bl_rna.properties.keys()):
        for key in (name + OWN_SUFFIX, name):
            if settings.get(key) is not None:
                del settings[key]


def noise_of_cycles(scene: bpy.types.Scene, default: float) -> float:
    """The noise target from the noise threshold of Cycles, which bounds the relative error of each pixel. The target of Ajar is the mean of its square."""
    if not compat.cycles_value(scene, "use_adaptive_sampling", False):
        return default
    return float(compat.cycles_value(scene, "adaptive_threshold", 0.0)) ** 2


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
