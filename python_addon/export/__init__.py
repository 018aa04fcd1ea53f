"""From Blender's evaluated dependency graph to Ajar's SceneDescription.

One module per kind of datablock. Axes, units and names are Blender's own; arrays are copied in bulk; nothing of Blender is kept.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..headless import Options
from . import camera, hints, motion, objects, settings, world
from .context import ExportCancelled, ExportContext
from .known_objects import KnownObjects, OutOfDate
from .mesh_cache import MeshCache

__all__ = ["ExportCancelled", "ExportContext", "KnownObjects", "MeshCache", "OutOfDate", "export_contents", "export_scene"]


def export_scene(depsgraph: bpy.types.Depsgraph, options: Options, passes: list[str], camera_object: bpy.types.Object | None,
                 is_cancelled: Callable[[], bool], report_step: Callable[[str], None],
                 frame_set: motion.FrameSet | None = None) -> ExportContext:
    """The whole scene as seen by `camera_object`. Raises ExportCancelled soon after `is_cancelled` says so. Motion is blurred with
    `frame_set` only, after which nothing evaluated before may be touched."""
    context = ExportContext(depsgraph, is_cancelled, report_step)
    if not motion.is_wanted(context.scene, context.view_layer):
        frame_set = None
    if frame_set is not None:
        context.appearances = []
    settings.export(context, options, passes)
    camera.export(context, camera_object)
    export_contents(context)
    if frame_set is not None:
        motion.export(context, camera_object, frame_set)
    return context


def export_contents(context: ExportContext) -> None:
    """What there is to see, wherever it is seen from."""
    world.export(context)
    objects.export(context)
    hints.export(context)
