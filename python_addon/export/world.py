"""The world: its node graph, or its plain colour. No world is black."""

from __future__ import annotations

from ..ajar_module import ajar
from . import node_graph
from .context import ExportContext


def export(context: ExportContext) -> None:
    world = context.scene.world
    if world is None:
        return
    out = context.description.world
    out.name = world.name
    if world.use_nodes and world.node_tree is not None:
        out.graph = node_graph.export(context, world.node_tree, world.name)
    else:
        out.color = tuple(world.color)
    out.visibility = _visibility(world)


def _visibility(world) -> int:
    flags = getattr(world, "cycles_visibility", None)
    if flags is None:
        return ajar.VISIBLE_ALL
    kinds = {"camera": ajar.VISIBLE_CAMERA, "diffuse": ajar.VISIBLE_DIFFUSE, "glossy": ajar.VISIBLE_GLOSSY,
             "transmission": ajar.VISIBLE_TRANSMISSION, "scatter": ajar.VISIBLE_VOLUME_SCATTER}
    return ajar.VISIBLE_SHADOW | sum(bit for name, bit in kinds.items() if getattr(flags, name, True))
