"""Tests of renders by `blender -b`: passes, borders, formats, invalid input and interruption."""

import json
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from blender_process import BUILD, ROOT, TIMEOUT_SECONDS, command, endless_render, environment
from small_scenes import script

sys.path.insert(0, str(BUILD / "python"))
import ajar

RENDER_TO_FILE = ROOT / "tools" / "render_to_file.py"


@pytest.fixture
def render(blender, tmp_path):
    """A function that renders LIT_SQUARE, changed by a script, to a linear image of floats. Returns (pixels, output of Blender)."""

    def run(text: str = "", *options: object, name: str = "out.exr"):
        out = tmp_path / name
        result = blender("--python-exit-code", 1, "--python", script(tmp_path, text), "--python", RENDER_TO_FILE, "--",
                         "--output", out, *options)
        assert result.returncode == 0, result.stdout
        pixels = ajar.read_image(str(out))
        assert np.isfinite(pixels).all(), result.stdout
        return pixels, result.stdout
    return run


def test_radiance_of_the_lit_square_is_that_of_its_lamp(render):
    pixels, _ = render("lamp.data.shadow_soft_size = 0", "--ajar-samples", 16)
    assert pixels.shape == (24, 32, 4)
    # Blender's point lamp of P watts has intensity P / (4 pi); a diffuse surface of albedo a at the distance h below it has the radiance a / pi * P /
    # (4 pi h^2).
    power, albedo, height = 100, 0.8, 2
    np.testing.assert_allclose(pixels[11:13, 15:17, :3], albedo / np.pi * power / (4 * np.pi * height**2), rtol=0.02)


def test_png_has_the_view_transform(render):
    pixels, _ = render("scene.view_settings.view_transform = 'Standard'; lamp.data.energy = 20", name="out.png")
    linear, _ = render("lamp.data.energy = 20")
    np.testing.assert_allclose(pixels[..., :3], np.clip(linear[..., :3], 0, 1), atol=0.02)


def test_border_renders_its_region_and_crop_reduces_the_size(render):
    uniform = "scene.ajar.image = 'uniform'\n"   # adaptive sampling looks at the region alone
    border = uniform + "scene.render.use_border = True\nscene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75\n" \
             "scene.render.border_min_y, scene.render.border_max_y = 0.5, 1.0\n"
    full, _ = render(uniform)
    uncropped, _ = render(border)
    assert uncropped.shape[:2] == (24, 32)
    inside = np.zeros((24, 32), bool)
    inside[12:, 8:24] = True
    assert (uncropped[~inside] == 0).all()
    np.testing.assert_array_equal(uncropped[inside], full[inside])
    cropped, _ = render(border + "scene.render.use_crop_to_border = True")
    np.testing.assert_array_equal(cropped, full[12:, 8:24])


def test_same_seed_gives_the_same_image_for_any_number_of_threads(render):
    one, _ = render("", "--ajar-threads", 1, "--ajar-seed", 5)
    two, _ = render("", "--ajar-threads", 2, "--ajar-seed", 5)
    other, _ = render("", "--ajar-seed", 6)
    np.testing.assert_array_equal(one, two)
    assert (one != other).any()


def test_passes_are_written_with_their_names(blender, tmp_path):
    text = """
layer = scene.view_layers[0]
layer.use_pass_z = layer.use_pass_normal = layer.use_pass_position = layer.use_pass_uv = True
layer.use_pass_mist = layer.use_pass_object_index = layer.use_pass_material_index = True
layer.use_pass_emit = layer.use_pass_environment = True
layer.use_pass_diffuse_direct = layer.use_pass_diffuse_indirect = layer.use_pass_diffuse_color = True
layer.use_pass_glossy_direct = layer.use_pass_transmission_color = True
square.pass_index = 7
layer.ajar.use_pass_albedo = layer.ajar.use_pass_sample_count = layer.ajar.use_pass_variance = True
layer.ajar.use_pass_denoising = True
scene.ajar.image = "uniform"
"""
    result = blender("--python", script(tmp_path, text), "-o", tmp_path / "out", "-F", "OPEN_EXR_MULTILAYER", "-f", 1)
    assert result.returncode == 0, result.stdout
    center = {name: values[12, 16] for name, values in ajar.read_channels(str(tmp_path / "out0001.exr")).items()}
    layer = "ViewLayer."
    assert center[layer + "Depth.Z"] == pytest.approx(4, abs=0.01)
    assert center[layer + "Normal.Z"] == pytest.approx(1, abs=1e-4)
    assert center[layer + "Position.Z"] == pytest.approx(0, abs=1e-4)
    assert 0.0 <= center[layer + "UV.U"] <= 1.0
    assert center[layer + "Albedo.R"] == pytest.approx(0.8, abs=0.01)
    assert center[layer + "Denoising Albedo.R"] == pytest.approx(0.8, abs=0.01)
    assert center[layer + "Denoising Normal.Z"] == pytest.approx(1, abs=1e-4)
    assert center[layer + "Denoising Depth.Z"] == pytest.approx(4, abs=0.01)
    # The mist of Blender's world starts at 5 metres and is quadratic; the distance of the square is 4 metres.
    assert (center[layer + "Mist.Z"], center[layer + "IndexOB.X"], center[layer + "IndexMA.X"]) == (0, 7, 0)
    assert center[layer + "DiffCol.R"] == pytest.approx(0.8, abs=1e-5)
    assert center[layer + "DiffDir.R"] * center[layer + "DiffCol.R"] == pytest.approx(center[layer + "Combined.R"], rel=1e-4)
    for name in ("DiffInd.R", "Emit.R", "Env.R", "GlossDir.R", "TransCol.R"):
        assert center[layer + name] == 0, name
    assert center[layer + "Sample Count.X"] == 4
    assert center[layer + "Variance.X"] >= 0


def test_importance_of_a_collection_changes_samples_but_not_the_expected_image(blender, tmp_path):
    """Two squares side by side under one lamp, which differ only in their importance."""
    text = """
other = bpy.data.objects.new("Other", mesh)
square.location.x, other.location.x = -1, 1
heroes = bpy.data.collections.new("Heroes")
scene.collection.children.link(heroes)
heroes.objects.link(other)
heroes.ajar.importance, other.ajar.importance = 4, 2
scene.ajar.image, scene.ajar.samples = "pmc_ip", 32
ours = scene.view_layers[0].ajar
ours.use_pass_sample_count = ours.use_pass_error = ours.use_pass_perceptual_error = True
"""
    result = blender("--python", script(tmp_path, text), "-o", tmp_path / "out", "-F", "OPEN_EXR_MULTILAYER", "-f", 1)
    assert result.returncode == 0, result.stdout
    channels = ajar.read_channels(str(tmp_path / "out0001.exr"))
    left, right = ({name.removeprefix("ViewLayer."): values[:, columns].mean() for name, values in channels.items()}
                   for columns in (slice(0, 16), slice(16, 32)))
    assert left["Sample Count.X"] + right["Sample Count.X"] == pytest.approx(2 * 32)
    assert right["Sample Count.X"] > 4 * left["Sample Count.X"]
    assert right["Combined.G"] == pytest.approx(left["Combined.G"], rel=0.03)
    assert 0 < right["Error.X"] < left["Error.X"] and 0 < right["Perceptual Error.X"] < left["Perceptual Error.X"]


BAD = {
    "NaN vertex": "mesh.vertices[0].co.x = float('nan')",
    "empty mesh": "scene.collection.objects.link(bpy.data.objects.new('Nothing', bpy.data.meshes.new('Nothing')))",
    "zero scale": "square.scale = (0, 0, 0)",
    "mirrored": "square.scale = (-1, 1, 1)",
    "no light": "bpy.data.objects.remove(lamp)",
    "no geometry": "bpy.data.objects.remove(square)",
    "no world": "scene.world = None",
    "1x1 pixel": "scene.render.resolution_x = 4; scene.render.resolution_y = 4; scene.render.resolution_percentage = 25",
    "no modifiers' object": "square.modifiers.new('Boolean', 'BOOLEAN')",
}


@pytest.mark.parametrize("text", BAD.values(), ids=BAD.keys())
def test_invalid_input_gives_an_image(render, text):
    render(text)


def test_missing_image_is_magenta_and_reported_by_name(render):
    pixels, words = render("""
material = bpy.data.materials.new("Poster")
material.use_nodes = True
nodes, links = material.node_tree.nodes, material.node_tree.links
nodes.clear()
texture, emission, output = (nodes.new(f"ShaderNode{t}") for t in ("TexImage", "Emission", "OutputMaterial"))
texture.image = bpy.data.images.new("Lost picture", 1, 1)
texture.image.source, texture.image.filepath = "FILE", "/no/such/file.png"
links.new(texture.outputs["Color"], emission.inputs["Color"])
links.new(emission.outputs[0], output.inputs["Surface"])
mesh.materials.append(material)
""")
    assert "Lost picture" in words
    red, green, blue = pixels[12, 16, :3]
    assert red > 0.5 and blue > 0.5 and green < 0.1


def test_unknown_node_is_reported_once_by_name(render):
    _, words = render("""
material = bpy.data.materials.new("Velvet")
material.use_nodes = True
node = material.node_tree.nodes.new("ShaderNodeEeveeSpecular")
node.name = "Cartoon"
material.node_tree.links.new(node.outputs[0], material.node_tree.nodes["Material Output"].inputs["Surface"])
mesh.materials.append(material)
""")
    assert words.count("Cartoon") == 1 and "Velvet" in words


HOPELESS = {
    "no camera": ("bpy.data.objects.remove(camera)", "camera"),
    "equal clip planes": ("camera.name = 'Eye'; camera.data.clip_start = camera.data.clip_end = 1.0", "Eye"),
}


@pytest.mark.parametrize("text, word", HOPELESS.values(), ids=HOPELESS.keys())
def test_a_scene_that_cannot_be_rendered_ends_with_an_exit_code(blender, tmp_path, text, word):
    result = blender("--python", script(tmp_path, text), "-o", tmp_path / "out", "-f", 1)
    assert result.returncode != 0 and word in result.stdout, result.stdout
    assert not list(tmp_path.glob("out*"))


def test_two_view_layers_and_two_frames(blender, tmp_path):
    text = "scene.view_layers.new('Second')\nscene.frame_end = 2"
    result = blender("--python", script(tmp_path, text), "-o", tmp_path / "out", "-F", "PNG", "-a")
    assert result.returncode == 0, result.stdout
    assert len(list(tmp_path.glob("out*.png"))) == 2


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupt_writes_the_image_and_ends_blender(profile, tmp_path, number):
    process = endless_render(profile, tmp_path)
    process.send_signal(number)
    words, _ = process.communicate(timeout=TIMEOUT_SECONDS)
    assert process.returncode != 0, words
    assert (tmp_path / "out0001.png").exists() and not (tmp_path / "out0002.png").exists()
    assert (tmp_path / "stats.json").exists() and (tmp_path / "checkpoint").exists()


def test_a_resumed_render_continues(render, blender, tmp_path):
    checkpoint, stats = tmp_path / "checkpoint", tmp_path / "stats.json"
    first, _ = render("", "--ajar-samples", 4, "--ajar-checkpoint", checkpoint)
    second, _ = render("", "--ajar-samples", 16, "--ajar-resume", checkpoint, "--ajar-stats", stats)
    found = json.loads(stats.read_text())
    assert found["samples_per_pixel"]["mean"] == 16 and len(found["seeds"]) == 2 and found["resumed"]["samples"] == 4
    assert np.abs(first - second).max() > 0.0
    other = blender("--python-exit-code", 1, "--python", script(tmp_path, "lamp.data.energy *= 2"), "-o", tmp_path / "other", "-f", 1, "--",
                    "--ajar-resume", checkpoint)
    assert other.returncode != 0 and "different scenes" in other.stdout


def test_description_renders_the_same_without_blender(render, tmp_path):
    inside, _ = render("", "--ajar-dump-scene", tmp_path / "scene.ajar")
    session = ajar.Session()
    session.start(ajar.load_description(str(tmp_path / "scene.ajar")))
    while not session.wait(1.0):
        pass
    assert session.take_error() == ""
    np.testing.assert_array_equal(session.snapshot("Combined"), inside)


def test_generated_coordinates_ignore_displacement_by_modifiers(render):
    text = """
material = bpy.data.materials.new("Generated")
material.use_nodes = True
nodes, links = material.node_tree.nodes, material.node_tree.links
nodes.clear()
coordinates, emission, output = (nodes.new(f"ShaderNode{t}") for t in ("TexCoord", "Emission", "OutputMaterial"))
links.new(coordinates.outputs["Generated"], emission.inputs["Color"])
links.new(emission.outputs[0], output.inputs["Surface"])
mesh.materials.append(material)
"""
    plain, _ = render(text)
    moved, _ = render(text + "modifier = square.modifiers.new('Lift', 'DISPLACE')\nmodifier.direction, modifier.strength = 'X', 0.25\n"
                             "modifier.mid_level = -1.0\nsquare.location.x -= 0.5\n")
    assert plain[12, 16, 0] == pytest.approx(0.5, abs=0.05)
    np.testing.assert_allclose(moved[12, 12:20], plain[12, 12:20], atol=0.02)


def test_a_render_continues_from_the_checkpoint_of_a_killed_render(profile, blender, tmp_path):
    """The settings of the panel switch the checkpoint on, not the command line."""
    text = (f"scene.ajar.use_checkpoint = scene.ajar.use_resume = True\nscene.ajar.checkpoint_path = {str(tmp_path / 'kept.checkpoint')!r}\n"
            "scene.ajar.checkpoint_interval = 1\nscene.ajar.samples = {samples}")
    process = subprocess.Popen(command("--python", script(tmp_path, text.format(samples=2**20)), "-o", tmp_path / "out", "-F", "PNG", "-f", 1),
                               env=environment(profile), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    kept = tmp_path / "kept_0001.checkpoint"
    while not kept.exists() and process.poll() is None:
        time.sleep(0.05)
    process.kill()
    process.wait()
    assert kept.exists() and not (tmp_path / "out0001.png").exists()
    stats = tmp_path / "stats.json"
    result = blender("--python", script(tmp_path, text.format(samples=1)), "-o", tmp_path / "out", "-F", "PNG", "-f", 1, "--", "--ajar-stats", stats)
    assert result.returncode == 0, result.stdout
    assert json.loads(stats.read_text())["resumed"]["samples"] >= 1


STEREO = """
scene.render.use_multiview = True
scene.camera.data.stereo.convergence_mode, scene.camera.data.stereo.pivot = 'OFFAXIS', 'CENTER'
scene.camera.data.stereo.convergence_distance, scene.camera.data.stereo.interocular_distance = 2.0, 0.4
scene.render.image_settings.views_format = 'INDIVIDUAL'
"""


def test_both_eyes_are_rendered_from_where_blender_places_them(blender, tmp_path):
    """A view is the render of a camera at its place with its shift."""
    def images(text: str, *names: str) -> list[np.ndarray]:
        result = blender("--python-exit-code", 1, "--python", script(tmp_path, text), "--python", RENDER_TO_FILE, "--", "--output", tmp_path / "out.exr", "--ajar-samples", 8)
        assert result.returncode == 0, result.stdout
        return [ajar.read_image(str(tmp_path / name)) for name in names]
    left, right = images(STEREO, "out_L.exr", "out_R.exr")
    # The frame is 36 mm wide at the focal length; both eyes see the same rectangle at the distance of convergence.
    expected = [images(f"""
eye = {side} * 0.2
data = scene.camera.data
scene.camera.location.x = eye
data.shift_x = -eye / 2.0 * data.lens / data.sensor_width
""", "out.exr")[0] for side in (-1, 1)]
    for image, placed in zip((left, right), expected):
        np.testing.assert_allclose(image, placed, rtol=1e-3, atol=1e-3 * placed.max())
    assert np.abs(left - right).max() > 0.1 * left.max()
