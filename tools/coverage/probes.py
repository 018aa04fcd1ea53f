"""The probes: every shader node, output, input, choice and switch of the running Blender, each in its own material.

A probe is a copy of the plain probe of its node with one change. Probes of one node type are next to each other, so that a change can be compared
with the plain probe.
"""

from __future__ import annotations

import argparse
import os
import sys
import traceback
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import bpy

ROOT = Path(__file__).resolve().parents[2]
IES_FILE = ROOT / "tests" / "core" / "ies" / "half_1991.ies"

# The exporter resolves these nodes, so that the compiler never receives them.
STRUCTURE = {"NodeGroupInput", "NodeGroupOutput", "NodeReroute", "NodeFrame", "ShaderNodeGroup", "ShaderNodeCustomGroup", "ShaderNodeTree"}
OUTPUTS = {"ShaderNodeOutputMaterial", "ShaderNodeOutputWorld", "ShaderNodeOutputLight", "ShaderNodeOutputLineStyle", "ShaderNodeOutputAOV"}
BRANCHES = {"ShaderNodeMixShader", "ShaderNodeAddShader"}
DISPLACEMENTS = {"ShaderNodeDisplacement", "ShaderNodeVectorDisplacement"}
# Sockets that Blender never shows or that add others, a switch of the compositor, and properties of the editor.
INTERNAL = {"Weight", "use_alpha", "SurfaceID", "active_item", "active_index", "is_active_output", "__extend__"}
COMMON = set(bpy.types.Node.bl_rna.properties.keys())

# Other settings that are required for a setting to have an effect: node type, then name of the setting.
CONTEXT: dict[str, dict[str, dict[str, object]]] = {
    "ShaderNodeBsdfPrincipled": {
        "Coat*": {"Coat Weight": 0.8}, "Clearcoat*": {"Clearcoat": 0.8}, "Sheen*": {"Sheen Weight": 0.8, "Sheen": 0.8}, "Emission*": {"Emission Strength": 0.5},
        "Subsurface*": {"Subsurface Weight": 0.5, "Subsurface": 0.5}, "subsurface_method": {"Subsurface Weight": 0.5, "Subsurface": 0.5},
        "Thin Film*": {"Thin Film Thickness": 400.0, "Metallic": 1.0}, "Thin Wall": {"Transmission Weight": 0.8}, "IOR": {"Transmission Weight": 0.8, "Transmission": 0.8},
        "Transmission*": {"Transmission Weight": 0.8, "Transmission": 0.8}, "Anisotropic*": {"Anisotropic": 0.7, "Metallic": 1.0}, "distribution": {"Metallic": 1.0, "Roughness": 0.8},
        "Specular Tint": {"Metallic": 0.5}, "Tangent": {"Anisotropic": 0.7, "Metallic": 1.0}},
    "ShaderNodeBsdfMetallic": {"Thin Film*": {"Thin Film Thickness": 400.0}, "Rotation": {"Anisotropy": 0.7}, "Tangent": {"Anisotropy": 0.7}, "IOR": {"fresnel_type": "PHYSICAL_CONDUCTOR"},
                               "Extinction": {"fresnel_type": "PHYSICAL_CONDUCTOR"}},
    "ShaderNodeBsdfGlass": {"Thin Film*": {"Thin Film Thickness": 400.0}},
    "ShaderNodeBsdfAnisotropic": {"Rotation": {"Anisotropy": 0.7}, "Tangent": {"Anisotropy": 0.7}},
    "ShaderNodeBsdfGlossy": {"Rotation": {"Anisotropy": 0.7}, "Tangent": {"Anisotropy": 0.7}},
    "ShaderNodeSubsurfaceScattering": {"IOR": {"falloff": "RANDOM_WALK_SKIN"}, "Anisotropy": {"falloff": "RANDOM_WALK"}, "Roughness": {"falloff": "RANDOM_WALK_SKIN"}},
    "ShaderNodeVolumeScatter": {"IOR": {"phase": "FOURNIER_FORAND"}, "Backscatter": {"phase": "FOURNIER_FORAND"}, "Alpha": {"phase": "DRAINE"}, "Diameter": {"phase": "MIE"}},
    "ShaderNodeVolumeCoefficients": {"IOR": {"phase": "FOURNIER_FORAND"}, "Backscatter": {"phase": "FOURNIER_FORAND"}, "Alpha": {"phase": "DRAINE"}, "Diameter": {"phase": "MIE"}},
    "ShaderNodeVolumePrincipled": {"Blackbody Tint": {"Blackbody Intensity": 1.0, "Temperature": 3000.0}, "Temperature": {"Blackbody Intensity": 1.0}, "Emission Color": {"Emission Strength": 0.5}},
    "ShaderNodeVectorRotate": {"Rotation": {"rotation_type": "EULER_XYZ"}},
    "ShaderNodeTexVoronoi": {"W": {"voronoi_dimensions": "4D"}, "Radius": {"feature": "N_SPHERE_RADIUS"}, "Smoothness": {"feature": "SMOOTH_F1"}, "Exponent": {"distance": "MINKOWSKI"}, "Lacunarity": {"Detail": 2.0}, "Roughness": {"Detail": 2.0}},
    "ShaderNodeTexNoise": {"W": {"noise_dimensions": "4D"}, "Offset": {"noise_type": "HETERO_TERRAIN"}, "Gain": {"noise_type": "HYBRID_MULTIFRACTAL"}},
    "ShaderNodeTexMusgrave": {"W": {"musgrave_dimensions": "4D"}, "Offset": {"musgrave_type": "HETERO_TERRAIN"}, "Gain": {"musgrave_type": "HYBRID_MULTIFRACTAL"}},
    "ShaderNodeTexWhiteNoise": {"W": {"noise_dimensions": "4D"}},
    "ShaderNodeTexGabor": {"Orientation 3D": {"gabor_type": "3D"}},
    "ShaderNodeTexWave": {"Detail Scale": {"Distortion": 2.0, "Detail": 2.0}, "Detail Roughness": {"Distortion": 2.0, "Detail": 2.0}, "Detail": {"Distortion": 2.0},
                          "rings_direction": {"wave_type": "RINGS"}},
    "ShaderNodeTexBrick": {"squash": {"squash_frequency": 2}, "offset": {"offset_frequency": 2}},
    "ShaderNodeTexImage": {"projection_blend": {"projection": "BOX"}},
    "ShaderNodeMapRange": {"Steps": {"interpolation_type": "STEPPED"}, "Steps_FLOAT3": {"data_type": "FLOAT_VECTOR", "interpolation_type": "STEPPED"},
                           "Vector": {"data_type": "FLOAT_VECTOR"}, "*_FLOAT3": {"data_type": "FLOAT_VECTOR"}},
    "ShaderNodeMix": {"A_Color": {"data_type": "RGBA"}, "B_Color": {"data_type": "RGBA"}, "blend_type": {"data_type": "RGBA"}, "clamp_result": {"data_type": "RGBA", "blend_type": "ADD"},
                      "A_Vector": {"data_type": "VECTOR"}, "B_Vector": {"data_type": "VECTOR"},
                      "Result_Color": {"data_type": "RGBA"}, "Result_Vector": {"data_type": "VECTOR"}, "factor_mode": {"data_type": "VECTOR"}, "Factor_Vector": {"data_type": "VECTOR", "factor_mode": "NON_UNIFORM"}},
    "ShaderNodeMixRGB": {"use_clamp": {"blend_type": "ADD"}},
    "ShaderNodeNormalMap": {"base": {"Strength": 0.5}},
    "ShaderNodeWireframe": {"use_pixel_size": {"Size": 2.0}},
    "ShaderNodeTangent": {"uv_map": {"direction_type": "UV_MAP"}, "axis": {"direction_type": "RADIAL"}},
    "ShaderNodeTexSky": {"turbidity": {"sky_type": "PREETHAM"}, "ground_albedo": {"sky_type": "HOSEK_WILKIE"}, "sun_direction": {"sky_type": "PREETHAM"}},
    "ShaderNodeVectorMath": {"Value": {"operation": "LENGTH"}, "Vector_002": {"operation": "MULTIPLY_ADD"}, "Scale": {"operation": "SCALE"}},
    "ShaderNodeMath": {"Value_002": {"operation": "MULTIPLY_ADD"}},
    "ShaderNodeClamp": {"Min": {"Value": -0.5}, "Max": {"Value": 1.5}, "clamp_type": {"Min": 0.8, "Max": 0.2}},
}


# Nodes whose default numbers would show no difference, so that other numbers are set, except for bounds.
LIVELY = {f"ShaderNode{name}" for name in ("Math", "MixRGB", "Mix", "Clamp", "MapRange", "VectorMath", "CombineColor", "CombineHSV", "CombineRGB", "CombineXYZ", "Gamma", "HueSaturation",
                                           "FloatCurve", "Squeeze", "VectorRotate", "Mapping")}
BOUNDS = ("To", "From", "Max", "Min", "Steps")
# Nodes for which an unlinked vector does not mean zero.
WITH_DEFAULT_VECTOR = ("ShaderNodeTex", "ShaderNodeBump", "ShaderNodeFresnel", "ShaderNodeLayerWeight", "ShaderNodeAmbientOcclusion", "ShaderNodeBevel")
HEIGHTS = {"ShaderNodeBump": ("Distance",), **dict.fromkeys(DISPLACEMENTS, ("Scale",))}


@dataclass(frozen=True)
class Probe:
    material: str
    node: str       # bl_idname
    kind: str       # "plain", "output", "input", "choice" or "switch"
    name: str       # of the output, input or property
    value: str      # of the choice
    shown: str = ""   # name in the user interface


def node_types() -> list[str]:
    tree = bpy.data.materials.new("types")
    tree.use_nodes = True
    found = []
    for name in sorted(dir(bpy.types)):
        if not name.startswith("ShaderNode") or name in STRUCTURE | OUTPUTS:
            continue
        try:
            node = tree.node_tree.nodes.new(name)
        except RuntimeError:       # a base class, or a node of another tree type
            continue
        if node.outputs:
            found.append(name)
    bpy.data.materials.remove(tree)
    return found


def thing(owner: str, kind: str, name: str) -> str:
    """The name of a part of a node, or of a setting, in the inventory."""
    return f"{owner}.{name}" if kind in ("choice", "switch") else f"{owner} {'input' if kind == 'input' else 'output'} {name}"


def parts(node: bpy.types.Node) -> Iterator[tuple[str, str, str, str]]:
    """(kind, name, choice, name in the user interface) of all outputs and inputs of a node and of its own properties."""
    first = next((socket.identifier for socket in node.outputs if socket.enabled), None)
    for output in node.outputs:
        if output.identifier and output.identifier not in INTERNAL:
            yield "plain" if output.identifier == first else "output", output.identifier, "", output.name
    for socket in node.inputs:
        if socket.identifier and socket.identifier not in INTERNAL:
            yield "input", socket.identifier, "", socket.name
    for prop in node.bl_rna.properties:
        if prop.identifier in COMMON | INTERNAL or prop.is_readonly:
            continue
        if prop.type == "ENUM" and not prop.is_enum_flag:
            yield from (("choice", prop.identifier, item.identifier, item.name) for item in prop.enum_items)
        elif prop.type in ("BOOLEAN", "INT", "FLOAT"):
            yield "switch", prop.identifier, "", prop.name
    if hasattr(node, "texture_mapping"):
        yield "switch", "texture_mapping", "", "Texture Mapping"


def _matching(table: dict[str, dict[str, object]], name: str) -> dict[str, object]:
    for pattern, settings in table.items():
        if fnmatchcase(name, pattern):
            return settings
    return {}


def _socket(node: bpy.types.Node, identifier: str) -> bpy.types.NodeSocket | None:
    return next((socket for socket in node.inputs if socket.identifier == identifier), None)


def _set(node: bpy.types.Node, settings: dict[str, object]) -> None:
    for name, value in settings.items():
        socket = _socket(node, name)
        if socket is not None and hasattr(socket, "default_value"):
            socket.default_value = value
        elif hasattr(node, name):
            try:
                setattr(node, name, value)
            except TypeError:      # this Blender does not have the choice
                pass


def other(value: float, low: float, high: float) -> float:
    """A value in the range that differs visibly from `value`."""
    if not value < 1e6:
        return 1.0
    for tried in (value * 0.6, value + 0.4, value + 1.0, value - 1.0, value + 10.0):
        if tried != value and low <= tried <= high and abs(tried - value) > 1e-3 * abs(value):
            return tried
    return value


def _number(identifier: str) -> float:
    """A number between 0 and 1 that is different for each socket."""
    return 0.15 + 0.7 * (zlib.crc32(identifier.encode()) % 1000) / 1000.0


class Builder:
    def __init__(self) -> None:
        self.probes: list[Probe] = []
        self.image = bpy.data.images.new("probe", 16, 16)
        pixels: list[float] = []
        for y in range(16):
            for x in range(16):
                pixels += [x / 15.0, y / 15.0, 0.25 + 0.5 * ((x // 4 + y // 4) % 2), 0.5 + 0.5 * x / 15.0]
        self.image.pixels = pixels
        self.ies = bpy.data.texts.load(str(IES_FILE))
        self.reference = bpy.data.objects.new("reference", None)
        self.reference.location = (0.3, -0.2, 0.1)

    def add_all(self) -> None:
        self.probes.append(Probe("", "(no material)", "plain", "Surface", "", "Surface"))
        for type_ in node_types():
            self.add_type(type_)

    def add_type(self, type_: str) -> None:
        tree = bpy.data.materials.new("model")
        tree.use_nodes = True
        node = tree.node_tree.nodes.new(type_)
        table = CONTEXT.get(type_, {})
        for kind, name, value, shown in parts(node):
            self.add(Probe("", type_, kind, name, value, shown), {} if kind == "plain" else _matching(table, name))
        bpy.data.materials.remove(tree)

    def add(self, probe: Probe, context: dict[str, object]) -> None:
        """Add two materials: one with the context, and one with the change as well. Without a context, the first is the plain probe."""
        if context:
            self.make(Probe("", probe.node, "context", probe.name, probe.value, probe.shown), context, False)
        self.make(probe, context, True)

    def make(self, probe: Probe, context: dict[str, object], changed: bool) -> None:
        name = f"probe {len(self.probes)}"
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        nodes, links = material.node_tree.nodes, material.node_tree.links
        nodes.clear()
        node, end = nodes.new(probe.node), nodes.new("ShaderNodeOutputMaterial")
        self.prepare(node)
        self.feed(node, nodes, links)
        _set(node, context)
        if changed and probe.kind == "choice":
            try:
                setattr(node, probe.name, probe.value)
            except TypeError:       # not available in this state of the node
                bpy.data.materials.remove(material)
                return
            if hasattr(node, "ies") and node.mode == "INTERNAL":   # the change of the mode has removed it
                node.ies = self.ies
        if changed and probe.kind == "switch":
            self.change_property(node, probe.name)
        if changed and probe.kind == "input":
            self.change_input(_socket(node, probe.name), nodes, links)
        output = next((s for s in node.outputs if s.identifier == probe.name and s.enabled), None) if probe.kind in ("plain", "output") else next((s for s in node.outputs if s.enabled), None)
        if output is None:
            bpy.data.materials.remove(material)
            return
        self.connect(probe.node, node, output, end, nodes, links)
        self.probes.append(Probe(name, probe.node, probe.kind, probe.name, probe.value, probe.shown))

    def prepare(self, node: bpy.types.Node) -> None:
        """Set values that are empty by default."""
        if hasattr(node, "image"):
            node.image = self.image
        for name in HEIGHTS.get(node.bl_idname, ()):   # the default heights of newer Blenders are too small to be visible
            node.inputs[name].default_value = 1.0
        if node.bl_idname == "ShaderNodeTexIES":
            node.mode, node.filepath, node.ies = "EXTERNAL", str(IES_FILE), self.ies
        if node.bl_idname == "ShaderNodeTexCoord":
            node.object = self.reference
        if node.bl_idname == "ShaderNodeAttribute":
            node.attribute_name = "Col"
        if node.bl_idname == "ShaderNodeVertexColor":
            node.layer_name = "Col"
        if hasattr(node, "color_ramp"):
            node.color_ramp.elements[0].color = (0.9, 0.2, 0.1, 0.3)
        if hasattr(node, "mapping") and hasattr(node.mapping, "curves"):
            node.mapping.curves[0].points.new(0.4, 0.7)
            node.mapping.update()
        if node.bl_idname in ("ShaderNodeValue", "ShaderNodeRGB"):
            node.outputs[0].default_value = 0.4 if node.bl_idname == "ShaderNodeValue" else (0.2, 0.5, 0.8, 1.0)

    def change_property(self, node: bpy.types.Node, name: str) -> None:
        prop = node.bl_rna.properties[name]
        if name == "texture_mapping":
            node.texture_mapping.translation, node.texture_mapping.rotation, node.texture_mapping.scale = (0.3, 0.2, 0.1), (0.2, 0.1, 0.4), (1.3, 0.8, 1.1)
        elif prop.type == "BOOLEAN":
            setattr(node, name, not getattr(node, name))
        elif getattr(prop, "is_array", False):
            setattr(node, name, [other(value, prop.soft_min, prop.soft_max) for value in getattr(node, name)])
        else:
            value = other(getattr(node, name), prop.soft_min, prop.soft_max)
            setattr(node, name, int(value) if prop.type == "INT" else value)

    def feed(self, node: bpy.types.Node, nodes: bpy.types.Nodes, links: bpy.types.NodeLinks) -> None:
        """Set inputs that show more than the defaults."""
        if node.bl_idname in BRANCHES:
            for socket, kind in zip([s for s in node.inputs if s.type == "SHADER"], ("ShaderNodeBsdfDiffuse", "ShaderNodeEmission")):
                source = nodes.new(kind)
                source.inputs["Color"].default_value = (0.8, 0.4, 0.2, 1.0) if kind.endswith("Diffuse") else (0.1, 0.3, 0.5, 1.0)
                links.new(source.outputs[0], socket)
        if node.bl_idname in HEIGHTS:
            wave = nodes.new("ShaderNodeTexWave")
            wave.inputs["Scale"].default_value = 0.7
            links.new(wave.outputs["Fac" if "Fac" in wave.outputs else 1], node.inputs["Vector" if node.bl_idname.endswith("VectorDisplacement") else "Height"])
        if node.bl_idname in HEIGHTS or any(socket.type == "SHADER" for socket in node.outputs):
            return
        for socket in node.inputs:
            if socket.identifier and hasattr(socket, "default_value"):
                self.feed_value(node, socket, nodes, links)

    def feed_value(self, node: bpy.types.Node, socket: bpy.types.NodeSocket, nodes: bpy.types.Nodes, links: bpy.types.NodeLinks) -> None:
        type_, name = node.bl_idname, socket.identifier
        if type_ == "ShaderNodeNormalMap":
            if socket.type == "RGBA":
                socket.default_value = (0.6, 0.7, 0.9, 1.0)
        elif socket.type == "VECTOR" and not (socket.hide_value and type_.startswith(WITH_DEFAULT_VECTOR)):
            if name == "Vector" or type_ in ("ShaderNodeVectorMath", "ShaderNodeNormal"):
                links.new(nodes.new("ShaderNodeTexCoord").outputs["Normal" if name == "Vector" else "Generated"], socket)
            elif type_ in LIVELY and not name.startswith(BOUNDS):
                socket.default_value = [_number(name + axis) for axis in "xyz"]
        elif socket.type == "RGBA":
            socket.default_value = [_number(name + channel) for channel in "rgb"] + [1.0]
        elif socket.type == "VALUE" and type_.startswith("ShaderNodeTex") and name == "Scale":
            socket.default_value = 0.8      # patterns of a size that is visible with a few pixels
        elif socket.type == "VALUE" and type_ in LIVELY and not name.startswith(BOUNDS):
            socket.default_value = _number(name)

    def change_input(self, socket: bpy.types.NodeSocket, nodes: bpy.types.Nodes, links: bpy.types.NodeLinks) -> None:
        for link in list(socket.links):
            links.remove(link)
        if socket.type == "VECTOR" and socket.hide_value:      # a tilted normal
            links.new(self.leaning_normal(nodes, links), socket)
        elif socket.type == "VECTOR":
            socket.default_value = [value * 0.6 + 0.3 for value in socket.default_value]
        elif socket.type == "RGBA":
            socket.default_value = (0.25, 0.5, 0.75, 1.0)
        elif socket.type == "BOOLEAN":
            socket.default_value = not socket.default_value
        elif socket.type in ("VALUE", "INT"):
            prop = socket.bl_rna.properties["default_value"]
            value = other(socket.default_value, getattr(prop, "soft_min", -1e9), getattr(prop, "soft_max", 1e9))
            socket.default_value = int(value) if socket.type == "INT" else value

    def leaning_normal(self, nodes: bpy.types.Nodes, links: bpy.types.NodeLinks) -> bpy.types.NodeSocket:
        geometry, sum_, unit = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeVectorMath"), nodes.new("ShaderNodeVectorMath")
        sum_.operation, unit.operation = "ADD", "NORMALIZE"
        sum_.inputs[1].default_value = (0.3, 0.2, 0.1)
        links.new(geometry.outputs["Normal"], sum_.inputs[0])
        links.new(sum_.outputs[0], unit.inputs[0])
        return unit.outputs[0]

    def connect(self, type_: str, node: bpy.types.Node, output: bpy.types.NodeSocket, end: bpy.types.Node, nodes: bpy.types.Nodes, links: bpy.types.NodeLinks) -> None:
        if type_ in DISPLACEMENTS:
            links.new(output, end.inputs["Displacement"])
            links.new(nodes.new("ShaderNodeBsdfDiffuse").outputs[0], end.inputs["Surface"])
        elif type_ in ("ShaderNodeBump", "ShaderNodeNormalMap", "ShaderNodeBevel"):
            diffuse = nodes.new("ShaderNodeBsdfDiffuse")
            links.new(output, diffuse.inputs["Normal"])
            links.new(diffuse.outputs[0], end.inputs["Surface"])
        elif output.type == "SHADER":
            links.new(output, end.inputs["Volume" if "Volume" in type_ else "Surface"])
        else:
            # Values can be negative, which a film does not store, so that they are shifted.
            emission = nodes.new("ShaderNodeEmission")
            for operation, numbers in (("MULTIPLY_ADD", (0.25, 0.5)), ("MAXIMUM", (0.0,)), ("MINIMUM", (4.0,))):
                step = nodes.new("ShaderNodeVectorMath")
                step.operation = operation
                for socket, number in zip(step.inputs[1:], numbers):
                    socket.default_value = (number,) * 3
                links.new(output, step.inputs[0])
                output = step.outputs[0]
            links.new(output, emission.inputs["Color"])
            links.new(emission.outputs[0], end.inputs["Surface"])


def run(program: Callable[[str], None]) -> None:
    """Call the program with the file that the command line names, and end Blender with an exit code."""
    parser = argparse.ArgumentParser(prog=Path(sys.argv[0]).name)
    parser.add_argument("out", help="JSON file of the results")
    status = 1
    try:
        program(parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else None).out)
        status = 0
    except Exception:
        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
