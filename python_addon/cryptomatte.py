"""Metadata of Cryptomatte: which name belongs to each id. Blender's node reads it from the render result and from OpenEXR files."""

from __future__ import annotations

import json

import bpy

from . import passes
from .ajar_module import ajar


def manifests(description: ajar.SceneDescription, view_layer: bpy.types.ViewLayer) -> dict[str, str]:
    """The fields of metadata, by the specification 1.2."""
    fields: dict[str, str] = {}
    for setting, matte in passes.MATTES.items():
        if not getattr(view_layer, setting):
            continue
        layer = f"{view_layer.name}.{matte}"
        prefix = f"cryptomatte/{ajar.name_hash(layer):08x}"[:len("cryptomatte/") + 7]
        hashes = {name: f"{ajar.name_hash(name):08x}" for name in names_of(description, matte)}
        fields |= {f"{prefix}/name": layer, f"{prefix}/hash": "MurmurHash3_32", f"{prefix}/conversion": "uint32_to_float32",
                   f"{prefix}/manifest": json.dumps(hashes, ensure_ascii=False, separators=(",", ":"))}
    return fields


def names_of(description: ajar.SceneDescription, matte: str) -> list[str]:
    if matte == "CryptoMaterial":
        return list(dict.fromkeys([*(material.name for material in description.materials), "default_surface"]))
    objects = description.objects
    return list(dict.fromkeys(thing.asset if matte == "CryptoAsset" else thing.name for thing in objects))
