"""Ctrl-C and SIGTERM in background mode stop the sampling and keep the image.

Blender itself would discard the image. During a render, this module handles the signals: Blender writes the image as usual and then ends.
"""

from __future__ import annotations

import signal
import threading
from typing import Any

import bpy

from . import headless

EXIT_INTERRUPTED = 130  # the convention of shells: 128 + SIGINT


class Interrupt:
    """Handles the signals inside its `with` block. Otherwise, and in Blender with windows, Blender handles them."""

    def __init__(self) -> None:
        self.raised = False
        self._previous: dict[int, Any] = {}

    def __enter__(self) -> Interrupt:
        if bpy.app.background and threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                self._previous[number] = signal.signal(number, self._raise)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._previous.items():
            # None: a handler that was not installed by Python, which Python cannot restore.
            signal.signal(number, handler if handler is not None else signal.SIG_DFL)

    def _raise(self, *_: object) -> None:
        self.raised = True

    @staticmethod
    def leave_after_writing() -> None:
        """End Blender after the image was written, before the next frame."""
        bpy.app.handlers.render_write.append(lambda *_: headless.leave(EXIT_INTERRUPTED))
