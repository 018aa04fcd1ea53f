"""Materials of Blender 5.2 as its Cycles renders them. make_materials.py recorded the images of Cycles 5.2.3 and the scene."""

from __future__ import annotations

from pathlib import Path

import ajar
import numpy as np
import pytest

HERE = Path(__file__).resolve().parent
LARGEST_MEAN, LARGEST_BLOCKS = 0.012, 0.03   # of a sphere's brightness; the second is the root mean square over blocks


def render(seed: int) -> np.ndarray:
    description = ajar.load_description(str(HERE / "materials_5.ajar"))
    description.settings.seed = seed
    session = ajar.Session()
    session.start(description)
    while not session.wait(0.5):
        pass
    error = session.take_error()
    assert not error, error
    assert not session.diagnostics()
    return np.asarray(session.snapshot("Combined"))[..., :3].astype(np.float64)


@pytest.fixture(scope="module")
def recorded() -> dict[str, np.ndarray]:
    return dict(np.load(HERE / "materials_5.npz"))


def test_materials_look_as_in_cycles(recorded: dict[str, np.ndarray]) -> None:
    size = int(recorded["block"])
    row, across = int(recorded["row"]), int(recorded["tile"]) // size
    pictures = np.stack([render(seed) for seed in (1, 2)])
    side = pictures.shape[1] // size
    ours = pictures.reshape(2, side, size, side, size, 3).mean(axis=(2, 4))
    wrong = []
    for i, name in enumerate(recorded["names"]):
        at = (slice(None), slice(across * (i // row), across * (i // row + 1)), slice(across * (i % row), across * (i % row + 1)))
        a, b = ours[at], recorded["blocks"][at].astype(np.float64)
        ratio = (a.mean(axis=(0, 1, 2)) / b.mean(axis=(0, 1, 2)))
        spread = np.abs(a[0].mean(axis=(0, 1)) - a[1].mean(axis=(0, 1))) / b.mean(axis=(0, 1, 2))   # of two seeds: the noise of the means
        # Products of differences with independent seeds: noise adds nothing in expectation.
        blocks = np.sqrt(max(((a[0] - b[0]) * (a[1] - b[1])).mean(), 0.0)) / b.mean()
        if np.any(np.abs(ratio - 1.0) > LARGEST_MEAN + spread) or blocks > LARGEST_BLOCKS:
            wrong.append(f"{name}: ratio of means {np.round(ratio, 4)}, seeds {np.round(spread, 4)}, blocks {blocks:.4f}")
    assert not wrong, "\n".join(wrong)
