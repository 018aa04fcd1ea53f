"""The agreement tests accept equal images, reject different images, and have their nominal level."""

import agreement
import numpy as np
import pytest


def noisy(random, truth, sigma, count):
    return [truth + random.normal(0, sigma, truth.shape) for _ in range(count)]


def test_block_means_of_a_ramp_with_partial_blocks():
    image = np.arange(20, dtype=float)[:, None, None] * np.ones((20, 18, 3))
    means = agreement.block_means(image, 16)
    assert means.shape == (2, 2, 3)
    assert means[0, 0, 0] == pytest.approx(7.5)
    assert means[1, 1, 2] == pytest.approx(17.5)


def test_both_estimates_of_the_standard_error_are_correct():
    random = np.random.default_rng(2)
    images = noisy(random, np.ones((64, 64, 3)), 0.5, 64)
    true = 0.5 / np.sqrt(64 * 256)
    assert agreement.blocks_of_replicates(images).standard_errors.mean() == pytest.approx(true, rel=0.05)
    assert agreement.blocks_of_pixels(*agreement.mean_and_variance(images), 64).standard_errors.mean() == pytest.approx(true, rel=0.05)


def test_agreement_allows_one_percent_and_three_standard_errors():
    reference = agreement.Blocks(np.ones((1, 1, 3)), np.full((1, 1, 3), 0.003), 8, 16)

    def ours(mean):
        return agreement.Blocks(np.full((1, 1, 3), mean), np.full((1, 1, 3), 0.004), 8, 16)

    assert agreement.disagreements(ours(1.0249), reference) == []
    found = agreement.disagreements(ours(1.0251), reference)
    assert len(found) == 3
    assert "ratio 1.0251" in str(found[0])


def test_differences_of_invisible_light_are_accepted():
    reference = agreement.Blocks(np.array([[[1.0], [0.0]]]), np.zeros((1, 2, 1)), 8, 16)

    def ours(dark):
        return agreement.Blocks(np.array([[[1.0], [dark]]]), np.zeros((1, 2, 1)), 8, 16)

    assert agreement.disagreements(ours(4e-6), reference) == []
    assert [d.column for d in agreement.disagreements(ours(6e-6), reference)] == [1]


def test_a_block_that_is_not_a_number_is_rejected():
    exact = agreement.Blocks(np.ones((1, 2, 3)), np.zeros((1, 2, 3)), 8, 16)
    broken = agreement.Blocks(np.array([[[1.0] * 3, [1.0, np.nan, 1.0]]]), np.zeros((1, 2, 3)), 8, 16)
    assert [(d.column, d.channel) for d in agreement.disagreements(broken, exact)] == [(1, 1)]


def test_a_two_percent_error_in_one_block_is_found():
    random = np.random.default_rng(3)
    truth = np.ones((64, 64, 3))
    wrong = truth.copy()
    wrong[16:32, 48:64] *= 1.02
    ours = agreement.blocks_of_replicates(noisy(random, wrong, 0.1, 16))
    theirs = agreement.blocks_of_replicates(noisy(random, truth, 0.1, 16))
    found = agreement.disagreements(ours, theirs)
    assert {(d.row, d.column) for d in found} == {(1, 3)}


@pytest.mark.parametrize("t, degrees, p", [
    (0.0, 5, 1.0),
    (1.0, 1, 0.5),                      # Cauchy: 1 - 2/pi atan(1)
    (12.706204736, 1, 0.05),            # tables of Student's t
    (2.228138852, 10, 0.05),
    (3.169272673, 10, 0.01),
    (1.959963985, 1e7, 0.05),           # normal
    (3.0, 2, 0.095466),                 # 1 - t / sqrt(2 + t^2)
])
def test_p_values_agree_with_the_tables(t, degrees, p):
    assert agreement.student_p_value(t, degrees) == pytest.approx(p, rel=1e-5)


def test_welch_has_its_nominal_level_for_equal_means():
    """200 families of 48 tests at level 0.05: Binomial(200, 0.05) has its 99.99 % quantile at 24."""
    random = np.random.default_rng(4)
    false_alarms = 0
    for _ in range(200):
        a = agreement.blocks_of_replicates(noisy(random, np.ones((16, 16, 3)), 0.3, 8), 4)
        b = agreement.blocks_of_replicates(noisy(random, np.ones((16, 16, 3)), 0.6, 16), 4)
        false_alarms += not agreement.welch_test(a, b, 0.05).agrees
    assert 1 <= false_alarms <= 24


def test_welch_finds_a_shift_of_six_standard_errors():
    random = np.random.default_rng(5)
    truth = np.ones((64, 64, 3))
    shifted = truth.copy()
    shifted[:16, :16] += 6 * 0.3 * np.sqrt(2 / 16) / 16
    result = agreement.welch_test(agreement.blocks_of_replicates(noisy(random, shifted, 0.3, 16)),
                                  agreement.blocks_of_replicates(noisy(random, truth, 0.3, 16)))
    assert {tuple(at[:2]) for at in np.argwhere(result.significant)} == {(0, 0)}


def test_welch_without_variance_accepts_only_equal_images():
    exact = agreement.Blocks(np.ones((1, 1, 3)), np.zeros((1, 1, 3)), 2, 16)
    other = agreement.Blocks(np.full((1, 1, 3), 1.0001), np.zeros((1, 1, 3)), 2, 16)
    assert agreement.welch_test(exact, exact).agrees
    assert not agreement.welch_test(exact, other).agrees


def test_sidak_level_of_one_test_is_its_level():
    one = agreement.Blocks(np.ones((1, 1, 1)), np.ones((1, 1, 1)), 8, 16)
    assert agreement.welch_test(one, one, 0.01).level == pytest.approx(0.01)
