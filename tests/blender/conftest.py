"""Blender in a clean profile with the built add-on installed, as a user would have it.

The build under test is $AJAR_BUILD (default build/release), the program $BLENDER (default blender).
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("AJAR_BUILD", ROOT / "build" / "release"))
TIMEOUT_SECONDS = 300


@pytest.fixture(scope="session")
def profile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("profile")
    subprocess.run([ROOT / "tools" / "install_addon.sh", BUILD, folder], check=True)
    return folder


Blender = Callable[..., subprocess.CompletedProcess]


@pytest.fixture(scope="session")
def blender(profile: Path) -> Blender:
    """Call with arguments after `blender -b --factory-startup --addons ajar_render`; standard error is part of stdout."""

    def run(*arguments: object, **more) -> subprocess.CompletedProcess:
        return subprocess.run(command(*arguments), env=environment(profile), text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=TIMEOUT_SECONDS, **more)
    return run


def command(*arguments: object) -> list[str]:
    program = os.environ.get("BLENDER", "blender")
    return [program, "-b", "--factory-startup", "--addons", "ajar_render", *map(str, arguments)]


def environment(profile: Path) -> dict[str, str]:
    return os.environ | {"BLENDER_USER_CONFIG": str(profile / "config"), "BLENDER_USER_SCRIPTS": str(profile / "scripts")}
