"""Checkerboard between a large and a small light (thesis, figures 1.4, 5.4 and 6.2).

Half of the squares are diffuse, the others glossy: nearly a mirror at the back, and rougher with each row to the front. The best sampling of direct
light differs between squares: light sampling for diffuse squares and the small light, BSDF sampling where the large light is reflected, and neither
of them alone where the glossy squares are rough.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import scene_tools as tools
from mathutils import Vector

ROWS, COLUMNS, SQUARE = 10, 10, 0.6
ROUGHEST, SMOOTHEST = 0.55, 0.06


def roughness_of(row: int) -> float:
    """Roughness from front (row 0) to back. The ratios are constant, so that the steps look uniform."""
    return ROUGHEST * (SMOOTHEST / ROUGHEST) ** (row / (ROWS - 1))


def add_floor() -> None:
    half = COLUMNS * SQUARE / 2.0
    verts = [(i * SQUARE - half, j * SQUARE - half, 0.0) for j in range(ROWS + 1) for i in range(COLUMNS + 1)]
    across = COLUMNS + 1
    faces = [(j * across + i, j * across + i + 1, (j + 1) * across + i + 1, (j + 1) * across + i)
             for j in range(ROWS) for i in range(COLUMNS)]
    floor = tools.add_mesh("Checkerboard", verts, faces, tools.diffuse("Diffuse squares", (0.72, 0.70, 0.66)))
    for row in range(ROWS):
        floor.data.materials.append(tools.glossy(f"Glossy squares, row {row}", (0.62, 0.66, 0.70), roughness_of(row)))
    floor.data.polygons.foreach_set("material_index", [1 + j if (i + j) % 2 else 0
                                                       for j in range(ROWS) for i in range(COLUMNS)])
    rim, under = 0.08, -0.14
    edge = tools.principled("Board", (0.05, 0.045, 0.04), roughness=0.4)
    tools.add_box("Board", (-half - rim, -half - rim, under), (half + rim, half + rim, -0.004), edge, bevel=0.02)


def add_panel(name: str, position: tuple[float, float, float], size: tuple[float, float], watts: float,
              colour: tools.Colour) -> None:
    """A light in a dark casing on a stand, directed at the centre of the board."""
    light = tools.area_light(name, position, (0.4 * position[0], -0.5, 0.2), size, watts, colour, seen=True)
    dark = tools.principled(f"{name} casing", (0.03, 0.03, 0.032), roughness=0.4)
    u, v = size[0] / 2.0 + 0.05, size[1] / 2.0 + 0.05
    casing = tools.add_box(f"{name} casing", (-u, -v, 0.01), (u, v, 0.09), dark, bevel=0.015)
    casing.matrix_world = light.matrix_world
    top = light.matrix_world @ Vector((0.0, 0.0, 0.09))
    tools.add_cylinder(f"{name} stand", (top.x, top.y + v, -0.14), top, 0.03, dark)


def main() -> None:
    tools.start_scene(500, 500)
    add_floor()
    room = tools.diffuse("Room", (0.50, 0.52, 0.56))
    tools.add_plane("Ground", (0, 0, -0.14), (40, 40), room)
    tools.add_quad("Wall", (-20, 5.2, -1), (20, 5.2, -1), (20, 5.2, 16), (-20, 5.2, 16), room)
    add_panel("Large light", (-1.05, 3.6, 1.25), (2.7, 1.7), 180.0, (1.0, 0.47, 0.09))
    add_panel("Small light", (2.05, 3.5, 0.90), (0.5, 0.5), 95.0, (0.10, 0.36, 1.0))
    tools.camera((0, -6.9, 3.5), (0, -0.02, 0.16), lens=45.5)
    tools.save(tools.output_path(__file__))


main()
