"""Presets: settings for types of work that are set together."""

from __future__ import annotations

from typing import Any

import bpy

from .translations import tooltip

# Every preset sets all of these, so that a preset replaces the previous one.
BASE = {"integrator": "auto", "image": "pmc_ip", "image_error": "relative", "samples": 1024, "time_limit": 0.0, "noise_target": 0.001,
        "bounces_total": 12, "bounces_diffuse": 4, "bounces_glossy": 4, "bounces_transmission": 12, "bounces_transparent": 8,
        "reflective_caustics": True, "refractive_caustics": True, "clamp_direct": 0.0, "clamp_indirect": 0.0}
PRESETS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "PREVIEW": ("Preview", "A first look: fast, with noise", {"integrator": "path", "samples": 32, "noise_target": 0.02}),
    "INTERIOR": ("Interior", "Light that comes around corners and bounces often",
                 {"noise_target": 0.002, "bounces_total": 24, "bounces_diffuse": 16, "bounces_glossy": 8}),
    "CAUSTICS": ("Caustics", "Light through glass and off mirrors, by photon maps",
                 {"integrator": "photon_map", "bounces_total": 24, "bounces_glossy": 12, "bounces_transmission": 24, "bounces_transparent": 16}),
    "PRODUCT": ("Product", "Objects in unoccluded light, with more samples where the eye sees noise",
                {"integrator": "path", "image_error": "perceptual", "bounces_transparent": 16}),
    "FINAL": ("Final", "Clean, without a time limit",
              {"samples": 16384, "noise_target": 0.0002, "bounces_total": 24, "bounces_diffuse": 8, "bounces_glossy": 8, "bounces_transmission": 24,
               "bounces_transparent": 16}),
}


class AJAR_OT_use_preset(bpy.types.Operator):
    bl_idname = "ajar.use_preset"
    bl_label = "Use Preset"
    bl_description = "Set the settings of the render for a kind of work"
    bl_options = {"REGISTER", "UNDO"}

    preset: bpy.props.EnumProperty(name="Preset", items=[(key, label, tip) for key, (label, tip, _) in PRESETS.items()])

    @classmethod
    def description(cls, context: bpy.types.Context, properties) -> str:
        return tooltip(PRESETS[properties.preset][1])

    def execute(self, context: bpy.types.Context) -> set[str]:
        for name, value in (BASE | PRESETS[self.preset][2]).items():
            setattr(context.scene.ajar, name, value)
        return {"FINISHED"}


class AJAR_MT_presets(bpy.types.Menu):
    bl_label = "Presets"

    def draw(self, context: bpy.types.Context) -> None:
        for key, (label, _, _) in PRESETS.items():
            self.layout.operator(AJAR_OT_use_preset.bl_idname, text=label).preset = key


CLASSES = (AJAR_OT_use_preset, AJAR_MT_presets)


register, unregister = bpy.utils.register_classes_factory(CLASSES)
