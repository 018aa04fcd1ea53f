"""The data tab of cameras."""

from __future__ import annotations

import bpy
from bpy.types import Panel

from .. import compat
from .common import AjarPanel

PANORAMA_SETTINGS = {
    "EQUIRECTANGULAR": ("latitude_min", "latitude_max", "longitude_min", "longitude_max"), "FISHEYE_EQUIDISTANT": ("fisheye_fov",),
    "FISHEYE_EQUISOLID": ("fisheye_lens", "fisheye_fov"),
    "FISHEYE_LENS_POLYNOMIAL": ("fisheye_fov", *(f"fisheye_polynomial_k{i}" for i in range(5))),
}


class CameraPanel(AjarPanel):
    bl_context = "data"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.camera is not None


class AJAR_CAMERA_PT_panorama(CameraPanel, Panel):
    bl_label = "Panorama"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.camera.type == "PANO"

    def draw(self, context: bpy.types.Context) -> None:
        column, settings = self.column(), compat.panorama_owner(context.camera)
        column.prop(settings, "panorama_type")
        for name in PANORAMA_SETTINGS.get(settings.panorama_type, ()):
            column.prop(settings, name)


class AJAR_CAMERA_PT_depth_of_field(CameraPanel, Panel):
    bl_label = "Depth of Field"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.camera.dof, "use_dof", text="")

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        lens = context.camera.dof
        column = self.layout.column()
        column.active = lens.use_dof
        column.prop(lens, "focus_object", text="Focus on Object")
        if lens.focus_object is not None and lens.focus_object.type == "ARMATURE":
            column.prop_search(lens, "focus_subtarget", lens.focus_object.data, "bones", text="Focus on Bone")
        distance = column.row()
        distance.active = lens.focus_object is None
        distance.prop(lens, "focus_distance", text="Focus Distance")


class AJAR_CAMERA_PT_aperture(CameraPanel, Panel):
    bl_label = "Aperture"
    bl_parent_id = "AJAR_CAMERA_PT_depth_of_field"

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        lens = context.camera.dof
        column = self.layout.column()
        column.active = lens.use_dof
        for name in ("aperture_fstop", "aperture_blades", "aperture_rotation", "aperture_ratio"):
            column.prop(lens, name)


CLASSES = (AJAR_CAMERA_PT_panorama, AJAR_CAMERA_PT_depth_of_field, AJAR_CAMERA_PT_aperture)
