"""Runs in the Python of a bpy wheel, as linking_inside.py: heads in many kinds of objects and instances emit what nodes read of the object, the surface and
the view. The excess is the share of pixels that differ between the engines, over the allowed share.

    python outputs_inside.py ZIP OUT
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "blender" / "inside"))
from plane_view import look_at_plane, render

SIZE = 40
MOST, SHARE = 3e-3, 0.02   # pixels at edges may see another face
UNREADABLE = ("geometry_nodes", "Attribute Color INSTANCER UVMap")   # by Python before 4.5, which the add-on reports
SETUPS: dict[str, Callable[[], None]] = {}


def setup(function: Callable[[], None]) -> Callable[[], None]:
    SETUPS[function.__name__] = function
    return function


class Probes:
    """A material that emits one of many outputs, shifted so that negative values are visible."""

    def __init__(self) -> None:
        self.material = bpy.data.materials.new("Probe")
        self.material.pass_index = 3
        self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        output, emission, self.shift = (self.tree.nodes.new(f"ShaderNode{kind}") for kind in ("OutputMaterial", "Emission", "VectorMath"))
        self.shift.operation = "MULTIPLY_ADD"
        self.shift.inputs[1].default_value, self.shift.inputs[2].default_value = (0.2,) * 3, (1.5,) * 3
        self.tree.links.new(self.shift.outputs[0], emission.inputs["Color"])
        self.tree.links.new(emission.outputs[0], output.inputs["Surface"])
        self.sockets: dict[str, bpy.types.NodeSocket] = {}
        self.add("ObjectInfo", ("Location", "Color", "Alpha", "Object Index", "Material Index", "Random"))
        self.add("TexCoord", ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection"))
        self.add("TexCoord", ("Generated", "UV"), from_instancer=True)
        self.add("NewGeometry", ("Position", "Normal", "Tangent", "True Normal", "Incoming", "Backfacing", "Pointiness", "Random Per Island"))
        self.add("CameraData", ("View Vector", "View Z Depth", "View Distance"))
        for kind in ("GEOMETRY", "OBJECT", "INSTANCER"):
            for name in ("color", "property", "location", "UVMap", "values"):
                self.add("Attribute", ("Color",), attribute_type=kind, attribute_name=name)
        for kind in ("VECTOR", "POINT", "NORMAL"):
            for start, end in (("OBJECT", "WORLD"), ("WORLD", "OBJECT"), ("CAMERA", "OBJECT")):
                self.add("VectorTransform", ("Vector",), vector_type=kind, convert_from=start, convert_to=end)
        self.add("Tangent", ("Tangent",), direction_type="UV_MAP")
        self.add("LayerWeight", ("Facing",))

    def add(self, kind: str, outputs: tuple[str, ...], **settings: object) -> None:
        node = self.tree.nodes.new(f"ShaderNode{kind}")
        for name, value in settings.items():
            setattr(node, name, value)
        if kind == "VectorTransform":
            node.inputs[0].default_value = (0.3, 0.5, 0.8)
        for name in outputs:
            self.sockets[" ".join((kind, name, *map(str, settings.values())))] = node.outputs[name]

    def show(self, name: str) -> None:
        self.tree.links.new(self.sockets[name], self.shift.inputs[0])


def head(collection: bpy.types.Collection | None = None, scale: float = 1.0) -> bpy.types.Object:
    bpy.ops.mesh.primitive_monkey_add(size=0.7 * scale)
    thing = bpy.context.object
    thing.data.materials.append(bpy.data.materials["Probe"])
    values = np.random.default_rng(1).random(4 * len(thing.data.vertices)).astype(np.float32)
    thing.data.color_attributes.new("values", "FLOAT_COLOR", "POINT").data.foreach_set("color", values)
    thing.color, thing.pass_index = (0.8, 0.1, 0.3, 0.4), 2
    thing["property"] = 0.7
    if collection is not None:
        for other in list(thing.users_collection):
            other.objects.unlink(thing)
        collection.objects.link(thing)
    return thing


def instancer(member: bpy.types.Collection, collection: bpy.types.Collection | None = None, color=(0.1, 0.8, 0.2, 0.6)) -> bpy.types.Object:
    thing = bpy.data.objects.new("Instancer", None)
    thing.instance_type, thing.instance_collection = "COLLECTION", member
    thing.rotation_euler, thing.scale, thing.location = (0.4, 0.3, 0.9), (1.2, 0.8, 1.0), (0.45, 0.5, 0.0)
    thing.color, thing.pass_index = color, 4
    thing["property"] = 0.25
    (collection or bpy.context.scene.collection).objects.link(thing)
    return thing


def ground(size: float = 0.4) -> bpy.types.Object:
    bpy.ops.mesh.primitive_plane_add(size=size, location=(0.5, 0.5, 0.0))
    thing = bpy.context.object
    thing.color = (0.1, 0.8, 0.2, 0.6)
    thing["property"] = 0.25
    return thing


@setup
def stretched() -> None:
    thing = head()
    thing.location, thing.rotation_euler, thing.scale = (0.5, 0.5, 0.0), (0.3, 0.2, 0.1), (1.0, 0.8, 1.1)


@setup
def mirrored() -> None:
    stretched()
    bpy.context.object.scale.x = -1.0


@setup
def collection() -> None:
    members = bpy.data.collections.new("Members")
    members.instance_offset = (0.1, 0.05, 0.1)
    head(members).rotation_euler = (0.0, 0.3, 0.0)
    instancer(members)


@setup
def nested() -> None:
    inner, outer = bpy.data.collections.new("Inner"), bpy.data.collections.new("Outer")
    head(inner)
    instancer(inner, outer).location = (0.0, 0.0, 0.0)
    instancer(outer, color=(0.2, 0.3, 0.9, 1.0))


@setup
def vertices() -> None:
    thing, parent = head(scale=0.5), ground()
    thing.parent, parent.instance_type, parent.show_instancer_for_render = parent, "VERTS", False


@setup
def geometry_nodes() -> None:
    thing, parent = head(scale=0.5), ground()
    thing.location = (9.0, 0.0, 0.0)
    tree = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
    for io in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=io, socket_type="NodeSocketGeometry")
    start, end, info, instances = (tree.nodes.new(kind) for kind in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeObjectInfo", "GeometryNodeInstanceOnPoints"))
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = thing, True
    instances.inputs["Rotation"].default_value, instances.inputs["Scale"].default_value = (0.2, 0.5, 0.1), (0.9, 1.2, 1.0)
    for a, b in ((start.outputs[0], instances.inputs["Points"]), (info.outputs["Geometry"], instances.inputs["Instance"]), (instances.outputs[0], end.inputs[0])):
        tree.links.new(a, b)
    parent.modifiers.new("Nodes", "NODES").node_group = tree


@setup
def particles() -> None:
    thing, parent = head(scale=0.6), ground(0.7)
    thing.location = (9.0, 0.0, 0.0)
    parent.show_instancer_for_render = False
    system = parent.modifiers.new("Particles", "PARTICLE_SYSTEM").particle_system.settings
    system.type, system.count, system.render_type, system.instance_object = "HAIR", 9, "OBJECT", thing
    system.particle_size, system.use_advanced_hair, system.use_rotation_instance = 0.5, True, True


def main() -> None:
    bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
    bpy.ops.preferences.addon_enable(module="cycles")
    scene, probes, folder, found = bpy.context.scene, Probes(), Path(tempfile.mkdtemp()), {}
    for place, build in SETUPS.items():
        for thing in list(bpy.data.objects):
            bpy.data.objects.remove(thing)
        scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(scene.camera)
        look_at_plane(scene, SIZE)
        build()
        bpy.context.view_layer.update()
        for name in probes.sockets:
            if (place, name) == UNREADABLE and not hasattr(bpy.types.Object, "evaluated_geometry"):
                continue
            probes.show(name)
            cycles, ajar = (render(scene, engine, folder) for engine in ("CYCLES", "AJAR"))
            seen = (cycles > 0.0).any(axis=1)
            share = float((np.abs(cycles - ajar).max(axis=1) > MOST).sum() / max(seen.sum(), 1))
            found[f"{place}: {name}"] = {"excess": share / SHARE if seen.sum() > 80 else 99.0}
    Path(sys.argv[2]).write_text(json.dumps(found, indent=2))
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
