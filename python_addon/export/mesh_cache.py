"""Meshes that a viewport has exported, so that an edit exports only changed meshes.

The keys are names, since addresses in Blender are not persistent. An entry is removed if the dependency graph reports a change of the geometry of its
owner or of its data. All entries are removed after an undo, for which the graph reports no changes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..ajar_module import ajar
from . import strands

if TYPE_CHECKING:
    from .context import ExportContext


class MeshCache:
    def __init__(self) -> None:
        self.known: dict[tuple, ajar.MeshDescription | None] = {}   # None: a mesh without triangles
        self.exported = 0                                           # number of exported meshes, for tests
        self._asked: dict[tuple, int] = {}

    def begin(self) -> None:
        """Called before each export."""
        self._asked = {}

    def finish(self) -> None:
        """Called after each export: remove the entries that were not used."""
        self.known = {key: mesh for key, mesh in self.known.items() if key[0] in self._asked and key[1] < self._asked[key[0]]}

    def key(self, context: ExportContext, owner: bpy.types.Object, data: bpy.types.Mesh | bpy.types.Curves | bpy.types.PointCloud | bpy.types.Volume, is_hair: bool = False) -> tuple:
        name = (owner.name_full, data.name_full, *(["", *_systems(owner)] if is_hair else []))
        # Geometry nodes can create several meshes with the same name. Their order in the graph is always the same.
        number = self._asked.get(name, 0)
        self._asked[name] = number + 1
        if isinstance(data, bpy.types.Volume):
            size: tuple = (data.filepath, data.grids.frame_filepath, data.render.space)
        elif isinstance(data, bpy.types.PointCloud):
            size = (len(data.points),)
        elif not isinstance(data, bpy.types.Mesh):
            size = (len(data.points), len(data.curves), *strands.shape(context).values())
        elif is_hair:
            size = (*strands.count(context, owner), *strands.shape(context).values())
        else:
            size = (len(data.vertices), len(data.loops), len(data.polygons), data.is_editmode)
        return (name, number, size, context.uses_generated, frozenset(context.attribute_names))

    def forget(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Remove the entries that have changed since the last export."""
        changed = {update.id.name_full for update in depsgraph.updates if update.is_updated_geometry or isinstance(update.id, bpy.types.ParticleSettings)}
        if changed:
            self.known = {key: mesh for key, mesh in self.known.items() if changed.isdisjoint(key[0])}

    def clear(self) -> None:
        self.known = {}


def _systems(owner: bpy.types.Object) -> list[str]:
    """Names of the datablocks on which the hair depends."""
    return [system.settings.name_full for system in owner.particle_systems]
