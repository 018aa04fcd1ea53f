"""Ajar: a render engine that finds the light other engines miss."""

from __future__ import annotations

bl_info = {
    "name": "Ajar Render Engine",
    "author": "The Ajar authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render Properties > Render Engine > Ajar",
    "description": "Path tracing by sequential Monte Carlo",
    "category": "Render",
    "support": "COMMUNITY",
}

from . import checks, engine, headless, hint_overlay, hints, presets, properties, ui, viewport  # noqa: E402

MODULES = (properties, engine, viewport, hints, hint_overlay, checks, presets, ui)


def register() -> None:
    headless.check()
    for module in MODULES:
        module.register()


def unregister() -> None:
    for module in reversed(MODULES):
        module.unregister()
