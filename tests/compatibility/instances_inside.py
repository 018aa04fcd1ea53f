"""Runs in the Python of a bpy wheel of Blender 5.0 or later, as linking_inside.py: boxes glow as attributes say that geometry nodes give their instances.

    python instances_inside.py ZIP OUT
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
import linking_inside as stage


def glowing(*names: str) -> bpy.types.Material:
    """Emits the sum of the attributes of the instancer."""
    material = stage.material((1.0, 1.0, 1.0), "ShaderNodeEmission")
    tree, last = material.node_tree, None
    for name in names:
        node = tree.nodes.new("ShaderNodeAttribute")
        node.attribute_type, node.attribute_name = "INSTANCER", name
        if last is None:
            last = node.outputs["Color"]
            continue
        add = tree.nodes.new("ShaderNodeVectorMath")
        tree.links.new(last, add.inputs[0])
        tree.links.new(node.outputs["Color"], add.inputs[1])
        last = add.outputs[0]
    tree.links.new(last, tree.nodes["Emission"].inputs["Color"])
    return material


class Nodes:
    """The geometry nodes of a new object."""

    def __init__(self, scene: bpy.types.Scene, name: str = "Host", collection: bpy.types.Collection | None = None) -> None:
        self.object = bpy.data.objects.new(name, bpy.data.meshes.new(name))
        (collection or scene.collection).objects.link(self.object)
        self.tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
        self.tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        self.object.modifiers.new(name, "NODES").node_group = self.tree

    def node(self, kind: str, *links: tuple[str, bpy.types.NodeSocket], **inputs: object) -> bpy.types.NodeSocket:
        """The output Geometry of a new node, or its only one."""
        node = self.tree.nodes.new(kind)
        for name, value in inputs.items():
            node.inputs[name].default_value = value
        for name, socket in links:
            self.tree.links.new(socket, node.inputs[name])
        return node.outputs.get("Geometry", node.outputs[0])

    def row(self, instance: bpy.types.NodeSocket, count: int, start: tuple, offset: tuple) -> bpy.types.NodeSocket:
        line = self.node("GeometryNodeMeshLine", **{"Count": count, "Start Location": start, "Offset": offset})
        return self.node("GeometryNodeInstanceOnPoints", ("Points", line), ("Instance", instance))

    def store(self, geometry: bpy.types.NodeSocket, name: str, kind: str, value: bpy.types.NodeSocket, domain: str = "INSTANCE") -> bpy.types.NodeSocket:
        node = self.tree.nodes.new("GeometryNodeStoreNamedAttribute")
        node.data_type, node.domain = kind, domain
        node.inputs["Name"].default_value = name
        self.tree.links.new(geometry, node.inputs["Geometry"])
        self.tree.links.new(value, node.inputs["Value"])
        return node.outputs[0]

    def position(self, factor: float) -> bpy.types.NodeSocket:
        scaled = self.tree.nodes.new("ShaderNodeVectorMath")
        scaled.operation = "SCALE"
        scaled.inputs["Scale"].default_value = factor
        self.tree.links.new(self.node("GeometryNodeInputPosition"), scaled.inputs[0])
        return scaled.outputs[0]

    def end(self, geometry: bpy.types.NodeSocket) -> None:
        self.tree.links.new(geometry, self.tree.nodes.new("NodeGroupOutput").inputs[0])


def small_box(scene: bpy.types.Scene, material: bpy.types.Material, name: str = "Small") -> tuple[bpy.types.Collection, bpy.types.Object]:
    """A box in a collection that the scene does not show."""
    hidden = bpy.data.collections.new("Hidden")
    thing = stage.box(name, (0.0, 0.0, 0.0), (0.9, 0.9, 0.9), (1.0, 1.0, 1.0), collection=hidden)
    thing.data.materials[0] = material
    return hidden, thing


def objects(scene: bpy.types.Scene) -> None:
    """Instances of an object. A property of the object and one of the host are hidden by the attributes; another one is not."""
    _hidden, thing = small_box(scene, glowing("shade", "tint", "of host"))
    thing["shade"] = 9.0
    nodes = Nodes(scene)
    nodes.object["tint"], nodes.object["of host"] = 7.0, (1.5, 1.0, 0.3)   # no sum is negative
    info = nodes.node("GeometryNodeObjectInfo", Object=thing, **{"As Instance": True})
    row = nodes.row(info, 5, (-3.0, -2.0, 0.5), (1.5, 0.0, 0.2))
    row = nodes.store(row, "shade", "INT", nodes.node("GeometryNodeInputIndex"))
    nodes.end(nodes.store(row, "tint", "FLOAT_VECTOR", nodes.position(0.4)))


def layers(scene: bpy.types.Scene) -> None:
    """Instances of instances of a collection: the innermost attribute counts."""
    hidden, _thing = small_box(scene, glowing("shade", "outer"))
    nodes = Nodes(scene)
    inner = nodes.row(nodes.node("GeometryNodeCollectionInfo", Collection=hidden), 2, (0.0, 0.0, 0.0), (0.0, 0.0, 1.2))
    inner = nodes.store(inner, "shade", "FLOAT", nodes.node("GeometryNodeInputIndex"))
    outer = nodes.row(inner, 4, (-3.0, -2.0, 0.6), (1.9, 0.0, 0.0))
    outer = nodes.store(outer, "shade", "FLOAT_COLOR", nodes.position(3.0))
    nodes.end(nodes.store(outer, "outer", "FLOAT", nodes.node("ShaderNodeMath", ("Value", nodes.node("GeometryNodeInputIndex")))))


def ids(scene: bpy.types.Scene) -> None:
    """Instances whose ids are not their numbers, in a collection that an empty shows."""
    _hidden, thing = small_box(scene, glowing("shade", "of empty"))
    shown = bpy.data.collections.new("Shown")
    stage.box("Other", (0.0, 0.0, -1.0), (0.2, 0.2, 0.2), (0.5, 0.5, 0.5), collection=shown)
    nodes = Nodes(scene, collection=shown)
    info = nodes.node("GeometryNodeObjectInfo", Object=thing, **{"As Instance": True})
    row = nodes.row(info, 5, (-3.0, -2.0, 0.5), (1.5, 0.0, 0.2))
    remaining = nodes.tree.nodes.new("ShaderNodeMath")
    remaining.operation, remaining.inputs[0].default_value = "SUBTRACT", 40.0
    nodes.tree.links.new(nodes.node("GeometryNodeInputIndex"), remaining.inputs[1])
    row = nodes.store(row, "shade", "FLOAT_VECTOR", nodes.position(0.5))
    nodes.end(nodes.node("GeometryNodeSetID", ("Geometry", row), ("ID", remaining.outputs[0])))
    empty = bpy.data.objects.new("Empty", None)
    empty.instance_type, empty.instance_collection, empty["of empty"] = "COLLECTION", shown, (2.0, 1.5, 0.2)
    scene.collection.objects.link(empty)


if __name__ == "__main__":
    stage.main((objects, layers, ids))
