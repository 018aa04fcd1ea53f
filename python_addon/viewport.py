"""The rendered 3D view. Each view has a session, which a timer polls. The image is drawn as a texture.

`draw` receives changes of the camera, `update` receives edits. Both request a new image from the session: first a coarse one that takes about
FIRST_SECONDS, then finer ones, then more samples. In a sequence of changes, the latest one is rendered as soon as an image of an earlier one can be
shown, so that a moving view is always updated. Changes of the camera build nothing. Edits export and build only what has changed, see
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
from .export import ExportContext, KnownObjects, MeshCache, OutOfDate, export_contents, settings
from .headless import Options

POLL_SECONDS = 0.01
FIRST_SECONDS = 0.03          # maximum time of the first image after a change
QUICK_SECONDS = 0.2           # a full image that takes no longer is rendered directly after it
PATIENCE_SECONDS = 0.25       # maximum time that a change waits for the image of the previous change
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
        self._divider = 1
        self._asked = 0.0
        self._pauses = False                           # the user has paused the render, and an image is shown
        self._rate = 1e6                               # pixels per second with one sample each
        self._uploaded = (0, 0)                        # render and iteration that the texture shows
        self._denoises = False                         # enabled and possible
        self._denoiser: denoise.Background | None = None
        self._noisy: tuple[int, float, dict[str, np.ndarray]] | None = None   # the newest render, samples, passes
        self._denoised = (0, 0.0)                      # render and samples of the last image that was passed to the denoiser
        self._clean = 0                                # the render whose denoised image is shown or follows soon
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
        revisions = self.known.changed(depsgraph) if is_hidden is None else None
        if revisions is not None:
            try:
                description = self._export(depsgraph, None, revisions)
            except (OutOfDate, ReferenceError):
                revisions = None
        if revisions is None:
            description = self._export(depsgraph, is_hidden, None)
        wanted = _for_view(description.settings, depsgraph.scene)
        fingerprint = description.fingerprint()
        if fingerprint != self._fingerprint:
            self._fingerprint, self._settings = fingerprint, wanted
            self._description = description
        elif wanted != self._settings:
            self._settings = wanted
            self._wanted_view = self._wanted_view or self.view
        self._proceed()

    def _export(self, depsgraph: bpy.types.Depsgraph, is_hidden, revisions: list[bpy.types.Object] | None) -> ajar.SceneDescription:
        """Export the scene. With `revisions`, only these objects are exported again."""
        exported = ExportContext(depsgraph, lambda: False, lambda step: None, self.meshes, is_hidden)
        exported.known, exported.revisions = self.known, revisions
        self._denoises = depsgraph.scene.ajar.use_viewport_denoise and denoise.is_available()
        settings.export(exported, Options(), ["Combined", *(denoise.NEEDED if self._denoises else ())])
        if revisions is None:
            self.meshes.begin()
        export_contents(exported)
        if revisions is None:
            self.meshes.finish()
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
        return waits or coarse or self._denoiser is not None or not (self.session.wait(0.0) or self._is_paused())

    def poll(self) -> bool:
        """Continue. Returns True if there is a new image to draw."""
        self._proceed()
        progress = self.session.progress()
        return self._is_denoised() or ((progress.render, progress.iteration) > self._uploaded and progress.iteration > 0)

    def _proceed(self) -> None:
        """Start the waiting change if it is time for it, or the next finer image."""
        if self._settings is None:
            return
        progress = self.session.progress()
        shown = progress.render == self._number and progress.iteration > 0
        if shown and progress.render_seconds > 0.0 and self.view is not None:
            self._rate = max(1.0, self.view.pixels() / self._divider**2 * progress.samples / progress.render_seconds)
        if self._description is not None or self._wanted_view is not None:
            target = self._wanted_view or self.view
            impatient = time.monotonic() - self._asked > PATIENCE_SECONDS
            if target is not None and not self._waits_for_denoiser() and (shown or impatient or self.session.wait(0.0)):
                self.view, self._wanted_view = target, None
                self._render(self._first_divider())
        elif shown and self._divider > 1 and self._uploaded[0] == self._number and self._denoiser is None:
            # The full image directly if it is fast, otherwise in steps.
            quick = self.view.pixels() / self._rate < QUICK_SECONDS
            self._render(1 if quick else self._divider // 2)
        # A paused view first shows the full image of an edit. The denoiser uses all cores, and a coarse image is denoised once.
        self._pauses = pausing.is_wanted_in_views() and self._divider == 1
        self.session.pause(self._pauses or self._awaits_denoiser() or self._denoiser is not None)

    def _awaits_denoiser(self) -> bool:
        """Whether the first image of the render will be denoised: the render waits after it. It goes on if the guides are not there yet."""
        is_uploaded = self._uploaded[0] == self._number
        has_guides = self._noisy is not None and self._noisy[0] == self._number
        is_due = self._divider > 1 or self._denoised[0] != self._number
        return self._denoises and not self._shows_density and (not is_uploaded or (has_guides and is_due))

    def _is_paused(self) -> bool:
        """Whether the user has paused the render, and it has stopped."""
        return self._pauses and self.session.is_paused()

    def _waits_for_denoiser(self) -> bool:
        """Whether the image of a move of the view is being denoised: otherwise a quick series of moves would show nothing."""
        return self._denoiser is not None and self._divider > 1 and not self._is_denoised()

    def _is_denoised(self) -> bool:
        return self._denoiser is not None and self._denoiser.wait(0.0)

    def _first_divider(self) -> int:
        divider = 1
        seconds = 0.25 * FIRST_SECONDS if self._denoises else FIRST_SECONDS   # the rest is for the denoiser
        while divider < COARSEST and self.view.pixels() / divider**2 / self._rate > seconds:
            divider *= 2
        return divider

    def _render(self, divider: int) -> None:
        if self._denoiser is not None:
            self._denoiser.cancel()
            self._denoiser = None
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
        self._divider, self._asked = divider, time.monotonic()

    # ---- Drawing --------------------------------------------------------------------------------------------------------------

    def status(self) -> str:
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
            self._uploaded, self._clean, self._denoised = (0, 0), 0, (0, 0.0)

    def _upload(self, scene: bpy.types.Scene) -> None:
        """Upload the newest image to the texture. It must be called during drawing, since `gpu` needs a window."""
        if self._is_denoised():
            self._take_denoised()
        progress = self.session.progress()
        state = (progress.render, progress.iteration)
        if progress.render != self._number or progress.iteration == 0 or state == self._uploaded:
            return
        if self._shows_density:
            counts = self.session.snapshot("Sample Count")
            if counts is not None:   # otherwise it is available after the next iteration
                self._uploaded = state
                self._show(graph.density(counts[..., 0])**DISPLAY_GAMMA)
            return
        pixels = self.session.snapshot("Combined")
        if pixels is None:
            return
        self._uploaded = state
        if self._denoises:
            pictures = {"Combined": pixels} | {name: self.session.snapshot(name) for name in denoise.NEEDED}
            if all(picture is not None and picture.shape[:2] == pixels.shape[:2] for picture in pictures.values()):
                self._noisy = (self._number, progress.samples, pictures)
                self._denoise()
        if self._clean != self._number:   # otherwise the denoised image follows
            self._show(pixels)
        if self._hints_of != self.updates:
            self._hints_of = self.updates
            hints.remember(self.session.hint_reports(), self._hint_points)
        photon_overlay.remember(scene, self.session)

    def _denoise(self) -> None:
        """Denoise when the number of samples has doubled and at the end, one image at a time."""
        if self._noisy is None or self._noisy[0] != self._number or self._denoiser is not None:
            return
        number, samples, pictures = self._noisy
        known = self._denoised[1] if self._denoised[0] == number else 0.0
        if samples >= 2.0 * known or (samples > known and self.session.wait(0.0)):
            self._denoised, self._clean = (number, samples), number
            self._denoiser = denoise.Background(pictures, self.statistics()["rays"], is_view=True)
        if self.session.wait(0.0) and samples == self._denoised[1]:
            self._noisy = None

    def _take_denoised(self) -> None:
        """Show the image of the denoiser, which has ended. It is that of the current render."""
        work, self._denoiser = self._denoiser, None
        try:
            found = work.result()
        except RuntimeError as error:
            print(f"Ajar: {error}", flush=True)
            found = None
        if found is None:
            self._clean, self._uploaded = 0, (0, 0)   # the noisy image is shown
        elif not self._shows_density:
            self._show(found[0])
        if self._divider == 1:
            self._denoise()

    def _show(self, pixels: np.ndarray) -> None:
        import gpu

        pixels = np.clip(pixels, 0.0, LARGEST_HALF)  # for display only, since larger values would be black
        height, width = pixels.shape[:2]
        buffer = gpu.types.Buffer("FLOAT", width * height * 4, np.ascontiguousarray(pixels).reshape(-1))
        self._texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)
        size, region = self.view.resolution(self._divider)
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
