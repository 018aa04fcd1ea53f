"""The camera: the part of the plane at distance 1 that the frame shows, and the lens."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import bpy
from mathutils import Matrix

from .. import compat, plain, unsupported
from ..ajar_module import ajar
from .context import ExportContext, rows_3x4
from .settings import resolution

_KINDS = {"PERSP": ajar.CameraKind.Perspective, "ORTHO": ajar.CameraKind.Orthographic, "PANO": ajar.CameraKind.Panorama}
_PANORAMAS = {
    "EQUIRECTANGULAR": ajar.PanoramaKind.Equirectangular, "FISHEYE_EQUIDISTANT": ajar.PanoramaKind.FisheyeEquidistant,
    "FISHEYE_EQUISOLID": ajar.PanoramaKind.FisheyeEquisolid, "FISHEYE_LENS_POLYNOMIAL": ajar.PanoramaKind.FisheyePolynomial,
    "MIRRORBALL": ajar.PanoramaKind.MirrorBall, "EQUIANGULAR_CUBEMAP_FACE": ajar.PanoramaKind.CubemapFace,
}


@dataclass(frozen=True)
class Eye:
    """Where a view of the render sees from. The default is the camera itself; with stereoscopy, it is one of its two eyes."""

    world_from_camera: Callable[[bpy.types.Object], Matrix] = lambda thing: thing.matrix_world
    shift_x: Callable[[bpy.types.Object], float] = lambda thing: thing.data.shift_x
    is_spherical: Callable[[bpy.types.Object], bool] = lambda thing: False   # whether its place depends on the direction of the ray
    side: float = 0.0   # of a spherical one, in distances between the eyes to the right of the centre


CENTRE: Eye = Eye()


def export(context: ExportContext, camera_object: bpy.types.Object | None, eye: Eye = CENTRE) -> None:
    if camera_object is None or camera_object.type != "CAMERA":
        return  # the core reports it
    describe(context, context.description.camera, camera_object, eye)


def describe(context: ExportContext, out: ajar.CameraDescription, camera_object: bpy.types.Object, eye: Eye = CENTRE) -> None:
    """Set `out` to what a camera sees in the frame of the scene, from one of its eyes."""
    camera = camera_object.data
    context.warn_all(camera_object.name, unsupported.asked_of(camera, unsupported.CAMERA))
    if eye.is_spherical(camera_object):
        out.stereo = stereo_of(camera.stereo, eye.side)
    out.present = True
    out.name = camera_object.name
    out.kind = _KINDS.get(camera.type, ajar.CameraKind.Perspective)   # custom cameras are reported
    frame = without_scale(eye.world_from_camera(camera_object))
    out.world_from_camera = rows_3x4(frame)
    out.screen_window = screen_window(context.scene.render, camera, eye.shift_x(camera_object))
    out.clip_start = camera.clip_start
    out.clip_end = camera.clip_end
    out.aperture_radius, out.focus_distance, out.blades, out.blade_rotation, out.aperture_ratio = lens_of(camera, frame)
    if camera.type == "PANO":
        out.panorama = panorama_of(context.scene.render, camera)
        if kind_of_panorama(camera) not in _PANORAMAS:
            context.warn(camera_object.name, "the panorama type {kind} is not supported; it renders as equirectangular", kind=kind_of_panorama(camera))


def stereo_of(stereo: bpy.types.CameraStereoData, side: float) -> tuple[float, float, float, float]:
    """The eye of spherical stereoscopy: see CameraDescription.stereo."""
    convergence = 0.0 if stereo.convergence_mode == "PARALLEL" else stereo.convergence_distance
    merge = (stereo.pole_merge_angle_from, stereo.pole_merge_angle_to) if stereo.use_pole_merge else (0.0, 0.0)
    return (side * stereo.interocular_distance, convergence, *merge)


def kind_of_panorama(camera: bpy.types.Camera) -> str:
    return plain.of(compat.panorama_owner(camera)).panorama_type


def panorama_of(render: bpy.types.RenderSettings, camera: bpy.types.Camera) -> ajar.PanoramaDescription:
    """The mapping from the film to directions, as in Cycles."""
    lens = plain.of(compat.panorama_owner(camera))
    out = ajar.PanoramaDescription()
    out.kind = _PANORAMAS.get(kind_of_panorama(camera), ajar.PanoramaKind.Equirectangular)
    out.limits = (lens.longitude_min, lens.longitude_max, lens.latitude_min, lens.latitude_max)
    out.fisheye_fov, out.fisheye_lens = lens.fisheye_fov, lens.fisheye_lens
    out.polynomial = [getattr(lens, f"fisheye_polynomial_k{i}") for i in range(5)]
    # The sensor fits one axis of the frame.
    width, height, horizontal = _fit(render, camera)
    size = camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width
    out.sensor = (size, size * height / width) if horizontal else (size * width / height, size)
    return out


def _fit(render: bpy.types.RenderSettings, camera: bpy.types.Camera) -> tuple[float, float, bool]:
    """The sides of the frame, and whether the sensor fits the horizontal one."""
    width, height = resolution(render)
    width, height = width * render.pixel_aspect_x, height * render.pixel_aspect_y
    return width, height, camera.sensor_fit == "HORIZONTAL" or (camera.sensor_fit == "AUTO" and width >= height)


def screen_window(render: bpy.types.RenderSettings, camera: bpy.types.Camera, shift_x: float) -> tuple[float, float, float, float]:
    """Left, right, bottom, top at z = -1 (orthographic: in metres). The sensor fits one axis; the aspect ratio gives the other. `shift_x` is the shift of the
    view to the right."""
    if camera.type == "PANO":
        return (0.0, 1.0, 0.0, 1.0)
    width, height, horizontal = _fit(render, camera)
    if camera.type == "ORTHO":
        extent = camera.ortho_scale
    else:
        extent = (camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width) / camera.lens
    half_width = 0.5 * extent * (1.0 if horizontal else width / height)
    half_height = 0.5 * extent * (height / width if horizontal else 1.0)
    x, y = shift_x * extent, camera.shift_y * extent  # both shifts are in units of the fitted axis
    return (x - half_width, x + half_width, y - half_height, y + half_height)


def lens_of(camera: bpy.types.Camera, frame: Matrix) -> tuple[float, float, int, float, float]:
    """Aperture radius, focus distance, blades, their rotation, ratio of the axes. `frame` is the transform of the camera to the world."""
    lens = camera.dof
    if not lens.use_dof or lens.aperture_fstop <= 0.0:
        return (0.0, 10.0, 0, 0.0, 1.0)
    focal_length = 1.0 if camera.type == "ORTHO" else camera.lens * 1e-3  # in metres; one metre for orthographic lenses
    distance = lens.focus_distance
    if lens.focus_object is not None:
        target = lens.focus_object.matrix_world.translation
        distance = abs((target - frame.translation).dot(frame.col[2].to_3d()))
    return (focal_length / (2.0 * lens.aperture_fstop), distance, lens.aperture_blades, lens.aperture_rotation, lens.aperture_ratio)


def without_scale(matrix: Matrix) -> Matrix:
    result = matrix.copy()
    for column in range(3):
        axis = matrix.col[column].to_3d().normalized()
        for row in range(3):
            result[row][column] = axis[row]
    return result
