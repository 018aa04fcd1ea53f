"""Small scenes of one feature each, for which both engines must render the same image (benchmarks/feature_agreement.py renders them):

    blender -b --factory-startup --python-exit-code 1 --python test_scenes/features.py -- FOLDER [NAME ...]

writes FOLDER/<name>.blend for every feature, or for those named; `--list FILE` writes the list of features as JSON. Each scene starts with the same
stage: a floor, a ball and a box before a camera. A feature changes one part of it and has a description of one line. All other parts stay plain, so
that a difference has one cause.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import scene_tools as tools
from mathutils import Vector

SIZE = 64
GREY, RED, BLUE = (0.6, 0.6, 0.6), (0.7, 0.2, 0.1), (0.1, 0.25, 0.7)


@dataclass(frozen=True)
class Feature:
    kind: str
    name: str
    what: str
    change: Callable


class Stage:
    """The scene that features change. A dim world is its only light until a lamp is added."""

    def __init__(self):
        bpy.context.preferences.edit.keyframe_new_interpolation_type = "LINEAR"
        self.scene = tools.start_scene(SIZE, SIZE, bounces=8)
        self.scene.cycles.light_sampling_threshold = 0.0
        self.floor = tools.add_plane("Floor", (0, 0, 0), (6, 6), tools.diffuse("Floor", GREY))
        self.ball = tools.add_sphere("Ball", (-0.65, 0, 0.6), 0.6, tools.diffuse("Ball", RED))
        self.box = tools.add_box("Box", (0.35, -0.35, 0.0), (1.05, 0.35, 0.9), tools.diffuse("Box", BLUE))
        self.camera = tools.camera((0, -5, 2.2), (0, 0, 0.5), lens=50)
        self.sky((0.25, 0.27, 0.3))

    def sky(self, colour, strength=1.0):
        return tools.background(self.scene, colour, strength)

    def sun(self):
        return tools.sun_light("Sun", (1, 1.2, -2), 2.0, angle=math.radians(5))

    def panel(self, watts=150.0, size=1.5):
        return tools.area_light("Panel", (-1.5, -2.5, 3.5), (0, 0, 0.4), size, watts)

    def material(self, things, made) -> bpy.types.Material:
        for thing in things:
            thing.data.materials.clear()
            thing.data.materials.append(made)
        return made

    def on_ball(self, made) -> bpy.types.Node:
        return tools.shader_of(self.material([self.ball], made))

    def everywhere(self, made) -> bpy.types.Node:
        return tools.shader_of(self.material([self.ball, self.box, self.floor], made))


FEATURES: dict[str, Feature] = {}


def feature(kind: str, name: str, what: str):
    def keep(change):
        FEATURES[name] = Feature(kind, name, what, change)
        return change
    return keep


def add(kind: str, name: str, what: str, change: Callable) -> None:
    FEATURES[name] = Feature(kind, name, what, change)


def shader(node_type: str, output: str = "BSDF", **inputs) -> bpy.types.Material:
    return tools._material(node_type, node_type, output, **inputs)


# --- Lights ----------------------------------------------------------------------------------------------------------

def lit_by(make: Callable, **settings) -> Callable:
    """A black world and one lamp. The settings are set on the data of the lamp."""
    def change(stage: Stage):
        stage.sky((0, 0, 0))
        lamp = make()
        for name, value in settings.items():
            setattr(lamp.data, name, value)
    return change


def point(radius=0.0):
    return lambda: tools.point_light("Lamp", (-1.2, -2.2, 3.2), 300, radius=radius)


def spot(**more):
    return lambda: tools.spot_light("Lamp", (-1.2, -2.2, 3.2), (0, 0, 0.3), 600, **more)


def area(size=1.2, disk=False, seen=False):
    return lambda: tools.area_light("Lamp", (-1.2, -2.0, 3.2), (0, 0, 0.3), size, 200, disk=disk, seen=seen)


def sun(degrees):
    return lambda: tools.sun_light("Lamp", (1, 1.2, -2), 3.0, angle=math.radians(degrees))


add("light", "point", "point lamp without extent", lit_by(point()))
add("light", "point_soft", "point lamp of 10 cm, far from surfaces", lit_by(point(0.1)))
add("light", "spot", "spot lamp, hard edge", lit_by(spot(blend=0.0)))
add("light", "spot_blend", "spot lamp, soft edge", lit_by(spot(blend=0.8)))
add("light", "spot_soft", "spot lamp of 10 cm", lit_by(spot(radius=0.1, angle=math.radians(60))))
add("light", "sun_sharp", "sun without extent", lit_by(sun(0)))
add("light", "sun_wide", "sun of 20 degrees", lit_by(sun(20)))
add("light", "sun_of_half_the_sky", "sun of 170 degrees", lit_by(sun(170)))
add("light", "area_square", "square area lamp", lit_by(area()))
add("light", "area_rectangle", "rectangular area lamp", lit_by(area((2.0, 0.5))))
add("light", "area_disk", "disk area lamp", lit_by(area(1.2, True)))
add("light", "area_ellipse", "elliptic area lamp", lit_by(area((2.0, 0.6), True)))
add("light", "area_spread", "area lamp with a spread of 60 degrees", lit_by(area(), spread=math.radians(60)))
add("light", "area_without_mis", "area lamp without multiple importance", lambda s: lit_by(area())(s) or setattr(
    bpy.data.lights["Lamp"].cycles, "use_multiple_importance_sampling", False))
add("light", "lamp_without_shadow", "a lamp that casts no shadow", lambda s: lit_by(area())(s) or setattr(
    bpy.data.lights["Lamp"].cycles, "cast_shadow", False))


@feature("light", "area_seen", "area lamp seen by the camera and mirrored")
def _(stage):
    stage.sky((0, 0, 0))
    lamp = tools.area_light("Lamp", (0.2, 1.6, 1.8), (0, 0, 0.4), 0.8, 60, seen=True)
    lamp.visible_camera = True
    stage.on_ball(tools.glossy("Ball", (0.8, 0.8, 0.8), 0.2))


@feature("light", "lamp_without_glossy", "a lamp that glossy rays do not see")
def _(stage):
    lamp = tools.area_light("Lamp", (0.2, 1.6, 2.0), (0, 0, 0.4), 0.8, 60)
    lamp.visible_glossy = False
    stage.on_ball(tools.glossy("Ball", (0.8, 0.8, 0.8), 0.3))


@feature("light", "mesh_light", "an emissive mesh")
def _(stage):
    stage.sky((0, 0, 0))
    tools.add_quad("Lamp", (-1.8, -1.5, 2.6), (-0.6, -1.5, 2.6), (-0.6, -0.3, 2.6), (-1.8, -0.3, 2.6), tools.emission("Lamp", (1, 0.8, 0.6), 12))


@feature("light", "mesh_lights_of_one_material", "two emissive meshes that take colour and strength from their objects")
def _(stage):
    stage.sky((0, 0, 0))
    made = tools.emission("Lamp", (1, 1, 1), 12)
    tree = made.node_tree
    info, power, emission = tree.nodes.new("ShaderNodeObjectInfo"), tree.nodes.new("ShaderNodeAttribute"), tools.shader_of(made)
    power.attribute_type, power.attribute_name = "OBJECT", "power"
    tree.links.new(info.outputs["Color"], emission.inputs["Color"])
    tree.links.new(power.outputs["Fac"], emission.inputs["Strength"])
    for x, colour, watts in ((-1.8, (1, 0.7, 0.3, 1), 14.0), (1.0, (0.2, 0.5, 1, 1), 6.0)):
        lamp = tools.add_quad("Lamp", (x, -1.5, 2.6), (x + 0.8, -1.5, 2.6), (x + 0.8, -0.7, 2.6), (x, -0.7, 2.6), made)
        lamp.color, lamp["power"] = colour, watts


@feature("light", "lamp_nodes", "a lamp with nodes: blackbody colour, linear falloff")
def _(stage):
    lit_by(point(0.05))(stage)
    tree_owner = bpy.data.lights["Lamp"]
    tree_owner.use_nodes = True
    nodes, links = tree_owner.node_tree.nodes, tree_owner.node_tree.links
    emission = nodes["Emission"]
    body, falloff = nodes.new("ShaderNodeBlackbody"), nodes.new("ShaderNodeLightFalloff")
    body.inputs[0].default_value, falloff.inputs["Strength"].default_value = 3200, 0.4
    links.new(body.outputs[0], emission.inputs["Color"])
    links.new(falloff.outputs["Linear"], emission.inputs["Strength"])


def shining_through(stage: Stage, turn: tuple[float, float, float], connect: Callable) -> None:
    """Rotate the lamp, and link the strength of its emission by `connect`(nodes, links, input of the strength)."""
    lamp = bpy.data.objects["Lamp"]
    lamp.rotation_euler = turn
    lamp.data.use_nodes = True
    nodes, links = lamp.data.node_tree.nodes, lamp.data.node_tree.links
    connect(nodes, links, nodes["Emission"].inputs["Strength"])


def measured(nodes: bpy.types.Nodes, strength: float) -> bpy.types.Node:
    """An IES Texture of a lamp with two lobes, one of which is wider."""
    text = bpy.data.texts.new("wings.ies")
    vertical, horizontal = (0, 15, 30, 45, 60, 75, 90, 110), (0, 45, 90, 135, 180, 225, 270, 315, 360)
    rows = [" ".join(f"{max(0.0, 90 - v + 160 * math.exp(-((v - 50) / 14) ** 2) * (math.cos(math.radians(h)) ** 2 + 0.3 * math.sin(math.radians(h)))):.2f}" for v in vertical)
            for h in horizontal]
    text.write("\n".join(["IESNA:LM-63-2002", "TILT=NONE", f"1 -1 1 {len(vertical)} {len(horizontal)} 1 2 0 0 0", "1 1 1",
                          " ".join(map(str, vertical)), " ".join(map(str, horizontal)), *rows, ""]))
    node = nodes.new("ShaderNodeTexIES")
    node.mode, node.ies = "INTERNAL", text
    node.inputs["Strength"].default_value = strength
    return node


@feature("light", "lamp_ies", "a point lamp with an IES texture, tilted")
def _(stage):
    lit_by(point())(stage)
    shining_through(stage, (0.5, -0.35, 0.8), lambda nodes, links, strength: links.new(measured(nodes, 0.12).outputs["Fac"], strength))


@feature("light", "lamp_ies_mapped", "a spot lamp of 10 cm with an IES texture turned by Mapping")
def _(stage):
    lit_by(spot(radius=0.1, angle=math.radians(120)))(stage)

    def connect(nodes, links, strength):
        coordinates, mapping, ies = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeMapping"), measured(nodes, 0.12)
        mapping.inputs["Rotation"].default_value = (0.3, 0.2, 1.1)
        links.new(coordinates.outputs["Normal"], mapping.inputs["Vector"])
        links.new(mapping.outputs["Vector"], ies.inputs["Vector"])
        links.new(ies.outputs["Fac"], strength)
    shining_through(stage, (0.6, -0.3, 0.2), connect)


@feature("light", "lamp_ies_area", "an area lamp with an IES texture along Geometry: Incoming")
def _(stage):
    lit_by(area())(stage)

    def connect(nodes, links, strength):
        geometry, ies = nodes.new("ShaderNodeNewGeometry"), measured(nodes, 0.12)
        links.new(geometry.outputs["Incoming"], ies.inputs["Vector"])
        links.new(ies.outputs["Fac"], strength)
    shining_through(stage, (0.6, -0.3, 0.2), connect)


@feature("light", "lamp_position", "an area lamp with stripes along its position")
def _(stage):
    lit_by(area((2.4, 1.2)))(stage)

    def connect(nodes, links, strength):
        geometry, wave = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeTexWave")
        wave.inputs["Scale"].default_value = 0.5
        links.new(geometry.outputs["Position"], wave.inputs["Vector"])
        links.new(wave.outputs["Fac"], strength)
    shining_through(stage, (0.6, -0.3, 0.2), connect)


@feature("light", "lamp_max_bounces", "an area lamp that is not sampled after the first bounce")
def _(stage):
    stage.sky((0, 0, 0))
    stage.panel().data.cycles.max_bounces = 0


@feature("light", "many_lamps", "24 small lamps of different colours")
def _(stage):
    stage.sky((0, 0, 0))
    for i in range(24):
        angle = i * 0.2618
        tools.point_light(f"Lamp {i}", (2.2 * math.cos(angle), 2.2 * math.sin(angle), 1.2 + 0.08 * i), 12,
                          (0.5 + 0.5 * math.cos(angle), 0.6, 0.5 + 0.5 * math.sin(angle)), radius=0.02)


# --- World -----------------------------------------------------------------------------------------------------------

add("world", "sky_constant", "a constant sky", lambda s: s.sky((0.5, 0.6, 0.8), 1.3))


def sky_texture(kind: str, **settings):
    def change(stage):
        shader_node = stage.sky((1, 1, 1), 0.1 if kind == "NISHITA" else 0.5)
        tree = stage.scene.world.node_tree
        sky = tree.nodes.new("ShaderNodeTexSky")
        sky.sky_type = kind
        for name, value in settings.items():
            setattr(sky, name, value)
        tree.links.new(sky.outputs[0], shader_node.inputs["Color"])
    return change


add("world", "sky_nishita", "Nishita sky without its sun", sky_texture("NISHITA", sun_disc=False, sun_elevation=0.6))
add("world", "sky_nishita_sun", "Nishita sky with its sun", sky_texture("NISHITA", sun_disc=True, sun_elevation=0.6, sun_size=0.1, sun_intensity=0.1))
add("world", "sky_hosek", "Hosek and Wilkie's sky", sky_texture("HOSEK_WILKIE"))
add("world", "sky_preetham", "Preetham's sky", sky_texture("PREETHAM"))


@feature("world", "environment_image", "an environment image with a bright spot")
def _(stage):
    width, height = 64, 32
    pixels = []
    for y in range(height):
        for x in range(width):
            bright = 30.0 if (x - 20) ** 2 + (y - 24) ** 2 < 9 else 0.0
            pixels += [0.1 + bright + 0.2 * y / height, 0.15 + bright, 0.3 + 0.8 * bright, 1.0]
    tools.environment(stage.scene, tools.packed_image("Sky", width, height, pixels, hdr=True))


@feature("world", "world_hidden_from_camera", "a sky that the camera does not see")
def _(stage):
    stage.sky((0.6, 0.6, 0.7))
    stage.scene.world.cycles_visibility.camera = False


@feature("world", "portal", "a sky through a portal")
def _(stage):
    stage.sky((1, 1, 1), 1.0)
    room = tools.add_box("Room", (-2.6, -5.6, -0.1), (2.6, 2.6, 3.4), tools.diffuse("Room", GREY))
    room.data.polygons.foreach_set("use_smooth", [False] * len(room.data.polygons))
    import bmesh
    work = bmesh.new()
    work.from_mesh(room.data)
    left = [f for f in work.faces if f.calc_center_median().x < -2.5]
    bmesh.ops.delete(work, geom=left, context="FACES")
    work.to_mesh(room.data)
    portal = tools.area_light("Portal", (-2.6, -1.5, 1.65), (0, -1.5, 1.65), (8.2, 3.5), 1)
    portal.data.cycles.is_portal = True


# --- Cameras ---------------------------------------------------------------------------------------------------------

def camera_feature(name: str, what: str, **settings):
    def change(stage):
        stage.sun()
        data = stage.camera.data
        for key, value in settings.items():
            target = data
            *path, last = key.split("__")
            for step in path:
                target = getattr(target, step)
            setattr(target, last, value)
    add("camera", name, what, change)


camera_feature("camera_wide", "perspective of 20 mm", lens=20)
camera_feature("camera_shift", "shifted lens", shift_x=0.15, shift_y=-0.1)
camera_feature("camera_sensor", "vertical sensor fit", sensor_fit="VERTICAL", sensor_height=18.0)
camera_feature("camera_orthographic", "orthographic", type="ORTHO", ortho_scale=3.5)
camera_feature("camera_clip", "near clipping plane through the ball", clip_start=4.9)
camera_feature("camera_dof", "depth of field", dof__use_dof=True, dof__aperture_fstop=0.2, dof__focus_distance=5.2)
camera_feature("camera_dof_blades", "depth of field, five blades turned", dof__use_dof=True, dof__aperture_fstop=0.15, dof__focus_distance=3.5,
               dof__aperture_blades=5, dof__aperture_rotation=0.4)
camera_feature("camera_dof_ratio", "anamorphic depth of field", dof__use_dof=True, dof__aperture_fstop=0.15, dof__focus_distance=3.5, dof__aperture_ratio=2.0)
camera_feature("camera_equirectangular", "panorama, equirectangular", type="PANO", cycles__panorama_type="EQUIRECTANGULAR")
camera_feature("camera_fisheye", "panorama, equidistant fisheye", type="PANO", cycles__panorama_type="FISHEYE_EQUIDISTANT", cycles__fisheye_fov=2.6)
camera_feature("camera_fisheye_lens", "panorama, equisolid fisheye", type="PANO", cycles__panorama_type="FISHEYE_EQUISOLID", cycles__fisheye_lens=12.0,
               cycles__fisheye_fov=3.0)
camera_feature("camera_mirror_ball", "panorama, mirror ball", type="PANO", cycles__panorama_type="MIRRORBALL")


# --- Lobes: the ball in a panel's light and a sky -----------------------------------------------------------------------

def lobe(name: str, what: str, make: Callable, panel: bool = True, **properties):
    def change(stage):
        if panel:
            stage.panel()
        node = stage.on_ball(make())
        for key, value in properties.items():
            setattr(node, key, value)
    add("lobe", name, what, change)


lobe("diffuse", "Diffuse", lambda: tools.diffuse("Ball", RED))
lobe("diffuse_rough", "Diffuse, roughness 1 (Oren-Nayar)", lambda: tools.diffuse("Ball", RED, roughness=1.0))
lobe("glossy_ggx", "Glossy GGX, roughness 0.4", lambda: tools.glossy("Ball", (0.8, 0.7, 0.5), 0.4))
lobe("glossy_rough", "Glossy GGX, roughness 1", lambda: tools.glossy("Ball", (0.8, 0.7, 0.5), 1.0))
lobe("glossy_beckmann", "Glossy Beckmann", lambda: tools.glossy("Ball", (0.8, 0.7, 0.5), 0.4), distribution="BECKMANN")
lobe("glossy_ashikhmin", "Glossy Ashikhmin-Shirley", lambda: tools.glossy("Ball", (0.8, 0.7, 0.5), 0.3), distribution="ASHIKHMIN_SHIRLEY")
lobe("glossy_multi_ggx", "Glossy Multiscatter GGX, roughness 0.4", lambda: tools.glossy("Ball", (0.8, 0.7, 0.5), 0.4), distribution="MULTI_GGX")
lobe("mirror", "Glossy without roughness", lambda: tools.mirror("Ball"))
lobe("anisotropic", "Anisotropic", lambda: shader("ShaderNodeBsdfAnisotropic", Color=(0.8, 0.7, 0.5), Roughness=0.4, Anisotropy=0.6, Rotation=0.1))
lobe("glass", "Glass", lambda: tools.glass("Ball", (0.9, 1.0, 0.95)), False)
lobe("glass_rough", "rough Glass under a sky", lambda: tools.glass("Ball", (0.9, 1.0, 0.95), roughness=0.3), False)
lobe("refraction", "rough Refraction under a sky", lambda: shader("ShaderNodeBsdfRefraction", Color=(1, 1, 1), Roughness=0.2, IOR=1.3), False)
lobe("translucent", "Translucent", lambda: tools.translucent("Ball", RED))
lobe("transparent", "Transparent, coloured", lambda: shader("ShaderNodeBsdfTransparent", Color=(0.9, 0.5, 0.3)))
lobe("translucent_transparent", "Translucent, 30 % Transparent", lambda: translucent_transparent_ball())
lobe("velvet", "Velvet", lambda: shader("ShaderNodeBsdfVelvet", Color=(0.8, 0.6, 0.4), Sigma=0.6))
lobe("toon_diffuse", "Toon, diffuse", lambda: shader("ShaderNodeBsdfToon", Color=RED, Size=0.5, Smooth=0.0))
lobe("toon_smooth", "Toon with a smooth edge, diffuse", lambda: shader("ShaderNodeBsdfToon", Color=RED, Size=0.5, Smooth=0.2))
lobe("toon_glossy", "Toon, glossy", lambda: shader("ShaderNodeBsdfToon", Color=RED, Size=0.4, Smooth=0.0), component="GLOSSY")
lobe("holdout", "Holdout", lambda: shader("ShaderNodeHoldout", "Holdout"))
lobe("emission", "Emission on the ball", lambda: tools.emission("Ball", (1, 0.6, 0.3), 2.0), False)
lobe("mix_shader", "diffuse and mirror mixed", lambda: mixed_ball())
lobe("principled", "Principled, its defaults", lambda: shader("ShaderNodeBsdfPrincipled", Base_Color=RED))
lobe("principled_metal", "Principled, metal", lambda: shader("ShaderNodeBsdfPrincipled", Base_Color=(0.9, 0.6, 0.3), Metallic=1.0, Roughness=0.3))
lobe("principled_plastic", "Principled, smooth and specular", lambda: shader("ShaderNodeBsdfPrincipled", Base_Color=RED, Specular=1.0, Roughness=0.15, Specular_Tint=0.5))
lobe("principled_sheen", "Principled, sheen", lambda: shader("ShaderNodeBsdfPrincipled", Base_Color=BLUE, Sheen=1.0, Sheen_Tint=0.5, Specular=0.0))
lobe("principled_clearcoat", "Principled, clearcoat under a lamp", lambda: shader("ShaderNodeBsdfPrincipled", Base_Color=BLUE, Clearcoat=1.0, Clearcoat_Roughness=0.2,
                                                                               Specular=0.0))
lobe("principled_anisotropic", "Principled, anisotropic metal", lambda: shader("ShaderNodeBsdfPrincipled", Base_Color=GREY, Metallic=1.0, Anisotropic=0.7, Roughness=0.4))
lobe("principled_transmission", "Principled, transmission under a sky", lambda: shader("ShaderNodeBsdfPrincipled", Base_Color=(0.8, 0.9, 1.0), Transmission=1.0,
                                                                                      Roughness=0.05), False)
lobe("principled_alpha", "Principled, half transparent and glowing", lambda: shader("ShaderNodeBsdfPrincipled", Base_Color=RED, Alpha=0.5, Emission=(0.2, 0.3, 0.1)))
lobe("principled_subsurface", "Principled, subsurface", lambda: shader("ShaderNodeBsdfPrincipled", Base_Color=RED, Subsurface=1.0, Subsurface_Color=(0.8, 0.3, 0.2),
                                                                     Subsurface_Radius=(0.3, 0.15, 0.1), Specular=0.0))
lobe("subsurface", "Subsurface Scattering, random walk", lambda: shader("ShaderNodeSubsurfaceScattering", "BSSRDF", Color=(0.8, 0.5, 0.3), Scale=0.3,
                                                                      Radius=(1.0, 0.5, 0.3)), falloff="RANDOM_WALK")


def named_mix(made):
    """The stage finds the node to change by this name."""
    next(n for n in made.node_tree.nodes if n.bl_idname == "ShaderNodeMixShader").name = "Shader"
    return made


def mixed_ball():
    return named_mix(tools.mixed("Ball", tools.diffuse("First", RED), tools.mirror("Second"), 0.4))


def translucent_transparent_ball():
    return named_mix(tools.mixed("Ball", tools.translucent("First", RED), shader("ShaderNodeBsdfTransparent", Color=(1, 1, 1)), 0.3))


# --- Nodes: the colour of a diffuse floor, ball and box ----------------------------------------------------------------

def pattern(name: str, what: str, build: Callable):
    """`build(tree)` returns the socket that gives the colour of all objects."""
    def change(stage):
        stage.sun()
        node = stage.everywhere(tools.diffuse("Pattern", GREY))
        tree = node.id_data
        tree.links.new(build(tree), node.inputs["Color"])
    add("node", name, what, change)


def texture(node_type: str, output: str = "Color", scale: float | None = 3.0, coordinates: str = "Object", inputs: dict | None = None, **properties):
    def build(tree):
        node, where = tree.nodes.new(node_type), tree.nodes.new("ShaderNodeTexCoord")
        for key, value in properties.items():
            setattr(node, key, value)
        if scale is not None and "Scale" in node.inputs:
            node.inputs["Scale"].default_value = scale
        for key, value in (inputs or {}).items():
            node.inputs[key].default_value = value
        tree.links.new(where.outputs[coordinates], node.inputs["Vector"])
        return node.outputs[output]
    return build


def through(node_type: str, build: Callable, socket: str = "Color", output: str = "Color", inputs: dict | None = None, **properties):
    def built(tree):
        node = tree.nodes.new(node_type)
        for key, value in properties.items():
            setattr(node, key, value)
        for key, value in (inputs or {}).items():
            node.inputs[key].default_value = value
        tree.links.new(build(tree), node.inputs[socket])
        return node.outputs[output]
    return built


NOISE = texture("ShaderNodeTexNoise", inputs={"Detail": 3.0, "Distortion": 0.5})
pattern("noise", "Noise Texture", NOISE)
pattern("musgrave", "Musgrave Texture", texture("ShaderNodeTexMusgrave", "Fac"))
pattern("voronoi", "Voronoi Texture", texture("ShaderNodeTexVoronoi"))
pattern("wave", "Wave Texture", texture("ShaderNodeTexWave", inputs={"Distortion": 2.0}))
pattern("gradient", "Gradient Texture", texture("ShaderNodeTexGradient", gradient_type="SPHERICAL"))
pattern("magic", "Magic Texture", texture("ShaderNodeTexMagic"))
pattern("brick", "Brick Texture", texture("ShaderNodeTexBrick"))
pattern("checker_generated", "Checker Texture on generated coordinates", texture("ShaderNodeTexChecker", coordinates="Generated"))
pattern("white_noise", "White Noise on cells", lambda tree: white_noise(tree))
pattern("color_ramp", "Noise through a Color Ramp", through("ShaderNodeValToRGB", texture("ShaderNodeTexNoise", "Fac"), "Fac"))
pattern("hue_saturation", "Noise through Hue/Saturation", through("ShaderNodeHueSaturation", NOISE, inputs={"Hue": 0.7, "Saturation": 1.6}))
pattern("rgb_curves", "Noise through RGB Curves", through("ShaderNodeRGBCurve", NOISE))
pattern("gamma", "Noise through Gamma", through("ShaderNodeGamma", NOISE, inputs={"Gamma": 2.2}))
pattern("invert", "Noise through Invert", through("ShaderNodeInvert", NOISE))
pattern("vector_rotate", "object coordinates through Vector Rotate", lambda tree: rotated(tree))
pattern("fresnel", "Fresnel as a colour", lambda tree: tree.nodes.new("ShaderNodeFresnel").outputs[0])
pattern("layer_weight", "Layer Weight as a colour", lambda tree: tree.nodes.new("ShaderNodeLayerWeight").outputs["Facing"])
pattern("geometry_normal", "the normal as a colour", lambda tree: tree.nodes.new("ShaderNodeNewGeometry").outputs["Normal"])
pattern("object_info", "Object Info: colour", lambda tree: tree.nodes.new("ShaderNodeObjectInfo").outputs["Color"])
pattern("camera_data", "Camera Data: view vector", lambda tree: tree.nodes.new("ShaderNodeCameraData").outputs["View Vector"])
pattern("wireframe", "Wireframe", lambda tree: wireframe(tree))
pattern("ambient_occlusion", "Ambient Occlusion as a colour", lambda tree: ambient_occlusion(tree))
pattern("ambient_occlusion_inside", "Ambient Occlusion inside and of the object alone", lambda tree: ambient_occlusion(tree, inside=True, only_local=True))


def white_noise(tree):
    snapped = through("ShaderNodeVectorMath", lambda t: t.nodes.new("ShaderNodeTexCoord").outputs["Object"], "Vector", "Vector", operation="SNAP")(tree)
    snapped.node.inputs[1].default_value = (0.3, 0.3, 0.3)
    node = tree.nodes.new("ShaderNodeTexWhiteNoise")
    tree.links.new(snapped, node.inputs["Vector"])
    return node.outputs["Color"]


def rotated(tree):
    return through("ShaderNodeVectorRotate", lambda t: t.nodes.new("ShaderNodeTexCoord").outputs["Object"], "Vector", "Vector", inputs={"Angle": 0.8})(tree)


def ambient_occlusion(tree, **properties):
    node = tree.nodes.new("ShaderNodeAmbientOcclusion")
    node.inputs["Distance"].default_value, node.inputs["Color"].default_value, node.samples = 0.6, (*BLUE, 1.0), 4
    for key, value in properties.items():
        setattr(node, key, value)
    return node.outputs["Color"]


def wireframe(tree):
    node = tree.nodes.new("ShaderNodeWireframe")
    node.inputs["Size"].default_value = 0.03
    return node.outputs[0]


@feature("node", "image_texture", "Image Texture on a UV map, closest")
def _(stage):
    stage.sun()
    pixels = [v for y in range(8) for x in range(8) for v in (x / 7, y / 7, 0.3 if (x + y) % 2 else 0.8, 1.0)]
    made = stage.material([stage.floor], tools.diffuse("Pictured", GREY))
    tools.image_texture(made, tools.packed_image("Picture", 8, 8, pixels)).interpolation = "Closest"


@feature("node", "bump", "Bump by noise")
def _(stage):
    stage.sun()
    node = stage.everywhere(tools.diffuse("Bumps", GREY))
    bump = node.id_data.nodes.new("ShaderNodeBump")
    bump.inputs["Strength"].default_value, bump.inputs["Distance"].default_value = 0.6, 0.1
    node.id_data.links.new(texture("ShaderNodeTexNoise", "Fac", 4.0)(node.id_data), bump.inputs["Height"])
    node.id_data.links.new(bump.outputs[0], node.inputs["Normal"])


@feature("node", "normal_map", "Normal Map on a UV map")
def _(stage):
    stage.sun()
    pixels = [v for y in range(16) for x in range(16) for v in (0.5 + 0.3 * math.sin(x * 0.8), 0.5 + 0.3 * math.cos(y * 0.8), 0.85, 1.0)]
    made = tools.diffuse("Floor", GREY)
    stage.material([stage.floor], made)
    node, tree = tools.shader_of(made), made.node_tree
    image = tools.packed_image("Normals", 16, 16, pixels)
    image.colorspace_settings.name = "Non-Color"
    picture, normal = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeNormalMap")
    picture.image = image
    tree.links.new(picture.outputs[0], normal.inputs["Color"])
    tree.links.new(normal.outputs[0], node.inputs["Normal"])


@feature("node", "light_path", "a floor that only the camera sees red")
def _(stage):
    stage.sun()
    node = stage.everywhere(tools.diffuse("Trick", GREY))
    tree = node.id_data
    path, mix = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMixRGB")
    mix.inputs[1].default_value, mix.inputs[2].default_value = (0.1, 0.8, 0.1, 1), (0.8, 0.2, 0.2, 1)
    tree.links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
    tree.links.new(mix.outputs[0], node.inputs["Color"])


@feature("node", "attribute", "a colour attribute of the vertices")
def _(stage):
    stage.sun()
    layer = stage.box.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    for i, entry in enumerate(layer.data):
        entry.color = (0.9 * (i % 2), 0.3 + 0.05 * (i % 8), 0.6, 1)
    made = tools.diffuse("Painted", GREY)
    stage.material([stage.box], made)
    node = made.node_tree.nodes.new("ShaderNodeAttribute")
    node.attribute_name = "Paint"
    made.node_tree.links.new(node.outputs["Color"], tools.shader_of(made).inputs["Color"])


def asks(stage: Stage, things: list[bpy.types.Object], node_type: str, output: str, **properties) -> bpy.types.Node:
    """Colour objects by this output of a node, with a sun. Returns the Diffuse node of the material."""
    stage.sun()
    made = tools.diffuse("Asking", GREY)
    stage.material(things, made)
    tree, shown = made.node_tree, tools.shader_of(made)
    node = tree.nodes.new(node_type)
    for key, value in properties.items():
        setattr(node, key, value)
    tree.links.new(node.outputs[output], shown.inputs["Color"])
    return shown


def attribute_of(domain: str, kind: str, values: Callable, output: str = "Color") -> None:
    """An attribute of the box by its domain and type; `values` gives that of element i."""
    name = f"attribute_{domain.lower()}_{kind.lower()}"

    def change(stage):
        stage.sun()
        layer = stage.box.data.attributes.new("Value", kind, domain)
        member = "color" if "COLOR" in kind else "vector" if kind in ("FLOAT_VECTOR", "FLOAT2") else "value"
        for i, element in enumerate(layer.data):
            setattr(element, member, values(i))
        node = tools.shader_of(stage.box.data.materials[0])
        tree = node.id_data
        read = tree.nodes.new("ShaderNodeAttribute")
        read.attribute_name = "Value"
        tree.links.new(read.outputs[output], node.inputs["Color"])
    add("node", name, f"an attribute of the box: {kind} of each {domain}", change)


def rgb(i: int) -> tuple[float, float, float]:
    return (0.2 + 0.6 * (i % 2), 0.2 + 0.3 * (i % 3), 0.8 - 0.15 * (i % 5))


attribute_of("EDGE", "FLOAT", lambda i: 0.1 + 0.07 * i, "Fac")
attribute_of("EDGE", "FLOAT_VECTOR", rgb, "Vector")
attribute_of("FACE", "INT", lambda i: i % 2, "Fac")
attribute_of("FACE", "FLOAT_COLOR", lambda i: (*rgb(i), 1.0))
attribute_of("POINT", "BOOLEAN", lambda i: i % 3 == 0, "Fac")
attribute_of("POINT", "FLOAT2", lambda i: rgb(i)[:2], "Vector")
attribute_of("POINT", "INT8", lambda i: i % 2, "Fac")
attribute_of("CORNER", "FLOAT_VECTOR", rgb, "Vector")
attribute_of("CORNER", "FLOAT", lambda i: 0.1 + 0.03 * i, "Fac")
attribute_of("CORNER", "BYTE_COLOR", lambda i: (*rgb(i), 1.0))


@feature("node", "property_of_object", "an attribute of the object: a custom property, and pass_index by its path")
def _(stage):
    asks(stage, [stage.ball, stage.box], "ShaderNodeAttribute", "Color", attribute_type="OBJECT", attribute_name="tint")
    stage.ball["tint"], stage.box["tint"], stage.floor["light"] = [0.2, 0.7, 0.9], 0.8, 0.6
    made = tools.diffuse("Floor by number", GREY)
    stage.material([stage.floor], made)
    tree, node, divide = made.node_tree, made.node_tree.nodes.new("ShaderNodeAttribute"), made.node_tree.nodes.new("ShaderNodeMath")
    node.attribute_type, node.attribute_name, stage.floor.pass_index = "OBJECT", "pass_index", 6
    divide.operation, divide.inputs[1].default_value = "DIVIDE", 10.0
    tree.links.new(node.outputs["Fac"], divide.inputs[0])
    tree.links.new(divide.outputs[0], tools.shader_of(made).inputs["Color"])


@feature("node", "property_of_instancer", "an attribute of the instancer: a box shown by three empties of other colours")
def _(stage):
    bpy.data.objects.remove(stage.ball)
    asks(stage, [stage.box], "ShaderNodeAttribute", "Color", attribute_type="INSTANCER", attribute_name="color")
    hidden = bpy.data.collections.new("Hidden")
    hidden.objects.link(stage.box)
    stage.scene.collection.objects.unlink(stage.box)
    for i, colour in enumerate(((0.9, 0.2, 0.1, 1), (0.1, 0.8, 0.3, 1), (0.2, 0.3, 0.9, 1))):
        empty = bpy.data.objects.new(f"Empty {i}", None)
        empty.instance_type, empty.instance_collection, empty.color = "COLLECTION", hidden, colour
        empty.location = (0.95 * i - 1.65, 0, 0)
        stage.scene.collection.objects.link(empty)


@feature("node", "property_of_view_layer", "an attribute of the view layer, which the scene has")
def _(stage):
    stage.scene["tint"] = [0.9, 0.5, 0.1]
    asks(stage, [stage.ball, stage.floor], "ShaderNodeAttribute", "Color", attribute_type="VIEW_LAYER", attribute_name="tint")


@feature("node", "random_per_island", "Random Per Island on a mesh of twenty-five boxes")
def _(stage):
    bpy.data.objects.remove(stage.ball)
    bpy.data.objects.remove(stage.box)
    points, faces = [], []
    for i in range(25):
        x, y = 0.7 * (i % 5) - 1.65, 0.7 * (i // 5) - 1.65
        corners, sides = tools.box_geometry((x, y, 0), (x + 0.5, y + 0.5, 0.5))
        faces += [tuple(len(points) + k for k in side) for side in sides]
        points += corners
    asks(stage, [tools.add_mesh("Boxes", points, faces)], "ShaderNodeNewGeometry", "Random Per Island")


@feature("node", "pointiness", "Pointiness on a smooth monkey and a box")
def _(stage):
    bpy.data.objects.remove(stage.ball)
    bpy.ops.mesh.primitive_monkey_add(size=1.6, location=(-0.6, 0, 0.8))
    monkey = bpy.context.object
    bpy.ops.object.shade_smooth()
    shown = asks(stage, [monkey, stage.box], "ShaderNodeNewGeometry", "Pointiness")
    tree = shown.id_data
    steep = tree.nodes.new("ShaderNodeMapRange")
    steep.inputs["From Min"].default_value, steep.inputs["From Max"].default_value = 0.4, 0.65
    tree.links.new(shown.inputs["Color"].links[0].from_socket, steep.inputs["Value"])
    tree.links.new(steep.outputs["Result"], shown.inputs["Color"])


# --- Geometry --------------------------------------------------------------------------------------------------------

@feature("geometry", "coarse_smooth_ball", "a smooth ball of 16 by 8 faces in the sun: the shadow terminator")
def _(stage):
    stage.sky((0, 0, 0))
    bpy.data.objects.remove(stage.ball)
    bpy.data.objects.remove(stage.box)
    tools.add_sphere("Coarse", (0, 0, 1.0), 1.0, tools.diffuse("Coarse", GREY), sides=16)
    tools.sun_light("Sun", (1, 0.4, -0.6), 3.0, angle=0.0)


@feature("geometry", "coarse_smooth_ball_area", "the same under an area lamp")
def _(stage):
    FEATURES["coarse_smooth_ball"].change(stage)
    bpy.data.objects.remove(bpy.data.objects["Sun"])
    tools.area_light("Lamp", (-3, -1.2, 2.2), (0, 0, 0.8), 0.6, 300)


@feature("geometry", "flat_ball", "a flat-shaded ball")
def _(stage):
    stage.sun()
    stage.ball.data.polygons.foreach_set("use_smooth", [False] * len(stage.ball.data.polygons))


@feature("geometry", "subdivision", "a subdivided box")
def _(stage):
    stage.sun()
    stage.box.modifiers.clear()
    stage.box.modifiers.new("Subdivision", "SUBSURF").render_levels = 3


@feature("geometry", "modifiers", "an array of mirrored, solid boxes")
def _(stage):
    stage.sun()
    array = stage.box.modifiers.new("Array", "ARRAY")
    array.count, array.relative_offset_displace = 3, (0.2, 1.3, 0.3)


@feature("geometry", "instances", "a collection shown three times")
def _(stage):
    stage.sun()
    group = bpy.data.collections.new("Group")
    group.objects.link(stage.ball)
    for i in range(3):
        empty = bpy.data.objects.new(f"Instance {i}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", group
        empty.location, empty.scale, empty.rotation_euler = (0.9 * i - 0.8, 1.0, 0.2 * i), (0.6, 0.7, 0.5 + 0.2 * i), (0.3 * i, 0.2, 0.5)
        stage.scene.collection.objects.link(empty)


@feature("geometry", "particles", "particle instances on the floor")
def _(stage):
    stage.sun()
    stage.floor.modifiers.new("Particles", "PARTICLE_SYSTEM")
    settings = stage.floor.particle_systems[0].settings
    settings.type, settings.count, settings.render_type, settings.instance_object = "HAIR", 60, "OBJECT", stage.box
    settings.particle_size, settings.hair_length = 0.06, 1.0


@feature("geometry", "curve", "a bevelled curve")
def _(stage):
    stage.sun()
    curve = bpy.data.curves.new("Curve", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.resolution_u = "3D", 0.12, 8
    spline = curve.splines.new("BEZIER")
    spline.bezier_points.add(2)
    for p, at in zip(spline.bezier_points, ((-1.2, -1, 0.2), (0, -1.2, 0.8), (1.2, -1, 0.3))):
        p.co, p.handle_left_type, p.handle_right_type = at, "AUTO", "AUTO"
    curve.materials.append(tools.diffuse("Curve", (0.8, 0.7, 0.2)))
    stage.scene.collection.objects.link(bpy.data.objects.new("Curve", curve))


@feature("geometry", "text", "an extruded text")
def _(stage):
    stage.sun()
    text = bpy.data.curves.new("Text", "FONT")
    text.body, text.extrude, text.size = "Ajar", 0.08, 0.9
    made = bpy.data.objects.new("Text", text)
    made.location, made.rotation_euler = (-0.9, -1.2, 0.1), (1.3, 0, 0)
    stage.scene.collection.objects.link(made)


@feature("geometry", "metaball", "two metaballs")
def _(stage):
    stage.sun()
    data = bpy.data.metaballs.new("Meta")
    data.render_resolution = 0.08
    for x in (-0.35, 0.35):
        element = data.elements.new()
        element.co, element.radius = (x, -1.1, 0.6), 0.6
    stage.scene.collection.objects.link(bpy.data.objects.new("Meta", data))


@feature("geometry", "custom_normals", "custom split normals")
def _(stage):
    stage.sun()
    mesh = stage.box.data
    stage.box.modifiers.clear()
    mesh.use_auto_smooth = True
    mesh.normals_split_custom_set([(Vector(mesh.vertices[loop.vertex_index].co) - Vector((0.7, 0, 0.45))).normalized() for loop in mesh.loops])


@feature("geometry", "two_materials", "two materials on one mesh")
def _(stage):
    stage.sun()
    stage.ball.data.materials.append(tools.glossy("Second", (0.8, 0.8, 0.8), 0.3))
    stage.ball.data.polygons.foreach_set("material_index", [i % 2 for i in range(len(stage.ball.data.polygons))])


@feature("geometry", "no_material", "objects without a material")
def _(stage):
    stage.sun()
    for thing in (stage.ball, stage.box):
        thing.data.materials.clear()


@feature("geometry", "negative_scale", "a mirrored glass of negative scale")
def _(stage):
    stage.on_ball(tools.glass("Ball"))
    stage.ball.scale = (-1, 0.7, 1.2)


def displaced(name: str, what: str, method: str = "DISPLACEMENT", node_type: str = "ShaderNodeDisplacement", smooth: Callable | None = None,
              more: Callable | None = None, **properties) -> None:
    """The ball, with 24,000 triangles, that a noise moves. `smooth` tells which faces are smooth; `more` changes the scene."""
    def change(stage):
        stage.sun()
        ball = stage.ball
        node = stage.on_ball(tools.diffuse("Moved", GREY))
        tree, output = node.id_data, next(n for n in node.id_data.nodes if n.type == "OUTPUT_MATERIAL")
        noise = tree.nodes.new("ShaderNodeTexNoise")
        noise.inputs["Scale"].default_value = 3.0
        tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], noise.inputs["Vector"])
        moved = tree.nodes.new(node_type)
        for key, value in properties.items():
            setattr(moved, key, value)
        is_vector = node_type == "ShaderNodeVectorDisplacement"
        moved.inputs["Midlevel"].default_value, moved.inputs["Scale"].default_value = 0.5, 0.5
        tree.links.new(noise.outputs["Color" if is_vector else "Fac"], moved.inputs["Vector" if is_vector else "Height"])
        tree.links.new(moved.outputs[0], output.inputs["Displacement"])
        ball.active_material.cycles.displacement_method = method
        finer = ball.modifiers.new("Finer", "SUBSURF")
        finer.subdivision_type, finer.levels, finer.render_levels = "SIMPLE", 2, 2
        if smooth is not None:
            faces = ball.data.polygons
            faces.foreach_set("use_smooth", [smooth(i) for i in range(len(faces))])
        if more is not None:
            more(stage, tree)
    add("displacement", name, what, change)


def squeezed(stage: Stage, _tree: bpy.types.NodeTree) -> None:
    stage.ball.scale, stage.ball.rotation_euler = (1.2, 0.8, 0.7), (0.3, 0.2, 0.5)


def shown_twice(stage: Stage, _tree: bpy.types.NodeTree) -> None:
    other = stage.ball.copy()   # shares the mesh
    stage.scene.collection.objects.link(other)
    other.location, other.scale = (0.7, -0.2, 1.3), (0.5, 0.5, 0.5)


def gentle(_stage: Stage, tree: bpy.types.NodeTree) -> None:
    next(n for n in tree.nodes if n.type == "DISPLACEMENT").inputs["Scale"].default_value = 0.1


def coloured(output: str) -> Callable:
    def change(_stage: Stage, tree: bpy.types.NodeTree) -> None:
        node = tree.nodes.new("ShaderNodeTexCoord" if output == "Generated" else "ShaderNodeNewGeometry")
        separate = tree.nodes.new("ShaderNodeVectorMath")
        separate.operation = "ABSOLUTE"
        tree.links.new(node.outputs[output], separate.inputs[0])
        tree.links.new(separate.outputs[0], next(n for n in tree.nodes if n.type == "BSDF_DIFFUSE").inputs["Color"])
    return change


displaced("displacement", "a smooth ball that a noise moves")
displaced("displacement_both", "the same, with bump", "BOTH")
displaced("displacement_flat", "a flat-shaded ball that a noise moves", smooth=lambda face: False)
displaced("displacement_both_flat", "the same, with bump", "BOTH", smooth=lambda face: False)
displaced("displacement_mixed", "a ball with smooth and flat faces that a noise moves", smooth=lambda face: face % 4 < 2)
displaced("displacement_world", "displacement in world space, of a turned and squeezed ball", more=squeezed, space="WORLD")
displaced("displacement_object", "displacement in object space, of a turned and squeezed ball", more=squeezed, space="OBJECT")
displaced("displacement_shared", "two balls with one mesh that a noise moves", more=shown_twice)
displaced("displacement_shared_both", "the same, with bump", "BOTH", more=shown_twice)
displaced("displacement_vector", "a vector displacement in object space", node_type="ShaderNodeVectorDisplacement", space="OBJECT", more=squeezed)
displaced("displacement_tangent", "a vector displacement in tangent space", node_type="ShaderNodeVectorDisplacement", space="TANGENT")
displaced("displacement_squeezed_both", "displacement in object space with bump, of a turned and squeezed ball", "BOTH", more=squeezed, space="OBJECT")
displaced("displacement_gentle_both", "displacement by a fifth, with bump", "BOTH", more=gentle)
displaced("displacement_generated", "Generated coordinates of a displaced ball", more=coloured("Generated"))
displaced("displacement_position", "positions on a displaced ball, with bump", "BOTH", more=coloured("Position"))


# ---- Adaptive subdivision ---------------------------------------------------------------------------------------------

def adaptive(kind: str, name: str, what: str, more: Callable | None = None, simple: bool = False, scale: float = 0.0) -> None:
    """A box of six faces instead of the ball, which adaptive subdivision divides. A noise moves it if `scale` is not 0."""
    def change(stage):
        stage.sun()
        stage.scene.cycles.feature_set = "EXPERIMENTAL"
        stage.scene.cycles.dicing_rate = 0.5
        bpy.data.objects.remove(stage.ball)
        stage.ball = tools.add_box("Ball", (-1.25, -0.6, 0.0), (-0.05, 0.6, 1.2), tools.diffuse("Ball", RED))
        faces = stage.ball.data.polygons
        faces.foreach_set("use_smooth", [True] * len(faces))
        modifier = stage.ball.modifiers.new("Subdivision", "SUBSURF")
        modifier.levels = modifier.render_levels = 2
        modifier.subdivision_type = "SIMPLE" if simple else "CATMULL_CLARK"
        stage.ball.cycles.use_adaptive_subdivision = True
        tree = stage.ball.active_material.node_tree
        if scale != 0.0:
            moved, noise = tree.nodes.new("ShaderNodeDisplacement"), tree.nodes.new("ShaderNodeTexNoise")
            noise.inputs["Scale"].default_value = 3.0
            moved.inputs["Midlevel"].default_value, moved.inputs["Scale"].default_value = 0.5, scale
            tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], noise.inputs["Vector"])
            tree.links.new(noise.outputs["Fac"], moved.inputs["Height"])
            tree.links.new(moved.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Displacement"])
            stage.ball.active_material.cycles.displacement_method = "DISPLACEMENT"
        if more is not None:
            more(stage, tree)
    add(kind, name, what, change)


def creased(stage: Stage, _tree: bpy.types.NodeTree) -> None:
    for i, edge in enumerate(stage.ball.data.edges):
        edge.crease = (0.0, 0.3, 1.0)[i % 3]


def flat(stage: Stage, _tree: bpy.types.NodeTree) -> None:
    stage.ball.data.polygons.foreach_set("use_smooth", [False] * len(stage.ball.data.polygons))


def with_ngons(stage: Stage, _tree: bpy.types.NodeTree) -> None:
    rim = [(math.cos(a), math.sin(a)) for a in (2 * math.pi * k / 7 for k in range(7))]
    vertices = [(0.6 * x - 0.65, 0.6 * y, z) for z in (0.0, 1.2) for x, y in rim]
    sides = [(k, (k + 1) % 7, 7 + (k + 1) % 7, 7 + k) for k in range(1, 7)]
    made = bpy.data.meshes.new("Prism")
    made.from_pydata(vertices, [], [tuple(range(6, -1, -1)), tuple(range(7, 14)), (0, 1, 8), (0, 8, 7), *sides])
    made.polygons.foreach_set("use_smooth", [True] * len(made.polygons))
    made.materials.append(stage.ball.active_material)
    stage.ball.data = made


def with_maps(stage: Stage, tree: bpy.types.NodeTree) -> None:
    """Checkers on a UV map of six islands, times colours of corners."""
    data = stage.ball.data
    layer = data.uv_layers.new(name="UVMap") if not data.uv_layers else data.uv_layers[0]
    colors = data.color_attributes.new("Corners", "FLOAT_COLOR", "CORNER")
    for face in data.polygons:
        for k, loop in enumerate(face.loop_indices):
            layer.data[loop].uv = ((0, 0), (1, 0), (1, 1), (0, 1))[k % 4]
            colors.data[loop].color = ((1, 0.3, 0.3, 1), (0.3, 1, 0.3, 1), (0.3, 0.3, 1, 1), (1, 1, 1, 1))[(k + face.index) % 4]
    checker, named, both = tree.nodes.new("ShaderNodeTexChecker"), tree.nodes.new("ShaderNodeVertexColor"), tree.nodes.new("ShaderNodeMixRGB")
    checker.inputs["Scale"].default_value = 4.0
    named.layer_name, both.blend_type = "Corners", "MULTIPLY"
    both.inputs["Fac"].default_value = 1.0
    tree.links.new(tree.nodes.new("ShaderNodeUVMap").outputs["UV"], checker.inputs["Vector"])
    tree.links.new(checker.outputs["Color"], both.inputs["Color1"])
    tree.links.new(named.outputs["Color"], both.inputs["Color2"])
    tree.links.new(both.outputs["Color"], next(n for n in tree.nodes if n.type == "BSDF_DIFFUSE").inputs["Color"])


def with_flat_faces(stage: Stage, _tree: bpy.types.NodeTree) -> None:
    stage.ball.data.materials.append(tools.glossy("Second", (0.8, 0.8, 0.8), 0.3))
    for i, face in enumerate(stage.ball.data.polygons):
        face.material_index = i % 2


def off_screen(stage: Stage, _tree: bpy.types.NodeTree) -> None:
    """The box casts its shadow from outside the picture."""
    stage.ball.location = (-2.2, -1.5, 1.0)
    stage.scene.cycles.offscreen_dicing_scale = 8.0


def with_dicing_camera(stage: Stage, _tree: bpy.types.NodeTree) -> None:
    other = stage.camera.copy()
    stage.scene.collection.objects.link(other)
    other.location = (0, -7, 3)
    stage.scene.cycles.dicing_camera = other


def with_rate(stage: Stage, _tree: bpy.types.NodeTree) -> None:
    stage.ball.cycles.dicing_rate = 2.0


def few_levels(stage: Stage, _tree: bpy.types.NodeTree) -> None:
    stage.scene.cycles.max_subdivisions = 2


def bent(stage: Stage, _tree: bpy.types.NodeTree) -> None:
    """A modifier before the subdivision."""
    bend = stage.ball.modifiers.new("Bend", "SIMPLE_DEFORM")
    bend.deform_method, bend.factor, bend.deform_axis = "TAPER", 0.6, "Z"
    with bpy.context.temp_override(object=stage.ball):
        bpy.ops.object.modifier_move_to_index(modifier="Bend", index=0)


adaptive("geometry", "adaptive", "adaptive subdivision of a box of six faces")
adaptive("geometry", "adaptive_simple", "the same with flat faces, with simple subdivision", flat, simple=True)
adaptive("geometry", "adaptive_creases", "the same, with creases", creased)
adaptive("geometry", "adaptive_ngons", "adaptive subdivision of faces with three and seven corners", with_ngons)
adaptive("geometry", "adaptive_maps", "a UV map and colours of corners under adaptive subdivision", with_maps)
adaptive("geometry", "adaptive_materials", "two materials under adaptive subdivision", with_flat_faces)
adaptive("geometry", "adaptive_modifiers", "adaptive subdivision after another modifier", bent)
adaptive("geometry", "adaptive_twice", "two objects with one mesh under adaptive subdivision", shown_twice)
adaptive("displacement", "adaptive_displaced", "a noise that moves a box of six faces under adaptive subdivision", scale=0.5)
adaptive("displacement", "adaptive_displaced_simple", "the same, with simple subdivision", simple=True, scale=0.5)
adaptive("displacement", "adaptive_rate", "the same, with a dicing rate of the object", with_rate, scale=0.5)
adaptive("displacement", "adaptive_camera", "the same, with a dicing camera", with_dicing_camera, scale=0.5)
adaptive("displacement", "adaptive_offscreen", "the same, outside the picture, with an offscreen scale", off_screen, scale=0.5)
adaptive("displacement", "adaptive_levels", "the same, with two subdivisions at most", few_levels, scale=0.3)


@feature("geometry", "ray_visibility", "a ball that diffuse rays and shadows do not see")
def _(stage):
    stage.sun()
    stage.ball.visible_shadow = stage.ball.visible_diffuse = False


@feature("geometry", "hidden_from_camera", "a box that only mirrors see")
def _(stage):
    stage.sun()
    stage.box.visible_camera = False
    stage.on_ball(tools.mirror("Ball"))


@feature("geometry", "object_holdout", "an object that holds out")
def _(stage):
    stage.sun()
    stage.box.is_holdout = True


@feature("geometry", "shadow_catcher", "a floor that catches shadows before a transparent film")
def _(stage):
    stage.sun()
    stage.floor.is_shadow_catcher = True
    stage.scene.render.film_transparent = True


@feature("geometry", "shadow_catcher_over_sky", "a floor that catches shadows below a sky")
def _(stage):
    stage.panel()
    stage.floor.is_shadow_catcher = True


def culled(stage: Stage, **settings) -> None:
    """Boxes beside the frame, behind the camera and far away, which shade the others, and may be left out."""
    stage.sun()
    stage.scene.render.use_simplify = True
    for name, value in settings.items():
        setattr(stage.scene.cycles, name, value)
    for place in ((-3.5, -2.0, 0.0), (-2.0, -5.5, 2.5), (-6.0, -6.0, 3.0), (1.5, 0.5, 0.0)):
        box = tools.add_box("Shade", place, tuple(x + 1.0 for x in place), tools.diffuse("Shade", GREY))
        box.cycles.use_camera_cull = box.cycles.use_distance_cull = True


@feature("geometry", "camera_culling", "boxes outside the frame that camera culling leaves out")
def _(stage):
    culled(stage, use_camera_cull=True, camera_cull_margin=0.1)


@feature("geometry", "distance_culling", "boxes that are left out by their distance")
def _(stage):
    culled(stage, use_distance_cull=True, distance_cull_margin=4.0)



# --- Hair -------------------------------------------------------------------------------------------------------------

def hair(stage: Stage, material: bpy.types.Material | None = None, count: int = 900, length: float = 0.35, radius: float = 0.02) -> bpy.types.ParticleSettings:
    """Strands on the ball, bent down, below the panel."""
    ball = stage.ball
    ball.data.materials.append(material or tools.diffuse("Hair", (0.6, 0.35, 0.15)))
    system = ball.modifiers.new("Hair", "PARTICLE_SYSTEM").particle_system
    settings = system.settings
    settings.type, settings.count, settings.hair_length = "HAIR", count, length
    settings.use_advanced_hair = True
    settings.brownian_factor = 0.02
    settings.effector_weights.gravity = 1.0
    settings.render_step, settings.hair_step = 4, 5
    settings.material = len(ball.material_slots)
    settings.root_radius, settings.tip_radius, settings.radius_scale = 1.0, 0.2, 2.0 * radius
    stage.panel()
    return settings


@feature("hair", "hair", "particle hair as ribbons, diffuse")
def _(stage: Stage):
    hair(stage)


@feature("hair", "hair_thick", "the same as tubes")
def _(stage: Stage):
    hair(stage)
    stage.scene.cycles_curves.shape = "THICK"


@feature("hair", "hair_glossy", "glossy strands, pointed and of another shape, without their emitter")
def _(stage: Stage):
    settings = hair(stage, shader("ShaderNodeBsdfGlossy", Color=(0.8, 0.7, 0.5, 1.0), Roughness=0.35))
    settings.shape, settings.use_close_tip = 0.6, True
    stage.ball.show_instancer_for_render = False


@feature("hair", "hair_info", "what Hair Info says, shining")
def _(stage: Stage):
    material = bpy.data.materials.new("Info")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    info, mix, emission, out = (nodes.new(kind) for kind in ("ShaderNodeHairInfo", "ShaderNodeCombineXYZ", "ShaderNodeEmission", "ShaderNodeOutputMaterial"))
    for number, output in enumerate(("Intercept", "Random", "Is Strand")):
        links.new(info.outputs[output], mix.inputs[number])
    links.new(mix.outputs[0], emission.inputs["Color"])
    links.new(emission.outputs[0], out.inputs["Surface"])
    hair(stage, material, count=300)


@feature("hair", "hair_texture", "colours of a UV map at the roots and of Generated coordinates")
def _(stage: Stage):
    material = tools.diffuse("Roots", (1, 1, 1))
    nodes, links = material.node_tree.nodes, material.node_tree.links
    coordinates, mix = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeMixRGB")
    links.new(coordinates.outputs["UV"], mix.inputs["Color1"])
    links.new(coordinates.outputs["Generated"], mix.inputs["Color2"])
    links.new(mix.outputs[0], tools.shader_of(material).inputs["Color"])
    hair(stage, material)


@feature("hair", "hair_instances", "a ball with hair, shown three times, turned and squeezed")
def _(stage: Stage):
    hair(stage, count=300)
    collection = bpy.data.collections.new("Balls")
    collection.objects.link(stage.ball)
    stage.scene.collection.objects.unlink(stage.ball)
    for number in range(3):
        empty = bpy.data.objects.new(f"There {number}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location, empty.rotation_euler, empty.scale = (0.4 * number, 0.3 * number, 0.2 * number), (0.3 * number, 0.2, 0.5 * number), (0.6, 0.6, 0.5 + 0.1 * number)
        stage.scene.collection.objects.link(empty)


@feature("hair", "hair_curves", "a hair curves object, made by geometry nodes")
def _(stage: Stage):
    thing = bpy.data.objects.new("Curves", bpy.data.hair_curves.new("Curves"))
    stage.scene.collection.objects.link(thing)
    tree = bpy.data.node_groups.new("Grow", "GeometryNodeTree")
    tree.outputs.new("NodeSocketGeometry", "Geometry")
    names = ("GeometryNodeMeshUVSphere", "GeometryNodeMeshToPoints", "GeometryNodeCurveQuadraticBezier", "GeometryNodeInstanceOnPoints", "GeometryNodeRealizeInstances",
             "GeometryNodeSetCurveRadius", "GeometryNodeSetMaterial", "GeometryNodeTransform", "NodeGroupOutput")
    ball, points, line, instances, realized, radius, material, moved, out = (tree.nodes.new(name) for name in names)
    ball.inputs["Segments"].default_value, ball.inputs["Rings"].default_value, ball.inputs["Radius"].default_value = 24, 16, 0.6
    line.inputs["Resolution"].default_value = 6
    line.inputs["Start"].default_value, line.inputs["Middle"].default_value, line.inputs["End"].default_value = (0, 0, 0), (0.1, 0, 0.2), (0.35, 0, 0.25)
    radius.inputs["Radius"].default_value = 0.02
    material.inputs["Material"].default_value = tools.diffuse("Hair", (0.15, 0.5, 0.3))
    moved.inputs["Translation"].default_value = (-0.65, 0, 0.6)
    for here, there, socket in ((ball, points, 0), (points, instances, 0), (instances, realized, 0), (realized, radius, 0), (radius, material, 0), (material, moved, 0), (moved, out, 0)):
        tree.links.new(here.outputs[0], there.inputs[socket])
    tree.links.new(line.outputs[0], instances.inputs["Instance"])
    thing.modifiers.new("Grow", "NODES").node_group = tree
    thing.data.materials.append(tools.diffuse("Hair of the object", (0.15, 0.5, 0.3)))
    stage.panel()


def hair_shader(name: str, what: str, node_type: str, thick: bool = False, mesh: bool = False, properties: dict | None = None, **inputs) -> None:
    """A shader of hair on strands, or on the ball."""
    def change(stage: Stage):
        material = shader(node_type, **inputs)
        for key, value in (properties or {}).items():
            setattr(tools.shader_of(material), key, value)
        if mesh:
            stage.panel()
            stage.on_ball(material)
        else:
            hair(stage, material)
        if thick:
            stage.scene.cycles_curves.shape = "THICK"
    add("hair", name, what, change)


BLOND = {"Color": (0.8, 0.6, 0.35, 1.0)}
hair_shader("hair_chiang", "Principled Hair by colour", "ShaderNodeBsdfHairPrincipled", **BLOND)
hair_shader("hair_chiang_thick", "the same on tubes", "ShaderNodeBsdfHairPrincipled", thick=True, **BLOND)
hair_shader("hair_chiang_mesh", "the same on a mesh", "ShaderNodeBsdfHairPrincipled", mesh=True, **BLOND)
hair_shader("hair_melanin", "Principled Hair by melanin, all amounts random", "ShaderNodeBsdfHairPrincipled", properties={"parametrization": "MELANIN"},
            Melanin=0.3, **{"Melanin Redness": 0.6, "Tint": (0.9, 0.8, 1.0, 1.0), "Random Color": 0.8, "Random Roughness": 0.5})
hair_shader("hair_absorption", "Principled Hair by absorption, coated, tilted, rough", "ShaderNodeBsdfHairPrincipled", properties={"parametrization": "ABSORPTION"},
            Coat=0.6, Offset=0.15, Roughness=0.6, IOR=1.4, **{"Radial Roughness": 0.5, "Absorption Coefficient": (0.1, 0.3, 0.6)})
hair_shader("hair_reflection", "the reflection of the Hair BSDF", "ShaderNodeBsdfHair", Color=(0.8, 0.6, 0.4, 1.0), Offset=0.2, RoughnessU=0.3, RoughnessV=0.4)
hair_shader("hair_transmission", "its transmission", "ShaderNodeBsdfHair", properties={"component": "Transmission"},
            Color=(0.8, 0.6, 0.4, 1.0), Offset=0.2, RoughnessU=0.3, RoughnessV=0.4)
hair_shader("hair_reflection_mesh", "its reflection on a mesh", "ShaderNodeBsdfHair", mesh=True, RoughnessU=0.3, RoughnessV=0.4)
hair_shader("hair_transmission_mesh", "its transmission on a mesh", "ShaderNodeBsdfHair", mesh=True, properties={"component": "Transmission"}, RoughnessU=0.3, RoughnessV=0.4)


# --- Point clouds ------------------------------------------------------------------------------------------------------

def chain(tree: bpy.types.NodeTree, *names: str) -> list[bpy.types.Node]:
    """New nodes, of which each has the first output of the one before it at its first input. The last is the output of the group."""
    if hasattr(tree, "interface"):
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    made = [tree.nodes.new(name) for name in (*names, "NodeGroupOutput")]
    for here, there in zip(made, made[1:], strict=False):
        tree.links.new(here.outputs[0], there.inputs[0])
    return made


def stored(tree: bpy.types.NodeTree, node: bpy.types.Node, name: str, kind: str, value: bpy.types.NodeSocket) -> None:
    """Set up a Store Named Attribute."""
    node.data_type = kind
    node.inputs["Name"].default_value = name
    tree.links.new(value, next(socket for socket in node.inputs if socket.name == "Value" and socket.enabled))


def cloud(stage: Stage, material: bpy.types.Material, radius: float = 0.1, above: float = 0.6) -> bpy.types.Object:
    """Points of different radii at the vertices of a ball, in place of the ball, below the panel."""
    bpy.data.objects.remove(stage.ball)
    thing = bpy.data.objects.new("Cloud", bpy.data.meshes.new("Cloud"))
    stage.scene.collection.objects.link(thing)
    tree = bpy.data.node_groups.new("Cloud", "GeometryNodeTree")
    ball, points, color, warmth, assigned, _ = chain(tree, "GeometryNodeMeshUVSphere", "GeometryNodeMeshToPoints", "GeometryNodeStoreNamedAttribute",
                                                   "GeometryNodeStoreNamedAttribute", "GeometryNodeSetMaterial")
    ball.inputs["Segments"].default_value, ball.inputs["Rings"].default_value, ball.inputs["Radius"].default_value = 14, 9, 0.55
    place, random = tree.nodes.new("GeometryNodeInputPosition"), tree.nodes.new("FunctionNodeRandomValue")
    random.data_type = "FLOAT"
    numbers = [socket for socket in random.inputs if socket.enabled]
    numbers[0].default_value, numbers[1].default_value = 0.3 * radius, radius
    value = next(socket for socket in random.outputs if socket.enabled)
    tree.links.new(value, points.inputs["Radius"])
    stored(tree, color, "tint", "FLOAT_COLOR", place.outputs[0])
    stored(tree, warmth, "warmth", "FLOAT", value)
    assigned.inputs["Material"].default_value = material
    thing.modifiers.new("Cloud", "NODES").node_group = tree
    thing.location = (-0.65, 0, above)
    stage.panel()
    return thing


def shining(node_type: str, outputs: dict[str, float], settings: dict | None = None) -> bpy.types.Material:
    """A material that shines in the sum of these outputs of a node, each times a factor and with an offset of one half."""
    material = bpy.data.materials.new("Shining")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    source, emission, out = (nodes.new(kind) for kind in (node_type, "ShaderNodeEmission", "ShaderNodeOutputMaterial"))
    for key, value in (settings or {}).items():
        setattr(source, key, value)
    total = None
    for output, factor in outputs.items():
        scaled = nodes.new("ShaderNodeVectorMath")
        scaled.operation = "MULTIPLY_ADD"
        links.new(source.outputs[output], scaled.inputs[0])
        scaled.inputs[1].default_value = (factor,) * 3
        if total is None:
            scaled.inputs[2].default_value = (0.5,) * 3
        else:
            links.new(total, scaled.inputs[2])
        total = scaled.outputs[0]
    links.new(total, emission.inputs["Color"])
    links.new(emission.outputs[0], out.inputs["Surface"])
    return material


def points(name: str, what: str, material: Callable[[], bpy.types.Material], more: Callable[[Stage, bpy.types.Object], None] | None = None, **settings) -> None:
    def change(stage: Stage):
        thing = cloud(stage, material(), **settings)
        if more:
            more(stage, thing)
    add("point", name, what, change)


def shown_thrice(stage: Stage, thing: bpy.types.Object) -> None:
    """Three instances by a collection, turned and squeezed."""
    thing.location = (0, 0, 0)
    collection = bpy.data.collections.new("Shown")
    collection.objects.link(thing)
    stage.scene.collection.objects.unlink(thing)
    for number in range(3):
        empty = bpy.data.objects.new(f"There {number}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location, empty.rotation_euler = (-1.0 + 0.5 * number, 0.3 * number, 0.6 + 0.4 * number), (0.3 * number, 0.2, 0.5 * number)
        empty.scale = (0.6, 0.6, 0.5 + 0.2 * number)
        stage.scene.collection.objects.link(empty)


# Instances of hair curves. A tuft is a Curves object of a few strands that geometry nodes make around its origin.

def tuft(stage: Stage, material: bpy.types.Material | None = None, smooth: bool = False) -> bpy.types.Object:
    material = material or tools.diffuse("Hair", (0.15, 0.5, 0.3))
    thing = bpy.data.objects.new("Tuft", bpy.data.hair_curves.new("Tuft"))
    stage.scene.collection.objects.link(thing)
    tree = bpy.data.node_groups.new("Tuft", "GeometryNodeTree")
    after = ("GeometryNodeCurveSplineType",) if smooth else ()
    ball, _points, instances, _realized, *spline, assigned, _out = chain(tree, "GeometryNodeMeshUVSphere", "GeometryNodeMeshToPoints", "GeometryNodeInstanceOnPoints",
                                                                       "GeometryNodeRealizeInstances", *after, "GeometryNodeSetMaterial")
    for node in spline:
        node.spline_type = "CATMULL_ROM"
    line, radius = tree.nodes.new("GeometryNodeCurveQuadraticBezier"), tree.nodes.new("GeometryNodeSetCurveRadius")
    ball.inputs["Segments"].default_value, ball.inputs["Rings"].default_value, ball.inputs["Radius"].default_value = 14, 9, 0.4
    line.inputs["Resolution"].default_value = 6
    line.inputs["Start"].default_value, line.inputs["Middle"].default_value, line.inputs["End"].default_value = (0, 0, 0), (0.1, 0, 0.2), (0.35, 0, 0.25)
    radius.inputs["Radius"].default_value = 0.02
    assigned.inputs["Material"].default_value = material
    tree.links.new(line.outputs[0], radius.inputs[0])
    tree.links.new(radius.outputs[0], instances.inputs["Instance"])
    thing.modifiers.new("Tuft", "NODES").node_group = tree
    thing.data.materials.append(material)
    stage.panel()
    return thing


def by_collection(stage: Stage, thing: bpy.types.Object) -> None:
    shown_thrice(stage, thing)


def by_nodes(stage: Stage, thing: bpy.types.Object) -> None:
    """At the vertices of the box, by Instance on Points."""
    tree = bpy.data.node_groups.new("Shown", "GeometryNodeTree")
    tree.inputs.new("NodeSocketGeometry", "Geometry")
    tree.outputs.new("NodeSocketGeometry", "Geometry")
    given, points, shown, joined, out = (tree.nodes.new(name) for name in (
        "NodeGroupInput", "GeometryNodeInstanceOnPoints", "GeometryNodeObjectInfo", "GeometryNodeJoinGeometry", "NodeGroupOutput"))
    shown.inputs["Object"].default_value, shown.inputs["As Instance"].default_value = thing, True
    points.inputs["Rotation"].default_value, points.inputs["Scale"].default_value = (0.3, 0.2, 0.5), (0.6, 0.6, 0.4)
    tree.links.new(given.outputs[0], points.inputs["Points"])
    tree.links.new(shown.outputs["Geometry"], points.inputs["Instance"])
    for geometry in (points.outputs[0], given.outputs[0]):
        tree.links.new(geometry, joined.inputs[0])
    tree.links.new(joined.outputs[0], out.inputs[0])
    stage.box.modifiers.new("Shown", "NODES").node_group = tree
    thing.hide_render = True


def by_particles(stage: Stage, thing: bpy.types.Object) -> None:
    """Particles on the ball."""
    settings = stage.ball.modifiers.new("Shown", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count, settings.frame_start, settings.frame_end, settings.lifetime = "EMITTER", 12, 1, 1, 50
    settings.physics_type, settings.render_type, settings.instance_object = "NO", "OBJECT", thing
    settings.particle_size, settings.size_random, settings.use_rotations = 0.6, 0.3, True
    settings.use_rotation_instance = True
    stage.scene.frame_set(2)
    thing.location = (0, 0, -50)


SHOWN = {"collection": by_collection, "nodes": by_nodes, "particles": by_particles}


def shown_by(name: str, what: str, way: str, make: Callable[[Stage], bpy.types.Object], kind: str = "hair") -> None:
    add(kind, name, what, lambda stage: SHOWN[way](stage, make(stage)))


shown_by("curves_by_collection", "hair curves, shown three times by a collection, turned and squeezed", "collection", tuft)
shown_by("curves_by_nodes", "hair curves, shown by geometry nodes of another object", "nodes", tuft)
shown_by("curves_by_particles", "hair curves, shown by particles", "particles", tuft)
shown_by("curves_smooth", "hair curves of smooth strands, shown three times", "collection", lambda stage: tuft(stage, smooth=True))
shown_by("curves_instances_info", "what Hair Info says on instances, shining", "collection",
         lambda stage: tuft(stage, shining("ShaderNodeHairInfo", {"Intercept": 0.5, "Thickness": 5.0, "Length": 0.5, "Random": 0.3})))
shown_by("curves_instances_chiang", "Principled Hair on instances", "collection", lambda stage: tuft(stage, shader("ShaderNodeBsdfHairPrincipled", **BLOND)))


def attribute_of(name: str) -> dict:
    return {"attribute_type": "GEOMETRY", "attribute_name": name}


def bumpy() -> bpy.types.Material:
    material = tools.diffuse("Bumpy", (0.7, 0.5, 0.3))
    nodes, links = material.node_tree.nodes, material.node_tree.links
    noise, bump = nodes.new("ShaderNodeTexNoise"), nodes.new("ShaderNodeBump")
    noise.inputs["Scale"].default_value, bump.inputs["Strength"].default_value, bump.inputs["Distance"].default_value = 12.0, 0.6, 0.1
    links.new(noise.outputs["Fac"], bump.inputs["Height"])
    links.new(bump.outputs[0], tools.shader_of(material).inputs["Normal"])
    return material


def in_motion(stage: Stage, thing: bpy.types.Object) -> None:
    scene = stage.scene
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    for frame, x in ((0, -1.0), (2, -0.2)):
        thing.location.x = x
        thing.keyframe_insert("location", frame=frame)
    scene.frame_set(1)


def brown() -> bpy.types.Material:
    return tools.diffuse("Points", (0.6, 0.35, 0.15))


points("points", "points of different radii, diffuse", brown)
points("points_large", "large points that overlap", brown, radius=0.25)
points("points_info", "what Point Info says, shining", lambda: shining("ShaderNodePointInfo", {"Position": 0.2, "Radius": 3.0, "Random": 0.5}))
points("points_color", "an attribute of colours of the points", lambda: shining("ShaderNodeAttribute", {"Color": 1.0}, attribute_of("tint")))
points("points_number", "an attribute of numbers of the points", lambda: shining("ShaderNodeAttribute", {"Fac": 5.0}, attribute_of("warmth")))
points("points_generated", "Generated coordinates of points", lambda: shining("ShaderNodeTexCoord", {"Generated": 0.5}))
points("points_normal", "normals of points", lambda: shining("ShaderNodeNewGeometry", {"Normal": 0.4}))
points("points_instances", "a point cloud, shown three times, turned and squeezed", brown, shown_thrice)
points("points_instances_info", "what Point Info says there, shining", lambda: shining("ShaderNodePointInfo", {"Position": 0.2, "Radius": 3.0, "Random": 0.5}), shown_thrice)
points("points_glossy", "glossy points", lambda: shader("ShaderNodeBsdfGlossy", Color=(0.8, 0.7, 0.5, 1.0), Roughness=0.25))
points("points_glass", "points of glass", lambda: shader("ShaderNodeBsdfGlass", Color=(0.8, 0.9, 0.7, 1.0), Roughness=0.2, IOR=1.4))
points("points_translucent", "translucent points", lambda: shader("ShaderNodeBsdfTranslucent", Color=(0.8, 0.6, 0.3, 1.0)))
points("points_emission", "points that shine", lambda: tools.emission("Points", (1.0, 0.6, 0.3), 2.0))
points("points_bump", "points with bump", bumpy, radius=0.3)
points("points_motion", "points of an object that moves", brown, in_motion)


def blurred(stage: Stage, shutter: float = 1.0) -> None:
    stage.scene.render.use_motion_blur, stage.scene.render.motion_blur_shutter = True, shutter
    stage.scene.frame_set(1)


def shape_key(stage: Stage, thing: bpy.types.Object, move: Callable) -> None:
    """A shape key that `move` makes, from 0 at frame 0 to 1 at frame 2."""
    thing.shape_key_add(name="Basis")
    key = thing.shape_key_add(name="Moved")
    for point in key.data:
        point.co = move(point.co)
    for frame in (0, 2):
        key.value = frame / 2
        key.keyframe_insert("value", frame=frame)


def clear_film(roughness: float) -> Callable:
    """Glass of this roughness before a transparent film, whose threshold is 0.1."""
    def change(stage: Stage):
        glass = tools._material("Glass", "ShaderNodeBsdfGlass", Color=(0.8, 0.9, 0.7, 1.0), Roughness=roughness, IOR=1.4)
        stage.material([stage.ball], glass)
        stage.scene.render.film_transparent = True
        stage.scene.cycles.film_transparent_glass, stage.scene.cycles.film_transparent_roughness = True, 0.1
        stage.sun()
    return change


add("film", "transparent_glass", "clear glass before a transparent film, with Transparent Glass", clear_film(0.0))
add("film", "transparent_glass_rough", "glass that is rougher than the threshold of Transparent Glass", clear_film(0.3))


@feature("material", "opaque_shadow", "a transparent material without Transparent Shadows")
def _(stage):
    material = tools._material("Veil", "ShaderNodeBsdfTransparent", Color=(0.8, 0.6, 0.9, 1.0))
    owner = material if hasattr(material, "use_transparent_shadow") else material.cycles
    owner.use_transparent_shadow = False
    stage.material([stage.ball], material)
    stage.sky((0, 0, 0))
    tools.point_light("Lamp", (-1.2, -2.2, 3.2), 300, radius=0.0)


@feature("motion", "deform_keys", "a ball that a shape key stretches")
def _(stage):
    shape_key(stage, stage.ball, lambda p: (p.x * 1.6, p.y, p.z * 0.5))
    blurred(stage)


@feature("motion", "deform_moving", "a ball that a shape key stretches and that moves, four steps")
def _(stage):
    shape_key(stage, stage.ball, lambda p: (p.x * 1.6, p.y, p.z * 0.5))
    in_motion(stage, stage.ball)
    stage.ball.cycles.motion_steps = 4


@feature("motion", "deform_smooth_modifier", "a box that a modifier twists, with flat faces")
def _(stage):
    twist = stage.box.modifiers.new("Twist", "SIMPLE_DEFORM")
    stage.box.modifiers.new("Divide", "SUBSURF").subdivision_type = "SIMPLE"
    twist.deform_method, twist.deform_axis = "TWIST", "Z"
    for frame, angle in ((0, -0.6), (2, 0.9)):
        twist.angle = angle
        twist.keyframe_insert("angle", frame=frame)
    stage.box.cycles.motion_steps = 3
    blurred(stage)


def stretched_waves(stage: Stage) -> None:
    material = tools.diffuse("Bumpy ball", RED)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    wave, displacement = nodes.new("ShaderNodeTexWave"), nodes.new("ShaderNodeDisplacement")
    coordinates = nodes.new("ShaderNodeTexCoord")
    displacement.inputs["Scale"].default_value = 0.1
    links.new(coordinates.outputs["Generated"], wave.inputs["Vector"])
    links.new(wave.outputs["Fac"], displacement.inputs["Height"])
    links.new(displacement.outputs[0], next(node for node in nodes if node.type == "OUTPUT_MATERIAL").inputs["Displacement"])
    owner = material.cycles if hasattr(material.cycles, "displacement_method") else material
    owner.displacement_method = "DISPLACEMENT"
    stage.material([stage.ball], material)
    shape_key(stage, stage.ball, lambda p: (p.x * 1.5, p.y, p.z * 0.6))
    blurred(stage)


def stretched_flat_waves(stage: Stage) -> None:
    for polygon in stage.ball.data.polygons:
        polygon.use_smooth = False
    stretched_waves(stage)


add("motion", "deform_displaced", "a displaced ball that a shape key stretches", stretched_waves)
add("motion", "deform_displaced_flat", "the same with flat faces", stretched_flat_waves)


@feature("motion", "motion_emission", "a glowing ball that moves")
def _(stage):
    stage.material([stage.ball], tools.emission("Ball", (1, 0.6, 0.3), 3.0))
    in_motion(stage, stage.ball)


@feature("motion", "deform_emission", "a glowing ball that a shape key stretches and that moves")
def _(stage):
    stage.material([stage.ball], tools.emission("Ball", (1, 0.6, 0.3), 3.0))
    shape_key(stage, stage.ball, lambda p: (p.x * 1.6, p.y, p.z * 0.5))
    in_motion(stage, stage.ball)


@feature("motion", "motion_start", "a ball that moves while the shutter is open after the frame")
def _(stage):
    in_motion(stage, stage.ball)
    owner = stage.scene.render if hasattr(stage.scene.render, "motion_blur_position") else stage.scene.cycles
    owner.motion_blur_position = "START"


@feature("motion", "zoom", "a lens that zooms")
def _(stage):
    for frame, lens in ((0, 40.0), (2, 60.0)):
        stage.camera.data.lens = lens
        stage.camera.data.keyframe_insert("lens", frame=frame)
    blurred(stage)


@feature("motion", "rolling_shutter", "a rolling shutter and a ball that moves")
def _(stage):
    in_motion(stage, stage.ball)
    stage.scene.cycles.rolling_shutter_type, stage.scene.cycles.rolling_shutter_duration = "TOP", 0.2


@feature("motion", "shutter_curve", "a shutter that opens slowly and a ball that moves")
def _(stage):
    in_motion(stage, stage.ball)
    mapping = stage.scene.render.motion_blur_shutter_curve
    points_of_curve = mapping.curves[0].points
    points_of_curve[0].location, points_of_curve[1].location = (0.0, 0.0), (1.0, 1.0)
    for point in points_of_curve:
        point.handle_type = "VECTOR"
    mapping.update()


@feature("motion", "deform_hair", "hair that a shape key of its ball bends and stretches")
def _(stage):
    hair(stage, count=400)
    shape_key(stage, stage.ball, lambda p: (p.x * 1.5, p.y, p.z * 0.6))
    blurred(stage)


points("points_hidden", "points that the camera does not see", brown, lambda stage, thing: setattr(thing, "visible_camera", False))


# --- Volumes ---------------------------------------------------------------------------------------------------------

def volume(*closures: tuple[str, dict], surface: str | None = None) -> bpy.types.Material:
    """A material whose volume is the sum of these nodes, which are given by type and inputs."""
    made = bpy.data.materials.new("Volume")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    if surface:
        node = tree.nodes.new(surface)
        tree.links.new(node.outputs[0], output.inputs["Surface"])
        if surface == "ShaderNodeBsdfGlass":
            node.distribution = "SHARP"
    fill(tree, output, closures)
    return made


def fill(tree: bpy.types.NodeTree, output: bpy.types.Node, closures) -> None:
    total = None
    for node_type, inputs in closures:
        node = tree.nodes.new(node_type)
        for socket, value in inputs.items():
            tools.set_input(node, socket.replace("_", " "), value)
        if total is not None:
            both = tree.nodes.new("ShaderNodeAddShader")
            tree.links.new(total, both.inputs[0])
            tree.links.new(node.outputs[0], both.inputs[1])
            node = both
        total = node.outputs[0]
    tree.links.new(total, output.inputs["Volume"])


def scatter(**inputs) -> tuple[str, dict]:
    return "ShaderNodeVolumeScatter", inputs


def fog(name: str, what: str, *closures, low=(-1.9, -1.9, 0.01), high=(1.9, 1.9, 2.4), lamp: bool = True) -> None:
    """Add a feature with fog around the ball and the box."""
    def change(stage):
        stage.sky((0.05, 0.05, 0.06))
        if lamp:
            tools.point_light("Lamp", (-1.2, -1.2, 3.2), 300, radius=0.0)
        tools.add_box("Fog", low, high, volume(*closures))
    add("volume", name, what, change)


fog("fog", "fog lit by a point lamp", scatter(Color=(0.8, 0.8, 0.8), Density=0.4))
fog("fog_forward", "fog that scatters forwards", scatter(Color=(0.9, 0.8, 0.6), Density=0.4, Anisotropy=0.7))
fog("fog_backward", "fog that scatters backwards", scatter(Color=(0.9, 0.8, 0.6), Density=0.4, Anisotropy=-0.7))
fog("fog_around_camera", "the camera inside fog", scatter(Color=(0.8, 0.8, 0.8), Density=0.12, Anisotropy=0.3), low=(-7, -7, -1), high=(7, 7, 6))
fog("smoke_absorbs", "Volume Absorption and Scatter added, in three colours", scatter(Color=(0.2, 0.5, 0.8), Density=0.5),
    ("ShaderNodeVolumeAbsorption", {"Color": (0.9, 0.6, 0.2), "Density": 0.5}))
fog("volume_emission", "a volume that only glows", ("ShaderNodeEmission", {"Color": (1.0, 0.5, 0.2), "Strength": 0.4}), lamp=False)
fog("volume_principled", "Principled Volume with absorption and emission", ("ShaderNodeVolumePrincipled", {
    "Color": (0.6, 0.4, 0.3), "Density": 0.6, "Anisotropy": 0.2, "Absorption_Color": (0.3, 0.1, 0.05), "Emission_Strength": 0.05, "Emission_Color": (0.2, 0.5, 1.0)}))
fog("volume_fire", "Principled Volume with blackbody emission", ("ShaderNodeVolumePrincipled", {
    "Color": (0.5, 0.5, 0.5), "Density": 0.3, "Blackbody_Intensity": 1.0, "Temperature": 2200.0}), lamp=False)


@feature("volume", "volume_single", "fog that scatters light once")
def _(stage):
    FEATURES["fog"].change(stage)
    stage.scene.cycles.volume_bounces = 0


@feature("volume", "volume_many_lights", "fog with an area lamp, a glowing mesh and a sky")
def _(stage):
    FEATURES["fog"].change(stage)
    stage.sky((0.3, 0.35, 0.4))
    tools.area_light("Panel", (1.6, -1.5, 3.0), (0, 0, 0.4), 0.8, 60)
    stage.on_ball(tools.emission("Ball", (1, 0.6, 0.3), 3.0))


@feature("volume", "volume_lamp_inside", "a lamp of 2 cm inside fog")
def _(stage):
    FEATURES["fog"].change(stage)
    bpy.data.objects.remove(bpy.data.objects["Lamp"])
    tools.point_light("Lamp", (0.1, -0.9, 1.5), 60, radius=0.02)


@feature("volume", "volume_overlap", "two volumes that overlap")
def _(stage):
    FEATURES["fog"].change(stage)
    tools.add_sphere("Second", (0.3, -0.8, 1.0), 0.8, volume(scatter(Color=(0.9, 0.3, 0.2), Density=0.9)))


@feature("volume", "volume_anisotropies", "two volumes of different anisotropies that overlap")
def _(stage):
    FEATURES["volume_overlap"].change(stage)
    next(n for n in bpy.data.materials["Volume.001"].node_tree.nodes if n.bl_idname == "ShaderNodeVolumeScatter").inputs["Anisotropy"].default_value = -0.3


@feature("volume", "volume_glass", "glass that absorbs")
def _(stage):
    stage.sky((0.5, 0.52, 0.55))
    stage.material([stage.ball], volume(("ShaderNodeVolumeAbsorption", {"Color": (0.2, 0.7, 0.5), "Density": 1.5}), surface="ShaderNodeBsdfGlass"))


@feature("volume", "volume_milk", "glass filled with what scatters")
def _(stage):
    stage.sky((0.5, 0.52, 0.55))
    stage.material([stage.ball], volume(scatter(Color=(0.9, 0.8, 0.7), Density=3.0, Anisotropy=0.5), surface="ShaderNodeBsdfGlass"))


@feature("volume", "volume_transparent", "a transparent surface around fog")
def _(stage):
    stage.sun()
    tools.add_box("Fog", (-1.9, -1.9, 0.01), (1.9, 1.9, 2.4), volume(scatter(Color=(0.8, 0.8, 0.8), Density=0.4), surface="ShaderNodeBsdfTransparent"))


@feature("volume", "volume_world", "fog in the whole world, and a lamp")
def _(stage):
    stage.sky((0.5, 0.6, 0.7))
    tools.point_light("Lamp", (-1.2, -1.2, 3.2), 300, radius=0.0)
    tree = stage.scene.world.node_tree
    fill(tree, next(n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputWorld"), [scatter(Color=(0.7, 0.8, 0.9), Density=0.08, Anisotropy=0.2)])


@feature("volume", "volume_world_inside", "a volume in a world of fog")
def _(stage):
    FEATURES["volume_world"].change(stage)
    tools.add_box("Fog", (-1.9, -1.9, 0.01), (1.9, 1.9, 2.4), volume(scatter(Color=(0.8, 0.3, 0.3), Density=0.3, Anisotropy=0.2)))


@feature("volume", "volume_noise", "a cloud of noise")
def _(stage):
    FEATURES["fog"].change(stage)
    stage.scene.cycles.volume_step_rate = 0.1
    tree = bpy.data.materials["Volume"].node_tree
    node = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeVolumeScatter")
    coordinates, noise = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value = 3.0
    ramp = tree.nodes.new("ShaderNodeMapRange")
    for socket, value in (("From Min", 0.45), ("From Max", 0.65), ("To Min", 0.0), ("To Max", 2.0)):
        ramp.inputs[socket].default_value = value
    tree.links.new(coordinates.outputs["Generated"], noise.inputs["Vector"])
    tree.links.new(noise.outputs["Fac"], ramp.inputs["Value"])
    tree.links.new(ramp.outputs["Result"], node.inputs["Density"])


# Volume objects with grids, whose voxels geometry nodes make from a formula.

def smoke(stage: Stage, space: str = "OBJECT") -> bpy.types.Object:
    """A ball of smoke, denser below."""
    stage.sky((0.05, 0.05, 0.06))
    tools.point_light("Lamp", (-1.2, -1.2, 3.2), 300, radius=0.0)
    stage.scene.cycles.volume_step_rate = 0.1
    thing = bpy.data.objects.new("Smoke", bpy.data.volumes.new("Smoke"))
    stage.scene.collection.objects.link(thing)
    material = volume(("ShaderNodeVolumePrincipled", {"Color": (0.8, 0.7, 0.6), "Density": 2.0}))
    thing.data.materials.append(material)
    thing.data.render.space = space
    tree = bpy.data.node_groups.new("Smoke", "GeometryNodeTree")
    cube, assigned, _out = chain(tree, "GeometryNodeVolumeCube", "GeometryNodeSetMaterial")
    cube.inputs["Min"].default_value, cube.inputs["Max"].default_value = (-0.5,) * 3, (0.5,) * 3
    for axis in "XYZ":
        cube.inputs[f"Resolution {axis}"].default_value = 24
    place, length, below, density = (tree.nodes.new(name) for name in ("GeometryNodeInputPosition", "ShaderNodeVectorMath", "ShaderNodeSeparateXYZ", "ShaderNodeMath"))
    length.operation, density.operation = "LENGTH", "SUBTRACT"
    falling = tree.nodes.new("ShaderNodeMath")
    falling.operation, falling.use_clamp = "MULTIPLY_ADD", True
    tree.links.new(place.outputs[0], length.inputs[0])
    tree.links.new(place.outputs[0], below.inputs[0])
    tree.links.new(length.outputs["Value"], falling.inputs[0])
    falling.inputs[1].default_value, falling.inputs[2].default_value = -4.0, 1.8
    density.operation = "MULTIPLY"
    shade = tree.nodes.new("ShaderNodeMath")
    shade.operation = "MULTIPLY_ADD"
    tree.links.new(below.outputs["Z"], shade.inputs[0])
    shade.inputs[1].default_value, shade.inputs[2].default_value = -1.0, 0.8
    tree.links.new(falling.outputs[0], density.inputs[0])
    tree.links.new(shade.outputs[0], density.inputs[1])
    tree.links.new(density.outputs[0], cube.inputs["Density"])
    assigned.inputs["Material"].default_value = material
    thing.modifiers.new("Smoke", "NODES").node_group = tree
    return thing


add("volume", "smoke_object", "a volume object", lambda stage: setattr(smoke(stage), "location", (0.2, -0.9, 0.8)))
shown_by("smoke_by_collection", "a volume object, shown three times, turned and squeezed", "collection", smoke, "volume")
shown_by("smoke_by_nodes", "a volume object, shown by geometry nodes of another object", "nodes", smoke, "volume")
shown_by("smoke_by_particles", "a volume object, shown by particles", "particles", smoke, "volume")
shown_by("smoke_in_world_units", "a volume object whose density is per metre, shown three times", "collection", lambda stage: smoke(stage, "WORLD"), "volume")


# --- The film --------------------------------------------------------------------------------------------------------

def film(name: str, what: str, **settings):
    def change(stage):
        stage.sun()
        for key, value in settings.items():
            *path, last = key.split("__")
            target = stage.scene
            for step in path:
                target = getattr(target, step)
            setattr(target, last, value)
    add("film", name, what, change)


def layer(name: str, what: str, change: Callable) -> None:
    """A setting of the view layer. The box is in a collection of its own."""
    def with_collection(stage: Stage) -> None:
        stage.sun()
        collection = bpy.data.collections.new("Boxes")
        stage.scene.collection.children.link(collection)
        stage.scene.collection.objects.unlink(stage.box)
        collection.objects.link(stage.box)
        view_layer = stage.scene.view_layers[0]
        change(stage, view_layer, view_layer.layer_collection.children["Boxes"])
    add("layer", name, what, with_collection)


layer("layer_indirect_only", "a collection that contributes indirect light only", lambda stage, view_layer, boxes: setattr(boxes, "indirect_only", True))
layer("layer_holdout", "a collection that holds out", lambda stage, view_layer, boxes: setattr(boxes, "holdout", True))
layer("layer_override", "a material for all objects", lambda stage, view_layer, boxes: setattr(view_layer, "material_override", tools.diffuse("Override", RED)))
layer("layer_without_world", "a view layer without its world", lambda stage, view_layer, boxes: setattr(view_layer, "use_sky", False))

film("film_transparent", "transparent film", render__film_transparent=True)
film("film_exposure", "film exposure of 2", cycles__film_exposure=2.0)
film("filter_box", "box filter", cycles__pixel_filter_type="BOX")
film("filter_gaussian", "Gaussian filter of 3 pixels", cycles__pixel_filter_type="GAUSSIAN", cycles__filter_width=3.0)
film("filter_blackman", "Blackman-Harris filter of 4 pixels", cycles__pixel_filter_type="BLACKMAN_HARRIS", cycles__filter_width=4.0)
film("bounce_limits", "one diffuse bounce", cycles__diffuse_bounces=1, cycles__max_bounces=2)
film("pixel_aspect", "pixels twice as wide as high", render__pixel_aspect_x=2.0)



@feature("film", "texture_limit", "images of 300 x 200 texels that Simplify limits to 128")
def _(stage):
    limited_textures(stage, texture_limit_render="128")


@feature("film", "texture_resolution_alone", "images of 300 x 200 texels with a texture resolution of 30 %, in Blenders that have it")
def _(stage):
    limited_textures(stage, texture_resolution_render=0.3)


@feature("film", "texture_resolution", "images of 300 x 200 texels with a texture resolution of 50 %, and a limit of 128, in Blenders that have it")
def _(stage):
    limited_textures(stage, texture_resolution_render=0.5, texture_limit_render="128")


def limited_textures(stage, **settings):
    """Coarse coloured noise on the ball and on the floor."""
    stage.sun()
    stage.scene.render.use_simplify = True
    for name, value in settings.items():
        if hasattr(stage.scene.cycles, name):
            setattr(stage.scene.cycles, name, value)
        else:
            stage.scene["cycles"][name] = value   # a newer Blender reads it
    rng = random.Random(7)
    coarse = [[(rng.random(), rng.random(), rng.random(), 1.0) for _ in range(60)] for _ in range(40)]
    pixels = [channel for y in range(200) for x in range(300) for channel in coarse[y // 5][x // 5]]
    for thing, name in ((stage.ball, "Ball"), (stage.floor, "Floor")):
        made = tools.diffuse(name, GREY)
        stage.material([thing], made)
        node, tree = tools.shader_of(made), made.node_tree
        picture, place = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeTexCoord")
        picture.image = tools.packed_image(name, 300, 200, pixels)
        picture.interpolation = "Closest" if name == "Floor" else "Linear"
        tree.links.new(place.outputs["Generated"], picture.inputs["Vector"])
        tree.links.new(picture.outputs["Color"], node.inputs["Color"])


def spherical(name: str, what: str, stereo: dict, **camera) -> None:
    """Both eyes beside each other. The camera looks up a little, so that its axes are not those of the world."""
    def change(stage):
        stage.sun()
        render, thing = stage.scene.render, stage.camera
        render.use_multiview, render.views_format = True, "STEREO_3D"
        render.image_settings.views_format = "STEREO_3D"
        render.image_settings.stereo_3d_format.display_mode = "SIDEBYSIDE"
        thing.location, thing.rotation_euler = (0.1, -1.4, 0.9), (math.radians(80), math.radians(15), 0)
        thing.data.stereo.use_spherical_stereo, thing.data.stereo.interocular_distance = True, 0.3
        for key, value in stereo.items():
            setattr(thing.data.stereo, key, value)
        for key, value in camera.items():
            setattr(thing.data.cycles if key == "panorama_type" else thing.data, key, value)
    add("camera", name, what, change)


spherical("stereo_panorama", "spherical stereo of a panorama whose eyes converge at 2 m and merge towards the poles",
          {"convergence_mode": "OFFAXIS", "convergence_distance": 2.0, "use_pole_merge": True, "pole_merge_angle_from": math.radians(20), "pole_merge_angle_to": math.radians(50)},
          type="PANO", panorama_type="EQUIRECTANGULAR")
spherical("stereo_parallel", "spherical stereo of a panorama with parallel rays", {"convergence_mode": "PARALLEL"}, type="PANO", panorama_type="EQUIRECTANGULAR")
spherical("stereo_perspective", "spherical stereo of a perspective camera", {"convergence_mode": "TOE", "convergence_distance": 1.5}, lens=20)


def main() -> None:
    parser = argparse.ArgumentParser(prog="features.py", description=__doc__.splitlines()[0])
    parser.add_argument("--list", type=Path, help="write the names of all scenes to this JSON file, and nothing else")
    parser.add_argument("folder", type=Path, nargs="?", help="of the .blend files")
    parser.add_argument("names", nargs="*", help="scenes; none: all")
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    if options.list is not None:
        options.list.write_text(json.dumps({f.name: {"kind": f.kind, "what": f.what} for f in FEATURES.values()}))
        return
    if options.folder is None:
        parser.error("a folder is needed")
    folder = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    for name in options.names or FEATURES:
        FEATURES[name].change(Stage())
        bpy.context.preferences.filepaths.save_version = 0
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"{name}.blend"), compress=True)


if __name__ == "__main__":
    main()
