"""The world: its node graph or its plain colour. A scene without a world is black."""

from __future__ import annotations

import bpy

from .. import compat, plain, unsupported
from ..ajar_module import ajar
from . import node_graph
from .context import ExportContext


def export(context: ExportContext) -> None:
    world = context.world
    if world is None or not context.view_layer.use_sky:
        return
    context.warn_all(world.name, unsupported.asked_of(world, unsupported.WORLD))
    out = context.description.world
    out.name = world.name
    tree = compat.node_tree(world)
    if tree is not None:
        out.graph = node_graph.export(context, tree, world, world.name)
    else:
        out.color = tuple(world.color)
    out.visibility = _visibility(world)
    out.max_bounces = plain.of(world.ajar).max_bounces
    out.light_group = world.lightgroup
    out.light_importance = context.light_importance(world)


def _visibility(world: bpy.types.World) -> int:
    kinds = {"camera": ajar.VISIBLE_CAMERA, "diffuse": ajar.VISIBLE_DIFFUSE, "glossy": ajar.VISIBLE_GLOSSY,
             "transmission": ajar.VISIBLE_TRANSMISSION, "volume_scatter": ajar.VISIBLE_VOLUME_SCATTER}
    return ajar.VISIBLE_SHADOW | sum(bit for name, bit in kinds.items() if getattr(plain.of(world.ajar), f"visible_{name}"))
