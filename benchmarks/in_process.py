"""Renders in this process with the module `ajar`, for measurements of CPU time."""

from __future__ import annotations

import os

import numpy as np

import ajar


def finish(session: ajar.Session) -> float:
    """Wait for a started render. Returns user CPU seconds of this process from its first sample, including pilots. Raises an error of the render."""
    start = os.times().user
    while not session.wait(0.01):
        if session.progress().phase == ajar.Progress.Phase.Building:
            start = os.times().user
    seconds = os.times().user - start
    if error := session.take_error():
        raise RuntimeError(error)
    return seconds


def direct_light(description: ajar.SceneDescription, method: str, direct_samples: int, samples: int, seed: int) -> tuple[np.ndarray, float]:
    """Direct light by one method on one thread: image (height, width, 3) and user CPU seconds of its samples. Empties the description."""
    settings = description.settings
    height, width = settings.height, settings.width
    bounces = settings.bounces
    bounces.total = 0
    settings.bounces, settings.integrator = bounces, "path"
    settings.direct, settings.direct_samples, settings.samples, settings.seconds = method, direct_samples, samples, 0.0
    settings.target_error, settings.seed, settings.threads, settings.passes = 0.0, seed, 1, ["Combined"]
    session = ajar.Session()
    session.start(description)
    seconds = finish(session)
    return np.asarray(session.snapshot("Combined")).reshape(height, width, 4)[..., :3].astype(np.float64), seconds
