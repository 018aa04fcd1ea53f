"""Tests of the command line: errors are reported before rendering, with the valid names and a non-zero exit code."""

import json

import pytest
from small_scenes import script

WRONG = [
    (["--ajar-integrator", "bogus"], ["bogus", "path", "pmc_pt", "erpt", "mps", "metropolis", "photon_map"]),
    (["--ajar-direct", "bogus"], ["bogus", "mis", "ocv_progressive"]),
    (["--ajar-guiding", "bogus"], ["bogus", "off", "on", "auto"]),
    (["--ajar-vertex-merging", "bogus"], ["bogus", "off", "on"]),
    (["--ajar-image", "bogus"], ["bogus", "uniform", "pmc_ip"]),
    (["--ajar-carry-learning", "bogus"], ["bogus", "on", "off"]),
    (["--ajar-bogus", "1"], ["--ajar-bogus", "--ajar-integrator", "--ajar-dump-scene"]),
    (["--ajar-samples", "many"], ["--ajar-samples", "many"]),
    (["--ajar-samples", "0"], ["--ajar-samples", "0"]),
    (["--ajar-samples"], ["--ajar-samples", "value"]),
    (["--ajar-time", "nan"], ["--ajar-time", "nan"]),
    (["--ajar-time", "-1"], ["--ajar-time", "-1"]),
    (["--ajar-error", "x"], ["--ajar-error", "x"]),
    (["--ajar-seed", "-1"], ["--ajar-seed", "-1"]),
    (["--ajar-threads", "1.5"], ["--ajar-threads", "1.5"]),
    (["--ajar-filter", "bogus"], ["bogus", "box", "blackman_harris"]),
    (["--ajar-refractive-caustics", "maybe"], ["maybe", "on", "off"]),
    (["--ajar-bounces-total", "-1"], ["--ajar-bounces-total", "-1"]),
    (["--ajar-memory-limit", "-1"], ["--ajar-memory-limit", "-1"]),
    (["--ajar-stats", "/no/such/folder/x.json"], ["--ajar-stats", "/no/such/folder"]),
    (["--ajar-dump-scene", "/"], ["--ajar-dump-scene"]),
    (["--ajar-checkpoint", "/no/such/folder/x"], ["--ajar-checkpoint", "/no/such/folder"]),
    (["--ajar-resume", "/no/such/file"], ["--ajar-resume", "/no/such/file"]),
]


@pytest.mark.parametrize("arguments, words", WRONG, ids=[" ".join(arguments) for arguments, _ in WRONG])
def test_wrong_options_end_blender_before_rendering(blender, tmp_path, arguments, words):
    result = blender("--python", script(tmp_path, ""), "-o", tmp_path / "out", "-f", 1, "--", *arguments)
    assert result.returncode != 0
    assert all(word in result.stdout for word in words), result.stdout
    assert not list(tmp_path.glob("out*"))


def test_memory_limit_stops_the_render_and_names_the_largest_part(blender, tmp_path):
    large = script(tmp_path, "scene.render.resolution_x = scene.render.resolution_y = 1000")
    for limit, code in ((2, 1), (800, 0)):
        result = blender("--python", large, "-o", tmp_path / f"out{limit}_", "-f", 1, "--", "--ajar-samples", 1, "--ajar-memory-limit", limit)
        assert result.returncode == code, result.stdout
        assert ("memory limit of 2 MiB: the picture" in result.stdout) == bool(code), result.stdout
    assert not list(tmp_path.glob("out2_*")) and list(tmp_path.glob("out800_*"))


def test_arguments_of_other_scripts_are_ignored(blender):
    assert blender("--", "--my-option", "3", "word").returncode == 0


def test_options_override_settings_of_all_types(blender, tmp_path):
    dump, read = tmp_path / "scene.ajar", tmp_path / "read.py"
    result = blender("--python", script(tmp_path, "scene.ajar.bounces_total = 7; scene.ajar.noise_target = 0.5"), "-o", tmp_path / "out", "-f", 1, "--",
                     "--ajar-samples", 1, "--ajar-time", 100, "--ajar-error=0.25", "--ajar-filter", "box", "--ajar-exposure", 2, "--ajar-bounces-glossy", 3,
                     "--ajar-refractive-caustics", "off", "--ajar-image-error", "perceptual", "--ajar-dump-scene", dump)
    assert result.returncode == 0, result.stdout
    read.write_text("import ajar_render\nfrom ajar_render.ajar_module import ajar\n"
                    f"s = ajar.load_description({str(dump)!r}).settings\n"
                    "print('READ', s.seconds, s.target_error, s.filter == ajar.FilterKind.Box, s.exposure, s.bounces.glossy, s.bounces.total,"
                    " s.refractive_caustics, s.reflective_caustics, s.image_error)\n")
    result = blender("--python", read)
    assert "READ 100.0 0.25 True 2.0 3 7 False True perceptual" in result.stdout, result.stdout


def test_statistics_have_all_fields_of_the_contract(blender, tmp_path):
    stats, dump = tmp_path / "stats.json", tmp_path / "scene.ajar"
    result = blender("--python", script(tmp_path, ""), "-o", tmp_path / "out", "-F", "PNG", "-f", 1, "--",
                     "--ajar-samples", 3, "--ajar-seed=7", "--ajar-threads", 1, "--ajar-stats", stats, "--ajar-dump-scene", dump)
    assert result.returncode == 0, result.stdout
    assert (tmp_path / "out0001.png").exists() and dump.exists()
    found = json.loads(stats.read_text())
    for name in ("version", "integrator", "threads", "resolution", "samples_per_pixel", "export_seconds", "build_seconds",
                 "render_seconds", "peak_memory_bytes", "refused_samples", "plan", "blender_version", "file"):
        assert name in found, name
    assert found["samples_per_pixel"]["mean"] == 3
    assert found["seeds"] == [7] and found["threads"] == 1 and found["integrator"] == "path"
    assert b"ajar." in (tmp_path / "out0001.png").read_bytes()
