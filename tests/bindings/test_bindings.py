"""Tests of the package `ajar` without Blender: scenes from arrays, images, scene files and errors."""

from __future__ import annotations

import json
import operator
import os
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(os.environ.get("AJAR_BUILD", Path(__file__).resolve().parents[2] / "build" / "release")) / "python"))
import ajar

HANG = 3600.0  # seconds; a limit that only a hang reaches, so that no test depends on the speed of the machine
IDENTITY = np.eye(3, 4, dtype=np.float32).reshape(1, 12)


def emission(strength: float = 1.0) -> ajar.NodeGraph:
    graph = ajar.NodeGraph()
    node = graph.add_node("ShaderNodeEmission", "Emission")
    graph.add_input(node, "Color", (1.0, 1.0, 1.0, 1.0))
    graph.add_input(node, "Strength", (strength, 0.0, 0.0, 0.0))
    graph.surface = ajar.NodeLink(node, "Emission")
    return graph


def square(samples: int = 4, width: int = 16, height: int = 12, reach: float = 9.0) -> ajar.SceneDescription:
    """An emissive square, which fills the frame unless `reach` is small."""
    description = ajar.SceneDescription()
    material = description.add_material(name="Glow", graph=emission(2.0))
    mesh = description.add_mesh(name="Square", positions=[(-reach, -reach, 0), (reach, -reach, 0), (reach, reach, 0), (-reach, reach, 0)],
                                triangles=[(0, 1, 2), (0, 2, 3)])
    thing = description.add_object(name="Square", mesh=mesh, materials=[material])
    description.add_instances([thing], IDENTITY)
    camera = description.camera
    camera.present, camera.name = True, "Camera"
    rows = IDENTITY[0].tolist()
    rows[11] = 3.0
    camera.world_from_camera = rows
    settings = description.settings
    settings.width, settings.height, settings.region, settings.samples = width, height, [0, 0, width, height], samples
    return description


def render(description: ajar.SceneDescription) -> ajar.Session:
    session = ajar.Session()
    session.start(description)
    while not session.wait(1.0):
        pass
    return session


def test_image_of_an_emissive_square_is_its_radiance():
    session = render(square())
    assert session.take_error() == ""
    picture = session.snapshot("Combined")
    assert picture.shape == (12, 16, 4) and picture.dtype == np.float32
    np.testing.assert_allclose(picture, np.tile([2, 2, 2, 1], (12, 16, 1)), rtol=1e-6)
    assert session.progress().phase == ajar.Progress.Phase.Done
    assert json.loads(session.statistics_json())["refused_samples"] == 0


def test_start_empties_the_description_unless_kept():
    description = square()
    session = ajar.Session()
    session.start(description, keep=True)
    assert len(description.meshes) == 1
    session = ajar.Session()
    session.start(description)
    assert len(description.meshes) == 0


def test_scene_file_keeps_all_data(tmp_path):
    description = square()
    path = str(tmp_path / "scene.ajar")
    ajar.save_description(description, path)
    loaded = ajar.load_description(path)
    np.testing.assert_array_equal(loaded.meshes[0].positions, description.meshes[0].positions)
    assert loaded.materials[0].graph.nodes[0].inputs[1].value[0] == 2.0
    np.testing.assert_array_equal(render(loaded).snapshot("Combined"), render(description).snapshot("Combined"))


def test_damaged_file_is_an_error_that_names_it(tmp_path):
    path = tmp_path / "scene.ajar"
    ajar.save_description(square(), str(path))
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(RuntimeError):
        ajar.load_description(str(path))
    with pytest.raises(RuntimeError, match="nothing.ajar"):
        ajar.load_description(str(tmp_path / "nothing.ajar"))


def test_a_missing_camera_is_reported_once():
    description = square()
    description.camera.present = False
    session = render(description)
    assert "camera" in session.take_error().lower()
    assert session.take_error() == ""
    assert session.progress().phase == ajar.Progress.Phase.Failed


@pytest.mark.parametrize("bad", [
    {"positions": np.zeros((3, 2))},
    {"triangles": np.zeros((1, 4))},
    {"normals": np.zeros((3, 4))},
    {"attributes": [("UV", ajar.Domain.Corner)]},
    {"attributes": [("UV", ajar.Domain.Corner, np.zeros((3, 5)))]},
])
def test_arrays_with_a_wrong_shape_raise_an_error_with_their_name(bad):
    good = {"name": "Mesh", "positions": np.zeros((3, 3)), "triangles": [(0, 1, 2)]}
    with pytest.raises(ValueError, match="Mesh"):
        ajar.SceneDescription().add_mesh(**(good | bad))


def test_error_of_an_unknown_pass_lists_the_valid_passes():
    with pytest.raises(ValueError, match="Combined"):
        ajar.Session().snapshot("Bogus")


def test_cancel_ends_an_endless_render():
    session = ajar.Session()
    session.start(square(samples=2**24))
    while session.progress().samples < 1:
        time.sleep(0.01)
    session.cancel()
    assert session.wait(HANG)
    assert session.progress().phase == ajar.Progress.Phase.Cancelled


def test_waiting_releases_python():
    session = ajar.Session()
    session.start(square(samples=2**24))
    waiter = threading.Thread(target=session.wait, args=(HANG,))
    waiter.start()
    for _ in range(20):
        assert waiter.is_alive()
        time.sleep(0.01)
    session.cancel()
    waiter.join()


def test_several_sessions_run_at_the_same_time():
    sessions = [ajar.Session() for _ in range(3)]
    for number, session in enumerate(sessions):
        session.start(square(samples=number + 1))
    for session in sessions:
        assert session.wait(HANG)
    for number, session in enumerate(sessions):
        assert session.progress().samples == number + 1


def test_deleting_a_session_stops_its_render():
    session = ajar.Session()
    session.start(square(samples=2**24))
    del session  # without a stop, this would not return


@pytest.mark.parametrize("name, tolerance", [("x.exr", 0.0), ("x.png", 0.005)])
def test_images_are_read_back_from_a_file(tmp_path, name, tolerance):
    picture = np.random.default_rng(1).random((5, 7, 4), dtype=np.float32)
    picture[..., 3] = 1.0
    ajar.write_image(str(tmp_path / name), picture, {"note": "hello"})
    np.testing.assert_allclose(ajar.read_image(str(tmp_path / name)), picture, atol=tolerance)


def test_png_keeps_premultiplied_alpha(tmp_path):
    picture = np.zeros((2, 2, 4), np.float32)
    picture[:] = (0.25, 0.125, 0.0, 0.5)
    ajar.write_image(str(tmp_path / "x.png"), picture)
    np.testing.assert_allclose(ajar.read_image(str(tmp_path / "x.png")), picture, atol=0.005)


def test_channels_have_the_expected_names(tmp_path):
    ajar.write_image(str(tmp_path / "x.exr"), np.ones((2, 3, 4), np.float32) * (1, 2, 3, 4))
    channels = ajar.read_channels(str(tmp_path / "x.exr"))
    assert {name: values[0, 0] for name, values in channels.items()} == {"R": 1, "G": 2, "B": 3, "A": 4}


@pytest.mark.parametrize("name", ["x.jpg", "noending", "no/such/folder/x.png"])
def test_error_of_an_image_that_cannot_be_written_has_its_path(tmp_path, name):
    with pytest.raises(RuntimeError, match="cannot write"):
        ajar.write_image(str(tmp_path / name), np.zeros((2, 2, 3), np.float32))


def test_shown_photons_are_arrays_of_positions_and_powers():
    def floor_below_the_light() -> ajar.SceneDescription:
        description = square()
        graph = ajar.NodeGraph()
        node = graph.add_node("ShaderNodeBsdfDiffuse", "Diffuse")
        graph.add_input(node, "Color", (0.5, 0.5, 0.5, 1.0))
        graph.surface = ajar.NodeLink(node, "BSDF")
        material = description.add_material(name="Grey", graph=graph)
        mesh = description.add_mesh(name="Floor", positions=[(-9, -9, -1), (9, -9, -1), (9, 9, -1), (-9, 9, -1)], triangles=[(0, 1, 2), (0, 2, 3)])
        description.add_instances([description.add_object(name="Floor", mesh=mesh, materials=[material])], IDENTITY)
        return description

    description = floor_below_the_light()
    description.settings.integrator = "photon_map"
    session = render(description)
    assert session.take_error() == ""
    positions, powers, stored = session.photons(500)
    assert positions.dtype == powers.dtype == np.float32 and positions.shape == powers.shape == (len(positions), 3)
    assert 400 < len(positions) <= 500 < stored
    np.testing.assert_allclose(positions[:, 2], -1.0, atol=1e-5)
    assert (powers > 0).all()
    positions, powers, stored = render(floor_below_the_light()).photons()
    assert positions.shape == powers.shape == (0, 3) and stored == 0


def test_instances_emit_values_of_their_own():
    """Two squares of one object. One of them has a row of values, the other one has the value of the object."""
    description = square(reach=1.0)
    graph = ajar.NodeGraph()
    attribute, node = graph.add_node("ShaderNodeAttribute", "Attribute"), graph.add_node("ShaderNodeEmission", "Emission")
    graph.add_property(attribute, "attribute_type", "INSTANCER")
    graph.add_property(attribute, "attribute_name", "shade")
    graph.add_input(node, "Color", link=ajar.NodeLink(attribute, "Color"))
    graph.add_input(node, "Strength", (1.0, 0.0, 0.0, 0.0))
    graph.surface = ajar.NodeLink(node, "Emission")
    thing = description.add_object(name="Shaded", mesh=0, materials=[description.add_material(name="Shade", graph=graph)],
                                   properties=[("shade", True, (0.25, 0.5, 1.0, 1.0), 1)])
    rows = np.repeat(IDENTITY, 2, axis=0)
    rows[:, 3], rows[:, 11] = (-1.1, 1.1), 0.5   # before the square, left and right
    description.add_instances([thing, thing], rows)
    for bad in ([1], [9] * 7), ([1, 2], [9] * 8):
        with pytest.raises(ValueError, match="values"):
            description.set_instance_values(bad[0], 2, bad[1])
    description.set_instance_values([2], 2, [9, 9, 9, 9, 4, 5, 6, 1])
    with pytest.raises(ValueError, match="columns"):
        description.set_instance_values([1], 1, [0, 0, 0, 0])
    with pytest.raises(IndexError):
        description.set_instance_values([3], 2, [0] * 8)
    row = render(description).snapshot("Combined")[6]
    np.testing.assert_allclose(row[5, :3], (0.25, 0.5, 1.0), rtol=1e-5)
    np.testing.assert_allclose(row[10, :3], (4, 5, 6), rtol=1e-5)


def test_every_setting_is_listed_with_its_default():
    settings = ajar.RenderSettings()
    listed = {info.name: info for info in ajar.setting_list()}
    fields = {name for name, item in vars(ajar.RenderSettings).items() if isinstance(item, property)} - {"bounces"}
    fields |= {f"bounces.{name}" for name, item in vars(ajar.BounceLimits).items() if isinstance(item, property)}
    assert set(listed) == fields and len(ajar.setting_list()) == len(fields)
    for name, info in listed.items():
        value = operator.attrgetter(name)(settings)
        assert info.text.endswith("."), name
        if info.type == "choice":
            names = [choice[0] for choice in info.choices]
            assert info.default in names and info.property_default in names, name
            assert not isinstance(value, str) or value == info.default, name
        else:
            assert value == info.default, name
        if info.type in ("int", "float"):
            assert info.minimum <= info.default <= info.maximum, name
            assert info.minimum <= info.property_minimum <= info.property_maximum <= info.maximum, name


def test_unknown_choices_are_refused_by_name():
    settings = ajar.RenderSettings()
    with pytest.raises(ajar.SceneError, match="Unknown direct light method 'best'. Valid names: mis, "):
        settings.direct = "best"
    assert settings.direct == "mis"
    settings.guiding = "auto"
    assert settings.guiding == "auto"


def test_denoise_refuses_wrong_shapes_and_a_missing_library():
    image = np.zeros((4, 5, 4), dtype=np.float32)
    with pytest.raises(ValueError, match=r"\[4, 5, 6 for each technique\]"):
        ajar.denoise(image, halves=np.zeros((4, 5, 3), dtype=np.float32))
    with pytest.raises(ValueError, match="albedo must be an array"):
        ajar.denoise(image, albedo=np.zeros((3, 5, 3), dtype=np.float32))
    if not ajar.denoiser.load():
        with pytest.raises(RuntimeError, match="no-such-library"):
            ajar.load_denoiser("/no-such-library.so")
        assert ajar.denoiser_version() == "" and ajar.denoiser.reason()
        with pytest.raises(RuntimeError, match="not loaded"):
            ajar.denoise(image)


def test_the_quality_of_the_denoiser_follows_the_rays_per_pixel():
    quality, named = ajar.denoiser.quality_for, ajar.DenoiseQuality
    large = 1920 * 1080
    rays_per_pixel, expected = (1.0, 150.0, 300.0, 1000.0), [named.Fastest, named.Fast, named.Balanced, named.High]
    assert [quality(rays * large, large) for rays in rays_per_pixel] == expected
    assert [quality(rays * 500.0, 500, 0.0) for rays in rays_per_pixel] == expected
    assert quality(1.0, 500) == named.Balanced   # it takes less than the free time


@pytest.mark.skipif(not ajar.denoiser.load(), reason="needs Open Image Denoise 2 (AJAR_DENOISER)")
def test_every_quality_denoises_and_a_cancelled_call_returns_none():
    rng = np.random.default_rng(1)
    image = (0.5 + 0.2 * rng.standard_normal((64, 64, 4))).astype(np.float32)
    guide = np.full((64, 64, 3), 0.5, dtype=np.float32)
    for quality in ajar.DenoiseQuality.__members__.values():
        result, error = ajar.denoise(image, albedo=guide, normal=guide, quality=quality)
        assert error is None
        assert result[8:-8, 8:-8, :3].std() < 0.05
        assert abs(result[..., :3].mean() - 0.5) < 0.02
    noise = rng.standard_normal((64, 64, 6)).astype(np.float32)
    halves = 0.5 + 0.1 * noise
    errors = {}
    for name, quality in ajar.DenoiseQuality.__members__.items():
        _, errors[name] = ajar.denoise(image, halves, guide, guide, quality, error=True)
        assert errors[name].shape == (64, 64) and 0 < errors[name].mean() < 0.01
        _, error = ajar.denoise(image, halves, guide, guide, quality)
        assert (error is None) == (name in ("Fast", "Fastest"))   # these estimate it only when asked
    assert np.array_equal(errors["Fast"], errors["Fastest"]), "the small network estimates both"
    cancellation = ajar.Cancellation()
    cancellation.set()
    assert ajar.denoise(image, cancellation=cancellation) is None


@pytest.mark.skipif(not ajar.denoiser.load(), reason="needs Open Image Denoise 2 (AJAR_DENOISER)")
def test_a_noise_target_refers_to_the_denoised_image():
    samples = {}
    for denoised in (False, True):
        description = square(samples=1 << 16, width=64, height=48, reach=0.5)
        description.camera.aperture_radius, description.camera.focus_distance = 1.0, 1.0
        description.settings.target_error, description.settings.denoised = 1e-3, denoised
        description.settings.passes = ["Combined", "Halves"]
        session = render(description)
        samples[denoised] = session.progress().samples
        assert (session.progress().denoised_relmse >= 0) == denoised
        assert 0 <= session.progress().shown_relmse <= 1e-3
    assert 16 <= samples[True] < 0.7 * samples[False], samples


@pytest.mark.skipif(not ajar.denoiser.load(), reason="needs Open Image Denoise 2 (AJAR_DENOISER)")
@pytest.mark.parametrize("samples", [2, 31, 64])
def test_the_picture_of_a_view_is_the_denoised_image_of_its_last_sample(samples):
    """Below 32 samples from one run of the small network, then in the same way as the final image, with the quality that its rays allow."""
    description = square(samples=samples, width=96, height=64, reach=0.5)
    description.camera.aperture_radius, description.camera.focus_distance = 1.0, 1.0
    session = ajar.Session()
    session.show_pictures(True)
    number = session.update(description)
    assert session.wait(HANG)
    picture = session.take_picture()
    assert picture.not_denoised == session.take_error() == ""
    assert (picture.render, picture.samples, picture.divider, picture.coarse_light) == (number, samples, 1, False)
    image, halves, albedo, normal = (session.snapshot(name) for name in ("Combined", "Halves", "Denoising Albedo", "Denoising Normal"))
    rays = json.loads(session.statistics_json())["rays"]
    pixels = picture.take_pixels()
    if samples < 32:
        larger, _ = ajar.denoise(image, None, albedo, normal, ajar.DenoiseQuality.Fastest)   # a network of the library, too
        assert 0.0 < np.sqrt(np.mean((pixels - larger) ** 2)) < 0.25 * np.sqrt(np.mean((image - larger) ** 2))
    else:
        expected, _ = ajar.denoise(image, halves, albedo, normal, ajar.denoise_quality_for(rays, 96 * 64, 0.0, separates=False))
        np.testing.assert_allclose(pixels, expected, rtol=1e-3, atol=1e-4)
    assert np.abs(pixels - image).max() > 0.01
    # The final image differs by its quality: the means agree.
    final, _ = ajar.denoise(image, halves, albedo, normal, ajar.DenoiseQuality.High)
    assert abs(pixels[..., :3].mean() / final[..., :3].mean() - 1.0) < 0.05
    assert session.take_picture() is None


def test_a_snapshot_during_a_render_with_pictures_has_the_size_of_its_image():
    description = square(samples=4, width=400, height=300)
    session = ajar.Session()
    session.show_pictures(True)
    session.update(description)
    sizes = set()
    while not session.wait(0.0):
        picture = session.snapshot("Combined")
        if picture is not None:
            sizes.add(picture.shape)
    sizes.add(session.snapshot("Combined").shape)
    assert (300, 400, 4) in sizes and all(abs(4 * height - 3 * width) < 4 for height, width, _ in sizes), sizes


def test_halves_are_two_means_of_the_image_and_unknown_for_one_sample():
    description = square(samples=4)
    description.settings.passes = ["Combined", "Halves"]
    session = render(description)
    halves = session.snapshot("Halves")
    assert halves.shape == (12, 16, 6)
    np.testing.assert_allclose(0.5 * (halves[..., :3] + halves[..., 3:]), session.snapshot("Combined")[..., :3], rtol=1e-6)
    description = square(samples=1)
    description.settings.passes = ["Combined", "Halves"]
    assert np.isnan(render(description).snapshot("Halves")).all()
