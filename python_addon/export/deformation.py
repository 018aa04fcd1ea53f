"""Shapes of meshes, strands and point clouds at several times while the shutter is open.

While the scene of the frame is exported, `watch` keeps what identifies a mesh and how its corners map to triangles. At each other time, `read` finds the
instance that shows it and copies positions, normals and radii. `export` hands over those that change.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import bpy
import numpy as np

from .. import compat, plain
from . import mesh, points, strands, subdivision
from .mesh import CornerMap

if TYPE_CHECKING:
    from .context import ExportContext
    from .objects import Geometry

NO_STRANDS = np.zeros(0, dtype=np.uint32)
TOLERANCE = 1e-6   # relative to the largest coordinate; shapes that differ by less are equal
CHANGES = "the number of its vertices changes while the shutter is open, so that only its motion is blurred"
DIVIDED = "it deforms while the shutter is open; with adaptive subdivision, only its motion is blurred"
VELOCITY = "velocity"   # the attribute of a mesh whose vertices change, in metres per second


@dataclass
class Shape:
    """The positions (and what belongs to them) at one time."""

    positions: np.ndarray
    normals: np.ndarray | None = None
    radii: np.ndarray | None = None


@dataclass
class Watched:
    """A mesh of the description that may deform."""

    name: str
    mesh: int                    # index in the description
    steps: int
    kind: type                   # of its data in Blender
    is_hair: bool
    is_divided: bool = False     # by adaptive subdivision
    corners: CornerMap | None = None
    strands: np.ndarray | None = None
    count: int = 0               # vertices
    velocity: np.ndarray | None = None
    found: dict[int, Shape | None] = field(default_factory=dict)   # by the number of the time; None: another topology


def watch(context: ExportContext, geometry: Geometry) -> None:
    """Called when the mesh has just been exported."""
    owner, data = geometry.owner, geometry.data
    if context.watched is None or geometry.is_volume or geometry.known_by is None or not _may_deform(owner, geometry):
        return
    watched = Watched(owner.name, geometry.mesh_index, plain.of(owner.ajar).motion_steps, type(data), geometry.is_hair)
    if not geometry.is_hair and isinstance(data, bpy.types.Mesh):
        watched.is_divided = geometry.is_own and subdivision.wanted(context, owner) is not None
        watched.count = len(data.vertices)
        if not watched.is_divided:
            watched.corners = mesh.corner_map(data)
            watched.velocity = _velocity(data)
    context.watched.setdefault(geometry.known_by, []).append(watched)


def _may_deform(owner: bpy.types.Object, geometry: Geometry) -> bool:
    """Whether anything could change the shape. A mesh alone keeps it."""
    settings = plain.of(owner.ajar)
    if not settings.use_motion_blur or not settings.use_deform_motion:
        return False
    return geometry.is_hair or owner.type != "MESH" or mesh.is_shaped(owner)


def _velocity(data: bpy.types.Mesh) -> np.ndarray | None:
    attribute = data.attributes.get(VELOCITY)
    if attribute is None or attribute.data_type != "FLOAT_VECTOR" or attribute.domain != "POINT":
        return None
    values = np.empty(3 * len(attribute.data), dtype=np.float32)
    attribute.data.foreach_get("vector", values)
    return values.reshape(-1, 3)


def read(context: ExportContext, instance: bpy.types.DepsgraphObjectInstance, number: int, watched: list[Watched]) -> None:
    """Copy the shapes of one instance at the time of this number."""
    for item in watched:
        if number in item.found or not isinstance(instance.object.data, item.kind) or item.velocity is not None:
            continue
        item.found[number] = _shape(context, instance, item)


def _shape(context: ExportContext, instance: bpy.types.DepsgraphObjectInstance, item: Watched) -> Shape | None:
    data = instance.object.data
    owner = instance.instance_object if instance.is_instance else instance.object
    if item.is_hair:
        return _of_arrays(item, strands.of_particles(context, owner, data, is_shape_only=True))
    if isinstance(data, bpy.types.Mesh):
        if len(data.vertices) != item.count:
            return None
        positions = compat.vertex_positions(data)
        if item.corners is None:
            return Shape(positions)
        normals = mesh.normals_by(item.corners, data, positions)
        return Shape(positions, normals[1]) if normals is not None else None
    if isinstance(data, bpy.types.PointCloud):
        return _of_arrays(item, points.of_cloud(context, data, item.name))
    return _of_arrays(item, strands.of_curves(context, data, item.name))


def _of_arrays(item: Watched, found: dict | None) -> Shape | None:
    if found is None:
        return None
    roots = found.get("strands", NO_STRANDS)
    if item.strands is None:
        item.strands = roots
    return Shape(found["positions"], None, found["radii"]) if np.array_equal(roots, item.strands) else None


def export(context: ExportContext, times: list[float]) -> bool:
    """Hand over the shapes that change. `times`: in frames from the frame. Returns whether there are any."""
    last, found = len(times) - 1, False
    for item in (item for known in (context.watched or {}).values() for item in known):
        step = max(1, last >> item.steps)
        if item.velocity is not None:
            found |= _export_velocity(context, item, times[::step])
            continue
        shapes = [item.found.get(number) for number in range(0, last + 1, step)]
        known = [shape for shape in shapes if shape is not None]
        if not item.found:
            continue
        if len(known) < len(shapes) or any(shape.positions.shape != known[0].positions.shape for shape in known):
            context.warn(item.name, CHANGES)
        elif _differs([shape.positions for shape in known]) or _differs(_all("radii", known)):
            found |= _hand_over(context, item, known)
    return found


def _all(name: str, shapes: list[Shape]) -> list[np.ndarray]:
    """The normals or radii of all shapes; an empty list if some have none, or another number."""
    found = [values for values in (getattr(shape, name) for shape in shapes) if values is not None]
    return found if len(found) == len(shapes) and all(values.shape == found[0].shape for values in found) else []


def _differs(values: list[np.ndarray]) -> bool:
    scale = max(float(np.abs(values[0]).max(initial=0.0)), 1e-30) if values else 1.0
    return any(float(np.abs(other - values[0]).max(initial=0.0)) > TOLERANCE * scale for other in values[1:])


def _hand_over(context: ExportContext, item: Watched, shapes: list[Shape]) -> bool:
    if item.is_divided:
        context.warn(item.name, DIVIDED)
        return False
    normals, radii = _all("normals", shapes), _all("radii", shapes)
    return _set_shapes(context, item, np.stack([shape.positions for shape in shapes]), np.stack(normals) if normals else None, np.stack(radii) if radii else None)


def _set_shapes(context: ExportContext, item: Watched, positions: np.ndarray, normals: np.ndarray | None, radii: np.ndarray | None) -> bool:
    try:
        context.description.set_shapes(item.mesh, positions, normals, radii)
    except ValueError:   # the mesh of the frame has another number of vertices
        context.warn(item.name, CHANGES)
        return False
    return True


def _export_velocity(context: ExportContext, item: Watched, times: list[float]) -> bool:
    """Vertices that move straight with the velocity of the frame, as in Cycles: fluids, whose vertices change between frames."""
    render = context.scene.render
    seconds = np.array(times, dtype=np.float32) * (render.fps_base / render.fps)
    if item.velocity is None or item.corners is None or not item.velocity.any():
        return False
    return _set_shapes(context, item, item.corners.positions + seconds[:, None, None] * item.velocity, None, None)
