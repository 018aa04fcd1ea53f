"""Lists what each tab of Properties shows with Cycles and with Ajar, for every kind of object. Runs inside a Blender with Ajar.

    blender -b --factory-startup --addons ajar_render --python compare.py -- OUT.json
"""

from __future__ import annotations

import argparse
import json
import sys
import types
from pathlib import Path

import bpy
import gpu

sys.path.insert(0, str(Path(__file__).parent))
import recorder

PANORAMAS = ("EQUIRECTANGULAR", "FISHEYE_EQUIDISTANT", "FISHEYE_EQUISOLID", "MIRRORBALL", "FISHEYE_LENS_POLYNOMIAL")


def objects() -> dict[str, bpy.types.Object]:
    """One object of each kind, including each kind of lamp and camera."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    things: dict[str, bpy.types.Object] = {}

    def link(name: str, data: bpy.types.ID | None) -> bpy.types.Object:
        things[name] = thing = bpy.data.objects.new(name, data)
        bpy.context.scene.collection.objects.link(thing)
        return thing

    things["mesh"] = bpy.context.scene.objects["Cube"]
    for kind in ("CURVE", "SURFACE", "FONT"):
        link(kind.lower(), bpy.data.curves.new(kind, kind))
    link("metaball", bpy.data.metaballs.new("Metaball"))
    link("curves", bpy.data.hair_curves.new("Curves"))
    link("volume", bpy.data.volumes.new("Volume"))
    link("empty", None)
    for kind in ("POINT", "SUN", "SPOT", "AREA"):
        link(f"{kind.lower()} lamp", bpy.data.lights.new(kind, kind))
    things["area lamp"].data.shape = "RECTANGLE"
    for kind in ("PERSP", "ORTHO", "PANO"):
        link(f"{kind.lower()} camera", bpy.data.cameras.new(kind)).data.type = kind
    hints = bpy.data.collections.new(bpy.context.scene.ajar.hint_collection)
    bpy.context.scene.collection.children.link(hints)
    things["light hint"] = bpy.data.objects.new("Hint", bpy.data.curves.new("Hint", "CURVE"))
    hints.objects.link(things["light hint"])
    link("portal", bpy.data.lights.new("Portal", "AREA")).data.cycles.is_portal = True
    return things


def use_everything(scene: bpy.types.Scene) -> None:
    """Switches on settings that show other settings."""
    render, layer = scene.render, scene.view_layers[0]
    scene.render.engine, scene.ajar.samples, render.resolution_percentage = "AJAR", 1, 2
    bpy.ops.render.render()   # the statistics of the render have a panel. It comes before Freestyle, which would need a graphics card, is switched on
    render.use_motion_blur = render.use_simplify = render.use_freestyle = render.film_transparent = render.use_multiview = True
    layer.use_pass_mist = True
    layer.lightgroups.add(name="Group")
    scene.ajar.image, scene.ajar.integrator, scene.ajar.importance_factor = "pmc_ip", "photon_map", 2.0


def members(thing: bpy.types.Object) -> dict[str, object]:
    """The members of the context of a Properties editor when this object is active."""
    data = thing.data
    found: dict[str, object] = {"object": thing, "active_object": thing}
    names = {bpy.types.Light: "light", bpy.types.Camera: "camera", bpy.types.Mesh: "mesh", bpy.types.Curve: "curve", bpy.types.MetaBall: "meta_ball",
             bpy.types.Volume: "volume"}
    if hasattr(bpy.types, "Curves"):
        names[bpy.types.Curves] = "curves"
    found |= {name: data if isinstance(data, kind) else None for kind, name in names.items()}
    slots = thing.material_slots
    found["material_slot"] = slots[0] if len(slots) > 0 else None
    found["material"] = slots[0].material if len(slots) > 0 else None
    return found


def cases(things: dict[str, bpy.types.Object]):
    """Tuples (tab, name of the shown datablock, context)."""
    scene, cube = bpy.context.scene, things["mesh"]
    for tab in ("render", "output", "view_layer", "scene"):
        yield tab, "", members(cube)
    yield "world", "", members(cube) | {"world": scene.world}
    yield "collection", "", members(cube) | {"collection": scene.collection}
    yield "material", "", members(cube)
    for name, thing in things.items():
        yield "object", name, members(thing)
        if thing.data is not None:
            yield "data", name, members(thing)


def passes(engine: str) -> list[tuple[str, str, str]]:
    """Tuples (name, channels, kind) of the passes of the engine with all passes switched on."""
    scene = bpy.context.scene
    scene.render.engine = engine
    layer = scene.view_layers[0]
    groups = (layer, layer.cycles) if engine == "CYCLES" else (layer, layer.ajar)
    before = [(owner, prop.identifier, getattr(owner, prop.identifier)) for owner in groups for prop in owner.bl_rna.properties if prop.type == "BOOLEAN" and not prop.is_readonly]
    for owner, name, _ in before:
        setattr(owner, name, True)
    found: list[tuple[str, str, str]] = []
    if engine == "CYCLES":
        from cycles.engine import list_render_passes

        found += list_render_passes(scene, layer)
    else:
        class Listener:
            def register_pass(self, _scene: bpy.types.Scene, _layer: bpy.types.ViewLayer, name: str, _count: int, channels: str, kind: str) -> None:
                found.append((name, channels, kind))

        next(kind for kind in bpy.types.RenderEngine.__subclasses__() if getattr(kind, "bl_idname", "") == engine).update_render_passes(Listener(), scene, layer)
    for owner, name, value in before:
        setattr(owner, name, value)
    return found


def nodes_in_add_menu(engine: str) -> list[str]:
    """The shader nodes in the Add menu of the shader editor for the material of an object."""
    space = types.SimpleNamespace(type="NODE_EDITOR", tree_type="ShaderNodeTree", shader_type="OBJECT", id_from=None, edit_tree=None, node_tree=None)
    context = recorder.Context(engine=engine, space_data=space)
    try:
        import nodeitems_builtins

        categories = nodeitems_builtins.shader_node_categories
    except (ImportError, AttributeError):   # since 4.0
        from bl_ui import node_add_menu_shader

        return [f"Cycles' nodes: {node_add_menu_shader.cycles_shader_nodes_poll(context)}"]
    return sorted(item.nodetype for category in categories for item in category.items(context) if hasattr(item, "nodetype"))


def main(out: str) -> None:
    import addon_utils

    addon_utils.enable("cycles")
    if bpy.app.background and hasattr(gpu.capabilities, "hdr_support_get"):
        gpu.capabilities.hdr_support_get = lambda: True   # a panel calls this, and Blender 4.2 raises an error without a window
    things = objects()
    scene = bpy.context.scene
    use_everything(scene)
    found = []
    for tab, name, context in cases(things):
        by_engine = {}
        for engine in ("CYCLES", "AJAR"):
            scene.render.engine = engine
            shown: set[recorder.Shown] = set()
            for kind in PANORAMAS if tab == "data" and name == "pano camera" else ("",):
                if kind:
                    camera = context["object"].data
                    for owner in (camera, getattr(camera, "cycles", None)):
                        if hasattr(owner, "panorama_type"):
                            owner.panorama_type = kind
                shown |= recorder.shown(tab, engine, **context)[0]
            by_engine[engine] = shown
        found.append({"tab": tab, "of": name, "cycles": sorted(by_engine["CYCLES"]), "ajar": sorted(by_engine["AJAR"])})
    Path(out).write_text(json.dumps({"version": bpy.app.version_string, "cases": found, "passes": {engine: passes(engine) for engine in ("CYCLES", "AJAR")}, "nodes": {engine: nodes_in_add_menu(engine) for engine in ("CYCLES", "AJAR")}}))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="compare.py", description=__doc__.splitlines()[0])
    parser.add_argument("out", help="JSON file")
    main(parser.parse_args(sys.argv[sys.argv.index("--") + 1:]).out)
