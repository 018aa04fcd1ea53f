"""Statistics of the last render of each scene, for the panels. They are kept until Blender ends."""

from __future__ import annotations

import bpy

_statistics: dict[str, dict] = {}


def remember(scene_name: str, statistics: dict) -> None:
    _statistics[scene_name] = statistics


def of(scene: bpy.types.Scene) -> dict | None:
    return _statistics.get(scene.name)


def of_hint(scene: bpy.types.Scene, name: str) -> dict | None:
    """The statistics of a light hint in the last render, if its integrator has them."""
    hints = (of(scene) or {}).get("hints", [])
    return next((hint for hint in hints if isinstance(hint, dict) and hint.get("name") == name), None)
