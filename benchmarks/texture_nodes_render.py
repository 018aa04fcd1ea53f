"""Runs in the Python of a bpy wheel: times a plane with one texture node in Cycles and in Ajar, in turn, and writes OUT.

    python texture_nodes_render.py ZIP OUT.json
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path

import bpy

SIZE, SAMPLES, RUNS = 192, 64, 3
ENGINES = ("CYCLES", "AJAR")
NOISE, VORONOI = "ShaderNodeTexNoise", "ShaderNodeTexVoronoi"
# Names to the type of the node, and properties or values of inputs that differ from Blender's own.
TEXTURES: dict[str, tuple[str, dict[str, object]]] = {
    "none": ("", {}),
    "Noise": (NOISE, {}),
    "Noise, detail 15": (NOISE, {"Detail": 15.0}),
    "Noise, 2D": (NOISE, {"noise_dimensions": "2D"}),
    "Noise, 4D": (NOISE, {"noise_dimensions": "4D"}),
    "Noise, distorted": (NOISE, {"Distortion": 1.0}),
    "Noise, hetero terrain": (NOISE, {"noise_type": "HETERO_TERRAIN", "Detail": 8.0}),
    "Voronoi": (VORONOI, {}),
    "Voronoi, 2D": (VORONOI, {"voronoi_dimensions": "2D"}),
    "Voronoi, 4D": (VORONOI, {"voronoi_dimensions": "4D"}),
    "Voronoi, F2, detail 2": (VORONOI, {"feature": "F2", "Detail": 2.0}),
    "Voronoi, Smooth F1": (VORONOI, {"feature": "SMOOTH_F1"}),
    "Voronoi, Smooth F1, 2D": (VORONOI, {"feature": "SMOOTH_F1", "voronoi_dimensions": "2D"}),
    "Voronoi, Distance to Edge": (VORONOI, {"feature": "DISTANCE_TO_EDGE"}),
    "Voronoi, Minkowski": (VORONOI, {"distance": "MINKOWSKI"}),
    "Wave, distorted": ("ShaderNodeTexWave", {"Distortion": 2.0}),
    "Magic": ("ShaderNodeTexMagic", {}),
    "Brick": ("ShaderNodeTexBrick", {}),
    "Checker": ("ShaderNodeTexChecker", {}),
    "Gradient": ("ShaderNodeTexGradient", {}),
    "White Noise": ("ShaderNodeTexWhiteNoise", {}),
    "Gabor": ("ShaderNodeTexGabor", {}),
    "Sky": ("ShaderNodeTexSky", {}),
}


def make_scene() -> bpy.types.Scene:
    """A plane of 2 m that fills the picture of an orthographic camera; no lamps."""
    bpy.ops.wm.read_homefile(use_empty=True)
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("Plane")
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location.z, camera.data.type, camera.data.ortho_scale = 2.0, "ORTHO", 1.9
    for thing in (bpy.data.objects.new("Plane", mesh), camera):
        scene.collection.objects.link(thing)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = SAMPLES, False, False
    settings = scene.ajar
    settings.use_cycles_settings, settings.samples, settings.integrator, settings.image = False, SAMPLES, "path", "uniform"
    settings.use_denoise, settings.noise_target, settings.time_limit = False, 0.0, 0.0
    return scene


def assign(scene: bpy.types.Scene, kind: str, values: dict[str, object]) -> None:
    """Gives the plane an emission with the colour of the texture."""
    material = bpy.data.materials.new("Texture")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output, emission = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeEmission")
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    if kind:
        texture, coordinates = tree.nodes.new(kind), tree.nodes.new("ShaderNodeTexCoord")
        for name, value in values.items():
            if hasattr(texture, name):
                setattr(texture, name, value)
            else:
                texture.inputs[name].default_value = value
        if "Vector" in texture.inputs:
            tree.links.new(coordinates.outputs["Object"], texture.inputs["Vector"])
        colors = [socket for socket in texture.outputs if socket.enabled and socket.type == "RGBA"]
        tree.links.new((colors or [socket for socket in texture.outputs if socket.enabled])[0], emission.inputs["Color"])
    mesh = scene.objects["Plane"].data
    mesh.materials.clear()
    mesh.materials.append(material)


def seconds(scene: bpy.types.Scene) -> dict[str, float]:
    """CPU seconds of each engine: the fastest of some renders in turn, because other programs can only slow them down."""
    times: dict[str, list[float]] = {engine: [] for engine in ENGINES}
    for _ in range(RUNS):
        for engine in ENGINES:
            scene.render.engine = engine
            start = time.process_time()
            bpy.ops.render.render()
            times[engine].append(time.process_time() - start)
    return {engine: min(found) for engine, found in times.items()}


def main(zip_file: str, out: Path) -> None:
    bpy.ops.extensions.package_install_files(filepath=zip_file, repo="user_default", enable_on_install=True)
    if "cycles" not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="cycles")
    found = {}
    for name, (kind, values) in TEXTURES.items():
        scene = make_scene()
        assign(scene, kind, values)
        found[name] = seconds(scene)
        print(f"{name}: {found[name]}", flush=True)
    out.write_text(json.dumps({"size": SIZE, "samples": SAMPLES, "seconds": found}))
    sys.stdout.flush()
    os._exit(0)


main(sys.argv[1], Path(sys.argv[2]))
