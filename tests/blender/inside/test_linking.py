"""Tests of light linking and of culling. Blender 3.4 has no light linking: its collections are imitated here, and tests/compatibility has the real ones."""

from types import SimpleNamespace

import bpy
import pytest
from ajar_render import compat
from ajar_render.export import KnownObjects, MeshCache, export_scene
from ajar_render.headless import Options
from ajar_render.viewport import Viewport
from mathutils import Matrix


def collection(*entries, children=(), name="Links"):
    """`entries`: pairs of an object and whether it is included; `children`: the same of collections."""
    def states(pairs):
        return [SimpleNamespace(light_linking=SimpleNamespace(link_state="INCLUDE" if included else "EXCLUDE")) for _, included in pairs]
    objects = [thing for thing, _ in entries]
    below = [thing for child, _ in children for thing in child.all_objects]
    return SimpleNamespace(name=name, objects=objects, collection_objects=states(entries), children=[child for child, _ in children],
                           collection_children=states(children), all_objects=objects + below)


@pytest.fixture
def link(monkeypatch):
    """A function that gives an object collections of receivers and of blockers."""
    links = {}
    monkeypatch.setattr(compat, "light_linking", lambda thing: links.get(thing.original))

    def add(thing, receivers=None, blockers=None):
        links[thing] = SimpleNamespace(receiver_collection=receivers, blocker_collection=blockers)
    return add


@pytest.fixture
def things(build):
    mesh = build.mesh()
    return [build.object(mesh, name) for name in ("A", "B", "C")]


def lamp(name="Lamp"):
    made = bpy.data.objects.new(name, bpy.data.lights.new(name, "POINT"))
    bpy.context.scene.collection.objects.link(made)
    return made


def lit(description, light=0) -> list[str]:
    return [thing.name for thing in description.objects if description.lights[light].receivers >> thing.receiver_set & 1]


def test_without_links_all_objects_are_in_one_set(export, things):
    lamp()
    out = export()
    assert {(thing.receiver_set, thing.blocker_set) for thing in out.objects} == {(0, 0)}
    assert out.lights[0].receivers == 2**64 - 1 and out.lights[0].blockers == 2**32 - 1


def test_an_included_object_excludes_those_that_are_not_listed(export, things, link):
    link(lamp(), collection((things[0], True)))
    assert lit(export()) == ["A"]


def test_an_excluded_object_leaves_the_others(export, things, link):
    link(lamp(), collection((things[0], False)))
    assert lit(export()) == ["B", "C"]


def test_an_object_overrides_the_collections_below(export, things, link):
    link(lamp(), collection((things[0], True), children=((collection((things[0], True), (things[1], True)), False),)))
    assert lit(export()) == ["A"]


def test_the_state_of_a_collection_applies_to_everything_below(export, things, link):
    inner = collection(children=((collection((things[0], True)), True),))
    link(lamp(), collection(children=((inner, False),)))
    assert lit(export()) == ["B", "C"]


def test_lamps_and_objects_have_their_own_sets(export, things, link):
    link(lamp("One"), collection((things[0], True)))
    link(lamp("Two"), collection((things[1], True)), collection((things[2], False)))
    link(things[2], collection((things[0], False)))
    out = export()
    assert lit(out, 0) == ["A"] and lit(out, 1) == ["B"]
    assert [thing.name for thing in out.objects if out.lights[1].blockers >> thing.blocker_set & 1] == ["A", "B"]
    emitter = next(thing for thing in out.objects if thing.name == "C")
    assert [thing.name for thing in out.objects if emitter.receivers >> thing.receiver_set & 1] == ["B", "C"]


def test_an_empty_collection_is_reported_and_has_no_effect(export_context, things, link):
    link(lamp(), collection(name="Nothing"), collection(name="Nobody"))
    context = export_context()
    assert lit(context.description) == ["A", "B", "C"]
    assert len([message for name, message in context.warnings if name == "Lamp" and ("Nothing" in message or "Nobody" in message)]) == 2


def test_too_many_sets_are_reported(export_context, build, link):
    mesh = build.mesh()
    objects = [build.object(mesh, f"Object {i}") for i in range(28)]
    for i, thing in enumerate(objects):
        link(lamp(f"Lamp {i}"), None, collection((thing, True)))
    assert len([name for name, message in export_context().warnings if "26" in message and name.startswith("Object")]) == 3   # set 0 is that of other objects


# ---- Culling ---------------------------------------------------------------------------------------------------------------

def culled_scene(build, scene):
    """The camera looks down from 5 m. One object is in view, one beside it, one behind the camera; the last does not allow it."""
    mesh = build.mesh()
    things = [build.object(mesh, name, place) for name, place in (("Seen", (0, 0, 0)), ("Beside", (30, 0, 0)), ("Behind", (0, 0, 9)), ("Kept", (30, 0, 0)))]
    for thing in things[:3]:
        thing.ajar.use_camera_cull = thing.ajar.use_distance_cull = True
    scene.render.use_simplify = True
    return things


def shown(description) -> list[str]:
    return [description.objects[instance.object].name for instance in description.instances]


def test_camera_culling_leaves_out_what_is_outside_the_frame(build, scene, export):
    culled_scene(build, scene)
    assert len(shown(export())) == 4
    scene.ajar.use_camera_cull = True
    assert sorted(shown(export())) == ["Kept", "Seen"]
    scene.ajar.camera_cull_margin = 5.0
    assert "Beside" not in shown(export())
    scene.render.use_simplify = False
    assert len(shown(export())) == 4


def test_distance_culling_leaves_out_what_is_far_away(build, scene, export):
    culled_scene(build, scene)
    scene.ajar.use_distance_cull = True
    scene.ajar.distance_cull_margin = 10.0
    assert sorted(shown(export())) == ["Behind", "Kept", "Seen"]


def test_an_object_that_allows_both_is_left_out_if_both_hold(build, scene, export):
    culled_scene(build, scene)
    scene.ajar.use_camera_cull = scene.ajar.use_distance_cull = True
    scene.ajar.distance_cull_margin = 10.0
    assert sorted(shown(export())) == ["Behind", "Kept", "Seen"]


def test_culling_does_nothing_with_stereoscopy(build, scene, export):
    culled_scene(build, scene)
    scene.ajar.use_camera_cull = scene.render.use_multiview = True
    assert len(shown(export())) == 4


def test_culling_also_holds_with_persistent_data(build, scene):
    culled_scene(build, scene)
    scene.ajar.use_camera_cull = True
    caches = MeshCache(), KnownObjects()
    for _ in range(2):
        depsgraph = bpy.context.evaluated_depsgraph_get()
        context = export_scene(depsgraph, Options(), ["Combined"], depsgraph.scene_eval.camera, lambda: False, lambda step: None, caches=caches)
        assert sorted(shown(context.description)) == ["Kept", "Seen"]


def seen_in_view(build, place) -> list[str]:
    """What a 3D view exports that looks down at `place` from 10 m, with an angle of 45 degrees to each side."""
    frame = Matrix.Translation((*place, 10.0))
    region = SimpleNamespace(width=100, height=100)
    region_3d = SimpleNamespace(view_matrix=frame.inverted(), view_perspective="PERSP",
                                window_matrix=Matrix(((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, -1, -0.2), (0, 0, -1, 0))))
    space = SimpleNamespace(use_render_border=False, clip_start=0.1, clip_end=100.0, local_view=None, use_local_collections=False, use_local_camera=False)
    bpy.context.scene.update_tag()  # the dependency graph does not notice settings that a script changes
    depsgraph = bpy.context.evaluated_depsgraph_get()
    depsgraph.update()
    shown_view = Viewport()
    shown_view.update(SimpleNamespace(region=region, region_data=region_3d, space_data=space), depsgraph)
    return shown(shown_view._description)


def test_a_view_culls_by_its_own_camera(build, scene):
    culled_scene(build, scene)
    assert len(seen_in_view(build, (0.0, 0.0))) == 4
    scene.ajar.use_camera_cull = True
    assert sorted(seen_in_view(build, (0.0, 0.0))) == ["Behind", "Kept", "Seen"]   # what is behind the camera of the scene is below the view
    assert sorted(seen_in_view(build, (30.0, 0.0))) == ["Beside", "Kept"]


def test_culling_without_a_camera_is_reported(build, scene, export_context):
    culled_scene(build, scene)
    scene.ajar.use_camera_cull = True
    scene.camera = None
    context = export_context()
    assert len(shown(context.description)) == 4
    assert any("culling" in message for _, message in context.warnings)


def test_a_lamp_and_the_world_have_their_own_number_of_bounces(build, scene, export):
    lamp().data.ajar.max_bounces = 3
    scene.world = bpy.data.worlds.new("World")
    scene.world.ajar.max_bounces = 2
    out = export()
    assert out.lights[0].max_bounces == 3 and out.world.max_bounces == 2
