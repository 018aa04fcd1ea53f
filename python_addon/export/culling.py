"""Camera culling and distance culling: objects outside the view of the camera, or far from it, are left out, as in Cycles with Simplify.

An object is left out if its bounding box lies outside the frame with its margin, or farther from the camera than the margin of the distance. If it uses
both, both must hold. Lamps stay. A panorama sees all directions and culls nothing; nor does stereoscopy. A 3D view culls what it does not see at an edit, and
keeps this while it moves, as in Cycles.
"""

from __future__ import annotations

import bpy
import numpy as np

from .. import plain
from ..ajar_module import ajar
from .context import ExportContext


def is_wanted(scene: bpy.types.Scene) -> bool:
    settings = plain.of(scene.ajar)
    return scene.render.use_simplify and not scene.render.use_multiview and (settings.use_camera_cull or settings.use_distance_cull)


class Culling:
    def __init__(self, context: ExportContext) -> None:
        scene = context.scene
        settings = plain.of(scene.ajar)
        self.camera = context.description.camera
        wanted = is_wanted(scene)
        if wanted and not self.camera.present and not context.is_view:
            context.warn(scene.name, "there is no camera for culling: all objects stay")
        usable = wanted and self.camera.present and self.camera.kind != ajar.CameraKind.Panorama
        self._by_camera = usable and settings.use_camera_cull
        self._by_distance = usable and settings.use_distance_cull and settings.distance_cull_margin > 0.0
        self._frame_margin, self._distance = settings.camera_cull_margin, settings.distance_cull_margin
        self.exists = self._by_camera or self._by_distance

    def stays(self, owner: bpy.types.Object, rows: np.ndarray) -> np.ndarray:
        """Which instances of an object stay. `rows`: float32[n, 12], their transforms."""
        settings = plain.of(owner.ajar)
        by_camera = self._by_camera and settings.use_camera_cull
        by_distance = self._by_distance and settings.use_distance_cull
        culled = np.full(len(rows), by_camera or by_distance)
        corners = np.array(owner.bound_box, dtype=np.float64)
        transforms = rows.reshape(-1, 3, 4).astype(np.float64)
        boxes = np.einsum("nij,kj->nki", transforms[:, :, :3], corners) + transforms[:, None, :, 3]   # instances, corners, axes
        if by_camera:
            culled &= self._outside_frame(boxes)
        if by_distance:
            culled &= self._far(boxes)
        return ~culled

    def _outside_frame(self, boxes: np.ndarray) -> np.ndarray:
        camera, margin = self.camera, self._frame_margin
        frame = np.array(camera.world_from_camera, dtype=np.float64).reshape(3, 4)
        local = (boxes - frame[:, 3]) @ frame[:, :3]   # the axes of a camera have unit length
        depth = -local[..., 2]
        left, right, bottom, top = camera.screen_window
        with np.errstate(divide="ignore", invalid="ignore"):
            across = local[..., :2] if camera.kind == ajar.CameraKind.Orthographic else local[..., :2] / depth[..., None]
            places = (across - (left, bottom)) / (right - left, top - bottom)   # 0 to 1 in the frame
        beyond_near = (depth - camera.clip_start) * (camera.clip_end / max(camera.clip_end - camera.clip_start, 1e-9)
                                                     if camera.kind != ajar.CameraKind.Orthographic else 1.0 / max(camera.clip_end - camera.clip_start, 1e-9))
        # Behind the near plane, the image is mirrored.
        places = np.where((beyond_near < 0.0)[..., None], 1.0 - places, places)
        all_behind = np.all(beyond_near < -margin, axis=1)
        lowest, highest = places.min(axis=1), places.max(axis=1)
        return all_behind | np.any((lowest >= 1.0 + margin) | (highest <= -margin), axis=1)

    def _far(self, boxes: np.ndarray) -> np.ndarray:
        eye = np.array(self.camera.world_from_camera, dtype=np.float64).reshape(3, 4)[:, 3]
        closest = np.clip(eye, boxes.min(axis=1), boxes.max(axis=1))
        return np.linalg.norm(closest - eye, axis=1) > self._distance
