"""Runs inside one Blender: renders every probe with Ajar and with Cycles, and writes the differences of the images and the messages of Ajar.

    PYTHONPATH=build/release/python blender -b --factory-startup --python-exit-code 1 --python tools/coverage/probe.py -- OUT.json
    PYTHONPATH=<unpacked zip> python tools/coverage/probe.py OUT.json          (in the environment of a bpy wheel)

Each probe is a sphere 10 pixels wide below a lamp and a sky with a gradient. Both engines render all spheres in one image, with two seeds. The spheres
that differ without a known reason are rendered again with more samples, and the second images decide: with a thousand probes, noise alone makes some
differ.

The difference of two images a and b of a sphere, each rendered twice, is the root of the mean of (a1 - b1)(a2 - b2) over its pixels and colours,
relative to its brightness. The noise of the two factors is independent, so that it adds nothing in expectation. The error of this mean is also
written.
"""

from __future__ import annotations

import json
import math
import sys
import tempfile
from pathlib import Path
from typing import Any

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[2])]

import judge                                                   # noqa: E402
import probes                                                  # noqa: E402
from python_addon import properties                            # noqa: E402
from python_addon.ajar_module import ajar                     # noqa: E402
from python_addon.export import export_scene                   # noqa: E402
from python_addon.headless import Options                      # noqa: E402

TILE, BLOCK, SPACING = 12, 2, 2.4   # in pixels, the last in radii: distance between spheres
SAMPLES, SAMPLES_AGAIN = 64, 1024


def build_scene(materials: list[str], samples: int) -> int:
    """Build a grid of spheres, seen vertically from above, in a scene without other objects. Returns the number of spheres in a row."""
    scene = bpy.context.scene
    for left in list(scene.collection.objects):
        bpy.data.objects.remove(left)
    row = math.ceil(math.sqrt(len(materials)))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=1.0)
    model = bpy.context.object
    bpy.ops.object.shade_smooth()
    colors = model.data.color_attributes.new("Col", "FLOAT_COLOR", "POINT")
    for i, vertex in enumerate(model.data.vertices):
        colors.data[i].color = (0.5 + 0.5 * vertex.co.x, 0.5 + 0.5 * vertex.co.y, 0.5 + 0.5 * vertex.co.z, 1.0)
    model.data.materials.append(None)
    for i, name in enumerate(materials):
        thing = bpy.data.objects.new(f"sphere {i}", model.data)
        thing.location = (SPACING * (i % row), SPACING * (i // row), 0.0)
        thing.rotation_euler = (0.5, 0.3, 0.2)
        thing.color = (0.3, 0.6, 0.9, 1.0)
        thing.pass_index = 3
        scene.collection.objects.link(thing)
        thing.material_slots[0].link = "OBJECT"
        thing.material_slots[0].material = bpy.data.materials.get(name)
    bpy.data.objects.remove(model)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", SPACING * row
    camera.location = (SPACING * (row - 1) / 2, SPACING * (row - 1) / 2, 10.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "SUN"))
    lamp.data.energy, lamp.data.angle, lamp.rotation_euler = 2.0, 0.5, (0.6, 0.3, 0.0)
    scene.collection.objects.link(lamp)
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    coordinates, ramp = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeVectorMath")
    ramp.operation = "MULTIPLY_ADD"
    ramp.inputs[1].default_value, ramp.inputs[2].default_value = (0.3, 0.2, 0.25), (0.5, 0.4, 0.6)
    links.new(coordinates.outputs["Generated"], ramp.inputs[0])
    links.new(ramp.outputs[0], nodes["Background"].inputs["Color"])
    render = scene.render
    render.resolution_x = render.resolution_y = TILE * row
    render.resolution_percentage = 100
    render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = samples, False, False
    cycles.max_bounces = cycles.transmission_bounces = cycles.glossy_bounces = cycles.volume_bounces = 4
    cycles.sample_clamp_indirect, cycles.blur_glossy = 0.0, 0.0
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    return row


def by_cycles(seed: int) -> np.ndarray:
    scene = bpy.context.scene
    scene.cycles.seed = seed
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = f"{folder}/cycles.exr"
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        image.colorspace_settings.name = "Non-Color"
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
        width, height = image.size
        bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)[..., :3]


def by_ajar(seed: int) -> tuple[np.ndarray, list[tuple[str, str]]]:
    scene = bpy.context.scene
    frame = scene.frame_current
    context = export_scene(bpy.context.evaluated_depsgraph_get(), Options({"samples": scene.cycles.samples, "integrator": "path", "seed": seed}), ["Combined"], scene.camera,
                           lambda: False, lambda step: None, lambda at, part: scene.frame_set(at, subframe=part))
    if scene.render.use_motion_blur:
        scene.frame_set(frame)
    session = ajar.Session()
    session.start(context.description)
    while not session.wait(0.5):
        pass
    error = session.take_error()
    if error:
        raise RuntimeError(error)
    said = [*context.warnings, *((d.object, d.message) for d in session.diagnostics())]
    return np.asarray(session.snapshot("Combined"))[..., :3], said


def blocks(picture: np.ndarray, index: int, row: int) -> np.ndarray:
    """Means of the blocks in the square of one sphere, for each colour. Rows count from the bottom."""
    x, y, count = TILE * (index % row), TILE * (index // row), TILE // BLOCK
    square = picture[y:y + TILE, x:x + TILE].astype(np.float64)
    return square.reshape(count, BLOCK, count, BLOCK, 3).mean(axis=(1, 3)).ravel()


def difference(a: list[np.ndarray], b: list[np.ndarray]) -> tuple[float, float]:
    """The difference of two spheres, and a bound that noise alone exceeds with probability 1/1000 (three standard errors)."""
    scale = max(np.mean(a), np.mean(b), 0.02)
    products = (a[0] - b[0]) * (a[1] - b[1]) / scale ** 2
    noise = (np.square(a[0] - a[1]).mean() + np.square(b[0] - b[1]).mean()) / (2.0 * scale ** 2)   # variance of a factor
    return math.sqrt(max(products.mean(), 0.0)), math.sqrt(3.0 * noise / math.sqrt(products.size))


class Rendered:
    """The images of some materials by both engines, each with two seeds."""

    def __init__(self, materials: list[str], samples: int) -> None:
        self.row = build_scene(materials, samples)
        pictures = [by_ajar(seed) for seed in (1, 2)]
        self.ours, self.theirs = [picture for picture, _ in pictures], [by_cycles(seed) for seed in (1, 2)]
        self.said: dict[str, list[str]] = {}
        for name, message in pictures[0][1]:
            self.said.setdefault(name, []).append(message)

    def spheres(self, pictures: list[np.ndarray], index: int) -> list[np.ndarray]:
        return [blocks(picture, index, self.row) for picture in pictures]

    def compared(self, index: int) -> dict[str, Any]:
        ours, theirs = self.spheres(self.ours, index), self.spheres(self.theirs, index)
        found, error = difference(ours, theirs)
        return {"difference": found, "error": error, "means": [float(np.mean(ours)), float(np.mean(theirs))]}


def main(path: str) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if "cycles" not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="cycles")
    properties.register()
    builder = probes.Builder()
    builder.add_all()
    asked = builder.probes
    rendered = Rendered([probe.material for probe in asked], SAMPLES)
    result: list[dict[str, Any]] = []
    plain, context = 0, 0
    for i, probe in enumerate(asked):
        plain = i if probe.kind == "plain" else plain
        context = i if probe.kind == "context" else context
        same = (probe.node, probe.name, probe.value) == (asked[context].node, asked[context].name, asked[context].value)
        reference = context if same and context < i else plain
        change, change_error = difference(rendered.spheres(rendered.theirs, i), rendered.spheres(rendered.theirs, reference))
        result.append({"node": probe.node, "kind": probe.kind, "name": probe.name, "value": probe.value, "shown": probe.shown,
                       "said": rendered.said.get(probe.material, []), "change": change, "change_error": change_error} | rendered.compared(i))
    # Spheres that differ for known reasons are left out: they light their neighbours.
    wrong = [i for i, entry in enumerate(result) if judge.verdict(entry, bpy.app.version_string).state == "wrong"]
    if wrong:
        again = Rendered([asked[i].material for i in wrong], SAMPLES_AGAIN)
        for index, i in enumerate(wrong):
            result[i] |= again.compared(index)
    Path(path).write_text(json.dumps({"blender": bpy.app.version_string, "probes": result}, indent=0), encoding="utf-8")


if __name__ == "__main__":
    probes.run(main)
