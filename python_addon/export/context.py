"""Data that the exporters of one render share."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import bpy

from ..ajar_module import ajar
from ..translations import report
from .known_objects import KnownObjects
from .linking import Linking
from .mesh_cache import MeshCache

if TYPE_CHECKING:
    from .deformation import Watched

CHECK_SECONDS = 0.05  # between two checks for cancellation


class ExportCancelled(Exception):
    """The user has cancelled the render."""


class ExportContext:
    """The description under construction, and the indices of exported datablocks.

    It is valid for one export, since its keys are addresses of Blender's data.
    """

    def __init__(self, depsgraph: bpy.types.Depsgraph, is_cancelled: Callable[[], bool], report_step: Callable[[str], None],
                 meshes: MeshCache | None = None, is_hidden: Callable[[bpy.types.DepsgraphObjectInstance], bool] | None = None) -> None:
        self.depsgraph = depsgraph
        self.refresh()
        self.description = ajar.SceneDescription()
        self.materials: dict[int, int] = {}              # address of a material -> index
        self.user = ""                                   # the object whose materials are exported, for messages
        self.images: dict[tuple, int] = {}
        self.aovs: dict[str, str] = {}                   # the AOVs that passes show, and the socket of each
        self.uses_generated = False                      # whether a material can use Generated coordinates
        self.attribute_names: set[str] = set()           # attributes that materials use
        self.node_properties: dict[str, list[str]] = {}  # type of a node -> what own_properties found for it
        self.object_properties: set[str] = set()         # properties of objects that materials use
        self.instancer_properties: frozenset[str] = frozenset()   # properties of instancers that materials use
        self.uses_origins = False                                 # whether materials use Particle Info or From Instancer
        self.warnings: list[tuple[str, str]] = []        # (name of the datablock, message)
        self.meshes = meshes                             # of a viewport, kept between exports
        self.is_hidden = is_hidden                       # whether a viewport hides an instance that is in the dependency graph
        self.is_view = False                             # of a viewport, which has no camera unless it culls objects
        self.known: KnownObjects | None = None           # of a viewport, kept between exports
        self.revisions: list[bpy.types.Object] | None = None   # the known objects to export again; None: all
        self.importance_of_collections: dict[int, float] | None = None
        self.importance_of_light_groups: dict[str, float] = {}
        self.appearances: list[tuple] | None = None      # with motion blur: the key of each instance (motion.identity)
        self.watched: dict[tuple, list[Watched]] | None = None   # with motion blur: the meshes that may deform, by the key of an instance
        self.divides = True                              # whether adaptive subdivision is followed
        self.unmoved: set[int] = set()                   # addresses of original materials whose displacement only bends normals
        self.catcher: bpy.types.Object | None = None     # a baked object that catches shadows
        self.base_is_evaluated: set[int] = set()   # addresses of objects that are evaluated without the modifier of adaptive subdivision
        self.mesh_of: dict[bpy.types.Object, int] | None = None   # for the pass Vector: the mesh of each original object that has one alone
        self.report_step = report_step
        self._is_cancelled = is_cancelled
        self._next_check = 0.0
        self.linking = Linking(self.warn)
        for group in self.view_layer.ajar.light_groups:
            if group.name in self.view_layer.lightgroups:
                self.importance_of_light_groups[group.name] = group.importance
            else:
                self.warn(self.view_layer.name, "its light group {group} does not exist, so that the importance of this group is not used", group=group.name)

    def bake(self, thing: bpy.types.Object | None, catches: bool) -> None:
        """The texels of a baked object are on its undisplaced mesh: its materials do not move it, and no mesh is divided, as in Cycles. `catches`: whether it
        catches shadows."""
        if thing is not None:
            self.catcher = thing.original if catches else None
            self.divides = False
            self.unmoved = {slot.material.original.as_pointer() for slot in thing.material_slots if slot.material is not None}

    def refresh(self) -> None:
        """Called after an evaluation."""
        self.scene = self.depsgraph.scene_eval
        self.view_layer = self.depsgraph.view_layer_eval
        # Since 4.3, a view layer can have its own world.
        self.world: bpy.types.World | None = getattr(self.view_layer, "world_override", None) or self.scene.world

    def warn_all(self, name: str, messages: Iterable[str]) -> None:
        for message in messages:
            self.warn(name, message)

    def warn(self, name: str, text: str, /, **values: object) -> None:
        """Add a warning once. `values` are filled into the format fields of the translated text."""
        message = report(text, **values)
        if (name, message) not in self.warnings:
            self.warnings.append((name, message))

    def light_importance(self, source: bpy.types.Object | bpy.types.World) -> float:
        """The importance of the light group of an object or world."""
        return self.importance_of_light_groups.get(source.lightgroup, 1.0) if self.importance_of_light_groups else 1.0

    def check_cancelled(self) -> None:
        """Fast enough for every iteration of a loop."""
        now = time.monotonic()
        if now < self._next_check:
            return
        if self._is_cancelled():
            raise ExportCancelled
        self._next_check = time.monotonic() + CHECK_SECONDS


def rows_3x4(matrix) -> list[float]:
    """A Blender matrix as the twelve numbers of an affine transform."""
    return [*matrix[0], *matrix[1], *matrix[2]]
