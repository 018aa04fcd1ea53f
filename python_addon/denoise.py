"""Denoising by Open Image Denoise, which the core loads (ajar/denoiser.py): Blender's own copy, the bundled one or that of the system.

The final image is combined with the rendered one, so that it converges to the correct image (core/denoise/denoise.h). The albedo and the normals of
the first rough surface guide the denoiser. Without the library, `AJAR_OT_denoise_in_compositor` adds the Denoise node to the compositor.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Sequence

import bpy
import numpy as np

from . import compat, passes
from .ajar_module import ajar
from .translations import report

NEEDED = (*(guide.name for guide in passes.GUIDES), passes.HALVES, passes.DIRECT_HALVES)   # passes of the core
CALIBRATION_SIDE = 64   # pixels
LEARNED_PIXELS = 128**2  # of an image whose time tells that of others
_seconds_per_pixel: dict[tuple[ajar.DenoiseQuality, int], float] = {}   # by quality and threads


def is_available() -> bool:
    return ajar.denoiser.load()


def _cores(threads: int) -> int:
    """`threads`, where 0 means all."""
    return threads or os.cpu_count() or 1


def quality_within(pixels: int, limit: float, threads: int) -> ajar.DenoiseQuality:
    """The quality for a render whose time limit in seconds includes denoising: a better one would take more from the samples than it gives."""
    return ajar.denoiser.quality_for(_cores(threads) * limit / ajar.denoiser.SECONDS_PER_RAY, pixels, 0.0)


def expected_seconds(pixels: int, quality: ajar.DenoiseQuality, threads: int) -> float:
    """The expected time to denoise an image: that of earlier images in this process. Before the first one, small noisy images are denoised to measure it."""
    threads = _cores(threads)
    if (quality, threads) not in _seconds_per_pixel:
        noise = np.random.default_rng(1).random((CALIBRATION_SIDE, CALIBRATION_SIDE, 6), dtype=np.float32)

        def seconds_of(side: int) -> float:
            image = np.ascontiguousarray(noise[:side, :side])
            started = time.monotonic()
            ajar.denoise(image[..., :3], image, image[..., :3], image[..., :3], quality, threads, direct_halves=0.5 * image)
            return time.monotonic() - started
        small = CALIBRATION_SIDE // 4
        seconds_of(small)   # starts the library's threads
        fixed = seconds_of(small)
        _seconds_per_pixel[quality, threads] = max(0.0, seconds_of(CALIBRATION_SIDE) - fixed) / (CALIBRATION_SIDE**2 - small**2)
    return pixels * _seconds_per_pixel[quality, threads]


class Background:
    """Denoises one image in its own thread."""

    def __init__(self, pictures: dict[str, np.ndarray], quality: ajar.DenoiseQuality, threads: int = 0, biased: Sequence[bool] = (), exposure: float = 1.0,
                 needs_error: bool = False) -> None:
        """Start to denoise the pass Combined of `pictures`, [height, width, 4]; its alpha is not changed. With the passes `NEEDED`, the result is
        consistent. `biased`: of each technique that has rendered the picture. `exposure`: light times this is displayed. `needs_error`: also with the qualities that estimate no error."""
        self._cancellation = ajar.Cancellation()
        self._result: tuple[np.ndarray, np.ndarray | None] | None = None
        self._error = ""
        self._thread = threading.Thread(target=self._work, args=(pictures, quality, threads, list(biased), exposure, needs_error), daemon=True)
        self._thread.start()

    def _work(self, pictures: dict[str, np.ndarray], quality: ajar.DenoiseQuality, threads: int, biased: list[bool], exposure: float, needs_error: bool) -> None:
        color = pictures[passes.COMBINED.name]
        albedo, normal, halves, direct_halves = (pictures.get(name) for name in NEEDED)
        started, pixels = time.monotonic(), color.shape[0] * color.shape[1]
        try:
            self._result = ajar.denoise(color, halves, albedo, normal, quality, threads, self._cancellation, direct_halves, biased, exposure, needs_error)
            if self._result is not None and pixels >= LEARNED_PIXELS:
                _seconds_per_pixel[quality, _cores(threads)] = (time.monotonic() - started) / pixels
        except RuntimeError as error:
            self._error = str(error)

    def wait(self, seconds: float) -> bool:
        """Whether it ends in this time."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def cancel(self) -> None:
        """Stop soon. Does not wait; the result is None."""
        self._cancellation.set()

    def result(self) -> tuple[np.ndarray, np.ndarray | None] | None:
        """The image, and the estimated relMSE of its pixels if it was estimated; None if denoising was cancelled. Waits for the end. Raises RuntimeError if the library failed."""
        self._thread.join()
        if self._error:
            raise RuntimeError(self._error)
        return self._result


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
