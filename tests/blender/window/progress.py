"""Tests the Progress panel during a render by F12: the graph of the noise and the map of the samples, in the sidebar of the image editor and in the render tab.

Arguments: folder for images, .blend file. Blender must have been started with --enable-event-simulate.
"""

import os
import time

import bpy
import window
from ajar_render import render_progress, viewport
from ajar_render.ui import progress
from permission import set_value

LONG = 300.0          # seconds; a limit that only a hang reaches
TAB_WIDTH, TAB_STEP, TABS_END = 10, 12, 400   # pixels: distance from the right edge of the sidebar, distance between two clicks, distance from its top to the end of the tabs


views: list[viewport.Viewport] = []
_make = viewport.Viewport.__init__


def _remember(view: viewport.Viewport) -> None:
    _make(view)
    views.append(view)


viewport.Viewport.__init__ = _remember


def until(is_true):
    end = time.monotonic() + LONG
    while not is_true():
        assert time.monotonic() < end, "nothing happens"
        yield 0.05


def open_tab(area: bpy.types.Area):
    """Clicks on the tabs of the sidebar from top to bottom until the panel is drawn."""
    sidebar = next(region for region in area.regions if region.type == "UI")
    for down in range(20, TABS_END, TAB_STEP):
        yield from window.click(sidebar.x + sidebar.width - TAB_WIDTH, sidebar.y + sidebar.height - down)
        yield 0.2
        if area.as_pointer() in render_progress._areas:
            return
    raise AssertionError("the sidebar has no tab with the panel")


def state(scene: bpy.types.Scene) -> dict:
    """The record of the render, and the pictures of the panel in Blender."""
    noted = render_progress.of(scene)
    found = {"number": noted.number, "points": len(noted.seconds), "samples": noted.samples, "is_running": noted.is_running, "density": None, "pictures": {}}
    if noted.density is not None:
        found["density"] = [noted.density.least, noted.density.mean, noted.density.most, *noted.density.means.shape]
    for name, preview in progress._pictures.items():
        pixels = list(preview.image_pixels_float)
        found["pictures"][name] = {"size": list(preview.image_size), "sum": sum(pixels), "colours": len(set(zip(pixels[0::4], pixels[1::4], pixels[2::4])))}
    return found


def steps(arguments, result):
    folder, file = arguments
    bpy.ops.wm.open_mainfile(filepath=file, load_ui=False)
    yield 0.5
    scene = bpy.context.scene
    scene.render.engine = "AJAR"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 160, 120, 100
    settings = scene.ajar
    settings.integrator, settings.image, settings.samples, settings.noise_target = "path", "pmc_ip", 640, 1e-5
    bpy.context.preferences.view.render_display_type = "NONE"

    # The image editor replaces the 3D view, and its sidebar shows the tab of Ajar.
    editor = window.area()
    editor.type = "IMAGE_EDITOR"
    editor.spaces.active.show_region_ui = True
    yield 0.5
    result["shown_at_first"] = len(render_progress._areas)
    yield from open_tab(editor)
    result["idle"] = {"is_noted": render_progress.of(scene) is not None}

    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=editor, region=editor.regions[-1]):
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield from until(lambda: bpy.app.is_job_running("RENDER"))
    editor.spaces.active.image = bpy.data.images["Render Result"]
    yield from until(lambda: render_progress.of(scene) is not None and len(render_progress.of(scene).seconds) >= 6)
    yield 0.7
    result["without_density"] = state(scene)

    # The map is switched on while the render runs.
    set_value(settings, "show_sample_density", True)
    editor.tag_redraw()
    yield from until(lambda: render_progress.of(scene).density is not None and render_progress.of(scene).samples > 40)
    yield 0.7
    result["during"] = state(scene)
    window.screenshot_of_area(os.path.join(folder, "during.png"), editor)
    yield from until(lambda: render_progress.of(scene).samples > 2 * result["during"]["samples"])
    yield 0.7
    result["later"] = state(scene)
    yield from until(lambda: not bpy.app.is_job_running("RENDER"))
    yield 1.0
    result["after"] = state(scene)
    window.screenshot_of_area(os.path.join(folder, "after.png"), editor)
    number = render_progress.of(scene).number
    drawn = dict(progress._drawn)
    yield 1.5
    result["redrawn_when_idle"] = render_progress.of(scene).number != number or progress._drawn != drawn

    # The same test for a rendered view, without another render.
    editor.type = "VIEW_3D"
    set_value(settings, "viewport_samples", 64)
    set_value(settings, "viewport_integrator", "path")
    window.look_through_camera()
    editor.spaces.active.overlay.show_overlays = False
    window.shade("RENDERED")
    yield from until(lambda: len(views) > 0 and views[-1].view is not None and not views[-1].is_busy())
    yield 0.5
    seen = [window.pixels_of_view()]
    renders = views[-1].updates + views[-1].moves
    for shows_density in (True, False):
        editor.spaces.active.shading.ajar.show_sample_density = shows_density
        yield 1.0
        yield from until(lambda: not views[-1].is_busy())
        yield 0.5
        seen.append(window.pixels_of_view())
        if shows_density:
            window.screenshot_of_view(os.path.join(folder, "view_density.png"))
    result["view"] = {"changed": float(abs(seen[1] - seen[0]).mean()), "left_over": float(abs(seen[2] - seen[0]).mean()), "renders": views[-1].updates + views[-1].moves - renders}
