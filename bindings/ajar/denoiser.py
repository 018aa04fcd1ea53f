"""Finds Open Image Denoise 2: the copy that is in the process already (official Blender has one), that of the environment variable AJAR_DENOISER, the
bundled one, or that of the system, in this order. Two copies in one process could conflict, so that a copy in the process is always used."""

from __future__ import annotations

import ctypes.util
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ._ajar import DenoiseQuality, denoise_quality_for, denoise_seconds_per_ray, denoiser_version, load_denoiser
from .system import loaded_libraries

if TYPE_CHECKING:
    import numpy as np

VARIABLE = "AJAR_DENOISER"
NAME = "OpenImageDenoise.dll" if sys.platform == "win32" else "libOpenImageDenoise.so.2"
BUNDLED = Path(__file__).parent / "lib" / "libajar_OpenImageDenoise.so"   # its symbols are renamed (tools/extension/isolate.py)
SECONDS_PER_RAY = denoise_seconds_per_ray()   # of a core
FREE_SECONDS = 5.0         # of a core: 2.5 seconds on two
_reasons: list[str] = []   # why the last `load` failed


def _in_process() -> str | None:
    return next((path for path in loaded_libraries() if Path(path).name.startswith(NAME)), None)


def library_file() -> str | None:
    """The file to load, or None."""
    if found := _in_process() or os.environ.get(VARIABLE):
        return found
    if BUNDLED.is_file():
        return str(BUNDLED)
    of_system = ctypes.util.find_library("OpenImageDenoise")
    return of_system if of_system == NAME else None


def load() -> bool:
    """Load the library, once. False if there is none or if it does not work; `reason` says why."""
    if denoiser_version():
        return True
    if _reasons:
        return False
    file = library_file()
    try:
        if file is None:
            raise RuntimeError("Open Image Denoise 2 was not found")
        load_denoiser(file)
    except RuntimeError as error:
        _reasons.append(str(error))
        return False
    return True


def reason() -> str:
    """Why `load` failed; "" if it did not."""
    return "".join(_reasons)


def quality_for(rays: float, pixels: int, free_seconds: float = FREE_SECONDS) -> DenoiseQuality:
    """The best quality that takes at most a tenth of a render with this number of rays, or, except High, `free_seconds` of a core. The picture has direct light apart."""
    return denoise_quality_for(rays, pixels, free_seconds, True)


def pixels_of(halves: np.ndarray | None, image: np.ndarray) -> int:
    """The number of pixels for `quality_for`: those of the image times the techniques of the pass "Halves", because each is denoised apart."""
    techniques = max(1, halves.shape[2] // 6) if halves is not None else 1
    return techniques * image.shape[0] * image.shape[1]


def biased_of(statistics: dict) -> list[bool]:
    """The argument `biased` of `ajar.denoise`, from the statistics of a render: of each of its techniques; empty if there is one."""
    return [technique["bias"] != "unbiased" for technique in statistics.get("techniques", ())]
