"""Motion blur: transforms of objects and the camera at several times while the shutter is open.

This is the last step of an export: the scene is evaluated again for every other time, after which objects that were evaluated before must not be
used. The shutter opens and closes as in Cycles. The scene is evaluated as often as the object with the most steps requests; each object has keys for its
own steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import numpy as np

from .. import compat, plain
from ..ajar_module import ajar
from . import camera, deformation
from .context import ExportContext, rows_3x4

FrameSet = Callable[[int, float], None]
_OPENS = {"START": 0.0, "CENTER": -0.5, "END": -1.0}  # in shutter times from the frame
SHUTTER_TIMES = 65
TOLERANCE = 1e-6  # relative to the largest number of a matrix; objects that move by less are at rest


def is_wanted(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> bool:
    return scene.render.use_motion_blur and getattr(view_layer, "use_motion_blur", True) and scene.render.motion_blur_shutter > 0.0


def of_shutter(context: ExportContext, owner: bpy.types.Object) -> tuple[float, float] | None:
    """How long the shutter is open, in seconds, and the time of the frame in it, from 0 to 1; None if the shape of this object is not blurred."""
    settings = plain.of(owner.ajar)
    if context.watched is None or not settings.use_motion_blur or not settings.use_deform_motion:
        return None
    render = context.scene.render
    opens = _OPENS[plain.of(compat.shutter_owner(context.scene)).motion_blur_position]
    return render.motion_blur_shutter * render.fps_base / render.fps, -opens


def identity(instance: bpy.types.DepsgraphObjectInstance) -> tuple:
    """The key by which an instance is found at another time."""
    if instance.is_instance:
        return (instance.parent.original.as_pointer(), instance.instance_object.original.as_pointer(), *instance.persistent_id)
    return (instance.object.original.as_pointer(),)


def export(context: ExportContext, camera_object: bpy.types.Object | None, frame_set: FrameSet, eye: camera.Eye = camera.CENTRE) -> None:
    scene, depsgraph = context.scene, context.depsgraph
    context.report_step("motion")
    context.description.camera.shutter = _shutter(scene.render)
    frame, subframe = scene.frame_current, scene.frame_subframe
    original_camera = camera_object.original if camera_object is not None and camera_object.type == "CAMERA" else None
    still = {thing.original.as_pointer() for thing in depsgraph.objects if not _is_blurred(thing)}
    steps_of = {thing.original.as_pointer(): plain.of(thing.ajar).motion_steps for thing in depsgraph.objects}
    times = _times(scene, depsgraph)
    shown: dict[tuple, list[int]] = {}   # a surface and its hair have the same key
    appearances, watched = context.appearances or [], context.watched or {}
    for index, known_by in enumerate(appearances):
        if still.isdisjoint(known_by[:2]):
            shown.setdefault(known_by, []).append(index)
    matrices = np.full((len(appearances), len(times), 12), np.nan, dtype=np.float32)
    cameras: list[list[float]] = []
    windows: list[tuple[float, float, float, float]] = []
    try:
        for number, time in enumerate(times):
            context.check_cancelled()
            moment = frame + subframe + time
            frame_set(math.floor(moment), moment - math.floor(moment))
            for instance in depsgraph.object_instances:
                known_by = identity(instance)
                for index in shown.get(known_by, ()):
                    x, y, z, _ = instance.matrix_world
                    matrices[index, number] = (*x, *y, *z)
                if known_by in watched:
                    deformation.read(context, instance, number, watched[known_by])
            if original_camera is not None:
                there = original_camera.evaluated_get(depsgraph)
                cameras.append(rows_3x4(camera.without_scale(eye.world_from_camera(there))))
                windows.append(camera.screen_window(depsgraph.scene_eval.render, there.data, eye.shift_x(there)))
    finally:
        frame_set(frame, subframe)
    context.refresh()
    moves = _set_motion(context, matrices, [max(steps_of.get(key, 1) for key in known_by[:2]) for known_by in appearances])
    if original_camera is not None and original_camera.as_pointer() not in still:
        moves |= _set_camera(context.description.camera, cameras, windows, steps_of.get(original_camera.as_pointer(), 1))
    moves |= deformation.export(context, times)
    settings = plain.of(context.scene.ajar)
    if moves and settings.rolling_shutter_type != "NONE":
        context.description.camera.row_exposure = settings.rolling_shutter_duration


def _set_motion(context: ExportContext, matrices: np.ndarray, steps: list[int]) -> bool:
    """The keys of the instances that move. Each has as many as it asks for, as in Cycles. Returns whether there are any."""
    moving, wanted = differs(matrices), np.array(steps, dtype=np.int64)
    last = matrices.shape[1] - 1
    for number in np.unique(wanted[moving]):
        own = np.flatnonzero(moving & (wanted == number))
        context.description.set_motion(own.astype(np.int32), np.ascontiguousarray(matrices[own][:, ::max(1, last >> int(number))]))
    return bool(moving.any())


def _set_camera(out: ajar.CameraDescription, cameras: list[list[float]], windows: list[tuple[float, float, float, float]], steps: int) -> bool:
    step = max(1, (len(cameras) - 1) >> steps)
    if differs(np.array([cameras], dtype=np.float32))[0]:
        out.motion = cameras[::step]
    if np.ptp(np.array(windows), axis=0).max() > TOLERANCE * np.abs(windows).max():
        out.window_motion = windows[::step]
    return bool(out.motion or out.window_motion)


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
