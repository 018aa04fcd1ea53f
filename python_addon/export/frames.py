"""Motion from the frame before to the frame after, for the pass Vector.

Like motion blur, this is the last step of an export: the scene is evaluated again for both frames, after which objects that were evaluated before must
not be used. As in Cycles, there are no vectors in a render with motion blur.
"""

from __future__ import annotations

import bpy
import numpy as np

from .. import compat
from ..ajar_module import ajar
from . import camera
from .context import ExportContext, rows_3x4
from .motion import TOLERANCE, FrameSet, differs, identity

OFFSETS = (0, -1, 1)   # in frames
DEFORM_TOLERANCE = 1e-6   # in metres
CHANGES = "the number of its vertices changes, so that the pass Vector does not contain its deformation"


def export(context: ExportContext, camera_object: bpy.types.Object | None, frame_set: FrameSet, eye: camera.Eye = camera.CENTRE) -> None:
    scene, depsgraph = context.scene, context.depsgraph
    context.report_step("motion")
    frame, subframe = scene.frame_current, scene.frame_subframe
    original_camera = camera_object.original if camera_object is not None else None
    appearances = context.appearances or []
    shown: dict[tuple, list[int]] = {}   # a surface and its hair have the same key
    for index, known_by in enumerate(appearances):
        shown.setdefault(known_by, []).append(index)
    matrices = np.full((len(appearances), len(OFFSETS), 12), np.nan, dtype=np.float32)
    cameras: list[list[float]] = []
    mesh_of = context.mesh_of or {}
    places: dict[bpy.types.Object, list[np.ndarray]] = {owner: [] for owner in mesh_of}
    try:
        for number, offset in enumerate(OFFSETS):
            context.check_cancelled()
            if offset != 0:
                frame_set(frame + offset, subframe)
            for instance in depsgraph.object_instances:
                for index in shown.get(identity(instance), ()):
                    x, y, z, _ = instance.matrix_world
                    matrices[index, number] = (*x, *y, *z)
            for owner, found in places.items():
                found.append(_positions(owner.evaluated_get(depsgraph)))
            if original_camera is not None and original_camera.type == "CAMERA":
                cameras.append(rows_3x4(camera.without_scale(eye.world_from_camera(original_camera.evaluated_get(depsgraph)))))
    finally:
        frame_set(frame, subframe)
    moving = differs(matrices)
    context.description.set_frames(np.flatnonzero(moving).astype(np.int32), matrices[moving][:, 1:])
    if cameras and differs(np.array([cameras], dtype=np.float32))[0]:
        context.description.camera.frames = cameras[1:]
    for owner, (now, *others) in places.items():
        _add_positions(context, owner, mesh_of[owner], (now, others))


def _positions(thing: bpy.types.Object) -> np.ndarray:
    """The vertices of an evaluated mesh; none if it has become something else."""
    if not isinstance(thing.data, bpy.types.Mesh):
        return np.zeros((0, 3), dtype=np.float32)
    return compat.vertex_positions(thing.data)


def _add_positions(context: ExportContext, owner: bpy.types.Object, index: int, places: tuple[np.ndarray, list[np.ndarray]]) -> None:
    now, others = places
    if any(len(other) != len(now) for other in others):
        context.warn(owner.name, CHANGES)
        return
    if len(now) == 0 or not any(np.abs(other - now).max() > max(DEFORM_TOLERANCE, TOLERANCE * np.abs(now).max()) for other in others):
        return
    try:
        for name, other in zip((ajar.POSITION_BEFORE, ajar.POSITION_AFTER), others):
            context.description.set_vertex_attribute(index, name, other)
    except ValueError:   # adaptive subdivision exports another mesh
        context.warn(owner.name, CHANGES)
