"""The data that the last export of a viewport collected from the dependency graph, so that an edit exports only what it changed.

The loop over the instances takes most of the time of an export in Python. It is skipped if the graph reports only changes of materials, lights, the
world, and of objects that change their transform or appearance but not their geometry, and that are neither instanced nor instancers. After all other
changes, and in cases of doubt, everything is collected again. In Blender 5, an edit of a material also counts as a change of the shading of all
meshes and objects that use it. The keys are the original datablocks, which persist. Blender reports when they are deleted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from . import linking

if TYPE_CHECKING:
    from .objects import Collected

# Changes of these types do not affect objects, or the graph reports the objects, too. Cameras are exported separately.
_APART = (bpy.types.Action, bpy.types.Material, bpy.types.Light, bpy.types.World, bpy.types.ShaderNodeTree, bpy.types.Camera)
_NOTHING_TO_SEE = {"CAMERA", "EMPTY", "ARMATURE", "LATTICE", "SPEAKER"}


def look_of(thing: bpy.types.Object) -> tuple:
    """All data that instances have from an original object except geometry and transform."""
    return (tuple(slot.material for slot in thing.material_slots), tuple(thing.color), thing.pass_index, thing.is_shadow_catcher, thing.is_holdout, thing.lightgroup,
            thing.visible_camera, thing.visible_diffuse, thing.visible_glossy, thing.visible_transmission, thing.visible_volume_scatter, thing.visible_shadow)


class OutOfDate(Exception):
    """There are more changes than were reported, so that everything must be collected again."""


class KnownObjects:
    def __init__(self) -> None:
        self.collected: Collected | None = None
        self.walks = 0                       # number of loops over all instances, for tests
        self.visible: tuple = ()             # visible_in the graph of the last render
        self.revised = 0                     # number of objects that were exported again without such a loop, for tests

    def forget(self) -> None:
        self.collected = None

    def changed(self, depsgraph: bpy.types.Depsgraph) -> list[bpy.types.Object] | None:
        """Originals of the objects to export again, or None if everything must be collected."""
        collected = self.collected
        if collected is None or collected.is_linked or len(depsgraph.updates) == 0:
            return None
        changed = []
        try:
            for update in depsgraph.updates:
                thing = update.id
                if isinstance(thing, _APART) or _only_shading(collected, update):
                    continue
                if not isinstance(thing, bpy.types.Object) or not _is_alone(collected, thing, update):
                    return None
                if linking.is_linked(thing.original):
                    return None
                if thing.type not in _NOTHING_TO_SEE:
                    changed.append(thing.original)
        except ReferenceError:
            return None
        return changed


def visible_in(depsgraph: bpy.types.Depsgraph, collected: Collected) -> tuple:
    """What is visible in a render. Blender does not report animated visibility as a change."""
    shown = frozenset(thing.original.as_pointer() for thing in depsgraph.objects)
    hidden = tuple(thing.evaluated_get(depsgraph).hide_render for thing in collected.shared)
    return shown, hidden, len(depsgraph.object_instances)


def _only_shading(collected: Collected, update: bpy.types.DepsgraphUpdate) -> bool:
    """Whether only a material has changed: of a mesh, or of an unchanged object that is instanced or an instancer."""
    if update.is_updated_transform or update.is_updated_geometry or not update.is_updated_shading:
        return False
    thing = update.id
    if isinstance(thing, bpy.types.Object):
        return thing.original in collected.shared and collected.shared[thing.original] == look_of(thing.original)
    return isinstance(thing, (bpy.types.Mesh, bpy.types.Curve, bpy.types.Curves, bpy.types.PointCloud, bpy.types.MetaBall))


def _is_alone(collected: Collected, thing: bpy.types.Object, update: bpy.types.DepsgraphUpdate) -> bool:
    """Whether the change of this object affects only its own single instance."""
    if not (update.is_updated_transform or update.is_updated_geometry or update.is_updated_shading):
        return False
    if thing.is_instancer or thing.original in collected.shared:
        return False
    if thing.type in ("LIGHT", "CAMERA"):   # their geometry is their datablock
        return thing.type == "CAMERA" or thing.original in collected.lamps
    if update.is_updated_geometry:
        return False
    return thing.type in _NOTHING_TO_SEE or thing.original in collected.alone
