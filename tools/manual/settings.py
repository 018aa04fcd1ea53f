"""Writes docs/manual/settings.md: every panel, setting and operator of Ajar, from the descriptions that Blender shows. Runs in Blender:

    blender -b --factory-startup --addons ajar_render --python tools/manual/settings.py -- docs/manual/settings.md

PANELS lists the settings of each panel, and the purpose of the panel. `tests/blender/inside/test_manual.py` fails if a setting is missing here or if
the page is out of date.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator
from pathlib import Path

import bpy
from ajar_render import data_properties, documentation, ui

BLENDERS = "The settings are Blender's own."
# Tab -> panel -> its purpose, and its settings of Ajar as "group.property".
PANELS: dict[str, dict[str, tuple[str, tuple[str, ...]]]] = {
    "Render tab": {
        "AJAR_RENDER_PT_checks": ("Warnings about settings that make the picture worse, each with a button that changes the setting. **Check Scene** reads and builds the scene without "
                                  "rendering it. More: [Before rendering](rendering.md#before-rendering).", ()),
        "AJAR_RENDER_PT_sampling": ("How many samples the render takes, how they are distributed over the picture, and when the render stops. More: [Sampling](rendering.md#sampling).", (
            "Scene.use_cycles_settings", "Scene.noise_level", "Scene.noise_target", "Scene.samples", "Scene.time_limit", "Scene.seed", "Scene.image", "Scene.image_error",
            "Scene.importance_factor", "Scene.importance_min", "Scene.importance_max", "Scene.use_denoise", "Scene.viewport_samples", "Scene.viewport_integrator",
            "Scene.use_viewport_denoise")),
        "AJAR_RENDER_PT_integrator": ("The rendering technique and its settings. The panel shows the settings that the chosen technique uses. More: [Integrator](rendering.md#integrator).", (
            "Scene.integrator", "Scene.guiding", "Scene.vertex_merging", "Scene.carry_learning", "Scene.photons", "Scene.photon_radius", "Scene.gather_rays", "Scene.show_photons")),
        "AJAR_RENDER_PT_direct": ("How light that comes straight from lamps, emitting surfaces and the world is sampled. More: [Direct light](rendering.md#direct-light).", (
            "Scene.direct", "Scene.direct_samples", "Scene.show_advanced")),
        "AJAR_RENDER_PT_light_paths": ("How often light bounces, and what is left out of it. More: [Light paths](rendering.md#light-paths).", (
            "Scene.bounces_total", "Scene.bounces_diffuse", "Scene.bounces_glossy", "Scene.bounces_transmission", "Scene.bounces_volume", "Scene.bounces_transparent",
            "Scene.clamp_direct", "Scene.clamp_indirect", "Scene.reflective_caustics", "Scene.refractive_caustics")),
        "AJAR_RENDER_PT_film": ("The brightness of the picture, the filter of its pixels, and whether the world is transparent in it. *Transparent* is a setting of Blender.", (
            "Scene.exposure", "Scene.filter", "Scene.filter_width", "Scene.transparent_glass", "Scene.transparent_glass_roughness")),
        "AJAR_RENDER_PT_curves": ("The shape of hair and curves. More: [Hair](rendering.md#hair).", ("Scene.curve_shape", "Scene.curve_subdivisions")),
        "AJAR_RENDER_PT_subdivision": ("How finely adaptive subdivision divides surfaces. More: [Adaptive subdivision](rendering.md#adaptive-subdivision).", (
            "Scene.dicing_rate", "Scene.preview_dicing_rate", "Scene.offscreen_dicing_scale", "Scene.max_subdivisions", "Scene.dicing_camera")),
        "AJAR_RENDER_PT_motion_blur": ("Blurs objects and the camera that move while the shutter is open. *Shutter* is a setting of Blender. "
                                       "More: [Cameras and motion blur](rendering.md#cameras-and-motion-blur).", (
            "Scene.motion_blur_position", "Scene.rolling_shutter_type", "Scene.rolling_shutter_duration")),
        "AJAR_RENDER_PT_shutter_curve": (f"How far the shutter is open at each moment. {BLENDERS}", ()),
        "AJAR_RENDER_PT_performance": ("Threads and memory. The picture does not depend on the number of threads. The settings of threads are Blender's own. "
                                       "More: [Performance](rendering.md#performance), [Memory](memory.md).", ("Scene.memory_limit", "Scene.compact_bvh")),
        "AJAR_RENDER_PT_texture_cache": ("Images are read in tiles, at the resolution that the picture needs. Since Blender 5.2, *Texture Cache* and *Auto Generate* are settings of Blender, and the "
                                         "folder is in its preferences. More: [Memory](memory.md#texture-cache).", (
            "Scene.use_texture_cache", "Scene.use_auto_generate_texture_cache", "Scene.texture_cache_directory", "Scene.texture_cache_size")),
        "AJAR_RENDER_PT_compositor": (f"Blender's compositor, which works on the pictures of every engine. {BLENDERS}", ()),
        "AJAR_RENDER_PT_checkpoint": ("Saves the samples during the render, so that a render that was stopped can continue. More: [Long renders](rendering.md#long-renders).", (
            "Scene.use_checkpoint", "Scene.checkpoint_path", "Scene.checkpoint_interval", "Scene.use_resume")),
        "AJAR_RENDER_PT_bake": (f"Renders into the textures of the selected objects. More: [Baking](rendering.md#baking). {BLENDERS}", ("Scene.bake_type",)),
        "AJAR_RENDER_PT_bake_influence": (f"From where the surface is seen, and which parts of its light are baked. {BLENDERS}", ()),
        "AJAR_RENDER_PT_bake_selected_to_active": (f"Bakes the other selected objects into the texture of the active one. {BLENDERS}", ()),
        "AJAR_RENDER_PT_bake_output": (f"Where the result goes, and how far it extends beyond the faces. {BLENDERS}", ()),
        "AJAR_RENDER_PT_progress": ("The noise over time and the samples of each pixel, while the render runs and after it. More: [Progress](rendering.md#progress).", (
            "Scene.show_sample_density",)),
        "AJAR_RENDER_PT_statistics": ("Numbers of the last render: time, memory, samples, noise, and the size of the scene. More: [Statistics](rendering.md#statistics).", ()),
        "AJAR_RENDER_PT_plan": ("The steps of the last render: which ones the scene needed, which ones were left out, and why. More: [Statistics](rendering.md#statistics).", ()),
        "AJAR_RENDER_PT_texture_size": ("Smaller textures save memory. The limits apply to all images; Texture Resolution is a setting of Blender 5.2 and later.", (
            "Scene.texture_limit", "Scene.texture_limit_render", "Scene.texture_resolution", "Scene.texture_resolution_render")),
        "AJAR_RENDER_PT_culling": ("Objects outside the view of the camera, or far from it, are left out, if they allow it.", (
            "Scene.use_camera_cull", "Scene.camera_cull_margin", "Scene.use_distance_cull", "Scene.distance_cull_margin")),
        "AJAR_RENDER_PT_hints": ("The curves that show the renderer where light goes, with what became of each. More: [Light hints](hints.md).", ("Scene.hint_collection",)),
    },
    "View layer tab": {
        "AJAR_VIEWLAYER_PT_filter": (f"What the view layer renders. {BLENDERS}", ()),
        "AJAR_VIEWLAYER_PT_override": (f"A material, a world and a number of samples that replace those of the scene in this view layer. {BLENDERS}", ()),
        "AJAR_VIEWLAYER_PT_passes": ("The passes that the view layer renders. Those below are of Ajar; the others are Blender's own. More: [Passes](rendering.md#passes).", (
            "ViewLayer.use_pass_albedo", "ViewLayer.use_pass_volume_direct", "ViewLayer.use_pass_volume_indirect", "ViewLayer.use_pass_shadow_catcher", "ViewLayer.use_pass_sample_count", "ViewLayer.use_pass_render_time",
            "ViewLayer.use_pass_variance", "ViewLayer.use_pass_error", "ViewLayer.use_pass_perceptual_error", "ViewLayer.use_pass_denoising",
            "ViewLayer.use_pass_denoising_error")),
        "AJAR_VIEWLAYER_PT_cryptomatte": (f"Mattes of objects, materials and assets for the node Cryptomatte of the compositor. {BLENDERS} More: [Passes](rendering.md#passes).", ()),
        "AJAR_VIEWLAYER_PT_aovs": (f"Passes of the AOV Output nodes of materials and of the world. {BLENDERS} More: [Passes](rendering.md#passes).", ()),
        "AJAR_VIEWLAYER_PT_light_groups": ("Groups of lamps, emitting objects and the world. Each has a pass, *Combined_* with its name, and an importance. More: [Passes](rendering.md#passes), [Sampling](rendering.md#sampling).", (
            "ViewLayer.light_group_importance", "ViewLayer.light_groups", "LightGroup.importance")),
    },
    "World tab": {
        "AJAR_WORLD_PT_preview": ("A small render of the world.", ()),
        "AJAR_WORLD_PT_surface": (f"The node that is linked to the input *Surface* of the output. {BLENDERS}", ()),
        "AJAR_WORLD_PT_volume": (f"The node that is linked to the input *Volume* of the output. More: [Volumes](rendering.md#volumes). {BLENDERS}", ()),
        "AJAR_WORLD_PT_mist": (f"The distances of the pass Mist. {BLENDERS}", ()),
        "AJAR_WORLD_PT_ray_visibility": ("Which rays see the world.", (
            "World.visible_camera", "World.visible_diffuse", "World.visible_glossy", "World.visible_transmission", "World.visible_volume_scatter")),
        "AJAR_WORLD_PT_settings": ("The light group of the world, and how long the world is sampled.", ("World.max_bounces",)),
    },
    "Object tab": {
        "AJAR_OBJECT_PT_motion_blur": ("Whether and how the object is blurred. More: [Cameras and motion blur](rendering.md#cameras-and-motion-blur).", (
            "Object.use_motion_blur", "Object.motion_steps", "Object.use_deform_motion")),
        "AJAR_OBJECT_PT_shading": ("How shadows at the edge of light are corrected on coarse smooth meshes.", ("Object.shadow_terminator_geometry_offset",)),
        "AJAR_OBJECT_PT_subdivision": ("Adaptive subdivision of the object. Since Blender 5.0, these are settings of the modifier Subdivision Surface. "
                                       "More: [Adaptive subdivision](rendering.md#adaptive-subdivision).", ("Object.use_adaptive_subdivision", "Object.dicing_rate")),
        "AJAR_OBJECT_PT_visibility": (f"Where the object is shown. {BLENDERS}", ()),
        "AJAR_OBJECT_PT_ray_visibility": (f"Which rays see the object. {BLENDERS}", ()),
        "AJAR_OBJECT_PT_culling": ("Whether culling may leave the object out. The switches of the scene are in *Simplify*.", ("Object.use_camera_cull", "Object.use_distance_cull")),
        "AJAR_OBJECT_PT_light_linking": (f"The objects that the light of this object illuminates. Shown in Blender 4.0 to 4.2; later versions have a panel of their own. {BLENDERS}", ()),
        "AJAR_OBJECT_PT_shadow_linking": (f"The objects that block the light of this object. Shown in Blender 4.0 to 4.2; later versions have a panel of their own. {BLENDERS}", ()),
        "AJAR_OBJECT_PT_importance": ("How many samples pixels with this object get, and the light group of the object. More: [Sampling](rendering.md#sampling).", ("Object.importance",)),
        "AJAR_OBJECT_PT_light_hint": ("Settings of a curve that is a light hint. More: [Light hints](hints.md#settings-of-a-path).", (
            "Object.hint_enabled", "Object.hint_spread", "Object.hint_weight", "Object.hint_light", "Object.hint_offset")),
    },
    "Collection tab": {
        "AJAR_COLLECTION_PT_importance": ("How many samples pixels with objects of this collection get. More: [Sampling](rendering.md#sampling).", ("Collection.importance",)),
    },
    "Material tab": {
        "AJAR_MATERIAL_PT_preview": ("A small render of the material.", ()),
        "AJAR_MATERIAL_PT_surface": (f"The node that is linked to the input *Surface* of the output. {BLENDERS}", ()),
        "AJAR_MATERIAL_PT_volume": (f"The node that is linked to the input *Volume* of the output. More: [Volumes](rendering.md#volumes). {BLENDERS}", ()),
        "AJAR_MATERIAL_PT_displacement": (f"The node that is linked to the input *Displacement* of the output. The method of the material says whether it moves the surface. {BLENDERS}", ()),
        "AJAR_MATERIAL_PT_settings": ("The pass index of the material, what its displacement does, and how light passes it.", (
            "Material.displacement_method", "Material.use_transparent_shadow", "Material.use_bump_map_correction")),
    },
    "Light tab": {
        "AJAR_LIGHT_PT_light": ("Type, colour, power and size of the lamp, which are settings of Blender, and how the lamp is sampled.", (
            "Light.max_bounces", "Light.cast_shadow", "Light.use_multiple_importance_sampling", "Light.is_portal")),
        "AJAR_LIGHT_PT_beam": (f"The cone of a spot lamp, or the spread of an area lamp. {BLENDERS}", ()),
        "AJAR_LIGHT_PT_nodes": (f"The nodes of the lamp. {BLENDERS}", ()),
    },
    "Camera tab": {
        "AJAR_CAMERA_PT_panorama": ("The projection of a panoramic camera.", (
            "Camera.panorama_type", "Camera.fisheye_fov", "Camera.fisheye_lens", "Camera.latitude_min", "Camera.latitude_max", "Camera.longitude_min", "Camera.longitude_max",
            *(f"Camera.fisheye_polynomial_k{number}" for number in range(5)))),
        "AJAR_CAMERA_PT_depth_of_field": (f"What is in focus. {BLENDERS}", ()),
        "AJAR_CAMERA_PT_aperture": (f"The aperture of the lens. {BLENDERS}", ()),
    },
    "Sidebar of the image editor": {
        "AJAR_IMAGE_PT_progress": ("The same as *Progress* in the render tab, beside the picture while it renders. More: [Progress](rendering.md#progress).", ()),
    },
    "Shading menu of the 3D view": {
        "AJAR_VIEW3D_PT_pass": ("What a rendered view shows. More: [Progress](rendering.md#progress).", ("Shading.show_sample_density",)),
    },
    "Sidebar of the 3D view": {
        "AJAR_VIEW3D_PT_hints": ("The same as *Light Hints* in the render tab, where light hints are drawn. More: [Light hints](hints.md).", ()),
    },
}
GROUPS = {"Scene": "AjarSceneSettings", "ViewLayer": "AjarViewLayerSettings", "LightGroup": "AjarLightGroup", "Collection": "AjarCollectionSettings", "Shading": "AjarShadingSettings",
          **{name: group.__name__ for name, group in data_properties.GROUPS.items()}}
DEFAULTS = {"Scene.use_cycles_settings": "Default: on in files in which a setting of Cycles was changed."}   # of settings without a fixed default
MOST_DIGITS = 6
UNITS = {"ANGLE": "°", "TIME_ABSOLUTE": " s", "DISTANCE": " m"}


class Incomplete(Exception):
    """PANELS and the add-on are inconsistent."""


def rna_id(setting: str) -> str:
    group, name = setting.split(".")
    return f"bpy.types.{GROUPS[group]}.{name}"


def property_of(setting: str) -> bpy.types.Property:
    group, name = setting.split(".")
    return bpy.types.PropertyGroup.bl_rna_get_subclass_py(GROUPS[group]).bl_rna.properties[name]


def check() -> None:
    """Every panel with a title and every setting of the add-on is in PANELS once, and nothing else."""
    panels = [name for tab in PANELS.values() for name in tab]
    settings = [rna_id(setting) for tab in PANELS.values() for _, shown in tab.values() for setting in shown]
    for kind, listed, wanted in (("panel", panels, {panel.__name__.removeprefix("NODE_") for panel in ui.CLASSES if issubclass(panel, bpy.types.Panel) and panel.bl_label}),
                                 ("setting", settings, set(documentation.ids_of_properties()))):
        if len(listed) != len(set(listed)) or set(listed) != wanted:
            twice = sorted({name for name in listed if listed.count(name) > 1})
            raise Incomplete(f"PANELS of {Path(__file__).name} lacks the {kind}s {sorted(wanted - set(listed))}, has the unknown ones {sorted(set(listed) - wanted)} and twice {twice}")


# ---- Texts ----------------------------------------------------------------------------------------------------------------

def sentence(text: str) -> str:
    return text if text.endswith(".") else f"{text}."


def number(value: float, prop: bpy.types.Property) -> str:
    value = math.degrees(value) if prop.subtype == "ANGLE" else value
    text = f"{value:,.0f}" if float(value).is_integer() else f"{value:.{4 if prop.subtype == 'ANGLE' else MOST_DIGITS}g}"
    return text + UNITS.get(prop.subtype, "")


def facts(prop: bpy.types.Property) -> str:
    """Default and range."""
    if prop.type == "BOOLEAN":
        return f"Default: {'on' if prop.default else 'off'}."
    if prop.type == "STRING":
        return f"Default: `{prop.default}`." if prop.default else "Default: empty."
    if prop.type == "ENUM":
        return f"Default: *{prop.enum_items[prop.default].name}*." if prop.default in prop.enum_items else ""
    if prop.type not in ("INT", "FLOAT"):
        return ""
    default = ", ".join(number(value, prop) for value in prop.default_array) if prop.is_array else number(prop.default, prop)
    limit = 2**31 - 1 if prop.type == "INT" else 1e30   # a larger bound is no bound
    low, high = (value if abs(value) < limit else None for value in (prop.hard_min, prop.hard_max))
    words = [f"Default: {default}"]
    if low is not None and high is not None:
        words.append(f"from {number(low, prop)} to {number(high, prop)}")
    elif low is not None:
        words.append(f"at least {number(low, prop)}")
    return f"{', '.join(words)}."


def describe(setting: str, listed: dict[tuple, str]) -> Iterator[str]:
    """Describe one setting. `listed`: the settings whose choices have been listed, by these choices."""
    prop, anchor = property_of(setting), documentation.anchor_of_id(rna_id(setting))
    yield f'<a id="{anchor}"></a>'
    yield f"**{prop.name}**: {sentence(prop.description)} {DEFAULTS.get(setting) or facts(prop)}".rstrip()
    choices = tuple((item.name, item.description) for item in prop.enum_items) if prop.type == "ENUM" else ()
    if choices in listed:
        yield f"The choices are those of [{property_of(listed[choices]).name}](#{documentation.anchor_of_id(rna_id(listed[choices]))})."
    yield ""
    if choices and choices not in listed:
        listed[choices] = setting
        yield from (f"* *{name}*: {sentence(text)}" if text else f"* *{name}*" for name, text in choices)
        yield ""


def operators() -> Iterator[str]:
    """All operators except those under old names, which have the same anchors."""
    found = {name: operator for name, operator in ((operator.bl_idname, operator) for operator in documentation.own(bpy.types.Operator)) if documentation.OLD_NAME not in name}
    for name, operator in sorted(found.items(), key=lambda pair: pair[1].bl_label):
        yield f'<a id="{documentation.anchor_of_id(f"bpy.ops.{name}")}"></a>'
        yield f"**{operator.bl_label}** (`bpy.ops.{name}`): {sentence(operator.bl_description)}"
        yield ""
        known = getattr(bpy.ops.ajar, name.removeprefix("ajar.")).get_rna_type().properties
        options = [known[key] for key in getattr(operator, "__annotations__", ())]
        for prop in options:
            choices = f"One of {', '.join(f'*{item.name}*' for item in prop.enum_items)}." if prop.type == "ENUM" else f"{sentence(prop.description)} {facts(prop)}"
            yield f"* *{prop.name}*: {choices}".rstrip()
        if options:
            yield ""


def page() -> str:
    check()
    lines = ["# Settings", "", "Every panel, setting and operator of Ajar. Right-click a setting or a button and choose *Online Manual*, or press F1 over it, to open this page at its entry.",
             "The question mark in the header of a panel opens this page at the panel. For settings that are Blender's own, *Online Manual* opens Blender's manual.",
             "Newer versions of Blender have some of the settings below themselves, such as the panorama type since 5.0. The panels then show Blender's.", ""]
    listed: dict[tuple, str] = {}
    for tab, panels in PANELS.items():
        lines += [f"## {tab}", ""]
        for name, (text, settings) in panels.items():
            panel = getattr(bpy.types, name)
            lines += [f'<a id="{documentation.anchor_of_panel(panel)}"></a>', "", f"### {panel.bl_label}", "", text, ""]
            for setting in settings:
                lines += describe(setting, listed)
    return "\n".join([*lines, "## Operators", "", *operators()]).rstrip() + "\n"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="settings.py", description=__doc__.splitlines()[0])
    parser.add_argument("page", type=Path, help="the file to write")
    parser.parse_args(sys.argv[sys.argv.index("--") + 1:]).page.write_text(page(), encoding="utf-8")
