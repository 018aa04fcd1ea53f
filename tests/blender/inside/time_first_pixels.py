"""Measures the time from the dependency graph to the first pixels of Blender's default scene."""

import time

import bpy
from ajar_render.ajar_module import ajar
from ajar_render.export import export_scene
from ajar_render.headless import Options

MAX_SECONDS = 0.15
WIDTH, HEIGHT = 480, 270   # a quarter of the frame in width and height, as the first picture of a viewport


def seconds_to_first_pixels(depsgraph: bpy.types.Depsgraph) -> float:
    started = time.process_time()  # CPU time of all threads, without other processes
    exported = export_scene(depsgraph, Options(), ["Combined"], depsgraph.scene_eval.camera, lambda: False, lambda step: None)
    session = ajar.Session()
    session.start(exported.description)
    assert session.wait(60.0)
    seconds = time.process_time() - started
    assert session.take_error() == ""
    assert float(session.snapshot("Combined")[..., :3].mean()) > 0.01
    return seconds


def test_first_pixels_of_the_default_cube_need_little_time():
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "AJAR"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH, HEIGHT, 100
    scene.ajar.samples = 1
    depsgraph = bpy.context.evaluated_depsgraph_get()
    depsgraph.update()
    seconds = min(seconds_to_first_pixels(depsgraph) for _ in range(3))
    print(f"{WIDTH} x {HEIGHT} pixels after {seconds:.3f} s")
    assert seconds < MAX_SECONDS
