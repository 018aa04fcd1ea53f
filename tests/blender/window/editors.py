"""Lists what the editors other than Properties offer with Cycles and with Ajar: headers, sidebars, menus and operators; the node trees of new
materials, worlds and lamps; materials that are dropped on objects.

Argument: folder for images. The result has, for each editor and engine, what headers, panels and menus draw, and the operators that can be called.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import bpy
import window

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "panels"))
import recorder

ENGINES = ("CYCLES", "AJAR")
NODES = ("ShaderNodeBsdfPrincipled", "ShaderNodeTexImage", "ShaderNodeTexNoise", "ShaderNodeOutputMaterial")


class Words(recorder.Notes):
    """Records properties, buttons and menus."""

    def _part(self) -> Words:
        return Words(self._shown)

    def _button(self, operator: str) -> Button:
        return Button(operator, self._shown)

    def _note(self, name: str, arguments: tuple, named: dict) -> None:
        super()._note(name, arguments, named)
        if name in ("operator", "menu", "menu_contents", "popover", "operator_menu_enum", "operator_enum"):
            self._shown.add((name, str(arguments[0] if arguments else next(iter(named.values())))))


class Button(recorder.OperatorProperties):
    def __init__(self, operator: str, shown: set[recorder.Shown]) -> None:
        super().__init__(operator)
        self.__dict__["operator"], self.__dict__["shown"] = operator, shown

    def __setattr__(self, name: str, value: object) -> None:
        super().__setattr__(name, value)
        self.shown.add((self.operator, f"{name} = {value}"))

    def __getattr__(self, name: str) -> object:
        """The object to which a button adds items of a collection of its operator, for example the settings of a new node."""
        return Items() if name in self.known else super().__getattribute__(name)


class Items:
    def add(self) -> Items:
        return self


def classes(base: type) -> Iterator[type]:
    for kind in base.__subclasses__():
        if getattr(kind, "is_registered", False):
            yield kind
        yield from classes(kind)


def is_shown(kind: type) -> bool:
    """Whether the poll functions of the panel and of its parents permit it here."""
    parent = getattr(bpy.types, getattr(kind, "bl_parent_id", ""), None)
    return (parent is None or is_shown(parent)) and (not hasattr(kind, "poll") or bool(kind.poll(bpy.context)))


def drawn(kind: type) -> list[recorder.Shown]:
    """What a header, a panel or a menu draws here, or its error if it cannot be drawn here."""
    shown: set[recorder.Shown] = set()
    try:
        if not is_shown(kind):
            return []
        for part in ("draw_header", "draw"):
            if hasattr(kind, part):
                getattr(kind, part)(recorder.Self(kind, Words(shown)), bpy.context)
    except Exception as error:   # the test fails if it differs between the engines
        shown.add(("error", f"{type(error).__name__}: {error}"))
    return sorted(shown)


def seen(space: str) -> dict[str, list[recorder.Shown]]:
    """The contents of each header, panel and menu that shows something in the present context, by its name."""
    kinds = [kind for base in (bpy.types.Header, bpy.types.Panel) for kind in classes(base) if getattr(kind, "bl_space_type", "") == space and space != "PROPERTIES"]
    found = {kind.__name__: drawn(kind) for kind in (*kinds, *classes(bpy.types.Menu))}
    return {name: shown for name, shown in found.items() if shown}


def callable_operators() -> list[str]:
    """The operators that the search for operators lists: their poll functions permit them here."""
    found = []
    for category in dir(bpy.ops):
        for name in dir(getattr(bpy.ops, category)):
            if getattr(getattr(bpy.ops, category), name).poll():
                found.append(f"{category}.{name}")
    return found


def tree_of(tree: bpy.types.NodeTree | None) -> dict | None:
    """All the data of a tree that affects the image."""
    if tree is None:
        return None

    def plain(value: object) -> object:
        return [round(number, 6) for number in value] if hasattr(value, "__len__") and not isinstance(value, str) else value
    return {"nodes": sorted([node.bl_idname, node.name, [[socket.identifier, plain(socket.default_value)] for socket in node.inputs if hasattr(socket, "default_value")]] for node in tree.nodes),
            "links": sorted([link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier] for link in tree.links)}


def region(area: bpy.types.Area, kind: str = "WINDOW") -> bpy.types.Region:
    return next(region for region in area.regions if region.type == kind)


def activate(thing: bpy.types.Object) -> None:
    for other in bpy.context.view_layer.objects:
        other.select_set(other == thing)
    bpy.context.view_layer.objects.active = thing


def use_nodes(owner: bpy.types.ID, engine: str) -> None:
    """Switches nodes on as the button of the panel does."""
    kinds = {"material": bpy.types.Material, "world": bpy.types.World, "light": bpy.types.Light}
    with bpy.context.temp_override(**{name: owner if isinstance(owner, kind) else None for name, kind in kinds.items()}):
        if engine == "CYCLES" and bpy.ops.cycles.use_shading_nodes.poll():   # newer Blenders have the button only for lamps
            bpy.ops.cycles.use_shading_nodes()
        else:
            owner.use_nodes = True


def made(engine: str) -> dict[str, dict | None]:
    """The node trees of new datablocks."""
    found: dict[str, dict | None] = {}
    thing = bpy.data.objects.new("new", bpy.data.meshes.new("new"))
    bpy.context.scene.collection.objects.link(thing)
    activate(thing)
    bpy.ops.object.material_slot_add()
    with bpy.context.temp_override(object=thing, material_slot=thing.material_slots[0]):
        before = set(bpy.data.materials)
        bpy.ops.material.new()
        found["material.new"] = tree_of(next(iter(set(bpy.data.materials) - before)).node_tree)
    before = set(bpy.data.worlds)
    bpy.ops.world.new()
    found["world.new"] = tree_of(next(iter(set(bpy.data.worlds) - before)).node_tree)
    for kind in ("POINT", "SUN", "SPOT", "AREA"):
        bpy.ops.object.light_add(type=kind)
        light = bpy.context.object.data
        found[f"{kind} lamp"] = tree_of(light.node_tree)
        use_nodes(light, engine)
        found[f"{kind} lamp with nodes"] = tree_of(light.node_tree)
        bpy.data.objects.remove(bpy.context.object)
    world = bpy.data.worlds.new("plain")
    world.color = (0.1, 0.2, 0.3)
    use_nodes(world, engine)
    found["world with nodes"] = tree_of(world.node_tree)
    material = bpy.data.materials.new("plain")
    material.diffuse_color = (0.1, 0.2, 0.3, 1.0)
    use_nodes(material, engine)
    found["material with nodes"] = tree_of(material.node_tree)
    bpy.data.objects.remove(thing)
    return found


def library(folder: str) -> str:
    """A file with a material as an asset."""
    material = bpy.data.materials.new("Asset")
    material.use_nodes = True
    material.asset_mark()
    path = os.path.join(folder, "library.blend")
    bpy.data.libraries.write(path, {material}, fake_user=True)
    bpy.data.materials.remove(material)
    return path


def dropped(cube: bpy.types.Object, name: str):
    """Steps: moves the mouse to the object in the 3D view and drops the material there. Returns the materials in the slots of the object."""
    cube.data.materials.clear()
    x, y = window.place_of(cube.matrix_world.translation)
    window.event("MOUSEMOVE", "NOTHING", x, y)
    yield 0.3
    with window.override():
        bpy.ops.object.drop_named_material("INVOKE_DEFAULT", name=name)
    yield 0.1
    return [slot.material.name if slot.material is not None else "" for slot in cube.material_slots]


def editors(area: bpy.types.Area) -> Iterator[tuple[str, str]]:
    """Tuples (name, type of space); the area has this type when the tuple is yielded."""
    scene = bpy.context.scene
    cube, lamp, camera = (scene.objects[name] for name in ("Cube", "Light", "Camera"))
    for name, thing in (("mesh", cube), ("lamp", lamp), ("camera", camera)):
        area.type = "VIEW_3D"
        activate(thing)
        yield f"3D view, {name}", "VIEW_3D"
    area.spaces.active.shading.type = "RENDERED"
    yield "3D view, rendered", "VIEW_3D"
    area.spaces.active.shading.type = "SOLID"
    area.ui_type = "ShaderNodeTree"
    area.spaces.active.show_region_ui = True
    activate(cube)
    nodes = cube.active_material.node_tree.nodes
    for type_ in NODES:
        node = next((node for node in nodes if node.bl_idname == type_), None) or nodes.new(type_)
        for other in nodes:
            other.select = other == node
        nodes.active = node
        yield f"shader editor, {type_.removeprefix('ShaderNode')}", "NODE_EDITOR"
    activate(lamp)
    yield "shader editor, lamp", "NODE_EDITOR"
    area.spaces.active.shader_type = "WORLD"
    scene.world.node_tree.nodes.active = scene.world.node_tree.nodes[0]
    yield "shader editor, world", "NODE_EDITOR"
    area.spaces.active.shader_type = "OBJECT"
    for type_ in ("OUTLINER", "IMAGE_EDITOR", "PROPERTIES"):
        area.type = type_
        activate(cube)
        yield type_.replace("_", " ").lower(), type_
    area.type = "VIEW_3D"


def paused(area: bpy.types.Area):
    """Steps: pauses the rendered view of Ajar, edits the scene and continues. Returns the samples at the pause and a second later, whether the edit
    is shown, and whether the render continues."""
    from ajar_render import viewport

    views: list[viewport.Viewport] = []
    make = viewport.Viewport.__init__
    viewport.Viewport.__init__ = lambda self: (make(self), views.append(self))[0]
    bpy.context.scene.ajar.viewport_samples = 1_000_000
    area.spaces.active.shading.type = "RENDERED"

    def progress():
        return views[-1].session.progress()

    def until(holds):
        for _ in range(600):
            if holds():
                return True
            yield 0.1
        return False
    yield from until(lambda: views and views[-1]._divider == 1 and progress().samples >= 2)
    with window.override():
        bpy.ops.ajar.pause_views()
    yield 1.0
    found = {"at_pause": progress().samples, "render": progress().render}
    yield 1.0
    found |= {"later": progress().samples, "status": views[-1].status(), "busy": views[-1].is_busy()}
    bpy.context.scene.objects["Light"].data.energy *= 2.0
    found["edit_is_shown"] = yield from until(lambda: views[-1]._divider == 1 and progress().render > found["render"] and progress().samples >= 1 and views[-1].session.is_paused())
    yield 1.0
    found["after_edit"] = progress().samples
    with window.override():
        bpy.ops.ajar.pause_views()
    found["goes_on"] = yield from until(lambda: progress().samples > found["after_edit"] + 1)
    area.spaces.active.shading.type = "SOLID"
    viewport.Viewport.__init__ = make
    return found


def steps(arguments, result):
    folder, = arguments
    scene = bpy.context.scene
    scene.cycles.preview_samples = scene.ajar.viewport_samples = 1
    window.event("MOUSEMOVE", "NOTHING", 400, 300)   # some operators use the position of the mouse
    scene.objects["Light"].data.use_nodes = True
    area = window.area()
    path = library(folder)
    result["editors"], result["made"], result["dropped"] = {}, {}, {}
    for engine in ENGINES:
        scene.render.engine = engine
        yield 0.5
        for name, space in editors(area):
            yield 0.3
            with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=area, region=region(area)):
                assert bpy.context.engine == engine
                result["editors"].setdefault(name, {})[engine] = {"seen": seen(space), "operators": callable_operators()}
            if space == "NODE_EDITOR":
                window.screenshot_of_area(os.path.join(folder, f"{engine.lower()} {name}.png"), area)
        yield 0.2
        with window.override():
            result["made"][engine] = made(engine)
            bpy.ops.wm.append(directory=f"{path}/Material/", filename="Asset")
        plain = bpy.data.materials.new("Dropped")
        cube = scene.objects["Cube"]
        result["dropped"][engine] = [(yield from dropped(cube, plain.name)), (yield from dropped(cube, "Asset"))]
        cube.data.materials.clear()
        cube.data.materials.append(bpy.data.materials["Material"])
        for name in ("Dropped", "Asset"):
            bpy.data.materials.remove(bpy.data.materials[name])
    result["paused"] = yield from paused(area)
