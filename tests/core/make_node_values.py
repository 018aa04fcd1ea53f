"""Records the values that Cycles computes for single nodes with constant inputs, as a table for test_shader_nodes.cpp.

    blender -b --factory-startup --python tests/core/make_node_values.py -- tests/core/node_values.txt
    python tests/core/make_node_values.py -- tests/core/node_values_5.txt        (in the environment of a bpy wheel of Blender 5)
    python tests/core/make_node_values.py -- tests/core/sky_values_5.txt

The second table has the nodes that Blender 5 defines differently from Blender 3, the third its skies.

Every case is a small plane that emits the output of the node and covers at least one pixel. Cycles renders all cases in one image without light
transport.
"""

import argparse
import math
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

PIXELS = 4      # per side of a case
IES_FILES = Path(__file__).resolve().parent / "ies"

CASES: list[tuple[str, str, dict, dict]] = []      # type, output, properties, inputs


def case(node: str, output: str, properties: dict | None = None, **inputs: object) -> None:
    CASES.append((f"ShaderNode{node}", output, properties or {}, {name.replace("__", " "): value for name, value in inputs.items()}))


def enum(node: str, name: str) -> list[str]:
    return [item.identifier for item in getattr(bpy.types, f"ShaderNode{node}").bl_rna.properties[name].enum_items]


def define() -> None:
    for operation in enum("Math", "operation"):
        for a, b, c in ((0.7, 1.9, 0.4), (-2.3, 0.6, 1.5), (3.0, 0.0, 0.0), (0.5, 0.5, 2.0)):
            case("Math", "Value", {"operation": operation}, Value=a, Value_001=b, Value_002=c)
    case("Math", "Value", {"operation": "ADD", "use_clamp": True}, Value=0.9, Value_001=0.8)
    for operation in enum("VectorMath", "operation"):
        output = "Value" if operation in ("DOT_PRODUCT", "DISTANCE", "LENGTH") else "Vector"
        for a, b in (((0.7, -1.9, 0.4), (0.3, 0.6, -1.5)), ((3.0, 2.0, -0.7), (0.0, 2.0, 0.5))):
            case("VectorMath", output, {"operation": operation}, Vector=a, Vector_001=b, Vector_002=(0.2, -0.4, 0.9), Scale=0.8)
    for mode in enum("MixRGB", "blend_type"):
        for a, b in (((0.2, 0.6, 0.9), (0.8, 0.3, 0.5)), ((1.4, 0.0, 0.3), (0.4, 0.4, 0.0))):
            case("MixRGB", "Color", {"blend_type": mode}, Fac=0.35, Color1=a, Color2=b)
            case("Mix", "Result_Color", {"data_type": "RGBA", "blend_type": mode, "clamp_result": True},
                 Factor_Float=0.8, A_Color=a, B_Color=b)
    case("MixRGB", "Color", {"blend_type": "ADD", "use_clamp": True}, Fac=1.7, Color1=(0.2, 0.6, 0.9), Color2=(0.8, 0.3, 0.5))
    case("Mix", "Result_Float", {"data_type": "FLOAT", "clamp_factor": False}, Factor_Float=1.3, A_Float=2.0, B_Float=-1.0)
    case("Mix", "Result_Vector", {"data_type": "VECTOR", "factor_mode": "NON_UNIFORM"}, Factor_Vector=(0.1, 0.5, 1.2),
         A_Vector=(1.0, 2.0, 3.0), B_Vector=(-1.0, 0.5, 8.0))
    for kind in enum("Mapping", "vector_type"):
        case("Mapping", "Vector", {"vector_type": kind}, Vector=(0.3, -0.8, 1.2), Location=(0.5, 0.1, -2.0),
             Rotation=(0.4, -0.9, 1.7), Scale=(2.0, 0.5, -1.5))
    for kind in enum("VectorRotate", "rotation_type"):
        for invert in (False, True):
            case("VectorRotate", "Vector", {"rotation_type": kind, "invert": invert}, Vector=(0.3, -0.8, 1.2),
                 Center=(0.5, 0.1, -2.0), Axis=(0.2, 1.0, -0.4), Angle=1.1, Rotation=(0.4, -0.9, 1.7))
    for kind in enum("Clamp", "clamp_type"):
        case("Clamp", "Result", {"clamp_type": kind}, Value=0.7, Min=0.9, Max=0.2)
    for kind in enum("MapRange", "interpolation_type"):
        for value in (0.37, 2.0, -1.0):
            case("MapRange", "Result", {"interpolation_type": kind, "clamp": value > 1.0}, Value=value, From__Min=0.2,
                 From__Max=0.9, To__Min=3.0, To__Max=-1.0, Steps=3.0)
            case("MapRange", "Vector", {"interpolation_type": kind, "data_type": "FLOAT_VECTOR", "clamp": value > 1.0},
                 Vector=(value, 0.4, 0.8), From_Min_FLOAT3=(0.2, 0.5, 0.1), From_Max_FLOAT3=(0.9, 0.5, 0.7),
                 To_Min_FLOAT3=(3.0, 1.0, 0.0), To_Max_FLOAT3=(-1.0, 2.0, 4.0), Steps_FLOAT3=(3.0, 4.0, 5.0))
    color = (0.9, 0.35, 0.1)
    case("Invert", "Color", Fac=0.7, Color=color)
    case("Gamma", "Color", Color=color, Gamma=2.2)
    case("BrightContrast", "Color", Color=color, Bright=0.1, Contrast=0.5)
    case("HueSaturation", "Color", Hue=0.8, Saturation=1.3, Value=0.7, Fac=0.9, Color=color)
    case("RGBToBW", "Val", Color=color)
    for kelvin in (500.0, 1000.0, 2500.0, 4000.0, 6500.0, 9000.0, 20000.0):
        case("Blackbody", "Color", Temperature=kelvin)
    for mode in enum("SeparateColor", "mode"):
        for output in ("Red", "Green", "Blue"):
            case("SeparateColor", output, {"mode": mode}, Color=color)
        case("CombineColor", "Color", {"mode": mode}, Red=0.4, Green=0.7, Blue=0.35)
    on_borders = [(0.3, 0.3, cell / 5) for cell in range(-4, 9)]
    for point in [(0.05, 0.05, 0.0), (0.25, 0.05, 0.0), (-0.1, 0.3, 0.71), (0.2, 0.4, 0.6), *on_borders]:
        case("TexChecker", "Color", Vector=point, Color1=(0.1, 0.2, 0.3), Color2=(0.7, 0.8, 0.9), Scale=5.0)
    for kind in enum("TexGradient", "gradient_type"):
        case("TexGradient", "Fac", {"gradient_type": kind}, Vector=(0.4, -0.3, 0.2))
    define_patterns()


def define_patterns() -> None:
    p, w = (0.37, -1.24, 2.71), -0.83
    for dimensions in ("1D", "2D", "3D", "4D"):
        for detail, roughness, distortion in ((0.0, 0.5, 0.0), (3.6, 0.7, 1.3)):
            case("TexNoise", "Color", {"noise_dimensions": dimensions}, Vector=p, W=w, Scale=1.7, Detail=detail, Roughness=roughness,
                 Distortion=distortion)
        for kind in enum("TexMusgrave", "musgrave_type"):
            for detail in (0.4, 4.3):
                case("TexMusgrave", "Fac", {"musgrave_dimensions": dimensions, "musgrave_type": kind}, Vector=p, W=w, Scale=1.7, Detail=detail,
                     Dimension=0.6, Lacunarity=2.2, Offset=0.3, Gain=1.4)
        for feature in enum("TexVoronoi", "feature"):
            properties = {"voronoi_dimensions": dimensions, "feature": feature}
            inputs = dict(Vector=p, W=w, Scale=2.3, Smoothness=0.7, Exponent=1.3, Randomness=0.8)
            outputs = {"DISTANCE_TO_EDGE": ["Distance"], "N_SPHERE_RADIUS": ["Radius"]}.get(feature, ["Distance", "Color"])
            if len(outputs) == 2:
                outputs += [*(["Position"] if dimensions != "1D" else []), *(["W"] if dimensions in ("1D", "4D") else [])]
            for output in outputs:
                case("TexVoronoi", output, properties, **inputs)
        case("TexVoronoi", "Color", {"voronoi_dimensions": dimensions, "feature": "SMOOTH_F1"}, Vector=p, W=w, Scale=2.3, Smoothness=0.0)
        case("TexWhiteNoise", "Color", {"noise_dimensions": dimensions}, Vector=p, W=w)
        case("TexWhiteNoise", "Value", {"noise_dimensions": dimensions}, Vector=p, W=w)
    case("TexNoise", "Fac", {"noise_dimensions": "3D"}, Vector=p, Scale=5.0, Detail=15.0, Roughness=1.6)
    for metric in enum("TexVoronoi", "distance"):
        case("TexVoronoi", "Distance", {"distance": metric, "feature": "F2"}, Vector=p, Scale=2.3, Exponent=0.6, Randomness=1.0)
    case("TexVoronoi", "Distance", {"distance": "MINKOWSKI"}, Vector=(0.4, 0.5, 0.6), Scale=3.0, Exponent=0.25, Randomness=1.0)   # distances above 8
    for profile in enum("TexWave", "wave_profile"):
        for direction in enum("TexWave", "bands_direction"):
            case("TexWave", "Fac", {"wave_type": "BANDS", "bands_direction": direction, "wave_profile": profile}, Vector=p, Scale=0.9,
                 Phase__Offset=0.4)
    for direction in enum("TexWave", "rings_direction"):
        case("TexWave", "Color", {"wave_type": "RINGS", "rings_direction": direction}, Vector=p, Scale=0.9, Distortion=2.5, Detail=2.7,
             Detail__Scale=1.4, Detail__Roughness=0.6, Phase__Offset=0.4)
    for depth in range(11):
        case("TexMagic", "Color", {"turbulence_depth": depth}, Vector=p, Scale=0.7, Distortion=1.4)
    case("TexMagic", "Fac", {"turbulence_depth": 3}, Vector=p, Scale=0.7, Distortion=0.0)
    colors = dict(Color1=(0.1, 0.2, 0.3), Color2=(0.7, 0.8, 0.9), Mortar=(0.9, 0.1, 0.5))
    for output in ("Color", "Fac"):
        for place in ((0.37, 0.21, 0.0), (-0.61, -0.14, 0.0), (0.28, 0.77, 0.0), (0.404, 0.9, 0.0)):
            case("TexBrick", output, {"offset_frequency": 3, "squash_frequency": 2}, Vector=place, **colors, Scale=2.0, Mortar__Size=0.06,
                 Mortar__Smooth=0.4, Bias=-0.1, Brick__Width=0.8, Row__Height=0.3)
    case("TexBrick", "Color", {}, Vector=(0.301, 0.1, 0.0), **colors, Scale=5.0, Mortar__Size=0.02, Mortar__Smooth=0.0)
    skies = (("PREETHAM", {"sun_direction": (0.6, -0.3, 0.4), "turbidity": 3.4}),
             ("HOSEK_WILKIE", {"sun_direction": (0.6, -0.3, 0.4), "turbidity": 3.4, "ground_albedo": 0.4}))
    for kind, properties in skies:
        for direction in ((0.0, 0.0, 1.0), (0.6, -0.3, 0.5), (-0.8, 0.5, 0.05), (0.3, 0.2, -0.4)):
            length = math.sqrt(sum(x * x for x in direction))
            case("TexSky", "Color", {"sky_type": kind, **properties}, Vector=tuple(x / length for x in direction))
    high = {"sky_type": "NISHITA", "sun_elevation": 0.7, "sun_rotation": 2.0, "altitude": 300.0, "air_density": 1.5, "dust_density": 2.0,
            "ozone_density": 3.0, "sun_disc": False}
    low = {**high, "sun_elevation": -0.01, "sun_rotation": -1.0, "dust_density": 0.3}
    # With a sun disc, the vector of the node is not linked; the centre of the pixel, in generated coordinates, must lie in the disc.
    sun = {"sky_type": "NISHITA", "sun_elevation": 0.5, "sun_rotation": 0.8, "sun_size": 0.3, "sun_intensity": 0.003, "sun_disc": True}
    case("TexSky", "Color", sun, Vector=(0.625, 0.625, 0.5))
    for properties, elevation, azimuth in ((high, 1.1, 0.3), (low, 0.04, 2.7), (low, -0.2, 2.0)):
        case("TexSky", "Color", properties, Vector=(math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth),
                                                    math.sin(elevation)))
    for output in ("Color", "Density", "Flame", "Temperature"):
        case("VolumeInfo", output)   # evaluated on a mesh
    for i, file in enumerate(sorted(IES_FILES.glob("*.ies"))):   # half of the files as internal texts
        for z, turn in ((-1.0, 0.0), (-0.999, 1.0), (-0.93, 6.1), (-0.8, 2.0), (-0.6, 3.3), (-0.5, 4.9), (-0.2, 5.2), (-0.05, 0.7), (0.0, 1.6), (0.3, 2.9),
                        (0.9, 4.0), (-0.7, 0.0), (-0.7, -math.pi / 2)):
            across = 2.3 * math.sqrt(1.0 - z * z)
            case("TexIES", "Fac", {"mode": "INTERNAL" if i % 2 else "EXTERNAL", "ies": file.name},
                 Vector=(across * math.cos(turn), across * math.sin(turn), 2.3 * z), Strength=0.3)
    for nanometres in (300.0, 380.0, 452.0, 507.5, 600.0, 779.0):
        case("Wavelength", "Color", Wavelength=nanometres)


def define_voronoi_of_blender_5() -> None:
    p, w = (0.37, -1.24, 2.71), -0.83
    common = {"Vector": p, "W": w, "Scale": 2.3, "Smoothness": 0.7, "Exponent": 1.3, "Randomness": 0.8, "Roughness": 0.6, "Lacunarity": 2.2}
    for dimensions in ("1D", "2D", "3D", "4D"):
        for feature in enum("TexVoronoi", "feature"):
            outputs = {"DISTANCE_TO_EDGE": ["Distance"], "N_SPHERE_RADIUS": ["Radius"]}.get(feature, ["Distance", "Color"])
            if len(outputs) == 2:
                outputs += [*(["Position"] if dimensions != "1D" else []), *(["W"] if dimensions in ("1D", "4D") else [])]
            for output in outputs:
                for detail in (0.0, 1.6):
                    case("TexVoronoi", output, {"voronoi_dimensions": dimensions, "feature": feature, "cells": "PCG"}, Detail=detail, **common)


def define_new_nodes_of_blender_5() -> None:
    place = (0.37, -1.24, 2.71)
    for kind in enum("TexGabor", "gabor_type"):
        for output in ("Value", "Phase", "Intensity"):
            for anisotropy in (1.0, 0.6, 0.0):
                case("TexGabor", output, {"gabor_type": kind}, Vector=place, Scale=1.7, Frequency=2.3, Anisotropy=anisotropy, Orientation__2D=0.9,
                     Orientation__3D=(0.3, -0.8, 0.5))
        case("TexGabor", "Value", {"gabor_type": kind}, Vector=(-3.1, 0.0, 12.8), Scale=5.0, Frequency=-1.0, Anisotropy=1.7, Orientation__2D=-4.0,
             Orientation__3D=(-2.0, 0.0, 1.0))
    # Every kind of side and corner, and the sector that is left if the number of sides is not whole.
    for sides in (2.0, 3.0, 5.0, 2.3, 4.6):
        for roundness in (0.0, 0.4, 1.0):
            if sides == 2.0 and roundness > 0.0:
                continue      # not defined
            for turn in (0.03, 0.35, 0.9, 2.2, 4.1, 5.3, 5.8, 6.1, 6.25):
                for normalize in (False, True):
                    case("RadialTiling", "Segment Coordinates", {"normalize": normalize}, Vector=(1.4 * math.cos(turn), 1.4 * math.sin(turn)), Sides=sides,
                         Roundness=roundness)
            for output in ("Segment ID", "Segment Width", "Segment Rotation"):
                for turn in (0.35, 4.1, 6.1):
                    case("RadialTiling", output, {}, Vector=(0.6 * math.cos(turn), 0.6 * math.sin(turn)), Sides=sides, Roundness=roundness)
    case("RadialTiling", "Segment Coordinates", {"normalize": True}, Vector=(0.0, 0.0), Sides=3.5, Roundness=1.5)
    case("RadialTiling", "Segment Coordinates", {"normalize": False}, Vector=(-1.0, 0.0), Sides=1.0, Roundness=-1.0)


def define_skies_of_blender_5() -> None:
    def sky(kind: str, directions: tuple, **properties: object) -> None:
        for elevation, azimuth in directions:
            case("TexSky", "Color", {"sky_type": kind, **properties}, Vector=(math.cos(elevation) * math.cos(azimuth),
                                                                              math.cos(elevation) * math.sin(azimuth), math.sin(elevation)))

    around = ((1.2, 0.4), (0.3, 1.6), (0.02, -1.5), (-0.03, 2.0), (-0.6, 0.7))
    for kind in ("SINGLE_SCATTERING", "MULTIPLE_SCATTERING"):
        without = {"sun_disc": False}
        sky(kind, around, sun_elevation=0.05, **without)
        sky(kind, around, sun_elevation=0.7, sun_rotation=2.0, altitude=30.0, air_density=3.0, aerosol_density=0.1, ozone_density=5.0, **without)
        sky(kind, around, sun_elevation=-0.06, sun_rotation=-1.0, altitude=3000.0, aerosol_density=8.0, ozone_density=0.0, **without)
        sky(kind, around, sun_elevation=4.0, altitude=70000.0, air_density=0.2, **without)
        # As above, the vector of a node with a sun disc is not linked.
        for sun in ({"sun_elevation": 0.5, "sun_size": 0.3, "altitude": 0.0, "aerosol_density": 2.0},
                    {"sun_elevation": 0.4, "sun_size": 1.2, "altitude": 15000.0, "ozone_density": 4.0},
                    {"sun_elevation": math.pi - 0.55, "sun_rotation": math.pi + 0.8, "sun_size": 0.2, "altitude": 200.0, "air_density": 3.0}):
            case("TexSky", "Color", {"sky_type": kind, "sun_rotation": 0.8, "sun_intensity": 0.003, "sun_disc": True, **sun}, Vector=(0.625, 0.625, 0.5))


# The slope of the plane in tests of bumped normals: z = SLOPE * (x, y).
SLOPE = (0.3, -0.2)
BUMPS: list[tuple[str, dict]] = []     # node, inputs and properties


def define_bumps() -> None:
    for strength, distance, invert in ((1.0, 1.0, False), (0.4, 0.3, False), (1.6, 0.2, True)):
        BUMPS.append(("Bump", {"Strength": strength, "Distance": distance, "invert": invert}))
    for space in ("OBJECT", "WORLD"):
        BUMPS.append(("Displacement", {"space": space, "Midlevel": 0.3, "Scale": 0.4}))


def add_bump(index: int, corner: tuple[float, float]) -> None:
    """Adds a tilted square that emits its normal, which a wave texture over the position changes."""
    kind, settings = BUMPS[index]
    mesh = bpy.data.meshes.new(f"bump {index}")
    points = [(corner[0] + x, corner[1] + y) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    mesh.from_pydata([(x, y, SLOPE[0] * x + SLOPE[1] * y) for x, y in points], [], [(0, 1, 2, 3)])
    material = bpy.data.materials.new(f"bump {index}")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    node, wave, geometry = nodes.new(f"ShaderNode{kind}"), nodes.new("ShaderNodeTexWave"), nodes.new("ShaderNodeNewGeometry")
    wave.bands_direction = "DIAGONAL"
    wave.inputs["Scale"].default_value = 0.13
    links.new(geometry.outputs["Position"], wave.inputs["Vector"])
    links.new(wave.outputs["Fac"], node.inputs["Height"])
    for name, value in settings.items():
        if name in node.inputs:
            node.inputs[name].default_value = value
        else:
            setattr(node, name, value)
    emission, end = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    shown = node.outputs["Normal"] if kind == "Bump" else nodes.new("ShaderNodeNewGeometry").outputs["Normal"]
    if kind == "Displacement":
        links.new(node.outputs["Displacement"], end.inputs["Displacement"])
    links.new(shown, emission.inputs["Color"])
    links.new(emission.outputs[0], end.inputs["Surface"])
    mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(f"bump {index}", mesh))


def set_inputs(node: bpy.types.Node, inputs: dict, links: bpy.types.NodeLinks, nodes: bpy.types.Nodes) -> None:
    for socket in node.inputs:
        if socket.identifier not in inputs:
            continue
        value = inputs[socket.identifier]
        if isinstance(value, tuple) and socket.hide_value:
            source = nodes.new("ShaderNodeCombineXYZ")
            for part, number in zip(source.inputs, value):
                part.default_value = number
            links.new(source.outputs[0], socket)
        elif isinstance(value, tuple):
            socket.default_value = (*value, 1.0) if socket.type == "RGBA" else value
        else:
            socket.default_value = value


def set_ies(node: bpy.types.Node, file: Path) -> None:
    if node.mode == "EXTERNAL":
        node.filepath = str(file)
    else:
        node.ies = bpy.data.texts.load(str(file))


def build_scene(side: int) -> None:
    scene = bpy.context.scene
    for i, (kind, output, properties, inputs) in enumerate(CASES):
        mesh = bpy.data.meshes.new(f"case {i}")
        x, y = i % side, i // side
        mesh.from_pydata([(x, y, 0), (x + 1, y, 0), (x + 1, y + 1, 0), (x, y + 1, 0)], [], [(0, 1, 2, 3)])
        material = bpy.data.materials.new(f"case {i}")
        material.use_nodes = True
        nodes, links = material.node_tree.nodes, material.node_tree.links
        nodes.clear()
        node = nodes.new(kind)
        for name, value in properties.items():
            if name == "ies":
                set_ies(node, IES_FILES / value)
            elif name != "cells":      # a property that the exporter adds
                setattr(node, name, value)
        set_inputs(node, inputs, links, nodes)
        emission, end = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
        source = next(socket for socket in node.outputs if socket.identifier == output)
        links.new(source, emission.inputs["Color"])
        links.new(emission.outputs[0], end.inputs["Surface"])
        mesh.materials.append(material)
        scene.collection.objects.link(bpy.data.objects.new(f"case {i}", mesh))
    for i in range(len(BUMPS)):
        add_bump(i, ((len(CASES) + i) % side, (len(CASES) + i) // side))
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", side
    holder = bpy.data.objects.new("camera", camera)
    holder.location = (side / 2, side / 2, side)
    scene.collection.objects.link(holder)
    scene.camera = holder
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.filter_width = 1, False, 0.01
    scene.render.resolution_x = scene.render.resolution_y = side * PIXELS
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"


def render(side: int) -> np.ndarray:
    with tempfile.NamedTemporaryFile(suffix=".exr") as file:
        bpy.context.scene.render.filepath = file.name
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(file.name)
        image.colorspace_settings.name = "Non-Color"
        pixels = np.empty(image.size[0] * image.size[1] * 4, "f4")
        image.pixels.foreach_get(pixels)
    return pixels.reshape(side * PIXELS, side * PIXELS, 4)


def text_of(value: object) -> str:
    numbers = value if isinstance(value, tuple) else (value,)
    return ",".join(f"{number:.7g}" for number in numbers)


def main(path: str) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if "cycles" not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="cycles")
    if Path(path).stem.startswith("sky_values"):
        define_skies_of_blender_5()
    elif bpy.app.version >= (5, 0):
        define_voronoi_of_blender_5()
        define_new_nodes_of_blender_5()
    else:
        define()
        define_bumps()
    side = math.ceil(math.sqrt(len(CASES) + len(BUMPS)))
    build_scene(side)
    pixels = render(side)
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"# Made by make_node_values.py: single nodes as Cycles of Blender {bpy.app.version_string} evaluates them.\n"
                   "# type, output, properties, inputs, result; separated by tabs\n")
        for i, (kind, output, properties, inputs) in enumerate(CASES):
            x, y = i % side, i // side
            value = tuple(float(number) for number in pixels[y * PIXELS + PIXELS // 2, x * PIXELS + PIXELS // 2, :3])
            listed = ";".join(f"{name}={content if isinstance(content, str) else text_of(content)}" for name, content in properties.items())
            sockets = ";".join(f"{name}={text_of(content)}" for name, content in inputs.items())
            file.write("\t".join((kind, output, listed, sockets, text_of(value))) + "\n")
        # Bumped normals, with the centre of the pixel at which they are evaluated.
        for i, (kind, settings) in enumerate(BUMPS):
            x, y = (len(CASES) + i) % side, (len(CASES) + i) // side
            middle = (PIXELS // 2 + 0.5) / PIXELS
            value = tuple(float(number) for number in pixels[y * PIXELS + PIXELS // 2, x * PIXELS + PIXELS // 2, :3])
            listed = ";".join(f"{name}={content if isinstance(content, str) else text_of(content)}" for name, content in settings.items())
            file.write("\t".join((f"@{kind}", text_of((x + middle, y + middle)), listed, text_of(value))) + "\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="make_node_values.py", description=__doc__.splitlines()[0])
    parser.add_argument("path", help="file of the values")
    main(parser.parse_args(sys.argv[sys.argv.index("--") + 1:]).path)
