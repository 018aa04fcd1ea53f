"""Builds the test scenes again: python3 build_all.py [--blender PATH] [NAME ...]"""

from __future__ import annotations

import argparse
import subprocess
from pathlib import Path

SCENES = ("checker", "box", "rooms", "room", "lantern", "buddha", "plant", "outdoor", "many_lights", "volume", "keyhole", "bar", "kitchen", "attic", "room_fog",
          "room_hair", "room_motion", "room_skin", "rooms_panorama", "ocean", "fur", "cloud")


def main() -> int:
    parser = argparse.ArgumentParser(description="Rebuild the test scenes beside this script.")
    parser.add_argument("--blender", default="blender", help="the Blender to build with")
    parser.add_argument("scenes", nargs="*", metavar="NAME", help=f"some of: {' '.join(SCENES)}")
    options = parser.parse_args()
    unknown = sorted(set(options.scenes) - set(SCENES))
    if unknown:
        parser.error(f"no such scene: {', '.join(unknown)}; there are: {', '.join(SCENES)}")

    here = Path(__file__).resolve().parent
    failed = []
    for name in options.scenes or SCENES:
        command = [options.blender, "-b", "--factory-startup", "--python-exit-code", "1",
                   "--python", str(here / f"build_{name}.py"), "--", str(here / f"{name}.blend")]
        if subprocess.run(command, check=False).returncode != 0:
            failed.append(name)
    if failed:
        print(f"failed: {', '.join(failed)}")
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
