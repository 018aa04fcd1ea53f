"""Attributes of the instances that geometry nodes make, for Attribute nodes that read from the instancer.

Blender finds the value of an instance by the layers of its instancing: an instance is in a geometry, which may be in an instance itself. The
innermost layer that has an attribute of the name counts. The persistent identifier of an instance has a number for each layer, the innermost first.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain

import bpy
import numpy as np

from . import attributes, named_values
from .context import ExportContext
from .instance_rows import InstanceRows

CAN_READ = hasattr(bpy.types.Object, "evaluated_geometry")
_NO_LAYER = 2**31 - 1   # in persistent identifiers
_COLOR_OF = {1: lambda v: np.column_stack((v, v, v, np.ones_like(v))), 2: lambda v: np.column_stack((v, np.zeros(len(v)), np.ones(len(v)))),
             3: lambda v: np.column_stack((v, np.ones(len(v)))), 4: lambda v: v}   # by components, as Blender converts attributes to colours


class _Layer:
    """The instances of a geometry."""

    def __init__(self, reader: Reader, geometry: bpy.types.GeometrySet, cloud: bpy.types.PointCloud) -> None:
        self._reader = reader
        self._inner: dict[int, _Layer | _Members | None] = {}   # of references
        self._references = geometry.instance_references()
        self._reference_of = attributes.read(cloud.attributes[".reference_index"])
        self.values = {name: _COLOR_OF[values.shape[1]](values) for name, _, values in attributes.named(cloud, set(reader.names))}
        identifier = cloud.attributes.get("id")
        ids = attributes.read(identifier).tolist() if identifier is not None else range(len(self._reference_of))
        self._number_of: dict[int, int] = {}
        for number, found in enumerate(ids):
            self._number_of.setdefault(found, number)   # Blender gives each further one a random number

    def number_of(self, identifier: int) -> int | None:
        return self._number_of.get(identifier)

    def inner(self, number: int) -> _Layer | _Members | None:
        reference = int(self._reference_of[number])
        if reference not in self._inner:
            self._inner[reference] = self._reader.layer_of(self._references[reference])
        return self._inner[reference]


class _Members:
    """The objects of an instanced collection. They have no values, but their own instances may."""

    def __init__(self, reader: Reader, members: Sequence[bpy.types.Object], numbers_each: int) -> None:
        self.values: dict[str, np.ndarray] = {}
        self._reader, self._members, self._numbers_each = reader, members, numbers_each

    def number_of(self, identifier: int) -> int | None:
        number = identifier // self._numbers_each
        return number if 0 <= number < len(self._members) else None

    def inner(self, number: int) -> _Layer | _Members | None:
        return self._reader.layer_of(self._members[number])


class Reader:
    """Finds the values of instances, with the layers that it has read so far. It has references to evaluated data."""

    def __init__(self, context: ExportContext, names: Sequence[str]) -> None:
        self.names = names
        self._context = context
        self._layers: dict[int, _Layer | _Members | None] = {}   # of objects

    def values_of(self, instance: bpy.types.DepsgraphObjectInstance) -> dict[str, named_values.Value]:
        """The values that layers have for this instance; empty: none has any."""
        layer = self.layer_of(instance.parent)
        found: dict[str, named_values.Value] = {}
        for identifier in reversed([number for number in instance.persistent_id if number != _NO_LAYER]):
            if layer is None:
                break
            number = layer.number_of(identifier)
            if number is None:
                self._context.warn(instance.parent.name, "some instances have the same id; they get the values of the object instead of their own")
                break
            found.update({name: tuple(values[number].tolist()) for name, values in layer.values.items()})
            layer = layer.inner(number)
        particles = instance.particle_system
        if found and particles is not None:   # they have precedence
            found = {name: value for name, value in found.items() if named_values.find((particles.settings,), name) is None}
        return found

    def layer_of(self, source: bpy.types.Object | bpy.types.Collection | bpy.types.GeometrySet) -> _Layer | _Members | None:
        """The outermost layer of instances that it consists of, or None."""
        if isinstance(source, bpy.types.Object):
            key = source.as_pointer()
            if key not in self._layers:
                self._layers[key] = self._of_object(source)
            return self._layers[key]
        if isinstance(source, bpy.types.Collection):
            hidden = "hide_render" if self._context.depsgraph.mode == "RENDER" else "hide_viewport"
            return _Members(self, [member for member in source.all_objects if not getattr(member, hidden)], 2)   # a number for the object, one for its instances
        return self._of_geometry(source)

    def _of_object(self, thing: bpy.types.Object) -> _Layer | _Members | None:
        layer = self._of_geometry(thing.evaluated_geometry()) if any(modifier.type == "NODES" for modifier in thing.modifiers) else None
        if layer is None and thing.instance_type == "COLLECTION" and thing.instance_collection is not None:
            return _Members(self, list(thing.instance_collection.all_objects), 1)
        return layer

    def _of_geometry(self, geometry: bpy.types.GeometrySet) -> _Layer | None:
        cloud = geometry.instances_pointcloud()
        return _Layer(self, geometry, cloud) if cloud is not None else None


class InstanceValues(InstanceRows):
    """The values of each instance that has values of its own: four numbers for each name that materials read from instancers, in order."""

    def add(self, number: int, values: Iterable[named_values.Value]) -> None:
        self.add_row(number, chain.from_iterable(values))

    def export(self, context: ExportContext, shown: np.ndarray) -> None:
        columns = len(context.instancer_properties)
        if (found := self.of_shown(shown, 4 * columns)) is not None:
            context.description.set_instance_values(found[0], columns, found[1])
