"""Tests of the pictures of the Progress panel: the positions of points, curves and labels."""

from __future__ import annotations

import numpy as np
import pytest
from ajar_render import graph

WIDTH, HEIGHT = 300, 200


def rows_of(picture: np.ndarray, column: int, color: tuple[float, float, float]) -> np.ndarray:
    return np.flatnonzero(np.abs(picture[:, column, :3] - np.array(color)).max(axis=1) < 0.02)


def frame(seconds, noise, target=0.0, end=0.0):
    return graph.frame_of(np.array(seconds, float), np.array(noise, float), target, end, WIDTH, HEIGHT, 1)


@pytest.mark.parametrize("exponent", [-0.5, -1.0])
def test_the_curve_passes_through_its_points(exponent):
    seconds = np.geomspace(0.5, 200, 40)
    noise = 0.3 * seconds**exponent
    picture = graph.draw(seconds, noise, 0.0, 0.0, WIDTH, HEIGHT)
    placed = frame(seconds, noise)
    for second, value in zip(seconds[1:-1], noise[1:-1]):
        column, row = round(placed.x.place(second)), placed.y.place(value)
        rows = rows_of(picture, column, graph.CURVE)
        assert len(rows) > 0 and abs(rows.mean() - row) < 1.0, (second, rows, row)


def test_a_power_law_is_a_straight_line():
    seconds = np.geomspace(1, 100, 5)
    picture = graph.draw(seconds, 0.1 / np.sqrt(seconds), 0.0, 0.0, WIDTH, HEIGHT)
    columns = np.arange(60, 280)
    middle = np.array([rows_of(picture, column, graph.CURVE).mean() for column in columns])
    fit = np.polyval(np.polyfit(columns, middle, 1), columns)
    assert np.abs(middle - fit).max() < 1.0 and np.ptp(middle) > 100


def test_the_axes_have_the_expected_ends():
    axis = graph.Axis(0.01, 1.0, 30.0, 230.0)
    assert axis.place(0.01) == pytest.approx(30) and axis.place(1.0) == pytest.approx(230) and axis.place(0.1) == pytest.approx(130)
    placed = frame([1, 10], [0.2, 0.1], target=0.01, end=100.0)
    assert placed.y.low < 0.01 and placed.y.high > 0.2 and placed.x.low == 1 and placed.x.high == 100


def test_the_target_is_a_dashed_line_at_its_noise():
    seconds, noise = [1, 10, 100], [0.2, 0.1, 0.05]
    picture = graph.draw(seconds, noise, 0.02, 0.0, WIDTH, HEIGHT)
    row = round(frame(seconds, noise, 0.02).y.place(0.02))
    hits = np.abs(picture[:, :, :3] - np.array(graph.TARGET)).max(axis=2) < 0.02
    assert set(np.flatnonzero(hits.any(axis=1))) == {row}
    assert 0.3 < hits[row, 50:290].mean() < 0.7
    without = graph.draw(seconds, noise, 0.0, 0.0, WIDTH, HEIGHT)
    assert not (np.abs(without[:, :, :3] - np.array(graph.TARGET)).max(axis=2) < 0.02).any()


def test_the_predicted_curve_ends_at_the_predicted_time():
    seconds, noise = [1, 10], [0.2, 0.1]
    picture = graph.draw(seconds, noise, 0.01, 1000.0, WIDTH, HEIGHT)
    placed = frame(seconds, noise, 0.01, 1000.0)
    assert placed.x.high == 1000
    expected = np.abs(picture[:, :, :3] - np.array(graph.EXPECTED)).max(axis=2) < 0.02
    columns = np.flatnonzero(expected.any(axis=0))
    assert abs(columns[0] - placed.x.place(10)) < 4 and abs(columns[-1] - placed.x.place(1000)) < 4
    assert abs(np.flatnonzero(expected[:, columns[-1] - 2]).mean() - placed.y.place(0.01)) < 3   # the noise is divided by ten when the time is multiplied by a hundred
    assert graph.expected_noise(np.array([10.0]), np.array([0.1]), 1e6, 0.01) == 0.01


@pytest.mark.parametrize("seconds, noise", [([], []), ([0.0], [0.1]), ([1.0], [0.0]), ([float("nan")], [1.0])])
def test_the_picture_without_data_is_empty(seconds, noise):
    picture = graph.draw(seconds, noise, 0.01, 5.0, WIDTH, HEIGHT)
    assert picture.shape == (HEIGHT, WIDTH, 4) and (picture[..., :3] == np.float32(graph.BACKGROUND)).all() and (picture[..., 3] == 1).all()


@pytest.mark.parametrize("width, height, unit", [(110, 110, 1), (480, 480, 2), (300, 60, 3)])
def test_any_size_and_any_values_can_be_drawn(width, height, unit):
    for seconds, noise in (([1], [0.5]), ([1, 1, 1], [0.5, 0.2, 0.5]), (np.geomspace(1e-3, 1e6, 5000), np.geomspace(1e4, 1e-6, 5000)), ([5, 3], [1, 2])):
        picture = graph.draw(seconds, noise, 1e-3, 0.0, width, height, unit)
        assert picture.shape == (height, width, 4) and np.isfinite(picture).all() and picture.min() >= 0 and picture.max() <= 1
        assert (np.abs(picture[..., :3] - np.array(graph.CURVE)).max(axis=2) < 0.05).any()


def test_ticks_are_round_numbers_inside_the_axes():
    assert graph.ticks_of_noise(0.004, 0.2)[0] == [pytest.approx(0.01), pytest.approx(0.1)]
    assert graph.ticks_of_seconds(0.5, 100)[0] == [1, 10, 60]
    assert [graph.name_of_seconds(s) for s in (0.1, 10, 60, 1800, 36000)] == ["0.1 s", "10 s", "1 min", "30 min", "10 h"]
    assert [graph.name_of_noise(noise) for noise in (1e-6, 0.0005, 0.05, 1, 50, 1e5)] == ["0.0001%", "0.05%", "5%", "100%", "5000%", "10000000%"]
    assert graph.text_width("0123456789.% smihn", 2) == 2 * graph.text_width("0123456789.% smihn", 1) > 0


def test_labels_are_beside_the_axes():
    picture = graph.draw([1, 100], [0.2, 0.02], 0.0, 0.0, WIDTH, HEIGHT)
    text = np.abs(picture[..., :3] - np.array(graph.TEXT)).max(axis=2) < 0.02
    placed = frame([1, 100], [0.2, 0.02])
    assert text[:, :int(placed.x.start)].any() and text[:int(placed.y.start), :].any()
    assert not text[int(placed.y.start) + 4:, int(placed.x.start):].any()


def test_density_runs_from_dark_to_bright():
    counts = np.array([[1, 2, 4, 8], [8, 8, 8, 64]], dtype=np.float32)
    picture = graph.density(counts)
    brightness = picture[..., :3].sum(axis=2)
    order = np.argsort(counts, axis=None, kind="stable")
    assert (np.diff(brightness.ravel()[order]) >= 0).all() and brightness[1, 3] > 2 * brightness[0, 0]
    np.testing.assert_allclose(picture[0, 0, :3], graph.DENSITY_COLORS[0], atol=1e-6)
    np.testing.assert_allclose(picture[1, 3, :3], graph.DENSITY_COLORS[-1], atol=1e-6)
    assert len(np.unique(graph.density(np.full((3, 5), 7.0))[..., 0])) == 1


def test_a_large_map_is_reduced_by_averaging():
    counts = np.arange(10 * 7, dtype=np.float32).reshape(10, 7)
    assert graph.shrunk(counts, 10) is counts
    small = graph.shrunk(counts, 5)
    assert small.shape == (5, 4)
    assert small[0, 0] == counts[:2, :2].mean() and small[4, 3] == counts[8:, 6:].mean()
    assert max(graph.shrunk(np.ones((2160, 3840), np.float32), 256).shape) <= 256
