"""Runs in the Python of a bpy wheel: renders small set-ups with Cycles and with Ajar, and prints a line of JSON for each.

    python noise_render.py ZIP OUT SAMPLES SEEDS [PART_OF_A_NAME ...]

A set-up is one kind of light on one kind of material, so that the noise of a sample says how well this pair is sampled.
"""

from __future__ import annotations

import functools
import json
import math
import os
import sys
import traceback
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from strangers_render import prepare, render_with

SIDE = 48   # pixels
SUN = math.radians(0.53)


# ---- Parts of a set-up ------------------------------------------------------------------------------------------------

def material(node: str, socket: str = "Surface", **inputs: object) -> bpy.types.Material:
    made = bpy.data.materials.new("Material")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new(node), tree.nodes.new("ShaderNodeOutputMaterial")
    for name, value in inputs.items():
        shader.inputs[name.replace("_", " ")].default_value = value
    tree.links.new(shader.outputs[0], output.inputs[socket])
    return made


def plane(of: bpy.types.Material, size: float = 20.0, place: tuple = (0, 0, 0), turned: tuple = (0, 0, 0)) -> None:
    bpy.ops.mesh.primitive_plane_add(size=size, location=place, rotation=turned)
    bpy.context.object.data.materials.append(of)


def ball(of: bpy.types.Material, radius: float, place: tuple) -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=place, segments=32, ring_count=16)
    bpy.context.object.data.materials.append(of)
    bpy.ops.object.shade_smooth()


def box(of: bpy.types.Material, size: tuple, place: tuple = (0, 0, 0)) -> None:
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=place)
    bpy.context.object.scale = size
    bpy.context.object.data.materials.append(of)


def show_plane(surface: Callable[[], bpy.types.Material]) -> None:
    plane(surface())


def room() -> None:
    walls, quarter = material("ShaderNodeBsdfDiffuse"), math.pi / 2
    for place, turned in (((0, 0, 0), (0, 0, 0)), ((0, 0, 3), (math.pi, 0, 0)), ((0, 2, 1.5), (quarter, 0, 0)), ((-2, 0, 1.5), (0, quarter, 0)), ((2, 0, 1.5), (0, -quarter, 0))):
        plane(walls, 4.0, place, turned)


def lamp(kind: str, place: tuple = (0, 0, 2), turned: tuple = (0, 0, 0), energy: float = 100.0, **values: object) -> None:
    data = bpy.data.lights.new("Lamp", kind)
    data.energy = energy
    for name, value in values.items():
        setattr(data, name, value)
    thing = bpy.data.objects.new("Lamp", data)
    thing.location, thing.rotation_euler = place, turned
    bpy.context.scene.collection.objects.link(thing)


def world(strength: float = 0.0) -> bpy.types.NodeTree:
    made = bpy.data.worlds.new("World")
    bpy.context.scene.world = made
    made.use_nodes = True
    background = made.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    background.inputs["Strength"].default_value = strength
    return made.node_tree


def sky(disc: bool = True) -> None:
    tree = world(0.1)
    node = tree.nodes.new("ShaderNodeTexSky")
    node.sun_disc, node.sun_elevation, node.sun_rotation = disc, 0.6, math.pi
    tree.links.new(node.outputs[0], tree.nodes["Background"].inputs["Color"])


def many_balls() -> None:
    glowing = material("ShaderNodeEmission", Strength=20.0)
    for i in range(25):
        ball(glowing, 0.05, (i % 5 - 2, i // 5 - 2, 1))


def many_lamps() -> None:
    for i in range(64):
        lamp("POINT", (i % 8 - 4, i // 8 - 4, 1), energy=20.0, shadow_soft_size=0.05)


def photograph() -> None:
    """A sky with a bright sun of its real size, as an image."""
    width, height = 2048, 1024
    theta, phi = np.meshgrid(math.pi * (np.arange(height) + 0.5) / height, 2 * math.pi * (np.arange(width) + 0.5) / width, indexing="ij")
    direction = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    towards = np.array([math.cos(0.7) * math.cos(1.3), math.cos(0.7) * math.sin(1.3), math.sin(0.7)])
    angle = np.arccos(np.clip(direction @ towards, -1, 1))
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = np.where(direction[..., 2:] > 0, np.array([0.4, 0.6, 0.9]), 0.05)
    pixels[..., :3] += 5e4 * np.clip((0.5 * SUN - angle) / 0.001 + 0.5, 0, 1)[..., None]
    image = bpy.data.images.new("Sky", width, height, float_buffer=True)
    image.pixels.foreach_set(pixels[::-1].ravel())
    image.pack()
    tree = world(1.0)
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = image
    tree.links.new(node.outputs[0], tree.nodes["Background"].inputs["Color"])


def look(elevation: float, distance: float = 6.0, width: float = 2.0) -> None:
    data = bpy.data.cameras.new("Camera")
    data.type, data.ortho_scale = "ORTHO", width
    thing = bpy.data.objects.new("Camera", data)
    angle = math.radians(elevation)
    thing.location, thing.rotation_euler = (0, -distance * math.cos(angle), distance * math.sin(angle)), (math.pi / 2 - angle, 0, 0)
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.scene.camera = thing


# ---- Set-ups ------------------------------------------------------------------------------------------------------------

LIGHTS: dict[str, Callable[[], None]] = {
    "point lamp": lambda: lamp("POINT", shadow_soft_size=0.1), "large point lamp": lambda: lamp("POINT", shadow_soft_size=1.0),
    "spot": lambda: lamp("SPOT", spot_size=0.8, spot_blend=0.5, shadow_soft_size=0.1), "sun": lambda: lamp("SUN", turned=(-0.6, 0, 0), energy=3.0, angle=SUN),
    "area lamp": lambda: lamp("AREA", (0, 1, 2), (-0.4, 0, 0), size=1.0), "large area lamp": lambda: lamp("AREA", size=6.0), "area lamp with spread": lambda: lamp("AREA", size=1.0, spread=0.5),
    "emissive ball": lambda: ball(material("ShaderNodeEmission", Strength=20.0), 0.2, (0, 0.5, 1.5)),
    "25 emissive balls": many_balls,
    "64 point lamps": many_lamps,
    "even world": lambda: world(1.0), "sky": sky, "sky without a disc": lambda: sky(False), "photograph of a sky": photograph,
}
PLAIN = ("sun", "area lamp", "emissive ball", "sky")
SURFACES: dict[str, Callable[[], bpy.types.Material]] = {
    "glossy 0.1": lambda: material("ShaderNodeBsdfGlossy", Roughness=0.1), "principled 0.3": lambda: material("ShaderNodeBsdfPrincipled", Roughness=0.3),
    "translucent": lambda: material("ShaderNodeBsdfTranslucent"), "subsurface": lambda: material("ShaderNodeSubsurfaceScattering", Scale=0.3),
    "principled subsurface": lambda: material("ShaderNodeBsdfPrincipled", Subsurface_Weight=1.0, Subsurface_Scale=0.1),
}


def set_ups() -> dict[str, Callable[[], None]]:
    found: dict[str, Callable[[], None]] = {}

    def add(name: str, light: str, objects: Callable[[], None], *camera: float) -> None:
        def make() -> None:
            world()
            objects()
            LIGHTS[light]()
            look(*camera)

        found[f"{name}, {light}"] = make

    def glass_on_a_plane() -> None:
        plane(material("ShaderNodeBsdfDiffuse"))
        ball(material("ShaderNodeBsdfGlass", Roughness=0.3), 0.7, (0, 0, 0.7))

    for light in LIGHTS:
        add("diffuse plane", light, lambda: plane(material("ShaderNodeBsdfDiffuse")), 90)
    for name, surface in SURFACES.items():
        for light in PLAIN:
            add(f"{name} plane", light, functools.partial(show_plane, surface), -45 if name == "translucent" else 45)
    for light in PLAIN:
        add("subsurface ball", light, lambda: ball(material("ShaderNodeSubsurfaceScattering", Scale=0.1), 0.6, (0, 0, 0)), 30)
        add("glass ball on a plane", light, glass_on_a_plane, 30, 6, 3)
    for light in ("point lamp", "area lamp", "emissive ball", "even world"):
        add("room", light, room, 20, 1.9)
    for light in ("point lamp", "spot", "sun", "area lamp", "even world"):
        add("fog", light, lambda: box(material("ShaderNodeVolumePrincipled", "Volume", Density=0.2), (8, 8, 8)), 10, 6, 3)
        add("dense cloud", light, lambda: box(material("ShaderNodeVolumePrincipled", "Volume", Density=4.0), (1.4, 1.4, 1.4)), 30, 6, 3)
    return found


def measure(out: Path, samples: int, seeds: int) -> dict:
    """For each engine: the mean, the relative standard deviation of one sample, and CPU seconds."""
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    prepare(scene, samples, SIDE)
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = scene.cycles.transmission_bounces = 6
    scene.cycles.volume_bounces = 1
    result = {}
    for engine in ("CYCLES", "AJAR"):
        renders = [render_with(engine, 1 + seed, out) for seed in range(seeds)]
        pixels = np.array([render[0].mean(axis=-1) for render in renders], dtype=np.float64)
        result[engine] = {"mean": float(pixels.mean()), "deviation": math.sqrt(samples * pixels.var(axis=0, ddof=1).mean()) / pixels.mean(),
                          "cpu": sum(render[2] for render in renders)}
    return result


def main(zip_file: str, out: str, samples: str, seeds: str, *parts: str) -> None:
    try:
        bpy.ops.extensions.package_install_files(filepath=zip_file, repo="user_default", enable_on_install=True)
        bpy.ops.preferences.addon_enable(module="cycles")
        for name, make in set_ups().items():
            if parts and not any(part in name for part in parts):
                continue
            for kind in (bpy.data.objects, bpy.data.materials, bpy.data.worlds, bpy.data.lights, bpy.data.cameras, bpy.data.images, bpy.data.meshes):
                for thing in list(kind):
                    kind.remove(thing)
            make()
            print("NOISE " + json.dumps({"name": name, **measure(Path(out), int(samples), int(seeds))}), flush=True)
    except Exception:
        traceback.print_exc()
        sys.stdout.flush()
        os._exit(1)
    os._exit(0)


if __name__ == "__main__":
    main(*sys.argv[1:])
