"""ajar-render on one of several machines: ranges of samples, checkpoints that are continued, damaged, of another version, on a full disk, after a signal."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(os.environ.get("AJAR_BUILD", Path(__file__).resolve().parents[2] / "build" / "release")) / "python"))
import ajar

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="Windows ends a process without telling it, and has no limit of the size of files")

BUILD = Path(os.environ.get("AJAR_BUILD", Path(__file__).resolve().parents[2] / "build" / "release"))
SIZE = 24


def command(*arguments: object) -> list[str]:
    return [str(BUILD / "ajar-render"), *map(str, arguments)]


def run(*arguments: object, **more) -> subprocess.CompletedProcess:
    return subprocess.run(command(*arguments), capture_output=True, text=True, check=False, **more)


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Path:
    description = ajar.load_description(str(Path(__file__).resolve().parents[1] / "render" / "materials_5.ajar"))
    description.settings.width = description.settings.height = SIZE
    description.settings.region = [0, 0, SIZE, SIZE]
    description.settings.passes = ["Combined", "Depth"]
    path = tmp_path_factory.mktemp("scene") / "scene.ajar"
    ajar.save_description(description, str(path))
    return path


def render(scene: Path, name: Path, first: int, samples: int, *options: object, **more) -> subprocess.CompletedProcess:
    return run(scene, name.with_suffix(".exr"), "--continue", name, "--first-sample", first, "--samples", samples, "--seed", 3, "--threads", 1, *options, **more)


def image(path: Path) -> np.ndarray:
    return np.asarray(ajar.read_image(str(path)))


def test_a_complete_render_that_is_continued_gets_no_more_samples(scene, tmp_path):
    assert render(scene, tmp_path / "done", 2, 8).returncode == 0
    before = image(tmp_path / "done.exr")
    (tmp_path / "done.exr").unlink()
    assert render(scene, tmp_path / "done", 2, 8, "--stats", tmp_path / "stats.json").returncode == 0
    assert json.loads((tmp_path / "stats.json").read_text())["samples_per_pixel"]["max"] == 8
    assert np.array_equal(image(tmp_path / "done.exr"), before)


@pytest.mark.parametrize("integrator", ["path", "bdpt"])
def test_ranges_merge_to_one_render_bit_for_bit(scene, tmp_path, integrator):
    options = ("--integrator", integrator, "--vertex-merging", "off")
    assert render(scene, tmp_path / "all", 0, 12, *options).returncode == 0
    for first, samples in ((0, 5), (5, 4), (9, 3)):
        assert render(scene, tmp_path / f"part{first}", first, samples, *options).returncode == 0
    result = run("--merge", tmp_path / "merged.exr", tmp_path / "merged", tmp_path / "part9", tmp_path / "part0", tmp_path / "part5")
    assert result.returncode == 0 and result.stdout == "12 samples per pixel of 3 renders\n", result.stderr
    assert np.array_equal(image(tmp_path / "merged.exr"), image(tmp_path / "all.exr"))
    assert not np.array_equal(image(tmp_path / "part0.exr"), image(tmp_path / "all.exr"))


@POSIX
def test_a_render_that_was_killed_goes_on_as_if_nothing_had_happened(scene, tmp_path):
    assert render(scene, tmp_path / "whole", 2, 900).returncode == 0
    for number in (signal.SIGTERM, signal.SIGKILL):
        part = tmp_path / f"part{number}"
        process = subprocess.Popen(command(scene, part.with_suffix(".exr"), "--continue", part, "--first-sample", 2, "--samples", 900, "--seed", 3, "--threads", 1,
                                           "--checkpoint-interval", 0.05), stderr=subprocess.DEVNULL)
        while not part.exists():
            time.sleep(0.01)
            assert process.poll() is None
        process.send_signal(number)
        assert process.wait() == (128 + number if number == signal.SIGTERM else -number)
        assert not part.with_suffix(".exr").exists()
        done = render(scene, part, 2, 900, "--stats", tmp_path / "stats.json")
        assert done.returncode == 0, done.stderr
        assert json.loads((tmp_path / "stats.json").read_text())["resumed"]["samples"] > 0
        assert np.array_equal(image(part.with_suffix(".exr")), image(tmp_path / "whole.exr"))


def test_a_damaged_checkpoint_is_said_and_moved_away(scene, tmp_path):
    part = tmp_path / "part"
    assert render(scene, part, 0, 2).returncode == 0
    content = bytearray(part.read_bytes())
    content[len(content) // 2] ^= 1
    part.write_bytes(content)
    assert run(scene, tmp_path / "x.exr", "--resume", part).returncode == 1
    merged = run("--merge", tmp_path / "m.exr", tmp_path / "m", part)
    assert merged.returncode == 1 and "checksum is wrong" in merged.stderr
    again = render(scene, part, 0, 2)
    assert again.returncode == 0 and "checksum is wrong" in again.stderr and (tmp_path / "part.damaged").exists()


def test_merging_leaves_out_what_does_not_fit(scene, tmp_path):
    for first in (0, 2):
        assert render(scene, tmp_path / f"{first}", first, 2).returncode == 0
    assert render(scene, tmp_path / "bounces", 4, 2, "--bounces-total", 0).returncode == 0
    (tmp_path / "version").write_bytes(b"AJARCHP1" + (tmp_path / "0").read_bytes()[8:])
    (tmp_path / "short").write_bytes((tmp_path / "2").read_bytes()[:-1])
    result = run("--merge", "--keep-going", tmp_path / "m.exr", tmp_path / "m", *(tmp_path / name for name in ("0", "bounces", "version", "short", "2", "0", "none")))
    assert result.returncode == 0 and result.stdout == "4 samples per pixel of 2 renders\n5 left out\n"
    for words in ("settings differ", "another version", "is damaged", "both contain sample 0", "cannot be read"):
        assert words in result.stderr, words
    assert run("--merge", "--keep-going", tmp_path / "m.exr", tmp_path / "m2", tmp_path / "short").returncode == 1


def test_a_checkpoint_of_another_scene_or_of_other_settings_stops_the_render(scene, tmp_path):
    assert render(scene, tmp_path / "part", 0, 2).returncode == 0
    result = render(scene, tmp_path / "part", 0, 4, "--filter", "box")
    assert result.returncode == 1 and "settings differ" in result.stderr
    assert render(scene, tmp_path / "part", 0, 4).returncode == 0, "and the checkpoint is still there"


@POSIX
def test_a_full_disk_leaves_the_checkpoint_that_was_there(scene, tmp_path):
    part = tmp_path / "part"
    assert render(scene, part, 0, 2).returncode == 0
    before = part.read_bytes()

    def small_disk():
        import resource

        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))
    result = render(scene, part, 0, 4, preexec_fn=small_disk)
    assert result.returncode == 1 and "could not be written" in result.stderr
    assert part.read_bytes() == before and sorted(path.name for path in tmp_path.iterdir()) == ["part", "part.exr"]
    assert render(scene, part, 0, 4).returncode == 0


def test_what_cannot_be_divided_by_ranges_is_divided_by_seeds(scene, tmp_path):
    for first in (0, 4):
        assert render(scene, tmp_path / f"{first}", first, 4, "--integrator", "metropolis").returncode == 0
    result = run("--merge", tmp_path / "m.exr", tmp_path / "m", tmp_path / "0", tmp_path / "4")
    assert result.returncode == 0 and result.stdout.endswith("of 2 renders\n")
    assert not np.array_equal(image(tmp_path / "0.exr"), image(tmp_path / "4.exr"))
