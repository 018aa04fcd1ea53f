"""The render engine AJAR: a render from the dependency graph to Blender's render result.

Blender calls `render` for each view layer in a separate thread, or in the main thread in background mode. With stereoscopy, each view of the layer is a
render of its own. The renderer has its own threads; the
calling thread polls it every tenth of a second, passes new images to Blender, and checks whether the render was cancelled. Previews of materials,
worlds and lamps are renders as well, and so are the strokes of Freestyle, which Blender makes a scene of. The rendered 3D view is in `viewport.py`.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from . import bake, compat, cryptomatte, denoise, headless, hints, last_render, learning, messages, passes, pausing, persistent, photon_overlay, plain, render_progress, viewport
from .ajar_module import ajar
from .export import ExportCancelled, export_scene
from .export.settings import view_exposure
from .export.camera import CENTRE, Eye
from .interrupt import Interrupt
from .translations import interface, report

POLL_SECONDS = 0.1
PREVIEW_POLL_SECONDS = 0.02
WORDS_SECONDS, BACKGROUND_WORDS_SECONDS = 0.5, 4.0  # between two progress messages; in background mode Blender prints all of them
FIRST_IMAGE_SECONDS, IMAGE_SECONDS = 0.5, 2.0  # until the first image is shown, and between two later ones
CHECKPOINT_SECONDS = 30.0   # between two checkpoints that the command line requests
FIRST_CHECKPOINT_SECONDS = 5.0
PAUSED_POLL_SECONDS = 0.3
USED_SHARE = 0.5            # of a time limit: a render that ends before was ended by its samples or its noise target
NAME = "Ajar"


class RenderFailed(Exception):
    """The render failed. The message is shown to the artist."""


class Rendered(NamedTuple):
    """The original data that are rendered. They remain when Blender's evaluated scene is released."""

    scene: bpy.types.Scene
    view_layer: bpy.types.ViewLayer


class TimeLimit(NamedTuple):
    """What a time limit leaves for samples, in seconds, and the quality of denoising for which it was shortened."""

    seconds: float
    quality: ajar.DenoiseQuality


class AjarRenderEngine(bpy.types.RenderEngine):
    bl_idname = "AJAR"
    bl_label = NAME
    bl_use_preview = True
    bl_use_eevee_viewport = True         # Material Preview is drawn by Eevee
    bl_use_postprocess = True
    bl_use_spherical_stereo = True
    bl_use_custom_freestyle = True       # strokes are rendered here; else by Eevee, which needs a graphics card
    bl_use_shading_nodes_custom = False  # otherwise Blender hides its standard shader nodes

    viewport: viewport.Viewport | None = None   # Blender keeps an engine object for each 3D view
    baked: bake.Kept | None = None   # Blender keeps an engine object for the images of an object
    baked_images = 0
    watched = False
    _is_aside = False           # a preview, or the strokes of Freestyle: nothing is kept of it, and it has one time and one view
    _next_words = 0.0
    _view = ""                  # the view that is rendered, with stereoscopy
    _share = (0.0, 1.0)         # of the progress: before this view, and of this view
    _is_last_view = True
    _limit: TimeLimit | None = None   # of the present render, if it is denoised

    def view_update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        if self.viewport is None:
            self.viewport = viewport.Viewport()
        self.viewport.update(context, depsgraph)
        self._watch()

    def view_draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        if self.viewport is None:
            self.view_update(context, depsgraph)
        self.viewport.draw(self, context, depsgraph)
        self._watch()

    def _watch(self) -> None:
        if not self.watched and self.viewport.is_busy():
            self.watched = True
            viewport.watch(self)

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        draws_strokes = not self.is_preview and all(depsgraph.scene != scene for scene in bpy.data.scenes)   # that scene is not in the file
        self._is_aside = self.is_preview or draws_strokes
        options = headless.preview() if self.is_preview else headless.strokes() if draws_strokes else headless.current()
        rendered = Rendered(depsgraph.scene, depsgraph.view_layer)
        self._handed_over: set[str] = set()   # the views of which Blender has a picture
        with Interrupt() as interrupt:
            try:
                self._render_views(depsgraph, options, lambda: interrupt.raised or self.test_break())
            except ExportCancelled:
                persistent.forget()
            except (RenderFailed, OSError, RuntimeError) as error:
                persistent.forget()
                self._fail(str(error))
            finally:
                pausing.end(self._is_aside)
                self._hand_over_black(rendered)
        if interrupt.raised and headless.renders_from_command_line():
            interrupt.leave_after_writing()

    def bake(self, depsgraph: bpy.types.Depsgraph, object: bpy.types.Object, pass_type: str, pass_filter: int, width: int, height: int) -> None:
        try:
            bake.bake(self, depsgraph, object, pass_type, pass_filter, width, height)
        except ExportCancelled:
            pass
        except (bake.CannotBake, OSError, RuntimeError) as error:
            self._fail(str(error))

    def update_render_passes(self, scene: bpy.types.Scene, renderlayer: bpy.types.ViewLayer) -> None:
        for item in passes.wanted(renderlayer):
            self.register_pass(scene, renderlayer, item.shown, len(item.letters), item.letters, item.kind)
        if plain.of(scene.ajar).use_denoise and denoise.is_available():
            for item in (passes.NOISY, passes.DENOISING_ERROR):
                if item is passes.NOISY or plain.of(renderlayer.ajar).use_pass_denoising_error:
                    self.register_pass(scene, renderlayer, item.shown, len(item.letters), item.letters, item.kind)

    def _render_views(self, depsgraph: bpy.types.Depsgraph, options: headless.Options, is_cancelled) -> None:
        if self._is_aside or not depsgraph.scene.render.use_multiview:
            self._render(depsgraph, options, is_cancelled, CENTRE)
            return
        names = [view.name for view in self.get_result().views]
        for number, self._view in enumerate(names):
            if is_cancelled():
                return
            self._share, self._is_last_view = (number / len(names), 1.0 / len(names)), number == len(names) - 1
            self.active_view_set(self._view)   # decides which camera `camera_override` is, too
            self._render(depsgraph, options, is_cancelled, self._eye())

    def _eye(self) -> Eye:
        """Where the active view sees from."""
        return Eye(lambda camera: self.camera_model_matrix(camera, use_spherical_stereo=self.use_spherical_stereo(camera)),
                   lambda camera: self.camera_shift_x(camera, use_spherical_stereo=self.use_spherical_stereo(camera)), self.use_spherical_stereo,
                   {"left": -0.5, "right": 0.5}.get(self._view, 0.0))

    def _render(self, depsgraph: bpy.types.Depsgraph, options: headless.Options, is_cancelled, eye: Eye) -> None:
        started = time.monotonic()
        rendered, scene = Rendered(depsgraph.scene, depsgraph.view_layer), depsgraph.scene_eval
        wanted = passes.wanted(depsgraph.view_layer_eval)
        asks_to_denoise = self._denoises(scene, options)
        denoises = asks_to_denoise and denoise.is_available()
        needed = denoise.NEEDED if denoises else ()
        learner = (scene.name, depsgraph.view_layer.name, self._view)
        is_kept = not self._is_aside and not (options.checkpoint or options.resume or scene.ajar.use_checkpoint)
        kept = persistent.of(depsgraph, learner) if is_kept else None
        exported = export_scene(depsgraph, options, list(dict.fromkeys([*(item.name for item in wanted), *needed])), self.camera_override or scene.camera,
                                is_cancelled, lambda step: self._show(rendered, interface("Exporting {step}", step=interface(step))),
                                None if self._is_aside else self.frame_set, eye, caches=(kept.meshes, kept.known) if kept is not None else None)
        scene = rendered.scene
        export_seconds = time.monotonic() - started
        messages.report_warnings(self, exported)
        if asks_to_denoise and not denoises:
            self.report({"WARNING"}, report("{name}: the picture is not denoised: {reason}", name=scene.name, reason=ajar.denoiser.reason()))
        settings = exported.description.settings
        self._limit = None
        if denoises and settings.seconds > 0.0:   # the time limit includes denoising
            pixels = settings.width * settings.height
            quality = denoise.quality_within(pixels, settings.seconds, settings.threads)
            settings.seconds = max(0.5 * settings.seconds, settings.seconds - denoise.expected_seconds(pixels, quality, settings.threads))
            self._limit = TimeLimit(settings.seconds, quality)
        if options.dump_scene is not None:
            path = headless.of_frame(options.dump_scene, scene.frame_current)
            ajar.save_description(exported.description, self._of_view(path))
            if options.dump_only:
                return

        noise_target = settings.target_error   # starting the session empties the description
        hint_points = hints.points_of(exported.description)
        manifests = cryptomatte.manifests(exported.description, depsgraph.view_layer_eval)   # likewise
        session = kept.session if kept is not None else ajar.Session()
        carries = not self._is_aside and learning.is_carried(scene, options)
        if carries:
            session.begin_with(learning.of(learner))
        interval = depsgraph.scene_eval.ajar.checkpoint_interval if options.checkpoint is None else CHECKPOINT_SECONDS
        save_checkpoint = self._checkpoints(rendered, options, session, exported.description)
        save_checkpoint()   # writes nothing yet; from now on, the session keeps a checkpoint of each iteration
        if not self._is_aside:
            render_progress.begin(scene.name)
        self._release(scene)
        if kept is not None:
            session.next_frame(exported.description)
        else:
            session.start(exported.description)
        self._follow(rendered, session, wanted, is_cancelled, save_checkpoint, interval, noise_target)
        save_checkpoint()

        error = session.take_error()
        if self._is_aside:
            self._hand_over(rendered, session, wanted, None)
            if error and not self.is_preview:
                raise RenderFailed(error)
            return
        render_progress.end(scene.name, session, noise_target)
        for diagnostic in session.diagnostics():
            messages.report_diagnostic(self, diagnostic)
        if is_cancelled():
            persistent.forget()
        if error:
            raise RenderFailed(error)
        if carries:
            learning.remember(learner, session.learned())
        statistics = json.loads(session.statistics_json())
        statistics |= {"export_seconds": export_seconds, "blender_version": bpy.app.version_string, "file": bpy.data.filepath,
                       "scene_name": scene.name, "view_layer": rendered.view_layer.name, "frame": scene.frame_current}
        self._show_memory(statistics)
        hints.remember(session.hint_reports(), hint_points)
        last_render.remember(scene.name, statistics)
        photon_overlay.remember(scene, session)
        if not self._hand_over(rendered, session, wanted, statistics, denoises, is_cancelled):
            return  # cancelled before the first sample
        self._add_fields(manifests)
        if options.stats is not None:
            options.stats.write_text(json.dumps(statistics, indent=2) + "\n", encoding="utf-8")

    def _release(self, scene: bpy.types.Scene) -> None:
        """Let Blender free the evaluated scene, which nothing reads after the export. With an interface or Persistent Data, it is used again."""
        if bpy.app.background and self._is_last_view and not self._is_aside and not scene.render.use_persistent_data:
            self.free_blender_memory()

    def _denoises(self, scene: bpy.types.Scene, options: headless.Options) -> bool:
        return not self._is_aside and (plain.of(scene.ajar).use_denoise if options.denoise is None else options.denoise)

    def _of_view(self, path: Path) -> str:
        """The file of the view that is rendered."""
        return str(path.with_name(f"{path.name}.{self._view}") if self._view else path)

    def _checkpoints(self, rendered: Rendered, options: headless.Options, session: ajar.Session,
                     description: ajar.SceneDescription) -> Callable[[], None]:
        """Resume from the checkpoint of the command line or the panel, and return a function that writes checkpoints. Each view layer and
        each view has its own file; with the panel, each frame has one as well."""
        settings = rendered.scene.ajar
        of_panel = Path(bpy.path.abspath(settings.checkpoint_path)) if settings.use_checkpoint else None
        if of_panel is not None:
            of_panel = of_panel.with_name(f"{of_panel.stem}_{rendered.scene.frame_current:04}{of_panel.suffix}")
        write, resume = options.checkpoint or of_panel, options.resume
        scene = description.fingerprint()
        several = sum(layer.use for layer in rendered.scene.view_layers) > 1

        def of_layer(path: Path) -> str:
            return self._of_view(path.with_name(f"{path.name}.{rendered.view_layer.name}") if several else path)
        if resume is None and of_panel is not None and settings.use_resume and Path(of_layer(of_panel)).is_file():
            resume = of_panel
        if self._is_aside or (write is None and resume is None):
            return lambda: None
        if resume is not None:
            session.resume(of_layer(resume), scene)
        return lambda: session.save_checkpoint(of_layer(write), scene) if write is not None else None

    def _follow(self, rendered: Rendered, session: ajar.Session, wanted: list[passes.Pass], is_cancelled,
                save_checkpoint: Callable[[], None], interval: float, noise_target: float) -> None:
        """Poll the session until it ends or the user cancels it. `interval`: seconds between two checkpoints."""
        next_image = time.monotonic() + FIRST_IMAGE_SECONDS
        next_checkpoint = time.monotonic() + min(FIRST_CHECKPOINT_SECONDS, interval)
        while not session.wait(PREVIEW_POLL_SECONDS if self._is_aside else POLL_SECONDS):
            progress = session.progress()
            before, share = self._share
            self.update_progress(before + share * progress.fraction)
            session.pause(pausing.is_wanted() and not self._is_aside)
            self._show(rendered, interface("Paused") if session.is_paused() else describe(progress, noise_target))
            if not self._is_aside:
                render_progress.note(rendered.scene.name, session, noise_target)
            if is_cancelled():
                session.cancel()
                session.wait(60.0)
                return
            if time.monotonic() > next_checkpoint:
                save_checkpoint()
                next_checkpoint = time.monotonic() + interval
            if not bpy.app.background and time.monotonic() > next_image:
                self._hand_over(rendered, session, wanted, None)
                next_image = time.monotonic() + IMAGE_SECONDS

    def _hand_over_black(self, rendered: Rendered) -> None:
        """Views that were not rendered become black. Blender 5 crashes when it writes a layer without pixels to an EXR file."""
        has_views = rendered.scene.render.use_multiview and not self._is_aside
        views = {view.name for view in self.get_result().views} if has_views else {""}
        for view in views - self._handed_over:
            self.end_result(self.begin_result(0, 0, self.resolution_x, self.resolution_y, layer=rendered.view_layer.name, view=view))

    def _hand_over(self, rendered: Rendered, session: ajar.Session, wanted: list[passes.Pass],
                   statistics: dict | None, is_denoised: bool = False, is_cancelled=lambda: False) -> bool:
        """Pass the current image to Blender. Returns False if there is none yet."""
        if session.snapshot("Combined") is None:
            return False
        self._handed_over.add(self._view)
        result = self.begin_result(0, 0, session.width, session.height, layer=rendered.view_layer.name, view=self._view)
        layer = result.layers[0]
        for item in wanted:
            target = layer.passes.get(item.shown)
            values = session.snapshot(item.name)
            if is_denoised and statistics is not None and item is passes.COMBINED:
                values = self._denoised(rendered, session, layer, statistics, is_cancelled)
            if target is not None and values is not None:
                compat.write_pass(target, passes.fitted(values, target.channels))
        self.end_result(result)
        if statistics is not None:
            self._stamp(f"{rendered.view_layer.name}.{self._view}" if self._view else rendered.view_layer.name, statistics)
        return True

    def _denoised(self, rendered: Rendered, session: ajar.Session, layer: bpy.types.RenderLayer, statistics: dict, is_cancelled) -> np.ndarray:
        """The denoised image; the noisy one if the user cancels or if the library fails. Writes the passes of denoising."""
        self._next_words = 0.0
        self._show(rendered, interface("Denoising"))
        started = time.monotonic()
        pictures = {name: session.snapshot(name) for name in (passes.COMBINED.name, *denoise.NEEDED)}
        image = noisy = pictures[passes.COMBINED.name]
        if self._limit is not None and statistics["render_seconds"] + statistics["pilot_seconds"] >= USED_SHARE * self._limit.seconds:
            quality = self._limit.quality
        else:
            quality = ajar.denoiser.quality_for(statistics["rays"], ajar.denoiser.pixels_of(pictures[passes.HALVES], image))
        work = denoise.Background(pictures, quality, statistics["threads"], ajar.denoiser.biased_of(statistics),
                                  view_exposure(rendered.scene), layer.passes.get(passes.DENOISING_ERROR.shown) is not None)
        while not work.wait(POLL_SECONDS):
            if is_cancelled():
                work.cancel()
        statistics["denoise_seconds"] = time.monotonic() - started
        error = None
        try:
            image, error = work.result() or (noisy, None)
        except RuntimeError as failure:
            self.report({"WARNING"}, report("{name}: the picture is not denoised: {reason}", name=rendered.scene.name, reason=str(failure)))
        written = {passes.NOISY: noisy}
        if error is not None:
            statistics["denoising_error"] = float(error.mean())
            written[passes.DENOISING_ERROR] = np.sqrt(error)[..., None]
        for item, values in written.items():
            if (target := layer.passes.get(item.shown)) is not None:
                compat.write_pass(target, passes.fitted(values, target.channels))
        return image

    def _stamp(self, owner: str, statistics: dict) -> None:
        """Write the statistics to the metadata of the image, if its format supports metadata. `owner`: the view layer, and the view if there are several."""
        self._add_fields({"ajar.engine": NAME, "ajar.version": ajar.version})
        self._add_fields({f"ajar.{owner}.{name}": value if isinstance(value, str) else json.dumps(value) for name, value in statistics.items()})

    def _add_fields(self, fields: dict[str, str]) -> None:
        result = self.get_result()
        for name, value in fields.items():
            result.stamp_data_add_field(name, value)

    # ---- Messages -----------------------------------------------------------------------------------------------------

    def _show(self, rendered: Rendered, text: str) -> None:
        now = time.monotonic()
        if now < self._next_words:
            return
        self._next_words = now + (BACKGROUND_WORDS_SECONDS if bpy.app.background else WORDS_SECONDS)
        self.update_stats(", ".join(filter(None, (rendered.scene.name, rendered.view_layer.name, self._view))), text)

    def _show_memory(self, statistics: dict) -> None:
        peak = statistics.get("peak_memory_bytes")
        if isinstance(peak, (int, float)):
            self.update_memory_stats(memory_used=peak / 2**20, memory_peak=peak / 2**20)

    def _fail(self, message: str) -> None:
        if headless.renders_from_command_line():
            headless.say_error(message)
            headless.leave(headless.EXIT_NO_IMAGE)
        self.report({"ERROR"}, message)
        self.error_set(message)


def describe(progress: ajar.Progress, noise_target: float) -> str:
    if progress.phase == ajar.Progress.Phase.Building:
        return interface("Building: {step}", step=interface(progress.step))
    words = [interface("{number:.4g} samples", number=progress.samples)]
    if progress.shown_relmse >= 0.0:
        words.append(interface("Noise {noise}", noise=render_progress.noise_words(progress.shown_relmse ** 0.5, max(0.0, noise_target) ** 0.5)))
    if progress.remaining_seconds >= 0.0:
        words.append(interface("Remaining {time}", time=render_progress.clock(progress.remaining_seconds)))
    return " | ".join(words)


def register() -> None:
    bpy.utils.register_class(AjarRenderEngine)


def unregister() -> None:
    bpy.utils.unregister_class(AjarRenderEngine)
