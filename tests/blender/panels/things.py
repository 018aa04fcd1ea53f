"""Lists what a renderer can support in this Blender: every setting with its choices, every part of every shader node, and every pass of Cycles. Runs
inside any Blender; Ajar is not needed.

    blender -b --factory-startup --python-exit-code 1 --python things.py -- OUT.json
    python things.py OUT.json          (in the environment of a bpy wheel)
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "tools" / "coverage"))
import probes

STRUCTS = ("Scene", "RenderSettings", "ViewLayer", "Object", "Mesh", "Curves", "PointLight", "SpotLight", "SunLight", "AreaLight", "World", "WorldMistSettings", "Camera", "CameraDOFSettings",
           "Material")
OWNERS = ("Scene", "ViewLayer", "Object", "Light", "World", "Camera", "Material", "Mesh")   # datablocks with settings of Cycles
CRYPTOMATTE = "Crypto"


def settings() -> Iterator[tuple[str, list[str]]]:
    """The settings of the datablocks that a renderer reads, and of the groups of Cycles in them, each with its choices."""
    of_every_datablock = set(bpy.types.ID.bl_rna.properties.keys()) | {"rna_type"}
    structs = {name: getattr(bpy.types, name).bl_rna for name in STRUCTS}
    for owner in OWNERS:
        for prop in getattr(bpy.types, owner).bl_rna.properties:
            if prop.identifier.startswith("cycles") and prop.type == "POINTER":
                structs[prop.fixed_type.identifier] = prop.fixed_type
    for name, rna in structs.items():
        for prop in rna.properties:
            if prop.identifier not in of_every_datablock and prop.identifier != "ajar" and (not prop.is_readonly or prop.type == "POINTER"):
                yield f"{name}.{prop.identifier}", [item.identifier for item in prop.enum_items] if prop.type == "ENUM" else []


def shader_nodes() -> Iterator[tuple[str, list[str]]]:
    """The outputs, inputs and properties of shader nodes, with their choices."""
    tree = bpy.data.materials.new("nodes")
    tree.use_nodes = True
    for type_ in sorted(dir(bpy.types)):
        if not type_.startswith(("ShaderNode", "NodeGroup", "NodeReroute", "NodeFrame")):
            continue
        try:
            node = tree.node_tree.nodes.new(type_)
        except RuntimeError:   # a base class, or a node of another kind of tree
            continue
        choices: dict[str, list[str]] = {}
        for kind, name, value, _ in probes.parts(node):
            if kind == "choice":
                choices.setdefault(probes.thing(type_, kind, name), []).append(value)
            elif name != "__extend__":   # the place for the link of a new socket
                yield probes.thing(type_, kind, name), []
        yield from choices.items()
        for prop in node.bl_rna.properties:
            if prop.identifier not in probes.COMMON | probes.INTERNAL | {"texture_mapping"} and prop.type in ("STRING", "POINTER", "COLLECTION"):
                yield f"{type_}.{prop.identifier}", []


def passes() -> Iterator[tuple[str, list[str]]]:
    """The passes of Cycles with all passes switched on; those of Cryptomatte without their numbers."""
    from cycles import engine

    scene = bpy.context.scene
    layer = scene.view_layers[0]
    scene.render.engine, scene.cycles.use_denoising = "CYCLES", True
    for owner in (layer, layer.cycles):
        for prop in owner.bl_rna.properties:
            if prop.type == "BOOLEAN" and not prop.is_readonly:
                setattr(owner, prop.identifier, True)
    for name in dict.fromkeys(name.rstrip("0123456789") if name.startswith(CRYPTOMATTE) else name for name, _, _ in engine.list_render_passes(scene, layer)):
        yield f"pass {name}", []


def main(path: str) -> None:
    import addon_utils

    addon_utils.enable("cycles")
    found = dict([*settings(), *shader_nodes(), *passes()])
    Path(path).write_text(json.dumps({"blender": bpy.app.version_string, "things": found}, indent=0), encoding="utf-8")


if __name__ == "__main__":
    probes.run(main)
