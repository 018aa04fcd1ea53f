"""Measures the time from a change until the rendered view shows the first new pixels.

Arguments: .blend file, repeats, optionally "denoised". The view is that of the scene's camera, but not through it. For each kind of change, the result
has medians in milliseconds, and the least and the largest `total` and `full`:
`total`      until the image is drawn; in a denoised view, the first denoised picture
`full`       until the first picture of the size of the view is drawn, in a denoised view only
`told`       until Blender calls the add-on
`exporting`  for the export
`asked`      until the call of the core
`build`      for the build
`first`      for the first image
`shown`      from the call of the core until the image is drawn
`cpu`        CPU time of all threads

Blender must not be started with --enable-event-simulate: it then ignores the events by which a window is redrawn soon.
"""

from __future__ import annotations

import statistics
import time

import bpy
import window
from ajar_render import viewport
from mathutils import Quaternion

SETTLE_SECONDS = 120.0
views: list[viewport.Viewport] = []
marks: dict[str, float] = {}     # times of events since the last change


def mark(name: str) -> None:
    marks.setdefault(name, time.monotonic())


def wrap(name: str, before: str = "", after: str = "") -> None:
    inner = getattr(viewport.Viewport, name)

    def wrapped(self, *arguments):
        if self not in views:
            views.append(self)
        if before:
            mark(before)
        result = inner(self, *arguments)
        if after:
            mark(after)
        return result
    setattr(viewport.Viewport, name, wrapped)


def watch_uploads() -> None:
    inner = viewport.Viewport._upload

    def upload(self, *arguments):
        shown = self._uploaded
        inner(self, *arguments)
        if self._uploaded != shown and "asked" in marks and self._uploaded[0] >= marks["asked_number"]:
            mark("shown")
            progress = self.session.progress()
            marks.setdefault("build", progress.build_seconds)
            marks.setdefault("first", progress.render_seconds)
    viewport.Viewport._upload = upload
    upload_picture = viewport.Viewport._upload_picture

    def upload_denoised(self, *arguments):
        upload_picture(self, *arguments)
        if "asked" in marks and self._uploaded[0] >= marks["asked_number"] and self._divider == 1:
            mark("full")
    viewport.Viewport._upload_picture = upload_denoised
    ask = viewport.Viewport._render

    def render(self, divider):
        ask(self, divider)
        mark("asked")
        marks.setdefault("asked_number", self._number)
        marks.setdefault("divider", divider)
    viewport.Viewport._render = render


def until(is_true, seconds: float = SETTLE_SECONDS):
    end = time.monotonic() + seconds
    while not is_true() and time.monotonic() < end:
        yield 0.005
    assert is_true(), "too slow"


def is_done() -> bool:
    return bool(views) and not views[-1].is_busy()


def changes():
    scene = bpy.context.scene
    lamp = next(thing for thing in scene.objects if thing.type == "LIGHT")
    meshes = [thing for thing in scene.objects if thing.type == "MESH" and not thing.hide_render]
    thing = min(meshes, key=lambda thing: len(thing.data.polygons))
    material = next(slot.material for mesh in meshes for slot in mesh.material_slots if slot.material and slot.material.use_nodes)
    shader = next(node for node in material.node_tree.nodes if node.inputs and hasattr(node.inputs[0], "default_value"))

    def turn():
        region = window.space().region_3d
        region.view_rotation @= Quaternion((0, 0, 1), 0.01)

    def move():
        thing.location.z += 0.001

    def brighten():
        lamp.data.energy *= 1.01

    def recolour():
        colour = list(shader.inputs[0].default_value)
        shader.inputs[0].default_value = [0.9 * c + 0.05 for c in colour]
    return turn, move, brighten, recolour


def look_from_camera() -> None:
    """The view of the camera, as it is after the artist has left it."""
    region, camera = window.space().region_3d, bpy.context.scene.camera
    region.view_perspective = "PERSP"
    region.view_matrix = camera.matrix_world.inverted()
    window.space().lens = camera.data.lens


def steps(arguments, result):
    is_denoised = arguments[2:] == ["denoised"]
    wrap("update", "told", "exported")
    watch_uploads()
    bpy.ops.wm.open_mainfile(filepath=arguments[0], load_ui=False)
    scene = bpy.context.scene
    scene.render.engine = "AJAR"
    scene.ajar.viewport_samples, scene.ajar.use_viewport_denoise = 4, is_denoised
    window.space().overlay.show_overlays = False   # Blender draws their depth, which is slow without a graphics card
    yield 0.5
    look_from_camera()
    window.shade("RENDERED")
    yield from until(is_done)
    result["region"] = list(views[-1].view.size)
    for change in changes():
        rows = []
        for _ in range(int(arguments[1])):
            yield from until(is_done)
            yield 0.1
            marks.clear()
            started, cpu = time.monotonic(), time.process_time()
            change()
            yield 0.0
            yield from until(lambda: "shown" in marks and ("full" in marks or not is_denoised))
            row = {"total": marks["shown"] - started, "asked": marks["asked"] - started, "shown": marks["shown"] - marks["asked"],
                   "cpu": time.process_time() - cpu, "divider": marks["divider"] / 1000}   # not a time: pixels of the view per pixel of the first image, along a side
            if "told" in marks:
                row |= {"told": marks["told"] - started, "exporting": marks["exported"] - marks["told"]}
            row |= {"build": marks["build"], "first": marks["first"]}
            if is_denoised:
                row["full"] = marks["full"] - started
            rows.append(row)
        result[change.__name__] = {name: round(1000 * statistics.median(row[name] for row in rows), 1) for name in rows[0]}
        for name in ("total", "full") if is_denoised else ("total",):
            result[change.__name__] |= {f"{name}_{word}": round(1000 * choose(row[name] for row in rows), 1) for word, choose in (("least", min), ("most", max))}
        print(change.__name__, result[change.__name__], flush=True)
