"""Renders in this process, by the module `ajar`, for measurements of CPU time."""

from __future__ import annotations

import os

import ajar


def finish(session: ajar.Session) -> float:
    """Wait for a render that was started; user CPU seconds of this process from its first sample on, pilots included. An error of the render is raised."""
    start = os.times().user
    while not session.wait(0.01):
        if session.progress().phase == ajar.Progress.Phase.Building:
            start = os.times().user
    seconds = os.times().user - start
    if error := session.take_error():
        raise RuntimeError(error)
    return seconds
