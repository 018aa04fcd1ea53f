"""The texture cache: its settings reach the core, and a render makes and reads files of tiles."""

import os

import bpy
import numpy as np
import pytest
from ajar_render import compat
from plane_view import look_at_plane, render


@pytest.fixture
def settings():
    """The owner of the switches. They are off again after the test."""
    owner = compat.texture_cache_owner(bpy.context.scene)
    yield owner
    owner.use_texture_cache = owner.use_auto_generate_texture_cache = False


def use_folder(folder):
    if compat.texture_cache_owner(bpy.context.scene) == bpy.context.scene.ajar:
        bpy.context.scene.ajar.texture_cache_directory = folder
    else:
        bpy.context.preferences.filepaths.texture_cache_directory = folder


def test_settings_reach_the_core(build, export, settings, tmp_path):
    settings.use_texture_cache = False
    out = export().settings
    assert not out.texture_cache and not out.texture_cache_generate
    assert out.texture_cache_folder == ""
    assert out.texture_cache_size == 1024
    settings.use_texture_cache = settings.use_auto_generate_texture_cache = True
    bpy.context.scene.ajar.texture_cache_size = 77
    use_folder(str(tmp_path))
    out = export().settings
    assert out.texture_cache and out.texture_cache_generate
    assert out.texture_cache_folder == str(tmp_path)
    assert out.texture_cache_size == 77
    settings.use_auto_generate_texture_cache = False
    assert not export().settings.texture_cache_generate


def test_a_render_makes_tiles_and_shows_the_same_picture(build, settings, tmp_path):
    pixels = np.random.default_rng(1).uniform(0.0, 1.0, (100, 90, 4)).astype(np.float32)
    pixels[..., 3] = 1.0
    image = bpy.data.images.new("Pixels", 90, 100)
    image.pixels.foreach_set(pixels.ravel())
    image.filepath_raw, image.file_format = str(tmp_path / "image.png"), "PNG"
    image.save()
    texture_image = bpy.data.images.load(str(tmp_path / "image.png"))
    mesh = build.mesh("Plane", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)])
    material = build.material()
    mesh.materials.append(material)
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    build.object(mesh)
    tree = material.node_tree
    tree.nodes.clear()
    output, emission, texture = (tree.nodes.new(f"ShaderNode{name}") for name in ("OutputMaterial", "Emission", "TexImage"))
    texture.image, texture.interpolation = texture_image, "Closest"
    tree.links.new(emission.outputs[0], output.inputs[0])
    tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
    scene = bpy.context.scene
    look_at_plane(scene, 200)
    whole = render(scene, "AJAR", tmp_path)
    use_folder(str(tmp_path / "tiles"))
    settings.use_texture_cache = settings.use_auto_generate_texture_cache = True
    tiled = render(scene, "AJAR", tmp_path)
    made = os.listdir(tmp_path / "tiles")
    assert len(made) == 1 and made[0].startswith("image_") and made[0].endswith(".ajar.tif")
    # A pixel is smaller than a texel, so the finest level is read.
    np.testing.assert_array_equal(tiled, whole)
