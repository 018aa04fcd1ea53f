"""Tests the rendered view of a small scene: the screen shows the image of the renderer, also after many edits.

Arguments: folder for images, number of edits, seed.
"""

from __future__ import annotations

import os
import random
import resource
import time

import bpy
import numpy as np
import window
from ajar_render import denoise, hints, photon_overlay, viewport
from ajar_render.export import KnownObjects
from mathutils import Quaternion

views: list[viewport.Viewport] = []
_make = viewport.Viewport.__init__


def _remember(self) -> None:
    _make(self)
    views.append(self)


viewport.Viewport.__init__ = _remember
LONGEST_SECONDS = 60.0   # a limit that a busy machine does not reach
revisions = {"edits": 0, "differences": 0}   # incremental exports, and those of them that differ from a full export
_export = viewport.Viewport._export


def _export_and_compare(self, depsgraph, is_hidden, revised, culls=None):
    description = _export(self, depsgraph, is_hidden, revised, culls)
    if revised is not None:
        known, self.known = self.known, KnownObjects()
        revisions["edits"] += 1
        revisions["differences"] += _export(self, depsgraph, is_hidden, None).fingerprint() != description.fingerprint()
        self.known = known
    return description


viewport.Viewport._export = _export_and_compare


def is_sharp(view: viewport.Viewport) -> bool:
    return view._divider == 1 and view._uploaded[0] == view._number and view._wanted_view is None and view._description is None


def is_shown(view: viewport.Viewport) -> bool:
    """Whether the last samples of a finished render have been drawn."""
    progress = view.session.progress()
    return not view.is_busy() and view._uploaded == (progress.render, progress.iteration)


def wait_until(holds, seconds: float = LONGEST_SECONDS):
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, f"still waiting after {seconds} s"
        yield 0.02


def wait_until_sharp():
    yield 0.1
    yield from wait_until(lambda: is_sharp(views[-1]))


def wait_until_done():
    yield from wait_until_sharp()
    yield from wait_until(lambda: is_shown(views[-1]))
    yield 0.3


def wait_for_another(number: int):
    """Waits until a render with a higher number is done."""
    yield from wait_until(lambda: views[-1]._number > number)
    yield from wait_until_done()


def prepare() -> None:
    """Puts the cube of a new file on a floor."""
    scene = bpy.context.scene
    scene.render.engine = "AJAR"
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.ajar.samples, scene.ajar.viewport_samples = 4, 4
    scene.view_settings.view_transform = "Standard"
    with window.override():
        bpy.ops.mesh.primitive_plane_add(size=8, location=(0, 0, -1))
        bpy.ops.object.select_all(action="DESELECT")
    space = window.space()
    space.overlay.show_overlays = space.show_gizmo = False


def steps(arguments, result):
    folder, count, seed = arguments[0], int(arguments[1]), int(arguments[2])
    prepare()
    yield 0.2
    window.shade("RENDERED")
    started = time.monotonic()
    yield from wait_until(lambda: views and views[-1]._uploaded[1])
    result["first_seconds"] = time.monotonic() - started
    yield from wait_until_done()
    window.screenshot_of_view(os.path.join(folder, "view.png"))
    np.save(os.path.join(folder, "view.npy"), views[-1].session.snapshot("Combined"))
    area = window.area()
    region = next(region for region in area.regions if region.type == "WINDOW")
    result["region"] = [region.x - area.x, region.y - area.y, region.width, region.height]
    result["overlapping"] = [[r.x - area.x, r.y - area.y, r.width, r.height] for r in area.regions
                             if r.type != "WINDOW" and r.width > 1 and r.height > 1]

    yield from counters(result)
    yield from expose(result)
    yield from draw_light_hint(result)
    yield from show_photons(result)
    yield from denoise_view(result)
    dice = random.Random(seed)
    result["edits"] = []
    memory = []
    for number in range(count):
        edit = dice.choice(EDITS)
        result["edits"].append(edit.__name__)
        print(number, edit.__name__, flush=True)
        edit(dice)
        yield dice.choice((0.0, 0.05, 0.2))
        memory.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024)
    restore()
    yield 0.1
    window.shade("RENDERED")
    yield from wait_until_sharp()
    result["memory"] = memory[:: max(1, len(memory) // 20)]
    result["views"], result["revisions"] = len(views), revisions
    window.screenshot(os.path.join(folder, "end.png"))
    picture = views[-1].session.snapshot("Combined")
    result["end"] = [float(picture[..., :3].mean()), float(picture[..., :3].std()), float(views[-1].session.progress().samples)]


# ---- Counts of exports and builds ------------------------------------------------------------------------------------------


def counters(result):
    """Counts for edits of one kind at a time: walks over all instances, exported meshes and requested updates; meshes, instances and programs of
    materials that the core built."""
    result["counters"] = {}
    cube, lamp = bpy.data.objects["Cube"], bpy.data.objects["Light"]

    def turn():
        window.space().region_3d.view_rotation @= Quaternion((0, 0, 1), 0.1)

    def select():
        cube.select_set(not cube.select_get())

    def transform():
        cube.location.x += 0.1

    def colour():
        bpy.data.materials["Material"].node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.8, 0.2, 0.1, 1)

    def energy():
        lamp.data.energy *= 1.1

    def world():
        bpy.context.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 2.0

    def geometry():
        cube.data.vertices[0].co.z += 0.1
        cube.data.update()

    for edit in (turn, select, transform, colour, energy, world, geometry):
        view = views[-1]
        before = (view.meshes.exported, view.updates, view.known.walks)
        edit()
        yield from wait_until_done()
        scene = view.statistics()["scene"]
        result["counters"][edit.__name__] = {
            "exported": view.meshes.exported - before[0], "updates": view.updates - before[1],
            "walks": view.known.walks - before[2], "built": scene["meshes"] - scene["kept_meshes"], "placed": scene["placed_instances"],
            "compiled": scene["compiled_programs"]}


def expose(result):
    """How many images are rendered for another exposure of the display."""
    scene = bpy.context.scene
    scene.update_tag()   # other changes of the scene are rendered before
    yield 0.3
    yield from wait_until_done()
    number = views[-1]._number
    for exposure in (1.5, 0.0):
        scene.view_settings.exposure = exposure
        scene.update_tag()
        yield 0.3
        yield from wait_until_done()
    result["renders_for_exposure"] = views[-1]._number - number


# ---- A light hint, by mouse -----------------------------------------------------------------------------------------------------


def draw_light_hint(result):
    """Draws a hint from the lamp to the floor and to the side of the cube, and removes one point on the way."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    prepare()
    yield 0.3
    lamp = bpy.data.objects["Light"]
    bpy.context.view_layer.objects.active = lamp
    with window.override():
        bpy.ops.ajar.draw_light_hint("INVOKE_DEFAULT")
    yield 0.2
    for point in ((2.5, -2.5, -1), (0, 0, 1)):
        yield from window.click(*window.place_of(point))
    window.event("BACK_SPACE")
    yield 0.1
    yield from window.click(*window.place_of((0, -1, 0)))
    window.event("RET")
    yield 0.2
    curve = hints.curves_of(bpy.context.scene)[0]
    result["drawn"] = {"points": [list(point.co[:3]) for point in curve.data.splines[0].points], "status": hints.status_of(curve),
                       "starts_at": curve.ajar.hint_light.name, "lamp": list(lamp.location)}


# ---- Photons as points ------------------------------------------------------------------------------------------------------------


def show_photons(result):
    """Counts the pixels of the screen that photons change, in the rendered view and in the solid view."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    prepare()
    scene, space = bpy.context.scene, window.space()
    scene.ajar.viewport_integrator, scene.ajar.photons = "photon_map", 20_000
    bpy.data.lights["Light"].color = (1.0, 0.0, 0.0)
    window.shade("RENDERED")
    yield from wait_until_done()
    result["photons"] = {"unasked": len(photon_overlay._photons)}
    number = views[-1]._number
    scene.ajar.show_photons = True
    scene.ajar.seed = 1
    scene.update_tag()    # starts the render again
    yield from wait_for_another(number)
    photons = photon_overlay.of(scene)
    result["photons"] |= {"shown": len(photons.positions), "stored": photons.stored, "lowest": float(photons.positions[:, 2].min())}
    window.shade("SOLID")
    for name in ("show_floor", "show_axis_x", "show_axis_y", "show_extras", "show_outline_selected", "show_cursor", "show_object_origins", "show_text"):
        setattr(space.overlay, name, False)
    space.overlay.show_overlays = True
    pictures = []
    for scene.ajar.show_photons in (False, True, False):
        yield 0.5
        pictures.append(window.pixels_of_view())
    space.overlay.show_overlays = False
    red = (pictures[1][..., 0] > pictures[0][..., 0] + 0.1) & (pictures[1][..., 1] < pictures[1][..., 0])
    result["photons"]["red_pixels"] = int(red.sum())
    result["photons"]["left_over"] = int((np.abs(pictures[2] - pictures[0]) > 0.1).any(axis=-1).sum())


# ---- A denoised view --------------------------------------------------------------------------------------------------------------


def denoise_view(result):
    """A library that stands for the denoiser makes every image blue."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    prepare()
    scene = bpy.context.scene
    scene.ajar.viewport_samples = 8   # with more, the rendered image counts as well
    window.shade("RENDERED")
    yield from wait_until_done()
    result["denoise"] = {"unasked": blue_share(), "available": denoise.is_available()}

    pictures = []   # [render, render of the view at that time, divider, samples]
    upload = viewport.Viewport._upload_picture

    def remember(self, *arguments):
        picture = self._picture
        pictures.append([picture.render, self._number, picture.divider, picture.samples])
        upload(self, *arguments)
    viewport.Viewport._upload_picture = remember
    number = views[-1]._number
    scene.ajar.use_viewport_denoise = True
    scene.update_tag()    # as a click does
    yield from wait_for_another(number)
    result["denoise"] |= {"samples": views[-1].session.progress().samples, "render": views[-1]._number, "last": pictures[-1], "blue": blue_share()}
    turned, moves = len(pictures), views[-1].moves
    for _ in range(20):
        window.space().region_3d.view_rotation @= Quaternion((0, 0, 1), 0.05)
        yield 0.03
    yield from wait_until_done()
    result["denoise"] |= {"moves": views[-1].moves - moves, "moved": pictures[turned:], "moved_render": views[-1]._number, "moved_blue": blue_share()}
    space = window.space()
    number = views[-1]._number
    space.shading.ajar.show_sample_density = True
    yield 0.5
    result["denoise"]["density_blue"] = blue_share()
    space.shading.ajar.show_sample_density = False
    yield 0.5
    result["denoise"] |= {"image_blue": blue_share(), "renders": views[-1]._number - number}
    scene.ajar.use_viewport_denoise = False
    scene.update_tag()
    yield from wait_for_another(number)
    result["denoise"] |= {"pictures": pictures, "off_blue": blue_share()}
    viewport.Viewport._upload_picture = upload

    number, found = views[-1]._number, (denoise.is_available, denoise.ajar.denoiser.reason)
    denoise.is_available, denoise.ajar.denoiser.reason = lambda: False, lambda: "no library"
    scene.ajar.use_viewport_denoise = True
    scene.update_tag()
    yield 0.5
    result["denoise"]["without_library"] = views[-1].status()
    scene.ajar.use_viewport_denoise = False
    denoise.is_available, denoise.ajar.denoiser.reason = found
    scene.update_tag()
    yield 0.5
    result["denoise"] |= {"status": views[-1].status(), "renders_without_library": views[-1]._number - number}


def blue_share() -> float:
    pixels = window.pixels_of_view()
    return float(((pixels[..., 2] > 0.1) & (pixels[..., 0] < 0.1 * pixels[..., 2])).mean())


# ---- Random edits of an artist -------------------------------------------------------------------------------------------------


def things(kind: str = "MESH") -> list[bpy.types.Object]:
    return [thing for thing in bpy.context.scene.objects if thing.type == kind]


def move(dice) -> None:
    thing = dice.choice(list(bpy.context.scene.objects))
    thing.location = [dice.uniform(-2, 2) for _ in range(3)]


def scale(dice) -> None:
    for thing in things()[:1]:
        thing.scale = (dice.choice((0.0, 1.0, -1.0)), 1, 1)


def recolour(dice) -> None:
    for material in list(bpy.data.materials)[:1]:
        if material.node_tree and "Principled BSDF" in material.node_tree.nodes:
            sockets = material.node_tree.nodes["Principled BSDF"].inputs
            sockets["Base Color"].default_value = (dice.random(), dice.random(), dice.random(), 1)
            sockets["Metallic"].default_value = dice.choice((0, 1))


def brighten(dice) -> None:
    for lamp in things("LIGHT")[:1]:
        lamp.data.energy = dice.uniform(0, 2000)
        lamp.data.type = dice.choice(("POINT", "SUN", "SPOT", "AREA"))


def change_world(dice) -> None:
    world = bpy.context.scene.world
    if world is not None and world.node_tree is not None:
        world.node_tree.nodes["Background"].inputs["Strength"].default_value = dice.uniform(0, 2)


def add(dice) -> None:
    with window.override():
        if bpy.context.mode == "OBJECT":
            dice.choice((bpy.ops.mesh.primitive_monkey_add, bpy.ops.mesh.primitive_cube_add, bpy.ops.object.text_add))(
                location=[dice.uniform(-2, 2) for _ in range(3)])


def delete(dice) -> None:
    if len(things()) > 1:
        bpy.data.objects.remove(dice.choice(things()))


def deform(dice) -> None:
    for thing in things()[:1]:
        if not thing.data.is_editmode and len(thing.data.vertices):
            thing.data.vertices[0].co.z = dice.uniform(-3, 3)
            thing.data.update()


def modify(dice) -> None:
    for thing in things()[-1:]:
        if thing.modifiers:
            thing.modifiers.clear()
        else:
            thing.modifiers.new("Subdivision", "SUBSURF").levels = 2


def instance(dice) -> None:
    empty = bpy.data.objects.new("Instance", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", bpy.data.collections.get("Collection")
    empty.location = (dice.uniform(-3, 3), 3, 0)
    bpy.context.scene.collection.objects.link(empty)


def orbit(dice) -> None:
    space = window.space()
    space.region_3d.view_rotation @= Quaternion((0, 0, 1), dice.uniform(-1, 1))


def look_otherwise(dice) -> None:
    window.space().region_3d.view_perspective = dice.choice(("PERSP", "ORTHO", "CAMERA"))


def shade(dice) -> None:
    preview = () if bpy.context.scene.render.engine == "BLENDER_WORKBENCH" else ("MATERIAL",)
    window.shade(dice.choice(("SOLID", "WIREFRAME", *preview, "RENDERED", "RENDERED")))


def switch_engine(dice) -> None:
    bpy.context.scene.render.engine = dice.choice(("BLENDER_WORKBENCH", "CYCLES", "AJAR", "AJAR"))


def remember(dice) -> None:
    with window.override():
        bpy.ops.ed.undo_push(message="edit")


def undo(dice) -> None:
    with window.override():
        operator = dice.choice((bpy.ops.ed.undo, bpy.ops.ed.redo))
        if operator.poll():
            operator()


def edit_mode(dice) -> None:
    with window.override():
        thing = bpy.context.view_layer.objects.active
        if thing is not None and thing.type == "MESH":
            bpy.ops.object.mode_set(mode=dice.choice(("EDIT", "OBJECT")))


def resize(dice) -> None:
    space = window.space()
    space.show_region_ui = not space.show_region_ui
    space.show_region_toolbar = dice.choice((True, False))


def border(dice) -> None:
    space = window.space()
    space.use_render_border = dice.choice((True, False))
    space.render_border_min_x, space.render_border_max_x = 0.2, dice.choice((0.7, 0.2))
    bpy.context.scene.render.use_border = dice.choice((True, False))


def local_view(dice) -> None:
    with window.override():
        if bpy.ops.view3d.localview.poll() and bpy.context.mode == "OBJECT":
            bpy.ops.view3d.localview()


def render(dice) -> None:
    """Renders by F12 while the view also renders."""
    if bpy.context.scene.camera is not None and not bpy.app.is_job_running("RENDER"):
        with window.override():
            bpy.ops.render.render("INVOKE_DEFAULT")


def next_frame(dice) -> None:
    bpy.context.scene.frame_set(bpy.context.scene.frame_current + 1)


def split(dice) -> None:
    areas = bpy.context.window_manager.windows[0].screen.areas
    with window.override():
        if len([area for area in areas if area.type == "VIEW_3D"]) < 2:
            bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)


def load(dice) -> None:
    if not bpy.app.is_job_running("RENDER"):
        bpy.ops.wm.read_homefile(use_factory_startup=True)
        prepare()


EDITS = (move, move, scale, recolour, recolour, brighten, change_world, add, add, delete, deform, modify, instance, orbit, orbit, look_otherwise,
         shade, switch_engine, remember, undo, undo, edit_mode, resize, border, local_view, render, next_frame, split, load)


def restore() -> None:
    """Restores a state in which the view must show an image."""
    with window.override():
        if bpy.context.mode != "OBJECT" and bpy.ops.object.mode_set.poll():
            bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    prepare()
