"""Runs in the Python of a bpy wheel with Ajar from a zip: renders a plane that emits a value with both engines, and writes the largest
difference of each case to OUT, as JSON. Negative light, which Ajar does not emit, counts as 0.

    python images_inside.py ZIP OUT
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "blender" / "inside"))
from plane_view import difference, look_at_plane

SIZE = 32
SPACES = ("sRGB", "Linear Rec.709", "Linear Rec.2020", "ACEScg", "Linear CIE-XYZ D65", "Filmic Log", "Rec.2100-PQ", "Display P3", "Non-Color")
OLDER_SPACES = ("sRGB", "Linear Rec.709", "Linear Rec.2020", "ACES2065-1", "Linear CIE-XYZ D65", "Filmic Log", "Display P3", "Non-Color")
FOLDER = Path(tempfile.mkdtemp())


def scene_with_plane() -> tuple[bpy.types.Scene, bpy.types.NodeTree, bpy.types.Mesh]:
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("Plane")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    material = bpy.data.materials.new("Material")
    material.use_nodes = True
    mesh.materials.append(material)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    for thing in (camera, bpy.data.objects.new("Plane", mesh)):
        scene.collection.objects.link(thing)
    scene.camera = camera
    look_at_plane(scene, SIZE)
    return scene, material.node_tree, mesh


class Cases:
    def __init__(self) -> None:
        self.scene, self.tree, self.mesh = scene_with_plane()
        self.found: dict[str, float] = {}

    def emission_of(self, type_: str) -> tuple[bpy.types.Node, bpy.types.Node]:
        """A new node of this type and an Emission node linked to the output."""
        self.tree.nodes.clear()
        output, emission, node = (self.tree.nodes.new(f"ShaderNode{name}") for name in ("OutputMaterial", "Emission", type_))
        self.tree.links.new(emission.outputs[0], output.inputs[0])
        return node, emission

    def show(self, image: bpy.types.Image, alpha: bool = False) -> None:
        texture, emission = self.emission_of("TexImage")
        texture.image, texture.interpolation = image, "Closest"
        self.tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
        if alpha:
            self.tree.links.new(texture.outputs["Alpha"], emission.inputs["Strength"])

    def along_u(self, type_: str, low: float, high: float) -> None:
        node, emission = self.emission_of(type_)
        coordinates, parts, values = (self.tree.nodes.new(f"ShaderNode{name}") for name in ("TexCoord", "SeparateXYZ", "MapRange"))
        values.inputs["To Min"].default_value, values.inputs["To Max"].default_value = low, high
        for start, end in ((coordinates.outputs["UV"], parts.inputs[0]), (parts.outputs[0], values.inputs[0]), (values.outputs[0], node.inputs[0]),
                           (node.outputs[0], emission.inputs[0])):
            self.tree.links.new(start, end)

    def measure(self, name: str) -> None:
        found, brightness = difference(self.scene, FOLDER)
        self.found[name] = found if brightness > 0.0 else 1.0


def written(name: str, kind: str, depth: str) -> bpy.types.Image:
    """A file of random pixels."""
    image = bpy.data.images.new("Pixels", 6, 5, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(np.random.default_rng(1).uniform(0.3, 0.9, 120).astype(np.float32))
    image.update()
    scene = bpy.data.scenes.new("Writer")
    scene.view_settings.view_transform = "Standard"
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):   # since 5.0
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_mode, settings.color_depth = kind, "RGBA", depth
    image.save_render(str(FOLDER / name), scene=scene)
    bpy.data.scenes.remove(scene)
    return bpy.data.images.load(str(FOLDER / name))


def colors(cases: Cases, images: dict[str, bpy.types.Image]) -> None:
    has_spaces = bpy.app.version >= (5, 0)
    for working in ("Linear Rec.709", "Linear Rec.2020", "ACEScg") if has_spaces else ("the only space",):
        if has_spaces:
            bpy.ops.wm.set_working_color_space(working_space=working)
        for name, image in images.items():
            for space in SPACES if has_spaces else OLDER_SPACES:
                image.colorspace_settings.name = space
                cases.show(image)
                cases.measure(f"{working}: {name} in {space}")
            image.colorspace_settings.name = "sRGB"
        cases.along_u("Blackbody", 900.0, 9000.0)
        cases.measure(f"{working}: Blackbody")
        cases.along_u("Wavelength", 400.0, 700.0)
        cases.measure(f"{working}: Wavelength")
    if has_spaces:
        bpy.ops.wm.set_working_color_space(working_space="Linear Rec.709")


def alpha_modes(cases: Cases, images: dict[str, bpy.types.Image]) -> None:
    for name, image in images.items():
        for mode in ("STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"):
            image.alpha_mode = mode
            for alpha in (False, True):
                cases.show(image, alpha)
                cases.measure(f"{name}, {mode}, {'with' if alpha else 'without'} alpha")


def repeat_zone(cases: Cases) -> None:
    cases.along_u("Math", 0.0, 1.0)
    nodes, links = cases.tree.nodes, cases.tree.links
    math, emission = (next(node for node in nodes if node.type == type_) for type_ in ("MATH", "EMISSION"))
    start, end = nodes.new("GeometryNodeRepeatInput"), nodes.new("GeometryNodeRepeatOutput")
    start.pair_with_output(end)
    end.repeat_items.clear()
    end.repeat_items.new("FLOAT", "Value")
    start.inputs[0].default_value, math.inputs[1].default_value = 4, 0.1
    links.new(next(node for node in nodes if node.type == "MAP_RANGE").outputs[0], start.inputs["Value"])
    links.new(start.outputs["Value"], math.inputs[0])
    links.new(math.outputs[0], end.inputs["Value"])
    links.new(end.outputs["Value"], emission.inputs[0])
    cases.measure("a repeat zone")


def generated_images(cases: Cases) -> None:
    """Images that were painted in Blender: only in memory, and packed."""
    for name, is_float in (("bytes", False), ("floats", True)):
        image = bpy.data.images.new("Painted", 6, 5, alpha=True, float_buffer=is_float)
        image.pixels.foreach_set(np.random.default_rng(2).uniform(0.3, 0.9, 120).astype(np.float32))
        image.update()
        for state in ("in memory", "packed"):
            if state == "packed":
                image.pack()
            for alpha in (False, True):
                cases.show(image, alpha)
                cases.measure(f"an image of {name} {state}, {'with' if alpha else 'without'} alpha")


def inputs_of_groups(cases: Cases) -> None:
    """The value of a group's input replaces the default coordinates of a texture, and the normal. Hidden values do not."""
    for hidden in (False, True):
        for inner, name in (("TexNoise", "Vector"), ("TexChecker", "Vector"), ("LayerWeight", "Normal"), ("Mapping", "Vector")):
            group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
            group.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketVector").hide_value = hidden
            group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
            start, node, end = (group.nodes.new(type_) for type_ in ("NodeGroupInput", f"ShaderNode{inner}", "NodeGroupOutput"))
            group.links.new(start.outputs[0], node.inputs[name])
            group.links.new(node.outputs[0], end.inputs[0])
            use, emission = cases.emission_of("Group")
            use.node_tree = group
            use.inputs[0].default_value = (0.3, 0.2, 0.6)
            cases.tree.links.new(use.outputs[0], emission.inputs[0])
            cases.measure(f"{inner} behind the input of a group{', hidden' if hidden else ''}")


def nodes_of_other_engines(cases: Cases) -> None:
    """Cycles ignores the links of Shader to RGB."""
    node, emission = cases.emission_of("ShaderToRGB")
    emission.inputs["Color"].default_value = (0.2, 0.5, 0.7, 1.0)
    cases.tree.links.new(cases.tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], node.inputs[0])
    cases.tree.links.new(node.outputs["Color"], emission.inputs["Color"])
    cases.measure("Shader to RGB")
    ramp = cases.tree.nodes.new("ShaderNodeValToRGB")
    ramp.inputs[0].default_value = 0.3
    cases.tree.links.new(node.outputs["Color"], ramp.inputs[0])
    cases.tree.links.new(ramp.outputs[0], emission.inputs["Color"])
    cases.measure("a ramp of Shader to RGB")


def normal_map(cases: Cases) -> None:
    node, emission = cases.emission_of("NormalMap")
    node.inputs["Color"].default_value, node.inputs["Strength"].default_value = (0.7, 0.6, 0.9, 1.0), 0.7
    cases.tree.links.new(node.outputs[0], emission.inputs[0])
    cases.measure("a normal map")
    cases.mesh.uv_layers[0].data.foreach_set("uv", [0.0] * 8)
    cases.mesh.update()
    cases.measure("a normal map without coordinates")


def sharp_edges(cases: Cases) -> None:
    """A roof of smooth faces, without sharp edges, with one and with sharp edges alone."""
    mesh = cases.mesh
    mesh.clear_geometry()
    mesh.from_pydata([(0, 0, 0), (0.5, 0, 0.4), (1, 0, 0), (0, 1, 0), (0.5, 1, 0.4), (1, 1, 0)], [], [(0, 1, 4, 3), (1, 2, 5, 4)])
    mesh.shade_smooth()
    node, emission = cases.emission_of("NewGeometry")
    cases.tree.links.new(node.outputs["Normal"], emission.inputs[0])
    sharp = mesh.attributes.new("sharp_edge", "BOOLEAN", "EDGE")
    ridge = next(edge.index for edge in mesh.edges if set(edge.vertices) == {1, 4})
    for name, edges in (("no", ()), ("one", (ridge,)), ("all", range(len(mesh.edges)))):
        sharp.data.foreach_set("value", [index in edges for index in range(len(mesh.edges))])
        mesh.update()
        cases.measure(f"smooth faces with sharp edges: {name}")


def main() -> None:
    bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
    bpy.ops.preferences.addon_enable(module="cycles")
    cases = Cases()
    images = {"png": written("a.png", "PNG", "8"), "exr": written("b.exr", "OPEN_EXR", "32")}
    colors(cases, images)
    alpha_modes(cases, images)
    if hasattr(bpy.types.Material, "inline_shader_nodes"):   # since 5.0
        repeat_zone(cases)
    generated_images(cases)
    inputs_of_groups(cases)
    nodes_of_other_engines(cases)
    normal_map(cases)
    sharp_edges(cases)
    Path(sys.argv[2]).write_text(json.dumps(cases.found, indent=2))
    sys.stdout.flush()
    os._exit(0)


main()
