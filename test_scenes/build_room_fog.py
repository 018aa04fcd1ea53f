"""`room_fog`: the scene `room` in thin fog, in which the light through the gap of the door is a visible shaft."""

from __future__ import annotations

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))

import build_room as room
import scene_tools as tools
from furniture import put
from shapes import block

# The lamp is higher and smaller than in `room`, so that the shaft has a sharp upper edge in view.
LAMP, LAMP_SIZE = (3.35, 3.90, 2.42), 0.12
WALLS = (0.20, 0.18, 0.16)  # darker than in `room`, so that the shaft is brighter than what is behind it
DENSITY = 0.08  # scattering events per metre
ANISOTROPY = 0.6
BOUNCES = 2  # in the fog


def build() -> None:
    room.build(LAMP)
    room.add_light_hints(LAMP)  # before the fog, since the rays that find the light hints would stop at its faces
    lamp = bpy.data.lights["Lamp"]
    lamp.size = lamp.size_y = LAMP_SIZE
    for name in ("Wall", "Ceiling"):
        tools.set_input(tools.shader_of(bpy.data.materials[name]), "Color", WALLS)
    bpy.context.scene.cycles.volume_bounces = BOUNCES
    half = room.WALL / 2  # The faces of the fog lie inside the walls.
    low = (room.LEFT - half, room.NEAR - half, -half)
    high = (room.BACK_RIGHT + half, room.BACK_FAR + half, room.CEILING + half)
    fog = put("Fog", block(low, high), tools.fog("Fog", (0.95, 0.95, 0.95), DENSITY, ANISOTROPY))
    fog.display_type = "WIRE"


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
