"""Images as in Cycles: a plane that emits the colours of a texture is rendered with both engines, which differ by at most 1e-3."""

import bpy
import numpy as np
import pytest
from ajar_render import checks
from plane_view import difference, look_at_plane, render

SIZE, MOST = 48, 1e-3


class Plane:
    """A square of 16 by 16 faces in front of the camera, whose UV map goes from `low` to `high`."""

    def __init__(self, build, low=0.0, high=1.0):
        steps = np.linspace(0.0, 1.0, 17)
        vertices = [(x, y, 0.0) for y in steps for x in steps]
        faces = [(i + 17 * j, i + 1 + 17 * j, i + 18 + 17 * j, i + 17 + 17 * j) for j in range(16) for i in range(16)]
        mesh = build.mesh("Plane", vertices, faces)
        self.material = build.material()
        mesh.materials.append(self.material)
        places = np.array([mesh.vertices[loop.vertex_index].co[:2] for loop in mesh.loops], dtype=np.float32)
        mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", (low + (high - low) * places + (0.003, 0.0017)).ravel())
        build.object(mesh)
        look_at_plane(bpy.context.scene, SIZE)

    def show(self, image, alpha=False, **settings):
        """Let the plane emit the image, times its alpha if `alpha` is set. Returns the texture node."""
        tree = self.material.node_tree
        tree.nodes.clear()
        output, emission, texture = (tree.nodes.new(f"ShaderNode{name}") for name in ("OutputMaterial", "Emission", "TexImage"))
        texture.image = image
        for name, value in ({"interpolation": "Closest"} | settings).items():
            setattr(texture, name, value)
        tree.links.new(emission.outputs[0], output.inputs[0])
        tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
        if alpha:
            tree.links.new(texture.outputs["Alpha"], emission.inputs["Strength"])
        return texture

    def difference(self, tmp_path):
        return difference(bpy.context.scene, tmp_path)


@pytest.fixture
def plane(build):
    return Plane(build)


@pytest.fixture
def write(tmp_path):
    """A function that writes a file of random pixels and returns its path."""

    def run(name, kind="PNG", depth="8", low=0.0, high=1.0, seed=1, opaque=False, mode="RGBA"):
        pixels = np.random.default_rng(seed).uniform(low, high, (5, 6, 4)).astype(np.float32)
        pixels[..., 3] = 1.0 if opaque else np.minimum(pixels[..., 3], 1.0)
        image = bpy.data.images.new("Pixels", 6, 5, alpha=True, float_buffer=True)
        image.colorspace_settings.name = "Non-Color"
        image.pixels.foreach_set(pixels.ravel())
        image.update()
        scene = bpy.data.scenes.new("Writer")
        scene.view_settings.view_transform = "Standard"
        scene.render.image_settings.file_format, scene.render.image_settings.color_mode = kind, mode
        if kind != "TARGA":
            scene.render.image_settings.color_depth = depth
        image.save_render(str(tmp_path / name), scene=scene)
        bpy.data.scenes.remove(scene)
        bpy.data.images.remove(image)
        return str(tmp_path / name)
    return run


@pytest.mark.parametrize("extension", ["REPEAT", "EXTEND", "CLIP"])
@pytest.mark.parametrize("interpolation", ["Closest", "Linear", "Cubic", "Smart"])
def test_interpolation_and_extension(build, write, tmp_path, interpolation, extension):
    plane = Plane(build, -0.7, 1.9)
    plane.show(bpy.data.images.load(write("a.png", low=0.45, high=0.55, opaque=True)), interpolation=interpolation, extension=extension)
    assert plane.difference(tmp_path)[0] <= MOST


FILES = {"png8": ("PNG", "8"), "png16": ("PNG", "16"), "targa": ("TARGA", ""), "half": ("OPEN_EXR", "16"), "float": ("OPEN_EXR", "32"), "tiff": ("TIFF", "16")}


@pytest.mark.parametrize("kind", FILES)
def test_files_and_packed_files_in_each_alpha_mode(plane, write, tmp_path, kind):
    image = bpy.data.images.load(write("picture", *FILES[kind], low=0.05, high=0.95 if FILES[kind][0] != "OPEN_EXR" else 4.0))
    packed = image.copy()
    packed.pack()
    for used in (image, packed):
        for mode in ("STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"):
            used.alpha_mode = mode
            for alpha in (False, True):
                plane.show(used, alpha)
                difference, mean = plane.difference(tmp_path)
                assert difference <= MOST and mean > 0.01, (used.name, mode, alpha)


@pytest.mark.parametrize("is_float", [False, True])
def test_generated_and_painted_images(plane, tmp_path, is_float):
    generated = bpy.data.images.new("Generated", 16, 16, alpha=True, float_buffer=is_float)
    generated.generated_color = (0.2, 0.5, 0.7, 0.6)
    grid = bpy.data.images.new("Grid", 16, 16, alpha=True, float_buffer=is_float)
    grid.generated_type = "COLOR_GRID"
    painted = bpy.data.images.new("Painted", 4, 4, alpha=True, float_buffer=is_float)
    painted.pixels.foreach_set(np.random.default_rng(3).random(64).astype(np.float32))
    for image in (generated, grid, painted):
        for mode in ("STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"):
            image.alpha_mode = mode
            for alpha in (False, True):
                plane.show(image, alpha)
                assert plane.difference(tmp_path)[0] <= MOST, (image.name, mode, alpha)


@pytest.mark.parametrize("kind", ["png8", "float"])
def test_every_color_space(plane, write, tmp_path, kind):
    image = bpy.data.images.load(write("picture", *FILES[kind], low=0.3, high=0.9))
    for space in image.colorspace_settings.bl_rna.properties["name"].enum_items.keys():
        image.colorspace_settings.name = space
        plane.show(image)
        assert plane.difference(tmp_path)[0] <= MOST, space


def test_tiles(build, write, tmp_path):
    plane = Plane(build, -1.0, 3.0)
    for number in (1001, 1002, 1011):
        write(f"tile.{number}.png", seed=number)
    image = bpy.data.images.load(str(tmp_path / "tile.1001.png"))
    image.source, image.filepath = "TILED", str(tmp_path / "tile.<UDIM>.png")
    assert [tile.number for tile in image.tiles] == [1001, 1002, 1011]
    for packed in (False, True):
        if packed:
            image.pack()
        for extension in ("REPEAT", "EXTEND", "CLIP"):
            plane.show(image, extension=extension)
            assert plane.difference(tmp_path)[0] <= MOST, (packed, extension)


# Automatic refresh, cyclic, offset, start, length
USERS = ((True, False, 0, 1, 5), (False, False, 0, 1, 5), (True, True, 0, 1, 5), (True, False, 2, 1, 3), (True, False, 0, 4, 2))


def set_user(node, settings):
    user = node.image_user
    user.use_auto_refresh, user.use_cyclic, user.frame_offset, user.frame_start, user.frame_duration = settings


@pytest.mark.parametrize("settings", USERS)
def test_sequences(plane, write, tmp_path, settings):
    for number in range(1, 6):
        write(f"frame{number:04}.png", seed=number)
    image = bpy.data.images.load(str(tmp_path / "frame0001.png"))
    image.source = "SEQUENCE"
    set_user(plane.show(image), settings)
    for frame in (0, 1, 3, 5, 7, 12):
        bpy.context.scene.frame_set(frame)
        assert plane.difference(tmp_path)[0] <= MOST, frame


@pytest.fixture
def movie(tmp_path):
    """A movie of eight frames, each of one grey."""
    scene = bpy.data.scenes.new("Movie")
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 1, False
    scene.render.resolution_x, scene.render.resolution_y, scene.frame_end = 64, 48, 8
    scene.camera = bpy.context.scene.camera
    scene.world = bpy.data.worlds.new("Grey")
    for frame in range(1, 9):
        scene.world.color = (frame / 10,) * 3
        scene.world.keyframe_insert("color", frame=frame)
    scene.view_settings.view_transform = "Standard"
    scene.render.image_settings.file_format, scene.render.use_file_extension = "AVI_JPEG", False
    scene.render.filepath = str(tmp_path / "movie.avi")
    bpy.ops.render.render(animation=True, scene=scene.name)
    bpy.data.scenes.remove(scene)
    return bpy.data.images.load(str(tmp_path / "movie.avi"))


def test_movies(plane, movie, tmp_path):
    assert movie.source == "MOVIE" and movie.frame_duration == 8
    for settings in USERS:
        set_user(plane.show(movie), settings)
        for frame in (1, 3, 7):
            bpy.context.scene.frame_set(frame)
            assert plane.difference(tmp_path)[0] <= MOST, (settings, frame)
    assert not bpy.data.textures


def test_two_frames_of_one_movie(plane, movie, tmp_path):
    first = plane.show(movie)
    tree = plane.material.node_tree
    second, mixed = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeMixRGB")
    second.image = movie
    set_user(first, (True, False, 0, 1, 8))
    set_user(second, (True, False, 3, 1, 8))
    for texture, socket in ((first, "Color1"), (second, "Color2")):
        tree.links.new(texture.outputs["Color"], mixed.inputs[socket])
    tree.links.new(mixed.outputs[0], next(node for node in tree.nodes if node.type == "EMISSION").inputs["Color"])
    bpy.context.scene.frame_set(2)
    assert plane.difference(tmp_path)[0] <= MOST


def test_a_missing_tile_is_reported_with_the_material_and_the_object(plane, write, tmp_path):
    write("tile.1001.png")
    image = bpy.data.images.load(str(tmp_path / "tile.1001.png"))
    image.source, image.filepath = "TILED", str(tmp_path / "tile.<UDIM>.png")
    image.tiles.new(tile_number=1012)
    plane.show(image)
    messages = [(name, text) for name, text in checks.check(bpy.context) if "is missing" in text]
    path = tmp_path / "tile.1012.png"
    assert messages == [(f"{image.name} 1012", f"is missing: {path}; magenta is used (material '{plane.material.name}' of object 'Object')")]


@pytest.mark.parametrize("kind", ["image", "tile"])
def test_a_corrupt_file_is_reported_with_the_material_and_the_object_and_the_render_goes_on(plane, write, tmp_path, kind):
    write("picture.1001.png")
    path = tmp_path / ("picture.1001.png" if kind == "image" else "picture.1012.png")
    image = bpy.data.images.load(str(tmp_path / "picture.1001.png"))
    if kind == "tile":
        image.source, image.filepath = "TILED", str(tmp_path / "picture.<UDIM>.png")
        image.tiles.new(tile_number=1012)
    path.write_bytes(b"\x89PNG\r\n\x1a\n and no picture")
    plane.show(image)
    name = image.name if kind == "image" else f"{image.name} 1012"
    found = [text for who, text in checks.check(bpy.context) if who == name]
    assert len(found) == 1
    assert "cannot be read" in found[0] and str(path) in found[0]
    assert found[0].endswith(f"magenta is used (material '{plane.material.name}' of object 'Object')")
    pixels = render(bpy.context.scene, "AJAR", tmp_path)
    assert np.isfinite(pixels).all() and pixels[:, 0].max() > 0.0


def test_a_corrupt_ies_file_is_reported_with_the_material_and_the_object_and_the_render_goes_on(plane, tmp_path):
    path = tmp_path / "lamp.ies"
    path.write_text("IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 broken")
    texture = plane.show(None)
    tree = plane.material.node_tree
    ies = tree.nodes.new("ShaderNodeTexIES")
    ies.mode, ies.filepath = "EXTERNAL", str(path)
    tree.links.new(ies.outputs[0], next(node for node in tree.nodes if node.type == "EMISSION").inputs["Color"])
    tree.nodes.remove(texture)
    found = [text for who, text in checks.check(bpy.context) if who == plane.material.name]
    assert len(found) == 1
    assert "its IES file cannot be used ('broken' is not a number)" in found[0]
    assert found[0].endswith(f"the light of material '{plane.material.name}' of object 'Object' is equal in all directions")
    assert np.isfinite(render(bpy.context.scene, "AJAR", tmp_path)).all()


def test_ten_thousand_nodes(plane, tmp_path):
    """A chain of groups in groups: ten nodes in each, four levels deep."""
    tree = None
    for level in range(4):
        inner, tree = tree, bpy.data.node_groups.new(f"Level {level}", "ShaderNodeTree")
        tree.inputs.new("NodeSocketFloat", "In")
        tree.outputs.new("NodeSocketFloat", "Out")
        last = tree.nodes.new("NodeGroupInput").outputs[0]
        for _ in range(10):
            node = tree.nodes.new("ShaderNodeMath" if inner is None else "ShaderNodeGroup")
            if inner is None:
                node.operation, node.inputs[1].default_value = "ADD", 1e-4
            else:
                node.node_tree = inner
            tree.links.new(last, node.inputs[0])
            last = node.outputs[0]
        tree.links.new(last, tree.nodes.new("NodeGroupOutput").inputs[0])
    texture = plane.show(None)
    nodes, links = plane.material.node_tree.nodes, plane.material.node_tree.links
    coordinates, group, emission = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeGroup"), next(node for node in nodes if node.type == "EMISSION")
    nodes.remove(texture)
    group.node_tree = tree
    links.new(coordinates.outputs["Generated"], group.inputs[0])
    links.new(group.outputs[0], emission.inputs["Color"])
    pixels = render(bpy.context.scene, "AJAR", tmp_path)[:, 0]
    x = (np.arange(SIZE) + 0.5) / SIZE
    expected = (x[None, :] + x[:, None]) / 3.0 + 1.0   # the mean of a vector; z is 0.5 or 0 on a flat object
    assert np.abs(pixels.reshape(SIZE, SIZE) - expected - (pixels[0] - expected[0, 0])).max() < 2e-3
    assert not [text for _, text in checks.check(bpy.context) if "too large" in text or "deeper" in text]
