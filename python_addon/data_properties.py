"""Ajar's settings of objects, lamps, worlds, cameras and materials.

They include the settings that Blender stores in the add-on of Cycles, so that they can be used without it. Where Blender itself has a setting, that
one is read (compat.py), and the one of Ajar is not shown.
"""

# No `from __future__ import annotations`: Blender needs the annotations as objects, not as text.

import math

import bpy

from . import inherited

IMPORTANCE = {"name": "Importance", "description": "Adaptive sampling gives pixels that show this object or collection this many times more samples. Does not change "
              "the mean of the picture", "default": 1.0, "min": 0.0, "soft_max": 10.0}
PANORAMAS = [("EQUIRECTANGULAR", "Equirectangular", "Longitude and latitude", 0), ("FISHEYE_EQUIDISTANT", "Fisheye Equidistant", "Angles are distances", 1),
             ("FISHEYE_EQUISOLID", "Fisheye Equisolid", "As most fisheye lenses", 2), ("MIRRORBALL", "Mirror Ball", "As seen in a mirrored ball", 3),
             ("FISHEYE_LENS_POLYNOMIAL", "Fisheye Lens Polynomial", "Angles are a polynomial of distances", 4),
             ("EQUIANGULAR_CUBEMAP_FACE", "Equiangular Cubemap Face", "One face of a cube, with equal angles", 5)]
POLYNOMIAL = (-1.1735143712967577e-05, -0.019988736953434998, -3.3525322965709175e-06, 3.099275275886036e-06, -2.6064646454854524e-08)


class AjarObjectSettings(bpy.types.PropertyGroup):
    """Settings of every object. Names that begin with `hint` are settings of curves that are light hints."""

    importance: bpy.props.FloatProperty(**IMPORTANCE)
    hint_enabled: bpy.props.BoolProperty(name="Use", description="Propose light along this curve", default=True)
    hint_spread: bpy.props.FloatProperty(name="Spread", subtype="ANGLE", default=0.0872665, min=1e-4, max=3.14159,
                                         description="Half-angle of the cone around each segment. The radius of the control point at its end multiplies it")
    hint_light: bpy.props.PointerProperty(name="Starts At", description="Lamp that the first point of the curve follows",
                                          type=bpy.types.Object, poll=lambda self, thing: thing.type == "LIGHT")
    hint_offset: bpy.props.FloatVectorProperty(name="Offset", description="Position of the first point on the lamp, in the local space of the lamp",
                                               size=3, subtype="TRANSLATION")
    hint_weight: bpy.props.FloatProperty(name="Weight", description="How often this curve is proposed, relative to the others",
                                         default=1.0, min=0.0, soft_max=10.0)
    use_motion_blur: inherited.boolean("use_motion_blur", "Motion Blur", "Blur this object when it moves", True, "use_motion_blur")
    use_deform_motion: inherited.boolean("use_deform_motion", "Deformation", "Blur this object when it deforms", True, "use_deform_motion")
    motion_steps: inherited.integer("motion_steps", "Steps", "Each step doubles the number of times at which the motion of this object is followed",
                                    1, "motion_steps", 1, 7)
    shadow_terminator_geometry_offset: inherited.number(
        "shadow_terminator_geometry_offset", "Geometry Offset", "Moves shadow rays from coarse smooth surfaces outwards. 1 moves them to the rounded surface", 0.1,
        "shadow_terminator_geometry_offset", 0.0, 1.0, subtype="FACTOR")
    use_camera_cull: inherited.boolean("use_camera_cull", "Use Camera Cull", "Leave this object out if it is outside the view of the camera", False, "use_camera_cull")
    use_distance_cull: inherited.boolean("use_distance_cull", "Use Distance Cull", "Leave this object out if it is far from the camera", False, "use_distance_cull")

    use_adaptive_subdivision: inherited.boolean(
        "use_adaptive_subdivision", "Adaptive Subdivision", "Divides the faces before the last Subdivision Surface modifier into triangles of the size of a pixel, "
        "instead of the levels of the modifier", False, "use_adaptive_subdivision")
    dicing_rate: inherited.number("dicing_rate", "Dicing Scale", "Factor of the size of the triangles of this object", 1.0, "dicing_rate", 0.1, 1000.0)


class AjarLightSettings(bpy.types.PropertyGroup):
    cast_shadow: inherited.boolean("cast_shadow", "Cast Shadow", "Objects block the light of this lamp", True, "cast_shadow")
    use_multiple_importance_sampling: inherited.boolean(
        "use_multiple_importance_sampling", "Multiple Importance", "Sample this lamp by the materials too. Large lamps on shiny surfaces need it", True,
        "use_multiple_importance_sampling")
    max_bounces: inherited.integer("max_bounces", "Max Bounces", "Bounces after which this lamp is not sampled any more", 1024, "max_bounces", 0, 1024)
    is_portal: inherited.boolean("is_portal", "Portal", "The lamp emits nothing. Cycles samples the sky through it; Ajar needs no portals", False, "is_portal")


class AjarWorldSettings(bpy.types.PropertyGroup):
    """Which rays see the world, and how long it is sampled."""

    max_bounces: inherited.integer("max_bounces", "Max Bounces", "Bounces after which the world is not sampled any more", 1024, "max_bounces", 0, 1024)

    visible_camera: inherited.boolean("visible_camera", "Camera", "Camera rays see the world", True, "camera", "cycles_visibility")
    visible_diffuse: inherited.boolean("visible_diffuse", "Diffuse", "Diffuse surfaces receive light of the world", True, "diffuse", "cycles_visibility")
    visible_glossy: inherited.boolean("visible_glossy", "Glossy", "Glossy surfaces reflect the world", True, "glossy", "cycles_visibility")
    visible_transmission: inherited.boolean("visible_transmission", "Transmission", "Refracted rays see the world", True, "transmission", "cycles_visibility")
    visible_volume_scatter: inherited.boolean("visible_volume_scatter", "Volume Scatter", "Volumes receive light of the world", True, "scatter", "cycles_visibility")


class AjarCameraSettings(bpy.types.PropertyGroup):
    panorama_type: inherited.enum("panorama_type", "Panorama Type", "How directions are mapped to the picture", "FISHEYE_EQUISOLID", "panorama_type", PANORAMAS)
    fisheye_fov: inherited.number("fisheye_fov", "Field of View", "Angle that the fisheye lens sees", math.pi, "fisheye_fov", 0.1745, 10 * math.pi, subtype="ANGLE")
    fisheye_lens: inherited.number("fisheye_lens", "Lens", "Focal length of the fisheye lens in millimetres", 10.5, "fisheye_lens", 0.01, 1000.0)
    latitude_min: inherited.number("latitude_min", "Latitude Min", "Lowest latitude", -0.5 * math.pi, "latitude_min", -0.5 * math.pi, 0.5 * math.pi, subtype="ANGLE")
    latitude_max: inherited.number("latitude_max", "Max", "Highest latitude", 0.5 * math.pi, "latitude_max", -0.5 * math.pi, 0.5 * math.pi, subtype="ANGLE")
    longitude_min: inherited.number("longitude_min", "Longitude Min", "Leftmost longitude", -math.pi, "longitude_min", -math.pi, math.pi, subtype="ANGLE")
    longitude_max: inherited.number("longitude_max", "Max", "Rightmost longitude", math.pi, "longitude_max", -math.pi, math.pi, subtype="ANGLE")


for _i, _default in enumerate(POLYNOMIAL):
    AjarCameraSettings.__annotations__[f"fisheye_polynomial_k{_i}"] = inherited.number(
        f"fisheye_polynomial_k{_i}", f"Fisheye Polynomial K{_i}", f"Coefficient K{_i} of the lens polynomial", _default, f"fisheye_polynomial_k{_i}", -1e6, 1e6, precision=6)


class AjarMaterialSettings(bpy.types.PropertyGroup):
    displacement_method: inherited.enum(
        "displacement_method", "Displacement", "What the displacement of the material does", "BUMP", "displacement_method",
        [("BUMP", "Bump Only", "Changes the shading normal", 0), ("DISPLACEMENT", "Displacement Only", "Moves the surface", 1),
         ("BOTH", "Displacement and Bump", "Moves the surface and changes the shading normal", 2)])
    use_transparent_shadow: inherited.boolean(
        "use_transparent_shadow", "Transparent Shadows", "Light passes the transparent parts of the material", True, "use_transparent_shadow")
    use_bump_map_correction: inherited.boolean(
        "use_bump_map_correction", "Bump Map Correction", "Light fades softly where a bump faces it and the surface does not", True, "use_bump_map_correction")


GROUPS = {"Object": AjarObjectSettings, "Light": AjarLightSettings, "World": AjarWorldSettings, "Camera": AjarCameraSettings, "Material": AjarMaterialSettings}
