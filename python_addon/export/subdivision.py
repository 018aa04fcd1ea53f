"""Adaptive subdivision: the faces of meshes before their last modifier, a Subdivision Surface modifier that Cycles and Ajar replace.

Since 4.5 Cycles divides the mesh before this modifier; older versions divide the mesh that the modifier has made, and so does Ajar there. Python sees
the mesh before the modifier only if it is the original mesh, or if the scene is evaluated with the modifier switched off (`prepare`). A viewport
cannot do the latter. There, a mesh with further modifiers is divided as the modifier has made it, without making it smooth again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from .. import compat, inherited, plain
from ..ajar_module import ajar
from . import camera, mesh
from .context import ExportContext

SHARPEST = 10.0   # of OpenSubdiv; a crease of 1
_UV_SMOOTHING = {
    "NONE": ajar.UvSmoothing.None_, "PRESERVE_CORNERS": ajar.UvSmoothing.KeepCorners,
    "PRESERVE_CORNERS_AND_JUNCTIONS": ajar.UvSmoothing.KeepCornersAndJunctions,
    "PRESERVE_CORNERS_JUNCTIONS_AND_CONCAVE": ajar.UvSmoothing.KeepCornersJunctionsAndConcave,
    "PRESERVE_BOUNDARIES": ajar.UvSmoothing.KeepBoundaries, "SMOOTH_ALL": ajar.UvSmoothing.All,
}


@dataclass
class Wanted:
    """Adaptive subdivision of an object."""

    modifier: bpy.types.SubsurfModifier
    in_pixels: bool
    edge_length: float


def wanted(context: ExportContext, thing: bpy.types.Object) -> Wanted | None:
    """What the object asks for. The modifier must be its last one."""
    modifier = thing.modifiers[-1] if len(thing.modifiers) > 0 else None
    is_preview = context.depsgraph.mode == "VIEWPORT"
    if modifier is None or modifier.type != "SUBSURF" or not context.divides:
        return None
    if thing.original.as_pointer() not in context.base_is_evaluated and not (modifier.show_viewport if is_preview else modifier.show_render):
        return None
    settings = plain.of(context.scene.ajar)
    rate = settings.preview_dicing_rate if is_preview else settings.dicing_rate
    if compat.adapts_by_modifier():
        if not modifier.use_adaptive_subdivision:
            return None
        in_pixels = modifier.adaptive_space == "PIXEL"
        return Wanted(modifier, in_pixels, max(0.1, modifier.adaptive_pixel_size * rate) if in_pixels else modifier.adaptive_object_edge_length * rate)
    own = plain.of(thing.original.ajar)
    if not own.use_adaptive_subdivision or not (inherited.is_own(thing.original.ajar, "use_adaptive_subdivision") or compat.is_experimental(context.scene)):
        return None
    return Wanted(modifier, True, max(0.1, own.dicing_rate * rate))


def signature(context: ExportContext, thing: bpy.types.Object) -> tuple:
    """What the division of an object depends on, apart from its mesh."""
    found = wanted(context, thing)
    return () if found is None else (found.in_pixels, found.edge_length)


def prepare(context: ExportContext, frame_set: Callable[[int, float], None] | None) -> None:
    """Evaluate the scene without the modifiers that adaptive subdivision replaces, where that is necessary. Objects that were evaluated before must not
    be used afterwards."""
    if frame_set is None or not compat.adapts_before_modifier():
        return
    switched: list[bpy.types.SubsurfModifier] = []
    for thing in context.depsgraph.objects:
        found = wanted(context, thing) if thing.type == "MESH" else None
        if found is None or _is_original(thing, found.modifier) or thing.original.library is not None:
            continue
        modifier = thing.original.modifiers.get(found.modifier.name)
        if modifier is not None:
            switched.append(modifier)
            context.base_is_evaluated.add(thing.original.as_pointer())
    if not switched:
        return
    scene = context.scene
    try:
        for modifier in switched:
            modifier.show_render = False
            modifier.id_data.update_tag(refresh={"OBJECT", "DATA"})
        frame_set(scene.frame_current, scene.frame_subframe)
    finally:
        for modifier in switched:   # the evaluated scene keeps the state above until it is evaluated again
            modifier.show_render = True
            modifier.id_data.update_tag(refresh={"OBJECT", "DATA"})
    context.refresh()


def _is_original(thing: bpy.types.Object, modifier: bpy.types.Modifier) -> bool:
    """Whether the mesh before the modifier is that of the datablock."""
    data = thing.original.data
    others = any(other.name != modifier.name and (other.show_viewport or other.show_render) for other in thing.modifiers)
    return not others and data.shape_keys is None and thing.parent_type not in ("ARMATURE", "LATTICE")


def export(context: ExportContext, owner: bpy.types.Object, data: bpy.types.Mesh) -> ajar.MeshDescription | None:
    """The faces of an object that asks for adaptive subdivision. None if it does not, or has no faces."""
    found = wanted(context, owner)
    if found is None:
        return None
    base, is_smoothed = data, False
    if compat.adapts_before_modifier() and owner.original.as_pointer() not in context.base_is_evaluated:
        if _is_original(owner, found.modifier) and not data.is_editmode:
            base = context.depsgraph.id_eval_get(owner.original.data)
        else:
            is_smoothed = True
    return _make(context, base, data.name, found, is_smoothed)


def _make(context: ExportContext, base: bpy.types.Mesh, name: str, found: Wanted, is_smoothed: bool) -> ajar.MeshDescription | None:
    modifier = found.modifier
    is_smooth = modifier.subdivision_type == "CATMULL_CLARK" and not is_smoothed
    arrays = mesh.face_arrays(context, base, name, keeps_normals=not is_smooth)
    if arrays is None:
        return None
    faces, corners, flat = arrays.pop("faces"), arrays.pop("corners"), arrays.pop("flat")
    made = ajar.make_mesh(**arrays)
    more: dict = {}
    if flat is not None:
        more["flat_faces"] = flat.astype(np.uint8)
    if is_smooth:
        more |= _creases(base, modifier)
    ajar.set_subdivision(
        made, ajar.SubdivisionScheme.CatmullClark if is_smooth else ajar.SubdivisionScheme.Simple, faces, corners,
        keep_corners=modifier.boundary_smooth == "PRESERVE_CORNERS", uv_smoothing=_UV_SMOOTHING.get(modifier.uv_smooth, ajar.UvSmoothing.KeepBoundaries),
        in_pixels=found.in_pixels, edge_length=found.edge_length,
        tangents=[name for name in sorted(context.attribute_names) if name.startswith(ajar.TANGENT_OF)], **more)
    return made


def _creases(base: bpy.types.Mesh, modifier: bpy.types.SubsurfModifier) -> dict:
    found: dict = {}
    if not modifier.use_creases:
        return found
    edges, vertices = compat.edge_creases(base), compat.vertex_creases(base)
    if edges is not None and edges.any():
        pairs: np.ndarray = np.empty(2 * len(base.edges), dtype=np.uint32)
        base.edges.foreach_get("vertices", pairs)
        sharp = np.flatnonzero(edges > 0.0)
        found |= {"creased_edges": pairs.reshape(-1, 2)[sharp], "edge_sharpness": SHARPEST * edges[sharp]}
    if vertices is not None and vertices.any():
        sharp = np.flatnonzero(vertices > 0.0)
        found |= {"creased_vertices": sharp.astype(np.uint32), "vertex_sharpness": SHARPEST * vertices[sharp]}
    return found


def export_settings(context: ExportContext) -> None:
    """What the division of all meshes follows."""
    settings, dicing = plain.of(context.scene.ajar), context.description.dicing
    dicing.max_subdivisions = settings.max_subdivisions
    dicing.offscreen_scale = settings.offscreen_dicing_scale
    thing = context.scene.ajar.dicing_camera or compat.cycles_value(context.scene, "dicing_camera", None)
    if isinstance(thing, bpy.types.Object) and thing.type == "CAMERA":
        camera.describe(context, dicing.camera, thing.original.evaluated_get(context.depsgraph))
