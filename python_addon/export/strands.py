"""Hair as strands: particle systems and hair curves.

Blender's interface returns particle hair point by point, and root data strand by strand; it has no bulk copy. The data of hair curves are copied in
bulk.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np

from .. import compat, plain
from ..ajar_module import ajar
from . import attributes

if TYPE_CHECKING:
    from .context import ExportContext

EMPTY_RADIUS = 0.005   # for hair curves without a radius, as in Cycles
POLY = 1               # a value of the attribute `curve_type`
SHAPES = {"RIBBONS": ajar.StrandShape.Ribbon, "THICK": ajar.StrandShape.Round, "THICK_LINEAR": ajar.StrandShape.Linear}


# ---- Particle hair --------------------------------------------------------------------------------------------------------

def systems(context: ExportContext, thing: bpy.types.Object) -> list[bpy.types.ParticleSystemModifier]:
    """The modifiers of an evaluated object that show hair as strands."""
    if thing.type != "MESH" or not context.view_layer.use_strand:
        return []
    final = context.depsgraph.mode == "RENDER"
    return [modifier for modifier in thing.modifiers if modifier.type == "PARTICLE_SYSTEM" and (modifier.show_render if final else modifier.show_viewport)
            and modifier.particle_system.settings.type == "HAIR" and modifier.particle_system.settings.render_type == "PATH"]


def _shown(psys: bpy.types.ParticleSystem, final: bool) -> range:
    """Numbers of the visible strands. Children come after the parents; if there are children, parents may be invisible."""
    settings, parents, children = psys.settings, len(psys.particles), len(psys.child_particles)
    if not final:
        children = int(children * settings.display_percentage / 100.0)
    return range(parents if settings.child_type != "NONE" and children else 0, parents + children)


def _steps(settings: bpy.types.ParticleSettings, final: bool) -> int:
    steps = 2 ** (settings.render_step if final else settings.display_step) + 1
    return steps + settings.kink_extra_steps if settings.kink == "SPIRAL" else steps


def count(context: ExportContext, thing: bpy.types.Object) -> tuple[tuple[int, int], ...]:
    """Numbers of strands and points of each system, from which changes are detected."""
    final = context.depsgraph.mode == "RENDER"
    return tuple((len(_shown(modifier.particle_system, final)), _steps(modifier.particle_system.settings, final)) for modifier in systems(context, thing))


def of_particles(context: ExportContext, thing: bpy.types.Object, mesh: bpy.types.Mesh, is_shape_only: bool = False) -> dict | None:
    """The arguments of `ajar.make_strands` for all systems of an evaluated object, or None if there are no strands. `is_shape_only`: without attributes."""
    final = context.depsgraph.mode == "RENDER"
    inverse = np.array(thing.matrix_world.inverted_safe(), dtype=np.float64)
    positions, radii, lengths, slots = [], [], [], []
    uv_layers = {layer.name: number for number, layer in enumerate(mesh.uv_layers)}
    rendered = next((layer.name for layer in mesh.uv_layers if layer.active_render), "")
    places: dict[str, list] = {name: [] for name in uv_layers if not is_shape_only and (name == rendered or name in context.attribute_names)}
    for modifier in systems(context, thing):
        psys = modifier.particle_system
        settings, shown = psys.settings, _shown(psys, final)
        steps = _steps(settings, final)
        if not shown:
            continue
        context.check_cancelled()
        co_hair = psys.co_hair
        points = (co_hair(thing, particle_no=strand, step=step) for strand in shown for step in range(steps))
        world = compat.coordinates(points, steps * len(shown)).reshape(len(shown), steps, 3)
        present = _present(world)
        usable = present[:, 1]   # a strand has two points at least
        shown = np.array(shown)[usable].tolist()
        if not shown:
            continue
        world, present = world[usable], present[usable]
        local = (world @ inverse[:3, :3].T + inverse[:3, 3]).astype(np.float32)
        positions.append(local[present])
        radii.append(_radii(settings, local, present)[present])
        lengths.append(present.sum(axis=1, dtype=np.uint32))
        slots.append(np.full(len(shown), max(settings.material - 1, 0), dtype=np.uint16))
        context.check_cancelled()
        parents = len(psys.particles)
        for name, found in places.items():
            layer = uv_layers[name]
            for strand in shown:
                # Children have no particle, so that an arbitrary one is used.
                particle = psys.particles[strand if strand < parents else 0]
                found.append(psys.uv_on_emitter(modifier, particle=particle, particle_no=strand, uv_no=layer))
    if not positions:
        return None
    ends = np.cumsum(np.concatenate(lengths), dtype=np.uint32)
    location, size = compat.texture_space(mesh)
    all_slots = np.concatenate(slots)
    return {**shape(context), "name": f"{thing.name} hair", "positions": np.concatenate(positions), "radii": np.concatenate(radii),
            "strands": ends - np.concatenate(lengths), "material_slots": all_slots if all_slots.any() else None,
            "attributes": [(name, ajar.Domain.Face, np.array(found, dtype=np.float32).reshape(-1, 2)) for name, found in places.items()],
            "active_uv": rendered, "texture_space_location": location, "texture_space_size": size}


def _present(points: np.ndarray) -> np.ndarray:
    """Which points exist; [strands, points]. Children that were cut (Length, Random Length) have fewer points: Blender gives zeros for the rest."""
    zero = ~np.asarray(points.any(axis=2))
    return ~np.logical_and.accumulate(zero[:, ::-1], axis=1)[:, ::-1]


def _radii(settings: bpy.types.ParticleSettings, points: np.ndarray, present: np.ndarray) -> np.ndarray:
    """Radii from root to tip by the shape of the strands; [strands, points]. As in Cycles, only strands that have all points close their tip."""
    pieces = np.where(present[:, 1:], np.linalg.norm(np.diff(points, axis=1), axis=2), 0.0)
    way = np.concatenate([np.zeros((len(points), 1)), np.cumsum(pieces, axis=1)], axis=1)
    length = way[:, -1:]
    left = 1.0 - np.divide(way, length, out=np.zeros_like(way), where=length > 0.0)
    shape = settings.shape
    if shape != 0.0:
        left = np.maximum(left, 0.0) ** (1.0 + shape if shape < 0.0 else 1.0 / max(1.0 - shape, 1e-6))
    scale = 0.5 * settings.radius_scale
    root, tip = scale * settings.root_radius, scale * settings.tip_radius
    radii = (left * (root - tip) + tip).astype(np.float32)
    if settings.use_close_tip:
        radii[:, -1] = 0.0
    return radii


# ---- Hair curves ------------------------------------------------------------------------------------------------------------

def of_curves(context: ExportContext, curves: bpy.types.Curves, name: str) -> dict | None:
    """The arguments of `ajar.make_strands`, or None if there are no strands."""
    strands = len(curves.curves)
    position = curves.attributes.get("position")
    if strands == 0 or position is None or not context.view_layer.use_strand:
        return None
    points = attributes.read(position)
    first = np.empty(strands, dtype=np.int32)
    curves.curves.foreach_get("first_point_index", first)
    radius = curves.attributes.get("radius")
    radii = attributes.read(radius) if radius is not None and radius.domain == "POINT" else np.full(len(points), EMPTY_RADIUS, dtype=np.float32)
    context.check_cancelled()
    coordinates = next((a.name for a in curves.attributes if a.data_type == "FLOAT2" and a.domain == "CURVE"), "")
    values = attributes.named(curves, context.attribute_names | {coordinates})
    if context.uses_generated:   # hair curves have none, so that the position in object space is used, as in Cycles
        values.append((ajar.UNDEFORMED_POSITION, ajar.Domain.Vertex, points))
    if attributes.CURVE_NORMAL in context.attribute_names and hasattr(curves, "normals"):
        normals = np.empty(3 * len(points), dtype=np.float32)
        curves.normals.foreach_get("vector", normals)
        values.append((attributes.CURVE_NORMAL, ajar.Domain.Vertex, normals.reshape(-1, 3)))
    form = shape(context)
    if compat.poly_curves_are_straight() and _are_poly(curves):
        form["shape"] = ajar.StrandShape.Linear
    return {**form, "name": name, "positions": points, "radii": radii, "strands": first.astype(np.uint32), "attributes": values,
            "active_uv": coordinates, "texture_space_location": (0.5, 0.5, 0.5), "texture_space_size": (0.5, 0.5, 0.5)}


def _are_poly(curves: bpy.types.Curves) -> bool:
    """Whether the first strand has straight pieces; Cycles takes all to be as the first."""
    kind = curves.attributes.get("curve_type")
    return kind is not None and len(kind.data) > 0 and kind.data[0].value == POLY


def shape(context: ExportContext) -> dict:
    """The shape of hair, a setting of the scene in Cycles."""
    ours = plain.of(context.scene.ajar)
    return {"shape": SHAPES[ours.curve_shape], "subdivisions": ours.curve_subdivisions}
