"""Tests of the zip in an official Blender: the bpy wheel for the Python of this machine, and the newest if its Python is installed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import compatibility  # makes benchmarks importable
import images
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "blender"))
import test_panels
import test_probes

BAKED, INSTANCED = "box", "plant"   # scenes without and with instances; the image of box is the same in every version
AJAR = ("AJAR",)
OFFICIAL = "5.0.1"   # the newest release for the Python of Debian 12
NEWEST = "5.2.3"     # needs Python 3.13


def same(ours, theirs) -> None:
    comparison = compatibility.compare(ours, theirs)
    assert compatibility.agrees(comparison), comparison


def wheel_or_skip(version: str, zip_file) -> compatibility.Blender:
    try:
        return compatibility.wheel(version, zip_file)
    except compatibility.Unavailable as reason:
        pytest.skip(f"not tried in Blender {version}: {reason}")


@pytest.fixture(scope="session")
def expected(tmp_path_factory):
    """The images of Blender 3.4.1 with the Ajar under test, which has Debian's libraries."""
    result = compatibility.run(compatibility.debian(None), compatibility.jobs([BAKED, INSTANCED], AJAR), tmp_path_factory.mktemp("reference"))
    assert "error" not in result, result["error"]
    return result


def test_legacy_add_on_renders_the_same(zips, expected, tmp_path):
    result = compatibility.run(compatibility.debian(zips[1]), compatibility.jobs([BAKED, INSTANCED], AJAR), tmp_path / "out")
    assert "error" not in result, result["error"]
    assert len(compatibility.foreign_libraries(result)["ours"]) == 4
    for scene in (BAKED, INSTANCED):
        same(compatibility.pictures_of(result, scene), compatibility.pictures_of(expected, scene))


@pytest.mark.parametrize("version", [OFFICIAL, NEWEST])
def test_official_blender_renders_the_same_as_its_cycles(zips, expected, tmp_path, version):
    result = compatibility.run(wheel_or_skip(version, zips[0]), compatibility.jobs([BAKED, INSTANCED]), tmp_path / "out")
    assert "error" not in result, result["error"]
    assert result["blender"].startswith(version)
    assert result["self_check"][-1].startswith("OK"), result["self_check"]
    found = compatibility.foreign_libraries(result)
    assert len(found["ours"]) == 4 and found["Blender's"], found
    same(compatibility.pictures_of(result, BAKED), compatibility.pictures_of(expected, BAKED))
    for scene in (BAKED, INSTANCED):
        same(compatibility.pictures_of(result, scene), compatibility.pictures_of(result, scene, "CYCLES"))


@pytest.mark.parametrize("version", compatibility.WHEELS)
def test_properties_shows_the_same_as_with_cycles(zips, tmp_path, version):
    """Uses the wheels that other tests need as well, and those that `make compat` has downloaded."""
    if version not in (OFFICIAL, NEWEST) and not (compatibility.WORK / f"bpy-{version}" / "complete").exists():
        pytest.skip(f"not tried in Blender {version}: make compat has not downloaded it")
    result = compatibility.run(wheel_or_skip(version, zips[0]), [], tmp_path / "out", panels=True)
    assert "error" not in result, result["error"]
    compared = json.loads((tmp_path / "out" / "panels.json").read_text())
    assert test_panels.problems(compared["cases"]) == []
    assert test_panels.different_passes(compared["passes"]) == []
    assert compared["nodes"]["AJAR"] == compared["nodes"]["CYCLES"]


def test_nodes_agree_with_cycles(zips, unpacked, tmp_path):
    """`make coverage` does the same for the settings."""
    python = wheel_or_skip(NEWEST, zips[0]).command[0]
    result = test_probes.probed([python, test_probes.COVERAGE / "probe.py"], unpacked, tmp_path / "probes.json")
    assert test_probes.judge.faults(result) == []


@pytest.mark.parametrize("version", [OFFICIAL, NEWEST])
@pytest.mark.parametrize("script", ["failures_inside.py", "mesh_reads_inside.py"])
def test_script_finds_no_fault(zips, tmp_path, script, version):
    out = tmp_path / "faults.json"
    result = subprocess.run([wheel_or_skip(version, zips[0]).command[0], Path(__file__).with_name(script), zips[0], out], text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, env=os.environ | {"BLENDER_USER_RESOURCES": str(tmp_path / "profile")}, timeout=300, check=False)
    assert out.is_file(), result.stdout
    assert json.loads(out.read_text()) == []


def test_self_check_works_when_the_renderer_cannot_be_loaded(zips, tmp_path):
    result = compatibility.run(wheel_or_skip(OFFICIAL, zips[0]), [], tmp_path / "out", AJAR_INSTRUCTION_SET="x86-64-v9")
    assert "FAILED: the renderer cannot be loaded:" in result["self_check"] and "x86-64-v9" in result["self_check"][-1], result


def test_denoising_by_the_library_is_not_worse_than_that_of_the_compositor(zips, tmp_path):
    """Ajar combines the image of the same library with the rendered one; Blender's node does not."""
    common = compatibility.jobs(["checker"], AJAR)[0]
    jobs = [common | {"samples": 8}, common | {"samples": 8, "denoise": "library"}, common | {"samples": 512}, common | {"samples": 8, "denoise": "compositor"}]
    result = compatibility.run(wheel_or_skip(OFFICIAL, zips[0]), jobs, tmp_path / "out")
    assert "error" not in result, result["error"]
    noisy, by_library, reference, by_compositor = (picture[..., :3] for picture in result["pictures"])
    def error(picture):
        return float((((picture - reference) ** 2) / (reference**2 + 0.01)).mean())
    assert error(by_library) < 0.5 * error(noisy)
    assert error(by_library) < 1.1 * error(by_compositor)
    assert not np.array_equal(by_library, by_compositor)


@pytest.mark.skipif("AJAR_TIMING" not in os.environ, reason="depends on the load of the machine: make timing")
def test_a_time_limit_includes_denoising_and_leaves_most_of_it_to_samples(zips, tmp_path):
    """Also the first render of a process, which does not know yet how long denoising takes."""
    limit = 4.0
    job = compatibility.jobs(["checker"], AJAR)[0] | {"samples": 1 << 20, "denoise": "library", "time_limit": limit, "percentage": 60}
    result = compatibility.run(wheel_or_skip(OFFICIAL, zips[0]), [job, job], tmp_path / "out")
    assert "error" not in result, result["error"]
    for number, found in enumerate(result["renders"]):
        text = images.read_exr_text(tmp_path / "out" / f"{number}.exr")
        seconds = {name: float(text[f"ajar.ViewLayer.{name}_seconds"]) for name in ("render", "denoise")}
        assert found["seconds"] < limit + 1.25, (number, found["seconds"], seconds)
        assert seconds["render"] > 0.68 * limit, (number, found["seconds"], seconds)
