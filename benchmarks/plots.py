"""Plots of error over time on log-log axes as SVG text, without a plotting package."""

from __future__ import annotations

import math
from html import escape

import numpy as np

COLORS = ["#0a6ebd", "#d1481f", "#3b8f3e", "#8a4fbf", "#b08800", "#555555"]
WIDTH, HEIGHT = 480, 340
LEFT, RIGHT, TOP, BOTTOM = 62, 14, 30, 44


def decades(low: float, high: float) -> list[float]:
    """Powers of ten in [low, high], or the 1-2-5 series if there are fewer than two."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks = [10.0**power for power in powers if low <= 10.0**power <= high]
    if len(ticks) < 2:
        ticks = [m * 10.0**power for power in powers for m in (1, 2, 5) if low <= m * 10.0**power <= high]
    return ticks


def loglog_plot(title: str, curves: dict[str, tuple], x_label: str = "seconds", y_label: str = "relMSE") -> str:
    """A plot with one line with markers for each curve. A curve is (x values, y values), all positive."""
    xs = np.concatenate([np.asarray(x, float) for x, _ in curves.values()])
    ys = np.concatenate([np.asarray(y, float) for _, y in curves.values()])
    x_low, x_high, y_low, y_high = xs.min() / 1.2, xs.max() * 1.2, ys.min() / 1.3, ys.max() * 1.3

    def at(x: float, y: float) -> tuple[float, float]:
        along = math.log(x / x_low) / math.log(x_high / x_low)
        up = math.log(y / y_low) / math.log(y_high / y_low)
        return LEFT + along * (WIDTH - LEFT - RIGHT), HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM)

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" '
             'font-family="sans-serif" font-size="12">', f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
             f'<text x="{WIDTH / 2}" y="18" text-anchor="middle" font-size="14">{escape(title)}</text>']
    for x in decades(x_low, x_high):
        px, _ = at(x, y_low)
        parts.append(f'<path d="M{px:.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#ddd"/>'
                     f'<text x="{px:.1f}" y="{HEIGHT - BOTTOM + 16}" text-anchor="middle">{x:g}</text>')
    for y in decades(y_low, y_high):
        _, py = at(x_low, y)
        parts.append(f'<path d="M{LEFT} {py:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>'
                     f'<text x="{LEFT - 6}" y="{py + 4:.1f}" text-anchor="end">{y:g}</text>')
    parts.append(f'<rect x="{LEFT}" y="{TOP}" width="{WIDTH - LEFT - RIGHT}" height="{HEIGHT - TOP - BOTTOM}" fill="none" stroke="#888"/>')
    for (x, y), color in zip(curves.values(), COLORS * (1 + len(curves) // len(COLORS))):
        points = [at(float(a), float(b)) for a, b in zip(x, y)]
        parts.append(f'<polyline points="{" ".join(f"{a:.1f},{b:.1f}" for a, b in points)}" fill="none" stroke="{color}" stroke-width="2"/>')
        parts += [f'<circle cx="{a:.1f}" cy="{b:.1f}" r="3" fill="{color}"/>' for a, b in points]
    for row, (name, color) in enumerate(zip(curves, COLORS * (1 + len(curves) // len(COLORS)))):
        y = HEIGHT - BOTTOM - 10 - 16 * (len(curves) - 1 - row)
        parts.append(f'<path d="M{LEFT + 8} {y - 4}h18" stroke="{color}" stroke-width="2"/><text x="{LEFT + 32}" y="{y}">{escape(name)}</text>')
    parts.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 8}" text-anchor="middle">{escape(x_label)}</text>')
    parts.append(f'<text transform="translate(14 {(TOP + HEIGHT - BOTTOM) / 2}) rotate(-90)" text-anchor="middle">{escape(y_label)}</text></svg>')
    return "\n".join(parts) + "\n"
