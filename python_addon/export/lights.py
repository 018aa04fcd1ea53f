"""Lamps. Their matrix and energy are exported unchanged; the core interprets them as Cycles does."""

from __future__ import annotations

import bpy

from .. import compat, plain
from ..ajar_module import ajar
from . import node_graph
from .context import ExportContext


def export(context: ExportContext, light: bpy.types.Light, name: str, rows: list[float], visibility: int,
           light_importance: float, light_group: str, links: dict[str, int]) -> None:
    """Export one lamp. Instances of a lamp are lamps."""
    if light.type == "AREA" and plain.of(light.ajar).is_portal:
        return  # a portal only guides how Cycles samples the world
    out = ajar.LightDescription()
    out.name = name
    out.world_from_light = rows
    out.color = compat.light_color(light)
    out.energy = compat.light_energy(light)
    out.visibility = visibility
    out.light_importance = light_importance
    for kind, sets in links.items():
        setattr(out, kind, sets)
    out.light_group = light_group
    out.cast_shadow = compat.casts_shadow(light)
    out.max_bounces = plain.of(light.ajar).max_bounces
    out.multiple_importance = light.ajar.use_multiple_importance_sampling
    out.has_uv = compat.lamps_have_uv()
    out.own_coordinates = compat.lamps_have_coordinates()
    _KINDS[light.type](out, light)
    tree = compat.node_tree(light)
    if tree is not None:
        out.graph = _graph(context, tree, light)
    hidden = [kind for bit, kind in _SEEN_BY if not visibility & bit]
    if 0 < len(hidden) < len(_SEEN_BY):
        context.warn(name, "it is invisible to some rays ({kinds}), but where it is sampled directly, it illuminates surfaces that scatter such rays", kinds=", ".join(hidden))
    context.description.add_light(out)


def _point(out: ajar.LightDescription, light: bpy.types.PointLight) -> None:
    out.kind = ajar.LightKind.Point
    out.radius = light.shadow_soft_size
    out.soft_falloff = compat.has_soft_falloff(light)


def _spot(out: ajar.LightDescription, light: bpy.types.SpotLight) -> None:
    out.kind = ajar.LightKind.Spot
    out.radius = light.shadow_soft_size
    out.soft_falloff = compat.has_soft_falloff(light)
    out.even_spot = compat.spots_are_even()
    out.spot_angle = light.spot_size
    out.spot_blend = light.spot_blend


def _sun(out: ajar.LightDescription, light: bpy.types.SunLight) -> None:
    out.kind = ajar.LightKind.Sun
    out.sun_angle = light.angle
    out.even_sun = compat.suns_are_even()


def _area(out: ajar.LightDescription, light: bpy.types.AreaLight) -> None:
    out.kind = ajar.LightKind.Area
    round_shape = light.shape in ("DISK", "ELLIPSE")
    out.area_shape = ajar.AreaShape.Ellipse if round_shape else ajar.AreaShape.Rectangle
    two_sizes = light.shape in ("RECTANGLE", "ELLIPSE")
    out.area_size = (light.size, light.size_y if two_sizes else light.size)
    out.spread = light.spread


_SEEN_BY = ((ajar.VISIBLE_DIFFUSE, "diffuse"), (ajar.VISIBLE_GLOSSY, "glossy"), (ajar.VISIBLE_TRANSMISSION, "transmission"))
_KINDS = {"POINT": _point, "SPOT": _spot, "SUN": _sun, "AREA": _area}


def _graph(context: ExportContext, tree: bpy.types.NodeTree, light: bpy.types.Light) -> ajar.NodeGraph:
    graph = node_graph.export(context, tree, light, light.name)
    if graph.surface.node < 0:  # nothing is linked, so that the lamp is dark
        node = graph.add_node("ShaderNodeEmission", "Emission")
        graph.add_input(node, "Strength", (0.0, 0.0, 0.0, 0.0))
        graph.surface = ajar.NodeLink(node, "Emission")
    return graph
