"""What the exporters of one render share."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

import bpy

from ..ajar_module import ajar
from ..translations import report
from .known_objects import KnownObjects
from .mesh_cache import MeshCache

CHECK_SECONDS = 0.05  # between two looks at the cancel button


class ExportCancelled(Exception):
    """The user wants no picture any more."""


class ExportContext:
    """The description under construction and the indices already given away.

    Lives for one export: its keys are addresses of Blender's data, which hold only that long.
    """

    def __init__(self, depsgraph: bpy.types.Depsgraph, is_cancelled: Callable[[], bool], report_step: Callable[[str], None],
                 meshes: MeshCache | None = None, is_hidden: Callable[[bpy.types.DepsgraphObjectInstance], bool] | None = None) -> None:
        self.depsgraph = depsgraph
        self.scene = depsgraph.scene_eval
        self.view_layer = depsgraph.view_layer_eval
        # Since 4.3 a view layer may have a world of its own.
        self.world: bpy.types.World | None = getattr(self.view_layer, "world_override", None) or self.scene.world
        self.description = ajar.SceneDescription()
        self.materials: dict[int, int] = {}              # address of a material -> index
        self.images: dict[tuple, int] = {}
        self.uses_generated = False                      # whether a material may ask for Generated coordinates
        self.attribute_names: set[str] = set()           # attributes that materials ask for by name
        self.object_properties: set[str] = set()         # likewise, of objects
        self.instancer_properties: frozenset[str] = frozenset()   # and of what makes their instances
        self.warnings: list[tuple[str, str]] = []        # (name of the datablock, message)
        self.meshes = meshes                             # of a viewport, from one export to the next
        self.is_hidden = is_hidden                       # what a viewport does not show, beyond what the dependency graph leaves out
        self.known: KnownObjects | None = None           # of a viewport, likewise
        self.revisions: list[bpy.types.Object] | None = None   # of these, the objects to look at again; None: everything
        self.importance_of_collections: dict[int, float] | None = None
        self.importance_of_light_groups: dict[str, float] = {}
        self.appearances: list[tuple] | None = None      # with motion blur: what each instance is known by (motion.identity)
        self.report_step = report_step
        self._is_cancelled = is_cancelled
        self._next_check = 0.0
        for group in self.view_layer.ajar.light_groups:
            if group.name in self.view_layer.lightgroups:
                self.importance_of_light_groups[group.name] = group.importance
            else:
                self.warn(self.view_layer.name, "its light group {group} is gone, and with it that group's importance", group=group.name)

    def warn_all(self, name: str, messages: Iterable[str]) -> None:
        for message in messages:
            self.warn(name, message)

    def warn(self, name: str, text: str, /, **values: object) -> None:
        """Tell the artist, once. `values` are filled into the format fields of the text, after it was translated."""
        message = report(text, **values)
        if (name, message) not in self.warnings:
            self.warnings.append((name, message))

    def light_importance(self, source: bpy.types.Object | bpy.types.World) -> float:
        """Of the light group it is in."""
        return self.importance_of_light_groups.get(source.lightgroup, 1.0) if self.importance_of_light_groups else 1.0

    def check_cancelled(self) -> None:
        """Cheap enough for every turn of a loop."""
        now = time.monotonic()
        if now < self._next_check:
            return
        if self._is_cancelled():
            raise ExportCancelled
        self._next_check = time.monotonic() + CHECK_SECONDS


def rows_3x4(matrix) -> list[float]:
    """A Blender matrix as the twelve numbers of an affine transform."""
    return [*matrix[0], *matrix[1], *matrix[2]]
