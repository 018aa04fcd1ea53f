"""Render passes: those that a view layer enables, and their format in Blender."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from . import compat, plain


@dataclass(frozen=True)
class Pass:
    name: str       # name in the film; `shown` is that of Blender
    letters: str    # one per channel
    kind: str       # type of the socket in the compositor
    label: str = ""   # name in Blender, if it is not that of the film

    @property
    def shown(self) -> str:
        return self.label or compat.pass_name(self.name)


COMBINED = Pass("Combined", "RGBA", "COLOR")
BUILT_IN = {  # property of the view layer -> pass. Two channels are not accepted, so UV has three.
    "use_pass_z": Pass("Depth", "Z", "VALUE"),
    "use_pass_position": Pass("Position", "XYZ", "VECTOR"),
    "use_pass_normal": Pass("Normal", "XYZ", "VECTOR"),
    "use_pass_vector": Pass("Vector", "XYZW", "VECTOR"),
    "use_pass_uv": Pass("UV", "UVA", "VECTOR"),
    "use_pass_mist": Pass("Mist", "Z", "VALUE"),
    "use_pass_object_index": Pass("IndexOB", "X", "VALUE"),
    "use_pass_material_index": Pass("IndexMA", "X", "VALUE"),
    "use_pass_emit": Pass("Emit", "RGB", "COLOR"),
    "use_pass_environment": Pass("Env", "RGB", "COLOR"),
    "use_pass_ambient_occlusion": Pass("AO", "RGB", "COLOR"),
} | {
    f"use_pass_{kind}_{part}": Pass(name + letters, "RGB", "COLOR")
    for kind, name in (("diffuse", "Diff"), ("glossy", "Gloss"), ("transmission", "Trans"))
    for part, letters in (("direct", "Dir"), ("indirect", "Ind"), ("color", "Col"))
}
OWN = {  # property of Ajar's settings -> pass
    "use_pass_albedo": Pass("Albedo", "RGB", "COLOR"),
    "use_pass_volume_direct": Pass("VolumeDir", "RGB", "COLOR"),
    "use_pass_volume_indirect": Pass("VolumeInd", "RGB", "COLOR"),
    "use_pass_shadow_catcher": Pass("Shadow Catcher", "RGB", "COLOR"),
    "use_pass_sample_count": Pass("Sample Count", "X", "VALUE"),
    "use_pass_render_time": Pass("Render Time", "X", "VALUE"),
    "use_pass_variance": Pass("Variance", "X", "VALUE"),
    "use_pass_error": Pass("Error", "X", "VALUE"),
    "use_pass_perceptual_error": Pass("Perceptual Error", "X", "VALUE"),
}


# The data of a denoiser, with the names that they have in Cycles.
GUIDES = (Pass("Denoising Albedo", "RGB", "COLOR"), Pass("Denoising Normal", "XYZ", "VECTOR"))
DENOISING = (*GUIDES, Pass("Depth", "Z", "VALUE", "Denoising Depth"))
HALVES = "Halves"   # the pass of the core with two independent images; it is not shown
DIRECT_HALVES = "Direct Halves"   # the part of direct paths in both
NOISY = Pass("Noisy Image", "RGBA", "COLOR")   # name of the image before denoising, as in Cycles
DENOISING_ERROR = Pass("Denoising Error", "X", "VALUE")


# Properties of the view layer, and the beginning of the names of the passes. Two ranks of mattes are in one pass. OpenEXR compresses channels with lower
# case letters without loss.
MATTES = {"use_pass_cryptomatte_object": "CryptoObject", "use_pass_cryptomatte_material": "CryptoMaterial", "use_pass_cryptomatte_asset": "CryptoAsset"}
MOST_RANKS = 16
COLOR_AOV, VALUE_AOV, LIGHT_GROUP = "AOV Color ", "AOV Value ", "Combined_"   # the beginnings of the names of passes in the film


def mattes(view_layer: bpy.types.ViewLayer) -> list[Pass]:
    count = (min(MOST_RANKS, view_layer.pass_cryptomatte_depth) + 1) // 2
    return [Pass(f"{matte}{number:02}", "rgba", "COLOR") for name, matte in MATTES.items() if getattr(view_layer, name) for number in range(count)]


def aovs(view_layer: bpy.types.ViewLayer) -> list[Pass]:
    """An AOV is not valid if another pass has its name."""
    return [Pass(VALUE_AOV + aov.name, "X", "VALUE", aov.name) if aov.type == "VALUE" else Pass(COLOR_AOV + aov.name, "RGBA", "COLOR", aov.name)
            for aov in view_layer.aovs if aov.is_valid and aov.name]


def types_of_aovs(names: list[str]) -> dict[str, str]:
    """The type of each AOV among these passes of the film, by its name: the socket of the node that the pass shows."""
    return {name.removeprefix(prefix): socket for name in names for prefix, socket in ((COLOR_AOV, "Color"), (VALUE_AOV, "Value")) if name.startswith(prefix)}


def light_groups(view_layer: bpy.types.ViewLayer) -> list[Pass]:
    return [Pass(LIGHT_GROUP + group.name, "RGB", "COLOR") for group in view_layer.lightgroups if group.name]


def wanted(view_layer: bpy.types.ViewLayer) -> list[Pass]:
    ours = plain.of(view_layer.ajar)
    return ([COMBINED] + [item for name, item in BUILT_IN.items() if getattr(view_layer, name)]
            + [item for name, item in OWN.items() if getattr(ours, name)]
            + mattes(view_layer) + aovs(view_layer) + light_groups(view_layer)
            + list(DENOISING if ours.use_pass_denoising or compat.cycles_value(view_layer, "denoising_store_passes", False) else ()))


def fitted(values: np.ndarray, channels: int) -> np.ndarray:
    """Convert [height, width, any] to [height * width, channels]. Channels are omitted or filled with zeros."""
    flat = values.reshape(-1, values.shape[2])
    if flat.shape[1] > channels:
        return np.ascontiguousarray(flat[:, :channels])
    if flat.shape[1] < channels:
        return np.pad(flat, ((0, 0), (0, channels - flat.shape[1])))
    return flat
