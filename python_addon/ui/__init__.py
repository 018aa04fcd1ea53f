"""Panels: those of Ajar, a module for each tab of the Properties editor, and those of Blender that apply to Ajar."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Panel

from . import bake, camera, hints, light, material, menus, object, progress, render, view_layer, world
from .common import ENGINE, AjarPanel, in_node_editor

__all__ = ["CLASSES", "AjarPanel", "built_in_panels", "register", "unregister"]

MODULES = (render, bake, progress, hints, view_layer, world, object, material, light, camera)
IN_NODE_EDITORS = (material.AJAR_MATERIAL_PT_settings, world.AJAR_WORLD_PT_ray_visibility, world.AJAR_WORLD_PT_settings, light.AJAR_LIGHT_PT_light,
                   light.AJAR_LIGHT_PT_beam)
BELOW_SIMPLIFY = (render.AJAR_RENDER_PT_texture_size, render.AJAR_RENDER_PT_culling)   # below the copy of a panel of Blender, which must be registered before
CLASSES = tuple(panel for module in MODULES for panel in module.CLASSES) + tuple(in_node_editor(panel) for panel in IN_NODE_EDITORS) + BELOW_SIMPLIFY

BEHIND = "RENDER_PT_simplify"
# Generic panels of Blender that panels of Ajar replace, or whose settings Ajar does not have.
EXCLUDED = {
    "VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes", "VIEWLAYER_PT_eevee_layer_passes_data", "VIEWLAYER_PT_eevee_next_layer_passes_data",
    "VIEWLAYER_PT_layer_passes_cryptomatte", "VIEWLAYER_PT_layer_passes_aov", "VIEWLAYER_PT_layer_passes_lightgroups",
    "RENDER_PT_opengl_render", "OBJECT_PT_visibility", "DATA_PT_light",
}


def _after_ours() -> list[type]:
    """Copies of built-in panels that must be shown after those of Ajar. Blender shows panels in the order of their registration."""
    originals = [panel for panel in Panel.__subclasses__() if panel.__name__.startswith(BEHIND) and "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ())]
    copies = []
    for panel in originals:
        values = {name: value for name, value in vars(panel).items() if name != "bl_rna"} | {"COMPAT_ENGINES": {ENGINE}}
        if values.get("bl_parent_id", "").startswith(BEHIND):
            values["bl_parent_id"] = f"AJAR_{values['bl_parent_id']}"
        copies.append(type(f"AJAR_{panel.__name__}", panel.__bases__, values))
    return copies


def built_in_panels() -> list[Any]:
    """Blender's panels for generic renderers without EXCLUDED."""
    # Copies for the node editors share the set of engines with their original.
    return [panel for panel in Panel.__subclasses__()
            if "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ()) and panel.__name__.removeprefix("NODE_") not in EXCLUDED
            and not panel.__name__.startswith(BEHIND)]


_register_classes, _unregister_classes = bpy.utils.register_classes_factory((*(panel for panel in CLASSES if panel not in BELOW_SIMPLIFY), *_after_ours(), *BELOW_SIMPLIFY))


def register() -> None:
    progress.register()
    _register_classes()
    for panel in built_in_panels():
        panel.COMPAT_ENGINES.add(ENGINE)
    menus.register()


def unregister() -> None:
    menus.unregister()
    for panel in built_in_panels():
        panel.COMPAT_ENGINES.discard(ENGINE)
    _unregister_classes()
    progress.unregister()
