"""How the tests start Blender. The build under test is $AJAR_BUILD (default build/release), the program $BLENDER."""

from __future__ import annotations

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("AJAR_BUILD", ROOT / "build" / "release"))
TIMEOUT_SECONDS = 300


def command(*arguments: object) -> list[str]:
    program = os.environ.get("BLENDER", "blender")
    return [program, "-b", "--factory-startup", "--addons", "ajar_render", *map(str, arguments)]


def environment(profile: Path) -> dict[str, str]:
    return os.environ | {"BLENDER_USER_CONFIG": str(profile / "config"), "BLENDER_USER_SCRIPTS": str(profile / "scripts")}
