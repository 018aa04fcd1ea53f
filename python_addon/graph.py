"""Images for the Progress panel, drawn with NumPy: the noise over time, and the samples of each pixel.

An image is float32 [height, width, 4] in display colours, with rows from bottom to top. This module needs no Blender, window or main thread.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

BACKGROUND, GRID, TEXT = (0.11, 0.11, 0.11), (0.22, 0.22, 0.22), (0.78, 0.78, 0.78)
CURVE, TARGET, EXPECTED = (1.0, 0.66, 0.22), (0.35, 0.75, 0.45), (0.55, 0.42, 0.25)
GLYPH_HEIGHT = 7
GLYPHS = {   # rows from top to bottom
    "0": "01110 10001 10011 10101 11001 10001 01110", "1": "00100 01100 00100 00100 00100 00100 01110",
    "2": "01110 10001 00001 00110 01000 10000 11111", "3": "01110 10001 00001 00110 00001 10001 01110",
    "4": "00010 00110 01010 10010 11111 00010 00010", "5": "11111 10000 11110 00001 00001 10001 01110",
    "6": "00110 01000 10000 11110 10001 10001 01110", "7": "11111 00001 00010 00100 01000 01000 01000",
    "8": "01110 10001 10001 01110 10001 10001 01110", "9": "01110 10001 10001 01111 00001 00010 01100",
    ".": "00 00 00 00 00 11 11", "%": "11001 11010 00010 00100 01000 01011 10011", " ": "000 000 000 000 000 000 000",
    "s": "0000 0000 0111 1000 0110 0001 1110", "m": "00000 00000 11010 10101 10101 10101 10101", "i": "1 0 1 1 1 1 1",
    "n": "0000 0000 1110 1001 1001 1001 1001", "h": "1000 1000 1110 1001 1001 1001 1001",
}
SECOND_TICKS = ((0.01, 0.1, 1, 10, 60, 600, 3600, 36000, 360000), (0.02, 0.05, 0.2, 0.5, 2, 5, 20, 30, 120, 300, 1200, 1800, 7200, 18000, 72000, 180000))
DENSITY_COLORS = np.array([(0.02, 0.02, 0.10), (0.30, 0.07, 0.42), (0.72, 0.21, 0.33), (0.98, 0.55, 0.15), (0.99, 0.98, 0.70)], dtype=np.float32)


@dataclass(frozen=True)
class Axis:
    """A logarithmic scale: the values `low` and `high` are at the pixels `start` and `end`."""

    low: float
    high: float
    start: float
    end: float

    def place(self, value: Any) -> Any:
        """The pixel of a value, or of each value of an array."""
        return self.start + (np.log(value) - math.log(self.low)) * (self.end - self.start) / (math.log(self.high) - math.log(self.low))


@dataclass(frozen=True)
class Frame:
    """The position of the graph in its image, and its scales."""

    x: Axis   # seconds
    y: Axis   # noise as a fraction of the brightness


def frame_of(seconds: np.ndarray, noise: np.ndarray, target: float, end_seconds: float, width: int, height: int, unit: int) -> Frame:
    """A frame that contains all points, the target (0: none) and the expected end (0: unknown)."""
    values = np.append(noise, target) if target > 0.0 else noise
    if end_seconds > seconds[-1]:
        values = np.append(values, expected_noise(seconds, noise, end_seconds, target))
    first, last = float(seconds.min()), max(float(seconds.max()), end_seconds)
    low, high = 0.8 * float(values.min()), 1.25 * float(values.max())
    high = max(high, 2.0 * low)
    names = [name_of_noise(value) for ticks in ticks_of_noise(low, high) for value in ticks]
    left, bottom = max((text_width(name, unit) for name in names), default=0) + 4 * unit, (GLYPH_HEIGHT + 5) * unit
    return Frame(Axis(first, max(last, 2.0 * first), left, width - 6 * unit), Axis(low, high, bottom, height - 6 * unit))


def expected_noise(seconds: np.ndarray, noise: np.ndarray, end_seconds: float, target: float) -> float:
    """The noise at the expected end, if it falls as one over the square root of the time; at least the target."""
    return max(target, float(noise[-1]) * math.sqrt(float(seconds[-1]) / end_seconds))


def draw(seconds: Sequence[float] | np.ndarray, noise: Sequence[float] | np.ndarray, target: float, end_seconds: float, width: int, height: int, unit: int = 1) -> np.ndarray:
    """The noise over time, both logarithmic. `unit`: size of a dot of the text in pixels. Only times and values above 0 are drawn; without any, the
    image is empty."""
    times, errors = np.asarray(seconds, dtype=np.float64), np.asarray(noise, dtype=np.float64)
    valid = np.isfinite(times) & np.isfinite(errors) & (times > 0.0) & (errors > 0.0)
    times, errors = times[valid], errors[valid]
    picture = np.ones((height, width, 4), dtype=np.float32)
    picture[..., :3] = BACKGROUND
    if len(times) == 0:
        return picture
    frame = frame_of(times, errors, target, end_seconds, width, height, unit)
    _draw_grid(picture, frame, unit)
    if target > 0.0:
        y = round(float(frame.y.place(target)))
        dashes = np.arange(width) // (3 * unit) % 2 == 0
        dashes[:round(frame.x.start)] = dashes[round(frame.x.end) + 1:] = False
        picture[max(0, y - unit // 2):y - unit // 2 + unit, dashes, :3] = TARGET
    if end_seconds > times[-1]:
        _draw_line(picture, frame, np.array([times[-1], end_seconds]), np.array([errors[-1], expected_noise(times, errors, end_seconds, target)]), 0.5 * unit, EXPECTED)
    _draw_line(picture, frame, times, errors, 0.8 * unit, CURVE)
    return picture


def density(counts: np.ndarray) -> np.ndarray:
    """The sample counts as colours from dark (minimum) to bright (maximum), on a logarithmic scale."""
    logs = np.log(np.maximum(counts, 1.0))
    low, high = float(logs.min()), float(logs.max())
    parts = (logs - low) / (high - low) if high > low else np.full_like(logs, 0.5)
    picture = np.ones((*counts.shape, 4), dtype=np.float32)
    picture[..., :3] = _density_table()[(255.0 * parts + 0.5).astype(np.uint8)]
    return picture


def shrunk(counts: np.ndarray, side: int) -> np.ndarray:
    """Means over squares of pixels, so that no side of the image is longer than `side`."""
    step = -(-max(counts.shape) // side)
    if step <= 1:
        return counts
    for axis in (0, 1):
        starts = np.arange(0, counts.shape[axis], step)
        sizes = np.diff(np.append(starts, counts.shape[axis])).astype(counts.dtype)
        counts = np.add.reduceat(counts, starts, axis=axis) / (sizes[:, None] if axis == 0 else sizes[None, :])
    return counts


def text_width(text: str, unit: int) -> int:
    return unit * sum(len(GLYPHS[letter].split()[0]) + 1 for letter in text)


def ticks_of_seconds(low: float, high: float) -> list[list[float]]:
    """Round times in the range, the most important first."""
    return [[t for t in ticks if low <= t <= high] for ticks in SECOND_TICKS]


def ticks_of_noise(low: float, high: float) -> list[list[float]]:
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    return [[digit * 10.0**k for k in decades for digit in digits if low <= digit * 10.0**k <= high] for digits in ((1,), (2, 5), (3, 4, 7))]


def name_of_noise(noise: float) -> str:
    """The noise in per cent, without an exponent."""
    return np.format_float_positional(100.0 * noise, precision=3, unique=False, fractional=False, trim="-") + "%"


def name_of_seconds(seconds: float) -> str:
    for size, name in ((3600, "h"), (60, "min")):
        if seconds >= size:
            return f"{seconds / size:g} {name}"
    return f"{seconds:g} s"


def _density_table() -> np.ndarray:
    places = np.linspace(0.0, len(DENSITY_COLORS) - 1.0, 256)
    return np.stack([np.interp(places, np.arange(len(DENSITY_COLORS)), DENSITY_COLORS[:, c]) for c in range(3)], axis=1).astype(np.float32)


def _draw_grid(picture: np.ndarray, frame: Frame, unit: int) -> None:
    """Draw lines at round values, each with its text unless it would touch another text."""
    x0, x1, y0, y1 = round(frame.x.start), round(frame.x.end), round(frame.y.start), round(frame.y.end)
    taken: list[tuple[float, float]] = []
    for ticks in ticks_of_noise(frame.y.low, frame.y.high):
        for value in ticks:
            y, text = round(float(frame.y.place(value))), name_of_noise(value)
            if _is_free(taken, y, 0.5 * (GLYPH_HEIGHT + 3) * unit):
                picture[y, x0:x1 + 1, :3] = GRID
                _draw_text(picture, text, x0 - text_width(text, unit) - unit, y - GLYPH_HEIGHT * unit // 2, unit)
    taken = []
    for ticks in ticks_of_seconds(frame.x.low, frame.x.high):
        for value in ticks:
            x, text = round(float(frame.x.place(value))), name_of_seconds(value)
            half = 0.5 * text_width(text, unit)
            if x + half <= picture.shape[1] and _is_free(taken, x, half + 2 * unit):
                picture[y0:y1 + 1, x, :3] = GRID
                _draw_text(picture, text, round(x - half), 2 * unit, unit)


def _is_free(taken: list[tuple[float, float]], place: float, half: float) -> bool:
    """Whether the interval is free. If so, it is marked as used."""
    if any(place - half < end and place + half > start for start, end in taken):
        return False
    taken.append((place - half, place + half))
    return True


def _draw_text(picture: np.ndarray, text: str, left: int, bottom: int, unit: int) -> None:
    for letter in text:
        rows = np.array([[int(dot) for dot in row] for row in GLYPHS[letter].split()[::-1]], dtype=bool)
        dots = np.kron(rows, np.ones((unit, unit), dtype=bool))
        top, right = min(bottom + dots.shape[0], picture.shape[0]), min(left + dots.shape[1], picture.shape[1])
        if left >= 0 and bottom >= 0 and right > left and top > bottom:
            picture[bottom:top, left:right, :3][dots[:top - bottom, :right - left]] = TEXT
        left += (rows.shape[1] + 1) * unit


def _draw_line(picture: np.ndarray, frame: Frame, seconds: np.ndarray, noise: np.ndarray, radius: float, color: tuple[float, float, float]) -> None:
    """Draw a line with soft edges through the points in the order of their times."""
    height, width = picture.shape[:2]
    xs, ys = frame.x.place(seconds), frame.y.place(noise)
    order = np.argsort(xs, kind="stable")
    xs, ys = xs[order], ys[order]
    columns = np.arange(max(0, math.floor(xs[0] - radius)), min(width, math.ceil(xs[-1] + radius) + 1))
    middle = np.interp(columns, xs, ys)
    left, right = np.interp(columns - 0.5, xs, ys), np.interp(columns + 0.5, xs, ys)
    # In each column, a steep line covers all rows between its values at the edges of the column.
    rows = np.arange(height)[:, None]
    top, bottom = np.maximum(np.maximum(left, right), middle), np.minimum(np.minimum(left, right), middle)
    outside = np.maximum(np.maximum(bottom - rows, rows - top), 0.0)
    beside = np.maximum(np.maximum(xs[0] - columns, columns - xs[-1]), 0.0)
    cover = np.clip(radius + 0.5 - np.hypot(outside, beside), 0.0, 1.0)[..., None].astype(np.float32)
    target = picture[:, columns, :3]
    picture[:, columns, :3] = target + cover * (np.array(color, dtype=np.float32) - target)
