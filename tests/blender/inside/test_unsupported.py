"""Settings that Ajar does not support are reported with the name of their owner, and supported settings of view layers have an effect."""

import bpy
import pytest
from ajar_render import unsupported
from ajar_render.export import export_scene
from ajar_render.headless import Options


def other_value(owner: bpy.types.bpy_struct, name: str, harmless: object) -> object:
    prop = owner.bl_rna.properties[name]
    if prop.type == "BOOLEAN":
        return not harmless
    if prop.type == "ENUM":
        return next(item.identifier for item in prop.enum_items if item.identifier != harmless)
    return harmless + 1 if harmless == 0 else harmless / 2 if prop.type == "FLOAT" else int(harmless / 2)


def owner_of(thing: bpy.types.ID, path: str) -> tuple[bpy.types.bpy_struct, str]:
    *groups, name = path.split(".")
    for group in groups:
        thing = getattr(thing, group)
    return thing, name


@pytest.fixture
def datablocks(build, scene):
    """One datablock of each kind, by the name that warnings use."""
    material = build.material("Paint")
    thing = build.object(build.mesh(), "Wall")
    thing.data.materials.append(material)
    lamp = build.object(bpy.data.lights.new("Bulb", "POINT"), "Bulb")
    scene.world = bpy.data.worlds.new("Sky")
    scene.render.use_simplify = scene.render.film_transparent = True
    return {"SCENE": (scene, scene.name), "VIEW_LAYER": (scene.view_layers[0], scene.view_layers[0].name), "OBJECT": (thing, "Wall"), "LIGHT": (lamp.data, "Bulb"),
            "WORLD": (scene.world, "Sky"), "CAMERA": (scene.camera.data, "Camera")}


def warnings() -> set[tuple[str, str]]:
    depsgraph = bpy.context.evaluated_depsgraph_get()
    depsgraph.update()
    return set(export_scene(depsgraph, Options(), ["Combined"], depsgraph.scene_eval.camera, lambda: False, lambda step: None).warnings)


def test_a_plain_scene_has_no_warnings(datablocks):
    assert warnings() == set()


KINDS = ("SCENE", "VIEW_LAYER", "OBJECT", "WORLD", "CAMERA")


@pytest.mark.parametrize("kind, setting", [(kind, setting) for kind in KINDS for setting in getattr(unsupported, kind)],
                         ids=lambda value: value.path if isinstance(value, unsupported.Setting) else value)
def test_each_setting_is_reported_by_name(datablocks, kind, setting):
    thing, name = datablocks[kind]
    if not unsupported.value_of(thing, setting.path)[0] or not setting.matters(thing):
        pytest.skip("this Blender does not have it")
    owner, prop = owner_of(thing, setting.path)
    setattr(owner, prop, other_value(owner, prop, setting.harmless))
    thing.update_tag() if hasattr(thing, "update_tag") else None
    assert (name, setting.message()) in warnings()


def test_an_aov_with_the_name_of_another_pass_is_reported(datablocks, scene):
    layer = scene.view_layers[0]
    layer.aovs.add().name = "Mask"
    assert not any("Mask" in text for _, text in warnings())
    layer.aovs.add().name = "Combined"
    assert any(name == layer.name and layer.aovs[1].name in text for name, text in warnings()) == (not layer.aovs[1].is_valid)


def test_a_view_layer_can_exclude_its_world_and_surfaces(datablocks, export, scene):
    layer = scene.view_layers[0]
    scene.world.use_nodes, scene.world.color = False, (0.5, 0.25, 0.125)
    before = export()
    assert tuple(before.world.color) == (0.5, 0.25, 0.125) and len(before.instances) == 1
    layer.use_sky = False
    assert tuple(export().world.color) == (0, 0, 0)
    layer.use_solid = False
    assert len(export().instances) == 0


def test_samples_of_a_view_layer_have_precedence_over_those_of_the_scene(export, scene):
    scene.ajar.samples = 32
    scene.view_layers[0].samples = 48
    assert export().settings.samples == 48
    assert export(Options({"samples": 7})).settings.samples == 7
    scene.cycles.use_layer_samples = "BOUNDED"
    assert export().settings.samples == 32
    scene.cycles.use_layer_samples = "IGNORE"
    assert export().settings.samples == 32
