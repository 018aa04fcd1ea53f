"""Images that are computed for the test scenes and packed into the files: planks, paintings, cloth, skies.

Functions return float arrays of shape (height, width, 3), first row at the bottom, in display (sRGB) values;
`sky` alone is linear radiance.
"""

from __future__ import annotations

import bpy
import numpy as np

from scene_tools import packed_image


def pack(name: str, pixels: np.ndarray, hdr: bool = False) -> bpy.types.Image:
    height, width = pixels.shape[:2]
    rgba = np.ones((height, width, 4), dtype=np.float32)
    rgba[..., :3] = pixels if hdr else np.clip(pixels, 0.0, 1.0)
    return packed_image(name, width, height, rgba.ravel(), hdr=hdr)


def smooth_noise(rng: np.random.Generator, height: int, width: int, cells_y: int, cells_x: int) -> np.ndarray:
    """Periodic value noise in [0, 1] with the given number of cells each way."""
    values = rng.random((cells_y, cells_x))
    y, x = np.arange(height) * cells_y / height, np.arange(width) * cells_x / width
    y0, x0 = y.astype(int), x.astype(int)
    fy, fx = y - y0, x - x0
    fy, fx = (fy * fy * (3 - 2 * fy))[:, None], (fx * fx * (3 - 2 * fx))[None, :]
    y1, x1 = (y0 + 1) % cells_y, (x0 + 1) % cells_x
    low = values[np.ix_(y0, x0)] * (1 - fx) + values[np.ix_(y0, x1)] * fx
    high = values[np.ix_(y1, x0)] * (1 - fx) + values[np.ix_(y1, x1)] * fx
    return low * (1 - fy) + high * fy


def blend(low: tuple[float, float, float], high: tuple[float, float, float], t: np.ndarray) -> np.ndarray:
    return np.asarray(low) * (1 - t[..., None]) + np.asarray(high) * t[..., None]


def wood(
    dark: tuple[float, float, float],
    light: tuple[float, float, float],
    size: int = 512,
    boards: int = 1,
    joint: float = 0.012,
    seed: int = 1,
) -> np.ndarray:
    """Wood with its grain along U: `boards` planks side by side along V, with staggered ends and dark joints."""
    rng = np.random.default_rng(seed)
    grain = np.zeros((size, size))
    tone = np.zeros((size, size))
    gap = np.ones((size, size))
    u = np.arange(size) / size
    for board in range(boards):
        rows = slice(board * size // boards, (board + 1) * size // boards)
        count = rows.stop - rows.start
        streaks = (
            sum(smooth_noise(rng, count, size, max(2, count // (12 >> k)), 3 << k) / 2**k for k in range(3)) / 1.75
        )
        rings = 0.5 + 0.5 * np.sin(
            2 * np.pi * (4 * smooth_noise(rng, count, size, 2, 3) + 3 * smooth_noise(rng, count, size, 5, 2))
        )
        grain[rows] = 0.6 * streaks + 0.4 * rings
        if boards == 1:
            tone[rows] = 0.5
            continue
        ends = (rng.random() + np.array([0.0, 0.5])) % 1.0
        side = ((u - ends[0]) % 1.0) < ((ends[1] - ends[0]) % 1.0)
        tone[rows] = np.where(side, rng.random(), rng.random())[None, :]
        v = np.minimum(np.arange(count), count - 1 - np.arange(count))[:, None] / size
        distance = np.minimum(v, np.min([np.abs((u - e + 0.5) % 1.0 - 0.5) for e in ends], axis=0)[None, :])
        gap[rows] = 0.35 + 0.65 * np.clip(distance * boards / joint / 4.0, 0.0, 1.0)
    return blend(dark, light, np.clip(0.55 * grain + 0.45 * tone, 0.0, 1.0)) * gap[..., None]


def cloth(
    first: tuple[float, float, float],
    second: tuple[float, float, float],
    border: tuple[float, float, float],
    height: int = 256,
    width: int = 384,
    seed: int = 2,
) -> np.ndarray:
    """A woven carpet: a border of bands and a field of diamonds."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:height, 0:width].astype(float)
    inset = np.minimum(np.minimum(x, width - 1 - x), np.minimum(y, height - 1 - y)) / height
    cell = height / 8
    diamonds = np.abs((x / cell) % 2 - 1) + np.abs((y / cell) % 2 - 1)
    field = np.where((diamonds < 0.55) | (np.abs(diamonds - 1.0) < 0.12), 1.0, 0.0)
    pixels = blend(first, second, field)
    bands = np.asarray([border, second, border, first, second])
    band = np.clip((inset / 0.025).astype(int), 0, 5)
    pixels = np.where((band < 5)[..., None], bands[np.minimum(band, 4)], pixels)
    return pixels * (0.86 + 0.14 * rng.random((height, width, 1)))


def landscape(
    height: int = 256,
    width: int = 384,
    seed: int = 3,
    sky_low=(0.98, 0.78, 0.48),
    sky_high=(0.25, 0.42, 0.60),
    near=(0.10, 0.16, 0.14),
    far=(0.52, 0.53, 0.55),
) -> np.ndarray:
    """A painted evening: a low sun, five ridges fading with distance, a lake."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[0:height, 0:width].astype(float)
    v, u = v / height, u / width
    pixels = blend(sky_low, sky_high, np.clip((v - 0.35) / 0.65, 0, 1) ** 0.8)
    sun = np.exp(-(((u - 0.64) * width / height) ** 2 + (v - 0.56) ** 2) / 0.004)
    pixels = pixels + sun[..., None] * np.asarray((0.6, 0.35, 0.1))
    for ridge in range(5):
        t = ridge / 4
        base = 0.56 - 0.11 * ridge
        line = (
            base
            + (0.10 + 0.04 * t) * (smooth_noise(rng, 1, width, 1, 5 + ridge)[0] - 0.5)
            + 0.03 * (smooth_noise(rng, 1, width, 1, 23)[0] - 0.5)
        )
        colour = np.asarray(far) * (1 - t) + np.asarray(near) * t
        cover = np.clip((line[None, :] - v) * height / 2, 0, 1)[..., None]
        pixels = pixels * (1 - cover) + colour * (0.9 + 0.25 * (line[None, :, None] - v[..., None])) * cover
    strokes = smooth_noise(rng, height, width, height // 3, width // 12)
    return pixels * (0.92 + 0.16 * strokes[..., None])


def mottled(
    first: tuple[float, float, float],
    second: tuple[float, float, float],
    size: int = 256,
    cells: int = 6,
    seed: int = 5,
) -> np.ndarray:
    """Patches of two colours at many scales, for earth, gravel and turf. The image is periodic."""
    rng = np.random.default_rng(seed)
    octaves = [(cells << k, 0.7**k) for k in range(5)]
    value = sum(share * smooth_noise(rng, size, size, count, count) for count, share in octaves) / sum(
        s for _, s in octaves
    )
    return blend(first, second, np.clip((value - 0.5) * 2.2 + 0.5, 0.0, 1.0))


def sky(sun: tuple[float, float, float], height: int = 128, width: int = 256) -> np.ndarray:
    """Radiance of a clear sky with haze at the horizon and a halo around the sun (the sun itself is a lamp).

    The mapping is equirectangular as in Cycles; `sun` points to the sun. Below the horizon is the colour of distant ground.
    """
    v, u = (np.mgrid[0:height, 0:width] + 0.5) / np.array([height, width]).reshape(2, 1, 1)
    elevation, azimuth = (v - 0.5) * np.pi, (0.5 - u) * 2 * np.pi
    toward = np.stack(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], axis=-1
    )
    cosine = np.clip(toward @ (np.asarray(sun) / np.linalg.norm(sun)), -1.0, 1.0)
    up = np.clip(toward[..., 2], 0.0, 1.0)
    pixels = blend((0.90, 1.02, 1.15), (0.14, 0.34, 0.85), up**0.45)
    pixels += (0.55 * np.exp((cosine - 1.0) / 0.10) + 0.25 * np.exp((cosine - 1.0) / 0.6))[..., None] * np.asarray(
        (1.0, 0.82, 0.58)
    )
    return np.where((toward[..., 2] < 0.0)[..., None], np.asarray((0.16, 0.17, 0.12)), pixels)
