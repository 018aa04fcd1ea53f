"""Denoising by the C interface of Open Image Denoise, which official Blender has in its process.

The denoised image is an estimate of the image without noise. It is biased, off by default, and not part of published measurements. The albedo and the
normals of the first surface guide the denoiser; they are denoised first (prefiltered). Where Blender does not have the library, or does not export
its functions, `AJAR_OT_denoise_in_compositor` adds the Denoise node to the compositor.
"""

from __future__ import annotations

import ctypes
import threading
import time
from pathlib import Path

import bpy
import numpy as np

from . import compat, passes
from .translations import report

GUIDES = (passes.OWN["use_pass_albedo"], passes.BUILT_IN["use_pass_normal"])
CALIBRATION_SIDE = 256   # pixels
_CPU, _FLOAT3 = 1, 3      # OIDN_DEVICE_TYPE_CPU, OIDN_FORMAT_FLOAT3
_HANDLE, _SIZE, _TEXT = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_char_p
_SIGNATURES = {
    "oidnNewDevice": (_HANDLE, [ctypes.c_int]), "oidnCommitDevice": (None, [_HANDLE]), "oidnReleaseDevice": (None, [_HANDLE]),
    "oidnGetDeviceError": (ctypes.c_int, [_HANDLE, ctypes.POINTER(_TEXT)]),
    "oidnNewFilter": (_HANDLE, [_HANDLE, _TEXT]), "oidnCommitFilter": (None, [_HANDLE]), "oidnExecuteFilter": (None, [_HANDLE]),
    "oidnReleaseFilter": (None, [_HANDLE]), "oidnSetFilterBool": (None, [_HANDLE, _TEXT, ctypes.c_bool]),
    "oidnSetSharedFilterImage": (None, [_HANDLE, _TEXT, _HANDLE, ctypes.c_int, _SIZE, _SIZE, _SIZE, _SIZE, _SIZE]),
}


class DenoisingFailed(RuntimeError):
    """The message is that of the library."""


def library_file() -> Path | None:
    """The file of Open Image Denoise 2 that Blender has loaded, or None."""
    for line in Path("/proc/self/maps").read_text(encoding="utf-8", errors="replace").splitlines():
        path = line.split(None, 5)[-1]
        if Path(path).name.startswith("libOpenImageDenoise.so.2"):
            return Path(path)
    return None


def is_available() -> bool:
    return _library() is not None


_loaded: list[ctypes.CDLL | None] = []


def _library() -> ctypes.CDLL | None:
    if not _loaded:
        file = library_file()
        library = ctypes.CDLL(str(file)) if file is not None else None
        for name, (result, arguments) in _SIGNATURES.items() if library is not None else ():
            function = getattr(library, name)
            function.restype, function.argtypes = result, arguments
        _loaded.append(library)
    return _loaded[0]


_seconds_per_pixel = 0.0   # of the last call; 0: not known


def expected_seconds(pixels: int) -> float:
    """The expected time to denoise an image. The first call denoises a small image to measure it."""
    if _seconds_per_pixel == 0.0:
        side = np.zeros((CALIBRATION_SIDE, CALIBRATION_SIDE, 3), dtype=np.float32)
        denoised(side, side, side)
    return pixels * _seconds_per_pixel


def denoised(color: np.ndarray, albedo: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Denoise `color`, linear [height, width, 3 or 4]; a fourth channel is not changed. The guides have three channels."""
    global _seconds_per_pixel
    started = time.monotonic()
    library = _library()
    assert library is not None   # checked by is_available()
    device = library.oidnNewDevice(_CPU)
    try:
        library.oidnCommitDevice(device)
        guides = {"albedo": _packed(albedo), "normal": _packed(normal)}
        for name, values in guides.items():
            _run(library, device, {name: values}, values)
        result = np.array(color, dtype=np.float32)
        image = _packed(color)
        _run(library, device, {"color": image, **guides}, image, hdr=True, cleanAux=True)
        result[..., :3] = image
        _seconds_per_pixel = (time.monotonic() - started) / (color.shape[0] * color.shape[1])
        return result
    finally:
        library.oidnReleaseDevice(device)


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
            except DenoisingFailed as error:
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


def _packed(values: np.ndarray) -> np.ndarray:
    """A contiguous copy of the first three channels."""
    return np.array(values[..., :3], dtype=np.float32, order="C")


def _run(library: ctypes.CDLL, device: int, inputs: dict[str, np.ndarray], output: np.ndarray, **options: bool) -> None:
    """Run one filter for ray traced images. `output` may be one of the inputs."""
    filter_ = library.oidnNewFilter(device, b"RT")
    try:
        for name, values in {**inputs, "output": output}.items():
            height, width, _ = values.shape
            library.oidnSetSharedFilterImage(filter_, name.encode(), values.ctypes.data, _FLOAT3, width, height, 0, 0, 0)
        for name, value in options.items():
            library.oidnSetFilterBool(filter_, name.encode(), value)
        library.oidnCommitFilter(filter_)
        library.oidnExecuteFilter(filter_)
    finally:
        library.oidnReleaseFilter(filter_)
    message = _TEXT()
    if library.oidnGetDeviceError(device, ctypes.byref(message)) != 0:
        raise DenoisingFailed(f"Open Image Denoise: {(message.value or b'unknown error').decode()}")


class AJAR_OT_denoise_in_compositor(bpy.types.Operator):
    bl_idname = "ajar.denoise_in_compositor"
    bl_label = "Denoise in Compositor"
    bl_description = "Turn on the passes that guide denoising, and put a Denoise node before the compositor's output"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        layer = context.view_layer
        layer.use_pass_normal = layer.ajar.use_pass_albedo = True
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
            tree.links.new(layers.outputs[name], node.inputs[name])
        tree.links.new(node.outputs["Image"], target)
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(AJAR_OT_denoise_in_compositor)


def unregister() -> None:
    bpy.utils.unregister_class(AJAR_OT_denoise_in_compositor)
