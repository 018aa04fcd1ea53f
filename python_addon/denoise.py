"""Denoising by Open Image Denoise, which the core loads (ajar/denoiser.py): Blender's own copy, the bundled one or that of the system.

The final image is combined with the rendered one, so that it converges to the correct image (core/denoise/denoise.h). The albedo and the normals of
the first rough surface guide the denoiser. Without the library, `AJAR_OT_denoise_in_compositor` adds the Denoise node to the compositor.
"""

from __future__ import annotations

import threading
import time

import bpy
import numpy as np

from . import compat, passes
from .ajar_module import ajar
from .translations import report

GUIDES = passes.GUIDES
HALVES = "Halves"        # the pass of the core that the combination needs
CALIBRATION_SIDE = 256   # pixels


def is_available() -> bool:
    return ajar.denoiser.load()


_seconds_per_pixel = 0.0   # of the last call; 0: not known


def expected_seconds(pixels: int) -> float:
    """The expected time to denoise an image. The first call denoises a small image to measure it."""
    if _seconds_per_pixel == 0.0:
        side = np.zeros((CALIBRATION_SIDE, CALIBRATION_SIDE, 6), dtype=np.float32)
        denoised(side[..., :3], side[..., :3], side[..., :3], side)
    return pixels * _seconds_per_pixel


def denoised(color: np.ndarray, albedo: np.ndarray | None, normal: np.ndarray | None, halves: np.ndarray | None = None) -> np.ndarray:
    """Denoise `color`, linear [height, width, 3 or 4]; a fourth channel is not changed. With `halves` [height, width, 6], the result is consistent.

    Raises RuntimeError if the library fails.
    """
    global _seconds_per_pixel
    started = time.monotonic()
    result = ajar.denoise(color, halves, albedo, normal)
    _seconds_per_pixel = (time.monotonic() - started) / (color.shape[0] * color.shape[1])
    return result


class Background:
    """Denoises one image at a time in its own thread, while the 3D view continues."""

    def __init__(self) -> None:
        self._thread: threading.Thread | None = None
        self._of: object = None
        self._result: np.ndarray | None = None

    def is_busy(self) -> bool:
        """True from `start` until `take`."""
        return self._thread is not None

    def is_ready(self) -> bool:
        return self._thread is not None and not self._thread.is_alive()

    def start(self, of: object, color: np.ndarray, albedo: np.ndarray, normal: np.ndarray) -> None:
        """Start to denoise. `take` returns `of` with the result."""
        def work() -> None:
            try:
                self._result = denoised(color, albedo, normal)
            except RuntimeError as error:
                print(f"Ajar: {error}", flush=True)
                self._result = color
        self._of, self._thread = of, threading.Thread(target=work, daemon=True)
        self._thread.start()

    def take(self) -> tuple[object, np.ndarray | None]:
        assert self._thread is not None   # checked by is_ready() or is_busy()
        self._thread.join()
        self._thread = None
        result, self._result = self._result, None
        return self._of, result


class AJAR_OT_denoise_in_compositor(bpy.types.Operator):
    bl_idname = "ajar.denoise_in_compositor"
    bl_label = "Denoise in Compositor"
    bl_description = "Turn on the passes that guide denoising, and put a Denoise node before the compositor's output"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        layer = context.view_layer
        layer.ajar.use_pass_denoising = True
        tree, target = compat.compositor_output(context.scene)
        if any(link.from_node.bl_idname == "CompositorNodeDenoise" for link in target.links):
            self.report({"INFO"}, report("The compositor denoises already"))
            return {"CANCELLED"}
        layers = next((node for node in tree.nodes if node.bl_idname == "CompositorNodeRLayers"), None) or tree.nodes.new("CompositorNodeRLayers")
        layers.scene, layers.layer = context.scene, layer.name
        source = target.links[0].from_socket if target.links else layers.outputs["Image"]
        node = tree.nodes.new("CompositorNodeDenoise")
        node.location = (layers.location.x + 300.0, layers.location.y)
        tree.links.new(source, node.inputs["Image"])
        for name in ("Albedo", "Normal"):
            tree.links.new(layers.outputs[f"Denoising {name}"], node.inputs[name])
        tree.links.new(node.outputs["Image"], target)
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(AJAR_OT_denoise_in_compositor)


def unregister() -> None:
    bpy.utils.unregister_class(AJAR_OT_denoise_in_compositor)
