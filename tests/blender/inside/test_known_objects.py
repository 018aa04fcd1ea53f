"""Tests of edits in a viewport: an export that reuses known objects is equal to a full export, and some edits need no walk over the instances."""

import random
import traceback

import bpy
import pytest
from ajar_render.export import ExportContext, KnownObjects, MeshCache, OutOfDate, export_contents, settings
from ajar_render.headless import Options
from mathutils import Vector


class Watcher:
    """Exports after every update as a viewport does, and compares the result with a full export."""

    def __init__(self) -> None:
        self.known, self.meshes = KnownObjects(), MeshCache()
        self.kinds: list[str] = []
        self.differences: list[str] = []
        self.edit, self.revisions = "", 0

    def export(self, depsgraph, known, revisions):
        context = ExportContext(depsgraph, lambda: False, lambda step: None, self.meshes)
        context.known, context.revisions = known, revisions
        settings.export(context, Options(), ["Combined"])
        if revisions is None:
            self.meshes.begin()
        export_contents(context)
        if revisions is None:
            self.meshes.finish()
        return context.description

    def __call__(self, scene, depsgraph) -> None:
        try:
            self.compare(depsgraph)
        except Exception:   # Blender only prints the exceptions of handlers
            self.differences.append(f"{self.edit}: {traceback.format_exc()}")

    def compare(self, depsgraph) -> None:
        self.meshes.forget(depsgraph)
        revisions = self.known.changed(depsgraph)
        description = None
        if revisions is not None:
            try:
                description = self.export(depsgraph, self.known, revisions)
            except (OutOfDate, ReferenceError):
                pass
        self.kinds.append("walk" if description is None else "revision")
        self.revisions += description is not None
        if description is None:
            description = self.export(depsgraph, self.known, None)
        fresh = self.export(depsgraph, None, None)
        if fresh.fingerprint() != description.fingerprint():
            self.differences.append(self.edit)

    def kinds_of(self, name: str, edit) -> list[str]:
        """How the updates that the edit causes were exported."""
        self.edit, self.kinds = name, []
        edit()
        bpy.context.view_layer.update()
        return self.kinds


@pytest.fixture
def watcher(scene):
    watcher = Watcher()
    bpy.app.handlers.depsgraph_update_post.append(watcher)
    yield watcher
    bpy.app.handlers.depsgraph_update_post.remove(watcher)


@pytest.fixture
def stage(build):
    """Single objects, a parent with a child, a collection with three instances, particles, lamps and materials."""
    red, glass = build.material("Red"), build.material("Glass")
    for material in (red, glass):
        node = material.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
        material.node_tree.links.new(node.outputs[0], material.node_tree.nodes[0].inputs[0])
    square = build.mesh()
    square.materials.append(red)
    alone = build.object(square, "Alone")
    build.object(square, "Beside", (2, 0, 0))
    child = build.object(build.mesh("Leaf", ((0, 0, 0), (1, 0, 0), (0, 1, 0)), ((0, 1, 2),)), "Child", (0, 0, 1))
    child.parent = alone
    child.data.materials.append(glass)
    lamp = build.object(bpy.data.lights.new("Lamp", "POINT"), "Lamp", (0, 0, 3))
    lamp.parent = build.object(None, "Holder")
    collection = bpy.data.collections.new("Pair")
    member = bpy.data.objects.new("Member", build.mesh("Tile"))
    collection.objects.link(member)
    collection.objects.link(bpy.data.objects.new("Candle", bpy.data.lights.new("Candle", "POINT")))
    for x in range(3):
        empty = build.object(None, f"Instance {x}", (x, 4, 0))
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
    ground = build.object(build.mesh("Ground"), "Ground", (0, 0, -1))
    particles = ground.modifiers.new("Grass", "PARTICLE_SYSTEM").particle_system.settings
    particles.type, particles.count, particles.render_type, particles.instance_object = "HAIR", 7, "OBJECT", build.object(build.mesh("Blade"), "Blade")
    bpy.context.scene.world = bpy.data.worlds.new("World")
    bpy.context.scene.world.use_nodes = True
    return bpy.data.objects


def diffuse(name: str):
    return bpy.data.materials[name].node_tree.nodes["Diffuse BSDF"]


def test_edits_of_single_objects_need_no_walk(watcher, stage):
    bpy.context.view_layer.update()

    def move(name):
        stage[name].location += Vector((0.1, 0.2, 0.3))

    edits = {
        "object": lambda: move("Beside"), "parent": lambda: move("Alone"), "child": lambda: move("Child"), "lamp": lambda: move("Lamp"),
        "lamp's parent": lambda: move("Holder"), "camera": lambda: move("Camera"),
        "colour": lambda: setattr(diffuse("Red").inputs[0], "default_value", (0.1, 0.2, 0.3, 1)),
        "energy": lambda: setattr(stage["Lamp"].data, "energy", 7), "kind": lambda: setattr(stage["Lamp"].data, "type", "SPOT"),
        "world": lambda: setattr(bpy.context.scene.world.node_tree.nodes["Background"].inputs[1], "default_value", 2),
        "visibility": lambda: setattr(stage["Beside"], "visible_camera", False), "index": lambda: setattr(stage["Beside"], "pass_index", 5),
        "unseen": lambda: [setattr(stage["Child"], f"visible_{kind}", False)
                           for kind in ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow")],
        "seen again": lambda: setattr(stage["Child"], "visible_shadow", True),
    }
    for name, edit in edits.items():
        before = watcher.known.walks
        assert watcher.kinds_of(name, edit) == ["revision"], name
        assert watcher.known.walks == before, name
    assert not watcher.differences


def test_edits_of_hair_are_exported(watcher, stage):
    fur = stage["Beside"].modifiers.new("Fur", "PARTICLE_SYSTEM").particle_system.settings
    fur.type, fur.count = "HAIR", 5
    bpy.context.view_layer.update()
    edits = {
        "emitter": lambda: setattr(stage["Beside"], "location", (1, 1, 1)), "length": lambda: setattr(fur, "hair_length", 1.0),
        "radius": lambda: setattr(fur, "root_radius", 0.3), "count": lambda: setattr(fur, "count", 8), "shown as nothing": lambda: setattr(fur, "render_type", "NONE"),
    }
    for name, edit in edits.items():
        assert watcher.kinds_of(name, edit), name
    assert not watcher.differences


def test_edits_of_instances_or_geometry_need_a_full_walk(watcher, stage):
    bpy.context.view_layer.update()

    def move(name):
        stage[name].location.x += 0.1

    def ask_for_an_attribute():
        nodes, links = bpy.data.materials["Red"].node_tree.nodes, bpy.data.materials["Red"].node_tree.links
        attribute = nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = "Heat"
        links.new(attribute.outputs[0], nodes["Diffuse BSDF"].inputs[0])

    edits = {
        "instancer": lambda: move("Instance 1"), "member": lambda: move("Member"), "candle": lambda: move("Candle"), "emitter": lambda: move("Ground"),
        "blade": lambda: move("Blade"), "geometry": lambda: setattr(stage["Beside"].modifiers.new("Solid", "SOLIDIFY"), "thickness", 0.3),
        "hidden": lambda: setattr(stage["Beside"], "hide_viewport", True), "holdout": lambda: setattr(stage["Alone"], "is_holdout", True),
        "gone": lambda: bpy.data.objects.remove(stage["Child"]), "attribute": ask_for_an_attribute,
        "coordinates": lambda: setattr(stage["Alone"], "instance_type", "VERTS"),
    }
    for name, edit in edits.items():
        assert "walk" in watcher.kinds_of(name, edit), name
    assert not watcher.differences


def test_export_after_random_edits_is_equal_to_a_full_export(watcher, stage, build):
    dice, pair = random.Random(5), bpy.data.collections["Pair"]

    def objects(*kinds):
        return [thing for thing in stage if thing.type in kinds]

    def move():
        for thing in dice.sample(list(stage), dice.choice((1, 1, 2))):
            thing.location = [dice.uniform(-2, 2) for _ in range(3)]

    def flatten():
        dice.choice(list(stage)).scale = (dice.choice((0, 1, -1)), 1, 1)

    def recolour():
        diffuse(dice.choice(("Red", "Glass"))).inputs[0].default_value = [dice.random() for _ in range(4)]

    def shine():
        lamp = dice.choice(list(bpy.data.lights))
        lamp.energy, lamp.type = dice.uniform(0, 9), dice.choice(("POINT", "SUN", "AREA"))

    def look():
        thing = dice.choice(list(stage))
        thing.visible_glossy, thing.color, thing.pass_index = dice.random() < 0.5, [dice.random() for _ in range(4)], dice.randrange(9)
        thing.ajar.importance = dice.choice((1, 2))

    def hide():
        thing = dice.choice(list(stage))
        if dice.random() < 0.5 and thing.name in bpy.context.view_layer.objects:
            thing.hide_set(not thing.hide_get())
        else:
            thing.hide_viewport = not thing.hide_viewport

    def swap_material():
        for thing in dice.sample(objects("MESH"), 1):
            for slot in thing.material_slots:
                slot.link = dice.choice(("DATA", "OBJECT"))
                slot.material = dice.choice((None, *bpy.data.materials))

    def adopt():
        a, b = dice.sample(list(stage), 2)
        if not (a.users_collection == (pair,) or any(thing == a or thing.instance_collection for thing in (b, *_ancestors(b)))):   # no cycles
            a.parent = b

    def deform():
        for mesh in dice.sample(list(bpy.data.meshes), 1):
            mesh.vertices[0].co.z = dice.uniform(-1, 1)
            mesh.update()

    def instance():
        if sum(thing.instance_collection is not None for thing in stage) < 5:
            empty = build.object(None, "More", (dice.uniform(-3, 3), 3, 0))
            empty.instance_type, empty.instance_collection = "COLLECTION", pair

    def join():
        for thing in list(pair.objects)[2:]:
            pair.objects.unlink(thing)
        thing = dice.choice(list(stage))
        if thing.instance_collection is None and thing.parent is None and pair not in thing.users_collection:
            pair.objects.link(thing)

    def replace():
        bpy.data.objects.remove(dice.choice(list(stage)))
        build.object(dice.choice(list(bpy.data.meshes)), "New", (dice.uniform(-2, 2), 0, 0))

    def frame():
        bpy.context.scene.frame_set(bpy.context.scene.frame_current + 1)

    edits = (move, move, move, flatten, recolour, recolour, shine, look, hide, swap_material, adopt, deform, instance, join, replace, frame)
    bpy.context.view_layer.update()
    for number in range(250):
        chosen = dice.sample(edits, dice.choice((1, 1, 2)))   # one update reports several edits
        watcher.kinds_of(f"{number} {' and '.join(edit.__name__ for edit in chosen)}", lambda chosen=chosen: [edit() for edit in chosen])
    assert not watcher.differences
    assert watcher.revisions > 30 and watcher.known.walks > 30


def _ancestors(thing):
    while thing.parent is not None:
        thing = thing.parent
        yield thing
