"""Animations: the data that frames pass on within one render job (a still receives none), and renders that are killed and started again."""

import json
import signal
import subprocess
import time

import ajar
import numpy as np
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


# A second object that changes its shape and colour, hair on it, and an object that is only seen in the last frames.
CHANGING = "ball = bpy.data.meshes.new('Ball'); ball.from_pydata([(0, 0, .2), (.5, 0, .2), (0, .5, .2)], [], [(0, 1, 2)])\n" \
           "thing = bpy.data.objects.new('Ball', ball); scene.collection.objects.link(thing)\n" \
           "thing.shape_key_add(name='Basis'); key = thing.shape_key_add(name='Grown'); key.data[1].co.x = 1.5\n" \
           "paint = bpy.data.materials.new('Paint'); paint.diffuse_color = (1, 0, 0, 1); ball.materials.append(paint)\n" \
           "other = bpy.data.objects.new('Other', mesh); other.scale = .2, .2, .2; other.location = -.5, -.5, .3; scene.collection.objects.link(other)\n" \
           "scene.ajar.integrator, scene.frame_start, scene.frame_end = 'path', 1, 5\n" \
           "for frame in (1, 5):\n" \
           "    key.value = (frame - 1) / 4; key.keyframe_insert('value', frame=frame)\n" \
           "    paint.diffuse_color = (1, frame / 5, 0, 1); paint.keyframe_insert('diffuse_color', frame=frame)\n" \
           "    lamp.location.x = 0.1 * frame; lamp.keyframe_insert('location', frame=frame)\n" \
           "    camera.location.x = 0.02 * frame; camera.keyframe_insert('location', frame=frame)\n" \
           "    other.hide_render = frame < 5; other.keyframe_insert('hide_render', frame=frame)\n"


# Blender reports these without a change of the shape, so that objects need not be collected again: a moving object, and one that appears.
MOVING = "other = bpy.data.objects.new('Other', mesh); other.scale = .2, .2, .2; other.location = -.5, -.5, .3; scene.collection.objects.link(other)\n" \
         "paint = bpy.data.materials.new('Paint'); paint.diffuse_color = (1, 0, 0, 1); mesh.materials.append(paint)\n" \
         "mover = bpy.data.objects.new('Mover', mesh); mover.scale = .1, .1, .1; scene.collection.objects.link(mover)\n" \
         "scene.ajar.integrator, scene.frame_start, scene.frame_end = 'path', 1, 5\n" \
         "for frame in (1, 5):\n" \
         "    camera.location.x = 0.02 * frame; camera.keyframe_insert('location', frame=frame)\n"
HIDDEN = "for frame in (1, 3, 5):\n    other.hide_render = frame == 3; other.keyframe_insert('hide_render', frame=frame)\n"
SLID = "for frame in (1, 5):\n    mover.location = (0.2 * frame - .5, .5, .2); mover.keyframe_insert('location', frame=frame)\n"
PAINTED = "for frame in (1, 5):\n    paint.diffuse_color = (1, frame / 5, 0, 1); paint.keyframe_insert('diffuse_color', frame=frame)\n"


@pytest.mark.parametrize("changes", [HIDDEN, SLID, PAINTED, HIDDEN + SLID + PAINTED], ids=["hidden", "slid", "painted", "all"])
def test_persistent_data_notice_each_change(blender, tmp_path, changes):
    compare_kept(blender, tmp_path, MOVING + changes)


def compare_kept(blender, tmp_path, scene):
    pictures = {}
    for kept in (True, False):
        result = blender("--python", script(tmp_path, scene + f"scene.render.use_persistent_data = {kept}\n"), "-o", tmp_path / f"{kept}_", "-F", "OPEN_EXR_MULTILAYER", "-a",
                         "--", "--ajar-carry-learning", "off")
        assert result.returncode == 0, result.stdout
        pictures[kept] = [ajar.read_channels(str(tmp_path / f"{kept}_{frame:04}.exr")) for frame in range(1, 6)]
    for ours, theirs in zip(pictures[True], pictures[False]):
        assert sorted(ours) == sorted(theirs)
        for name in ours:
            np.testing.assert_allclose(ours[name], theirs[name], rtol=2e-3, atol=2e-3, err_msg=name)
    means = [float(frame["ViewLayer.Combined.R"].mean()) for frame in pictures[True]]
    assert len({round(mean, 6) for mean in means}) == 5


@pytest.mark.parametrize("more", ["", "scene.render.use_motion_blur = True\n", "scene.view_layers[0].use_pass_vector = True\n"], ids=["plain", "blurred", "vectors"])
def test_persistent_data_do_not_change_the_pictures(blender, tmp_path, more):
    compare_kept(blender, tmp_path, CHANGING + more)
