"""Ctrl-C and SIGTERM in the background: stop sampling, keep the picture.

Blender itself would throw the picture away. While a render runs we listen instead; what has been rendered is then written as
usual, and Blender ends.
"""

from __future__ import annotations

import signal
import threading
from typing import Any

import bpy

from . import headless

EXIT_INTERRUPTED = 130  # as shells say it: 128 + SIGINT


class Interrupt:
    """Listens inside its `with`; elsewhere, and in Blender with windows, Blender's own handling stands."""

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
            # None: a handler not made by Python, which Python cannot give back.
            signal.signal(number, handler if handler is not None else signal.SIG_DFL)

    def _raise(self, *_: object) -> None:
        self.raised = True

    @staticmethod
    def leave_after_writing() -> None:
        """End Blender when the picture has been written, before a next frame."""
        bpy.app.handlers.render_write.append(lambda *_: headless.leave(EXIT_INTERRUPTED))
