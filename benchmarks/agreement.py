"""Tests whether two renders show the same image: block means with standard errors, and two tests on them.

A render is given as replicates: N images of the same scene with N independent seeds. Their mean is the estimate, and their scatter gives its variance
for all algorithms. For chains and populations, no other estimate of the variance is valid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Blocks:
    """Means over square blocks of pixels: arrays of rows x columns x channels. Blocks at the
    right and bottom edge may be smaller. `standard_errors` are those of `means`; zero for an exact image."""

    means: np.ndarray
    standard_errors: np.ndarray
    replicates: int
    size: int

    def __post_init__(self):
        if self.means.shape != self.standard_errors.shape:
            raise ValueError("means and standard errors differ in shape")


def reduce_blocks(image: np.ndarray, size: int, function=np.add) -> np.ndarray:
    """Sums (or another ufunc's reduction) over blocks of size x size pixels."""
    rows = function.reduceat(image, np.arange(0, image.shape[0], size), axis=0)
    return function.reduceat(rows, np.arange(0, image.shape[1], size), axis=1)


def block_means(image: np.ndarray, size: int = 16) -> np.ndarray:
    """Mean of each block, in double precision."""
    image = np.asarray(image, dtype=np.float64)
    return reduce_blocks(image, size) / reduce_blocks(np.ones(image.shape[:2] + (1,)), size)


def blocks_of_replicates(images, size: int = 16) -> Blocks:
    """Block means over replicates. The standard error comes from the scatter of the block means between replicates, so that it includes the
    correlation between pixels. At least two replicates are needed, and eight or more for standard errors with a relative error below 27 %."""
    means = np.stack([block_means(image, size) for image in images])
    count = len(means)
    if count < 2:
        raise ValueError("a standard error needs two replicates or more")
    return Blocks(means.mean(axis=0), means.std(axis=0, ddof=1) / np.sqrt(count), count, size)


def blocks_of_pixels(mean: np.ndarray, variance: np.ndarray, replicates: int, size: int = 16) -> Blocks:
    """Block means from a mean image and the variance of the mean of each pixel. Pixels are assumed to be independent, as in path tracers with
    decorrelated pixels. 256 pixels compensate for few replicates."""
    pixels = reduce_blocks(np.ones(mean.shape[:2] + (1,)), size)
    errors = np.sqrt(reduce_blocks(np.asarray(variance, dtype=np.float64), size)) / pixels
    return Blocks(block_means(mean, size), errors, replicates, size)


def mean_and_variance(images) -> tuple[np.ndarray, np.ndarray]:
    """Mean image of replicates, and the variance of that mean."""
    stack = np.stack([np.asarray(image, dtype=np.float64)[..., :3] for image in images])
    if len(stack) < 2:
        raise ValueError("a variance needs two replicates or more")
    return stack.mean(axis=0), stack.var(axis=0, ddof=1) / len(stack)


@dataclass(frozen=True)
class Disagreement:
    """A block and channel whose difference exceeds the allowance. Row and column count blocks from the top left."""

    row: int
    column: int
    channel: int
    value: float
    reference: float
    allowance: float

    def __str__(self) -> str:
        ratio = self.value / self.reference if self.reference else float("inf")
        excess = abs(self.value - self.reference) / self.allowance if self.allowance else float("inf")
        return (f"block row {self.row} column {self.column} {'RGBA'[self.channel]}: {self.value:.6g} against {self.reference:.6g}, "
                f"ratio {ratio:.4f}, {excess:.1f} times the allowance")


def disagreements(ours: Blocks, theirs: Blocks, relative: float = 0.01, standard_errors: float = 3.0,
                  darkness: float = 1e-5) -> list[Disagreement]:
    """The agreement test of the project: |a - b| <= 1 % of |b| + 3 standard errors of the difference, for every block and channel. Returns the
    failures, the worst first. A value that is not finite always fails.

    A side without any light has no estimate of its standard error, while the other may have a rare path with little light. Therefore a difference
    below `darkness` times the mean of the whole reference, which is invisible, is accepted."""
    if ours.means.shape != theirs.means.shape:
        raise ValueError(f"images of {ours.means.shape} and {theirs.means.shape} blocks cannot be compared")
    allowance = relative * np.abs(theirs.means) + darkness * np.abs(theirs.means).mean()
    allowance = allowance + standard_errors * np.hypot(ours.standard_errors, theirs.standard_errors)
    difference = np.abs(ours.means - theirs.means)
    failed = np.argwhere(~(difference <= allowance))
    found = [Disagreement(int(row), int(column), int(channel), float(ours.means[row, column, channel]), float(theirs.means[row, column, channel]),
                          float(allowance[row, column, channel])) for row, column, channel in failed]
    return sorted(found, key=lambda d: -abs(d.value - d.reference) / max(d.allowance, 1e-300))


# ---- Welch's test ------------------------------------------------------------------------------------


def _incomplete_beta(a, b, x) -> np.ndarray:
    """Regularised incomplete beta function I_x(a, b) by Lentz's continued fraction [Press et al. 2007, section 6.4]."""
    a, b, x = np.broadcast_arrays(*(np.asarray(v, dtype=np.float64) for v in (a, b, x)))
    swap = x > (a + 1.0) / (a + b + 2.0)
    a, b, x = np.where(swap, b, a), np.where(swap, a, b), np.where(swap, 1.0 - x, x)
    tiny = 1e-300
    c = np.ones_like(x)
    d = 1.0 - (a + b) * x / (a + 1.0)
    d = 1.0 / np.where(np.abs(d) < tiny, tiny, d)
    h = d
    for m in range(1, 400):
        for numerator in (m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                          -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))):
            d = 1.0 + numerator * d
            d = 1.0 / np.where(np.abs(d) < tiny, tiny, d)
            c = 1.0 + numerator / c
            c = np.where(np.abs(c) < tiny, tiny, c)
            h = h * d * c
        if np.all(np.abs(d * c - 1.0) < 1e-14):
            break
    with np.errstate(divide="ignore"):
        log_front = a * np.log(x) + b * np.log1p(-x) - np.log(a) - (_log_gamma(a) + _log_gamma(b) - _log_gamma(a + b))
    value = np.exp(log_front) * h
    return np.where(swap, 1.0 - value, value)


def _log_gamma(x) -> np.ndarray:
    """Logarithm of the gamma function for x > 0: Stirling's series after shifting x above 8 [Abramowitz and Stegun, 6.1.41]."""
    x = np.asarray(x, dtype=np.float64)
    shift = np.zeros_like(x)
    for _ in range(8):
        low = x < 8.0
        shift = shift + np.where(low, np.log(np.where(low, x, 1.0)), 0.0)
        x = np.where(low, x + 1.0, x)
    inverse = 1.0 / x
    series = inverse * (1 / 12 - inverse**2 * (1 / 360 - inverse**2 * (1 / 1260 - inverse**2 / 1680)))
    return (x - 0.5) * np.log(x) - x + 0.5 * np.log(2.0 * np.pi) + series - shift


def student_p_value(t, degrees_of_freedom) -> np.ndarray:
    """Two-sided p-value of Student's t."""
    t, nu = np.broadcast_arrays(np.asarray(t, dtype=np.float64), np.asarray(degrees_of_freedom, dtype=np.float64))
    return _incomplete_beta(nu / 2.0, 0.5, nu / (nu + t**2))


@dataclass(frozen=True)
class WelchResult:
    """`p_values` per block and channel; `significant` those below the Šidák-corrected level."""

    p_values: np.ndarray
    level: float
    significant: np.ndarray

    @property
    def agrees(self) -> bool:
        return not self.significant.any()


def welch_test(ours: Blocks, theirs: Blocks, level: float = 0.01) -> WelchResult:
    """Welch's t-test of equal means in every block and channel [Welch 1947], at the joint `level`: each is tested at 1 - (1 - level)^(1/n) [Šidák
    1967]. Blocks without scatter on either side must be equal."""
    if ours.means.shape != theirs.means.shape:
        raise ValueError(f"images of {ours.means.shape} and {theirs.means.shape} blocks cannot be compared")
    variance_a, variance_b = ours.standard_errors**2, theirs.standard_errors**2
    variance = variance_a + variance_b
    difference = ours.means - theirs.means
    safe = np.where(variance > 0.0, variance, 1.0)
    denominator = variance_a**2 / max(ours.replicates - 1, 1) + variance_b**2 / max(theirs.replicates - 1, 1)
    degrees = np.where(variance > 0.0, variance**2 / np.where(denominator > 0.0, denominator, 1.0), 1.0)
    p_values = student_p_value(difference / np.sqrt(safe), degrees)
    p_values = np.where(variance > 0.0, p_values, np.where(difference == 0.0, 1.0, 0.0))
    p_values = np.where(np.isfinite(difference), p_values, 0.0)
    threshold = -np.expm1(np.log1p(-level) / p_values.size)
    return WelchResult(p_values, float(threshold), p_values < threshold)
