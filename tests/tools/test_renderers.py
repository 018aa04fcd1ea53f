"""Render times are read from the log and the metadata of Cycles."""

import json

import renderers

RECORD = {"path": "/x/16_1.exr", "samples": 16, "seed": 1, "threads": 2, "frame": 1, "renderer": "Cycles 3.4.1",
          "seconds": 0.32, "sync_seconds": 0.05}
LOG = """
Time (in seconds):
                                       Wall              Average
          Path Tracing             0.322501             0.020156
        Display Update             0.000001             0.000001
"""


def test_time_is_read_from_the_log_if_it_exists():
    renders = renderers.parse_cycles_log(LOG + "CYCLES " + json.dumps(RECORD) + "\nCYCLES " + json.dumps(RECORD | {"seed": 2}))
    assert [(r.seed, r.seconds, r.sync_seconds) for r in renders] == [(1, 0.322501, 0.05), (2, 0.32, 0.05)]


def test_error_of_a_renderer_has_its_name_and_the_end_of_its_log():
    try:
        renderers.run(["sh", "-c", "echo no such scene; exit 3"], "Cycles on lost.blend")
    except renderers.RenderFailed as failure:
        assert "Cycles on lost.blend ended with code 3" in str(failure) and "no such scene" in str(failure)
    else:
        raise AssertionError("no failure was raised")
