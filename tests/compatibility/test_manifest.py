"""Tests of the manifest of the extension with Blender's own tool, in a zip with everything except the compiled parts."""

from __future__ import annotations

import os
import re
import subprocess
import tomllib
import zipfile
from pathlib import Path

import build
import pytest

ROOT = Path(__file__).resolve().parents[2]
# Folders that may contain Blender 4.2 or newer with its tool for extensions; $AJAR_BLENDER_EXT is the path of the tool.
PLACES = ("build/compat/bpy-*/lib/python3.*/site-packages/bpy/*/scripts", "/usr/share/blender/scripts", "/usr/share/blender/*/scripts")
TOOL = "addons_core/bl_pkg/cli/blender_ext.py"


def tools() -> list[Path]:
    if "AJAR_BLENDER_EXT" in os.environ:
        return [Path(os.environ["AJAR_BLENDER_EXT"])]
    return sorted(tool for place in PLACES for folder in (Path("/").glob(place[1:]) if place.startswith("/") else ROOT.glob(place)) if (tool := folder / TOOL).is_file())


@pytest.fixture(scope="module")
def archive(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("manifest")
    (folder / "ajar").mkdir()
    build.pack(folder / "ajar.zip", folder / "ajar", build.PYTHONS_OF_EXTENSION, "")
    return folder / "ajar.zip"


def validate(tool: Path, archive: Path) -> subprocess.CompletedProcess:
    return subprocess.run(["/usr/bin/python3", tool, "validate", archive], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)


def test_blender_accepts_the_extension(archive):
    if not tools():
        pytest.skip("there is no Blender 4.2 or newer here (make compat downloads one)")
    for tool in tools():
        result = validate(tool, archive)
        assert result.returncode == 0, f"{tool}: {result.stdout}"


def test_blender_refuses_a_manifest_without_a_maintainer(archive, tmp_path):
    if not tools():
        pytest.skip("there is no Blender 4.2 or newer here (make compat downloads one)")
    broken = tmp_path / "broken.zip"
    with zipfile.ZipFile(archive) as source, zipfile.ZipFile(broken, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            target.writestr(name, re.sub(rb"(?m)^maintainer = .*$", b"", data) if name == "blender_manifest.toml" else data)
    for tool in tools():
        result = validate(tool, broken)
        assert result.returncode != 0 and "maintainer" in result.stdout, f"{tool}: {result.stdout}"


def test_maintainer_has_a_name_and_an_address(archive):
    with zipfile.ZipFile(archive) as opened:
        manifest = tomllib.loads(opened.read("blender_manifest.toml").decode())
    assert re.fullmatch(r"[^<>]+ <[^<>@\s]+@[^<>@\s]+\.[a-z]+>", manifest["maintainer"])


def test_the_zip_has_the_manual(archive):
    with zipfile.ZipFile(archive) as opened:
        assert {"manual/index.html", "manual/settings.html", "manual/style.css", "manual/panel_sampling.jpg"} <= set(opened.namelist())
