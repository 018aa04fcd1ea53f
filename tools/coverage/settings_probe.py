"""Runs inside one Blender: changes each setting of the scene that Ajar supports or reports, renders with Ajar and with Cycles, and writes the
differences of the images and the messages of Ajar.

    PYTHONPATH=build/release/python blender -b --factory-startup --python-exit-code 1 --python tools/coverage/settings_probe.py -- OUT.json
    PYTHONPATH=<unpacked zip> python tools/coverage/settings_probe.py OUT.json          (in the environment of a bpy wheel)

The scene is small: a diffuse, a glossy and a glass body on a floor with a pattern, one of which moves, and a lamp of each type. The list of settings
comes from Blender; tests/blender/panels/inventory.py states how each is handled. The form of the result is that of probe.py.

With AJAR_SHORT_PROBES=1 in the environment, every second setting is probed, and a quarter of the samples is enough where they show, with three standard
errors, that the difference is below the limit. Fewer changes of the image of Cycles are found than with all samples.
"""

from __future__ import annotations

import json
import math
import os
import sys
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(Path(__file__).resolve().parent), str(ROOT / "tests" / "blender" / "panels")]

import inventory                                               # noqa: E402
import judge                                                   # noqa: E402
import probe                                                   # noqa: E402
import probes                                                  # noqa: E402
from probes import other                                   # noqa: E402

WIDTH, HEIGHT, SAMPLES = 40, 30, 128
SHORT = "AJAR_SHORT_PROBES" in os.environ

# Other settings that are required for a setting to have an effect.
CONTEXT: dict[str, dict[str, object]] = {
    "RenderSettings.motion_blur*": {"render.use_motion_blur": True}, "RenderSettings.border*": {"render.use_border": True}, "RenderSettings.use_border": {"render.border_max_x": 0.6},
    "RenderSettings.use_crop_to_border": {"render.use_border": True, "render.border_max_x": 0.6},
    "CyclesObjectSettings.*motion*": {"render.use_motion_blur": True}, "CyclesRenderSettings.motion_blur_position": {"render.use_motion_blur": True},
    "Camera.ortho_scale": {"camera.type": "ORTHO"}, "Camera.sensor_height": {"camera.sensor_fit": "VERTICAL"},
    "CameraDOFSettings.aperture_rotation": {"camera.dof.use_dof": True, "camera.dof.focus_distance": 4.0, "camera.dof.aperture_fstop": 0.2, "camera.dof.aperture_blades": 3},
    "CameraDOFSettings.*": {"camera.dof.use_dof": True, "camera.dof.focus_distance": 4.0, "camera.dof.aperture_fstop": 0.2},
    "CyclesCameraSettings.fisheye_fov": {"camera.type": "PANO", "camera.cycles.panorama_type": "FISHEYE_EQUIDISTANT"},
    "CyclesCameraSettings.fisheye_lens": {"camera.type": "PANO", "camera.cycles.panorama_type": "FISHEYE_EQUISOLID"},
    "CyclesCameraSettings.fisheye_polynomial_*": {"camera.type": "PANO", "camera.cycles.panorama_type": "FISHEYE_LENS_POLYNOMIAL"},
    "Camera.fisheye_polynomial_*": {"camera.type": "PANO", "camera.panorama_type": "FISHEYE_LENS_POLYNOMIAL"},
    "Camera.central_cylindrical_*": {"camera.type": "PANO", "camera.panorama_type": "CENTRAL_CYLINDRICAL"},
    "CyclesCameraSettings.*": {"camera.type": "PANO", "camera.cycles.panorama_type": "EQUIRECTANGULAR"},
    "Camera.panorama_type": {"camera.type": "PANO"}, "Camera.fisheye_fov": {"camera.type": "PANO", "camera.panorama_type": "FISHEYE_EQUIDISTANT"},
    "Camera.fisheye_lens": {"camera.type": "PANO", "camera.panorama_type": "FISHEYE_EQUISOLID"}, "Camera.l*itude_*": {"camera.type": "PANO", "camera.panorama_type": "EQUIRECTANGULAR"},
    "CyclesRenderSettings.film_transparent*": {"render.film_transparent": True},
    "CyclesRenderSettings.rolling_shutter_duration": {"render.use_motion_blur": True, "scene.cycles.rolling_shutter_type": "TOP"},
    "CyclesRenderSettings.rolling_shutter_type": {"render.use_motion_blur": True},
    "CyclesRenderSettings.ao_*": {"scene.cycles.use_fast_gi": True}, "CyclesRenderSettings.fast_gi_method": {"scene.cycles.use_fast_gi": True},
    "CyclesObjectSettings.ao_distance": {"scene.cycles.use_fast_gi": True},
    "CyclesRenderSettings.camera_cull_margin": {"render.use_simplify": True, "scene.cycles.use_camera_cull": True},
    "CyclesRenderSettings.distance_cull_margin": {"render.use_simplify": True, "scene.cycles.use_distance_cull": True},
    "CyclesRenderSettings.use_*_cull": {"render.use_simplify": True}, "CyclesRenderSettings.texture_*": {"render.use_simplify": True},
    "CyclesObjectSettings.use_camera_cull": {"render.use_simplify": True, "scene.cycles.use_camera_cull": True},
    "CyclesObjectSettings.use_distance_cull": {"render.use_simplify": True, "scene.cycles.use_distance_cull": True},
    "CyclesRenderSettings.sample_subset_length": {"scene.cycles.use_sample_subset": True},
    "CyclesRenderLayerSettings.denoising_pass_*": {"layer.cycles.denoising_store_passes": True},
    "Mesh.texspace_*": {"mesh.use_auto_texspace": False}, "Mesh.*auto_texspace": {"mesh.use_auto_texspace": False, "mesh.texspace_size": (0.5, 0.7, 1.5)},
    "Material.diffuse_color": {"material.use_nodes": False}, "World.color": {"world.use_nodes": False},
    "*Light.temperature": {"lamp.use_temperature": True}, "*Light.use_temperature": {"lamp.temperature": 3000.0},
    # One lamp only, so that the others do not hide its effect.
    "PointLight.*": {"sun.energy": 0.0, "spot.energy": 0.0, "area.energy": 0.0}, "SunLight.*": {"point.energy": 0.0, "spot.energy": 0.0, "area.energy": 0.0},
    "SpotLight.*": {"point.energy": 0.0, "sun.energy": 0.0, "area.energy": 0.0}, "AreaLight.*": {"point.energy": 0.0, "sun.energy": 0.0, "spot.energy": 0.0},
}
# Settings for which the usual changed value would have too small an effect.
VALUES: dict[str, list[object]] = {
    "Camera.clip_start": [7.5], "Camera.clip_end": [8.5], "*.fisheye_polynomial_k0": [0.1], "*.fisheye_polynomial_k1": [-0.02], "*.fisheye_polynomial_k2": [-0.0002],
    "*.fisheye_polynomial_k3": [1e-5], "*.fisheye_polynomial_k4": [-3e-7], "SunLight.angle": [1.5], "SpotLight.spot_blend": [0.9], "*Light.shadow_soft_size": [1.2], "AreaLight.size_y": [3.0],
    "RenderSettings.motion_blur_shutter": [2.0], "CyclesRenderSettings.*_bounces": [0], "Mesh.texspace_location": [(0.6, 0.4, -0.5)],
}
# Settings that other tests or other scenes cover.
SKIPPED = ("resolution_*", "*samples", "seed", "threads*", "engine", "use_pass_*", "frame_*", "time_limit", "*adaptive*", "pass_*", "use_layer_samples", "use_nodes", "hide_*", "use", "use_guiding", "use_multiview", "views_format",
           "matrix_*", "location", "rotation_*", "scale", "dimensions", "delta_*")   # the last ones are exported as one matrix


def build_scene() -> dict[str, object]:
    """Build the scene. Returns the owners of settings, by the name in CONTEXT and the struct."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if "cycles" not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="cycles")
    probe.properties.register()
    scene = bpy.context.scene

    def material(name: str, type_: str, color: tuple[float, float, float], **inputs: float) -> bpy.types.Material:
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        nodes = made.node_tree.nodes
        nodes.clear()
        node, end = nodes.new(type_), nodes.new("ShaderNodeOutputMaterial")
        node.inputs["Color"].default_value = (*color, 1.0)
        for key, value in inputs.items():
            node.inputs[key].default_value = value
        made.node_tree.links.new(node.outputs[0], end.inputs["Surface"])
        return made

    def body(name: str, of: bpy.types.Material, place: tuple[float, float, float]) -> bpy.types.Object:
        bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, location=place)
        made = bpy.context.object
        bpy.ops.object.shade_smooth()
        made.name = name
        made.data.materials.append(of)
        return made

    subject = body("subject", material("matte", "ShaderNodeBsdfDiffuse", (0.7, 0.3, 0.2)), (0.0, 0.0, 1.0))
    tree = subject.data.materials[0].node_tree
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], tree.nodes["Diffuse BSDF"].inputs["Color"])
    body("glossy", material("glossy", "ShaderNodeBsdfGlossy", (0.7, 0.7, 0.6), Roughness=0.4), (-2.1, 0.6, 1.0))
    body("glass", material("glass", "ShaderNodeBsdfGlass", (0.9, 0.9, 0.9), Roughness=0.6), (2.1, 0.6, 1.0))
    bpy.ops.mesh.primitive_plane_add(size=12.0)
    floor = material("floor", "ShaderNodeBsdfDiffuse", (0.6, 0.6, 0.6))
    checker = floor.node_tree.nodes.new("ShaderNodeTexChecker")
    checker.inputs["Color1"].default_value, checker.inputs["Color2"].default_value = (0.7, 0.6, 0.4, 1.0), (0.2, 0.3, 0.5, 1.0)
    floor.node_tree.links.new(checker.outputs["Color"], floor.node_tree.nodes["Diffuse BSDF"].inputs["Color"])
    bpy.context.object.data.materials.append(floor)
    for frame, x in ((0, -0.6), (2, 0.6)):
        subject.location.x = x
        subject.keyframe_insert("location", frame=frame)
    scene.frame_set(1)

    lamps = {}
    for kind, place, energy in (("POINT", (-3.0, -2.0, 3.0), 80.0), ("SUN", (0.0, 0.0, 5.0), 0.6), ("SPOT", (2.0, -3.0, 4.0), 300.0), ("AREA", (0.0, 1.0, 5.0), 80.0)):
        light = bpy.data.lights.new(kind.lower(), kind)
        thing = bpy.data.objects.new(kind.lower(), light)
        thing.location, light.energy = place, energy
        thing.rotation_euler = (0.4, 0.2, 0.0) if kind != "AREA" else (0.0, 0.0, 0.0)
        if kind == "SPOT":
            thing.rotation_euler, light.shadow_soft_size, light.spot_size = (0.6, 0.4, 0.0), 0.3, 0.8
        if kind == "POINT":
            light.shadow_soft_size = 0.4
        if kind == "AREA":
            light.shape, light.size, light.size_y = "RECTANGLE", 1.5, 1.0
        if kind == "SUN":
            light.angle = 0.3
        scene.collection.objects.link(thing)
        lamps[kind] = thing
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0.0, -8.0, 4.0), (1.17, 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.25, 0.35, 1.0)

    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage, render.engine = WIDTH, HEIGHT, 100, "CYCLES"
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = SAMPLES, False, False
    scene.cycles.blur_glossy, scene.cycles.sample_clamp_indirect, scene.cycles.max_bounces = 0.0, 0.0, 6
    return {"scene": scene, "render": render, "layer": scene.view_layers[0], "subject": subject, "mesh": subject.data, "world": scene.world, "mist": scene.world.mist_settings,
            "camera": camera.data, "dof": camera.data.dof, "material": subject.data.materials[0], **{kind.lower(): thing.data for kind, thing in lamps.items()},
            "lamp object": lamps["AREA"]}


def owners(things: dict[str, Any]):
    """(name, struct, settings) of each datablock and of the groups that Cycles adds to it."""
    for name, thing in things.items():
        yield name, thing.bl_rna.identifier, thing
        for group in ("cycles", "cycles_visibility", "cycles_curves"):
            if hasattr(thing, group):
                yield f"{name}.{group}", getattr(thing, group).bl_rna.identifier, getattr(thing, group)


def values_of(owner: bpy.types.bpy_struct, prop: bpy.types.Property) -> list[object]:
    """Values that differ from the present one."""
    now = getattr(owner, prop.identifier)
    chosen = next((values for pattern, values in VALUES.items() if fnmatchcase(f"{owner.bl_rna.identifier}.{prop.identifier}", pattern)), None)
    if chosen is not None:
        return chosen
    if prop.type == "BOOLEAN" and not prop.is_array:
        return [not now]
    if prop.type == "ENUM" and not prop.is_enum_flag:
        return [item.identifier for item in prop.enum_items if item.identifier != now]
    if prop.type in ("INT", "FLOAT"):
        kind = int if prop.type == "INT" else float
        changed = [kind(other(value, prop.soft_min, prop.soft_max)) for value in (now if prop.is_array else [now])]
        if changed == (list(now) if prop.is_array else [now]):
            return []
        return [changed if prop.is_array else changed[0]]
    return []


def is_asked(struct: str, name: str) -> bool:
    if any(fnmatchcase(name, pattern) for pattern in SKIPPED):
        return False
    fate = inventory.fate(struct, name)
    return fate in ("read", "reported") or "reported" in fate or "not supported" in fate


def context_of(struct: str, name: str) -> dict[str, object]:
    return next((settings for pattern, settings in CONTEXT.items() if fnmatchcase(f"{struct}.{name}", pattern)), {})


class Setter:
    """Sets values and restores the old ones."""

    def __init__(self) -> None:
        self.before: list[tuple[object, str, object]] = []

    def set(self, owner: object, name: str, value: object) -> None:
        old = getattr(owner, name)
        self.before.append((owner, name, list(old) if hasattr(old, "__len__") and not isinstance(old, str) else old))
        setattr(owner, name, value)

    def restore(self) -> None:
        for owner, name, value in reversed(self.before):
            setattr(owner, name, value)
        self.before.clear()


def pictures(seeds: tuple[int, int] = (1, 2), samples: int = SAMPLES) -> dict:
    """Images of both engines with two seeds, and the messages of Ajar."""
    bpy.context.scene.cycles.samples = samples
    for block in (*bpy.data.objects, *bpy.data.lights, *bpy.data.worlds, *bpy.data.cameras, *bpy.data.materials, *bpy.data.meshes, *bpy.data.scenes):
        block.update_tag()   # changes of the groups of Cycles cause no update
    bpy.context.view_layer.update()
    ours = [probe.by_ajar(seed) for seed in seeds]
    return {"ajar": [picture for picture, _ in ours], "cycles": [probe.by_cycles(seed) for seed in seeds], "said": [message for _, message in ours[0][1]]}


def cropped(picture: np.ndarray) -> np.ndarray:
    """The rendered region of an image whose other parts are empty. Ajar returns the region only."""
    rows, columns = np.any(picture, axis=(1, 2)), np.any(picture, axis=(0, 2))
    return picture[rows.argmax():len(rows) - rows[::-1].argmax(), columns.argmax():len(columns) - columns[::-1].argmax()] if rows.any() else picture


def compared(a: list[np.ndarray], b: list[np.ndarray]) -> tuple[float, float]:
    if a[0].shape != b[0].shape:
        a, b = ([cropped(picture) for picture in group] for group in (a, b))
    if a[0].shape != b[0].shape:
        return 1.0, 0.0
    block = probe.BLOCK
    small = [[p[:p.shape[0] // block * block, :p.shape[1] // block * block].astype(np.float64).reshape(p.shape[0] // block, block, p.shape[1] // block, block, 3).mean((1, 3)).ravel()
              for p in group] for group in (a, b)]
    return probe.difference(*small)


def measured() -> tuple[dict, float, float]:
    """Images of both engines, their difference and its error."""
    if SHORT:
        shown = pictures(samples=SAMPLES // 4)
        difference, error = compared(shown["ajar"], shown["cycles"])
        if math.hypot(difference, error) < judge.MIN_DIFFERENCE:
            return shown, difference, error
    shown = pictures()
    return shown, *compared(shown["ajar"], shown["cycles"])


def main(path: str) -> None:
    things = build_scene()
    setter, result = Setter(), []
    references: dict[str, dict] = {"{}": pictures()}
    entries = [(name, struct, owner, prop) for name, struct, owner in owners(things) for prop in owner.bl_rna.properties
               if not prop.is_readonly and prop.type in ("BOOLEAN", "ENUM", "INT", "FLOAT") and is_asked(struct, prop.identifier)]
    if SHORT:
        entries = entries[::2]
    for name, struct, owner, prop in entries:
        context = context_of(struct, prop.identifier)
        try:
            for key, value in context.items():
                first, *middle, last = key.replace("lamp.", f"{name}.").split(".")
                target = things[first]
                for step in middle:
                    target = getattr(target, step)
                setter.set(target, last, value)
        except (AttributeError, TypeError):      # this Blender does not have the setting
            setter.restore()
            continue
        if repr(context) not in references:
            references[repr(context)] = pictures()
        reference = references[repr(context)]
        kept = list(setter.before)
        print("probe", struct, prop.identifier, "of", name, flush=True)
        for value in values_of(owner, prop):
            setter.before = []
            try:
                setter.set(owner, prop.identifier, value)
            except (TypeError, AttributeError):
                setter.restore()
                continue
            shown, difference, error = measured()
            new = [message for message in shown["said"] if message not in references["{}"]["said"]]
            if not new and difference > math.hypot(judge.MIN_DIFFERENCE, error):   # more samples reduce the noise, but not an error
                shown = pictures((3, 4), 4 * SAMPLES)
                difference, error = compared(shown["ajar"], shown["cycles"])
            setter.restore()
            change, change_error = compared(shown["cycles"], reference["cycles"])
            result.append({"node": struct, "kind": "choice" if prop.type == "ENUM" else "switch", "name": prop.identifier, "value": str(value), "shown": f"{prop.name} of {name}", "said": new,
                           "difference": difference, "error": error, "change": change, "change_error": change_error,
                           "means": [float(np.mean(shown["ajar"])), float(np.mean(shown["cycles"]))]})
        setter.before = kept
        setter.restore()
    Path(path).write_text(json.dumps({"blender": bpy.app.version_string, "probes": result}, indent=0), encoding="utf-8")


if __name__ == "__main__":
    probes.run(main)
