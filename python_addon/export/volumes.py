"""Grids of OpenVDB in volume objects, as bricks of voxels.

The grids are read by the Python module of OpenVDB: `openvdb` in Blender 4.4 and newer, `pyopenvdb` of the distribution before. Grids that
Blender made or changed itself are written to a temporary file first.
"""

from __future__ import annotations

import importlib
import importlib.machinery
import importlib.util
import os
import sys
import tempfile
from types import ModuleType
from typing import Any

import bpy
import numpy as np

from ..ajar_module import ajar
from . import motion
from .context import ExportContext

BRICK = 8
CHUNK = 128             # voxels along an axis of a lower internal node of OpenVDB's tree
ROOT = 4096             # the same for a child of the root
MAX_ROOTS = 1_000_000   # of children of the root that the bounds of a grid may have
MAX_BRICKS = 2_000_000   # of a grid; 4 GiB of densities
LOWER_NODE = 2          # depth of a lower internal node in the tree
VELOCITY = "velocity"   # name of a grid that is made of three grids of components

VOXELS = BRICK ** 3

# Name, index_from_object, bricks and values of a grid, as ajar.make_volume takes them.
Grid = tuple[str, list[float], np.ndarray, np.ndarray]
# Name of the grid of velocities, by how much of a velocity its volume moves while the shutter is open, and the time of the frame in it, from 0 to 1.
Flow = tuple[str, float, float]


def library() -> ModuleType | None:
    for name in ("openvdb", "pyopenvdb"):
        try:
            return importlib.import_module(name)
        except ImportError:
            continue
    # Blender as a Python module has it in a folder that Python does not search.
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    folder = os.path.join(bpy.utils.resource_path("LOCAL"), "python", "lib", version, "site-packages")
    spec = importlib.machinery.PathFinder.find_spec("openvdb", [folder])
    if spec is None or spec.loader is None:
        return None
    module = sys.modules["openvdb"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def make(context: ExportContext, owner: bpy.types.Object, volume: bpy.types.Volume) -> ajar.MeshDescription | None:
    """The box of a volume with its grids, or None after a warning if there is nothing to show."""
    name = owner.name
    vdb = library()
    if vdb is None:
        context.warn(name, "this Blender cannot read OpenVDB files in Python (Blender 4.4 and newer can); the volume does not render")
        return None
    if not volume.grids.load():
        context.warn(name, 'its file cannot be read and the volume does not render: {error}', error=volume.grids.error_message or volume.filepath)
        return None
    if len(volume.grids) == 0:
        context.warn(name, "it has no grids and does not render")
        return None
    grids, corners = [], []
    for grid in _read(context, vdb, owner, volume):
        context.check_cancelled()
        found = _bricks(context, name, grid)
        if found is not None:
            grids.append(found[:4])
            corners.append(found[4])
    if not grids:
        context.warn(name, "all its grids are empty and it does not render")
        return None
    box = np.concatenate(corners)
    flow = _flow(context, owner, volume, grids)
    reach = farthest(grids, flow)
    return ajar.make_volume(name=volume.name, lower=tuple(box.min(axis=0) - reach), upper=tuple(box.max(axis=0) + reach), grids=grids,
                            density_in_object_space=volume.render.space == "OBJECT", flow=flow)


def farthest(grids: list[Grid], flow: Flow | None) -> np.ndarray:
    """How far values move along each axis while the shutter is open, in object space: float64[3]."""
    values = next((grid[3] for grid in grids if flow is not None and grid[0] == flow[0]), None)
    if flow is None or values is None:
        return np.zeros(3)
    return np.abs(values.reshape(-1, 3)).max(axis=0).astype(np.float64) * abs(flow[1]) * max(flow[2], 1.0 - flow[2])


def _flow(context: ExportContext, owner: bpy.types.Object, volume: bpy.types.Volume, grids: list[Grid]) -> Flow | None:
    """The grid of velocities, its scale and the time of the frame in the shutter, for motion blur. Three grids of components are joined to one, which is
    added to the grids."""
    shutter = motion.of_shutter(context, owner)
    if shutter is None or volume.velocity_scale == 0.0:
        return None
    seconds, frame = shutter
    # As in Cycles, velocities per frame are not multiplied by the length of the shutter.
    scale = volume.velocity_scale * (seconds if volume.velocity_unit == "SECOND" else 1.0)
    known = {grid[0]: grid for grid in grids}
    for name in (volume.velocity_grid, VELOCITY):
        if name in known and len(known[name][3]) == 3 * VOXELS * len(known[name][2]):
            return name, scale, frame
    names = (volume.velocity_x_grid, volume.velocity_y_grid, volume.velocity_z_grid)
    parts = {axis: known[name] for axis, name in enumerate(names) if name in known}   # grids of zeros are not among the known ones
    if VELOCITY in known or not all(names) or not parts:
        return None
    if any(len(part[3]) != VOXELS * len(part[2]) for part in parts.values()) or len({tuple(part[1]) for part in parts.values()}) > 1:
        context.warn(owner.name, "the grids of its velocity do not fit together; its motion is not blurred")
        return None
    grids.append(_joined(parts))
    return VELOCITY, scale, frame


def _joined(parts: dict[int, Grid]) -> Grid:
    """One grid of three components, of grids for some axes; the others are 0."""
    bricks = np.unique(np.concatenate([part[2] for part in parts.values()]), axis=0)
    index = {tuple(brick): number for number, brick in enumerate(bricks)}
    values = np.zeros((len(bricks), VOXELS, 3), dtype=np.float32)
    for axis, part in parts.items():
        values[[index[tuple(brick)] for brick in part[2]], :, axis] = part[3].reshape(-1, VOXELS)
    return VELOCITY, next(iter(parts.values()))[1], bricks.astype(np.int32), values.reshape(-1)


def _read(context: ExportContext, vdb: ModuleType, owner: bpy.types.Object, volume: bpy.types.Volume) -> list:
    path = bpy.path.abspath(volume.grids.frame_filepath) if volume.filepath and not volume.packed_file else ""
    is_file = os.path.isfile(path) and not any(modifier.show_render for modifier in owner.modifiers)
    try:
        if is_file:
            return vdb.readAll(path)[0]
        with tempfile.TemporaryDirectory(prefix="ajar_") as folder:
            path = os.path.join(folder, "grids.vdb")
            volume.grids.save(filepath=path)
            return vdb.readAll(path)[0]
    except Exception as error:  # noqa: BLE001: the module raises many types for damaged files
        context.warn(owner.name, "its file cannot be read and the volume does not render: {error}", error=str(error))
        return []


def _bricks(context: ExportContext, owner: str, grid: Any) -> tuple | None:
    """(name, index_from_object, bricks, values, corners of its bounds in object space), or None if the grid is empty or cannot be used."""
    first, last = (np.array(corner, dtype=np.int64) for corner in grid.evalActiveVoxelBoundingBox())
    if (first > last).any():
        return None
    components = _components(grid)
    if components is None:
        context.warn(owner, 'the grid "{grid}" has values of the type {type}, which cannot be rendered', grid=grid.name, type=grid.valueTypeName)
        return None
    if np.prod((last - first) // ROOT + 2, dtype=np.float64) > MAX_ROOTS:
        context.warn(owner, 'the grid "{grid}" is too large and is ignored: {size} voxels', grid=grid.name, size=" x ".join(str(n) for n in last - first + 1))
        return None
    object_from_index = _matrix(grid.transform)
    if object_from_index is None:
        context.warn(owner, 'the grid "{grid}" has a transform that is not affine or has no inverse, and is ignored', grid=grid.name)
        return None
    bricks, values = [], []
    for chunk in _chunks(grid, first, last):
        context.check_cancelled()
        dense = np.zeros((CHUNK, CHUNK, CHUNK) if components == 1 else (CHUNK, CHUNK, CHUNK, components), dtype=np.float32)
        grid.copyToArray(dense, ijk=tuple(int(i) for i in chunk))
        n = CHUNK // BRICK
        split = dense.reshape(n, BRICK, n, BRICK, n, BRICK, components).transpose(0, 2, 4, 5, 3, 1, 6)
        full = np.argwhere(split.any(axis=(3, 4, 5, 6)))
        if len(full):
            bricks.append((full + chunk // BRICK).astype(np.int32))
            values.append(split[full[:, 0], full[:, 1], full[:, 2]].reshape(-1))
        if sum(len(some) for some in bricks) > MAX_BRICKS:
            context.warn(owner, 'the grid "{grid}" has too many voxels and is ignored', grid=grid.name)
            return None
    if not bricks:
        return None
    # Values are interpolated up to the neighbouring voxels.
    sides = np.array((first - 1, last + 1), dtype=np.float64)
    corners = np.array([[sides[x, 0], sides[y, 1], sides[z, 2], 1.0] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    rows = np.linalg.inv(object_from_index)[:3].reshape(-1)
    return grid.name, [float(x) for x in rows], np.concatenate(bricks), np.concatenate(values), (corners @ object_from_index.T)[:, :3]


def _components(grid: Any) -> int | None:
    kind = grid.valueTypeName
    if kind in ("float", "double", "half", "int32", "int64", "bool"):
        return 1
    return 3 if kind.startswith("vec3") else None


def _matrix(transform: Any) -> np.ndarray | None:
    """Object from index, 4 x 4."""
    def at(*index: int) -> np.ndarray:
        return np.array(transform.indexToWorld(index), dtype=np.float64)

    matrix = np.eye(4)
    matrix[:3, 3] = at(0, 0, 0)
    for axis in range(3):
        matrix[:3, axis] = at(*(int(axis == k) for k in range(3))) - matrix[:3, 3]
    far = np.array((97, 89, 101, 1.0))
    is_affine = np.allclose((matrix @ far)[:3], at(97, 89, 101), rtol=1e-4, atol=1e-6 * float(np.abs(matrix).max()))
    return matrix if is_affine and np.isfinite(matrix).all() and np.linalg.det(matrix) != 0.0 else None


def _chunks(grid: Any, first: np.ndarray, last: np.ndarray) -> list[np.ndarray]:
    """The first voxels of all nodes of 128 x 128 x 128 voxels that can hold values. Empty space costs little."""
    accessor = grid.getConstAccessor()

    def firsts(low: np.ndarray, high: np.ndarray, size: int) -> list[np.ndarray]:
        ranges = [range(int(a) // size * size, int(b) + 1, size) for a, b in zip(low, high)]
        return [np.array((x, y, z), dtype=np.int64) for x in ranges[0] for y in ranges[1] for z in ranges[2]]

    def is_zero(place: tuple) -> bool:
        return not np.any(accessor.getValue(place))

    found = []
    for root in firsts(first, last, ROOT):
        corner = tuple(int(i) for i in root)
        depth = accessor.getValueDepth(corner)
        if depth < 0 or (depth == 0 and is_zero(corner)):
            continue
        for chunk in firsts(np.maximum(root, first), np.minimum(root + ROOT - 1, last), CHUNK):
            place = tuple(int(i) for i in chunk)
            if accessor.getValueDepth(place) >= LOWER_NODE or not is_zero(place):
                found.append(chunk)
    return found
