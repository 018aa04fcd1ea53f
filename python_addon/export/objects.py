"""Objects and instances of the dependency graph. Each mesh and each hair system is exported once.

A first loop over the graph collects the instances; then the meshes are exported. Instances of collections, particles and geometry nodes have the same
form: a mesh, a list of materials, and a matrix for each instance. A viewport keeps the collected data. After an edit that allows it
(known_objects.py), only the changed objects are updated.
"""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field

import bpy
import numpy as np

from .. import compat, plain, unsupported
from ..ajar_module import ajar
from ..translations import interface
from . import deformation, instance_values, lights, materials, mesh, motion, named_values, origins, points, smoke, strands, subdivision, volumes
from .context import ExportContext, rows_3x4
from .culling import Culling
from .known_objects import OutOfDate, look_of


@dataclass
class Geometry:
    """Data that instances share. `owner` is a real object; with `is_own`, the geometry is its own datablock."""

    owner: bpy.types.Object
    data: bpy.types.ID | None
    is_own: bool
    materials: list[bpy.types.Material | None]
    look: dict                              # arguments of SceneDescription.add_object other than mesh, materials and properties
    index: int = -1
    is_volume: bool = False
    known_by: tuple | None = None           # with motion blur: motion.identity of an instance that shows it
    is_hair: bool = False                   # the particle hair of the owner instead of its surface
    from_instancer: dict[str, named_values.Value] = field(default_factory=dict)   # properties that materials use
    has_values: bool = False                # some of its instances have values of their own (instance_values.py)
    # Indices in the description:
    material_indices: list[int] = field(default_factory=list)
    mesh_index: int = -1                    # mesh.EMPTY for empty meshes
    shared: ajar.MeshDescription | None = None


@dataclass
class Lamp:
    """An instance of a lamp."""

    owner: bpy.types.Object
    rows: list[float]
    visibility: int
    grouped_with: bpy.types.Object   # the object whose light group it has


class Collected:
    """One entry for each instance, in growing arrays."""

    def __init__(self) -> None:
        self.geometries: dict[tuple[int, int, int], Geometry] = {}
        self.order: list[Geometry] = []
        self.geometry_of = array("i")
        self.rows = array("f")
        self.random = array("f")
        self.origins = origins.Origins()
        self.values = instance_values.InstanceValues()
        self.lamps_in_order: list[Lamp] = []
        # The keys are original objects:
        self.alone: dict[bpy.types.Object, tuple[Geometry, int]] = {}   # objects with a single instance, and the number of this instance
        self.lamps: dict[bpy.types.Object, Lamp] = {}                   # likewise for lamps
        self.shared: dict[bpy.types.Object, tuple] = {}                 # instanced objects and instancers, with their look_of
        self.is_linked = False                                          # whether light linking exists
        self.asked: tuple = ()                                          # attributes that materials use of meshes


def export(context: ExportContext) -> None:
    context.report_step("objects")
    context.instancer_properties = named_values.asked_of_instancers()
    context.uses_origins = named_values.origins_are_asked()
    known = context.known
    if known is not None and known.collected is not None and context.revisions is not None:
        collected, known.collected = known.collected, None   # kept only if the export succeeds
        _revise(context, collected, context.revisions)
        known.revised += len(context.revisions)
    else:
        collected = Collected()
        collected.is_linked = context.linking.exists
        _collect(context, collected)
        _export_lamps(context, collected)
        _export_meshes(context, collected)
        if known is not None:
            known.collected = None
            known.walks += 1
    _add_objects(context, collected)
    _add_instances(context, collected)
    if known is not None:
        known.collected = _lasting(context, collected)


def _collect(context: ExportContext, collected: Collected) -> None:
    """Loop over the instances. There may be a million of them, so that each iteration must be fast."""
    geometries, appearances = collected.geometries, context.appearances
    hairs: dict[tuple[int, int, int], Geometry | None] = {}
    kind_of_parent: dict[int | tuple, int] = {}
    from_instancers: list[dict[str, named_values.Value]] = []   # of each instancer key
    asked_of_instancers, uses_origins = context.instancer_properties, context.uses_origins
    reader = instance_values.Reader(context, sorted(asked_of_instancers)) if asked_of_instancers and instance_values.CAN_READ else None
    of_all: dict[int, dict[str, named_values.Value]] = {}   # of geometries: the values of their instances that have none of their own
    kinds: dict[tuple, int] = {}
    add_geometry, add_row, add_random = collected.geometry_of.append, collected.rows.extend, collected.random.append

    def add(instance: bpy.types.DepsgraphObjectInstance, geometry: Geometry) -> None:
        x, y, z, _ = instance.matrix_world
        add_row((*x, *y, *z))
        add_random(((instance.random_id & 0xFFFFFFFF) if instance.is_instance else name_hash(instance.object.name)) / 0xFFFFFFFF)
        if uses_origins and instance.is_instance:
            collected.origins.add(len(collected.geometry_of), instance, context.scene.frame_current_final)
        if reader is not None and instance.is_instance:
            own = reader.values_of(instance)
            if own:
                geometry.has_values = True
                if geometry.index not in of_all:
                    of_all[geometry.index] = dict(_instancer_properties(context, geometry, geometry.owner))
                collected.values.add(len(collected.geometry_of), [own.get(name, value) for name, value in of_all[geometry.index].items()])
        add_geometry(geometry.index)
        if appearances is not None:
            known_by = motion.identity(instance)
            appearances.append(known_by)
            geometry.known_by = geometry.known_by or known_by

    for number, instance in enumerate(context.depsgraph.object_instances):
        if number % 64 == 0:
            context.check_cancelled()
        shows_self = instance.show_self
        if not shows_self and not instance.show_particles:
            continue
        thing = instance.object
        if context.is_hidden is not None and context.is_hidden(instance):
            continue
        data = thing.data
        if data is None:
            continue
        if instance.is_instance:
            owner, parent = instance.instance_object, instance.parent
            parent_key = parent.as_pointer() if not asked_of_instancers else _instancer_key(instance)
            kind = kind_of_parent.get(parent_key, -1)
            if kind < 0:
                from_instancer = _from_instancer(context, instance) if asked_of_instancers else {}
                shows = (*_shows(context, parent), *from_instancer.items())
                kind = kind_of_parent[parent_key] = kinds.setdefault(shows, len(kinds))
                if kind == len(from_instancers):
                    from_instancers.append(from_instancer)
                collected.shared[parent.original] = look_of(parent.original)
            key = (owner.as_pointer(), data.as_pointer(), kind)
        else:
            owner, parent = thing, None
            key = (owner.as_pointer(), data.as_pointer(), -1)
        # Instances of one object under equal parents differ only in their matrix.
        geometry = geometries.get(key) if shows_self else None
        if geometry is None and shows_self:
            if parent is not None:
                collected.shared[owner.original] = look_of(owner.original)
            if thing.type == "LIGHT":
                lamp = Lamp(owner, rows_3x4(instance.matrix_world), _visibility(context, owner, parent), _grouped_with(owner, parent))
                collected.lamps_in_order.append(lamp)
                if parent is None:
                    collected.lamps[owner.original] = lamp
                continue
            if _has_surface(context, thing, owner):
                geometry = _geometry(context, thing, owner, parent, len(collected.order))
                if parent is not None:
                    geometry.from_instancer = from_instancers[kind]
                geometries[key] = geometry
                collected.order.append(geometry)
                if parent is None:
                    collected.alone[owner.original] = (geometry, len(collected.geometry_of))
        if key not in hairs:
            hairs[key] = hair = _hair(context, thing, owner, parent, collected) if owner.type == "MESH" else None
            if hair is not None and parent is not None:
                hair.from_instancer = from_instancers[kind]
        hair = hairs[key]
        if geometry is not None:
            add(instance, geometry)
        if hair is not None and instance.show_particles:
            add(instance, hair)


def name_hash(name: str) -> int:
    """The random number of a real object as 32 bits: a hash of its name, which is the same as in Cycles.

    The bytes of the name are digits in base 37; the last step of Jenkins' lookup3 (2006) mixes them."""
    key = 0
    for byte in name.encode():
        key = (37 * key + byte) & 0xFFFFFFFF

    def turned(value: int, bits: int) -> int:
        return (value << bits | value >> (32 - bits)) & 0xFFFFFFFF

    start = (0xDEADBEEF + (2 << 2) + 13) & 0xFFFFFFFF
    words = [(start + key) & 0xFFFFFFFF, start, start]   # a, b, c
    for target, source, bits in ((2, 1, 14), (0, 2, 11), (1, 0, 25), (2, 1, 16), (0, 2, 4), (1, 0, 14), (2, 1, 24)):
        words[target] = ((words[target] ^ words[source]) - turned(words[source], bits)) & 0xFFFFFFFF
    return words[2]


def _hair(context: ExportContext, thing: bpy.types.Object, owner: bpy.types.Object, parent: bpy.types.Object | None, collected: Collected) -> Geometry | None:
    """The particle hair of an object."""
    if not strands.systems(context, owner) or not isinstance(thing.data, bpy.types.Mesh):
        return None
    collected.shared[owner.original] = look_of(owner.original)   # each change of the object exports its hair again
    hair = _geometry(context, thing, owner, parent, len(collected.order))
    hair.is_hair, hair.is_volume = True, False
    collected.order.append(hair)
    return hair


def _shows(context: ExportContext, parent: bpy.types.Object) -> tuple:
    """Data that instances have from their instancer."""
    return (_ray_visibility(parent), *context.linking.sets_of(parent), parent.indirect_only_get(view_layer=context.view_layer),
            parent.holdout_get(view_layer=context.view_layer), parent.is_shadow_catcher, parent.lightgroup, tuple(parent.color))


def _instancer_key(instance: bpy.types.DepsgraphObjectInstance) -> tuple:
    particles = instance.particle_system
    return instance.parent.as_pointer(), particles.as_pointer() if particles is not None else 0


def _from_instancer(context: ExportContext, instance: bpy.types.DepsgraphObjectInstance) -> dict[str, named_values.Value]:
    """Values that materials use and that particles or the parent have. The object may have the others."""
    particles, parent = instance.particle_system, instance.parent
    found = {}
    for name in sorted(context.instancer_properties):
        value = named_values.find((particles.settings if particles is not None else None, parent), name)
        if value is not None:
            found[name] = value
        elif not instance_values.CAN_READ and any(modifier.type == "NODES" for modifier in parent.modifiers):
            context.warn(parent.name, 'if its geometry nodes give instances an attribute "{attribute}", it cannot be read', attribute=name)
    return found


def _has_surface(context: ExportContext, thing: bpy.types.Object, owner: bpy.types.Object) -> bool:
    if smoke.domain_of(owner) is not None:
        return context.view_layer.use_volumes
    if not context.view_layer.use_solid and isinstance(thing.data, bpy.types.Mesh):
        return False
    if isinstance(thing.data, bpy.types.Volume):
        return context.view_layer.use_volumes
    # Curves, texts and metaballs are in the graph a second time, as instances of their evaluated mesh.
    return isinstance(thing.data, (bpy.types.Mesh, bpy.types.Curves, bpy.types.PointCloud))


def _geometry(context: ExportContext, thing: bpy.types.Object, owner: bpy.types.Object, parent: bpy.types.Object | None,
              index: int) -> Geometry:
    is_own = owner.data is not None and owner.data.as_pointer() == thing.data.as_pointer()
    return Geometry(owner, thing.data, is_own, _materials(context, thing), _look(context, owner, parent), index,
                    is_volume=isinstance(thing.data, bpy.types.Volume) or smoke.domain_of(owner) is not None)


def _materials(context: ExportContext, thing: bpy.types.Object) -> list[bpy.types.Material | None]:
    override = context.view_layer.material_override
    if override is not None:
        return [override]
    found = [slot.material for slot in thing.material_slots]   # the last slot is used for higher indices
    return found if found or not compat.default_is_principled() else [None]


def _grouped_with(owner: bpy.types.Object, parent: bpy.types.Object | None) -> bpy.types.Object:
    """The object whose light group an object or an instance has: that of its instancer counts if it has none."""
    return owner if parent is None or owner.lightgroup else parent


def _look(context: ExportContext, owner: bpy.types.Object, parent: bpy.types.Object | None) -> dict:
    context.warn_all(owner.name_full, unsupported.of_object(owner))   # of linked objects, it has the library
    group_owner = _grouped_with(owner, parent)
    is_catcher = owner.is_shadow_catcher or (parent is not None and parent.is_shadow_catcher) or owner.original == context.catcher
    return {"name": owner.name, "visibility": _visibility(context, owner, parent),
            "holdout": (parent or owner).holdout_get(view_layer=context.view_layer), "shadow_catcher": is_catcher,
            "pass_index": owner.pass_index, "color": tuple((parent or owner).color), "importance": _importance(context, owner),
            "shadow_terminator_offset": plain.of(compat.terminator_owner(owner)).shadow_terminator_geometry_offset, "light_importance": context.light_importance(group_owner),
            "asset": _topmost(owner).name, "light_group": group_owner.lightgroup, **context.linking.arguments(owner, parent)}


def _topmost(thing: bpy.types.Object) -> bpy.types.Object:
    """The object, or the last of its parents: an asset of Cryptomatte."""
    while thing.parent is not None:
        thing = thing.parent
    return thing


def _visibility(context: ExportContext, owner: bpy.types.Object, parent: bpy.types.Object | None) -> int:
    bits = _ray_visibility(owner)
    if parent is not None:
        bits &= _ray_visibility(parent)
    shown = parent or owner   # instances are in the collections of their instancer
    if shown.indirect_only_get(view_layer=context.view_layer):
        bits &= ~ajar.VISIBLE_CAMERA
    return bits


def _ray_visibility(thing: bpy.types.Object) -> int:
    return ((ajar.VISIBLE_CAMERA if thing.visible_camera else 0) | (ajar.VISIBLE_DIFFUSE if thing.visible_diffuse else 0)
            | (ajar.VISIBLE_GLOSSY if thing.visible_glossy else 0)
            | (ajar.VISIBLE_TRANSMISSION if thing.visible_transmission else 0)
            | (ajar.VISIBLE_VOLUME_SCATTER if thing.visible_volume_scatter else 0)
            | (ajar.VISIBLE_SHADOW if thing.visible_shadow else 0))


def _export_lamps(context: ExportContext, collected: Collected) -> None:
    for lamp in collected.lamps_in_order:
        _export_lamp(context, lamp, lamp.owner, lamp.grouped_with)


def _export_lamp(context: ExportContext, lamp: Lamp, owner: bpy.types.Object, grouped_with: bpy.types.Object) -> None:
    lights.export(context, owner.data, owner.name, lamp.rows, lamp.visibility, context.light_importance(grouped_with), grouped_with.lightgroup,
                  context.linking.masks(owner))


def _export_meshes(context: ExportContext, collected: Collected) -> None:
    """Export every mesh once. Materials are exported first, since they define the needed attributes."""
    for geometry in collected.order:
        context.user = geometry.owner.name
        geometry.material_indices = _material_indices(context, geometry, geometry.materials)
    collected.asked = _asked(context)
    numbers: dict[tuple[int, int], tuple[int, ajar.MeshDescription | None]] = {}
    for number, geometry in enumerate(collected.order):
        context.report_step(interface("mesh {number} of {total}", number=number + 1, total=len(collected.order)))
        context.check_cancelled()
        key = (geometry.data.as_pointer(), geometry.owner.as_pointer() if geometry.is_hair else 0)
        if key not in numbers:
            numbers[key] = _export_mesh(context, geometry)
            if context.watched is not None and numbers[key][0] != mesh.EMPTY:
                geometry.mesh_index = numbers[key][0]
                deformation.watch(context, geometry)
        geometry.mesh_index, geometry.shared = numbers[key]
        if context.mesh_of is not None and _is_alone(collected, geometry):
            context.mesh_of[geometry.owner.original] = geometry.mesh_index


def _is_alone(collected: Collected, geometry: Geometry) -> bool:
    """Whether the geometry is the surface of a real object, and no other one shows its mesh."""
    found = collected.alone.get(geometry.owner.original)
    return found is not None and found[0] is geometry and geometry.mesh_index != mesh.EMPTY and isinstance(geometry.data, bpy.types.Mesh)


def _material_indices(context: ExportContext, geometry: Geometry, found: list[bpy.types.Material | None]) -> list[int]:
    if geometry.is_volume:
        return [materials.export_of_volume(context, material) for material in found or [None]]
    return [materials.export(context, material) for material in found]


def _asked(context: ExportContext) -> tuple:
    return context.uses_generated, frozenset(context.attribute_names), context.instancer_properties, context.uses_origins


def _add_objects(context: ExportContext, collected: Collected) -> None:
    """Set `Geometry.index` to the index of the object, or to mesh.EMPTY."""
    for geometry in collected.order:
        if geometry.mesh_index == mesh.EMPTY or geometry.look["visibility"] == 0:
            geometry.index = mesh.EMPTY
            continue
        geometry.index = context.description.add_object(mesh=geometry.mesh_index, materials=geometry.material_indices,
                                                        properties=_properties(context, geometry), **geometry.look)


def _properties(context: ExportContext, geometry: Geometry) -> list[tuple[str, bool, named_values.Value, int]]:
    """Properties that materials use and that the object or its instancer has, and their columns in the values of instances."""
    if not context.object_properties and not context.instancer_properties:
        return []
    owner = geometry.owner if context.revisions is None else geometry.owner.evaluated_get(context.depsgraph)
    of_objects = [(name, geometry.look["color"] if name == "color" and name not in owner.keys() else named_values.of_object(owner, name))
                  for name in sorted(context.object_properties)]
    found = [(name, False, value, -1) for name, value in of_objects if value is not None]
    for column, (name, value) in enumerate(_instancer_properties(context, geometry, owner)):
        if geometry.has_values or value is not named_values.NOT_FOUND:
            found.append((name, True, value, column if geometry.has_values else -1))
    return found


def _instancer_properties(context: ExportContext, geometry: Geometry, owner: bpy.types.Object) -> list[tuple[str, named_values.Value]]:
    """For each name that materials read from instancers, in order, the value of the instances that have none of their own."""
    return [(name, geometry.from_instancer.get(name) or named_values.of_object(owner, name) or named_values.NOT_FOUND)
            for name in sorted(context.instancer_properties)]


def _lasting(context: ExportContext, collected: Collected) -> Collected | None:
    """A copy without evaluated data, or None if that is not possible."""
    if context.is_hidden is not None:
        return None
    if context.revisions is not None:
        return collected
    for geometry in collected.order:
        geometry.owner, geometry.data = geometry.owner.original, None
        geometry.materials = [material.original if material is not None else None for material in geometry.materials]
    for lamp in collected.lamps_in_order:
        lamp.owner, lamp.grouped_with = lamp.owner.original, lamp.grouped_with.original
    collected.geometries = {}
    return collected


def _revise(context: ExportContext, collected: Collected, changed: list[bpy.types.Object]) -> None:
    """Update collected data. Only these objects, materials and lights have changed."""
    depsgraph = context.depsgraph
    for original in changed:
        thing = original.evaluated_get(depsgraph)
        if thing.type == "LIGHT":
            lamp = collected.lamps[original]
            lamp.rows, lamp.visibility = rows_3x4(thing.matrix_world), _visibility(context, thing, None)
            continue
        geometry, number = collected.alone[original]
        geometry.look = _look(context, thing, None)
        geometry.materials = [material.original if material is not None else None for material in _materials(context, thing)]
        collected.rows[12 * number:12 * number + 12] = array("f", rows_3x4(thing.matrix_world))
        collected.random[number] = name_hash(thing.name) / 0xFFFFFFFF
    for lamp in collected.lamps_in_order:
        _export_lamp(context, lamp, lamp.owner.evaluated_get(depsgraph), lamp.grouped_with.evaluated_get(depsgraph))
    for geometry in collected.order:
        context.user = geometry.owner.name
        geometry.material_indices = _material_indices(context, geometry, [material.evaluated_get(depsgraph) if material is not None else None
                                                                          for material in geometry.materials])
    if _asked(context) != collected.asked:
        raise OutOfDate
    numbers: dict[int, int] = {}
    for geometry in collected.order:
        if geometry.shared is None:
            continue
        key = id(geometry.shared)
        if key not in numbers:
            numbers[key] = context.description.add_shared_mesh(geometry.shared)
        geometry.mesh_index = numbers[key]


def _factors_of_collections(context: ExportContext) -> dict[int, float]:
    """Importance of objects by their collections, where it is not 1. A query of the collections of each object would take a time proportional to the
    number of collections."""
    if context.importance_of_collections is not None:
        return context.importance_of_collections
    factors: dict[int, float] = {}
    for collection in (*bpy.data.collections, *(scene.collection for scene in bpy.data.scenes)):
        if collection.ajar.importance != 1.0:
            for thing in collection.objects:
                factors[thing.as_pointer()] = factors.get(thing.as_pointer(), 1.0) * collection.ajar.importance
    context.importance_of_collections = factors
    return factors


def _importance(context: ExportContext, owner: bpy.types.Object) -> float:
    """The importance of the object times that of each of its collections."""
    original, factors = owner.original, _factors_of_collections(context)
    return original.ajar.importance * (factors.get(original.as_pointer(), 1.0) if factors else 1.0)


def _export_mesh(context: ExportContext, geometry: Geometry) -> tuple[int, ajar.MeshDescription | None]:
    """The index of the mesh in the description, and the mesh itself if it may be used again."""
    description, cache = context.description, context.meshes
    if geometry.is_volume:
        return _export_volume(context, geometry)
    is_surface = isinstance(geometry.data, bpy.types.Mesh) and not geometry.is_hair
    if is_surface and geometry.is_own and not geometry.data.is_editmode and subdivision.wanted(context, geometry.owner) is not None:
        return _export_faces(context, geometry)
    if cache is None:
        kind, found = _shape(context, geometry)
        return (getattr(description, f"add_{kind}")(**found) if found is not None else mesh.EMPTY), None
    key = cache.key(context, geometry.owner, geometry.data, geometry.is_hair)
    if key not in cache.known:
        kind, found = _shape(context, geometry)
        cache.known[key] = getattr(ajar, f"make_{kind}")(**found) if found is not None else None
        cache.exported += 1
    shared = cache.known[key]
    return (description.add_shared_mesh(shared) if shared is not None else mesh.EMPTY), shared


def _export_faces(context: ExportContext, geometry: Geometry) -> tuple[int, ajar.MeshDescription | None]:
    """Like _export_mesh, for adaptive subdivision."""
    cache = context.meshes
    key = (*cache.key(context, geometry.owner, geometry.data), subdivision.signature(context, geometry.owner)) if cache is not None else ()
    shared = cache.known.get(key) if cache is not None else None
    if shared is None:
        shared = subdivision.export(context, geometry.owner, geometry.data)
        if cache is not None:
            cache.known[key] = shared
            cache.exported += 1
    return (context.description.add_shared_mesh(shared) if shared is not None else mesh.EMPTY), shared


def _export_volume(context: ExportContext, geometry: Geometry) -> tuple[int, ajar.MeshDescription | None]:
    """Like _export_mesh. Volumes that cannot be read are not kept, so that each export reports them."""
    cache, found = context.meshes, None
    if cache is not None:
        key = (*cache.key(context, geometry.owner, geometry.data), motion.of_shutter(context, geometry.owner))
        found = cache.known.get(key)
    if found is None:
        make = volumes.make if isinstance(geometry.data, bpy.types.Volume) else smoke.make
        found = make(context, geometry.owner, geometry.data)
        if cache is not None:
            cache.known[key] = found
            cache.exported += 1
    return (context.description.add_shared_mesh(found) if found is not None else mesh.EMPTY), found


def _shape(context: ExportContext, geometry: Geometry) -> tuple[str, dict | None]:
    """The kind of geometry (mesh, strands or points), and the arguments of ajar.make_mesh, make_strands or make_points; None if it is empty."""
    data = geometry.data
    if geometry.is_hair:
        return "strands", strands.of_particles(context, geometry.owner, data)
    if isinstance(data, bpy.types.Mesh):
        return "mesh", _arrays(context, geometry)
    if isinstance(data, bpy.types.PointCloud):
        return "points", points.of_cloud(context, data, geometry.owner.name)
    return "strands", strands.of_curves(context, data, geometry.owner.name)


def _arrays(context: ExportContext, geometry: Geometry) -> dict | None:
    data = geometry.data
    if not (data.is_editmode and geometry.is_own):
        return mesh.arrays(context, data, data.name, geometry.is_own and mesh.is_shaped(geometry.owner))
    # In edit mode, the evaluated mesh does not have all its layers.
    try:
        return mesh.arrays(context, geometry.owner.to_mesh(), data.name, mesh.is_shaped(geometry.owner))
    finally:
        geometry.owner.to_mesh_clear()


def _add_instances(context: ExportContext, collected: Collected) -> None:
    context.report_step("instances")
    if not collected.order:
        return
    object_index = np.array([geometry.index for geometry in collected.order], dtype=np.int32)
    objects = object_index[np.frombuffer(collected.geometry_of, dtype=np.int32)] if len(collected.geometry_of) else object_index[:0]
    shown = objects != mesh.EMPTY
    rows = np.frombuffer(collected.rows, dtype=np.float32).reshape(-1, 12)
    culling = Culling(context)
    if culling.exists:
        geometry_of = np.frombuffer(collected.geometry_of, dtype=np.int32)
        for number, geometry in enumerate(collected.order):
            own = np.flatnonzero(shown & (geometry_of == number))
            shown[own] = culling.stays(geometry.owner, rows[own])
    random = np.frombuffer(collected.random, dtype=np.float32)
    context.description.add_instances(objects[shown], rows[shown], random[shown])
    collected.origins.export(context, shown)
    collected.values.export(context, shown)
    if context.appearances is not None:
        context.appearances = [context.appearances[i] for i in np.flatnonzero(shown)]
