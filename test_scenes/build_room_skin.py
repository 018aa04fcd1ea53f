"""`room_skin`: the scene `room` with a bust on the table, whose skin scatters light below its surface."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import build_buddha as buddha
import build_room as room
import scene_tools as tools
from implicit_mesh import Array, axis, common, join, limb
from mathutils import Matrix

BASE = 0.70  # the height in the figure of `buddha` at which the bust begins
SIZE = 0.56  # relative to this figure
PLACE = (-0.85, 0.66)  # on the table, in the direct light
TURN = np.radians(65.0)


def bust(x: Array, y: Array, z: Array) -> Array:
    """Head, neck and shoulders."""
    d = join(buddha.torso(x, y, z), limb(x, y, z, (0, 0.06, 0.90), (0, 0.02, 1.12), 0.112, 0.100), 0.07)
    d = join(d, buddha.head(x, y, z), 0.035)
    return common(common(d, np.abs(x) - 0.33, 0.05), BASE - z, 0.03)


def build() -> None:
    room.build()
    room.add_light_hints()
    # The radius of red is 3 cm, a quarter of the radius of the head, so that the effect is clearly visible.
    flesh = tools.subsurface("Flesh", (0.72, 0.40, 0.28), (1.0, 0.40, 0.20), 0.03)
    gloss = tools.glossy("Gloss", (1, 1, 1), 0.35)
    made = buddha.add_part("Bust", bust, axis(-0.45, 0.45, 0.014), axis(-0.40, 0.40, 0.014), axis(0.6, 1.6, 0.014),
                           tools.mixed("Skin", flesh, gloss, 0.04))
    made.matrix_world = (Matrix.Translation((*PLACE, room.TABLE_HEIGHT)) @ Matrix.Rotation(TURN, 4, "Z")
                         @ Matrix.Scale(SIZE, 4) @ Matrix.Translation((0, 0, -BASE)))


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
