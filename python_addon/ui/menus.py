"""Menus of Blender that hide entries from engines other than Cycles: shader nodes in the Add menu, and Indirect Only in the Outliner."""

from __future__ import annotations

import importlib
from types import ModuleType

import bpy

from .common import ENGINE

# Modules in which Blender checks whether to offer shader nodes: until 3.6, and later.
_MODULES = ("nodeitems_builtins", "bl_ui.node_add_menu_shader")
_QUESTION = "cycles_shader_nodes_poll"
_originals: dict[ModuleType, object] = {}


def _draw_indirect_only(self, context: bpy.types.Context) -> None:
    if context.engine == ENGINE:
        self.layout.operator("outliner.collection_indirect_only_set")
        self.layout.operator("outliner.collection_indirect_only_clear")


def register() -> None:
    for name in _MODULES:
        try:
            module = importlib.import_module(name)
        except ImportError:   # this Blender does not have the module
            continue
        original = getattr(module, _QUESTION, None)
        if original is not None:
            _originals[module] = original
            setattr(module, _QUESTION, lambda context, original=original: context.engine == ENGINE or original(context))
    bpy.types.OUTLINER_MT_collection_view_layer.append(_draw_indirect_only)


def unregister() -> None:
    bpy.types.OUTLINER_MT_collection_view_layer.remove(_draw_indirect_only)
    for module, original in _originals.items():
        setattr(module, _QUESTION, original)
    _originals.clear()
