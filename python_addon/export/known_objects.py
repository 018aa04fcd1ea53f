"""What a viewport's last export found in the dependency graph, so that an edit looks again only at what it changed.

Walking over the instances takes Python longer than all the rest. It is left out when the graph says that nothing has changed but
materials, lights, the world, and objects that move or look otherwise by themselves: neither instances nor what makes them, without a
change of geometry. Whatever else has changed, and whenever in doubt, all is collected again. In Blender 5 an edit of a material also counts as one of the
shading of all meshes and objects that have it.
Datablocks are known by their originals, which last; Blender says when they are gone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    from .objects import Collected

# Changes of these alone leave objects where they are. Cameras are exported by views.
_APART = (bpy.types.Material, bpy.types.Light, bpy.types.World, bpy.types.ShaderNodeTree, bpy.types.Camera)
_NOTHING_TO_SEE = {"CAMERA", "EMPTY", "ARMATURE", "LATTICE", "SPEAKER"}


def look_of(thing: bpy.types.Object) -> tuple:
    """All that an original object gives its instances besides geometry and place."""
    return (tuple(slot.material for slot in thing.material_slots), tuple(thing.color), thing.pass_index, thing.is_shadow_catcher, thing.is_holdout, thing.visible_camera,
            thing.visible_diffuse, thing.visible_glossy, thing.visible_transmission, thing.visible_volume_scatter, thing.visible_shadow)


class OutOfDate(Exception):
    """More has changed than was said: everything has to be collected again."""


class KnownObjects:
    def __init__(self) -> None:
        self.collected: Collected | None = None
        self.walks = 0                       # over all instances, for tests
        self.revised = 0                     # objects that were looked at again without one

    def forget(self) -> None:
        self.collected = None

    def changed(self, depsgraph: bpy.types.Depsgraph) -> list[bpy.types.Object] | None:
        """Originals of the objects to look at again; None when all have to be collected."""
        collected = self.collected
        if collected is None or len(depsgraph.updates) == 0:
            return None
        changed = []
        try:
            for update in depsgraph.updates:
                thing = update.id
                if isinstance(thing, _APART) or _only_shading(collected, update):
                    continue
                if not isinstance(thing, bpy.types.Object) or not _is_alone(collected, thing, update):
                    return None
                if thing.type not in _NOTHING_TO_SEE:
                    changed.append(thing.original)
        except ReferenceError:
            return None
        return changed


def _only_shading(collected: Collected, update: bpy.types.DepsgraphUpdate) -> bool:
    """A mesh, or an object that is instanced or instances others and still looks as it did: a material of it has changed."""
    if update.is_updated_transform or update.is_updated_geometry or not update.is_updated_shading:
        return False
    thing = update.id
    if isinstance(thing, bpy.types.Object):
        return thing.original in collected.shared and collected.shared[thing.original] == look_of(thing.original)
    return isinstance(thing, (bpy.types.Mesh, bpy.types.Curve, bpy.types.Curves, bpy.types.MetaBall))


def _is_alone(collected: Collected, thing: bpy.types.Object, update: bpy.types.DepsgraphUpdate) -> bool:
    """Whether what changed of this object shows nowhere but in its own single appearance."""
    if not (update.is_updated_transform or update.is_updated_geometry or update.is_updated_shading):
        return False
    if thing.is_instancer or thing.original in collected.shared:
        return False
    if thing.type in ("LIGHT", "CAMERA"):   # whose geometry is their data
        return thing.type == "CAMERA" or thing.original in collected.lamps
    if update.is_updated_geometry:
        return False
    return thing.type in _NOTHING_TO_SEE or thing.original in collected.alone
