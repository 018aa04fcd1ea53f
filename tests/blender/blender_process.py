"""Starts Blender for the tests. $AJAR_BUILD is the build under test (default: build/release), $BLENDER the program."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

from small_scenes import script

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("AJAR_BUILD", ROOT / "build" / "release"))
TIMEOUT_SECONDS = 300


def command(*arguments: object) -> list[str]:
    program = os.environ.get("BLENDER", "blender")
    return [program, "-b", "--factory-startup", "--addons", "ajar_render", *map(str, arguments)]


def environment(profile: Path) -> dict[str, str]:
    return os.environ | {"BLENDER_USER_CONFIG": str(profile / "config"), "BLENDER_USER_SCRIPTS": str(profile / "scripts")}


def endless_render(profile: Path, folder: Path) -> subprocess.Popen:
    """Starts an animation with an endless first frame, and returns after the first samples. Its image, statistics and checkpoint are written to `folder`."""
    arguments = command("--python", script(folder, "scene.ajar.samples = 2**20"), "-o", folder / "out", "-F", "PNG", "-a",
                        "--", "--ajar-stats", folder / "stats.json", "--ajar-checkpoint", folder / "checkpoint")
    process = subprocess.Popen(arguments, env=environment(profile), text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    for line in process.stdout:
        if "samples" in line:
            break
    return process
