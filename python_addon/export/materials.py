"""Materials: their node graphs, or a graph for a material without nodes."""

from __future__ import annotations

import bpy

from .. import compat, plain
from ..ajar_module import ajar
from . import node_graph
from .context import ExportContext

NO_MATERIAL = -1  # the core's default grey


_DISPLACEMENT_METHODS = {"BUMP": ajar.DisplacementMethod.Bump, "DISPLACEMENT": ajar.DisplacementMethod.Displacement, "BOTH": ajar.DisplacementMethod.Both}


def export(context: ExportContext, material: bpy.types.Material | None) -> int:
    """Index of the material."""
    if material is None:
        return _default(context)
    key = material.as_pointer()
    if key not in context.materials:
        tree = compat.node_tree(material)
        if tree is not None:
            graph = node_graph.export(context, tree, material, material.name)
            # An output without links neither reflects nor emits. With a volume only, the surface is invisible.
            if graph.surface.node < 0 and graph.volume.node < 0:
                _diffuse(graph, (0.0, 0.0, 0.0, 1.0))
        else:
            graph = ajar.NodeGraph()
            _diffuse(graph, tuple(material.diffuse_color))
        context.materials[key] = context.description.add_material(name=material.name, graph=graph, pass_index=material.pass_index,
                                                                        displacement_method=_displacement_method(context, material),
                                                                        transparent_shadow=plain.of(compat.transparency_owner(material)).use_transparent_shadow,
                                                                        bump_map_correction=plain.of(material.ajar).use_bump_map_correction)
    return context.materials[key]


def _displacement_method(context: ExportContext, material: bpy.types.Material) -> ajar.DisplacementMethod:
    is_unmoved = material.original.as_pointer() in context.unmoved
    return _DISPLACEMENT_METHODS["BUMP" if is_unmoved else plain.of(compat.displacement_owner(material)).displacement_method]


def export_of_volume(context: ExportContext, material: bpy.types.Material | None) -> int:
    """Index of the material of a volume object. As in Cycles, it is a Principled Volume if there is no material, and nothing is visible if the material has no volume."""
    tree = compat.node_tree(material) if material is not None else None
    output = tree.get_output_node("CYCLES") if tree is not None else None
    if material is not None and output is not None and output.inputs["Volume"].is_linked:
        return export(context, material)
    key = -1 if material is None else -2
    if key not in context.materials:
        graph = ajar.NodeGraph()
        node = graph.add_node("ShaderNodeVolumePrincipled", "Principled Volume")
        graph.add_input(node, "Density", (1.0 if material is None else 0.0, 0.0, 0.0, 0.0))
        graph.add_property(node, "Density Attribute", text="density")
        graph.volume = ajar.NodeLink(node, "Volume")
        context.materials[key] = context.description.add_material(name="Default Volume" if material is None else "No Volume", graph=graph)
    return context.materials[key]


def _default(context: ExportContext) -> int:
    """The default material: grey diffuse, and since Blender 5.0 a Principled BSDF with default values."""
    if not (compat.default_is_principled() or node_graph.keeps_diffuse_normals()):
        return NO_MATERIAL
    if 0 not in context.materials:
        graph = ajar.NodeGraph()
        if compat.default_is_principled():
            node = graph.add_node("ShaderNodeBsdfPrincipled", "Principled BSDF")
            graph.add_input(node, "Specular IOR Level", (0.5, 0.0, 0.0, 0.0))   # the compiler recognizes the version of the node by this socket; the other sockets have defaults
            graph.surface = ajar.NodeLink(node, "BSDF")
        else:
            _diffuse(graph, (0.8, 0.8, 0.8, 1.0))
        context.materials[0] = context.description.add_material(name="default_surface", graph=graph)
    return context.materials[0]


def _diffuse(graph: ajar.NodeGraph, color: tuple[float, ...]) -> None:
    node = graph.add_node("ShaderNodeBsdfDiffuse", "Diffuse BSDF")
    graph.add_input(node, "Color", color)
    graph.add_property(node, "keeps_normal", numbers=[float(node_graph.keeps_diffuse_normals())])
    graph.surface = ajar.NodeLink(node, "BSDF")
