"""Persistent Data: what a render keeps for the next frame of the animation, or for the next render of the scene.

With this setting, Blender keeps its dependency graph, which reports what has changed. Ajar keeps exported meshes, the collected objects and the session
with its built scene. Nothing is kept with checkpoints, whose samples belong to one frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
from bpy.app.handlers import persistent

from .ajar_module import ajar
from .export import KnownObjects, MeshCache


@dataclass
class Kept:
    depsgraph: int   # its address
    session: ajar.Session = field(default_factory=ajar.Session)
    meshes: MeshCache = field(default_factory=MeshCache)
    known: KnownObjects = field(default_factory=KnownObjects)


_kept: dict[tuple, Kept] = {}


def of(depsgraph: bpy.types.Depsgraph, key: tuple[str, str, str]) -> Kept | None:
    """What the render before has kept; new if there was none. None without Persistent Data."""
    if not depsgraph.scene.render.use_persistent_data:
        _kept.clear()
        return None
    found = _kept.get(key)
    if found is None or found.depsgraph != depsgraph.as_pointer():
        found = _kept[key] = Kept(depsgraph.as_pointer())
    return found


@persistent
def forget(*_) -> None:
    """Also called after a render that failed or was cancelled: it may have read changes that it did not export."""
    _kept.clear()


HANDLERS = (bpy.app.handlers.load_pre, bpy.app.handlers.undo_post, bpy.app.handlers.redo_post)


def register() -> None:
    for handlers in HANDLERS:
        handlers.append(forget)


def unregister() -> None:
    forget()
    for handlers in HANDLERS:
        handlers.remove(forget)
