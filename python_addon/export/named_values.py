"""Numbers and colours that Attribute nodes read from datablocks by name, with the rules of Cycles.

A custom property of this name has precedence over a property path in Blender's data, such as "color", "pass_index" or "data.auto_smooth_angle".
Texts, lists of more than four items and paths to an item of a list are ignored.
"""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Real
from typing import Any

import bpy

Value = tuple[float, float, float, float]
NOT_FOUND: Value = (0.0, 0.0, 0.0, 0.0)   # what Attribute nodes read of a name that nothing has


def find(owners: Iterable[bpy.types.bpy_struct | None], name: str) -> Value | None:
    """The value of the first owner that has it."""
    for owner in owners:
        value = _of(owner, name) if owner is not None and name else None
        if value is not None:
            return value
    return None


def of_object(thing: bpy.types.Object, name: str) -> Value | None:
    return find((thing, thing.data), name)


def of_view_layer(view_layer: bpy.types.ViewLayer, scene: bpy.types.Scene, name: str) -> Value:
    return find((view_layer, scene, scene.world), name) or NOT_FOUND


def asked_of_instancers() -> frozenset[str]:
    """Names of instancer attributes that materials use. They must be known before the instances are collected."""
    return frozenset(node.attribute_name for node in _shader_nodes()
                     if node.bl_idname == "ShaderNodeAttribute" and node.attribute_type == "INSTANCER")


def origins_are_asked() -> bool:
    """Whether a material uses Particle Info or From Instancer."""
    return any(node.bl_idname == "ShaderNodeParticleInfo" or getattr(node, "from_instancer", False) for node in _shader_nodes())


def _shader_nodes() -> Iterable[bpy.types.Node]:
    for material in bpy.data.materials:
        if material.node_tree is not None:
            yield from material.node_tree.nodes
    for tree in bpy.data.node_groups:
        if tree.bl_idname == "ShaderNodeTree":
            yield from tree.nodes


def _of(owner: bpy.types.bpy_struct, name: str) -> Value | None:
    if name in owner.keys():
        return _as_color(owner[name])
    if name.endswith("]") and not name.endswith(('"]', "']")):
        return None
    try:
        return _as_color(owner.path_resolve(name))
    except ValueError:   # an invalid path
        return None


def _as_color(value: Any) -> Value | None:
    if isinstance(value, Real):   # includes booleans
        return (float(value), float(value), float(value), 1.0)
    try:
        numbers = [*value[:]]
    except (TypeError, AttributeError, KeyError):
        return None
    if not 1 <= len(numbers) <= 4 or not all(isinstance(number, Real) and not isinstance(number, bool) for number in numbers):
        return None
    red, green, blue, alpha = (*map(float, numbers), *(0.0, 0.0, 0.0, 1.0)[len(numbers):])
    return (red, green, blue, alpha)
