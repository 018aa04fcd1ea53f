"""Daily work with only Ajar as the engine: opens a file, edits a lamp, a material, the world and the depth of field, adds a light hint,
renders, pauses, denoises and saves.

Arguments: folder for images, .blend file. The result describes the events. A screenshot of each tab of Properties is saved, and the result lists what
its panels show.
"""

import os
import time

import bpy
import window

TABS = ("RENDER", "OUTPUT", "VIEW_LAYER", "SCENE", "WORLD", "OBJECT", "MATERIAL", "DATA")
LONG = 300.0   # seconds; a limit that only a hang reaches


def until(is_true):
    end = time.monotonic() + LONG
    while not is_true():
        assert time.monotonic() < end, "nothing happens"
        yield 0.05


def activate(thing: bpy.types.Object) -> None:
    for other in bpy.context.view_layer.objects:
        other.select_set(other == thing)
    bpy.context.view_layer.objects.active = thing


def photograph_tabs(folder: str, name: str, tabs, result):
    """Saves screenshots of the tabs, with a large Properties editor in place of the 3D view."""
    area = window.area()
    area.type = "PROPERTIES"
    yield 0.2
    for tab in tabs:
        try:
            area.spaces.active.context = tab
        except TypeError:   # the active object has no such tab
            continue
        yield 0.3
        path = os.path.join(folder, f"{name}_{tab.lower()}.png")
        window.screenshot_of_area(path, area)
        result["tabs"].append(f"{name} {tab}")
    area.type = "VIEW_3D"
    yield 0.2


def find(kind: str) -> bpy.types.Object:
    return next(thing for thing in bpy.context.scene.objects if thing.type == kind and not thing.hide_render)


def edit(scene: bpy.types.Scene, result) -> None:
    lamp, mesh, camera = find("LIGHT"), find("MESH"), scene.camera
    lamp.data.energy *= 1.5
    if mesh.active_material is None:
        mesh.active_material = bpy.data.materials.new("Material")
    material = mesh.active_material
    material.use_nodes = True
    node = next((node for node in material.node_tree.nodes if "Roughness" in node.inputs), None)
    if node is not None:
        node.inputs["Roughness"].default_value = 0.3
        (node.inputs.get("Base Color") or node.inputs["Color"]).default_value = (0.7, 0.2, 0.1, 1.0)
    scene.world = scene.world or bpy.data.worlds.new("World")
    scene.world.color = (0.05, 0.06, 0.08)
    camera.data.dof.use_dof = True
    camera.data.dof.focus_object, camera.data.dof.aperture_fstop = mesh, 2.8
    result["edited"] = [lamp.name, material.name, scene.world.name, camera.name]


def steps(arguments, result):
    folder, file = arguments
    result["tabs"] = []
    bpy.ops.wm.open_mainfile(filepath=file, load_ui=False)
    yield 0.5
    scene = bpy.context.scene
    scene.render.engine = "AJAR"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 320, 200, 100
    scene.ajar.samples, scene.ajar.integrator, scene.ajar.viewport_samples = 16, "auto", 4
    edit(scene, result)
    for kind in ("MESH", "LIGHT", "CAMERA"):
        activate(find(kind))
        yield from photograph_tabs(folder, kind.lower(), TABS if kind == "MESH" else ("OBJECT", "DATA"), result)

    # A light hint from the lamp to the object that the camera points at.
    from ajar_render import hints
    lamp = next(thing for thing in scene.objects if thing.type == "LIGHT" and thing.data.type != "SUN" and not thing.hide_render)
    target = find("MESH")
    hints.new_path(bpy.context, [lamp.matrix_world.translation.copy(), target.matrix_world @ target.data.polygons[0].center])
    with window.override():
        result["hints"] = [list(bpy.ops.ajar.check_light_hints())]
    result["hint_status"] = [hints.status_of(curve) for curve in hints.curves_of(scene)]
    yield from photograph_tabs(folder, "hint", ("OBJECT",), result)

    # The rendered view.
    window.look_through_camera()
    window.shade("RENDERED")
    yield 4.0
    window.screenshot(os.path.join(folder, "view.png"))
    window.shade("SOLID")
    yield 0.2

    # Render, pause, continue. The compositor denoises, because every Blender has a node for this.
    with window.override():
        bpy.ops.ajar.denoise_in_compositor()
    scene.render.use_compositing = False   # in Debian's Blender, the node has no denoiser
    scene.ajar.samples = 4000
    scene.ajar.time_limit = 6.0
    with window.override():
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield from until(lambda: bpy.app.is_job_running("RENDER"))
    yield 1.0
    result["runs_while_paused"] = None   # on a busy machine the render may have ended, so that it cannot be paused
    if bpy.app.is_job_running("RENDER"):
        bpy.ops.ajar.pause_render()
        yield 1.0
        window.screenshot(os.path.join(folder, "paused.png"))
        result["runs_while_paused"] = bpy.app.is_job_running("RENDER")
        bpy.ops.ajar.pause_render()
    yield from until(lambda: not bpy.app.is_job_running("RENDER"))
    yield 0.5
    window.screenshot(os.path.join(folder, "rendered.png"))
    from ajar_render import last_render
    statistics = last_render.of(scene)
    result["statistics"] = {name: statistics[name] for name in ("integrator", "render_seconds", "state")}
    bpy.data.images["Render Result"].save_render(os.path.join(folder, "picture.png"))
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "saved.blend"))
    result["engine"] = scene.render.engine
