"""What artists leave behind in their files: passes of another type, collections that are gone, names that exist twice. The message names the datablock, and the
render goes on."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from ajar_render import compat
from ajar_render.export import export_scene
from ajar_render.headless import Options


def warnings_of(passes=("Combined",)) -> tuple[object, list[tuple[str, str]]]:
    """The description, and what is reported about it."""
    bpy.context.scene.update_tag()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    depsgraph.update()
    context = export_scene(depsgraph, Options(), list(passes), depsgraph.scene_eval.camera, lambda: False, lambda step: None)
    return context.description, context.warnings


def renders(tmp_path) -> np.ndarray:
    """The pixels of a small picture of the scene."""
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.render.resolution_percentage, scene.ajar.samples = 100, 1
    scene.render.image_settings.file_format, scene.render.filepath = "OPEN_EXR", str(tmp_path / "picture.exr")
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(scene.render.filepath)
    pixels = np.empty(len(picture.pixels), dtype=np.float32)
    picture.pixels.foreach_get(pixels)
    return pixels


@pytest.mark.parametrize(("type_of_pass", "linked", "other"), [("COLOR", "Value", "Color"), ("VALUE", "Color", "Value")])
def test_an_aov_of_another_type_than_its_node_names_the_material(build, scene, tmp_path, type_of_pass, linked, other):
    layer = scene.view_layers[0]
    layer.aovs.add().name = "heat"
    layer.aovs[0].type = type_of_pass
    material = build.material("Red")
    nodes, links = material.node_tree.nodes, material.node_tree.links
    source, output = nodes.new("ShaderNodeTexNoise"), nodes.new("ShaderNodeOutputAOV")
    if hasattr(output, "aov_name"):
        output.aov_name = "heat"
    else:
        output.name = "heat"
    links.new(source.outputs[0], output.inputs[linked])
    mesh = build.mesh()
    mesh.materials.append(material)
    build.object(mesh)
    _, said = warnings_of(["Combined", ("AOV Value " if type_of_pass == "VALUE" else "AOV Color ") + "heat"])
    assert any(name == "Red" and "heat" in text and linked in text for name, text in said)
    assert np.isfinite(renders(tmp_path)).all()


def test_an_instancer_of_a_deleted_collection_shows_nothing(build, scene, tmp_path):
    group = bpy.data.collections.new("Trees")
    group.objects.link(bpy.data.objects.new("Tree", build.mesh()))
    instancer = build.object(None, "Forest")
    instancer.instance_type, instancer.instance_collection = "COLLECTION", group
    assert len(warnings_of()[0].instances) == 1
    bpy.data.collections.remove(group)
    description, said = warnings_of()
    assert len(description.instances) == 0 and said == []
    assert np.isfinite(renders(tmp_path)).all()


def test_an_emitter_whose_linked_objects_are_deleted_is_named_and_lights_everything(build, scene, tmp_path, monkeypatch):
    """Blender clears the link to a deleted collection; a collection of deleted objects stays, and is empty."""
    mesh = build.mesh()
    build.object(mesh, "Kept")
    lamp = build.object(bpy.data.lights.new("Key", "POINT"), "Key")
    empty = SimpleNamespace(name="Heroes", objects=[], collection_objects=[], children=[], collection_children=[], all_objects=[])
    monkeypatch.setattr(compat, "light_linking",
                        lambda thing: SimpleNamespace(receiver_collection=empty, blocker_collection=None) if thing.original == lamp else None)
    description, said = warnings_of()
    assert any(name == "Key" and "Heroes" in text for name, text in said)
    assert description.lights[0].receivers == 2**64 - 1
    assert np.isfinite(renders(tmp_path)).all()


def test_objects_of_one_name_in_two_libraries_are_two_objects(build, scene, tmp_path):
    """Each has its mesh and its material. A message names the library, so that the artist finds the right one."""
    for number in range(2):
        mesh = build.mesh("Square", vertices=((0, 0, 0), (1 + number, 0, 0), (1, 1, 0), (0, 1, 0)))
        material = build.material("Paint")
        material.diffuse_color = (0.1 + 0.5 * number, 0, 0, 1)
        mesh.materials.append(material)
        thing = bpy.data.objects.new("Same", mesh)
        thing.location.x, thing.cycles.shadow_terminator_offset = 3.0 * number, 0.2
        bpy.data.libraries.write(str(tmp_path / f"library_{number}.blend"), {thing}, fake_user=True)
        bpy.data.objects.remove(thing)
        bpy.data.meshes.remove(mesh)
        bpy.data.materials.remove(material)
    for number in range(2):
        with bpy.data.libraries.load(str(tmp_path / f"library_{number}.blend"), link=True) as (_, wanted):
            wanted.objects = ["Same"]
        scene.collection.objects.link(wanted.objects[0])
    description, said = warnings_of()
    assert [thing.name for thing in description.objects] == ["Same", "Same"]
    assert len(description.meshes) == 2 and len(description.materials) == 2
    assert sorted(instance.world_from_object[3] for instance in description.instances) == [0.0, 3.0]
    assert sorted(name for name, text in said if "Shadow Terminator" in text) == ["Same [library_0.blend]", "Same [library_1.blend]"]
    assert np.isfinite(renders(tmp_path)).all()
