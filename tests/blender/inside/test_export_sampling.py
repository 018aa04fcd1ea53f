"""How samples are shared out: the settings, and what the artist says matters."""

import bpy
import pytest
from ajar_render import viewport
from ajar_render.headless import Options


def test_settings_reach_the_core_and_the_command_line_wins(export, scene):
    assert export().settings.image == "uniform"
    scene.ajar.image, scene.ajar.image_error, scene.ajar.importance_factor = "pmc_ip", "perceptual", 3.0
    scene.ajar.importance_min, scene.ajar.importance_max = (0.25, 0.5), (0.75, 1.0)
    settings = export().settings
    assert (settings.image, settings.image_error, settings.importance_factor) == ("pmc_ip", "perceptual", 3.0)
    assert list(settings.importance_region) == [0.25, 0.5, 0.75, 1.0]
    assert export(Options(image="uniform")).settings.image == "uniform"


def test_importance_of_an_object_is_its_own_times_its_collections(build, export, scene):
    thing = build.object(build.mesh(), "Face")
    assert export().objects[0].importance == 1.0
    thing.ajar.importance = 2.0
    collection = bpy.data.collections.new("Heroes")
    scene.collection.children.link(collection)
    collection.objects.link(thing)
    collection.ajar.importance = 3.0
    assert export().objects[0].importance == pytest.approx(6.0)


def test_views_share_samples_out_alike_but_for_the_region_of_the_frame(export, scene):
    scene.ajar.image, scene.ajar.image_error, scene.ajar.importance_factor = "pmc_ip", "perceptual", 3.0
    settings = export().settings
    of_view = viewport._for_view(settings, scene)
    assert (of_view.image, of_view.image_error, of_view.importance_factor) == ("pmc_ip", "perceptual", 1.0)
    assert settings.importance_factor == 3.0
