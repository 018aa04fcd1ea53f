"""Runs in the Python of a bpy wheel: what compat.py reads of meshes in bulk is what Blender's older properties say.

    python mesh_reads_inside.py ZIP OUT
"""

from __future__ import annotations

import importlib
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import inside


def meshes() -> Iterator[tuple[str, bpy.types.Mesh]]:
    bpy.ops.mesh.primitive_monkey_add()
    monkey = bpy.context.object
    monkey.modifiers.new("Subdivision", "SUBSURF")
    monkey.data.uv_layers.new(name="Second")
    bpy.ops.mesh.primitive_cylinder_add(vertices=7)   # with faces of seven corners
    cylinder = bpy.context.object
    bpy.ops.object.text_add()
    text = bpy.context.object
    bpy.ops.mesh.primitive_plane_add()
    bare = bpy.context.object
    for layer in list(bare.data.uv_layers):
        bare.data.uv_layers.remove(layer)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for thing in (monkey, cylinder, bare):
        yield f"evaluated {thing.name}", thing.evaluated_get(depsgraph).data
        yield f"original {thing.name}", thing.data
    yield "text", text.evaluated_get(depsgraph).to_mesh()
    yield "empty", bpy.data.meshes.new("Empty")


def main(zip_file: str, out: Path) -> None:
    compat = importlib.import_module(f"{inside.install(zip_file)}.compat")
    faults = []
    for name, mesh in meshes():
        mesh.calc_loop_triangles()
        pairs = {"positions": (compat.vertex_positions(mesh), compat.numbers(mesh.vertices, "co", 3, np.float32)),
                 "corners": (compat.corner_vertices(mesh), compat.numbers(mesh.loops, "vertex_index", 1, np.uint32)),
                 "polygons": (compat.triangle_polygons(mesh), compat.numbers(mesh.loop_triangles, "polygon_index", 1, np.uint32))}
        pairs |= {f"UV map {layer.name}": (compat.uv_coordinates(layer), compat.numbers(layer.data, "uv", 2, np.float32)) for layer in mesh.uv_layers}
        faults += [f"{name}: {what}" for what, (ours, theirs) in pairs.items() if ours.dtype != theirs.dtype or not np.array_equal(ours, theirs)]
    out.write_text(json.dumps(faults))


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
    sys.stdout.flush()
    os._exit(0)
