"""Statistics of each scene's last render, for the panels. They last as long as Blender runs."""

from __future__ import annotations

import bpy

_statistics: dict[str, dict] = {}


def remember(scene_name: str, statistics: dict) -> None:
    _statistics[scene_name] = statistics


def of(scene: bpy.types.Scene) -> dict | None:
    return _statistics.get(scene.name)


def of_hint(scene: bpy.types.Scene, name: str) -> dict | None:
    """What a light hint was worth in the last render, where its integrator says so."""
    hints = (of(scene) or {}).get("hints", [])
    return next((hint for hint in hints if isinstance(hint, dict) and hint.get("name") == name), None)
