"""`room_motion`: the scene `room` with a door that swings shut while the shutter is open.

The exposure lasts one frame. When the shutter opens, the door is open as in `room`; the light hints are valid at this time.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))

import build_room as room
import scene_tools as tools

SWING = math.radians(-24.0)  # per frame
OPENS = -0.5  # the time at which the shutter opens, in frames from the rendered one
FRAME = 1  # the frame that is rendered
MOTION_STEPS = 3  # 2^3 + 1 positions of the door
ON_DOOR = (6, 10)  # light hints that touch the door, which is elsewhere at all other times


def build() -> None:
    room.build()
    room.add_light_hints(omitted=ON_DOOR)
    scene = bpy.context.scene
    scene.frame_start = scene.frame_end = FRAME
    scene.render.use_motion_blur = True
    scene.render.motion_blur_shutter = 1.0
    swing_door()
    scene.frame_set(FRAME)


def swing_door() -> None:
    """Turn the door around its hinge at a constant speed. It has its present angle when the shutter opens."""
    hinge = tools.link(bpy.data.objects.new("Hinge", None))
    hinge.location = (room.DOOR_RIGHT - 0.005, room.FAR - 0.021, 0.0)
    hinge.empty_display_size = 0.2
    bpy.context.view_layer.update()
    for name in ("Door", "Handles"):
        part = bpy.data.objects[name]
        part.parent = hinge
        part.matrix_parent_inverse = hinge.matrix_world.inverted()
        part.cycles.motion_steps = MOTION_STEPS
    bpy.context.preferences.edit.keyframe_new_interpolation_type = "LINEAR"
    for offset in (-1, 1):
        hinge.rotation_euler.z = (offset - OPENS) * SWING
        hinge.keyframe_insert("rotation_euler", index=2, frame=FRAME + offset)


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
