#!/usr/bin/python3
"""compare.py BUILD: renders a scene with ajar-render.exe under Wine and with ajar-render of a build for Linux, and compares the pictures.

Both take the same samples. The functions of the C libraries (sin, pow) differ in the last bit, so a few paths take another turn, and the others agree to rounding.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "tests" / "render" / "materials_5.ajar"
SAMPLES = 16
SAME = 1e-3              # of a pixel, relative: rounding of its samples
MIN_SAME = 0.97          # of all pixels
MAX_DIFFERENCE = 5e-3    # of the means of the pictures


def render(command: Sequence[object], picture: Path) -> float:
    """Render the scene and return the seconds that it took."""
    start = time.monotonic()
    subprocess.run([*map(str, command), str(SCENE), str(picture), "--samples", str(SAMPLES)], check=True, capture_output=True)
    return time.monotonic() - start


def main() -> None:
    build = Path(sys.argv[1])
    sys.path.insert(0, str(build / "python"))
    import ajar

    with tempfile.TemporaryDirectory() as folder:
        pictures = [Path(folder) / "linux.exr", Path(folder) / "windows.exr"]
        wine = [ROOT / "tools" / "windows" / "wine.sh", ROOT / "build" / "windows" / "ajar" / "ajar-render.exe"]
        seconds = [render([build / "ajar-render"], pictures[0]), render(wine, pictures[1])]
        linux, windows = (np.asarray(ajar.read_image(str(path)), dtype=np.float64)[..., :3] for path in pictures)
    same = float(np.mean(np.all(np.abs(windows - linux) <= SAME * (np.abs(linux) + 1e-3), axis=-1)))
    difference = abs(windows.mean() / linux.mean() - 1.0)
    print(f"{SCENE.name}, {SAMPLES} samples: {100.0 * same:.2f} % of the pixels agree to {SAME:g}, the means to {difference:.1e}; "
          f"{seconds[0]:.1f} s on Linux, {seconds[1]:.1f} s under Wine, both with their start")
    if same < MIN_SAME or difference > MAX_DIFFERENCE:
        raise SystemExit("The pictures differ.")


if __name__ == "__main__":
    main()
