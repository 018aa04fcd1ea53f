"""Tests of the export of the sample distribution: its settings and the importance that the artist sets."""

import bpy
import pytest
from ajar_render import viewport
from ajar_render.headless import Options


def test_settings_are_exported_and_the_command_line_has_precedence(export, scene):
    assert export().settings.image == "pmc_ip"
    scene.ajar.image, scene.ajar.image_error, scene.ajar.importance_factor = "pmc_ip", "perceptual", 3.0
    scene.ajar.importance_min, scene.ajar.importance_max = (0.25, 0.5), (0.75, 1.0)
    settings = export().settings
    assert (settings.image, settings.image_error, settings.importance_factor) == ("pmc_ip", "perceptual", 3.0)
    assert list(settings.importance_region) == [0.25, 0.5, 0.75, 1.0]
    assert export(Options({"image": "uniform"})).settings.image == "uniform"


def test_importance_of_an_object_is_multiplied_by_that_of_its_collections(build, export, scene):
    thing = build.object(build.mesh(), "Face")
    assert export().objects[0].importance == 1.0
    thing.ajar.importance = 2.0
    collection = bpy.data.collections.new("Heroes")
    scene.collection.children.link(collection)
    collection.objects.link(thing)
    collection.ajar.importance = 3.0
    assert export().objects[0].importance == pytest.approx(6.0)


def test_importance_of_a_light_group_applies_to_all_its_sources(build, export, scene):
    view_layer = bpy.context.view_layer
    build.object(build.mesh(), "Face").lightgroup = "Key"
    build.object(build.mesh(), "Other").lightgroup = "Fill"
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    scene.collection.objects.link(lamp)
    scene.world = bpy.data.worlds.new("Sky")
    lamp.lightgroup = scene.world.lightgroup = "Key"
    for name in ("Key", "Fill"):
        bpy.ops.scene.view_layer_add_lightgroup(name=name)

    def importances():
        description = export()
        return {**{thing.name: thing.light_importance for thing in (*description.objects, *description.lights)}, "Sky": description.world.light_importance}
    assert set(importances().values()) == {1.0}
    view_layer.active_lightgroup_index = 0
    view_layer.ajar.light_group_importance = 5.0
    assert importances() == {"Face": 5.0, "Other": 1.0, "Lamp": 5.0, "Sky": 5.0}
    view_layer.active_lightgroup_index = 1
    assert view_layer.ajar.light_group_importance == 1.0
    view_layer.ajar.light_group_importance = 0.5
    assert importances() == {"Face": 5.0, "Other": 0.5, "Lamp": 5.0, "Sky": 5.0}
    view_layer.active_lightgroup_index = 0
    view_layer.ajar.light_group_importance = 1.0
    assert [group.name for group in view_layer.ajar.light_groups] == ["Fill"]


def test_views_have_the_settings_of_renders_except_for_the_region_of_the_frame(export, scene):
    scene.ajar.image, scene.ajar.image_error, scene.ajar.importance_factor = "pmc_ip", "perceptual", 3.0
    settings = export().settings
    of_view = viewport._for_view(settings, scene)
    assert (of_view.image, of_view.image_error, of_view.importance_factor) == ("pmc_ip", "perceptual", 1.0)
    assert settings.importance_factor == 3.0
