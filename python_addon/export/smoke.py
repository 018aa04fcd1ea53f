"""Smoke: the voxels of the gas domain of a fluid simulation, as grids of a volume."""

from __future__ import annotations

import bpy
import numpy as np

from .. import compat
from ..ajar_module import ajar
from . import motion
from .context import ExportContext
from .volumes import BRICK, VELOCITY, Grid, farthest

# Floats per voxel of the grids that materials can read by name.
_COMPONENTS = {"density": 1, "flame": 1, "heat": 1, "temperature": 1, "color": 4, "velocity": 3}


def domain_of(owner: bpy.types.Object) -> bpy.types.FluidDomainSettings | None:
    for modifier in owner.modifiers:
        if modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN" and modifier.domain_settings.domain_type == "GAS":
            return modifier.domain_settings
    return None


def make(context: ExportContext, owner: bpy.types.Object, mesh: bpy.types.Mesh) -> ajar.MeshDescription | None:
    """The box of a domain with its grids at the current frame, or None after a warning if there is nothing to show. The surface of the domain is not shown."""
    domain = domain_of(owner)
    density = _read(domain, "density") if domain is not None else None
    if domain is None or density is None or not density.any() or len(mesh.vertices) == 0:
        context.warn(owner.name, "its smoke is empty in this frame and does not render; an unbaked simulation has to be baked or played first")
        return None
    lower, upper = (edge(compat.vertex_positions(mesh).astype(np.float64), axis=0) for edge in (np.min, np.max))
    if not (upper > lower).all():
        context.warn(owner.name, "its domain is flat and does not render")
        return None
    shutter = motion.of_shutter(context, owner)
    flow = (VELOCITY, domain.velocity_scale * shutter[0], shutter[1]) if shutter is not None and domain.velocity_scale != 0.0 else None
    wanted = context.attribute_names | ({VELOCITY} if flow is not None else set())
    grids: list[Grid] = []
    for name in ["density", *sorted((_COMPONENTS.keys() - {"density"}) & wanted)]:
        context.check_cancelled()
        values = density if name == "density" else _read(domain, name)
        if values is not None:
            grids.append((name, _index_from_object(values, lower, upper), *_bricks(values)))
    if not any(grid[0] == VELOCITY for grid in grids):
        flow = None
    # Values are interpolated up to the voxels outside, which are 0.
    voxel = (upper - lower) / np.array(density.shape[2::-1])
    around = 0.5 * voxel + farthest(grids, flow)
    return ajar.make_volume(name=mesh.name, lower=tuple(lower - around), upper=tuple(upper + around), grids=grids, flow=flow)


def _index_from_object(values: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> list[float]:
    """Twelve numbers. Noise does not multiply the resolution of all grids, so that the sizes of their voxels differ."""
    voxel = (upper - lower) / np.array(values.shape[2::-1])
    rows = np.column_stack([np.diag(1.0 / voxel), -lower / voxel - 0.5])
    return [float(x) for x in rows.reshape(-1)]


def _read(domain: bpy.types.FluidDomainSettings, name: str) -> np.ndarray | None:
    """float32[z, y, x, component], or None if the simulation does not have the grid."""
    values = getattr(domain, f"{name}_grid")
    shape, components = tuple(domain.domain_resolution), _COMPONENTS[name]
    count = len(values)
    voxels = shape[0] * shape[1] * shape[2]
    if voxels == 0 or count == 0:
        return None
    if count != voxels * components:   # noise multiplies the resolution
        factor = domain.noise_scale
        shape = tuple(n * factor for n in shape)
        if count != shape[0] * shape[1] * shape[2] * components:
            return None
    flat = np.empty(count, dtype=np.float32)
    values.foreach_get(flat)
    found: np.ndarray = flat.reshape(shape[2], shape[1], shape[0], components)
    if name == "density":
        found[~(found >= domain.clipping)] = 0.0   # as in Cycles; not a number is 0 as well
    return found


def _bricks(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Index and voxels of the bricks that are not 0."""
    components = values.shape[3]
    padded = np.pad(values, [(0, -n % BRICK) for n in values.shape[:3]] + [(0, 0)])
    z, y, x = (n // BRICK for n in padded.shape[:3])
    split = padded.reshape(z, BRICK, y, BRICK, x, BRICK, components).transpose(0, 2, 4, 1, 3, 5, 6)
    full = np.argwhere(split.any(axis=(3, 4, 5, 6)))
    return np.ascontiguousarray(full[:, ::-1]).astype(np.int32), np.ascontiguousarray(split[full[:, 0], full[:, 1], full[:, 2]]).reshape(-1)
