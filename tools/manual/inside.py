"""Runs in Blender's window for `pictures.py`: opens scenes, operates the user interface and takes screenshots. Steps for `tests/blender/window/drive.py`.

Arguments: folder for the pictures, root of the project, names of the pictures (none: all).
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import time
from typing import Any

import bpy
from mathutils import Euler

LONGEST_SECONDS = 400.0
COLUMN = 400            # pixels, width of the properties

parser = argparse.ArgumentParser(prog="inside.py", description=__doc__.splitlines()[0])
parser.add_argument("folder", help="of the pictures")
parser.add_argument("root", help="of the project")
parser.add_argument("names", nargs="*", help="of pictures; none: all")
options = parser.parse_args(sys.argv[sys.argv.index("--") + 3:])
folder, root, names = options.folder, options.root, options.names
sys.path.insert(0, f"{root}/tests/blender/window")
import window  # noqa: E402
from ajar_render import hints, render_progress, ui, viewport  # noqa: E402
from ajar_render.export import hints as export_hints  # noqa: E402

views: list[viewport.Viewport] = []
_make = viewport.Viewport.__init__
shown: set[str] | None = None     # names of the panels that are visible; None: all


def _remember(view: viewport.Viewport) -> None:
    _make(view)
    views.append(view)


viewport.Viewport.__init__ = _remember


def is_wanted(name: str) -> bool:
    """Whether a picture was requested, or a chapter, whose name is the beginning of the names of its pictures."""
    return not names or any(name.startswith(wanted) or wanted.startswith(f"{name}_") for wanted in names)


# ---- Blender's window ---------------------------------------------------------------------------------------------------


def open_panels() -> None:
    """Open all panels by default, and make it possible to hide each panel."""
    for panel in [*ui.CLASSES]:
        if "DEFAULT_CLOSED" in getattr(panel, "bl_options", ()):
            bpy.utils.unregister_class(panel)
            panel.bl_options = panel.bl_options - {"DEFAULT_CLOSED"}
            bpy.utils.register_class(panel)
    for panel in bpy.types.Panel.__subclasses__():
        if getattr(panel, "bl_space_type", "") == "PROPERTIES" and hasattr(panel, "poll"):
            _hide_at_will(panel)


def _hide_at_will(panel: Any) -> None:
    poll = panel.poll.__func__

    def only_when_shown(cls, context) -> bool:
        return (shown is None or cls.__name__ in shown) and poll(cls, context)
    panel.poll = classmethod(only_when_shown)


def show(*panels: str) -> None:
    global shown
    shown = set(panels) or None
    window.area("PROPERTIES").tag_redraw()


def open_scene(name: str | None) -> None:
    """Open a test scene (None: Blender's default scene), with the view on the left and a column of properties on the right, both of full height."""
    if name is None:
        bpy.ops.wm.read_homefile(use_factory_startup=True)
    else:
        bpy.ops.wm.open_mainfile(filepath=f"{root}/test_scenes/{name}.blend", load_ui=False)
    scene = bpy.context.scene
    scene.render.engine = "AJAR"
    collection = export_hints.collection_of(scene)
    if collection is not None:
        collection.name = export_hints.COLLECTION   # scenes for older versions have another name
    bpy.context.preferences.view.show_statusbar_stats = False


def arrange():
    """Close the areas that are not needed, one after the other."""
    screen = bpy.context.window_manager.windows[0].screen
    for kind in ("DOPESHEET_EDITOR", "OUTLINER"):
        for area in [area for area in screen.areas if area.type == kind]:
            with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], screen=screen, area=area):
                bpy.ops.screen.area_close()
            yield 0.2


def widen_properties():
    """Split the 3D view where the properties shall begin, and join the right part with the properties."""
    win = bpy.context.window_manager.windows[0]
    view = window.area()
    with bpy.context.temp_override(window=win, screen=win.screen, area=view, region=view.regions[-1]):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=1.0 - (COLUMN - window.area("PROPERTIES").width) / view.width)
    yield 0.2
    spare = max((area for area in win.screen.areas if area.type == "VIEW_3D"), key=lambda area: area.x)
    with bpy.context.temp_override(window=win, screen=win.screen, area=spare):
        bpy.ops.screen.area_close()
    yield 0.2


def photograph(name: str, *areas: str) -> None:
    """Take a screenshot of areas, or of the whole window."""
    path = os.path.join(folder, f"{name}.png")
    if not areas:
        window.screenshot(path)
        return
    window.screenshot_of_area(path, window.area(areas[0]))


def panel(name: str, *classes: str, tab: str = "RENDER"):
    if is_wanted(f"panel_{name}"):
        window.area("PROPERTIES").spaces.active.context = tab
        show(*classes)
        yield 0.4
        photograph(f"panel_{name}", "PROPERTIES")


def tidy_view() -> None:
    space = window.space()
    overlay = space.overlay
    overlay.show_floor = overlay.show_axis_x = overlay.show_axis_y = overlay.show_cursor = False
    space.show_gizmo_navigate = False


# ---- The pictures ---------------------------------------------------------------------------------------------------------


def steps(arguments, result):
    open_panels()
    open_scene(None)
    yield 0.5
    yield from arrange()
    yield from widen_properties()
    for chapter in (whole_window, settings, progress, hint_steps, photons):
        yield from chapter()


def whole_window():
    """`room` in the rendered view, with its light hints."""
    if not is_wanted("blender"):
        return
    open_scene("room")
    yield 0.5
    tidy_view()
    scene = bpy.context.scene
    scene.ajar.viewport_integrator, scene.ajar.viewport_samples, scene.ajar.integrator = "photon_map", 24, "metropolis"
    window.area("PROPERTIES").spaces.active.context = "RENDER"
    for thing in list(bpy.context.selected_objects):
        thing.select_set(False)
    window.look_through_camera()
    with window.override():
        bpy.ops.view3d.view_center_camera()
    window.shade("RENDERED")
    yield 1.0
    started = time.monotonic()
    while (not views or views[-1].is_busy()) and time.monotonic() - started < LONGEST_SECONDS:
        yield 0.5
    yield 0.5
    photograph("blender")
    window.shade("SOLID")


def settings():
    """Screenshots of all panels of the render properties after a render."""
    if not is_wanted("panel"):
        return
    open_scene("room")
    scene = bpy.context.scene
    yield 0.3
    yield from panel("sampling", "AJAR_RENDER_PT_sampling")
    for name, kind, tab, classes in (
            ("material", "MESH", "MATERIAL", ("AJAR_MATERIAL_PT_slots", "AJAR_MATERIAL_PT_surface")),
            ("light", "LIGHT", "DATA", ("DATA_PT_context_light", "AJAR_LIGHT_PT_light", "AJAR_LIGHT_PT_beam", "AJAR_LIGHT_PT_nodes"))):
        bpy.context.view_layer.objects.active = next(thing for thing in scene.objects if thing.type == kind and (kind != "MESH" or thing.active_material))
        yield 0.2
        yield from panel(name, *classes, tab=tab)
    yield from panel("integrator", "AJAR_RENDER_PT_integrator")
    scene.ajar.integrator = "photon_map"
    yield from panel("integrator_photons", "AJAR_RENDER_PT_integrator")
    yield from panel("direct", "AJAR_RENDER_PT_direct")
    yield from panel("light_paths", "AJAR_RENDER_PT_light_paths")
    yield from panel("performance", "AJAR_RENDER_PT_performance")
    scene.ajar.clamp_indirect = 10.0
    yield from panel("checks", "AJAR_RENDER_PT_checks")
    scene.ajar.clamp_indirect = 0.0
    scene.ajar.integrator, scene.ajar.samples = "auto", 32
    scene.render.resolution_percentage = 25
    if any(is_wanted(f"panel_{name}") for name in ("statistics", "plan")):
        bpy.ops.render.render()
        yield 0.5
        yield from panel("statistics", "AJAR_RENDER_PT_statistics", "AJAR_RENDER_PT_plan")


def progress():
    """A render of `checker` with its Progress panel, in the sidebar of the image editor."""
    if not is_wanted("progress"):
        return
    open_scene("checker")
    yield 0.5
    scene = bpy.context.scene
    scene.ajar.integrator, scene.ajar.image, scene.ajar.samples, scene.ajar.noise_target = "path", "pmc_ip", 256, 1e-4
    scene.ajar.show_sample_density = True
    scene.render.resolution_x = scene.render.resolution_y = 360
    scene.render.resolution_percentage = 100
    bpy.context.preferences.view.render_display_type = "NONE"
    editor = window.area()
    editor.type = "IMAGE_EDITOR"
    editor.spaces.active.show_region_ui = True
    yield 0.5
    sidebar = next(region for region in editor.regions if region.type == "UI")
    for down in range(20, 400, 12):   # clicks on the tabs until the panel is drawn
        yield from window.click(sidebar.x + sidebar.width - 10, sidebar.y + sidebar.height - down)
        yield 0.3
        if editor.as_pointer() in render_progress._areas:
            break
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=editor, region=editor.regions[-1]):
        bpy.ops.render.render("INVOKE_DEFAULT")
    started = time.monotonic()
    noted = None
    while (noted is None or noted.samples < 100 or noted.density is None) and time.monotonic() - started < 3 * LONGEST_SECONDS:
        yield 0.2
        noted = render_progress.of(scene)
        if bpy.data.images.get("Render Result") is not None:
            editor.spaces.active.image = bpy.data.images["Render Result"]
    yield 0.7
    photograph("progress", "IMAGE_EDITOR")
    while bpy.app.is_job_running("RENDER"):
        yield 0.2
    editor.type = "VIEW_3D"
    yield 0.3


AJAR_TAB = (987, 661)   # of the sidebar, in a window of the size in pictures.py


def look(location, distance: float, down: float, around: float) -> None:
    """Set the view: angles in degrees from vertically down, and around the vertical axis."""
    region = window.space().region_3d
    region.view_perspective = "PERSP"
    region.view_rotation = Euler((math.radians(down), 0.0, math.radians(around))).to_quaternion()
    region.view_location, region.view_distance = location, distance


def open_room():
    """Show `room` from above, without its ceiling and its light hints."""
    open_scene("room")
    yield 0.5
    tidy_view()
    for curve in hints.curves_of(bpy.context.scene):
        bpy.data.objects.remove(curve)
    bpy.data.objects["Ceiling"].hide_set(True)
    window.space().shading.type = "SOLID"
    window.space().show_region_ui = True
    look((0.9, 1.6, 0.9), 8.5, 42, 14)
    lamp = bpy.data.objects["Lamp"]
    bpy.context.view_layer.objects.active = lamp
    for thing in bpy.context.scene.objects:
        thing.select_set(thing == lamp)
    yield 0.5
    yield from window.click(*AJAR_TAB)
    yield 0.3


def start_drawing() -> None:
    with window.override():
        bpy.ops.ajar.draw_light_hint("INVOKE_DEFAULT")


def hint_steps():
    """Draw a light hint from the lamp of `room`, then show all light hints."""
    if not is_wanted("hint"):
        return
    yield from open_room()
    photograph("hint_1_lamp", "VIEW_3D")
    start_drawing()
    yield 0.3
    through_the_gap = window.place_of((-0.75, 0.62, 0.74))
    window.event("MOUSEMOVE", "NOTHING", *through_the_gap)
    yield 0.5
    photograph("hint_2_drawing")
    yield from window.click(*through_the_gap)
    window.event("RET")
    yield 0.5
    photograph("hint_3_attached", "VIEW_3D")
    bpy.context.view_layer.objects.active = bpy.data.objects["Lamp"]
    start_drawing()
    yield 0.3
    yield from window.click(*window.place_of((-1.2, -0.9, 0.01)))
    window.event("RET")
    yield 0.5
    photograph("hint_4_failed", "VIEW_3D")

    open_scene("box")
    yield 0.5
    tidy_view()
    window.space().shading.type = "SOLID"
    window.space().show_region_ui = False
    window.look_through_camera()
    with window.override():
        bpy.ops.view3d.view_center_camera()
        bpy.ops.ajar.check_light_hints()
    yield 0.5
    photograph("hint_5_bounced", "VIEW_3D")
    scene = bpy.context.scene
    scene.render.resolution_percentage, scene.ajar.samples, scene.ajar.integrator = 30, 16, "metropolis"
    if is_wanted("hint_6"):
        bpy.ops.render.render()
        yield 0.5
        window.area("PROPERTIES").spaces.active.context = "RENDER"
        show("AJAR_RENDER_PT_hints")
        yield 0.5
        photograph("panel_hints", "PROPERTIES")
        show()


def photons():
    """The photons of photon mapping and Metropolis photon sampling in `rooms`, of which the camera sees one."""
    if not is_wanted("photons"):
        return
    open_scene("rooms")
    yield 0.5
    tidy_view()
    scene = bpy.context.scene
    for thing in scene.objects:
        if "eiling" in thing.name or thing.type in ("LIGHT", "CAMERA", "CURVE"):
            thing.hide_set(True)
        thing.select_set(False)
    window.space().show_region_ui = False
    look((0.0, 0.0, 0.0), 12.5, 0, 0)
    shading = window.space().shading
    shading.color_type, shading.single_color = "SINGLE", (0.12, 0.12, 0.13)
    scene.render.resolution_percentage, scene.ajar.samples, scene.ajar.photons, scene.ajar.show_photons = 20, 2, 60_000, True
    for integrator in ("photon_map", "mps"):
        scene.ajar.integrator = integrator
        bpy.ops.render.render()
        yield 0.5
        photograph(f"photons_{integrator}", "VIEW_3D")
