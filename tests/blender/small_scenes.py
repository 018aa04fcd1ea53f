"""Small scenes as scripts. Blender runs them before it renders."""

from __future__ import annotations

from pathlib import Path

# A square with sides of 2 m under a lamp, seen from above; 32x24 pixels.
LIT_SQUARE = """
import bpy
bpy.ops.wm.read_homefile(use_empty=True)
scene = bpy.context.scene
scene.render.resolution_x, scene.render.resolution_y = 32, 24
mesh = bpy.data.meshes.new("Square")
mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
mesh.uv_layers.new(name="UVMap")
square = bpy.data.objects.new("Square", mesh)
lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
lamp.data.energy, lamp.location = 100, (0, 0, 2)
camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
camera.location.z = 4
for thing in (square, lamp, camera):
    scene.collection.objects.link(thing)
scene.camera = camera
scene.render.engine = "AJAR"
scene.ajar.samples = 4
"""


def script(folder: Path, text: str, name: str = "scene.py") -> Path:
    """Writes a file with LIT_SQUARE followed by `text`."""
    path = folder / name
    path.write_text(LIT_SQUARE + text, encoding="utf-8")
    return path
