"""Every difference between Blender versions, in one place. Written for 3.4 and newer."""

from __future__ import annotations

import bpy
import numpy as np

# Cycles' enumerations as stored in a file, for when its add-on is not enabled.
_CYCLES_ENUMS = {
    "pixel_filter_type": ("BOX", "GAUSSIAN", "BLACKMAN_HARRIS"),
    "panorama_type": ("EQUIRECTANGULAR", "FISHEYE_EQUIDISTANT", "FISHEYE_EQUISOLID", "MIRRORBALL", "FISHEYE_LENS_POLYNOMIAL",
                      "EQUIANGULAR_CUBEMAP_FACE"),
}


# ---- Settings that a file was given for Cycles --------------------------------------------------------------------

def _stored(owner: bpy.types.bpy_struct, group: str) -> dict:
    """Properties of a group as the file stores them; empty where they are no longer reachable (5.0)."""
    try:
        value = owner.get(group)
    except (TypeError, AttributeError):
        return {}
    return value if value is not None else {}


def has_cycles_settings(owner: bpy.types.bpy_struct) -> bool:
    """Whether somebody set something of Cycles on this scene (light, world, ...)."""
    cycles = getattr(owner, "cycles", None)
    if cycles is None:
        return bool(_stored(owner, "cycles"))
    return any(cycles.is_property_set(name) for name in cycles.bl_rna.properties.keys() if name not in ("rna_type", "name"))


def cycles_value(owner: bpy.types.bpy_struct, name: str, default: object) -> object:
    """A Cycles property of `owner`, enabled or only stored; `default` where neither has it."""
    cycles = getattr(owner, "cycles", None)
    if cycles is not None:
        return getattr(cycles, name, default)
    value = _stored(owner, "cycles").get(name, default)
    if name in _CYCLES_ENUMS and isinstance(value, int):
        return _CYCLES_ENUMS[name][value]
    return value


def panorama_value(camera: bpy.types.Camera, name: str, default: object) -> object:
    """A property of panoramic cameras: Blender's own where it has them (5.0), before that Cycles'."""
    return getattr(camera, name) if hasattr(camera, name) else cycles_value(camera, name, default)


# ---- Meshes ---------------------------------------------------------------------------------------------------------

def _numbers(collection: bpy.types.bpy_prop_collection, name: str, columns: int, kind: type) -> np.ndarray:
    values = np.empty(len(collection) * columns, dtype=kind)
    collection.foreach_get(name, values)
    return values.reshape(-1, columns) if columns > 1 else values


def polygon_materials(mesh: bpy.types.Mesh) -> np.ndarray | None:
    """Material index per polygon; None: all 0."""
    attribute = mesh.attributes.get("material_index")
    if attribute is None or attribute.domain != "FACE" or len(attribute.data) != len(mesh.polygons):
        return None if bpy.app.version >= (3, 4) else _numbers(mesh.polygons, "material_index", 1, np.int32)
    return _numbers(attribute.data, "value", 1, np.int32)


def polygon_smooth(mesh: bpy.types.Mesh) -> np.ndarray:
    """Whether each polygon is shaded smooth."""
    if bpy.app.version >= (4, 1):
        sharp = mesh.attributes.get("sharp_face")
        if sharp is None or sharp.domain != "FACE":
            return np.ones(len(mesh.polygons), dtype=bool)
        return ~_numbers(sharp.data, "value", 1, bool)
    return _numbers(mesh.polygons, "use_smooth", 1, bool)


def has_split_normals(mesh: bpy.types.Mesh) -> bool:
    """Whether the normals of one vertex may differ between smooth corners."""
    if bpy.app.version >= (4, 1):
        return mesh.normals_domain == "CORNER"
    return mesh.use_auto_smooth or mesh.has_custom_normals


def corner_normals(mesh: bpy.types.Mesh) -> np.ndarray:
    """Split normals, one per polygon corner."""
    if bpy.app.version >= (4, 1):
        return _numbers(mesh.corner_normals, "vector", 3, np.float32)
    mesh.calc_normals_split()
    normals = _numbers(mesh.loops, "normal", 3, np.float32)
    mesh.free_normals_split()
    return normals


def vertex_normals(mesh: bpy.types.Mesh) -> np.ndarray:
    return _numbers(mesh.vertex_normals, "vector", 3, np.float32)


def texture_space(mesh: bpy.types.Mesh) -> tuple[tuple[float, ...], tuple[float, ...]]:
    return tuple(mesh.texspace_location), tuple(mesh.texspace_size)


# ---- Images -----------------------------------------------------------------------------------------------------------

def packed_bytes(image: bpy.types.Image) -> bytes:
    """The file packed into the .blend, or nothing."""
    packed = image.packed_file or (image.packed_files[0] if len(image.packed_files) else None)
    return bytes(packed.data) if packed is not None and packed.size > 0 else b""


# ---- Drawing --------------------------------------------------------------------------------------------------------------

POLYLINE_SHADER = "POLYLINE_UNIFORM_COLOR" if bpy.app.version >= (4, 0) else "3D_POLYLINE_UNIFORM_COLOR"


def font_size(font: int, size: int) -> None:
    import blf

    if bpy.app.version >= (4, 0):
        blf.size(font, size)
    else:
        blf.size(font, size, 72)
