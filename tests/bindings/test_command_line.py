"""The program `ajar-render`: each setting is an option, a mistake ends it with code 2 before anything is rendered."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(os.environ.get("AJAR_BUILD", Path(__file__).resolve().parents[2] / "build" / "release")) / "python"))
import ajar

BUILD = Path(os.environ.get("AJAR_BUILD", Path(__file__).resolve().parents[2] / "build" / "release"))
USAGE_ERROR = 2
OPTION_NAMES = {"target-error": "error"}


def run(*arguments: object) -> subprocess.CompletedProcess:
    return subprocess.run([str(BUILD / "ajar-render"), *map(str, arguments)], capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Path:
    """A camera below a grey sky."""
    description = ajar.SceneDescription()
    description.camera.present = True
    description.settings.width, description.settings.height, description.settings.samples = 8, 6, 4
    path = tmp_path_factory.mktemp("scene") / "sky.ajar"
    ajar.save_description(description, str(path))
    return path


def statistics(scene: Path, folder: Path, *options: object) -> dict:
    result = run(scene, folder / "out.exr", "--stats", folder / "stats.json", *options)
    assert result.returncode == 0, result.stderr
    return json.loads((folder / "stats.json").read_text())


def test_every_setting_is_an_option():
    text = run("--help").stdout
    options = {line.split()[0] for line in text.splitlines() if line.strip().startswith("--")}
    for info in ajar.setting_list():
        name = info.name.replace(".", "-").replace("_", "-")
        assert "--" + OPTION_NAMES.get(name, name) in options, info.name


def test_options_override_the_file(scene, tmp_path):
    found = statistics(scene, tmp_path, "--samples", 3, "--seed=7", "--threads", 1, "--width", 5, "--direct", "bsdf", "--guiding", "on", "--vertex-merging", "on",
                       "--image", "pmc_ip", "--integrator", "bdpt")
    assert found["samples_per_pixel"]["mean"] == 3 and found["seeds"] == [7] and found["threads"] == 1 and found["resolution"] == [5, 6]
    assert [found[name] for name in ("direct", "guiding", "vertex_merging", "image", "integrator")] == ["bsdf", "on", "on", "pmc_ip", "bdpt"]


def test_lists_and_switches_are_read(scene, tmp_path):
    statistics(scene, tmp_path, "--region", 1, 2, 4, 5, "--passes", "Combined,Depth", "--transparent-film", "on", "--filter", "box", "--mist", 1, 2, 3)
    pixels = np.asarray(ajar.read_image(str(tmp_path / "out.exr")))
    assert pixels.shape[:2] == (3, 3) and not pixels[..., 3].any()


def test_a_later_time_limit_replaces_the_samples_and_later_samples_come_back(scene, tmp_path):
    assert statistics(scene, tmp_path, "--seconds", 0.3, "--samples", 2)["samples_per_pixel"]["mean"] == 2
    assert statistics(scene, tmp_path, "--samples", 2, "--seconds", 0.3)["samples_per_pixel"]["mean"] > 2
    assert statistics(scene, tmp_path, "--samples", 2, "--samples", 3)["samples_per_pixel"]["mean"] == 3


@pytest.mark.parametrize("options, words", [
    (["--samples", "many"], ["--samples", "many"]),
    (["--samples", "-1"], ["--samples", "-1"]),
    (["--samples"], ["--samples"]),
    (["--gather-rays", "70000"], ["--gather-rays", "65536"]),
    (["--direct", "best"], ["--direct", "best", "pmc_hi"]),
    (["--reflective-caustics", "perhaps"], ["--reflective-caustics", "perhaps"]),
    (["--bogus", "1"], ["--bogus"]),
    (["third_file"], ["nothing else"]),
])
def test_mistakes_end_the_program_before_it_renders(scene, tmp_path, options, words):
    result = run(scene, tmp_path / "out.exr", *options)
    assert result.returncode == USAGE_ERROR
    assert all(word in result.stderr for word in words), result.stderr
    assert not (tmp_path / "out.exr").exists()


def test_checkpoints_are_continued_and_merged(scene, tmp_path):
    for seed in (1, 2):
        statistics(scene, tmp_path, "--seed", seed, "--checkpoint", tmp_path / f"{seed}.checkpoint")
    assert statistics(scene, tmp_path, "--resume", tmp_path / "1.checkpoint", "--samples", 6)["samples_per_pixel"]["mean"] == 6
    result = run("--merge", tmp_path / "merged.exr", tmp_path / "all.checkpoint", tmp_path / "1.checkpoint", tmp_path / "2.checkpoint")
    assert result.returncode == 0 and result.stdout == "8 samples per pixel of 2 renders\n", result.stderr
    assert (tmp_path / "merged.exr").exists() and (tmp_path / "all.checkpoint").exists()
    assert run("--merge", tmp_path / "merged.exr").returncode == USAGE_ERROR
