"""Progress of a render for the artist: the noise over time and the samples of each pixel.

The render thread stores plain numbers here (`note`) and reads no data of Blender. Panels draw the latest numbers in the main thread. A timer redraws
the areas that show the panel when there are new numbers. While no panel is visible, the render thread does not query the session until the render
ends. In background mode nothing is stored.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from . import graph
from .ajar_module import ajar
from .translations import interface

NOTE_SECONDS = 0.5            # between two notes of a render
LOOK_SECONDS = 0.25           # between two calls of the timer
DENSITY_SIDE = 256            # maximum side of the map in pixels
FEW_SAMPLES = 2.0             # estimates from fewer samples miss rare bright samples


@dataclass(frozen=True)
class Density:
    means: np.ndarray         # [height, width], at most DENSITY_SIDE each
    least: float              # minimum over the pixels
    mean: float
    most: float


@dataclass(frozen=True)
class Noted:
    """The state of a render at one time. It is replaced as a whole, so that a reader in another thread gets a consistent state."""

    number: int               # number of the note; a drawing with a smaller number is out of date
    seconds: np.ndarray       # times of the estimates of the error
    noise: np.ndarray         # as a fraction of the brightness
    target: float             # noise at which the render ends; 0: none
    samples: float
    remaining_seconds: float  # negative: not known
    is_running: bool
    density: Density | None


_noted: dict[str, Noted] = {}          # by the name of the scene
_count = 0
_next_note = 0.0
_areas: dict[int, int] = {}            # areas that show a panel -> number of the note that was drawn
_density_is_shown = False


# ---- The render thread --------------------------------------------------------------------------------------------------

def begin(scene_name: str) -> None:
    """Called at the start of a render, so that the panel does not show the previous one."""
    global _next_note
    _next_note = 0.0
    if not bpy.app.background:
        _put(scene_name, np.empty(0), np.empty(0), 0.0, 0.0, -1.0, True, None)


def note(scene_name: str, session: ajar.Session, target_relmse: float) -> None:
    """Store the progress in intervals, while a panel is visible."""
    global _next_note
    if bpy.app.background or not _areas or time.monotonic() < _next_note:
        return
    _next_note = time.monotonic() + NOTE_SECONDS
    noted = _noted[scene_name]
    lacks_density = _density_is_shown and noted.density is None
    if lacks_density or session.progress().samples != noted.samples:   # a paused render does not change
        _note(scene_name, session, target_relmse, True)


def end(scene_name: str, session: ajar.Session, target_relmse: float) -> None:
    """Store the final state, which the panel shows until the next render."""
    if not bpy.app.background:
        _note(scene_name, session, target_relmse, False)


def _note(scene_name: str, session: ajar.Session, target_relmse: float, is_running: bool) -> None:
    progress = session.progress()
    errors = session.error_over_time()   # seconds, samples, relMSE, perceptual error
    known = errors[(errors[:, 1] > FEW_SAMPLES) & (errors[:, 2] >= 0.0)]
    _put(scene_name, known[:, 0], np.sqrt(known[:, 2]), max(0.0, target_relmse)**0.5, progress.samples, progress.remaining_seconds if is_running else 0.0,
         is_running, density_of(session) if _density_is_shown and _areas else None)


def _put(scene_name: str, *values: Any) -> None:
    global _count
    _count += 1
    _noted[scene_name] = Noted(_count, *values)


def density_of(session: ajar.Session) -> Density | None:
    """The sample density. None until an iteration has ended after the first request."""
    counts = session.snapshot("Sample Count")
    if counts is None:
        return None
    counts = counts[..., 0]
    return Density(graph.shrunk(counts, DENSITY_SIDE), float(counts.min()), float(counts.mean(dtype=np.float64)), float(counts.max()))


# ---- Texts --------------------------------------------------------------------------------------------------------------

def noise_words(noise: float, target: float) -> str:
    """The noise and the target as text. Both are fractions of the brightness; target 0: none."""
    if target > 0.0:
        return interface("{percent} % of {target} %", percent=_percent(noise), target=_percent(target))
    return interface("{percent} %", percent=_percent(noise))


def _percent(part: float) -> str:
    """Two digits, without an exponent."""
    return f"{100.0 * part:.2g}" if part < 0.995 else f"{100.0 * part:.0f}"


def clock(seconds: float) -> str:
    minutes, seconds = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{seconds:02}" if minutes >= 60 else f"{minutes:02}:{seconds:02}"


# ---- The main thread ----------------------------------------------------------------------------------------------------

def of(scene: bpy.types.Scene) -> Noted | None:
    return _noted.get(scene.name)


def show_in(area: bpy.types.Area, scene: bpy.types.Scene) -> Noted | None:
    """Called by a panel while it is drawn. Returns the data to show. The area is redrawn when there are new data."""
    global _density_is_shown
    noted = of(scene)
    _density_is_shown = scene.ajar.show_sample_density
    if area is not None and not bpy.app.background:
        _areas[area.as_pointer()] = _count
        if not bpy.app.timers.is_registered(_look):
            bpy.app.timers.register(_look, first_interval=LOOK_SECONDS)
    return noted


def _look() -> float | None:
    """Redraw the areas that do not show the newest note. An area that draws the panel again is registered again; others are removed."""
    shown = {area.as_pointer(): area for window in bpy.context.window_manager.windows for area in window.screen.areas}
    for pointer, count in list(_areas.items()):
        if pointer not in shown:
            del _areas[pointer]
        elif count < _count:
            del _areas[pointer]
            shown[pointer].tag_redraw()
    return LOOK_SECONDS if _areas else None
