"""OpenEXR files of Blender are read exactly."""

import struct
import zlib

import images
import numpy as np
import pytest


def exr_bytes(planes, compression, metadata=None):
    """A scanline OpenEXR file, built from the specification of the format and independent of the reader."""
    names = sorted(planes)
    height, width = planes[names[0]].shape
    kinds = {np.dtype("f2"): 1, np.dtype("f4"): 2}

    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    channels = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", kinds[planes[n].dtype], 0, 1, 1) for n in names) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = b"\x76\x2f\x31\x01\x02\0\0\0" + attribute("channels", "chlist", channels)
    header += attribute("compression", "compression", bytes([compression]))
    header += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    for name, value in (metadata or {}).items():
        header += attribute(name, "string", value.encode())
    header += b"\0"
    lines = 16 if compression == 3 else 1
    chunks = []
    for y in range(0, height, lines):
        raw = b"".join(planes[n][row].tobytes() for row in range(y, min(y + lines, height)) for n in names)
        if compression:
            data = np.frombuffer(raw, np.uint8)
            data = np.concatenate([data[0::2], data[1::2]]).astype(int)
            data[1:] = (data[1:] - data[:-1] + 128) & 255
            packed = zlib.compress(data.astype(np.uint8).tobytes())
            raw = packed if len(packed) < len(raw) else raw
        chunks.append(struct.pack("<ii", y, len(raw)) + raw)
    offsets, at = [], len(header) + 8 * len(chunks)
    for chunk in chunks:
        offsets.append(at)
        at += len(chunk)
    return header + struct.pack(f"<{len(offsets)}Q", *offsets) + b"".join(chunks)


@pytest.mark.parametrize("compression", [0, 2, 3])
@pytest.mark.parametrize("smooth", [True, False])
def test_channels_of_both_depths_are_read_exactly(tmp_path, compression, smooth):
    random = np.random.default_rng(1)
    values = np.linspace(0, 1, 37 * 23).reshape(37, 23) if smooth else random.random((37, 23)) * 1e4
    planes = {"R": values.astype("f4"), "G": (values * 0.5).astype("f2"), "B": -values.astype("f4"), "A": np.ones((37, 23), "f2")}
    (tmp_path / "image.exr").write_bytes(exr_bytes(planes, compression))
    assert np.array_equal(images.read_exr(tmp_path / "image.exr"), np.stack([planes[c].astype("f4") for c in "RGB"], axis=-1))
    assert images.read_exr(tmp_path / "image.exr", "A").min() == 1.0


def test_metadata_is_read(tmp_path):
    text = {"cycles.ViewLayer.render_time": "01:02.50", "Camera": "Caméra"}
    (tmp_path / "image.exr").write_bytes(exr_bytes({"Y": np.zeros((1, 1), "f4")}, 0, text))
    assert images.read_exr_text(tmp_path / "image.exr") == text


def test_error_of_an_unknown_compression_has_its_name(tmp_path):
    (tmp_path / "image.exr").write_bytes(exr_bytes({"Y": np.zeros((1, 1), "f4")}, 4))
    with pytest.raises(ValueError, match="compression 4"):
        images.read_exr(tmp_path / "image.exr", "Y")


def test_srgb_values_are_those_of_the_standard():
    # 0.215861 is the linear value of 128 of 255 (IEC 61966-2-1).
    assert images.srgb_bytes(np.array([[[0.0, 0.215861, 7.0]]])).tolist() == [[[0, 128, 255]]]


def test_png_has_the_pixels(tmp_path):
    pixels = np.arange(2 * 3 * 3, dtype=np.uint8).reshape(2, 3, 3)
    images.write_png(tmp_path / "image.png", pixels)
    data = (tmp_path / "image.png").read_bytes()
    start = data.index(b"IDAT") + 4
    (length,) = struct.unpack(">I", data[start - 8 : start - 4])
    assert zlib.decompress(data[start : start + length]) == b"".join(b"\0" + row.tobytes() for row in pixels)
