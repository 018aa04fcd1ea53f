"""Learned data of the frames of an animation, for the following frames.

The data are kept from the start to the end of a render job, for each view layer and eye. A still image is a job of one frame, so that it starts
without learned data and depends only on the seed.
"""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from . import headless
from .ajar_module import ajar

_learned: dict[tuple[str, str, str], ajar.Learned] = {}


def is_carried(scene: bpy.types.Scene, options: headless.Options) -> bool:
    return scene.ajar.carry_learning if options.carry_learning is None else options.carry_learning


def of(key: tuple[str, str, str]) -> ajar.Learned | None:
    return _learned.get(key)


def remember(key: tuple[str, str, str], learned: ajar.Learned | None) -> None:
    """Store the learned data; None if the render was stopped early."""
    if learned is None:
        _learned.pop(key, None)
    else:
        _learned[key] = learned


@persistent
def _forget(*_) -> None:
    _learned.clear()


HANDLERS = (bpy.app.handlers.render_init, bpy.app.handlers.render_complete, bpy.app.handlers.render_cancel)


def register() -> None:
    for handlers in HANDLERS:
        handlers.append(_forget)


def unregister() -> None:
    _forget()
    for handlers in HANDLERS:
        handlers.remove(_forget)
