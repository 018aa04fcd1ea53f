"""Ajar: a render engine that finds the light other engines miss."""

from __future__ import annotations

import traceback
from types import ModuleType

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

from . import documentation, self_check, translations  # noqa: E402

try:
    from . import ajar_module  # noqa: F401
except ImportError:
    self_check.import_failure = traceback.format_exc()
    print(self_check.import_failure, flush=True)
    MODULES: tuple[ModuleType, ...] = (translations, documentation, self_check)   # the self-check reports why the renderer cannot be loaded
else:
    from . import bake, checks, denoise, engine, headless, hint_overlay, hints, interrupted, learning, pausing, persistent, photon_overlay, presets, properties, ui, viewport

    MODULES = (translations, documentation, self_check, properties, engine, bake, interrupted, learning, persistent, viewport, pausing, hints, hint_overlay, photon_overlay, checks, presets, denoise, ui)


def register() -> None:
    if not self_check.import_failure:
        headless.check()
    for module in MODULES:
        module.register()


def unregister() -> None:
    for module in reversed(MODULES):
        module.unregister()
