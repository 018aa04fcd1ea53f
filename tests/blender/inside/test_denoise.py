"""Tests of the plan for denoising under a time limit. The library itself is tested in the wheels of official Blender."""

from __future__ import annotations

import numpy as np
import pytest
from ajar_render import denoise, passes
from ajar_render.ajar_module import ajar

FIXED, PER_PIXEL = 0.07, 2e-5   # seconds of the library that is imitated
Quality = ajar.DenoiseQuality


class Library:
    """In the place of ajar.denoise and of the clock: a call takes FIXED and PER_PIXEL, half as much again for a noisy image, and the first one a second more."""

    def __init__(self) -> None:
        self.now, self.calls, self.pixels = 0.0, 0, 0

    def monotonic(self) -> float:
        return self.now

    def denoise(self, color, halves, albedo, normal, quality, threads, cancellation=None, direct_halves=None, biased=(), exposure=1.0, error=False):
        pixels = color.shape[0] * color.shape[1]
        noisy = np.mean((halves[..., :3] - halves[..., 3:]) ** 2) > 0.02
        self.now += FIXED + PER_PIXEL * pixels * (1.5 if noisy else 1.0) + (1.0 if self.calls == 0 else 0.0)
        self.calls, self.pixels = self.calls + 1, self.pixels + pixels
        return color, None


@pytest.fixture
def library(monkeypatch):
    made = Library()
    monkeypatch.setattr(denoise.time, "monotonic", made.monotonic)
    monkeypatch.setattr(ajar, "denoise", made.denoise)
    monkeypatch.setattr(denoise, "_seconds_per_pixel", {})
    return made


def test_the_quality_takes_a_small_part_of_the_time_limit():
    pixels = 432 * 324
    assert [denoise.quality_within(pixels, limit, 2) for limit in (1.0, 6.0, 10.0, 60.0)] == [Quality.Fastest, Quality.Fast, Quality.Balanced, Quality.High]
    assert denoise.quality_within(1920 * 1080, 4.0, 2) == Quality.Fastest
    assert denoise.quality_within(pixels, 4.0, 64) == Quality.High


def test_the_time_of_denoising_is_that_of_a_noisy_image_and_costs_little_to_find(library):
    pixels = 432 * 324
    assert denoise.expected_seconds(pixels, Quality.Balanced, 2) == pytest.approx(1.5 * PER_PIXEL * pixels, rel=0.05)
    assert library.pixels < 0.05 * pixels
    known = library.calls
    assert denoise.expected_seconds(10 * pixels, Quality.Balanced, 2) == pytest.approx(15 * PER_PIXEL * pixels, rel=0.05)
    assert library.calls == known, "it was measured again"


def test_the_time_of_a_large_image_is_learned_and_that_of_a_small_one_is_not(library):
    def picture(side: int) -> dict[str, np.ndarray]:
        found = {name: np.full((side, side, 3), 0.5, dtype=np.float32) for name in denoise.NEEDED}
        return found | {passes.COMBINED.name: np.full((side, side, 4), 0.5, dtype=np.float32), **{name: np.full((side, side, 6), 0.5, dtype=np.float32) for name in (passes.HALVES, passes.DIRECT_HALVES)}}

    for side in (16, 200):
        work = denoise.Background(picture(side), Quality.High, 2)
        image, _ = work.result()
        assert image.shape == (side, side, 4)
        assert ((Quality.High, 2) in denoise._seconds_per_pixel) == (side == 200)
    assert denoise.expected_seconds(1000, Quality.High, 2) == pytest.approx(1000 * (PER_PIXEL + FIXED / 200**2))
