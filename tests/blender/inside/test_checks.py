"""Tests of the checks before a render, of their fixes, and of presets."""

from __future__ import annotations

import bpy
import pytest
from ajar_render import checks, hints, presets
from mathutils import Vector


def names(scene) -> set[str]:
    return {fix.name for fix in checks.found_in(scene)}


def no_camera(scene):
    bpy.data.objects.remove(scene.camera)


def draw_a_path(scene):
    hints.new_path(bpy.context, [Vector((0, 0, 0)), Vector((1, 0, 0))], "Path")
    scene.ajar.integrator = "path"


def clamp(scene):
    scene.ajar.integrator, scene.ajar.clamp_indirect = "path", 10.0


BREAK = {
    "CAMERA": no_camera,
    "CLAMPING": clamp,
    "CAUSTICS": lambda scene: setattr(scene.ajar, "refractive_caustics", False),
    "HINTS": draw_a_path,
    "BIASED": lambda scene: setattr(scene.ajar, "direct", "ocv_paper"),
}


@pytest.fixture
def plain(scene):
    """A scene with Ajar's settings set, independent of the settings of Cycles in the file."""
    bpy.ops.ajar.use_preset(preset="FINAL")
    return scene


def test_a_plain_scene_has_no_warning(plain):
    assert names(plain) == set()


def test_clamping_that_auto_ignores_is_no_warning(plain):
    clamp(plain)
    plain.ajar.integrator = "auto"
    assert names(plain) == set()


def test_an_object_that_is_no_camera_is_replaced(plain):
    plain.camera = bpy.data.objects.new("Cube", None)
    plain.collection.objects.link(plain.camera)
    assert names(plain) == {"CAMERA"}
    assert bpy.ops.ajar.fix(what="CAMERA") == {"FINISHED"}
    assert plain.camera.type == "CAMERA"


def test_every_check_has_a_case():
    assert set(BREAK) == {fix.name for fix in checks.FIXES}


@pytest.mark.parametrize("name", BREAK)
def test_the_fix_of_a_check_removes_its_warning(plain, name):
    BREAK[name](plain)
    assert name in names(plain)
    assert bpy.ops.ajar.fix(what=name) == {"FINISHED"}
    assert name not in names(plain)


def test_check_lists_the_warnings_of_the_core(plain, build):
    thing = build.object(build.mesh())
    material = build.material("Odd")
    odd = material.node_tree.nodes.new("ShaderNodeShaderToRGB")
    diffuse = material.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
    material.node_tree.links.new(odd.outputs["Color"], diffuse.inputs["Color"])
    material.node_tree.links.new(diffuse.outputs[0], material.node_tree.nodes["Material Output"].inputs[0])
    thing.data.materials.append(material)
    assert checks.messages_of(plain) is None
    bpy.ops.ajar.check_scene()
    assert any("Odd" in name and "Shader to RGB" in text for name, text in checks.messages_of(plain)), checks.messages_of(plain)
    thing.data.materials.clear()
    bpy.ops.ajar.check_scene()
    assert checks.messages_of(plain) == []


@pytest.mark.parametrize("value, told", [(0.0, False), (1.0, False), (3.0, True)])
def test_a_raised_filter_glossy_is_reported(plain, build, value, told):
    if not hasattr(plain, "cycles"):
        pytest.skip("Cycles' add-on is not enabled here")
    build.object(build.mesh())
    plain.cycles.blur_glossy = value
    bpy.ops.ajar.check_scene()
    assert any("Filter Glossy" in text for _, text in checks.messages_of(plain)) == told


def test_check_of_a_scene_that_cannot_be_rendered_has_the_reason(plain):
    no_camera(plain)
    with pytest.raises(RuntimeError, match="camera"):
        bpy.ops.ajar.check_scene()
    assert "camera" in checks.messages_of(plain)[0][1]


def test_missing_images_are_reported_by_name(plain, build):
    image = bpy.data.images.new("Lost", 4, 4)
    image.source, image.filepath = "FILE", "//nowhere.png"
    image.use_fake_user = True
    assert checks.missing_images() == ["Lost"]


@pytest.mark.parametrize("preset", presets.PRESETS)
def test_every_preset_sets_the_same_settings(scene, preset):
    bpy.ops.ajar.use_preset(preset="CAUSTICS")  # its settings must be replaced
    assert bpy.ops.ajar.use_preset(preset=preset) == {"FINISHED"}
    for name, value in (presets.BASE | presets.PRESETS[preset][2]).items():
        assert getattr(scene.ajar, name) == pytest.approx(value), name
    assert set(presets.PRESETS[preset][2]) <= set(presets.BASE)
