"""`keyhole`: the cellar of `volume` in clear air and without its night lamp. All light comes through the keyhole.

The light falls on the table, a glass ball and the wall, and bounces from there to the visible surfaces. Y points from the eye to the door.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import build_volume as cellar
import scene_tools as tools
from images import mottled, pack

WATTS = 60000.0


def build() -> None:
    tools.start_scene(640, 480)
    stone = tools.diffuse("Stone", (1, 1, 1))
    tools.image_texture(stone, pack("Stone", mottled((0.42, 0.39, 0.35), (0.66, 0.62, 0.56), 256, 5, 21)))
    cellar.build_cellar(stone)
    cellar.build_door()
    cellar.build_table()
    cellar.build_barrel()
    tools.point_light("Lamp", cellar.LAMP, WATTS, (1.0, 0.80, 0.52), radius=0.025)
    tools.camera((0.40, -1.55, 1.62), (0.00, 1.2, 0.93), lens=33.0)
    cellar.add_light_hints()


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
