"""Meshes that a viewport has exported, so that an edit exports only what it changed.

Keys are names, because addresses in Blender do not last. An entry is forgotten when the dependency graph says that the geometry of its
owner or of its data has changed, and all are after an undo, where it does not say.
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
        self.known: dict[tuple, ajar.MeshDescription | None] = {}   # None: has no triangles
        self.exported = 0                                           # since the cache was made, for tests
        self._asked: dict[tuple, int] = {}

    def begin(self) -> None:
        """Before each export."""
        self._asked = {}

    def finish(self) -> None:
        """After each export: forget what was not asked for."""
        self.known = {key: mesh for key, mesh in self.known.items() if key[0] in self._asked and key[1] < self._asked[key[0]]}

    def key(self, context: ExportContext, owner: bpy.types.Object, data: bpy.types.Mesh | bpy.types.Curves, is_hair: bool = False) -> tuple:
        name = (owner.name_full, data.name_full, *(["", *_systems(owner)] if is_hair else []))
        # Several meshes may come under one name out of geometry nodes: the graph has them in the same order each time.
        number = self._asked.get(name, 0)
        self._asked[name] = number + 1
        if not isinstance(data, bpy.types.Mesh):
            size = (len(data.points), len(data.curves), *strands.shape(context).values())
        elif is_hair:
            size = (*strands.count(context, owner), *strands.shape(context).values())
        else:
            size = (len(data.vertices), len(data.loops), len(data.polygons), data.is_editmode)
        return (name, number, size, context.uses_generated, frozenset(context.attribute_names))

    def forget(self, depsgraph: bpy.types.Depsgraph) -> None:
        """What has changed since the last export."""
        changed = {update.id.name_full for update in depsgraph.updates if update.is_updated_geometry or isinstance(update.id, bpy.types.ParticleSettings)}
        if changed:
            self.known = {key: mesh for key, mesh in self.known.items() if changed.isdisjoint(key[0])}

    def clear(self) -> None:
        self.known = {}


def _systems(owner: bpy.types.Object) -> list[str]:
    """Names of what hair is made by, whose changes change it."""
    return [system.settings.name_full for system in owner.particle_systems]
