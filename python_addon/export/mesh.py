"""Meshes as triangles. All data are copied in bulk, without loops over elements.

A corner of triangle t is one of Blender's loops: `loops[t, k]` maps all values of corners to triangles.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from .. import compat, plain
from ..ajar_module import ajar
from .context import ExportContext

EMPTY = -1
Polygons = Callable[[], np.ndarray]   # the polygon of each triangle; most meshes do not need them


@dataclass
class CornerMap:
    """How the corners of the triangles map to the loops and polygons of a mesh, to read the same corners at another time."""

    positions: np.ndarray
    triangles: np.ndarray   # [n, 3] vertices
    loops: np.ndarray
    polygons: np.ndarray
    loop_count: int

_DOMAINS = {"POINT": ajar.Domain.Vertex, "CORNER": ajar.Domain.Corner, "FACE": ajar.Domain.Face}
_VALUES = {  # data type of an attribute -> RNA name of its value, components
    "FLOAT": ("value", 1), "INT": ("value", 1), "INT8": ("value", 1), "BOOLEAN": ("value", 1), "FLOAT2": ("vector", 2),
    "FLOAT_VECTOR": ("vector", 3), "FLOAT_COLOR": ("color", 4), "BYTE_COLOR": ("color", 4),
}


def arrays(context: ExportContext, mesh: bpy.types.Mesh, name: str, is_modified: bool) -> dict | None:
    """The arguments of `ajar.make_mesh` and `SceneDescription.add_mesh`, or None if there are no triangles."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    context.check_cancelled()
    # Unsigned as in Blender, so that Blender copies them in bulk.
    loops = compat.numbers(mesh.loop_triangles, "loops", 3, np.uint32)
    polygons = functools.cache(lambda: compat.triangle_polygons(mesh))
    triangles = compat.corner_vertices(mesh)[loops]
    positions = compat.vertex_positions(mesh)
    context.check_cancelled()
    normal_domain, normals = _normals(mesh, positions, triangles, loops, polygons)
    context.check_cancelled()
    materials = compat.polygon_materials(mesh)
    slots = materials[polygons()].astype(np.uint16) if materials is not None and materials.any() else None
    attributes = _uv_maps(mesh, loops) + _colors(mesh, loops, polygons) + _requested(context, mesh, loops, polygons)
    attributes += _analysed(context, mesh, positions, triangles)
    attributes += _tangents(context, mesh, positions, triangles, (normal_domain, normals), loops)
    if normals is not None and normal_domain == ajar.Domain.Corner and materials_move_vertices(mesh):
        attributes.append((ajar.FLAT_FACES, ajar.Domain.Face, (~_smooth(mesh))[polygons()].astype(np.float32).reshape(-1, 1)))
    if is_modified and context.uses_generated:
        attributes += _undeformed(mesh, positions)
    context.check_cancelled()
    location, size = compat.texture_space(mesh)
    return {"name": name, "positions": positions, "triangles": triangles, "material_slots": slots, "normals": normals,
            "normal_domain": normal_domain, "attributes": attributes, "active_uv": _rendered_map(mesh),
            "texture_space_location": location, "texture_space_size": size}


def face_arrays(context: ExportContext, mesh: bpy.types.Mesh, name: str, keeps_normals: bool) -> dict | None:
    """The arguments of `ajar.make_mesh` for a mesh that is divided into triangles later, with "faces", the numbers of corners, "corners", their vertices,
    and "flat", the faces that are shaded flat. None if there are no faces."""
    count = len(mesh.polygons)
    if count == 0:
        return None
    context.check_cancelled()
    sizes, starts = compat.numbers(mesh.polygons, "loop_total", 1, np.int32), compat.numbers(mesh.polygons, "loop_start", 1, np.int32)
    ends = np.cumsum(sizes, dtype=np.int64)
    loops = np.arange(ends[-1]) + np.repeat(starts - (ends - sizes), sizes)   # in the order of the faces
    polygons = functools.cache(lambda: np.arange(count))
    positions = compat.vertex_positions(mesh)
    corners = compat.corner_vertices(mesh)[loops]
    smooth = _smooth(mesh)
    normals = None
    split = keeps_normals and compat.has_split_normals(mesh)
    if keeps_normals and smooth.any():
        normals = compat.corner_normals(mesh)[loops] if split else compat.vertex_normals(mesh)
    materials = compat.polygon_materials(mesh)
    attributes = _uv_maps(mesh, loops) + _colors(mesh, loops, polygons) + _requested(context, mesh, loops, polygons)
    attributes += _analysed(context, mesh, positions, corners[ends - sizes].reshape(-1, 1))
    if context.uses_generated:
        attributes += _undeformed(mesh, positions)
    location, size = compat.texture_space(mesh)
    return {"name": name, "positions": positions, "triangles": np.zeros((0, 3), dtype=np.uint32),
            "material_slots": materials.astype(np.uint16) if materials is not None and materials.any() else None, "normals": normals,
            "normal_domain": ajar.Domain.Corner if split else ajar.Domain.Vertex, "attributes": attributes, "active_uv": _rendered_map(mesh),
            "texture_space_location": location, "texture_space_size": size, "faces": sizes.astype(np.uint32), "corners": corners,
            "flat": ~smooth if not smooth.all() else None}


def is_shaped(owner: bpy.types.Object) -> bool:
    """Whether modifiers, shape keys or a parent may have moved the vertices of its mesh."""
    return len(owner.modifiers) > 0 or getattr(owner.data, "shape_keys", None) is not None or owner.parent_type in ("ARMATURE", "LATTICE")


def corner_map(mesh: bpy.types.Mesh) -> CornerMap:
    mesh.calc_loop_triangles()
    loops = compat.numbers(mesh.loop_triangles, "loops", 3, np.uint32)
    return CornerMap(compat.vertex_positions(mesh), compat.corner_vertices(mesh)[loops], loops,
                     compat.triangle_polygons(mesh), len(mesh.loops))


def normals_by(corners: CornerMap, mesh: bpy.types.Mesh, positions: np.ndarray) -> tuple[ajar.Domain, np.ndarray | None] | None:
    """The normals of the same corners at another time. None if the mesh has other faces."""
    if len(mesh.loops) != corners.loop_count or (len(corners.polygons) and len(mesh.polygons) <= corners.polygons.max()):
        return None
    if not np.array_equal(compat.corner_vertices(mesh)[corners.loops], corners.triangles):
        return None
    return _normals(mesh, positions, corners.triangles, corners.loops, lambda: corners.polygons)


def _rendered_map(mesh: bpy.types.Mesh) -> str:
    active = mesh.uv_layers.active
    return next((layer.name for layer in mesh.uv_layers if layer.active_render), active.name if active else "")


def _normals(mesh: bpy.types.Mesh, positions: np.ndarray, triangles: np.ndarray, loops: np.ndarray,
             polygons: Polygons) -> tuple[ajar.Domain, np.ndarray | None]:
    """Shading normals: none if all faces are flat, per vertex if all are smooth, otherwise per corner."""
    smooth = _smooth(mesh)
    if not smooth.any():
        return ajar.Domain.Corner, None
    split = compat.has_split_normals(mesh)
    if smooth.all() and not split:
        return ajar.Domain.Vertex, compat.vertex_normals(mesh)
    if split:
        return ajar.Domain.Corner, compat.corner_normals(mesh)[loops].reshape(-1, 3)
    corners = compat.vertex_normals(mesh)[triangles]
    flat = ~smooth[polygons()]
    # The normal of the triangle, not of its polygon, since polygons need not be planar.
    corners[flat] = _triangle_normals(positions, triangles[flat])[:, None, :]
    return ajar.Domain.Corner, corners.reshape(-1, 3)


def _smooth(mesh: bpy.types.Mesh) -> np.ndarray:
    """Whether each polygon is shaded smooth."""
    return compat.polygon_smooth(mesh) | compat.has_custom_normals(mesh)


def materials_move_vertices(mesh: bpy.types.Mesh) -> bool:
    return any(material is not None and plain.of(compat.displacement_owner(material)).displacement_method != "BUMP" for material in mesh.materials)


def _triangle_normals(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return np.divide(normal, length, out=np.zeros_like(normal), where=length > 0.0)


def _uv_maps(mesh: bpy.types.Mesh, loops: np.ndarray) -> list[tuple]:
    flat_loops = loops.reshape(-1)
    return [(layer.name, ajar.Domain.Corner, np.take(compat.uv_coordinates(layer), flat_loops, axis=0))
            for layer in mesh.uv_layers if len(layer.data) == len(mesh.loops)]


def _undeformed(mesh: bpy.types.Mesh, positions: np.ndarray) -> list[tuple]:
    """Positions of the vertices before the modifiers, which Blender keeps when it evaluates for a render."""
    undeformed = compat.numbers(mesh.vertices, "undeformed_co", 3, np.float32)
    return [] if np.array_equal(undeformed, positions) else [(ajar.UNDEFORMED_POSITION, ajar.Domain.Vertex, undeformed)]


def _analysed(context: ExportContext, mesh: bpy.types.Mesh, positions: np.ndarray, triangles: np.ndarray) -> list[tuple]:
    """Values of the Geometry node that depend on the whole mesh."""
    found = []
    if ajar.RANDOM_PER_ISLAND in context.attribute_names:
        random = ajar.random_per_island(len(positions), compat.numbers(mesh.edges, "vertices", 2, np.uint32))
        found.append((ajar.RANDOM_PER_ISLAND, ajar.Domain.Face, random[triangles[:, 0]].reshape(-1, 1)))
    if ajar.POINTINESS in context.attribute_names:
        values = ajar.pointiness(positions, compat.vertex_normals(mesh), compat.numbers(mesh.edges, "vertices", 2, np.uint32))
        found.append((ajar.POINTINESS, ajar.Domain.Vertex, values.reshape(-1, 1)))
    return found


def _tangents(context: ExportContext, mesh: bpy.types.Mesh, positions: np.ndarray, triangles: np.ndarray,
              normals: tuple[ajar.Domain, np.ndarray | None], loops: np.ndarray) -> list[tuple]:
    """The smooth tangents of the UV maps whose normal maps, tangents or displacements materials use. Without a name, of the active map."""
    wanted = [name for name in sorted(context.attribute_names) if name.startswith(ajar.TANGENT_OF)]
    if not wanted:
        return []
    domain, values = normals
    if values is None:
        values = np.repeat(_triangle_normals(positions, triangles), 3, axis=0)
    elif domain == ajar.Domain.Vertex:
        values = values[triangles.reshape(-1)]
    layers = {layer.name: layer for layer in mesh.uv_layers if len(layer.data) == len(mesh.loops)}
    rendered = next((layer for layer in mesh.uv_layers if layer.active_render), mesh.uv_layers.active)
    found = []
    for name in wanted:
        uv_map = name[len(ajar.TANGENT_OF):]
        layer = layers.get(uv_map) if uv_map else rendered
        if layer is not None or (not uv_map and not layers):   # without UV maps: coordinates on a sphere
            uvs = np.take(compat.uv_coordinates(layer), loops.reshape(-1), axis=0) if layer is not None else None
            context.check_cancelled()
            found.append((name, ajar.Domain.Corner, ajar.uv_tangents(positions, triangles, values, uvs)))
    return found


def _colors(mesh: bpy.types.Mesh, loops: np.ndarray, polygons: Polygons) -> list[tuple]:
    return [_attribute(attribute, loops, polygons) for attribute in mesh.color_attributes if len(attribute.data)]


def _requested(context: ExportContext, mesh: bpy.types.Mesh, loops: np.ndarray, polygons: Polygons) -> list[tuple]:
    """Other attributes that a material uses by name."""
    known = {layer.name for layer in mesh.uv_layers} | {attribute.name for attribute in mesh.color_attributes}
    found = []
    for name in sorted(context.attribute_names - known):
        attribute = mesh.attributes.get(name)
        if attribute is None:
            continue
        if attribute.data_type not in _VALUES or attribute.domain not in {"EDGE", *_DOMAINS}:
            context.warn(mesh.name, 'its attribute "{attribute}" cannot be read, because materials have no values of its type', attribute=name)
        elif attribute.domain == "EDGE":
            found.append(_of_edges(mesh, attribute))
        else:
            found.append(_attribute(attribute, loops, polygons))
    return found


def _of_edges(mesh: bpy.types.Mesh, attribute: bpy.types.Attribute) -> tuple:
    """For each vertex, the mean of its edges, as in Cycles."""
    values, edges = _values_of(attribute), compat.numbers(mesh.edges, "vertices", 2, np.uint32)
    count = len(mesh.vertices)
    number = np.maximum(np.bincount(edges.ravel(), minlength=count), 1)
    means = [np.bincount(edges.ravel(), np.repeat(column, 2), minlength=count) / number for column in values.T]
    return attribute.name, ajar.Domain.Vertex, np.stack(means, axis=1).astype(np.float32)


def _values_of(attribute: bpy.types.Attribute) -> np.ndarray:
    value, components = _VALUES[attribute.data_type]
    kind = {"INT": np.int32, "INT8": np.int32, "BOOLEAN": bool}.get(attribute.data_type, np.float32)
    return compat.numbers(attribute.data, value, components, kind).astype(np.float32, copy=False).reshape(-1, components)


def _attribute(attribute: bpy.types.Attribute, loops: np.ndarray, polygons: Polygons) -> tuple:
    values = _values_of(attribute)
    if attribute.domain == "CORNER":
        values = values[loops.reshape(-1)]
    elif attribute.domain == "FACE":
        values = values[polygons()]
    return attribute.name, _DOMAINS[attribute.domain], values
