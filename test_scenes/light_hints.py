"""Light hints along real paths of light: a ray finds each point on a surface, and the camera sees the last point."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

from scene_tools import Point, light_hint

AWAY = 1e-4  # distance in metres between the origin of a ray and the surface that it leaves


def aimed_light_hint(name: str, light: Point, targets: Sequence[Point], tolerance: float = 0.15) -> bpy.types.Object:
    """A light hint from a light to the surfaces that are found in the direction of each target in turn.

    A hit farther than `tolerance` from the target, or an end that is out of view, stops the script.
    """
    bpy.context.view_layer.update()
    points = [Vector(light)]
    for target in targets:
        points.append(_first_hit(name, points[-1], Vector(target), tolerance))
    scene = bpy.context.scene
    seen = world_to_camera_view(scene, scene.camera, points[-1])
    panorama = scene.camera.data.type == "PANO"  # All directions are in view.
    if not panorama and not (0.0 < seen.x < 1.0 and 0.0 < seen.y < 1.0 and seen.z > 0.0):
        raise ValueError(f"{name}: its end is at {seen.x:.2f}, {seen.y:.2f} of the picture's width and height")
    _first_hit(name, scene.camera.matrix_world.translation, points[-1], 0.01)
    return light_hint(name, points)


def _first_hit(name: str, start: Vector, target: Vector, tolerance: float) -> Vector:
    along = (target - start).normalized()
    graph = bpy.context.evaluated_depsgraph_get()
    hit, place, _, _, thing, _ = bpy.context.scene.ray_cast(graph, start + AWAY * along, along)
    if not hit or (place - target).length > tolerance:
        found = f"{thing.name} at {tuple(round(c, 3) for c in place)}" if hit else "nothing"
        raise ValueError(f"{name}: aimed at {tuple(target)} from {tuple(start)}, found {found}")
    return place
