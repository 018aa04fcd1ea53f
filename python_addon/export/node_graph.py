"""Shader node trees as flat graphs: docs/developer/node_contract.md.

A graph is traversed from its output, so that unused nodes are not exported. Groups, reroutes and muted nodes are resolved: the source of an input is
another node, a constant, or nothing.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import dataclass, field

import bpy

from .. import compat
from ..ajar_module import ajar
from . import images, named_values
from .attributes import CURVE_NORMAL
from .context import ExportContext, rows_3x4

Value = tuple[float, float, float, float]
ZERO: Value = (0.0, 0.0, 0.0, 0.0)
LARGEST_IES = 1 << 24   # bytes; typical files have a few thousand
# All other texture nodes use Generated coordinates by default.
WITHOUT_GENERATED = {"ShaderNodeTexImage", "ShaderNodeTexEnvironment", "ShaderNodeTexWhiteNoise", "ShaderNodeTexIES"}

# Nodes without a closure that Blender shows but Cycles does not have. It ignores their links: an input keeps its own value.
NOT_OF_CYCLES = {"ShaderNodeShaderToRGB", "ShaderNodeSqueeze", "ShaderNodeUVAlongStroke"}

# Nodes by which Blender's inlining links a constant to an input, and the property that has it.
CONSTANTS = {"FunctionNodeInputVector": "vector", "FunctionNodeInputInt": "integer", "FunctionNodeInputBool": "boolean"}


@dataclass(eq=False)
class Scope:
    """One use of a node tree: by the material itself, or by one group node."""

    tree: bpy.types.NodeTree
    group_node: bpy.types.Node | None = None
    parent: Scope | None = None
    prefix: str = ""
    is_inlined: bool = False
    feeding: dict[int, bpy.types.NodeLink] = field(default_factory=dict)   # address of an input -> its link
    children: dict[int, Scope | None] = field(default_factory=dict)        # address of a group node -> its scope

    def __post_init__(self) -> None:
        for link in self.tree.links:
            if link.is_valid and not link.is_muted and link.from_socket.enabled and link.to_socket.enabled:
                self.feeding[link.to_socket.as_pointer()] = link

    def label(self, node: bpy.types.Node) -> str:
        """The name of a node for messages. Blender puts a number before the names in a tree that it has inlined."""
        return self.prefix + (re.sub(r"^\d+_", "", node.name) if self.is_inlined else node.name)

    def child(self, group_node: bpy.types.Node) -> Scope | None:
        """The scope of a group node, or None if its tree contains itself."""
        key = group_node.as_pointer()
        if key not in self.children:
            outer: Scope | None = self
            while outer is not None and not is_same_tree(outer.tree, group_node.node_tree):
                outer = outer.parent
            self.children[key] = Scope(group_node.node_tree, group_node, self, f"{self.prefix}{group_node.name}/") if outer is None else None
        return self.children[key]


@dataclass
class Source:
    """The source of an input: an output of a node, or a constant of a socket type (node None)."""

    node: bpy.types.Node | None
    scope: Scope
    socket: bpy.types.NodeSocket | None
    value: Value = ZERO
    type: str = "VALUE"


def export(context: ExportContext, tree: bpy.types.NodeTree, owner: bpy.types.ID, name: str) -> ajar.NodeGraph:
    """The graph of the active output of `tree`, which `owner` has. It is empty if there is no output or nothing is linked to it. `name`: for messages."""
    inlined = compat.inlined(owner, tree)
    root = Scope(tree) if inlined is None else Scope(inlined.node_tree, is_inlined=True)
    return GraphExporter(context, root, name).run()


class GraphExporter:
    def __init__(self, context: ExportContext, root: Scope, owner: str) -> None:
        self.context = context
        self.owner = owner
        self.root = root
        self.graph = ajar.NodeGraph()
        self.indices: dict[tuple[int, int], int] = {}
        self.pending: list[tuple[int, bpy.types.Node, Scope]] = []

    def run(self) -> ajar.NodeGraph:
        output = self.root.tree.get_output_node("CYCLES")
        if output is None:
            return self.graph
        for name in ("Surface", "Volume", "Displacement"):
            socket = output.inputs.get(name)
            if socket is not None:
                source = self.trace(socket, self.root)
                if source is not None and source.node is not None:
                    setattr(self.graph, name.lower(), self.link_to(source))
        if self.context.aovs:
            self.add_aovs(self.root)
        while self.pending:
            self.context.check_cancelled()
            self.fill(*self.pending.pop())
        return self.graph

    def add_aovs(self, scope: Scope) -> None:
        """Add the AOV Output nodes that passes show, also those in groups."""
        for node in scope.tree.nodes:
            if node.mute:
                continue
            if node.bl_idname == "ShaderNodeOutputAOV":
                name = compat.aov_name(node)
                shown = self.context.aovs.get(name)
                if shown is None:
                    continue
                other = "Value" if shown == "Color" else "Color"
                if self.trace(node.inputs[shown], scope) is None and self.trace(node.inputs[other], scope) is not None:
                    self.context.warn(self.owner, "its AOV Output {name} has a link only at {other}, but the view layer's AOV shows {shown}",
                                      name=name, other=other, shown=shown)
                self.link_to(Source(node, scope, node.inputs[shown]))
            elif getattr(node, "node_tree", None) is not None and (inner := scope.child(node)) is not None:
                self.add_aovs(inner)

    # ---- Following links ----------------------------------------------------------------------------------------------

    def trace(self, socket: bpy.types.NodeSocket, scope: Scope) -> Source | None:
        """The source of `socket` by links, or None if it is not linked."""
        link = scope.feeding.get(socket.as_pointer())
        if link is None:
            return None
        seen: set[tuple[int, int]] = set()
        while True:
            node, output = link.from_node, link.from_socket
            if (id(scope), output.as_pointer()) in seen:    # a loop of reroutes
                return Source(None, scope, None, ZERO, output.type)
            seen.add((id(scope), output.as_pointer()))
            if node.bl_idname in NOT_OF_CYCLES and not node.mute:
                self.context.warn(self.owner, 'node "{name}" is not a node of Cycles: its links are ignored, as in Cycles', name=scope.label(node))
                return None
            step = self.look_through(node, output, scope)
            if step is None:
                return Source(node, scope, output)
            inner, scope = step
            if inner is None:
                return Source(None, scope, None, ZERO, output.type)
            link = scope.feeding.get(inner.as_pointer())
            if link is None:
                return Source(None, scope, None, value_of(inner), inner.type)

    def look_through(self, node: bpy.types.Node, output: bpy.types.NodeSocket,
                     scope: Scope) -> tuple[bpy.types.NodeSocket | None, Scope] | None:
        """The input that `output` passes on, and its scope; (None, scope) if the output is zero; None if the node must be exported."""
        if node.mute:
            inputs = [link.from_socket for link in node.internal_links if link.to_socket == output]
            return (inputs[0] if inputs else None), scope
        if node.bl_idname == "NodeReroute":
            return node.inputs[0], scope
        if node.bl_idname == "NodeGroupInput":
            if scope.parent is None:
                return None, scope
            return with_identifier(scope.group_node.inputs, output.identifier), scope.parent
        if node.bl_idname == "ShaderNodeGroup" or node.type == "GROUP":
            if node.node_tree is None:
                self.context.warn(self.owner, 'node group "{group}" has lost its tree', group=scope.label(node))
                return None, scope
            inner = scope.child(node)
            if inner is None:
                self.context.warn(self.owner, 'node group "{group}" contains itself: it is left out inside itself (object "{thing}")',
                                  group=scope.label(node), thing=self.context.user)
                return None, scope
            outputs = [other for other in inner.tree.nodes if other.bl_idname == "NodeGroupOutput"]
            active = next((other for other in outputs if other.is_active_output), outputs[0] if outputs else None)
            return (with_identifier(active.inputs, output.identifier) if active is not None else None), inner
        return None

    def link_to(self, source: Source) -> ajar.NodeLink:
        key = (id(source.scope), source.node.as_pointer())
        if source.node.bl_idname in CONSTANTS:
            return self.constant_node(Source(None, source.scope, None, constant_of(source.node), source.socket.type))
        if key not in self.indices:
            index = self.graph.add_node(source.node.bl_idname, source.scope.label(source.node))
            self.indices[key] = index
            self.pending.append((index, source.node, source.scope))
        return ajar.NodeLink(self.indices[key], source.socket.identifier)

    # ---- Nodes --------------------------------------------------------------------------------------------------------

    def fill(self, index: int, node: bpy.types.Node, scope: Scope) -> None:
        for socket in node.inputs:
            if not socket.identifier:
                continue
            source = self.trace(socket, scope)
            if socket.identifier == "Vector" and has_texture_mapping(node):
                self.graph.add_input(index, socket.identifier, ZERO, self.mapped(node, scope, source))
            elif source is None:
                self.graph.add_input(index, socket.identifier, value_of(socket))
            elif source.node is not None:
                self.graph.add_input(index, socket.identifier, value_of(socket), self.link_to(source))
            elif socket.type == "SHADER" and source.type != "SHADER":
                self.graph.add_input(index, socket.identifier, ZERO, self.constant_node(source))
            else:
                self.graph.add_input(index, socket.identifier, converted(source.value, source.type, socket.type))
        kind = node.bl_idname
        if kind not in self.context.node_properties:
            self.context.node_properties[kind] = own_properties(node)
        for name in self.context.node_properties[kind]:
            self.add_property(index, node, name)
        for socket in node.inputs:
            if socket.type == "STRING":
                self.graph.add_property(index, socket.identifier, text=socket.default_value)
                self.context.attribute_names |= {socket.default_value} - {""}   # the attributes of Principled Volume
        if node.bl_idname.startswith("ShaderNodeTex") and node.bl_idname not in WITHOUT_GENERATED:
            self.context.uses_generated = True
        special = SPECIAL.get(node.bl_idname)
        if special is not None:
            for name, content in special(self.context, node):
                if isinstance(content, str):
                    self.graph.add_property(index, name, text=content)
                else:
                    self.graph.add_property(index, name, numbers=content)

    def add_property(self, index: int, node: bpy.types.Node, name: str) -> None:
        value = getattr(node, name)
        if isinstance(value, str):
            self.graph.add_property(index, name, text=value)
        elif isinstance(value, set):
            self.graph.add_property(index, name, text=" ".join(sorted(value)))
        elif isinstance(value, (bool, int, float)):
            self.graph.add_property(index, name, numbers=[float(value)])
        else:
            self.graph.add_property(index, name, numbers=[float(number) for number in value])

    def mapped(self, node: bpy.types.Node, scope: Scope, source: Source | None) -> ajar.NodeLink:
        """The coordinates of a texture after its Texture Mapping, which is exported as a Mapping node."""
        name, mapping = scope.label(node), node.texture_mapping
        if (mapping.mapping_x, mapping.mapping_y, mapping.mapping_z) != ("X", "Y", "Z"):
            self.context.warn(self.owner, "node '{name}' ({kind}): the Projection of its Texture Mapping is not supported: X, Y and Z are used",
                              name=name, kind=node.bl_idname)
        index = self.graph.add_node("ShaderNodeMapping", f"{name} texture mapping")
        if source is None:
            self.graph.add_input(index, "Vector", ZERO, self.own_coordinates(node, name))
        elif source.node is None:
            self.graph.add_input(index, "Vector", converted(source.value, source.type, "VECTOR"))
        else:
            self.graph.add_input(index, "Vector", ZERO, self.link_to(source))
        for socket, numbers in (("Location", mapping.translation), ("Rotation", mapping.rotation), ("Scale", mapping.scale)):
            self.graph.add_input(index, socket, (*numbers, 0.0))
        self.graph.add_property(index, "vector_type", text=mapping.vector_type)
        return ajar.NodeLink(index, "Vector")

    def own_coordinates(self, node: bpy.types.Node, name: str) -> ajar.NodeLink:
        """The default coordinates of a texture whose vector is not linked."""
        is_world = self.root.tree.get_output_node("CYCLES").bl_idname == "ShaderNodeOutputWorld"
        if node.bl_idname == "ShaderNodeTexEnvironment" and not is_world:
            return ajar.NodeLink(self.graph.add_node("ShaderNodeNewGeometry", f"{name} coordinates"), "Position")
        self.context.uses_generated = True
        return ajar.NodeLink(self.graph.add_node("ShaderNodeTexCoord", f"{name} coordinates"), "UV" if node.bl_idname == "ShaderNodeTexImage" else "Generated")

    def constant_node(self, source: Source) -> ajar.NodeLink:
        """A node for a number or colour that is linked to a closure socket, where it is an emission."""
        index = self.graph.add_node("ShaderNodeRGB", f"{self.owner} constant")
        self.graph.add_property(index, "value", numbers=list(converted(source.value, source.type, "RGBA")))
        return ajar.NodeLink(index, "Color")


def is_same_tree(a: bpy.types.NodeTree, b: bpy.types.NodeTree) -> bool:
    return a == b


def has_texture_mapping(node: bpy.types.Node) -> bool:
    """Whether a texture has a Texture Mapping, which is set in the sidebar of the shader editor."""
    mapping = getattr(node, "texture_mapping", None)
    if mapping is None:
        return False
    axes = (mapping.mapping_x, mapping.mapping_y, mapping.mapping_z)
    return any((*mapping.translation, *mapping.rotation)) or any(number != 1.0 for number in mapping.scale) or axes != ("X", "Y", "Z")


# ---- Sockets --------------------------------------------------------------------------------------------------------------

def with_identifier(sockets: bpy.types.bpy_prop_collection, identifier: str) -> bpy.types.NodeSocket | None:
    return next((socket for socket in sockets if socket.identifier == identifier), None)


def value_of(socket: bpy.types.NodeSocket) -> Value:
    if socket.type in ("VALUE", "INT", "BOOLEAN"):
        return (float(socket.default_value), 0.0, 0.0, 0.0)
    if socket.type in ("RGBA", "VECTOR", "ROTATION"):
        first, second, third, fourth = [*(float(number) for number in socket.default_value), 0.0, 0.0, 0.0, 0.0][:4]
        return (first, second, third, fourth)
    return ZERO


def constant_of(node: bpy.types.Node) -> Value:
    """The value of one of CONSTANTS."""
    value = getattr(node, CONSTANTS[node.bl_idname])
    if isinstance(value, (bool, int)):
        return (float(value), 0.0, 0.0, 0.0)
    x, y, z = value
    return (x, y, z, 0.0)


def converted(value: Value, source: str, target: str) -> Value:
    """A constant of one socket type converted to another, by the rules of node_contract.md."""
    source_is_number = source in ("VALUE", "INT", "BOOLEAN")
    if "SHADER" in (source, target):
        return ZERO
    if target in ("VALUE", "INT", "BOOLEAN"):
        if source == "RGBA":
            return (0.2126729 * value[0] + 0.7151522 * value[1] + 0.0721750 * value[2], 0.0, 0.0, 0.0)
        return value if source_is_number else (sum(value[:3]) / 3.0, 0.0, 0.0, 0.0)
    if source_is_number:
        return (value[0], value[0], value[0], 1.0)
    return value if source == "RGBA" else (*value[:3], 1.0)


def own_properties(node: bpy.types.Node) -> list[str]:
    """Identifiers of the properties of this node type that other nodes do not have, without pointers and collections."""
    common = bpy.types.Node.bl_rna.properties
    return [prop.identifier for prop in node.bl_rna.properties
            if prop.identifier not in common and prop.type in ("BOOLEAN", "INT", "FLOAT", "STRING", "ENUM")]


# ---- Values outside sockets and plain properties ------------------------------------------------------------------------

Content = list[float] | str


def _output_value(_context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    value = node.outputs[0].default_value
    return [("value", [float(value)] if isinstance(value, float) else [float(number) for number in value])]


def _image(context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    return [("image", [float(images.export(context, node.image, node.image_user))])]


def _ramp(_context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    ramp = node.color_ramp
    last = compat.last_of_tables()
    numbers = [number for i in range(last + 1) for number in ramp.evaluate(i / last)]
    return [("ramp", numbers), ("ramp_interpolation", ramp.interpolation)]


def _curve(_context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    mapping = node.mapping
    mapping.initialize()
    curves = mapping.curves
    places = [point.location[0] for curve in curves for point in curve.points]
    low, high = min(places), max(places)
    numbers: list[float] = []
    last = compat.last_of_tables()
    for i in range(last + 1):
        t = low + (high - low) * i / last
        if len(curves) == 4:                             # red, green, blue, combined
            t = mapping.evaluate(curves[3], t)
        axes = curves[:3] if len(curves) >= 3 else [curves[0]] * 3
        numbers += [*(mapping.evaluate(curve, t) for curve in axes), 1.0]
    return [("curve", numbers), ("curve_range", [low, high]), ("curve_extrapolate", [float(mapping.extend == "EXTRAPOLATED")])]


def _voronoi(_context: ExportContext, _node: bpy.types.Node) -> list[tuple[str, Content]]:
    return [("cells", "PCG" if bpy.app.version >= (5, 0) else "LOOKUP3")]


def _subsurface(_context: ExportContext, _node: bpy.types.Node) -> list[tuple[str, Content]]:
    if bpy.app.version < (4, 0):
        return []
    return [("random_walk", "MEAN_FREE_PATH" if bpy.app.version >= (5, 2) else "FIXED_RADIUS"),
            ("enters_after_diffuse", [float(bpy.app.version >= (5, 0))])]


def _principled(context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    return [*_subsurface(context, node), ("film_on_metal", [float(bpy.app.version >= (5, 0))])]


def _facets(_context: ExportContext, _node: bpy.types.Node) -> list[tuple[str, Content]]:
    return [("facets", "CORRELATED" if bpy.app.version >= (4, 0) else "SEPARABLE")]


def _displacement(_context: ExportContext, _node: bpy.types.Node) -> list[tuple[str, Content]]:
    return [("filter_width", [0.1 if bpy.app.version >= (4, 3) else 1.0]), *_bumped(_context, _node)]


def keeps_diffuse_normals() -> bool:
    """Whether normals are bent towards the eye for reflections only, and not for diffuse closures."""
    return bpy.app.version >= (4, 0)


def _bumped(_context: ExportContext, _node: bpy.types.Node) -> list[tuple[str, Content]]:
    return [("keeps_normal", [float(keeps_diffuse_normals())])]


def _diffuse(_context: ExportContext, _node: bpy.types.Node) -> list[tuple[str, Content]]:
    return [("multiple_scattering", [float(bpy.app.version >= (4, 3))]), *_bumped(_context, _node)]


def _object_of_coordinates(_context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    if node.object is None:
        return []
    return [("object", rows_3x4(node.object.matrix_world.inverted_safe()))]


def _geometry(context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    for output, name in (("Random Per Island", ajar.RANDOM_PER_ISLAND), ("Pointiness", ajar.POINTINESS)):
        if node.outputs[output].is_linked:
            context.attribute_names.add(name)
    return []


def _volume_info(context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    context.attribute_names |= {output.name.lower() for output in node.outputs if output.is_linked}   # names of grids
    return []


def _vector_transform(_context: ExportContext, _node: bpy.types.Node) -> list[tuple[str, Content]]:
    return [("lamp_has_space", [float(compat.lamps_have_a_space())]), ("normals_stay_perpendicular", [float(compat.normals_stay_perpendicular())])]


def _light_falloff(_context: ExportContext, _node: bpy.types.Node) -> list[tuple[str, Content]]:
    return [("suns_have_none", [float(compat.suns_have_no_falloff())])]


def _ies(_context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    return [*_ies_content(node), ("seen_from_eye", [float(compat.ies_is_seen_from_eye())])]


def _ies_content(node: bpy.types.Node) -> list[tuple[str, Content]]:
    """The text of the profile, or why there is none."""
    if node.mode == "INTERNAL":
        return [("ies", node.ies.as_string())] if node.ies is not None else []
    if not node.filepath:
        return []
    path = os.path.normpath(bpy.path.abspath(node.filepath, library=node.id_data.library))
    try:
        with open(path, "rb") as file:
            content = file.read(LARGEST_IES + 1)
    except OSError as error:
        return [("unreadable", f"{path}: {error.strerror}")]
    if len(content) > LARGEST_IES:
        return [("unreadable", f"{path}: too large")]
    return [("ies", content.decode("latin-1"))]


def _distance_of_world(context: ExportContext, _node: bpy.types.Node) -> list[tuple[str, Content]]:
    world = context.scene.world
    return [("world_distance", [world.light_settings.distance if world is not None else 0.0])]


def _attribute(context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    """Attributes of instancers are handled by named_values.asked_of_instancers."""
    if node.attribute_type == "GEOMETRY":
        context.attribute_names.add({"pointiness": ajar.POINTINESS, "random_per_island": ajar.RANDOM_PER_ISLAND}.get(node.attribute_name, node.attribute_name))
        context.uses_generated |= node.attribute_name == "generated"
    elif node.attribute_type == "OBJECT":
        context.object_properties.add(node.attribute_name)
    elif node.attribute_type == "VIEW_LAYER":
        return [("value", list(named_values.of_view_layer(context.view_layer, context.scene, node.attribute_name)))]
    return []


def _color_attribute(context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    """Meshes have all their colours; curves and point clouds only what is asked for."""
    context.attribute_names |= {node.layer_name} - {""}
    return []


def _tangent(context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    """A tangent or a vector displacement: ask for the tangents of its UV map."""
    if getattr(node, "space", "TANGENT") == "TANGENT" and getattr(node, "direction_type", "UV_MAP") == "UV_MAP":
        context.attribute_names.add(ajar.TANGENT_OF + getattr(node, "uv_map", ""))
    return []


def _vector_displacement(context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    return [*_displacement(context, node), *_tangent(context, node)]


def _normal_map(context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    return [*_tangent(context, node), ("generation", compat.normal_map_generation())]


def _aov(_context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    return [("aov_name", compat.aov_name(node))]


def _hair(context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    aspect = node.inputs.get("Aspect Ratio")
    if getattr(node, "model", "") == "HUANG" and aspect is not None and (aspect.is_linked or aspect.default_value != 1.0):
        context.attribute_names.add(CURVE_NORMAL)   # the direction of an axis of the ellipse
    return [("tilt", compat.hair_tilt())]


def _raycast(_context: ExportContext, node: bpy.types.Node) -> list[tuple[str, Content]]:
    """The types of the outputs for attributes at the hit. Their names are in inputs."""
    return [(output.identifier.replace("Attribute_", "attribute_type_"), output.type) for output in node.outputs
            if output.identifier.startswith("Attribute_") and not output.identifier.endswith("_Alpha")]


SPECIAL: dict[str, Callable[[ExportContext, bpy.types.Node], list[tuple[str, Content]]]] = {
    "ShaderNodeOutputAOV": _aov,
    "ShaderNodeValue": _output_value,
    "ShaderNodeRGB": _output_value,
    "ShaderNodeNormal": _output_value,
    "ShaderNodeTexImage": _image,
    "ShaderNodeTexEnvironment": _image,
    "ShaderNodeValToRGB": _ramp,
    "ShaderNodeRGBCurve": _curve,
    "ShaderNodeVectorCurve": _curve,
    "ShaderNodeFloatCurve": _curve,
    "ShaderNodeTexCoord": _object_of_coordinates,
    "ShaderNodeTexIES": _ies,
    "ShaderNodeVectorTransform": _vector_transform,
    "ShaderNodeLightFalloff": _light_falloff,
    "ShaderNodeTexVoronoi": _voronoi,
    "ShaderNodeBsdfDiffuse": _diffuse,
    "ShaderNodeBsdfSheen": _bumped,
    "ShaderNodeBsdfToon": _bumped,
    "ShaderNodeBump": _bumped,
    "ShaderNodeDisplacement": _displacement,
    "ShaderNodeBsdfGlossy": _facets,
    "ShaderNodeBsdfAnisotropic": _facets,
    "ShaderNodeBsdfGlass": _facets,
    "ShaderNodeBsdfRefraction": _facets,
    "ShaderNodeBsdfPrincipled": _principled,
    "ShaderNodeBsdfHairPrincipled": _hair,
    "ShaderNodeSubsurfaceScattering": _subsurface,
    "ShaderNodeNewGeometry": _geometry,
    "ShaderNodeAmbientOcclusion": _distance_of_world,
    "ShaderNodeAttribute": _attribute,
    "ShaderNodeVertexColor": _color_attribute,
    "ShaderNodeRaycast": _raycast,
    "ShaderNodeNormalMap": _normal_map,
    "ShaderNodeTangent": _tangent,
    "ShaderNodeVolumeInfo": _volume_info,
    "ShaderNodeVectorDisplacement": _vector_displacement,
}
