"""Blender in a clean profile with the built add-on installed."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from blender_process import BUILD, ROOT, TIMEOUT_SECONDS, command, environment

collect_ignore = ["inside", "window"]  # these run inside Blender; test_inside.py and test_window.py start them
if "AJAR_TIMING" not in os.environ:
    collect_ignore.append("test_timing.py")  # depends on the machine's speed


@pytest.fixture(scope="session")
def profile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("profile")
    subprocess.run([ROOT / "tools" / "install_addon.sh", BUILD, folder], check=True)
    return folder


@pytest.fixture(scope="session")
def blender(profile: Path) -> Callable[..., subprocess.CompletedProcess]:
    """A function that runs `blender -b --factory-startup --addons ajar_render` with its arguments; stdout includes the standard error."""

    def run(*arguments: object, **more) -> subprocess.CompletedProcess:
        return subprocess.run(command(*arguments), env=environment(profile), text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=TIMEOUT_SECONDS, check=False, **more)
    return run


@pytest.fixture(scope="session")
def display() -> Iterator[str]:
    """The name of a virtual display in memory."""
    read, write = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1000x700x24", "-nolisten", "tcp"],
                              pass_fds=[write], stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as number:
        yield f":{number.readline().strip()}"
    server.terminate()
    server.wait()
