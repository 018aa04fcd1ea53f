"""Reads and writes images for the tools. Only this file handles file formats.

Measurements must not depend on the measured program, so that NumPy and zlib read linear images here: single-part scanline OpenEXR, uncompressed or
ZIP, which Blender can write. Arrays are height x width x channels, with the top row first.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np

EXR_PIXEL_TYPES: dict[int, np.dtype] = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
EXR_LINES_PER_CHUNK = {0: 1, 2: 1, 3: 16}  # no compression, ZIPS, ZIP


def _parse_exr_header(data: bytes) -> tuple[dict[str, tuple[str, bytes]], int]:
    if data[:4] != b"\x76\x2f\x31\x01":
        raise ValueError("not an OpenEXR file")
    if data[5] & 0x1A:
        raise ValueError("tiled, deep or multi-part OpenEXR is not supported")
    attributes, at = {}, 8
    while data[at]:
        name_end = data.index(0, at)
        type_end = data.index(0, name_end + 1)
        (size,) = struct.unpack_from("<i", data, type_end + 1)
        start = type_end + 5
        attributes[data[at:name_end].decode()] = (data[name_end + 1 : type_end].decode(), data[start : start + size])
        at = start + size
    return attributes, at + 1


def read_exr_text(path: str | Path) -> dict[str, str]:
    """The text attributes of an OpenEXR file, which contain the metadata of renderers."""
    attributes, _ = _parse_exr_header(Path(path).read_bytes())
    return {name: value.decode(errors="replace") for name, (kind, value) in attributes.items() if kind == "string"}


def _parse_channels(value: bytes) -> list[tuple[str, np.dtype]]:
    channels: list[tuple[str, np.dtype]] = []
    at = 0
    while value[at]:
        end = value.index(0, at)
        (kind,) = struct.unpack_from("<i", value, end + 1)
        channels.append((value[at:end].decode(), EXR_PIXEL_TYPES[kind]))
        at = end + 17
    return channels


def _undo_zip(chunk: bytes, size: int) -> bytes:
    """Inflate, undo the byte differences, and interleave the two halves."""
    if len(chunk) == size:
        return chunk
    differences = np.frombuffer(zlib.decompress(chunk), dtype=np.uint8).astype(np.int64)
    differences[1:] -= 128
    decoded = (np.cumsum(differences) & 255).astype(np.uint8)
    result = np.empty_like(decoded)
    half = (decoded.size + 1) // 2
    result[0::2], result[1::2] = decoded[:half], decoded[half:]
    return result.tobytes()


def read_exr(path: str | Path, channels: str = "RGB") -> np.ndarray:
    """The named one-letter channels of an OpenEXR file as float32."""
    data = Path(path).read_bytes()
    attributes, at = _parse_exr_header(data)
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"][1])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    compression = attributes["compression"][1][0]
    if compression not in EXR_LINES_PER_CHUNK:
        raise ValueError(f"{path}: OpenEXR compression {compression} is not supported; save it with ZIP")
    lines = EXR_LINES_PER_CHUNK[compression]
    layout = _parse_channels(attributes["channels"][1])
    row_bytes = width * sum(kind.itemsize for _, kind in layout)
    planes = {name: np.empty((height, width), dtype=np.float32) for name, _ in layout}
    for offset in struct.unpack_from(f"<{-(-height // lines)}Q", data, at):
        y, size = struct.unpack_from("<ii", data, offset)
        first = y - y0
        count = min(lines, height - first)
        chunk = data[offset + 8 : offset + 8 + size]
        rows = np.frombuffer(_undo_zip(chunk, count * row_bytes) if compression else chunk, dtype=np.uint8)
        rows = rows.reshape(count, row_bytes)
        column = 0
        for name, kind in layout:
            bytes_wide = width * kind.itemsize
            planes[name][first : first + count] = np.ascontiguousarray(rows[:, column : column + bytes_wide]).view(kind)
            column += bytes_wide
    return np.stack([planes[name] for name in channels], axis=-1)


def srgb_bytes(linear: np.ndarray, exposure: float = 1.0) -> np.ndarray:
    """Linear radiance as 8-bit sRGB, clipped at white [IEC 61966-2-1]."""
    value = np.clip(np.nan_to_num(np.asarray(linear, dtype=np.float64)[..., :3] * exposure), 0.0, 1.0)
    encoded = np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)
    return np.rint(encoded * 255).astype(np.uint8)


def write_png(path: str | Path, pixels: np.ndarray) -> None:
    """8-bit RGB rows as a PNG file."""
    height, width, _ = pixels.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, width * 3)], axis=1)

    def chunk(kind: bytes, payload: bytes) -> bytes:
        return struct.pack(">I", len(payload)) + kind + payload + struct.pack(">I", zlib.crc32(kind + payload))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    Path(path).write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header)
                           + chunk(b"IDAT", zlib.compress(rows.tobytes(), 9)) + chunk(b"IEND", b""))
