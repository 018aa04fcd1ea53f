"""Settings of Blender and Cycles that Ajar does not support. Each is reported with the name of its datablock if its value would change the image.

`tests/blender/panels/inventory.py` lists how every other setting is handled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import bpy

from .translations import report


@dataclass(frozen=True)
class Setting:
    path: str        # from the datablock, like "cycles.max_bounces"
    harmless: object   # the value that does not change the image
    text: str        # a sentence that follows the name of the datablock
    matters: Callable[[bpy.types.bpy_struct], bool] = lambda owner: True   # whether the datablock uses the setting
    values: dict[str, str] = field(default_factory=dict)   # values of the format fields of the text

    def message(self) -> str:
        """The text in the language of the artist."""
        return report(self.text, **self.values)


SCENE = (
    Setting("cycles.use_fast_gi", False, "Fast GI Approximation is not supported: all bounces are followed"),
    Setting("cycles.sample_offset", 0, "Sample Offset is not supported: choose another seed instead"),
    Setting("cycles.use_sample_subset", False, "Sample Subset is not supported: choose another seed instead"),
)
VIEW_LAYER = (
    *(Setting(f"use_pass_{name}", False, "the pass {name} is not supported and stays black", values={"name": label}) for name, label in (
        ("shadow", "Shadow"), ("subsurface_direct", "Subsurface Direct"),
        ("subsurface_indirect", "Subsurface Indirect"), ("subsurface_color", "Subsurface Color"), ("grease_pencil", "Grease Pencil"))),
    *(Setting(f"cycles.use_pass_volume_{name}", False, "the pass {name} is not supported", values={"name": f"Volume {name.title()}"}) for name in ("scatter", "transmit", "majorant")),
)
OBJECT = (
    Setting("cycles.shadow_terminator_offset", 0.0, "its Shadow Terminator Shading Offset is not supported and is ignored", lambda thing: not hasattr(thing, "shadow_terminator_shading_offset")),
    Setting("shadow_terminator_shading_offset", 0.0, "its Shadow Terminator Shading Offset is not supported and is ignored"),
)
WORLD = (
    Setting("cycles.use_shadows", True, "a world that casts no shadows is not supported"),
)
CAMERA = (
    Setting("type", "PERSP", "custom cameras are not supported: it is rendered as a perspective one", lambda camera: camera.type == "CUSTOM"),
)


def value_of(owner: bpy.types.bpy_struct, path: str) -> tuple[bool, object]:
    """Whether this Blender has the setting, and its value."""
    found: object = owner
    for name in path.split("."):
        if not hasattr(found, name):
            return False, None
        found = getattr(found, name)
    return True, found


def asked_of(owner: bpy.types.bpy_struct, settings: tuple[Setting, ...]) -> Iterator[str]:
    """The messages for one datablock."""
    for setting in settings:
        known, value = value_of(owner, setting.path)
        if known and value != setting.harmless and setting.matters(owner):
            yield setting.message()


def of_object(thing: bpy.types.Object) -> Iterator[str]:
    yield from asked_of(thing, OBJECT)


def of_view_layer(layer: bpy.types.ViewLayer) -> Iterator[str]:
    yield from asked_of(layer, VIEW_LAYER)
    for output in layer.aovs:
        if not output.is_valid:
            yield report("the AOV {name} has no name of its own and is not rendered", name=output.name)
