"""Makes large scenes in Blender's process, for geometry.py: many triangles, all different, and many instances of one object."""

from __future__ import annotations

import math

import bpy
import numpy as np

TRIANGLES_OF_A_MESH = 1_000_000
TRIANGLES_OF_AN_INSTANCE = 80


def make(name: str) -> None:
    """Replaces the open file by a scene such as "triangles:20000000", "one_mesh:20000000" (all in one mesh) or "instances:1000000"."""
    kind, _, count = name.partition(":")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 640, 360
    material = bpy.data.materials.new("Grey")
    material.use_nodes = True
    if kind == "instances":
        _instances(int(count), material)
    else:
        _triangles(int(count), int(count) if kind == "one_mesh" else TRIANGLES_OF_A_MESH, material)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -14.0, 9.0), (math.radians(58.0), 0.0, 0.0)
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    lamp.data.energy, lamp.rotation_euler = 3.0, (0.6, 0.3, 0.0)
    for thing in (camera, lamp):
        scene.collection.objects.link(thing)
    scene.camera = camera


def _triangles(count: int, each: int, material: bpy.types.Material) -> None:
    meshes = max(1, round(count / each))
    for number in range(meshes):
        mesh = _hills(f"Hills {number}", each, number)
        mesh.materials.append(material)
        thing = bpy.data.objects.new(mesh.name, mesh)
        thing.location = (0.0, 0.0, 0.2 * number - 0.1 * meshes)
        bpy.context.scene.collection.objects.link(thing)


def _hills(name: str, triangles: int, seed: int) -> bpy.types.Mesh:
    """A smooth height field of quadrangles with a UV map of two islands."""
    side = math.isqrt(triangles // 2)
    at = np.linspace(-5.0, 5.0, side + 1, dtype=np.float32)
    x, y = np.meshgrid(at, at)
    points = np.stack([x, y, 0.1 * np.sin(3.0 * x + seed) * np.cos(2.0 * y - seed) + 0.002 * np.sin(90.0 * x) * np.sin(80.0 * y)], axis=-1, dtype=np.float32)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add((side + 1) ** 2)
    mesh.vertices.foreach_set("co", points.ravel())
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)[None, :]).ravel()
    corners = np.stack([first, first + 1, first + side + 2, first + side + 1], axis=-1).astype(np.int32)
    quads = len(corners)
    mesh.loops.add(4 * quads)
    mesh.loops.foreach_set("vertex_index", corners.ravel())
    mesh.polygons.add(quads)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 4 * quads, 4, dtype=np.int32))
    if bpy.app.version < (4, 1):
        mesh.polygons.foreach_set("loop_total", np.full(quads, 4, dtype=np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(quads, dtype=bool))
    uvs = (points.reshape(-1, 3)[corners.ravel(), :2] + 5.0) / 10.0
    uvs[:2 * quads, 0] += 2.0   # the first half is an island of its own
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", uvs.astype(np.float32).ravel())
    mesh.update(calc_edges=True)
    return mesh


def _instances(count: int, material: bpy.types.Material) -> None:
    """One small object at each vertex of a mesh."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=4.0 / math.sqrt(count))
    ball = bpy.context.object
    assert len(ball.data.polygons) == TRIANGLES_OF_AN_INSTANCE
    ball.data.materials.append(material)
    random = np.random.default_rng(1)
    points = random.random((count, 3), dtype=np.float32) * np.float32(10.0) - np.float32(5.0)
    mesh = bpy.data.meshes.new("Places")
    mesh.vertices.add(count)
    mesh.vertices.foreach_set("co", points.ravel())
    places = bpy.data.objects.new("Places", mesh)
    places.instance_type = "VERTS"
    places.show_instancer_for_render = places.show_instancer_for_viewport = False
    bpy.context.scene.collection.objects.link(places)
    ball.parent = places
