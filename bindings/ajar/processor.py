"""Chooses the compiled module for this processor: an extension contains one for each supported level of x86-64."""

from __future__ import annotations

import os
from pathlib import Path

from .system import LEVELS, processor_flags, use_libraries_of

VARIABLE = "AJAR_INSTRUCTION_SET"


def choose(available: set[str], flags: set[str], wanted: str | None = None) -> str:
    """Returns the best of the `available` levels for a processor with `flags`, or `wanted`. Raises ImportError if there is none."""
    runs, missing = [], set()
    for level in reversed(LEVELS):
        missing |= LEVELS[level] - flags
        if missing:
            break
        runs.insert(0, level)
    if wanted:
        if wanted not in available or wanted not in runs:
            raise ImportError(f"{VARIABLE}={wanted}: there are {', '.join(sorted(available))}, and this processor runs {', '.join(runs) or 'none'}")
        return wanted
    for level in runs:
        if level in available:
            return level
    raise ImportError(f"Ajar needs a processor with x86-64-v2 (made since 2009); this one lacks {', '.join(sorted(missing))}")


def folder_of(package: Path) -> Path:
    """Returns the folder of the compiled module: the package itself if it was built for one machine."""
    available = {level for level in LEVELS if (package / level).is_dir()}
    return package / choose(available, processor_flags(), os.environ.get(VARIABLE)) if available else package


def prepare(package: Path) -> Path:
    """Returns the folder of the compiled module, which can be imported from now on."""
    use_libraries_of(package / "lib")
    return folder_of(package)
