"""The camera of a 3D view for the core. It is exactly that of Blender's overlays."""

from __future__ import annotations

import math
from dataclasses import dataclass

import bpy
from mathutils import Matrix, Vector

from .ajar_module import ajar
from .export import camera as export_camera
from .export.context import rows_3x4


@dataclass(frozen=True)
class View:
    """Contains values only, so that two views can be compared."""

    world_from_camera: tuple[float, ...]
    orthographic: bool
    window: tuple[float, float, float, float]          # left, right, bottom, top at distance 1; orthographic: in metres
    clip: tuple[float, float]
    lens: tuple[float, float, int, float, float]       # aperture radius, focus distance, blades, rotation, ratio
    size: tuple[int, int]                              # size of the region in pixels
    border: tuple[int, int, int, int]                  # rendered part, in pixels of the region
    panorama: ajar.PanoramaDescription | None = None   # if set, `window` is the visible part of the panorama

    def camera(self) -> ajar.CameraDescription:
        out = ajar.CameraDescription()
        out.present, out.name = True, "View"
        out.kind = ajar.CameraKind.Orthographic if self.orthographic else ajar.CameraKind.Perspective
        if self.panorama is not None:
            out.kind, out.panorama = ajar.CameraKind.Panorama, self.panorama
        out.world_from_camera = list(self.world_from_camera)
        out.screen_window = self.window
        out.clip_start, out.clip_end = self.clip
        out.aperture_radius, out.focus_distance, out.blades, out.blade_rotation, out.aperture_ratio = self.lens
        return out

    def resolution(self, divider: int) -> tuple[tuple[int, int], list[int]]:
        """Size and region of an image with one pixel for `divider` squared pixels of the view."""
        width, height = (max(1, math.ceil(side / divider)) for side in self.size)
        x0, y0, x1, y1 = (edge / divider for edge in self.border)
        left, bottom = min(int(x0), width - 1), min(int(y0), height - 1)
        return (width, height), [left, bottom, min(max(math.ceil(x1), left + 1), width), min(max(math.ceil(y1), bottom + 1), height)]

    def pixels(self) -> int:
        x0, y0, x1, y1 = self.border
        return (x1 - x0) * (y1 - y0)


def of(region: bpy.types.Region, region_3d: bpy.types.RegionView3D, space: bpy.types.SpaceView3D,
       depsgraph: bpy.types.Depsgraph) -> View | None:
    """The view, or None while it has no size."""
    width, height = region.width, region.height
    projection = region_3d.window_matrix
    if width < 1 or height < 1 or projection[0][0] == 0.0 or projection[1][1] == 0.0:
        return None
    frame = region_3d.view_matrix.inverted_safe()
    orthographic = projection[3][3] == 1.0
    x, y = (projection[0][3], projection[1][3]) if orthographic else (-projection[0][2], -projection[1][2])
    sx, sy = projection[0][0], projection[1][1]
    window = ((-1.0 - x) / sx, (1.0 - x) / sx, (-1.0 - y) / sy, (1.0 - y) / sy)
    camera = _camera(region_3d, space, depsgraph)
    lens = (0.0, 10.0, 0, 0.0, 1.0)
    if orthographic:
        near, far = (projection[2][3] + 1.0) / projection[2][2], (projection[2][3] - 1.0) / projection[2][2]
        frame = frame @ Matrix.Translation((0.0, 0.0, -near))  # orthographic views show planes behind the eye
        clip = (0.0, far - near)
    elif camera is not None:
        clip = (camera.data.clip_start, camera.data.clip_end)
    else:
        clip = (space.clip_start, space.clip_end)
    if camera is not None and not orthographic:
        lens = export_camera.lens_of(camera.data, frame)
    panorama = None
    if camera is not None and camera.data.type == "PANO":
        panorama = export_camera.panorama_of(depsgraph.scene.render, camera.data)
        left, bottom, right, top = _camera_frame(region_3d, camera, depsgraph.scene)
        window = (-left / (right - left), (1.0 - left) / (right - left), -bottom / (top - bottom), (1.0 - bottom) / (top - bottom))
    return View(tuple(rows_3x4(frame)), orthographic, window, clip, lens, (width, height),
                _border(region, region_3d, space, depsgraph, camera), panorama)


def _camera(region_3d: bpy.types.RegionView3D, space: bpy.types.SpaceView3D, depsgraph: bpy.types.Depsgraph) -> bpy.types.Object | None:
    """The camera that the view looks through."""
    if region_3d.view_perspective != "CAMERA":
        return None
    camera = space.camera if space.use_local_camera else depsgraph.scene.camera
    return camera.evaluated_get(depsgraph) if camera is not None and camera.type == "CAMERA" else None


def _border(region: bpy.types.Region, region_3d: bpy.types.RegionView3D, space: bpy.types.SpaceView3D, depsgraph: bpy.types.Depsgraph,
            camera: bpy.types.Object | None) -> tuple[int, int, int, int]:
    """The render region that the artist has set in the view, otherwise the whole view."""
    width, height = region.width, region.height
    full = (0, 0, width, height)
    if camera is None:
        if not space.use_render_border:
            return full
        edges = (space.render_border_min_x, space.render_border_min_y, space.render_border_max_x, space.render_border_max_y)
    else:
        render = depsgraph.scene.render
        if not render.use_border:
            return full
        left, bottom, right, top = _camera_frame(region_3d, camera, depsgraph.scene)
        edges = (left + (right - left) * render.border_min_x, bottom + (top - bottom) * render.border_min_y,
                 left + (right - left) * render.border_max_x, bottom + (top - bottom) * render.border_max_y)
    x0, y0, x1, y1 = (min(max(round(edge * side), 0), side) for edge, side in zip(edges, (width, height, width, height)))
    return (x0, y0, x1, y1) if x1 > x0 and y1 > y0 else full


def _camera_frame(region_3d: bpy.types.RegionView3D, camera: bpy.types.Object, scene: bpy.types.Scene) -> tuple[float, ...]:
    """Left, bottom, right, top of the camera frame as fractions of the region."""
    shares = []
    for corner in camera.data.view_frame(scene=scene):
        clip = region_3d.window_matrix @ Vector((*corner, 1.0))
        shares.append((0.5 + 0.5 * clip.x / clip.w, 0.5 + 0.5 * clip.y / clip.w))
    xs, ys = zip(*shares)
    return min(xs), min(ys), max(xs), max(ys)
