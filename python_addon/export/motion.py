"""Motion blur: transforms of objects and the camera at several times while the shutter is open.

This is the last step of an export: the scene is evaluated again for every other time, after which objects that were evaluated before must not be
used. The shutter opens and closes as in Cycles. The number of times is the maximum that an object requests, as in Cycles.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import numpy as np

from .. import compat, plain
from . import camera
from .context import ExportContext, rows_3x4

FrameSet = Callable[[int, float], None]
_OPENS = {"START": 0.0, "CENTER": -0.5, "END": -1.0}  # in shutter times from the frame
SHUTTER_TIMES = 65
TOLERANCE = 1e-6  # relative to the largest number of a matrix; objects that move by less are at rest


def is_wanted(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> bool:
    return scene.render.use_motion_blur and getattr(view_layer, "use_motion_blur", True) and scene.render.motion_blur_shutter > 0.0


def identity(instance: bpy.types.DepsgraphObjectInstance) -> tuple:
    """The key by which an instance is found at another time."""
    if instance.is_instance:
        return (instance.parent.original.as_pointer(), instance.instance_object.original.as_pointer(), *instance.persistent_id)
    return (instance.object.original.as_pointer(),)


def export(context: ExportContext, camera_object: bpy.types.Object | None, frame_set: FrameSet, eye: camera.Eye = camera.CENTRE) -> None:
    scene, depsgraph = context.scene, context.depsgraph
    context.report_step("motion")
    context.description.camera.shutter = _shutter(scene.render)
    if compat.cycles_value(scene, "rolling_shutter_type", "NONE") != "NONE":
        context.warn(scene.name, "a rolling shutter is not supported: all lines of the picture are exposed together")
    frame, subframe = scene.frame_current, scene.frame_subframe
    original_camera = camera_object.original if camera_object is not None else None
    still = {thing.original.as_pointer() for thing in depsgraph.objects if not _is_blurred(thing)}
    times = _times(scene, depsgraph)
    shown: dict[tuple, list[int]] = {}   # a surface and its hair have the same key
    appearances = context.appearances or []
    for index, known_by in enumerate(appearances):
        if still.isdisjoint(known_by[:2]):
            shown.setdefault(known_by, []).append(index)
    matrices = np.full((len(appearances), len(times), 12), np.nan, dtype=np.float32)
    cameras: list[list[float]] = []
    lenses: set[tuple[float, ...]] = set()
    boxes: dict[str, list[list[tuple[float, ...]]]] = {}
    try:
        for number, time in enumerate(times):
            context.check_cancelled()
            moment = frame + subframe + time
            frame_set(math.floor(moment), moment - math.floor(moment))
            for instance in depsgraph.object_instances:
                for index in shown.get(identity(instance), ()):
                    x, y, z, _ = instance.matrix_world
                    matrices[index, number] = (*x, *y, *z)
            for thing in depsgraph.objects:
                if thing.type in ("MESH", "CURVES") and thing.original.as_pointer() not in still and plain.of(thing.ajar).use_deform_motion:
                    boxes.setdefault(thing.name, []).append([tuple(corner) for corner in thing.bound_box])
            if original_camera is not None and original_camera.type == "CAMERA":
                there = original_camera.evaluated_get(depsgraph)
                cameras.append(rows_3x4(camera.without_scale(eye.world_from_camera(there))))
                lenses.add((there.data.lens, there.data.ortho_scale, there.data.shift_x, there.data.shift_y))
    finally:
        frame_set(frame, subframe)
    moving = differs(matrices)
    context.description.set_motion(np.flatnonzero(moving).astype(np.int32), matrices[moving])
    if cameras and original_camera.as_pointer() not in still and differs(np.array([cameras], dtype=np.float32))[0]:
        context.description.camera.motion = cameras
    if len(lenses) > 1:
        context.warn(original_camera.name, "its lens changes while the shutter is open; only its motion is blurred")
    for name, corners in boxes.items():
        if not np.allclose(corners, corners[0], atol=1e-5):
            context.warn(name, "it deforms while the shutter is open; motion blur supports only moving objects, not deformation")


def _is_blurred(thing: bpy.types.Object) -> bool:
    return plain.of(thing.ajar).use_motion_blur


def _times(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> list[float]:
    """The times in frames relative to the current one, equidistant."""
    steps = max((plain.of(thing.ajar).motion_steps for thing in depsgraph.objects if _is_blurred(thing)), default=1)
    count = 2 ** steps + 1
    opens = _OPENS[plain.of(compat.shutter_owner(scene)).motion_blur_position]
    return [scene.render.motion_blur_shutter * (opens + i / (count - 1)) for i in range(count)]


def differs(matrices: np.ndarray) -> np.ndarray:
    """Which of the matrices [things, times, 12] differ between times. Objects that do not exist at all times are at rest."""
    if len(matrices) == 0:
        return np.zeros(0, dtype=bool)
    scale = np.abs(matrices).max(axis=(1, 2))
    return np.isfinite(scale) & (np.ptp(matrices, axis=1).max(axis=1) > TOLERANCE * scale)


def _shutter(render: bpy.types.RenderSettings) -> list[float]:
    """Times at which equal fractions of the light have arrived; none if the curve is constant."""
    mapping = render.motion_blur_shutter_curve
    mapping.initialize()
    curve = mapping.curves[0]
    places = np.linspace(0.0, 1.0, 4 * SHUTTER_TIMES + 1)
    values = np.maximum([mapping.evaluate(curve, place) for place in places], 0.0)
    if values.max() <= 0.0 or np.ptp(values) < 1e-4 * values.max():
        return []
    shares = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]))])
    inverse = np.interp(np.linspace(0.0, 1.0, SHUTTER_TIMES), shares / shares[-1], places)
    inverse[0], inverse[-1] = 0.0, 1.0
    return inverse.tolist()
