"""The rendered 3D view. Each view has a session, which a timer polls. The image is drawn as a texture.

`draw` receives changes of the camera, `update` receives edits. Both request a new image from the session: first a coarse one that takes about
FIRST_SECONDS, then finer ones, then more samples. In a sequence of changes, the latest one is rendered as soon as an image of an earlier one can be
shown, so that a moving view is always updated. A denoised view gets its pictures, from coarse to fine, from the session itself
(`Session.show_pictures`). Changes of the camera build nothing. Edits export and build only what has changed, see
`export/known_objects.py`, `export/mesh_cache.py` and `Session.update`.
"""

from __future__ import annotations

import copy
import json
import time
import weakref
from typing import Any

import bpy
import numpy as np
from bpy.app.handlers import persistent

from . import denoise, graph, hints, pausing, photon_overlay, view
from .ajar_module import ajar
from .export import ExportContext, KnownObjects, MeshCache, OutOfDate, culling, export_contents, settings
from .headless import Options

POLL_SECONDS = 0.01
FIRST_SECONDS = 0.03          # maximum time of the first image after a change
QUICK_SECONDS = 0.2           # a full image that takes no longer is rendered directly after it
PATIENCE_SECONDS = 0.25       # maximum time that a change waits for the image of the previous change
CLEAN_PATIENCE_SECONDS = 0.6  # the same in a denoised view
COARSEST = 16
LARGEST_HALF = 65504.0        # maximum value of half floats
DISPLAY_GAMMA = 2.2           # of the colours of the sample density, which are drawn like an image

_undo_count = 0


class Viewport:
    """The image of one 3D view. It exists as long as the engine object of Blender for this view."""

    def __init__(self) -> None:
        self.session = ajar.Session()
        self.meshes = MeshCache()
        self.known = KnownObjects()
        self.view: view.View | None = None             # view of the image that is rendered
        self.updates = self.moves = 0                  # numbers of requests to the session, for tests
        self._settings: ajar.RenderSettings | None = None   # of the scene
        self._fingerprint: int | None = None
        self._description: ajar.SceneDescription | None = None   # waiting to be rendered
        self._wanted_view: view.View | None = None               # waiting to be rendered
        self._undo_count = _undo_count
        self._number = 0                               # number of the current render
        self._divider = 1                              # pixels of the view for one of the image, along a side
        self._asked = 0.0
        self._pauses = False                           # the user has paused the render, and an image is shown
        self._rate = 1e6                               # pixels per second with one sample each
        self._uploaded = (0, 0)                        # render and iteration that the texture shows
        self._denoises = False                         # enabled and possible
        self._picture: ajar.ViewPicture | None = None  # denoised, not shown yet
        self._clean: np.ndarray | None = None          # pixels of the latest denoised picture of the current render
        self._not_denoised = ""                        # why the pictures are not denoised although the user wants it
        self._counted = (0, 0)                         # render and iteration whose sample density the texture shows
        self._hints_of = -1                            # number of the update whose attached hints are shown
        self._shows_density = False                    # shows the sample density instead of the image
        self._texture: Any = None                      # of `gpu`, created at the first drawing
        self._texture_border = (0, 0, 0, 0)
        self._error = ""
        self._hint_points: dict[str, np.ndarray] = {}

    # ---- Calls by Blender ------------------------------------------------------------------------------------------------

    def update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Called when the scene may have changed."""
        if self._undo_count != _undo_count:
            self._undo_count = _undo_count
            self.meshes.clear()
            self.known.forget()
        self.meshes.forget(depsgraph)
        is_hidden = _hidden_in(context.space_data)
        culls = view.of(context.region, context.region_data, context.space_data, depsgraph) if culling.is_wanted(depsgraph.scene) else None
        revisions = self.known.changed(depsgraph) if is_hidden is None and culls is None else None
        if revisions is not None:
            try:
                description = self._export(depsgraph, None, revisions)
            except (OutOfDate, ReferenceError):
                revisions = None
        if revisions is None:
            description = self._export(depsgraph, is_hidden, None, culls)
        wanted = _for_view(description.settings, depsgraph.scene)
        asks_to_denoise = depsgraph.scene.ajar.use_viewport_denoise
        denoises = asks_to_denoise and denoise.is_available()
        self._not_denoised = ajar.denoiser.reason() if asks_to_denoise and not denoises else ""
        is_switched = denoises != self._denoises
        self._denoises = denoises
        fingerprint = description.fingerprint()
        if fingerprint != self._fingerprint:
            self._fingerprint, self._settings = fingerprint, wanted
            self._description = description
        elif is_switched or _with_exposure_of(wanted, self._settings) != self._settings:
            self._settings = wanted
            self._wanted_view = self._wanted_view or self.view
        self._proceed()

    def _export(self, depsgraph: bpy.types.Depsgraph, is_hidden, revisions: list[bpy.types.Object] | None, culls: view.View | None = None) -> ajar.SceneDescription:
        """Export the scene. With `revisions`, only these objects are exported again. `culls`: the view whose camera leaves out objects."""
        exported = ExportContext(depsgraph, lambda: False, lambda step: None, self.meshes, is_hidden)
        exported.known, exported.revisions, exported.is_view = self.known, revisions, True
        if culls is not None:
            exported.description.camera = culls.camera()
        settings.export(exported, Options(), ["Combined"])
        if revisions is None:
            self.meshes.begin()
        export_contents(exported)
        if revisions is None:
            self.meshes.finish()
        exported.description.camera = ajar.CameraDescription()   # that of the image is set when it is rendered
        return exported.description

    def draw(self, engine: bpy.types.RenderEngine, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        now = view.of(context.region, context.region_data, context.space_data, depsgraph)
        if now is not None and now != (self._wanted_view or self.view):
            self._wanted_view = now
        self._proceed()
        self._choose_pass(context.space_data.shading.ajar.show_sample_density)
        self._upload(depsgraph.scene)
        self._proceed()  # a finer image may follow
        if self._texture is not None:
            self._draw_texture(engine, depsgraph.scene)
        engine.update_stats("", self.status())

    # ---- Control of the session --------------------------------------------------------------------------------------------

    def is_busy(self) -> bool:
        waits = self._wanted_view is not None or self._description is not None
        coarse = self._divider > 1 and self.session.progress().phase != ajar.Progress.Phase.Failed
        return waits or coarse or self._picture is not None or not (self.session.wait(0.0) or self._is_paused())

    def poll(self) -> bool:
        """Continue. Returns True if there is a new image to draw."""
        self._proceed()
        self._take_picture()
        if self._picture is not None:
            return True
        if self._denoises and not self._shows_density:
            return False
        progress = self.session.progress()
        return (progress.render, progress.iteration) > (self._counted if self._shows_density else self._uploaded) and progress.iteration > 0

    def _proceed(self) -> None:
        """Start the waiting change if it is time for it, or the next finer image."""
        if self._settings is None:
            return
        progress = self.session.progress()
        shown = progress.render == self._number and progress.iteration > 0
        if self._denoises:
            shown = self._uploaded[0] == self._number
        elif shown and progress.render_seconds > 0.0 and self.view is not None:
            self._rate = max(1.0, self.view.pixels() / self._divider**2 * progress.samples / progress.render_seconds)
        if self._description is not None or self._wanted_view is not None:
            target = self._wanted_view or self.view
            impatient = time.monotonic() - self._asked > (CLEAN_PATIENCE_SECONDS if self._denoises else PATIENCE_SECONDS)
            if target is not None and (shown or impatient or self.session.wait(0.0)):
                self.view, self._wanted_view = target, None
                self._render(1 if self._denoises else self._first_divider())
        elif shown and self._divider > 1 and not self._denoises and self._uploaded[0] == self._number:
            # The full image directly if it is fast, otherwise in steps.
            quick = self.view.pixels() / self._rate < QUICK_SECONDS
            self._render(1 if quick else self._divider // 2)
        # A paused view first shows the full image of an edit.
        self._pauses = pausing.is_wanted_in_views() and self._divider == 1
        self.session.pause(self._pauses)

    def _is_paused(self) -> bool:
        """Whether the user has paused the render, and it has stopped."""
        return self._pauses and self.session.is_paused()

    def _first_divider(self) -> int:
        divider = 1
        while divider < COARSEST and self.view.pixels() / divider**2 / self._rate > FIRST_SECONDS:
            divider *= 2
        return divider

    def _render(self, divider: int) -> None:
        self._picture = self._clean = None
        self.session.show_pictures(self._denoises)
        wanted = copy.copy(self._settings)
        (wanted.width, wanted.height), wanted.region = self.view.resolution(divider)
        camera = self.view.camera()
        if self._description is not None:
            description, self._description = self._description, None
            self._hint_points = hints.points_of(description)
            description.camera, description.settings = camera, wanted
            self._number = self.session.update(description)
            self.updates += 1
        else:
            self._number = self.session.change_view(camera, wanted)
            self.moves += 1
        # The first picture of a denoised view is coarse.
        self._divider, self._asked = COARSEST if self._denoises else divider, time.monotonic()

    def _take_picture(self) -> None:
        """Take the newest denoised picture of the current render."""
        found = self.session.take_picture()
        if found is not None and found.render == self._number:
            self._picture = found

    # ---- Drawing --------------------------------------------------------------------------------------------------------------

    def status(self) -> str:
        return " | Not denoised: ".join(filter(None, (self._progress(), self._not_denoised)))

    def _progress(self) -> str:
        error = self.session.take_error()
        progress = self.session.progress()
        if error:
            self._error = error
        elif progress.iteration > 0:
            self._error = ""
        if self._error:
            return f"Ajar: {self._error}"
        if progress.phase == ajar.Progress.Phase.Building:
            return f"Building: {progress.step}"
        if progress.phase == ajar.Progress.Phase.Done and self._divider == 1:
            return f"Rendering done | {progress.samples:.0f} samples"
        if self._is_paused():
            return f"Paused | {progress.samples:.0f} samples"
        return f"Sample {progress.samples:.0f} of {self._settings.samples}" if self._settings else ""

    def statistics(self) -> dict:
        return json.loads(self.session.statistics_json())

    def _choose_pass(self, shows_density: bool) -> None:
        """Show the image or the sample density of the current render."""
        if shows_density != self._shows_density:
            self._shows_density = shows_density
            self._counted = (0, 0)
            if not self._denoises:
                self._uploaded = (0, 0)
            elif self._clean is not None and not shows_density:
                self._show(self._clean, self._divider)

    def _upload(self, scene: bpy.types.Scene) -> None:
        """Upload the newest image to the texture. It must be called during drawing, since `gpu` needs a window."""
        self._take_picture()
        if self._picture is not None:
            self._upload_picture(scene)
        progress = self.session.progress()
        state = (progress.render, progress.iteration)
        if progress.render != self._number or progress.iteration == 0:
            return
        if self._shows_density and state != self._counted:
            self._upload_density(state)
        elif not self._shows_density and not self._denoises and state != self._uploaded:
            pixels = self.session.snapshot("Combined")
            if pixels is None:
                return
            self._uploaded = state
            self._show(pixels, self._divider)
            self._remember(scene)

    def _upload_picture(self, scene: bpy.types.Scene) -> None:
        """Upload the denoised picture that waits."""
        picture, self._picture = self._picture, None
        if picture.not_denoised not in ("", self._not_denoised):
            print(f"Ajar: {picture.not_denoised}", flush=True)
        self._not_denoised = picture.not_denoised
        self._uploaded, self._divider, self._clean = (picture.render, picture.iteration), picture.divider, picture.take_pixels()
        if not self._shows_density:
            self._show(self._clean, self._divider)
        self._remember(scene)

    def _upload_density(self, state: tuple[int, int]) -> None:
        """Upload the sample density. That of a denoised view is the one of the full image."""
        counts = self.session.snapshot("Sample Count")
        divider = 1 if self._denoises else self._divider
        _, (x0, y0, x1, y1) = self.view.resolution(divider)
        if counts is None or counts.shape[:2] != (y1 - y0, x1 - x0):   # it is available after a later iteration
            return
        self._counted = state
        if not self._denoises:
            self._uploaded = state
        self._show(graph.density(counts[..., 0])**DISPLAY_GAMMA, divider)

    def _remember(self, scene: bpy.types.Scene) -> None:
        """Keep the hints and the photons of the render for their overlays."""
        if self._hints_of != self.updates:
            self._hints_of = self.updates
            hints.remember(self.session.hint_reports(), self._hint_points)
        photon_overlay.remember(scene, self.session)

    def _show(self, pixels: np.ndarray, divider: int) -> None:
        """Show an image with one pixel for `divider` squared pixels of the view."""
        import gpu

        pixels = np.clip(pixels, 0.0, LARGEST_HALF)  # for display only, since larger values would be black
        height, width = pixels.shape[:2]
        buffer = gpu.types.Buffer("FLOAT", width * height * 4, np.ascontiguousarray(pixels).reshape(-1))
        self._texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)
        size, region = self.view.resolution(divider)
        self._texture_border = tuple(edge * self.view.size[i % 2] / size[i % 2] for i, edge in enumerate(region))

    def _draw_texture(self, engine: bpy.types.RenderEngine, scene: bpy.types.Scene) -> None:
        import gpu
        from gpu_extras.presets import draw_texture_2d

        x0, y0, x1, y1 = self._texture_border
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(scene)
        draw_texture_2d(self._texture, (x0, y0), x1 - x0, y1 - y0)
        engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")


def _for_view(wanted: ajar.RenderSettings, scene: bpy.types.Scene) -> ajar.RenderSettings:
    """Change the settings of a final render to those of a 3D view."""
    wanted = copy.copy(wanted)
    ours = scene.ajar
    wanted.integrator, wanted.samples = ours.viewport_integrator, ours.viewport_samples
    wanted.seconds, wanted.target_error = 0.0, 0.0
    wanted.importance_factor = 1.0   # its region refers to the frame of the camera
    return wanted


def _with_exposure_of(wanted: ajar.RenderSettings, shown: ajar.RenderSettings) -> ajar.RenderSettings:
    """`wanted` with the exposure of the view that is shown: a new exposure of the display needs no new image."""
    wanted = copy.copy(wanted)
    wanted.view_exposure = shown.view_exposure
    return wanted


def _hidden_in(space: bpy.types.SpaceView3D):
    """A function that tells whether this view hides an instance that others show (local view, hidden collections)."""
    if not (space.local_view or space.use_local_collections):
        return None

    def is_hidden(instance: bpy.types.DepsgraphObjectInstance) -> bool:
        owner = instance.parent if instance.is_instance else instance.object
        return not owner.original.visible_in_viewport_get(space)
    return is_hidden


def watch(engine: bpy.types.RenderEngine) -> None:
    """Poll the session of the engine with a timer, and redraw its view when there is a new image."""
    reference = weakref.ref(engine)

    def look() -> float | None:
        engine = reference()
        try:
            if engine is None or engine.viewport is None:
                return None
            if engine.viewport.poll():
                engine.tag_redraw()
            if engine.viewport.is_busy():
                return POLL_SECONDS
            engine.tag_redraw()  # shows the final status
            engine.watched = False
            return None
        except ReferenceError:  # Blender has freed the engine
            return None
    bpy.app.timers.register(look, first_interval=POLL_SECONDS)


@persistent
def _count_undo(*_: object) -> None:
    global _undo_count
    _undo_count += 1


HANDLERS = (bpy.app.handlers.undo_post, bpy.app.handlers.redo_post, bpy.app.handlers.load_post)


def register() -> None:
    for handlers in HANDLERS:
        handlers.append(_count_undo)


def unregister() -> None:
    for handlers in HANDLERS:
        handlers.remove(_count_undo)
