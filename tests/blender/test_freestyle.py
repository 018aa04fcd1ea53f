"""Strokes of Freestyle in `blender -b`, where no graphics card is needed, beside those of Cycles."""

import json
import sys

import numpy as np
import pytest
from blender_process import BUILD

sys.path.insert(0, str(BUILD / "python"))
import ajar

# The cube of the factory settings, which have a set of lines. Settings that a render of the strokes must not follow: a technique that costs more, few
# samples, denoising, motion, and the statistics of the command line.
STAGE = """
import bpy, sys
scene = bpy.context.scene
layer = scene.view_layers[0]
line = layer.freestyle_settings.linesets[0].linestyle
line.color, line.alpha, line.thickness = (0.1, 0.9, 0.3), 0.75, 5.0
scene.render.resolution_x, scene.render.resolution_y, scene.render.film_transparent = 96, 64, True
scene.render.engine = "AJAR"
scene.ajar.samples, scene.ajar.integrator, scene.ajar.use_denoise, scene.render.use_motion_blur = 16, "bdpt", True, True
scene.render.use_freestyle = layer.use_freestyle = "LINES" in sys.argv
if "CYCLES" in sys.argv:
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", 64, False
"""


@pytest.fixture
def rendered(blender, tmp_path):
    def run(*words: str) -> np.ndarray:
        (tmp_path / "stage.py").write_text(STAGE)
        result = blender("--python-exit-code", 1, "--python", tmp_path / "stage.py", "-o", tmp_path / "out", "-F", "OPEN_EXR", "-f", 1, "--", *words,
                         "--ajar-stats", tmp_path / "stats.json")
        assert result.returncode == 0 and "EGL" not in result.stdout, result.stdout   # no graphics card is asked for
        return ajar.read_image(str(tmp_path / "out0001.exr"))
    return run


def test_strokes_look_as_those_of_cycles(rendered, tmp_path):
    with_lines = rendered("LINES")
    statistics = json.loads((tmp_path / "stats.json").read_text())
    assert statistics["scene_name"] == "Scene" and statistics["integrator"] == "bdpt"
    without, theirs = rendered(), rendered("LINES", "CYCLES")
    is_line = theirs[..., 1] > 1.5 * theirs[..., 0]
    assert 200 < is_line.sum() < 1500
    assert abs(with_lines - without)[is_line].mean() > 0.1
    difference = (with_lines - theirs)[is_line]
    assert abs(difference.mean()) < 0.01 and abs(difference).mean() < 0.03
