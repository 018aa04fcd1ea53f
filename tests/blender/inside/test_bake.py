"""Baking: what Ajar bakes is what it renders, and the same as Cycles bakes."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest

SIZE = 16


@pytest.fixture
def target() -> bpy.types.Image:
    return bpy.data.images.new("Baked", SIZE, SIZE, float_buffer=True)


@pytest.fixture
def square(build, target) -> bpy.types.Object:
    """A square of 2 m that is turned and moved, whose UV map covers the image, with a red diffuse material."""
    mesh = build.mesh(vertices=((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)))
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    thing = build.object(mesh, location=(0.3, -0.2, 0.5))
    thing.rotation_euler = (0.2, -0.1, 0.4)
    mesh.materials.append(diffuse(build, (0.8, 0.3, 0.1), target))
    return thing


def diffuse(build, colour, target: bpy.types.Image) -> bpy.types.Material:
    material = build.material()
    nodes, links = material.node_tree.nodes, material.node_tree.links
    shader, image = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeTexImage")
    shader.inputs["Color"].default_value = (*colour, 1.0)
    links.new(shader.outputs[0], next(node for node in nodes if node.type == "OUTPUT_MATERIAL").inputs["Surface"])
    image.image, nodes.active = target, image
    return material


def lamp(build, location=(0.3, -0.2, 2.5), watts=100.0) -> bpy.types.Object:
    data = bpy.data.lights.new("Lamp", "POINT")
    data.energy, data.shadow_soft_size = watts, 0.0
    return build.object(data, location=location)


def baked(thing: bpy.types.Object, target: bpy.types.Image, kind: str, engine: str = "AJAR", samples: int = 16, **more) -> np.ndarray:
    """[row, column, channel] of the image after baking the object."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.ajar.samples = samples
    if hasattr(scene, "cycles"):
        scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = samples, False, False
    scene.render.bake.margin = 0
    for other in bpy.context.view_layer.objects:
        other.select_set(False)
    thing.select_set(True)
    bpy.context.view_layer.objects.active = thing
    bpy.ops.object.bake(type=kind, **more)
    pixels = np.empty(SIZE * SIZE * 4, dtype=np.float32)
    target.pixels.foreach_get(pixels)
    return pixels.reshape(SIZE, SIZE, 4)[..., :3]


def places(thing: bpy.types.Object) -> np.ndarray:
    """The centres of the texels of the square in world space."""
    along = 2.0 * (np.arange(SIZE) + 0.5) / SIZE - 1.0
    x, y = np.meshgrid(along, along)
    local = np.stack([x, y, np.zeros_like(x), np.ones_like(x)], axis=-1)
    return (local @ np.array(thing.matrix_world).T)[..., :3]


def test_positions_are_those_of_the_texels(square, target):
    np.testing.assert_allclose(baked(square, target, "POSITION"), places(square), atol=1e-3)


def test_coordinates_are_those_of_the_uv_map(square, target):
    along = (np.arange(SIZE) + 0.5) / SIZE
    u, v = np.meshgrid(along, along)
    np.testing.assert_allclose(baked(square, target, "UV"), np.stack([u, v, np.ones_like(u)], axis=-1), atol=1e-3)


def test_light_of_a_lamp_has_its_closed_form(build, square, target):
    """The radiance is albedo / pi * cosine * power / (4 pi distance^2)."""
    source = lamp(build)
    bpy.context.view_layer.update()
    away = np.array(source.location) - places(square)
    distance = np.linalg.norm(away, axis=-1)
    cosine = (away @ np.array(square.matrix_world)[:3, 2]) / distance
    irradiance = 100.0 / (4.0 * math.pi) * cosine / distance**2
    expected = irradiance[..., None] / math.pi * np.array([0.8, 0.3, 0.1])
    result = baked(square, target, "COMBINED")
    np.testing.assert_allclose(result, expected, rtol=0.03)
    np.testing.assert_allclose(baked(square, target, "DIFFUSE", pass_filter={"DIRECT"}), np.repeat(irradiance[..., None] / math.pi, 3, axis=-1), rtol=0.03)
    np.testing.assert_allclose(baked(square, target, "DIFFUSE", pass_filter={"COLOR"}), np.broadcast_to([0.8, 0.3, 0.1], (SIZE, SIZE, 3)), rtol=1e-3)


@pytest.mark.parametrize("integrator", ["auto", "erpt", "photon_map", "irradiance_cache"])
def test_every_integrator_bakes_or_path_tracing_does(build, square, target, integrator):
    lamp(build)
    expected = baked(square, target, "COMBINED")
    bpy.context.scene.ajar.integrator = integrator
    np.testing.assert_allclose(baked(square, target, "COMBINED", samples=64), expected, rtol=0.05)


@pytest.mark.parametrize(("kind", "more"), [
    ("COMBINED", {}), ("COMBINED", {"pass_filter": {"DIRECT", "DIFFUSE"}}), ("DIFFUSE", {"pass_filter": {"DIRECT", "INDIRECT", "COLOR"}}),
    ("GLOSSY", {"pass_filter": {"DIRECT", "INDIRECT", "COLOR"}}), ("EMIT", {}), ("POSITION", {}), ("AO", {}), ("ROUGHNESS", {}),
    ("NORMAL", {"normal_space": "TANGENT"}), ("NORMAL", {"normal_space": "OBJECT"}),
])
def test_bakes_agree_with_cycles(build, target, kind, more):
    """A round, smooth mesh over a floor, with a diffuse and glossy material that emits light for the bake of Emit. Normals are bumped; for light, bumps compare heights over another distance."""
    floor = build.object(build.mesh("Floor", vertices=((-5, -5, -1), (5, -5, -1), (5, 5, -1), (-5, 5, -1))))
    floor.data.materials.append(diffuse(build, (0.2, 0.6, 0.9), target))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, location=(0.2, 0.1, 0.4))
    ball = bpy.context.object
    bpy.ops.object.shade_smooth()
    material = diffuse(build, (0.7, 0.5, 0.3), target)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    mixed, glossy, shining, bump, wave = (nodes.new(name) for name in ("ShaderNodeAddShader", "ShaderNodeBsdfGlossy", "ShaderNodeEmission", "ShaderNodeBump", "ShaderNodeTexWave"))
    both = nodes.new("ShaderNodeAddShader")
    glossy.inputs["Color"].default_value, glossy.inputs["Roughness"].default_value = (0.2, 0.2, 0.3, 1.0), 0.5
    shining.inputs["Color"].default_value = (0.0, 0.1, 0.2, 1.0) if kind == "EMIT" else (0.0, 0.0, 0.0, 1.0)
    shader = next(node for node in nodes if node.type == "BSDF_DIFFUSE")
    wave.inputs["Scale"].default_value, bump.inputs["Strength"].default_value, bump.inputs["Distance"].default_value = 1.5, 0.3 if kind == "NORMAL" else 0.0, 0.1
    links.new(wave.outputs["Fac"], bump.inputs["Height"])
    links.new(bump.outputs[0], shader.inputs["Normal"])
    links.new(shader.outputs[0], mixed.inputs[0])
    links.new(glossy.outputs[0], mixed.inputs[1])
    links.new(mixed.outputs[0], both.inputs[0])
    links.new(shining.outputs[0], both.inputs[1])
    links.new(both.outputs[0], next(node for node in nodes if node.type == "OUTPUT_MATERIAL").inputs["Surface"])
    ball.data.materials.append(material)
    lamp(build, location=(1.5, -1.0, 3.0), watts=300.0)
    # Cycles of Blender 3 adds the positions of all samples.
    ours, theirs = (baked(ball, target, kind, engine, 1 if kind == "POSITION" else 256, **more) for engine in ("AJAR", "CYCLES"))
    middle = slice(SIZE // 4, 3 * SIZE // 4)   # texels at the poles belong to several triangles
    ours, theirs = ours[middle], theirs[middle]
    scale = max(float(np.abs(theirs).mean()), 1e-3)
    assert abs(ours.mean() - theirs.mean()) < 0.01 * scale
    assert np.sqrt(np.mean((ours - theirs)**2)) < 0.06 * scale


def test_selected_to_active_bakes_the_other_object(build, square, target):
    other = build.object(build.mesh("Other", vertices=((-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0))))
    other.data.materials.append(diffuse(build, (0.1, 0.9, 0.2), target))
    square.rotation_euler, square.location = (0.0, 0.0, 0.0), (0.0, 0.0, 0.05)
    scene = bpy.context.scene
    scene.render.bake.use_selected_to_active, scene.render.bake.cage_extrusion = True, 0.2
    scene.render.engine = "AJAR"
    other.select_set(True)
    square.select_set(True)
    bpy.context.view_layer.objects.active = square
    bpy.ops.object.bake(type="DIFFUSE", pass_filter={"COLOR"}, use_selected_to_active=True, cage_extrusion=0.2, margin=0)
    pixels = np.empty(SIZE * SIZE * 4, dtype=np.float32)
    target.pixels.foreach_get(pixels)
    np.testing.assert_allclose(pixels.reshape(-1, 4)[:, :3], np.broadcast_to([0.1, 0.9, 0.2], (SIZE * SIZE, 3)), atol=2e-3)


def test_a_kind_that_ajar_does_not_bake_is_an_error_with_its_name():
    from ajar_render import bake
    with pytest.raises(bake.CannotBake, match="Whatever"):
        bake.passes_for("WHATEVER", 0)


def shadowed(build, square, target, albedo: float) -> bpy.types.Object:
    """A square of half the size floats over the baked one and has its shadow."""
    above = build.object(build.mesh("Above", vertices=((-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0))), "Above")
    above.data.materials.append(diffuse(build, 3 * (albedo,), target))
    square.rotation_euler, square.location = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    above.location.z = 0.5
    return above


def test_shadow_is_the_light_relative_to_that_without_the_other_objects(build, square, target):
    """The centre of a black blocker of 1 m at 0.5 m, below a lamp at 2.5 m: its shadow is 1.25 m wide. The shadow of Cycles in Blender 3 is the same."""
    shadowed(build, square, target, 0.0)
    lamp(build, location=(0.0, 0.0, 2.5))
    bpy.context.view_layer.update()
    farthest = np.abs(places(square)[..., :2]).max(axis=-1)
    ours, theirs = (baked(square, target, "SHADOW", engine) for engine in ("AJAR", "CYCLES"))
    inside, outside = farthest < 0.55, farthest > 0.7
    assert (ours[inside] == 0.0).all() and (theirs[inside] == 0.0).all()
    np.testing.assert_allclose(ours[outside], 1.0, atol=1e-3)
    np.testing.assert_allclose(theirs[outside], 1.0, atol=1e-3)


def test_shadow_has_the_light_of_the_world(build, square, target):
    """Half of the light of a lamp and a world remains, and a bright blocker adds light."""
    shadowed(build, square, target, 0.8)
    world = bpy.data.worlds.new("World")
    bpy.context.scene.world = world
    world.use_nodes = False
    world.color = (0.5, 0.5, 0.5)
    lamp(build, location=(0.0, 0.0, 2.5))
    above = bpy.data.objects["Above"]
    lit = baked(square, target, "COMBINED", samples=256)
    shadow = baked(square, target, "SHADOW", samples=256)
    above.hide_render = True
    alone = baked(square, target, "COMBINED", samples=256)
    assert 0.02 < shadow.min() < 0.4
    np.testing.assert_allclose(shadow, lit / alone, rtol=0.15, atol=0.03)
    assert abs(shadow.mean() - (lit / alone).mean()) < 0.01


def test_the_environment_is_seen_from_the_origin(build, square, target):
    """The colour of the world is the direction; Cycles bakes it in the direction of each place."""
    world = bpy.data.worlds.new("World")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    coordinates = nodes.new("ShaderNodeTexCoord")
    background = next(node for node in nodes if node.type == "BACKGROUND")
    links.new(coordinates.outputs["Generated"], background.inputs["Color"])
    square.location.z = 3.0
    bpy.context.view_layer.update()
    directions = places(square) / np.linalg.norm(places(square), axis=-1, keepdims=True)
    ours, theirs = (baked(square, target, "ENVIRONMENT", engine, 64) for engine in ("AJAR", "CYCLES"))
    np.testing.assert_allclose(ours, np.maximum(directions, 0.0), atol=0.01)
    np.testing.assert_allclose(ours, np.maximum(theirs, 0.0), atol=0.01)   # Ajar clips negative light


def test_roughness_is_the_mean_of_the_lobes(build, square, target):
    material = square.data.materials[0]
    nodes, links = material.node_tree.nodes, material.node_tree.links
    glossy, both = nodes.new("ShaderNodeBsdfGlossy"), nodes.new("ShaderNodeMixShader")
    glossy.inputs["Roughness"].default_value, both.inputs[0].default_value = 0.6, 0.25
    rough = nodes.new("ShaderNodeBsdfDiffuse")
    rough.inputs["Roughness"].default_value = 0.4
    links.new(rough.outputs[0], both.inputs[1])
    links.new(glossy.outputs[0], both.inputs[2])
    links.new(both.outputs[0], next(node for node in nodes if node.type == "OUTPUT_MATERIAL").inputs["Surface"])
    ours, theirs = (baked(square, target, "ROUGHNESS", engine, 4) for engine in ("AJAR", "CYCLES"))
    np.testing.assert_allclose(ours, 0.75 * 0.4 + 0.25 * 0.6, atol=2e-3)
    np.testing.assert_allclose(ours, theirs, atol=2e-3)


@pytest.mark.parametrize("subsurf", [False, True])
def test_baked_surfaces_are_not_displaced(build, square, target, subsurf):
    """Texels of displaced places would be black."""
    material = square.data.materials[0]
    nodes, links = material.node_tree.nodes, material.node_tree.links
    displacement = nodes.new("ShaderNodeDisplacement")
    displacement.inputs["Height"].default_value = 1.5
    links.new(displacement.outputs[0], next(node for node in nodes if node.type == "OUTPUT_MATERIAL").inputs["Displacement"])
    material.cycles.displacement_method = "DISPLACEMENT"
    if subsurf:
        bpy.context.scene.cycles.feature_set = "EXPERIMENTAL"
        square.cycles.use_adaptive_subdivision = True
        square.modifiers.new("Divide", "SUBSURF").subdivision_type = "SIMPLE"
    np.testing.assert_allclose(baked(square, target, "DIFFUSE", pass_filter={"COLOR"}), np.broadcast_to([0.8, 0.3, 0.1], (SIZE, SIZE, 3)), atol=2e-3)


def test_the_scene_is_exported_once_for_several_images(build, square, target, monkeypatch):
    from ajar_render import bake
    other = bpy.data.images.new("Other", SIZE, SIZE, float_buffer=True)
    mesh = build.mesh("Two", vertices=((-1, -1, 0), (0, -1, 0), (0, 1, 0), (-1, 1, 0), (0, -1, 0), (1, -1, 0), (1, 1, 0), (0, 1, 0)),
                      faces=((0, 1, 2, 3), (4, 5, 6, 7)))
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", 2 * [0, 0, 1, 0, 1, 1, 0, 1])
    thing = build.object(mesh, "Two")
    mesh.materials.append(diffuse(build, (0.5, 0.6, 0.7), target))
    mesh.materials.append(diffuse(build, (0.1, 0.2, 0.3), other))
    mesh.polygons[1].material_index = 1
    exports = []
    original = bake.export_scene
    monkeypatch.setattr(bake, "export_scene", lambda *more, **named: exports.append(1) or original(*more, **named))
    np.testing.assert_allclose(baked(thing, target, "DIFFUSE", pass_filter={"COLOR"}), np.broadcast_to([0.5, 0.6, 0.7], (SIZE, SIZE, 3)), atol=2e-3)
    pixels = np.empty(SIZE * SIZE * 4, dtype=np.float32)
    other.pixels.foreach_get(pixels)
    np.testing.assert_allclose(pixels.reshape(-1, 4)[:, :3], np.broadcast_to([0.1, 0.2, 0.3], (SIZE * SIZE, 3)), atol=2e-3)
    assert len(exports) == 1


@pytest.mark.parametrize(("in_interface", "displaced"), [(True, False), (True, True), (False, False)])
def test_selected_objects_share_one_export_unless_one_is_displaced(build, square, target, in_interface, displaced, monkeypatch):
    """Two squares above the active one, a red one and a green one, each over its half. The handlers are those that Blender calls for a bake of the interface."""
    from ajar_render import bake
    square.rotation_euler, square.location = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    others = []
    for name, x, colour in (("Left", -1, (0.9, 0.1, 0.1)), ("Right", 0, (0.1, 0.9, 0.1))):
        other = build.object(build.mesh(name, vertices=((x, -1, 0), (x + 1, -1, 0), (x + 1, 1, 0), (x, 1, 0))), name, location=(0, 0, 0.1))
        other.data.materials.append(diffuse(build, colour, target))
        others.append(other)
    if displaced:
        nodes, links = others[1].data.materials[0].node_tree.nodes, others[1].data.materials[0].node_tree.links
        links.new(nodes.new("ShaderNodeDisplacement").outputs[0], nodes["Material Output"].inputs["Displacement"])
    exports = []
    original = bake.export_scene
    monkeypatch.setattr(bake, "export_scene", lambda *more, **named: exports.append(1) or original(*more, **named))
    scene = bpy.context.scene
    scene.render.engine, scene.ajar.samples = "AJAR", 1
    for thing in (*others, square):
        thing.select_set(True)
    bpy.context.view_layer.objects.active = square
    for _ in range(2):   # a scene is never kept for the next bake
        exports.clear()
        if in_interface:
            bake._begin()
        bpy.ops.object.bake(type="DIFFUSE", pass_filter={"COLOR"}, use_selected_to_active=True, cage_extrusion=0.3, margin=0)
        bake._end()
        assert len(exports) == (1 if in_interface and not displaced else 2)
    pixels = np.empty(SIZE * SIZE * 4, dtype=np.float32)
    target.pixels.foreach_get(pixels)
    pixels = pixels.reshape(SIZE, SIZE, 4)[..., :3]
    np.testing.assert_allclose(pixels[:, :SIZE // 2], np.broadcast_to([0.9, 0.1, 0.1], (SIZE, SIZE // 2, 3)), atol=2e-3)
    np.testing.assert_allclose(pixels[:, SIZE // 2:], np.broadcast_to([0.1, 0.9, 0.1], (SIZE, SIZE // 2, 3)), atol=2e-3)


@pytest.mark.parametrize("fault", ["no UV map", "no size"])
def test_bakes_that_have_nowhere_to_go_name_the_object(build, square, target, fault):
    if fault == "no UV map":
        square.data.uv_layers.remove(square.data.uv_layers[0])
    else:
        node = next(node for node in square.data.materials[0].node_tree.nodes if node.type == "TEX_IMAGE")
        node.image = bpy.data.images.new("Nothing", 1, 1)
        node.image.source, node.image.filepath = "FILE", "//missing.png"
    with pytest.raises(RuntimeError, match=square.name):
        baked(square, target, "DIFFUSE", pass_filter={"COLOR"})


def test_a_scene_without_camera_and_light_bakes_black(scene, square, target):
    bpy.data.objects.remove(scene.camera)
    bpy.context.view_layer.update()
    assert (baked(square, target, "COMBINED") == 0.0).all()
