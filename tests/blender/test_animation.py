"""Tests of the data that frames of an animation pass on within one render job. A still receives no such data."""

import json

import pytest
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
