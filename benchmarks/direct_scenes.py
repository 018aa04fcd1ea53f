"""Scenes of direct light for direct_against_cycles.py: `checker`, and soft shadows of one large unoccluded area light.

    blender -b --factory-startup --python direct_scenes.py -- DIRECTORY
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(PROJECT / "test_scenes"))

import bpy  # noqa: E402
import scene_tools as tools  # noqa: E402


def soft_shadows() -> None:
    """Diffuse objects on diffuse ground below a lamp of two by two metres that the camera does not see. Most of the image is penumbra."""
    tools.start_scene(800, 500)
    tools.add_plane("Ground", (0, 0, 0), (40, 40), tools.diffuse("Ground", (0.6, 0.6, 0.58)))
    stone, clay = tools.diffuse("Stone", (0.7, 0.68, 0.62)), tools.diffuse("Clay", (0.65, 0.35, 0.22))
    for i in range(9):
        angle = 2.0 * math.pi * i / 9.0
        foot = (1.6 * math.cos(angle), 1.6 * math.sin(angle), 0.0)
        tools.add_cylinder(f"Column {i}", foot, (foot[0], foot[1], 0.9), 0.09, stone)
    tools.add_sphere("Ball", (0.0, 0.0, 0.62), 0.45, clay)
    tools.add_box("Step", (-0.6, -0.6, 0.0), (0.6, 0.6, 0.17), stone)
    tools.area_light("Lamp", (1.5, 1.0, 3.2), (0, 0, 0.3), 2.0, 300.0, seen=True)
    tools.camera((0.0, -4.6, 2.6), (0.0, 0.0, 0.3), lens=42)


def main() -> None:
    parser = argparse.ArgumentParser(prog="direct_scenes.py", description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="of the .blend files")
    folder = parser.parse_args(sys.argv[sys.argv.index("--") + 1:]).folder
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("soft_shadows", "checker"):
        if name == "checker":
            bpy.ops.wm.open_mainfile(filepath=str(PROJECT / "test_scenes" / "checker.blend"))
        else:
            soft_shadows()
        bpy.context.scene.cycles.max_bounces = 0
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"{name}.blend"), compress=True)


main()
