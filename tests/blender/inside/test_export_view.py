"""Tests of the export of lights, world, camera and settings."""

import bpy
import numpy as np
import pytest
from ajar_render.ajar_module import ajar
from ajar_render.headless import Options


def light(build, kind, **values):
    data = bpy.data.lights.new(kind.title(), kind)
    for name, value in values.items():
        setattr(data, name, value)
    return build.object(data, data.name, (1, 2, 3))


def test_values_of_lights_are_exported(build, export):
    light(build, "POINT", energy=10, shadow_soft_size=0.5, color=(1, 0.5, 0.25))
    light(build, "SPOT", spot_size=1.0, spot_blend=0.5)
    light(build, "SUN", angle=0.1, energy=2)
    light(build, "AREA", shape="RECTANGLE", size=2, size_y=3, spread=1.5)
    lights = {out.name: out for out in export().lights}
    point, spot, sun, area = (lights[name] for name in ("Point", "Spot", "Sun", "Area"))
    assert not spot.even_spot and not sun.even_sun
    assert not spot.has_uv and not sun.own_coordinates
    assert point.soft_falloff and spot.soft_falloff   # since 4.2 an option; 3.4 has no other lamps
    assert (point.kind, point.energy, point.radius, point.color) == (ajar.LightKind.Point, 10, 0.5, (1, 0.5, 0.25))
    assert point.world_from_light[3::4] == [1, 2, 3]
    assert (spot.kind, spot.spot_angle, spot.spot_blend) == (ajar.LightKind.Spot, 1.0, 0.5)
    assert (sun.kind, sun.energy) == (ajar.LightKind.Sun, 2)
    assert sun.sun_angle == pytest.approx(0.1)
    assert (area.kind, area.area_shape, area.area_size, area.spread) == (ajar.LightKind.Area, ajar.AreaShape.Rectangle, (2, 3), 1.5)


@pytest.mark.parametrize("shape, expected", [("SQUARE", (2, 2)), ("DISK", (2, 2)), ("ELLIPSE", (2, 3))])
def test_area_shapes(build, export, shape, expected):
    light(build, "AREA", shape=shape, size=2, size_y=3)
    out = export().lights[0]
    assert out.area_size == expected
    assert (out.area_shape == ajar.AreaShape.Ellipse) == (shape in ("DISK", "ELLIPSE"))


def test_instances_of_lights_are_lights(build, export):
    collection = bpy.data.collections.new("Lamps")
    collection.objects.link(bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT")))
    for x in range(3):
        empty = build.object(None, "Instance", (x, 0, 0))
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
    assert sorted(out.world_from_light[3] for out in export().lights) == [0, 1, 2]


def test_world_with_a_colour_with_a_graph_and_missing(export, scene):
    scene.world = None
    assert export().world.color == (0, 0, 0)
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = False
    scene.world.color = (0.25, 0.5, 0.75)
    assert export().world.color == (0.25, 0.5, 0.75)
    scene.world.use_nodes = True
    graph = export().world.graph
    assert graph.nodes[graph.surface.node].type == "ShaderNodeBackground"


def frame_of_blender(scene):
    """The corners of the view at z = -1, from Blender."""
    corners = np.array(scene.camera.data.view_frame(scene=scene))
    if scene.camera.data.type != "ORTHO":
        corners /= -corners[:, 2:]
    return corners[:, 0].min(), corners[:, 0].max(), corners[:, 1].min(), corners[:, 1].max()


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
@pytest.mark.parametrize("size", [(640, 480), (480, 640), (500, 500)])
def test_frame_of_the_camera_is_that_of_blender(export, scene, kind, fit, size):
    camera = scene.camera.data
    camera.type, camera.sensor_fit, camera.shift_x, camera.shift_y = kind, fit, 0.1, -0.2
    camera.lens, camera.sensor_height, camera.ortho_scale = 35, 20, 4
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = 1.0, 1.5
    np.testing.assert_allclose(export().camera.screen_window, frame_of_blender(scene), rtol=1e-5)


def test_values_of_panoramas_are_exported(export, scene):
    camera = scene.camera.data
    camera.type, camera.sensor_fit, camera.sensor_height, camera.cycles.panorama_type = "PANO", "VERTICAL", 20, "EQUIRECTANGULAR"
    scene.render.resolution_x, scene.render.resolution_y = 300, 200
    ours = camera.cycles
    ours.longitude_min, ours.longitude_max, ours.latitude_min, ours.latitude_max = -1, 2, -0.5, 0.25
    ours.fisheye_fov, ours.fisheye_lens, ours.fisheye_polynomial_k2 = 2.5, 8, 0.125
    out = export().camera
    assert (out.kind, out.panorama.kind) == (ajar.CameraKind.Panorama, ajar.PanoramaKind.Equirectangular)
    assert (out.screen_window, out.panorama.limits) == ((0, 1, 0, 1), (-1, 2, -0.5, 0.25))
    assert (out.panorama.fisheye_fov, out.panorama.fisheye_lens, out.panorama.polynomial[2]) == (2.5, 8, 0.125)
    assert out.panorama.sensor == pytest.approx((30, 20))
    kinds = {"FISHEYE_EQUIDISTANT": ajar.PanoramaKind.FisheyeEquidistant, "FISHEYE_EQUISOLID": ajar.PanoramaKind.FisheyeEquisolid,
             "MIRRORBALL": ajar.PanoramaKind.MirrorBall, "FISHEYE_LENS_POLYNOMIAL": ajar.PanoramaKind.FisheyePolynomial,
             "EQUIANGULAR_CUBEMAP_FACE": ajar.PanoramaKind.CubemapFace}
    for name, kind in kinds.items():
        ours.panorama_type = name
        camera.update_tag()
        assert export().camera.panorama.kind == kind


def test_camera_matrix_has_no_scale(export, scene):
    scene.camera.scale = (2, 3, 0.5)
    np.testing.assert_allclose(np.reshape(export().camera.world_from_camera, (3, 4))[:, :3], np.eye(3), atol=1e-6)


def test_depth_of_field(build, export, scene):
    camera = scene.camera.data
    assert export().camera.aperture_radius == 0
    camera.lens, camera.dof.use_dof, camera.dof.aperture_fstop = 50, True, 2.0
    camera.dof.focus_distance, camera.dof.aperture_blades = 7, 6
    out = export().camera
    assert out.aperture_radius == pytest.approx(0.0125)
    assert (out.focus_distance, out.blades) == (7, 6)
    camera.dof.focus_object = build.object(None, "Focus", (1, 0, 2))
    assert export().camera.focus_distance == pytest.approx(3.0)


def test_settings_take_cycles_values_until_they_are_set(export, scene):
    assert export().settings.samples == 64
    scene.cycles.samples = 17
    scene.cycles.max_bounces = 3
    scene.cycles.pixel_filter_type = "GAUSSIAN"
    settings = export().settings
    assert (settings.samples, settings.bounces.total, settings.filter) == (17, 3, ajar.FilterKind.Gaussian)
    scene.ajar.samples = 5
    scene.ajar.filter = "BOX"
    settings = export().settings
    assert (settings.samples, settings.bounces.total, settings.filter) == (5, 3, ajar.FilterKind.Box)
    assert scene.ajar.samples == 5


def test_command_line_overrides_the_scene(export, scene):
    scene.ajar.samples = 5
    settings = export(Options({"samples": 9, "seed": 3, "time_limit": 1.5, "noise_target": 0.01}, threads=2)).settings
    assert (settings.samples, settings.seed, settings.threads, settings.seconds) == (9, 3, 2, 1.5)
    assert settings.target_error == 0.01


def test_resolution_and_border(export, scene):
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = 101, 50, 50
    settings = export().settings
    assert (settings.width, settings.height, settings.region) == (50, 25, [0, 0, 50, 25])
    render.use_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.2, 0.6, 0.4, 1.0
    assert export().settings.region == [10, 10, 30, 25]


def test_a_missing_camera_is_left_to_the_core(export, scene):
    scene.camera = None
    assert not export().camera.present


def test_a_field_of_a_message_may_have_the_name_name(export_context):
    context = export_context()
    context.warn("Owner", "node {name} of {text}", name="Image Texture", text="a tree")
    assert ("Owner", "node Image Texture of a tree") in context.warnings


def test_settings_of_cycles_are_used_all_or_none(export, scene):
    assert not scene.ajar.use_cycles_settings
    assert (scene.ajar.samples, scene.ajar.noise_target, scene.ajar.use_denoise, scene.ajar.use_viewport_denoise) == (64, 0.0, False, False)
    scene.cycles.adaptive_threshold = 0.02
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = scene.cycles.use_preview_denoising = True
    scene.cycles.samples = 300
    assert scene.ajar.use_cycles_settings
    assert (scene.ajar.samples, scene.ajar.use_denoise, scene.ajar.use_viewport_denoise) == (300, True, True)
    assert scene.ajar.noise_target == pytest.approx(4e-4)
    assert export().settings.target_error == pytest.approx(4e-4)
    scene.cycles.use_adaptive_sampling = False
    assert scene.ajar.noise_target == 0.0
    scene.ajar.use_cycles_settings = False
    assert (scene.ajar.samples, scene.ajar.use_denoise, scene.ajar.use_viewport_denoise) == (64, False, False)


def test_reading_the_settings_of_cycles_sets_none(export, scene):
    """A pointer that is read, such as the dicing camera, counts as set in Blender. The next frame would then inherit the defaults of Cycles."""
    assert scene.cycles.dicing_camera is None
    export()
    assert not scene.ajar.use_cycles_settings
    assert (scene.ajar.samples, scene.ajar.use_denoise) == (64, False)
    scene.cycles.dicing_camera = scene.camera
    assert scene.ajar.use_cycles_settings


def test_number_of_samples_of_the_command_line_is_used(export, scene):
    scene.cycles.use_adaptive_sampling, scene.cycles.adaptive_threshold = True, 0.1
    assert export().settings.target_error == pytest.approx(0.01)
    assert export(Options({"samples": 8})).settings.target_error == 0.0
    scene.ajar.noise_target = 0.25   # set by the artist
    assert export(Options({"samples": 8})).settings.target_error == 0.25


def test_own_settings_can_be_reset(scene):
    scene.cycles.samples = 17
    scene.ajar.samples, scene.ajar.integrator = 5, "erpt"
    assert bpy.ops.ajar.inherit_settings() == {"FINISHED"}
    assert (scene.ajar.samples, scene.ajar.integrator) == (17, "erpt")


def test_noise_has_named_levels(scene):
    scene.ajar.noise_level = "GOOD"
    assert scene.ajar.noise_target == pytest.approx(1e-3)
    scene.ajar.noise_target = 0.5
    assert scene.ajar.noise_level == "CUSTOM"
    scene.ajar.noise_level = "OFF"
    assert scene.ajar.noise_target == 0.0


def test_light_hints_are_found_in_the_collection_of_older_files(scene):
    from ajar_render import hints
    old = bpy.data.collections.new("Light Paths")
    scene.collection.children.link(old)
    curve = bpy.data.objects.new("Hint", bpy.data.curves.new("Hint", "CURVE"))
    old.objects.link(curve)
    assert scene.ajar.hint_collection == "Light Hints" and hints.curves_of(scene) == [curve]
    scene.collection.children.link(bpy.data.collections.new("Light Hints"))
    assert hints.curves_of(scene) == []
    assert hasattr(bpy.ops.ajar.draw_light_path, "poll") and bpy.ops.ajar.check_light_paths.get_rna_type().identifier == "AJAR_OT_check_light_paths"


def test_the_exposure_of_the_display_is_exported(build, export):
    scene = bpy.context.scene
    assert export().settings.view_exposure == 1.0
    scene.view_settings.exposure = -3.0
    try:
        assert export().settings.view_exposure == 0.125
    finally:
        scene.view_settings.exposure = 0.0
