"""Tests of time limits, which depend on the machine. `make bench` runs them (AJAR_TIMING=1), `make test` does not."""

import signal
import sys
import time
from pathlib import Path

import pytest
from blender_process import BUILD, endless_render

sys.path.insert(0, str(BUILD / "python"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bindings"))
import ajar
from test_bindings import square

INSIDE = Path(__file__).parent / "inside"


def running_session() -> ajar.Session:
    session = ajar.Session()
    session.start(square(samples=2**24, width=512, height=512))
    while session.progress().phase != ajar.Progress.Phase.Rendering:
        time.sleep(0.01)
    time.sleep(0.1)
    return session


def test_cancel_ends_within_a_fifth_of_a_second():
    session = running_session()
    started = time.monotonic()
    session.cancel()
    assert session.wait(5.0)
    assert time.monotonic() - started < 0.2


def test_deleting_a_session_stops_its_render_within_a_second():
    session = running_session()
    started = time.monotonic()
    del session
    assert time.monotonic() - started < 1.0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupt_ends_blender_within_three_seconds(profile, tmp_path, number):
    process = endless_render(profile, tmp_path)
    asked = time.monotonic()
    process.send_signal(number)
    process.communicate(timeout=60)
    assert time.monotonic() - asked < 3.0  # this includes the time to write the image and to exit


@pytest.mark.parametrize("name", sorted(path.name for path in INSIDE.glob("time_*.py")))
def test_inside(blender, name):
    result = blender("--python", INSIDE / "run.py", "--", INSIDE / name)
    assert result.returncode == 0, result.stdout
