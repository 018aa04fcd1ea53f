"""The photons of the last pass as points in the 3D view (as in figures 4.2 and 4.4 of Fan's thesis).

While `show_photons` is off, no photons are read from the renderer. A point has the colour of its photon; its brightness is the flux relative to the
strongest photons.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from . import compat
from .ajar_module import ajar
from .translations import interface

INTEGRATORS = {"photon_map", "mps"}
MAX_PHOTONS = 50_000          # drawn; a larger number is reduced evenly over space
POINT_SIZE = 2.5
FAINTEST = 0.5                # brightness of a photon without flux, so that its position is visible

_handles: list[object] = []


@dataclass
class Photons:
    positions: np.ndarray     # [n, 3]
    colors: np.ndarray        # [n, 4], as drawn
    stored: int               # number of photons in the last pass
    batch: Any = None         # of `gpu`, created at the first drawing


_photons: dict[str, Photons] = {}   # by the name of the scene


def remember(scene: bpy.types.Scene, session: ajar.Session) -> None:
    """Store the present photons of the session if the overlay is on."""
    if not scene.ajar.show_photons:
        return
    positions, powers, stored = session.photons(MAX_PHOTONS)
    if stored > 0:
        _photons[scene.name] = Photons(positions, _colors(powers), stored)
    elif session.progress().iteration > 0 and session.wait(0.0):
        _photons.pop(scene.name, None)   # the render has ended without photons


def of(scene: bpy.types.Scene) -> Photons | None:
    return _photons.get(scene.name) if scene.ajar.show_photons else None


def forget(scene_name: str) -> None:
    _photons.pop(scene_name, None)


def status_of(scene: bpy.types.Scene) -> str:
    photons = of(scene)
    if photons is None:
        return interface("Shown after the next render")
    shown = len(photons.positions)
    if shown < photons.stored:
        return interface("{shown:,} of {stored:,} photons", shown=shown, stored=photons.stored)
    return interface("{number:,} photons", number=shown)


def _colors(powers: np.ndarray) -> np.ndarray:
    strongest = powers.max(axis=1, initial=0.0)
    colors = np.ones((len(powers), 4), dtype=np.float32)
    hue = powers / np.maximum(strongest, 1e-30)[:, None]
    # A few photons are much stronger than the others, so that the scale ends at the 95th percentile.
    worth = strongest / max(float(np.quantile(strongest, 0.95)) if len(powers) else 0.0, 1e-30)
    colors[:, :3] = np.sqrt(np.clip(hue, 0.0, 1.0)) * np.clip(np.sqrt(worth), FAINTEST, 1.0)[:, None]
    return colors


def _draw() -> None:
    context = bpy.context
    if context.engine != "AJAR" or not context.space_data.overlay.show_overlays:
        return
    photons = of(context.scene)
    if photons is None:
        return
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin(compat.POINT_SHADER)
    if photons.batch is None:
        photons.batch = batch_for_shader(shader, "POINTS", {"pos": photons.positions, "color": photons.colors})
    gpu.state.point_size_set(POINT_SIZE * context.preferences.system.ui_scale)
    gpu.state.depth_test_set("LESS_EQUAL")
    shader.bind()
    photons.batch.draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.point_size_set(1.0)


def register() -> None:
    if not bpy.app.background:
        _handles.append(bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW"))


def unregister() -> None:
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    _photons.clear()
