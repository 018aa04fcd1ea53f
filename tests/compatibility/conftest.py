"""The extension for one level of x86-64 and the Pythons of official Blender 4.2 to 5.0 and 5.2."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "tools" / "extension" / "build.py"
sys.path.insert(0, str(BUILD.parent))
import build  # noqa: E402


@pytest.fixture(scope="session")
def zips(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The extension and the legacy add-on, either from the folder $AJAR_ZIPS or built for the tests."""
    if "AJAR_ZIPS" in os.environ:
        folder = Path(os.environ["AJAR_ZIPS"])
        return folder / f"ajar-{build.version()}-linux-x64.zip", folder / f"ajar-{build.version()}-legacy-linux-x64.zip"
    out = tmp_path_factory.mktemp("zips")
    result = subprocess.run(["/usr/bin/python3", BUILD, "--python", "3.11", "3.13", "--level", "x86-64-v3", "--out", out], text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    if result.returncode == build.EXIT_UNREACHABLE:
        pytest.skip(f"no extension without its libraries: {result.stdout}")
    assert result.returncode == 0, result.stdout
    extension, legacy = out / f"ajar-{build.version()}-linux-x64.zip", out / f"ajar-{build.version()}-legacy-linux-x64.zip"
    return extension, legacy


@pytest.fixture(scope="session")
def unpacked(zips: tuple[Path, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("extension")
    with zipfile.ZipFile(zips[0]) as archive:
        archive.extractall(folder)
    return folder
