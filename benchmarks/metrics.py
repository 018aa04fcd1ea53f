"""Errors of images, and ratios of the times in which renderers reach the same error.

Images are arrays of linear radiance, height x width x 3; `R` is the reference, `I` the measured image. Functions return a smaller number for a better
image, except efficiencies and speedups. Times are seconds of the render without scene export and build, which are reported separately.
"""

from __future__ import annotations

import numpy as np

# CIE Y of linear Rec. 709 primaries, as in Blender.
LUMINANCE_WEIGHTS = np.array([0.2126729, 0.7151522, 0.0721750])

# Radiance 1 in a scene is the white of a display; ITU-R BT.709 / sRGB viewing assumes 80 to 100 cd/m^2. The thesis does not state its mapping, so
# that its tables can be compared only by ratios.
CANDELAS_PER_UNIT = 100.0


def luminance(image: np.ndarray) -> np.ndarray:
    """CIE Y of each pixel."""
    return np.asarray(image, dtype=np.float64)[..., :3] @ LUMINANCE_WEIGHTS


# ---- Errors ------------------------------------------------------------------------------------------


def relative_squared_errors(image, reference, reference_variance=None, epsilon: float = 0.01) -> np.ndarray:
    """(I-R)^2 / (R^2 + epsilon) per pixel, mean over channels [Rousselle et al. 2011, "Adaptive Sampling and
    Reconstruction using Greedy Error Minimization", section 6].

    The noise of a reference adds var(R) / (R^2 + epsilon) to the expectation. With `reference_variance` (variance of the pixel means of the
    reference) it is subtracted; single pixels may then be negative.
    """
    image = np.asarray(image, dtype=np.float64)[..., :3]
    reference = np.asarray(reference, dtype=np.float64)[..., :3]
    squared = (image - reference) ** 2
    if reference_variance is not None:
        squared = squared - np.asarray(reference_variance, dtype=np.float64)[..., :3]
    return (squared / (reference**2 + epsilon)).mean(axis=-1)


def relmse(image, reference, reference_variance=None, discard: float = 0.0) -> float:
    """Relative mean squared error. `discard` is the fraction of the worst pixels that is omitted (0.001 for the usual 0.1 %, which removes single
    fireflies and keeps the noise)."""
    errors = np.sort(relative_squared_errors(image, reference, reference_variance), axis=None)
    kept = errors.size - int(np.ceil(discard * errors.size))
    return float(errors[: max(kept, 1)].mean())


def tvi(candelas) -> np.ndarray:
    """Threshold versus intensity: the smallest luminance difference that an eye adapted to `candelas` (cd/m^2) can see,
    in cd/m^2 [Ferwerda et al. 1996; Ward Larson et al. 1997, "A Visibility Matching Tone Reproduction Operator",
    table 1, in its piecewise form]. Black has the threshold of the darkest piece."""
    level = np.log10(np.maximum(np.asarray(candelas, dtype=np.float64), 1e-30))
    rods = np.maximum(0.405 * level + 1.6, 0.0) ** 2.18 - 2.86
    cones = np.maximum(0.249 * level + 0.65, 0.0) ** 2.7 - 0.72
    # The first true condition selects the piece.
    exponent = np.select([level < -3.94, level < -1.44, level < -0.0184, level < 1.9],
                         [-2.86, rods, level - 0.395, cones], level - 1.255)
    return 10.0**exponent


def perceptual_error(image, reference, candelas_per_unit: float = CANDELAS_PER_UNIT) -> float:
    """Err = sum over pixels of e^2 / tvi(L), with e and L in cd/m^2 [Fan 2006, section 5.3.4 and the tables of chapter 5;
    L is the reference's]. It is proportional to the number of pixels, so that only equal resolutions can be compared."""
    true = luminance(reference) * candelas_per_unit
    error = luminance(image) * candelas_per_unit - true
    return float((error**2 / tvi(true)).sum())


def perceptual_efficiency(seconds: float, error: float) -> float:
    """P-Eff = 1 / (T * Err) [Fan 2006, chapter 5]."""
    return 1.0 / (seconds * error)


def ocv_error(image, reference, candelas_per_unit: float = CANDELAS_PER_UNIT) -> float:
    """Square root of the mean over pixels of ((L - L_true) / tvi(L_true))^2 [Fan 2006, section 6.5; Fan et al. 2006]."""
    true = luminance(reference) * candelas_per_unit
    relative = (luminance(image) * candelas_per_unit - true) / tvi(true)
    return float(np.sqrt((relative**2).mean()))


def mps_error(image, reference) -> float:
    """Root mean square over pixels of the relative luminance error (I - I_ref) / I_ref [Fan 2006, section 4.6;
    Fan et al. 2005]. Pixels with a black reference have no relative error and are omitted."""
    true = luminance(reference)
    lit = true > 0.0
    return float(np.sqrt((((luminance(image) - true)[lit] / true[lit]) ** 2).mean()))


def structural_similarity(image, reference) -> float:
    """SSIM of the display luminance (sRGB curve, clipped to 0..1): the mean over windows of 7 x 7 pixels [Wang et al. 2004]. 1: equal."""
    def display(picture) -> np.ndarray:
        light = np.clip(luminance(picture), 0.0, 1.0)
        return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)

    def mean(values: np.ndarray) -> np.ndarray:
        return np.lib.stride_tricks.sliding_window_view(values, (7, 7)).mean(axis=(-1, -2))
    x, y = display(image), display(reference)
    mx, my = mean(x), mean(y)
    vx, vy, both = mean(x * x) - mx * mx, mean(y * y) - my * my, mean(x * y) - mx * my
    c1, c2 = 0.01**2, 0.03**2
    return float((((2 * mx * my + c1) * (2 * both + c2)) / ((mx * mx + my * my + c1) * (vx + vy + c2))).mean())


def worst_block(image, reference, side: int = 16) -> float:
    """The largest relMSE of a square of `side` pixels."""
    errors = relative_squared_errors(image, reference)
    height, width = (size - size % side for size in errors.shape)
    return float(errors[:height, :width].reshape(height // side, side, width // side, side).mean(axis=(1, 3)).max())


# ---- Efficiency --------------------------------------------------------------------------------------


def efficiency(seconds: float, error: float) -> float:
    """1 / (T * relMSE): constant in T for a renderer whose variance falls as 1/T [Hammersley and Handscomb 1964, 5.1]."""
    return 1.0 / (seconds * error)


class ErrorCurve:
    """The error of one renderer on one scene as a function of time, interpolated linearly on log-log axes.

    By noise, a longer render can have a larger error than a shorter one. Such points are removed, so that the time to an error is the first time at
    which it is reached.
    """

    def __init__(self, seconds, errors):
        order = np.argsort(np.asarray(seconds, dtype=np.float64), kind="stable")
        self.seconds = np.asarray(seconds, dtype=np.float64)[order]
        self.errors = np.asarray(errors, dtype=np.float64)[order]
        if self.seconds.size == 0 or (self.seconds <= 0).any() or (self.errors <= 0).any():
            raise ValueError("an error curve needs points with positive times and errors")
        best_before = np.concatenate([[np.inf], np.minimum.accumulate(self.errors)[:-1]])
        better = self.errors < best_before
        self.seconds, self.errors = self.seconds[better], self.errors[better]

    def time_to(self, error: float) -> float:
        """Seconds until the error has fallen to `error`; nan outside of the curve, without extrapolation."""
        log_errors = np.log(self.errors[::-1])
        log_seconds = np.log(self.seconds[::-1])
        return float(np.exp(np.interp(np.log(error), log_errors, log_seconds, left=np.nan, right=np.nan)))


def equal_error_speedup(ours: ErrorCurve, theirs: ErrorCurve, levels: int = 33) -> float:
    """The time of `theirs` divided by that of `ours` at equal error: the geometric mean over the errors that both curves reach, equidistant in log
    error; nan if there are none. 2 means twice as fast."""
    low = max(ours.errors.min(), theirs.errors.min())
    high = min(ours.errors.max(), theirs.errors.max())
    if low > high:
        return float("nan")
    ratios = [theirs.time_to(error) / ours.time_to(error) for error in np.geomspace(high, low, levels)[1:-1]]
    return float(np.exp(np.nanmean(np.log(ratios))))
