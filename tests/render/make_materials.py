"""Records how Cycles renders materials of Blender 5.2, for test_materials.py. Run it in the environment of the bpy wheel:

    PYTHONPATH=<unpacked zip> build/compat/bpy-5.2.3/bin/python tests/render/make_materials.py

Writes materials_5.ajar (the scene as the add-on exports it) and materials_5.npz: the names of the spheres, and the mean of each block of two images with
independent seeds.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parents[1] / "tools" / "coverage"), str(HERE.parents[1])]

import probe                                                  # noqa: E402
from python_addon import properties                            # noqa: E402
from python_addon.ajar_module import ajar                     # noqa: E402
from python_addon.export import export_scene                   # noqa: E402
from python_addon.headless import Options                      # noqa: E402

SAMPLES = 1024
COLOR = (0.8, 0.5, 0.3, 1.0)
Maker = Callable[[bpy.types.NodeTree], bpy.types.NodeSocket]


def node(kind: str, choices: dict[str, str] | None = None, **inputs: Any) -> Maker:
    """A material of one node. Underscores in the names of inputs stand for spaces."""
    def make(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        made = tree.nodes.new(kind)
        for name, value in (choices or {}).items():
            setattr(made, name, value)
        for name, value in inputs.items():
            next(socket for socket in made.inputs if socket.identifier == name.replace("_", " ")).default_value = value   # also hidden ones
        return made.outputs[0]
    return make


def principled(choices: dict[str, str] | None = None, **inputs: Any) -> Maker:
    return node("ShaderNodeBsdfPrincipled", choices, **{"Base_Color": COLOR, **inputs})


def bumped(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    """Subsurface scattering with a bump, which tilts the normal where light leaves."""
    wave, bump, closure = (tree.nodes.new(kind) for kind in ("ShaderNodeTexWave", "ShaderNodeBump", "ShaderNodeBsdfPrincipled"))
    wave.inputs["Scale"].default_value = 1.5
    bump.inputs["Distance"].default_value = 0.3
    closure.inputs["Subsurface Weight"].default_value, closure.inputs["Subsurface Scale"].default_value = 1.0, 0.3
    tree.links.new(wave.outputs["Fac"], bump.inputs["Height"])
    tree.links.new(bump.outputs["Normal"], closure.inputs["Normal"])
    return closure.outputs[0]


def bump(closure: str, distance: float, is_displacement: bool = False) -> Maker:
    """A closure with a noise as bump, or as displacement with the method Bump Only."""
    def make(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        shader, noise = tree.nodes.new(closure), tree.nodes.new("ShaderNodeTexNoise")
        node_of_height = tree.nodes.new("ShaderNodeDisplacement" if is_displacement else "ShaderNodeBump")
        node_of_height.inputs["Scale" if is_displacement else "Distance"].default_value = distance
        tree.links.new(noise.outputs[0], node_of_height.inputs["Height"])
        if is_displacement:
            output = next(other for other in tree.nodes if other.bl_idname == "ShaderNodeOutputMaterial")
            tree.links.new(node_of_height.outputs[0], output.inputs["Displacement"])
        else:
            tree.links.new(node_of_height.outputs[0], shader.inputs["Normal"])
        return shader.outputs[0]
    return make


def bumps() -> list[tuple[str, Maker]]:
    diffuse, principled_node = "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfPrincipled"
    return [("Bump, diffuse", bump(diffuse, 0.3)), ("Steep bump, diffuse", bump(diffuse, 1.5)), ("Steep bump, Principled", bump(principled_node, 1.5)),
            ("Displacement as bump, diffuse", bump(diffuse, 0.8, True)), ("Displacement as bump, Principled", bump(principled_node, 0.8, True))]


def subsurface() -> list[tuple[str, Maker]]:
    made = []
    for method in ("RANDOM_WALK", "RANDOM_WALK_SKIN", "RANDOM_WALK_LEGACY", "BURLEY"):
        common = {"Subsurface_Radius": (1.0, 0.4, 0.2), "Subsurface_Scale": 0.3}
        made += [(f"Principled {method}", principled({"subsurface_method": method}, Subsurface_Weight=1.0, **common)),
                 (f"Principled {method} anisotropy", principled({"subsurface_method": method}, Subsurface_Weight=0.5, Subsurface_Anisotropy=0.8, **common)),
                 (f"Subsurface {method}", node("ShaderNodeSubsurfaceScattering", {"falloff": method}, Color=COLOR, Scale=0.3, IOR=2.0, Roughness=0.2,
                                               Anisotropy=0.5))]
    return [*made, ("Principled subsurface with bump", bumped)]


def layers() -> list[tuple[str, Maker]]:
    metal = {"Metallic": 1.0}
    return [
        ("Principled", principled()), ("Principled GGX", principled({"distribution": "GGX"})), ("Principled tint", principled(Specular_Tint=(0.2, 0.5, 1.0, 1.0))), ("Principled IOR", principled(IOR=2.0)),
        ("Principled diffuse roughness", principled(Diffuse_Roughness=1.0)), ("Principled alpha", principled(Alpha=0.5)),
        ("Principled bright colour", principled(Base_Color=(2.0, 1.0, 0.5, 1.0))),
        ("Principled metal", principled(**metal, Roughness=0.3)), ("Principled rough metal", principled(**metal, Roughness=1.0)),
        ("Principled metal GGX", principled({"distribution": "GGX"}, **metal, Roughness=0.7)),
        ("Principled coat", principled(Coat_Weight=1.0)), ("Principled coat tint", principled(Coat_Weight=1.0, Coat_Tint=(0.3, 0.6, 0.9, 1.0), Coat_IOR=1.8)),
        ("Principled emission below a coat", principled(Coat_Weight=1.0, Coat_Tint=(0.3, 0.6, 0.9, 1.0), Emission_Color=(1.0, 0.5, 0.2, 1.0),
                                                        Emission_Strength=1.0)),
        ("Principled sheen", principled(Sheen_Weight=1.0)), ("Principled fine sheen", principled(Sheen_Weight=1.0, Sheen_Roughness=0.2)),
        ("Principled glass", principled(Transmission_Weight=1.0, Roughness=0.3)),
    ]


def films() -> list[tuple[str, Maker]]:
    film = {"Thin_Film_Thickness": 400.0, "Thin_Film_IOR": 1.8}
    return [
        ("Principled film of 100 nm", principled(Thin_Film_Thickness=100.0, Thin_Film_IOR=1.6, Roughness=0.3)),
        ("Principled film of 600 nm", principled(Thin_Film_Thickness=600.0, Thin_Film_IOR=1.6, Roughness=0.3)),
        ("Principled film, tint", principled(**film, Specular_Tint=(0.3, 1.0, 0.5, 1.0), Roughness=0.3)),
        ("Principled film on glass", principled(**film, Transmission_Weight=1.0, Roughness=0.3)),
        ("Principled film on metal", principled(**film, Metallic=1.0, Roughness=0.5)),
        ("Glass with film", node("ShaderNodeBsdfGlass", **film, Roughness=0.3)),
        ("Thin wall, glass", principled(Transmission_Weight=1.0, Roughness=0.3, Thin_Wall=True)),
        ("Thin wall, smooth glass", principled(Transmission_Weight=1.0, Roughness=0.0, Thin_Wall=True)),
        ("Thin wall, subsurface", principled(Subsurface_Weight=1.0, Subsurface_Anisotropy=0.3, Thin_Wall=True)),
        ("Thin wall, rough subsurface", principled(Subsurface_Weight=1.0, Subsurface_Anisotropy=0.3, Diffuse_Roughness=0.7, Thin_Wall=True)),
        ("Thin wall, film", principled(**film, Transmission_Weight=1.0, Roughness=0.3, Thin_Wall=True)),
    ]


def closures() -> list[tuple[str, Maker]]:
    conductor = {"IOR": (0.2, 0.9, 1.2), "Extinction": (3.0, 2.5, 2.0)}
    metallic, physical = "ShaderNodeBsdfMetallic", "PHYSICAL_CONDUCTOR"
    return [
        ("Diffuse", node("ShaderNodeBsdfDiffuse", Color=COLOR)), ("Diffuse rough", node("ShaderNodeBsdfDiffuse", Color=COLOR, Roughness=1.0)),
        ("Metallic F82", node(metallic, {"fresnel_type": "F82"}, Base_Color=COLOR, Edge_Tint=(0.5, 0.8, 1.0, 1.0))),
        ("Metallic conductor", node(metallic, {"fresnel_type": physical}, **conductor, Roughness=0.3)),
        ("Metallic Beckmann", node(metallic, {"fresnel_type": physical, "distribution": "BECKMANN"}, **conductor, Anisotropy=0.6)),
        ("Metallic film", node(metallic, {"fresnel_type": physical}, **conductor, Roughness=0.3, Thin_Film_Thickness=350.0, Thin_Film_IOR=1.6)),
        ("Sheen", node("ShaderNodeBsdfSheen", Color=COLOR)), ("Sheen Ashikhmin", node("ShaderNodeBsdfSheen", {"distribution": "ASHIKHMIN"}, Color=COLOR)),
        ("Glossy GGX", node("ShaderNodeBsdfAnisotropic", {"distribution": "GGX"}, Color=COLOR, Roughness=0.7)),
        ("Glossy Multiscatter", node("ShaderNodeBsdfAnisotropic", {"distribution": "MULTI_GGX"}, Color=COLOR, Roughness=0.7)),
        ("Glossy Beckmann", node("ShaderNodeBsdfAnisotropic", {"distribution": "BECKMANN"}, Color=COLOR, Roughness=0.7)),
        ("Glossy anisotropic", node("ShaderNodeBsdfAnisotropic", Color=COLOR, Roughness=0.5, Anisotropy=0.7)),
        ("Glass Multiscatter", node("ShaderNodeBsdfGlass", {"distribution": "MULTI_GGX"}, Color=COLOR, Roughness=0.4)),
        ("Refraction", node("ShaderNodeBsdfRefraction", Color=COLOR, Roughness=0.5)),
    ]


def main() -> None:
    probe.TILE, probe.SPACING = 24, 5.0
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if "cycles" not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="cycles")
    properties.register()
    names = []
    for name, make in (*layers(), *films(), *closures(), *subsurface(), *bumps()):
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(make(tree), output.inputs["Surface"])
        names.append(name)
    row = probe.build_scene(names)
    scene = bpy.context.scene
    cycles = scene.cycles
    cycles.samples = SAMPLES
    cycles.max_bounces = cycles.transmission_bounces = cycles.glossy_bounces = cycles.diffuse_bounces = 8
    context = export_scene(bpy.context.evaluated_depsgraph_get(), Options({"samples": 64, "integrator": "path", "seed": 1}), ["Combined"], scene.camera,
                           lambda: False, lambda step: None, lambda at, part: scene.frame_set(at, subframe=part))
    assert not context.warnings, context.warnings
    ajar.save_description(context.description, str(HERE / "materials_5.ajar"))
    images = np.stack([probe.by_cycles(seed) for seed in (1, 2)])
    side = probe.TILE * row
    blocks = images.reshape(2, side // probe.BLOCK, probe.BLOCK, side // probe.BLOCK, probe.BLOCK, 3).mean(axis=(2, 4))
    np.savez_compressed(HERE / "materials_5.npz", names=np.array(names), blocks=blocks.astype(np.float32), row=row, tile=probe.TILE, block=probe.BLOCK,
                        blender=bpy.app.version_string)
    print(len(names), "materials,", math.prod(blocks.shape), "values")


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)
