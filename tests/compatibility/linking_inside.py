"""Runs in the Python of a bpy wheel of Blender 4.2 or later: renders scenes with light linking, shadow linking and shadow catchers with both engines, and
writes how far blocks of 8 x 8 pixels are apart to OUT, as JSON: for each scene, the largest excess of a difference over 1 % + 3 standard errors, and the
ratio of the means.

    python linking_inside.py ZIP OUT        ZIP: of the extension; "-": the add-on of the profile
"""

from __future__ import annotations

import json
import math
import os
import sys
import tempfile
import traceback
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import inside

SIZE, BLOCK, SEEDS, MORE_SEEDS = int(os.environ.get("AJAR_SIZE", "48")), 8, 4, 32
SAMPLES = {"CYCLES": 256, "AJAR": 256}
FOLDER = Path(tempfile.mkdtemp())


def new_scene() -> bpy.types.Scene:
    for things in (bpy.data.objects, bpy.data.collections, bpy.data.materials, bpy.data.meshes, bpy.data.lights):
        for thing in list(things):
            things.remove(thing)
    scene = bpy.context.scene
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.max_bounces = 4
    scene.cycles.sample_clamp_indirect = scene.cycles.blur_glossy = 0.0
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.film_transparent = False
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.05, 0.05, 0.06, 1.0)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.location, camera.rotation_euler = (0.0, -9.0, 5.5), (math.radians(60.0), 0.0, 0.0)
    scene.camera = camera
    box("Floor", (0.0, 0.0, -0.5), (10.0, 10.0, 1.0), (0.7, 0.7, 0.7))
    box("Left", (-1.8, 0.0, 0.7), (1.4, 1.4, 1.4), (0.8, 0.3, 0.2))
    box("Right", (1.8, 0.3, 0.6), (1.2, 1.2, 1.2), (0.2, 0.4, 0.8), rotation=0.4)
    return scene


def material(color: tuple[float, float, float], kind: str = "ShaderNodeBsdfDiffuse") -> bpy.types.Material:
    result = bpy.data.materials.new("Material")
    result.use_nodes = True
    tree = result.node_tree
    tree.nodes.clear()
    output, node = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new(kind)
    node.inputs["Color"].default_value = (*color, 1.0)
    tree.links.new(node.outputs[0], output.inputs["Volume" if "Volume" in kind else "Surface"])
    return result


def box(name: str, place: tuple[float, float, float], size: tuple[float, float, float], color: tuple[float, float, float], kind: str = "ShaderNodeBsdfDiffuse",
        rotation: float = 0.0, collection: bpy.types.Collection | None = None) -> bpy.types.Object:
    corners = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    mesh.materials.append(material(color, kind))
    thing = bpy.data.objects.new(name, mesh)
    thing.location, thing.scale, thing.rotation_euler = place, size, (0.0, 0.0, rotation)
    (collection or bpy.context.scene.collection).objects.link(thing)
    return thing


def lamp(kind: str, energy: float, place: tuple[float, float, float] = (0.0, 0.0, 0.0), rotation: tuple[float, float, float] = (0.0, 0.0, 0.0),
         size: float = 0.0) -> bpy.types.Object:
    data = bpy.data.lights.new(kind.title(), kind)
    data.energy = energy
    if kind == "AREA":
        data.size = size
    elif kind == "SUN":
        data.angle = size
    else:
        data.shadow_soft_size = size
    thing = bpy.data.objects.new(kind.title(), data)
    thing.location, thing.rotation_euler = place, rotation
    bpy.context.scene.collection.objects.link(thing)
    return thing


def collection(*things: bpy.types.Object, excluded: tuple[bpy.types.Object, ...] = ()) -> bpy.types.Collection:
    result = bpy.data.collections.new("Links")
    for thing in things + excluded:
        result.objects.link(thing)
    for thing, entry in zip(result.objects, result.collection_objects):
        entry.light_linking.link_state = "EXCLUDE" if thing in excluded else "INCLUDE"
    return result


def named(name: str) -> bpy.types.Object:
    return bpy.data.objects[name]


def receivers(scene: bpy.types.Scene) -> None:
    area = lamp("AREA", 300.0, (3.0, -1.0, 4.0), (0.0, math.radians(40.0), 0.0), 2.0)
    area.light_linking.receiver_collection = collection(named("Floor"), named("Left"))
    point = lamp("POINT", 250.0, (-2.0, -3.0, 3.0), size=0.2)
    point.light_linking.receiver_collection = collection(excluded=(named("Left"),))
    lamp("SUN", 0.5, rotation=(0.5, 0.2, 0.0))


def emissive_mesh(scene: bpy.types.Scene) -> None:
    shine = box("Shine", (0.0, 0.0, 2.4), (0.8, 0.8, 0.8), (9.0, 8.0, 6.0), "ShaderNodeEmission")
    shine.light_linking.receiver_collection = collection(named("Floor"), named("Right"))


def nested_collections(scene: bpy.types.Scene) -> None:
    point = lamp("POINT", 400.0, (0.0, -2.0, 4.0), size=0.1)
    outer = collection(named("Left"))
    inner = collection(named("Left"), named("Right"))
    outer.children.link(inner)
    outer.collection_children[0].light_linking.link_state = "EXCLUDE"
    point.light_linking.receiver_collection = outer


def empty_collection(scene: bpy.types.Scene) -> None:
    point = lamp("POINT", 400.0, (0.0, -2.0, 4.0), size=0.1)
    point.light_linking.receiver_collection = collection()
    point.light_linking.blocker_collection = collection()


def volume(scene: bpy.types.Scene) -> None:
    fog = box("Fog", (0.0, -1.0, 1.2), (2.0, 2.0, 2.0), (0.8, 0.8, 0.8), "ShaderNodeVolumeScatter")
    fog.data.materials[0].node_tree.nodes["Volume Scatter"].inputs["Density"].default_value = 0.6
    first = lamp("POINT", 300.0, (3.0, -2.0, 4.0), size=0.0)
    first.light_linking.receiver_collection = collection(fog)
    second = lamp("POINT", 300.0, (-3.0, -2.0, 4.0), size=0.0)
    second.light_linking.receiver_collection = collection(excluded=(fog,))


def instances(scene: bpy.types.Scene) -> None:
    source = bpy.data.collections.new("Source")
    box("Small", (0.0, 0.0, 0.5), (0.8, 0.8, 0.8), (0.3, 0.8, 0.3), collection=source)
    places = []
    for x in (-0.6, 0.6):
        empty = bpy.data.objects.new("Instancer", None)
        empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", source, (x, -2.2, 0.0)
        scene.collection.objects.link(empty)
        places.append(empty)
    point = lamp("POINT", 300.0, (0.0, -4.0, 4.0), size=0.1)
    point.light_linking.receiver_collection = collection(places[0], named("Left"))
    lamp("SUN", 0.5, rotation=(0.5, 0.2, 0.0))


def blockers(scene: bpy.types.Scene) -> None:
    point = lamp("POINT", 500.0, (0.5, -0.5, 5.0), size=0.0)
    point.light_linking.blocker_collection = collection(named("Left"))
    sun = lamp("SUN", 1.5, rotation=(0.6, 0.7, 0.0))
    sun.light_linking.blocker_collection = collection(excluded=(named("Right"),))


def receivers_and_blockers(scene: bpy.types.Scene) -> None:
    spot = lamp("SPOT", 900.0, (2.5, -2.0, 5.0), (math.radians(20.0), math.radians(28.0), 0.0), 0.0)
    spot.data.spot_size = 1.2
    spot.light_linking.receiver_collection = collection(named("Floor"), named("Left"))
    spot.light_linking.blocker_collection = collection(named("Left"))
    lamp("SUN", 0.4, rotation=(0.5, 0.2, 0.0))


def catcher(scene: bpy.types.Scene) -> None:
    scene.render.film_transparent = True
    named("Floor").is_shadow_catcher = True
    lamp("SUN", 3.0, rotation=(0.6, 0.7, 0.0), size=0.1)


def catcher_over_world(scene: bpy.types.Scene) -> None:
    named("Floor").is_shadow_catcher = True
    lamp("AREA", 300.0, (3.0, -1.0, 4.0), (0.0, math.radians(40.0), 0.0), 2.0)


def mirroring_catcher(scene: bpy.types.Scene) -> None:
    scene.render.film_transparent = True
    floor = named("Floor")
    floor.is_shadow_catcher = True
    floor.data.materials[0] = material((0.8, 0.8, 0.8), "ShaderNodeBsdfGlossy")
    floor.data.materials[0].node_tree.nodes["Glossy BSDF"].inputs["Roughness"].default_value = 0.3
    lamp("SUN", 3.0, rotation=(0.6, 0.7, 0.0), size=0.1)


SCENES: tuple[Callable[[bpy.types.Scene], None], ...] = (receivers, emissive_mesh, nested_collections, empty_collection, volume, instances, blockers, receivers_and_blockers, catcher,
                                                         catcher_over_world, mirroring_catcher)


def picture(scene: bpy.types.Scene, engine: str, seed: int) -> np.ndarray:
    """Means of blocks, linear RGBA."""
    job = {"blend": bpy.data.filepath, "engine": engine, "samples": SAMPLES[engine], "seed": seed, "percentage": 100}
    image = inside.render(job, FOLDER / "image")
    blocks = SIZE // BLOCK
    return image.reshape(blocks, BLOCK, blocks, BLOCK, 4).mean(axis=(1, 3))


def difference(scene: bpy.types.Scene, seeds: range) -> dict[str, float]:
    """How far the means of both engines over these seeds are apart."""
    means, variances = {}, {}
    for engine in ("CYCLES", "AJAR"):
        pictures = np.array([picture(scene, engine, seed) for seed in seeds])
        means[engine], variances[engine] = pictures.mean(axis=0), pictures.var(axis=0, ddof=1) / len(seeds)
    # The variance of few seeds is uncertain: that of all blocks is a lower bound.
    variance = sum(np.maximum(found, found.mean(axis=(0, 1))) for found in variances.values())
    allowed = 0.01 * np.abs(means["CYCLES"]) + 3.0 * np.sqrt(variance) + 1e-4
    return {"excess": float((np.abs(means["AJAR"] - means["CYCLES"]) / allowed).max()), "allowed": float(np.median(allowed[..., :3] / np.maximum(means["CYCLES"][..., :3], 1e-3))),
            "ratio": float(means["AJAR"][..., :3].sum() / means["CYCLES"][..., :3].sum())}


def compare(fill: Callable[[bpy.types.Scene], None]) -> dict[str, float]:
    """The difference with SEEDS seeds. Where it is too large, that of MORE_SEEDS other seeds decides: the noise of caustics is so skewed that the variance
    of four seeds is often too small, and a real difference is seen better with more seeds."""
    scene = new_scene()
    fill(scene)
    found = difference(scene, range(1, SEEDS + 1))
    return found if found["excess"] <= 1.0 else difference(scene, range(SEEDS + 1, SEEDS + MORE_SEEDS + 1))


def main(scenes: tuple[Callable[[bpy.types.Scene], None], ...]) -> None:
    zip_file, out = sys.argv[-2:]
    try:
        inside.install(None if zip_file == "-" else zip_file)
        bpy.context.scene.render.engine = "CYCLES"
        bpy.context.scene.view_settings.view_transform = "Raw" if "Raw" in bpy.types.ColorManagedViewSettings.bl_rna.properties["view_transform"].enum_items else "Standard"
        Path(out).write_text(json.dumps({fill.__name__: compare(fill) for fill in scenes}, indent=1))
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
        os._exit(1)
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main(SCENES)
