"""Ajar without Blender: describe a scene, or load one, and render it.

    import ajar
    description = ajar.load_description("room.ajar")
    session = ajar.Session()
    session.start(description)
    while not session.wait(0.5):
        print(session.progress())
    ajar.write_image("room.exr", session.snapshot("Combined"))
"""

from __future__ import annotations

from pathlib import Path as _Path

from .processor import prepare as _prepare

__path__ = [str(_prepare(_Path(__file__).parent)), *__path__]

from . import denoiser  # noqa: F401
from ._ajar import *  # noqa: F403
from ._ajar import __doc__ as _doc, __version__  # noqa: F401
