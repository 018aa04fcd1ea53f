"""Animations: the data that frames pass on within one render job (a still receives none), and renders that are killed and started again."""

import json
import signal
import subprocess
import time

import ajar
import pytest
from blender_process import command, environment
from small_scenes import script

# A wall beside the square causes indirect light, which the path guide can learn.
GUIDED = "wall = bpy.data.objects.new('Wall', mesh)\n" \
         "wall.rotation_euler.y, wall.location = 1.57, (1, 0, 1)\n" \
         "scene.collection.objects.link(wall)\n" \
         "scene.ajar.integrator, scene.ajar.guiding, scene.ajar.samples = 'path', 'on', 4\n" \
         "scene.frame_start, scene.frame_end = 1, 3\n" \
         "for frame in (1, 3):\n    camera.location.x = 0.05 * frame\n    camera.keyframe_insert('location', frame=frame)\n"


@pytest.mark.parametrize("job, options, frames_before", [
    (["-a"], [], 2),
    (["-a"], ["--ajar-carry-learning", "off"], 0),
    (["-f", "1", "-f", "2"], [], 0),
], ids=["animation", "switched off", "stills"])
def test_frames_of_an_animation_use_the_learning_of_earlier_frames(blender, tmp_path, job, options, frames_before):
    stats = tmp_path / "stats.json"
    result = blender("--python", script(tmp_path, GUIDED), "-o", tmp_path / "out", "-F", "PNG", *job, "--", "--ajar-stats", stats, *options)
    assert result.returncode == 0, result.stdout
    last = json.loads(stats.read_text())
    assert last["frames_before"] == frames_before
    used = {step["step"]: step["used"] for step in last["plan"] if step["step"].startswith("learned in the frame before")}
    assert used == ({"learned in the frame before: path guide": True} if frames_before else {})


FRAMES = 12
TINY = "scene.frame_start, scene.frame_end, scene.render.use_overwrite = 1, 12, False\n" \
       "scene.ajar.integrator, scene.ajar.samples = 'path', 256\n" \
       "lamp.keyframe_insert('location', frame=1)\nlamp.location.x = 1\nlamp.keyframe_insert('location', frame=12)\n"


@pytest.mark.parametrize("form, suffix", [("PNG", ".png"), ("OPEN_EXR_MULTILAYER", ".exr")])
def test_an_animation_that_is_killed_loses_no_frame(blender, profile, tmp_path, form, suffix):
    arguments = ["--python", script(tmp_path, TINY), "-o", tmp_path / "out", "-F", form, "-a"]
    files = [tmp_path / f"out{frame:04}{suffix}" for frame in range(1, FRAMES + 1)]
    process = subprocess.Popen(command(*arguments), env=environment(profile), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while not files[4].exists() and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    written = [path for path in files if path.exists()]
    assert 5 <= len(written) < FRAMES
    whole = {path: path.stat().st_mtime_ns for path in written[:3]}
    data = written[3].read_bytes()
    written[3].write_bytes(data[:len(data) // 2])   # as if it had been killed while it wrote this frame
    result = blender(*arguments)
    assert result.returncode == 0, result.stdout
    assert f"{written[3]} is not complete" in result.stdout
    assert [path.name for path in files if not path.exists()] == []
    for path in files:
        if suffix == ".png":
            assert ajar.read_image(str(path)).shape[:2] == (24, 32)
        else:
            assert ajar.read_channels(str(path))["ViewLayer.Combined.R"].shape == (24, 32)
    assert {path: path.stat().st_mtime_ns for path in whole} == whole   # complete frames are kept


def test_files_say_how_they_were_rendered(blender, tmp_path):
    result = blender("--python", script(tmp_path, "scene.ajar.seed = 5\nscene.ajar.integrator = 'path'"), "-o", tmp_path / "out", "-F", "OPEN_EXR", "-f", "1")
    assert result.returncode == 0, result.stdout
    header = (tmp_path / "out0001.exr").read_bytes()[:20000]
    for name in ("version", "integrator", "samples", "seed", "render_seconds", "estimated_error", "blender_version"):
        assert f"ajar.ViewLayer.{name}".encode() in header, name
    assert b"ajar.engine" in header
