"""Light linking and shadow linking of Blender 4 and later, as sets of objects.

The collections of all emitters divide the objects into sets: two objects are in the same set if every collection says the same of both. The core gets the
set of each object, and of each emitter the sets that it lights and that cast shadows of its light. As in Cycles, an object that is included makes all objects
that are not listed excluded; the state of a collection within the collection applies to everything below it; an object that is listed itself overrides
collections; and a collection without objects has no effect.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import bpy

from .. import compat
from ..ajar_module import ajar

_RECEIVERS, _BLOCKERS = "receiver_collection", "blocker_collection"
_LIMITS = {_RECEIVERS: ajar.RECEIVER_SETS, _BLOCKERS: ajar.BLOCKER_SETS}
_ALL = {_RECEIVERS: 2**64 - 1, _BLOCKERS: 2**32 - 1}
Warn = Callable[..., None]


class _Partition:
    """The sets of one kind of linking."""

    def __init__(self, kind: str, emitters: list[bpy.types.Object], warn: Warn) -> None:
        self.kind = kind
        self.collections: list[bpy.types.Collection] = []      # different ones that are not empty
        states: list[dict[bpy.types.Object, bool]] = []        # of the listed objects: whether they are included
        for emitter in emitters:
            collection = getattr(compat.light_linking(emitter), kind)
            if collection is None or collection in self.collections:
                continue
            listed = dict(_listed(collection))
            if not listed:
                if kind == _RECEIVERS:
                    warn(emitter.name, "its collection {collection} for light linking is empty, so that it lights all objects", collection=collection.name)
                else:
                    warn(emitter.name, "its collection {collection} for shadow linking is empty, so that all objects block its light", collection=collection.name)
                continue
            self.collections.append(collection)
            states.append(listed)
        only_included = [any(listed.values()) for listed in states]
        # Of objects that are not listed anywhere, and set 0.
        self.signatures: list[tuple[bool, ...]] = [tuple(not only for only in only_included)]
        self.set_of: dict[bpy.types.Object, int] = {}
        for thing in {thing: None for listed in states for thing in listed}:
            signature = tuple(listed.get(thing, not only) for listed, only in zip(states, only_included))
            if signature not in self.signatures:
                if len(self.signatures) == _LIMITS[kind]:
                    if kind == _RECEIVERS:
                        warn(thing.name, "light linking divides the objects of the scene into more than {number} sets: it is treated like objects that are not listed", number=_LIMITS[kind])
                    else:
                        warn(thing.name, "shadow linking divides the objects of the scene into more than {number} sets: it is treated like objects that are not listed", number=_LIMITS[kind])
                    continue
                self.signatures.append(signature)
            self.set_of[thing] = self.signatures.index(signature)

    def mask(self, emitter: bpy.types.Object) -> int:
        collection = getattr(compat.light_linking(emitter), self.kind)
        if collection not in self.collections:
            return _ALL[self.kind]
        number = self.collections.index(collection)
        return sum(1 << i for i, signature in enumerate(self.signatures) if signature[number])


class Linking:
    """The links of all emitters in the file."""

    def __init__(self, warn: Warn) -> None:
        emitters = [thing for thing in bpy.data.objects if is_linked(thing)]
        self.exists = bool(emitters)
        if self.exists:
            self._receivers, self._blockers = (_Partition(kind, emitters, warn) for kind in (_RECEIVERS, _BLOCKERS))

    def sets_of(self, *things: bpy.types.Object) -> tuple[int, int]:
        """The receiver set and the blocker set of the first object that is listed."""
        if not self.exists:
            return 0, 0
        originals = [thing.original for thing in things]
        receiver, blocker = (next((partition.set_of[thing] for thing in originals if thing in partition.set_of), 0)
                             for partition in (self._receivers, self._blockers))
        return receiver, blocker

    def arguments(self, owner: bpy.types.Object, parent: bpy.types.Object | None) -> dict[str, int]:
        """Of SceneDescription.add_object. An instance that is not listed itself is in the sets of its instancer."""
        if not self.exists:
            return {}
        receiver, blocker = self.sets_of(owner) if parent is None else self.sets_of(owner, parent)
        return {"receiver_set": receiver, "blocker_set": blocker} | self.masks(owner)

    def masks(self, emitter: bpy.types.Object) -> dict[str, int]:
        """The sets that an emitter lights, and those that block its light."""
        original = emitter.original
        if not self.exists or not is_linked(original):
            return {}
        return {"receivers": self._receivers.mask(original), "blockers": self._blockers.mask(original)}


def is_linked(thing: bpy.types.Object) -> bool:
    links = compat.light_linking(thing)
    return links is not None and (links.receiver_collection is not None or links.blocker_collection is not None)


def _listed(collection: bpy.types.Collection) -> Iterator[tuple[bpy.types.Object, bool]]:
    """Objects and whether they are included. Later entries override earlier ones."""
    for child, entry in zip(collection.children, collection.collection_children):
        for thing in child.all_objects:
            yield thing, entry.light_linking.link_state == "INCLUDE"
    for thing, entry in zip(collection.objects, collection.collection_objects):
        yield thing, entry.light_linking.link_state == "INCLUDE"
