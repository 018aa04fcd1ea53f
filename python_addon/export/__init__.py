"""Export of Blender's evaluated dependency graph to Ajar's SceneDescription.

Each type of datablock has its own module. Axes, units and names are those of Blender. Arrays are copied in bulk, and no object of Blender is kept.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..headless import Options
from . import camera, frames, hints, images, motion, objects, settings, subdivision, world
from .context import ExportCancelled, ExportContext
from .culling import Culling
from .known_objects import KnownObjects, OutOfDate, visible_in
from .mesh_cache import MeshCache

__all__ = ["ExportCancelled", "ExportContext", "KnownObjects", "MeshCache", "OutOfDate", "export_contents", "export_scene", "export_view"]


def export_scene(depsgraph: bpy.types.Depsgraph, options: Options, passes: list[str], camera_object: bpy.types.Object | None,
                 is_cancelled: Callable[[], bool], report_step: Callable[[str], None],
                 frame_set: motion.FrameSet | None = None, eye: camera.Eye = camera.CENTRE, baked: bpy.types.Object | None = None,
                 caches: tuple[MeshCache, KnownObjects] | None = None) -> ExportContext:
    """Export the scene with `camera_object` as its camera, seen from `eye`. `baked`: the object whose texels will be the image. Raises ExportCancelled soon
    after `is_cancelled` returns True. Motion blur needs `frame_set`; after its call, objects that were evaluated before must not be used. `caches`: what the
    export before has kept; the graph must report all changes since then."""
    meshes, known = caches or (None, None)
    revisions = None
    if meshes is not None and known is not None:
        meshes.forget(depsgraph)
        revisions = known.changed(depsgraph)
        if revisions is not None and known.collected is not None and visible_in(depsgraph, known.collected) != known.visible:
            revisions = None

    def export(revisions: list[bpy.types.Object] | None) -> ExportContext:
        context = ExportContext(depsgraph, is_cancelled, report_step, meshes)
        context.bake(baked, catches="Shadow Catcher" in passes)
        context.known = known
        _export_frame(context, options, passes, camera_object, frame_set, eye, revisions)
        return context
    try:
        context = export(revisions)
    except OutOfDate:
        context = export(None)
    if known is not None and known.collected is not None:
        known.visible = visible_in(depsgraph, known.collected)
    return context


def _export_frame(context: ExportContext, options: Options, passes: list[str], camera_object: bpy.types.Object | None,
                  frame_set: motion.FrameSet | None, eye: camera.Eye, revisions: list[bpy.types.Object] | None) -> None:
    original_camera = camera_object.original if camera_object is not None else None
    subdivision.prepare(context, frame_set)
    camera_object = original_camera.evaluated_get(context.depsgraph) if original_camera is not None else None
    blurs = frame_set is not None and motion.is_wanted(context.scene, context.view_layer)
    shows_motion = frame_set is not None and "Vector" in passes and not blurs
    if blurs and "Vector" in passes:
        context.warn(context.view_layer.name, "the pass Vector is empty, because the scene has motion blur")
    if blurs or shows_motion:
        context.appearances = []
    if blurs:
        context.watched = {}
    if shows_motion:
        context.mesh_of = {}
    settings.export(context, options, passes)
    camera.export(context, camera_object, eye)
    # These need a loop over all instances.
    context.revisions = None if blurs or shows_motion or context.base_is_evaluated or Culling(context).exists else revisions
    if context.meshes is not None and context.revisions is None:
        context.meshes.begin()
    export_contents(context)
    if context.meshes is not None and context.revisions is None:
        context.meshes.finish()
    if frame_set is not None and shows_motion:
        frames.export(context, camera_object, frame_set, eye)
    if frame_set is not None and blurs:
        motion.export(context, camera_object, frame_set, eye)


def export_view(depsgraph: bpy.types.Depsgraph, options: Options, passes: list[str], camera_object: bpy.types.Object | None) -> ExportContext:
    """Export the camera and the settings alone."""
    context = ExportContext(depsgraph, lambda: False, lambda step: None)
    settings.export(context, options, passes)
    camera.export(context, camera_object)
    return context


def export_contents(context: ExportContext) -> None:
    """Export all that does not depend on the camera."""
    images.export_color_spaces(context)
    subdivision.export_settings(context)
    world.export(context)
    objects.export(context)
    hints.export(context)
