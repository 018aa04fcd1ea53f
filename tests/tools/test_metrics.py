"""Tests of the metrics with results computed by hand."""

import math

import metrics
import numpy as np
import pytest


def test_luminance_of_white_is_one():
    assert metrics.luminance(np.ones((1, 1, 3)))[0, 0] == pytest.approx(1.0, abs=1e-6)


def test_relmse_of_a_constant_error():
    # (1.1 - 1)^2 / (1 + 0.01)
    assert metrics.relmse(np.full((4, 4, 3), 1.1), np.ones((4, 4, 3))) == pytest.approx(0.01 / 1.01)


def test_relmse_on_black_is_bounded_by_epsilon():
    assert metrics.relmse(np.full((4, 4, 3), 0.1), np.zeros((4, 4, 3))) == pytest.approx(1.0)


def test_discarding_a_thousandth_removes_exactly_the_worst_pixels():
    reference = np.ones((50, 40, 3))
    image = reference + 0.1
    image[3, 7] = 1000.0
    image[20, 20] = 500.0
    assert metrics.relmse(image, reference) > 100.0
    assert metrics.relmse(image, reference, discard=0.001) == pytest.approx(0.01 / 1.01)


def test_noise_of_the_reference_is_subtracted_from_relmse():
    random = np.random.default_rng(1)
    truth = np.full((200, 200, 3), 2.0)
    image = truth + random.normal(0, 0.2, truth.shape)
    noisy_reference = truth + random.normal(0, 0.1, truth.shape)
    corrected = metrics.relmse(image, noisy_reference, np.full(truth.shape, 0.01))
    assert corrected == pytest.approx(0.04 / 4.01, rel=0.02)
    assert metrics.relmse(image, noisy_reference) == pytest.approx(0.05 / 4.01, rel=0.02)


@pytest.mark.parametrize("candelas, log_threshold", [
    (1e-5, -2.86),
    (0.0, -2.86),
    (1e-2, (0.405 * -2 + 1.6) ** 2.18 - 2.86),
    (0.1, -1.395),
    (1.0, 0.65**2.7 - 0.72),
    (10.0, 0.899**2.7 - 0.72),
    (100.0, 0.745),
    (1e4, 2.745),
])
def test_tvi_has_the_pieces_of_ward(candelas, log_threshold):
    assert math.log10(metrics.tvi(candelas)) == pytest.approx(log_threshold)


def test_tvi_is_continuous_to_the_precision_of_the_published_constants():
    # At the joints, the pieces with Ward's constants differ by at most 0.012 in log10.
    for joint in (-3.94, -1.44, -0.0184, 1.9):
        below, above = metrics.tvi(10.0 ** np.array([joint - 1e-9, joint + 1e-9]))
        assert math.log10(above / below) == pytest.approx(0.0, abs=0.012)


def test_perceptual_error_of_one_pixel():
    # 110 instead of 100 cd/m^2: e^2 / tvi = 100 / 10^0.745
    reference, image = np.ones((1, 1, 3)), np.full((1, 1, 3), 1.1)
    expected = 100.0 / 10**0.745
    assert metrics.perceptual_error(image, reference) == pytest.approx(expected, rel=1e-5)
    assert metrics.perceptual_error(np.tile(image, (2, 3, 1)), np.tile(reference, (2, 3, 1))) == pytest.approx(6 * expected, rel=1e-5)
    assert metrics.perceptual_efficiency(2.0, 5.0) == pytest.approx(0.1)


def test_ocv_error_has_the_unit_of_thresholds():
    reference, image = np.ones((2, 2, 3)), np.full((2, 2, 3), 1.1)
    assert metrics.ocv_error(image, reference) == pytest.approx(10.0 / 10**0.745, rel=1e-5)


def test_mps_error_excludes_black_pixels():
    reference = np.ones((1, 2, 3))
    reference[0, 1] = 0.0
    image = np.full((1, 2, 3), 1.25)
    assert metrics.mps_error(image, reference) == pytest.approx(0.25)


def test_speedup_of_parallel_curves_is_their_ratio():
    seconds = np.array([1.0, 4.0, 16.0])
    slow = metrics.ErrorCurve(seconds, 0.3 / seconds)
    fast = metrics.ErrorCurve(seconds, 0.1 / seconds)
    assert metrics.equal_error_speedup(fast, slow) == pytest.approx(3.0)
    assert metrics.equal_error_speedup(slow, fast) == pytest.approx(1 / 3)


def test_time_is_interpolated_on_log_axes():
    curve = metrics.ErrorCurve([1.0, 100.0], [1.0, 0.01])
    assert curve.time_to(0.1) == pytest.approx(10.0)
    assert math.isnan(curve.time_to(0.001))
    assert math.isnan(curve.time_to(2.0))


def test_curves_without_a_common_error_have_no_speedup():
    poor, good = metrics.ErrorCurve([1, 2], [1.0, 0.5]), metrics.ErrorCurve([1, 2], [0.1, 0.05])
    assert math.isnan(metrics.equal_error_speedup(good, poor))


def test_a_longer_render_with_a_larger_error_does_not_change_the_curve():
    curve = metrics.ErrorCurve([4.0, 1.0, 2.0], [0.25, 1.0, 1.5])
    assert curve.time_to(0.5) == pytest.approx(2.0)


def test_a_curve_rejects_zero_time():
    with pytest.raises(ValueError):
        metrics.ErrorCurve([0.0, 1.0], [1.0, 0.5])
