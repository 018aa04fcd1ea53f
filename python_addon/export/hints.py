"""Light hints: every curve in one collection. The control points of a curve lead from a light to a surface that the camera sees.

Only the points are exported, in world space. The core attaches them to lights and surfaces, and reports by name those that it cannot attach.
"""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from .context import ExportContext

COLLECTION, OLD_COLLECTION = "Light Hints", "Light Paths"


def collection_of(scene: bpy.types.Scene) -> bpy.types.Collection | None:
    """The collection of the settings. Its default name is "Light Hints", in older files "Light Paths"."""
    name = scene.ajar.hint_collection
    found = bpy.data.collections.get(name)
    return bpy.data.collections.get(OLD_COLLECTION) if found is None and name == COLLECTION else found


def export(context: ExportContext) -> None:
    scene = context.depsgraph.scene
    collection = collection_of(scene)
    if collection is None:
        return
    context.report_step("light hints")
    for thing in collection.all_objects:
        if thing.type != "CURVE" or thing.name not in context.view_layer.objects:
            continue
        evaluated = thing.evaluated_get(context.depsgraph)
        settings = thing.ajar
        lamp = settings.hint_light.evaluated_get(context.depsgraph) if settings.hint_light is not None else None
        for number, spline in enumerate(thing.data.splines):
            name = thing.name if len(thing.data.splines) == 1 else f"{thing.name}, part {number + 1}"
            points = points_of(thing, spline, evaluated.matrix_world, lamp)
            context.description.add_hint(name=name, points=points, spread=settings.hint_spread, spreads=spreads_of(spline, settings.hint_spread),
                                         weight=settings.hint_weight, enabled=settings.hint_enabled and not thing.hide_render)


def points_of(curve: bpy.types.Object, spline: bpy.types.Spline, matrix_world: Matrix, lamp: bpy.types.Object | None) -> np.ndarray:
    """Control points in world space, float32[n, 3]. If the curve starts at a lamp, the first point is on this lamp."""
    bezier = spline.type == "BEZIER"
    points = spline.bezier_points if bezier else spline.points
    width = 3 if bezier else 4
    local = np.empty(len(points) * width, dtype=np.float32)
    points.foreach_get("co", local)
    local = local.reshape(-1, width)[:, :3]
    matrix = np.array(matrix_world, dtype=np.float32)
    places = np.ascontiguousarray(local @ matrix[:3, :3].T + matrix[:3, 3])
    if lamp is not None and len(places):
        places[0] = lamp.matrix_world @ curve.ajar.hint_offset
    return places


def spreads_of(spline: bpy.types.Spline, spread: float) -> list[float]:
    """The spread of each segment: that of the curve times the radius of the control point at the end of the segment."""
    points = spline.bezier_points if spline.type == "BEZIER" else spline.points
    radii = np.empty(len(points), dtype=np.float32)
    points.foreach_get("radius", radii)
    return [min(spread * float(radius), np.pi) for radius in radii[1:]]
