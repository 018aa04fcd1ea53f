"""`rooms_panorama`: the scene `rooms` seen by an equirectangular camera in the middle of the furnished room."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))

import build_rooms as rooms
import scene_tools as tools

EYE = (0.20, 0.40, 1.60)
HIDDEN = (2, 7)  # the light hints whose end cannot be seen from there


def build() -> None:
    rooms.build()
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 800, 400
    camera = scene.camera
    camera.location = EYE
    camera.rotation_euler = (math.pi / 2, 0.0, 0.0)
    camera.data.type = "PANO"
    # Blender 5 has this setting in the camera, earlier ones in the add-on of Cycles.
    lens = camera.data if hasattr(camera.data, "panorama_type") else camera.data.cycles
    lens.panorama_type = "EQUIRECTANGULAR"
    rooms.add_light_hints(omitted=HIDDEN)


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
