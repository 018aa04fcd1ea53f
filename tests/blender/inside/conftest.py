"""Fixtures for tests that run inside Blender: an empty scene for each test, and its export."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import pytest
from ajar_render.ajar_module import ajar
from ajar_render.export import export_scene
from ajar_render.headless import Options


@pytest.fixture(autouse=True)
def scene() -> bpy.types.Scene:
    """An empty scene with a camera, new for each test."""
    bpy.ops.wm.read_homefile(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "AJAR"
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location.z = 5.0
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


class Builder:
    """Creates small datablocks and links them to the scene."""

    def mesh(self, name: str = "Square", vertices=((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)), faces=((0, 1, 2, 3),)) -> bpy.types.Mesh:
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(vertices, [], faces)
        return mesh

    def object(self, data: bpy.types.ID | None, name: str = "Object", location=(0.0, 0.0, 0.0)) -> bpy.types.Object:
        thing = bpy.data.objects.new(name, data)
        thing.location = location
        bpy.context.scene.collection.objects.link(thing)
        return thing

    def material(self, name: str = "Material") -> bpy.types.Material:
        """A material with only an output node."""
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        material.node_tree.nodes.clear()
        material.node_tree.nodes.new("ShaderNodeOutputMaterial")
        return material


@pytest.fixture
def build() -> Builder:
    return Builder()


Export = Callable[[], ajar.SceneDescription]


@pytest.fixture
def export_context(scene) -> Callable:
    def run(options: Options | None = None, is_cancelled=lambda: False):
        bpy.context.scene.update_tag()  # the dependency graph does not notice settings that a script changes
        depsgraph = bpy.context.evaluated_depsgraph_get()
        depsgraph.update()
        return export_scene(depsgraph, options or Options(), ["Combined"], depsgraph.scene_eval.camera, is_cancelled, lambda step: None)
    return run


@pytest.fixture
def export_blurred(scene) -> Callable:
    """A function that exports the scene with motion blur and returns the context."""
    def run():
        scene.render.use_motion_blur = True
        depsgraph = bpy.context.evaluated_depsgraph_get()
        depsgraph.update()
        return export_scene(depsgraph, Options(), ["Combined"], depsgraph.scene_eval.camera, lambda: False, lambda step: None,
                            lambda frame, subframe: scene.frame_set(frame, subframe=subframe))
    return run


@pytest.fixture
def export(export_context) -> Export:
    return lambda *arguments: export_context(*arguments).description


@pytest.fixture
def graph_of(export, build) -> Callable[[bpy.types.Material], ajar.NodeGraph]:
    """A function that exports a square with a material and returns the graph of the material."""

    def run(material: bpy.types.Material) -> ajar.NodeGraph:
        mesh = build.mesh()
        mesh.materials.append(material)
        build.object(mesh)
        return export().materials[0].graph
    return run
