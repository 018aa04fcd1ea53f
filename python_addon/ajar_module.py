"""The compiled renderer as `ajar`: the copy inside the installed add-on, or else the one on Python's path (for development)."""

from __future__ import annotations

from pathlib import Path

if (Path(__file__).parent / "ajar").is_dir():
    from . import ajar
else:
    import ajar

__all__ = ["ajar"]
