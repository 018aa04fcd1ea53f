"""The folder of a release: the index is the one of Blender's own tool, and a Blender finds the update in it; checksums, licences, notes."""

from __future__ import annotations

import json
import subprocess
import zipfile
from pathlib import Path

import build
import pytest
import release
from test_manifest import tools

LIBRARIES = ("libajar_embree4.so", "libajar_tbb.so", "libajar_OpenImageIO.so", "libajar_OpenImageIO_Util.so", "libajar_OpenImageDenoise.so")
LICENSES = ("Embree.txt", "OpenImageIO.txt", "OpenImageDenoise.txt", "OpenSubdiv.txt")


@pytest.fixture(scope="module")
def zips(tmp_path_factory) -> Path:
    """Everything but the compiled parts, which are empty files."""
    folder = tmp_path_factory.mktemp("zips")
    package = folder / "ajar"
    for below, names in (("lib", LIBRARIES), ("licenses", LICENSES)):
        (package / below).mkdir(parents=True)
        for name in names:
            (package / below / name).write_text(name)
    build.pack(folder / f"ajar-{build.version()}-linux-x64.zip", package, build.PYTHONS_OF_EXTENSION, "")
    build.pack(folder / f"ajar-{build.version()}-legacy-linux-x64.zip", package, build.PYTHONS_OF_LEGACY, "ajar_render/")
    return folder


@pytest.fixture(scope="module")
def made(zips) -> Path:
    release.make(zips, zips / "release")
    return zips / "release"


def test_the_index_is_that_of_blenders_own_tool(made, tmp_path):
    if not tools():
        pytest.skip("there is no Blender 4.2 or newer here (make compat downloads one)")
    ours = json.loads((made / "index.json").read_text())
    for number, tool in enumerate(tools()):
        folder = tmp_path / str(number)
        folder.mkdir()
        archive = next(made.glob("*.zip"))
        (folder / archive.name).symlink_to(archive)
        subprocess.run(["/usr/bin/python3", tool, "server-generate", "--repo-dir", folder], check=True, capture_output=True)
        assert ours == json.loads((folder / "index.json").read_text()), tool


def test_blender_finds_the_extension_in_the_folder(made, tmp_path):
    if not tools():
        pytest.skip("there is no Blender 4.2 or newer here (make compat downloads one)")
    for what in ("sync", "list"):
        result = subprocess.run(["/usr/bin/python3", tools()[-1], what, "--local-dir", tmp_path, "--remote-url", f"file://{made}/index.json"], capture_output=True, text=True, check=False)
        assert result.returncode == 0, result.stdout + result.stderr
    assert "ajar_render" in result.stdout, result.stdout


def test_checksums_are_those_of_the_files(made):
    assert subprocess.run(["sha256sum", "--quiet", "-c", "SHA256SUMS"], cwd=made, check=False).returncode == 0
    listed = {line.split("  ")[1] for line in (made / "SHA256SUMS").read_text().splitlines()}
    assert listed == {str(path.relative_to(made)) for path in made.rglob("*") if path.is_file()} - {"SHA256SUMS"}


def test_every_library_has_a_component_with_a_licence(made):
    bill = json.loads((made / "sbom.json").read_text())
    assert (bill["bomFormat"], bill["specVersion"]) == ("CycloneDX", "1.5")
    files = {entry["name"].removeprefix("file:ajar/lib/") for component in bill["components"] for entry in component.get("properties", [])}
    assert files == set(LIBRARIES)
    assert all(component["licenses"] and component["version"] for component in bill["components"])
    assert {"OpenSubdiv", "pybind11", "GLM"} <= {component["name"] for component in bill["components"]}


@pytest.mark.parametrize("name, words", [("ajar/lib/libstranger.so", "libstranger.so"), (None, "not its licence")])
def test_a_library_without_a_component_and_a_licence_without_a_text_are_errors(zips, tmp_path, name, words):
    original = zips / f"ajar-{build.version()}-linux-x64.zip"
    with zipfile.ZipFile(original) as source, zipfile.ZipFile(tmp_path / original.name, "w") as target:
        for entry in source.namelist():
            if name or "OpenImageDenoise.txt" not in entry:
                target.writestr(entry, source.read(entry))
        if name:
            target.writestr(name, "x")
    with pytest.raises(release.ReleaseError, match=words):
        release.make(tmp_path, tmp_path / "release")


def test_notes_list_the_changes_by_area(made):
    text = (made / "RELEASE_NOTES.md").read_text()
    assert text.startswith(f"# Ajar {build.version()}\n") and "\n## " in text and "\n* " in text
