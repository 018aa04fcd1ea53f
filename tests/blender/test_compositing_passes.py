"""Passes for compositing in `blender -b`: Cryptomatte with Blender's own node and against Cycles, AOVs, light groups, and motion vectors."""

import json
import struct
import sys

import numpy as np
import pytest
from blender_process import BUILD
from small_scenes import script

sys.path.insert(0, str(BUILD / "python"))
import ajar

# A ball, its child behind a half transparent sheet, hair, and an instance of a collection, out of focus.
STAGE = """
from math import radians
camera.location, camera.rotation_euler = (0, -6, 3), (radians(63), 0, 0)
camera.data.dof.use_dof, camera.data.dof.focus_distance, camera.data.dof.aperture_fstop = True, 5, 0.5
square.scale = (3, 3, 1)
def material(name, color):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    made.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*color, 1)
    return made
red, blue, sheer = material("Red", (0.8, 0.1, 0.1)), material("Bläuliches", (0.1, 0.1, 0.8)), material("Sheer", (0.5, 0.5, 0.5))
sheer.node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = 0.3
def add(operator, name, material, **options):
    operator(**options)
    bpy.context.object.name = name
    bpy.context.object.data.materials.append(material)
    return bpy.context.object
ball = add(bpy.ops.mesh.primitive_uv_sphere_add, "Ball", red, radius=0.6, location=(-0.8, 0, 0.6))
box = add(bpy.ops.mesh.primitive_cube_add, "Box", blue, size=0.8, location=(0.8, 0, 0.4))
box.parent = ball
box.matrix_parent_inverse = ball.matrix_world.inverted()
sheet = add(bpy.ops.mesh.primitive_plane_add, "Sheet", sheer, size=1.0, location=(0.8, -1, 0.6), rotation=(radians(90), 0, 0))
collection = bpy.data.collections.new("Copies")
collection.objects.link(add(bpy.ops.mesh.primitive_cone_add, "Cone", red, radius1=0.3, depth=0.8, location=(0, 1, 0.4)))
scene.collection.objects.unlink(bpy.data.objects["Cone"]) if "Cone" in scene.collection.objects else None
instancer = bpy.data.objects.new("Instancer", None)
instancer.instance_type, instancer.instance_collection = "COLLECTION", collection
scene.collection.objects.link(instancer)
layer = scene.view_layers[0]
layer.use_pass_cryptomatte_object = layer.use_pass_cryptomatte_material = layer.use_pass_cryptomatte_asset = True
layer.pass_cryptomatte_depth = 6
scene.render.resolution_x, scene.render.resolution_y = 48, 36
scene.ajar.samples = SAMPLES
import sys
if "CYCLES" in sys.argv:
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = "CPU", SAMPLES, False, False
"""
SAMPLES = 64


def stage(text: str = "", samples: int = SAMPLES) -> str:
    return STAGE.replace("SAMPLES", str(samples)) + text


@pytest.fixture(scope="module")
def rendered(blender, tmp_path_factory):
    """A function that renders STAGE, changed by a script, to a multilayer EXR. Returns its path and the output of Blender."""

    def run(text: str = "", engine: str = "AJAR", samples: int = SAMPLES):
        folder = tmp_path_factory.mktemp("stage")
        result = blender("--python-exit-code", 1, "--python", script(folder, stage(text, samples)), "-o", folder / "out", "-F", "OPEN_EXR_MULTILAYER", "-f", 1, "--", engine)
        assert result.returncode == 0 and (folder / "out0001.exr").exists(), result.stdout
        return folder / "out0001.exr", result.stdout
    return run


def mattes(path, kind: str) -> dict[int, np.ndarray]:
    """The coverage of each id of a matte."""
    channels = {name.removeprefix("ViewLayer."): values for name, values in ajar.read_channels(str(path)).items()}
    found: dict[int, np.ndarray] = {}
    for number in range(8):
        for id_name, coverage_name in (("r", "g"), ("b", "a")):
            ids = channels.get(f"{kind}{number:02}.{id_name}")
            if ids is None:
                continue
            coverage = channels[f"{kind}{number:02}.{coverage_name}"]
            bits = ids.astype(np.float32).view(np.uint32)
            for value in np.unique(bits[coverage > 0]):
                found.setdefault(int(value), np.zeros(ids.shape))
                found[int(value)] += np.where(bits == value, coverage, 0)
    return found


MOVING = """
scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1
for frame, x in ((0, -1.2), (2, -0.4)):
    ball.location.x = x
    ball.keyframe_insert("location", frame=frame)
for curve in ball.animation_data.action.fcurves:
    for point in curve.keyframe_points:
        point.interpolation = "LINEAR"
square.modifiers.new("Hair", "PARTICLE_SYSTEM")
hair = square.particle_systems[0].settings
hair.type, hair.count, hair.hair_length, hair.root_radius = "HAIR", 40, 0.6, 4
scene.frame_set(1)
"""


@pytest.mark.parametrize("text", ["", MOVING], ids=["still", "moving, with hair"])
def test_mattes_are_those_of_cycles(rendered, text):
    """The same ids bit for bit, and coverages that differ by noise. A pixel with few samples has a standard deviation of at most 0.5 / sqrt(samples)."""
    ours, theirs = rendered(text)[0], rendered(text, engine="CYCLES")[0]
    for kind, count in (("CryptoObject", 5), ("CryptoMaterial", 4), ("CryptoAsset", 4)):
        found, expected = mattes(ours, kind), mattes(theirs, kind)
        shown = {key for key, values in expected.items() if values.sum() > 0.5}
        assert len(shown) >= count and shown <= set(found), kind
        for key in shown:
            difference = found[key] - expected[key]
            assert np.sqrt((difference**2).mean()) < 2 * 0.5 / np.sqrt(SAMPLES), (kind, hex(key))
            assert abs(difference.mean()) < 4 * 0.5 / np.sqrt(SAMPLES * difference.size), (kind, hex(key))


def test_metadata_names_the_ids(rendered):
    """OpenEXR stores each field as its name, its type and its text."""
    path, _ = rendered(samples=4)
    data = path.read_bytes()
    prefix = f"cryptomatte/{ajar.name_hash('ViewLayer.CryptoObject'):08x}"[:19]

    def field(name: str) -> str:
        start = data.index(f"{prefix}/{name}\0string\0".encode()) + len(f"{prefix}/{name}\0string\0")
        return data[start + 4:start + 4 + struct.unpack("<i", data[start:start + 4])[0]].decode()
    assert field("name") == "ViewLayer.CryptoObject" and field("hash") == "MurmurHash3_32" and field("conversion") == "uint32_to_float32"
    manifest = json.loads(field("manifest"))
    assert manifest["Ball"] == f"{ajar.name_hash('Ball'):08x}" and {"Square", "Box", "Cone", "Sheet"} <= set(manifest)
    assert "Bläuliches".encode() in data


NODE = """
scene.use_nodes = True
tree = scene.node_tree
tree.nodes.clear()
tree.nodes.new("CompositorNodeRLayers")   # otherwise Blender does not render
node = tree.nodes.new("CompositorNodeCryptomatteV2")
node.source = "SOURCE"
if "SOURCE" == "RENDER":
    node.scene = scene
else:
    node.image = bpy.data.images.load("PATH")
node.layer_name = "ViewLayer.CryptoObject"
node.matte_id = "Box"
output = tree.nodes.new("CompositorNodeComposite")
tree.links.new(node.outputs["Matte"], output.inputs["Image"])
scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
"""


@pytest.mark.parametrize("source", ["RENDER", "IMAGE"])
def test_blenders_node_picks_the_object(blender, rendered, tmp_path, source):
    path, _ = rendered()
    expected = mattes(path, "CryptoObject")[int(np.float32(ajar.matte_id("Box")).view(np.uint32))]
    text = stage(NODE.replace("SOURCE", source).replace("PATH", str(path)))
    result = blender("--python-exit-code", 1, "--python", script(tmp_path, text), "-o", tmp_path / "matte", "-f", 1)
    assert result.returncode == 0, result.stdout
    picked = ajar.read_image(str(tmp_path / "matte0001.exr"))[..., 0]
    assert picked.max() > 0.9
    np.testing.assert_allclose(picked, expected, atol=2e-3)


def test_aov_nodes_write_their_passes(rendered):
    text = """
for name, kind in (("heat", "VALUE"), ("tint", "COLOR"), ("unused", "COLOR")):
    layer.aovs.add().name = name
    layer.aovs[-1].type = kind
for used in (red, blue):
    nodes, links = used.node_tree.nodes, used.node_tree.links
    for name in ("heat", "tint"):
        aov = nodes.new("ShaderNodeOutputAOV")
        if hasattr(aov, "aov_name"):
            aov.aov_name = name
        else:
            aov.name = name
        color = nodes.new("ShaderNodeRGB")
        color.outputs[0].default_value = (0.2, 0.4, 0.6, 1)
        links.new(color.outputs[0], aov.inputs["Color"])
        if used is blue:
            aov.inputs["Value"].default_value = 5
            value = nodes.new("ShaderNodeValue")
            value.outputs[0].default_value = 5
            links.new(value.outputs[0], aov.inputs["Value"])
"""
    path, said = rendered(text)
    other, _ = rendered(text, engine="CYCLES")
    ours, theirs = ajar.read_channels(str(path)), ajar.read_channels(str(other))
    # Behind the sheet, Cycles weights values by its probability of passing the sheet instead of by the transparency.
    for name in ("heat.X", "tint.R", "tint.G", "tint.B", "tint.A", "unused.R"):
        difference = ours[f"ViewLayer.{name}"] - theirs[f"ViewLayer.{name}"]
        assert abs(difference.mean()) < 0.04 * (abs(theirs[f"ViewLayer.{name}"].mean()) + 1e-6), name
        assert np.sqrt((difference**2).mean()) < 0.1 * (theirs[f"ViewLayer.{name}"].max() + 1e-6), name
    assert theirs["ViewLayer.heat.X"].max() > 4.9 and theirs["ViewLayer.tint.G"].max() > 0.39
    assert 'Red: its AOV Output heat has a link only at Color' in said


def test_light_groups_add_up_to_the_image(rendered):
    text = """
scene.world = bpy.data.worlds.new("Sky")
scene.world.color = (0.2, 0.3, 0.4)
for name in ("key", "sky"):
    layer.lightgroups.add(name=name)
lamp.lightgroup, scene.world.lightgroup = "key", "sky"
"""
    path, _ = rendered(text, samples=32)
    ours = ajar.read_channels(str(path))
    other, _ = rendered(text, engine="CYCLES", samples=256)
    theirs = ajar.read_channels(str(other))
    for channel in "RGB":
        total = sum(ours[f"ViewLayer.Combined_{group}.{channel}"] for group in ("key", "sky"))
        np.testing.assert_allclose(total, ours[f"ViewLayer.Combined.{channel}"], rtol=1e-4, atol=1e-5)
        for group in ("key", "sky"):
            mine, his = (found[f"ViewLayer.Combined_{group}.{channel}"].mean() for found in (ours, theirs))
            assert mine == pytest.approx(his, rel=0.02) and mine > 0.001, group


def test_motion_vectors_and_occlusion_are_those_of_cycles(rendered):
    text = """
layer.use_pass_vector = layer.use_pass_ambient_occlusion = True
camera.data.dof.use_dof = False
def animate(thing, attribute, places):
    for frame, place in places.items():
        setattr(thing, attribute, place)
        thing.keyframe_insert(attribute, frame=frame)
animate(ball, "location", {0: (-1.0, 0, 0.6), 1: (-0.8, 0, 0.6), 2: (-0.5, 0, 0.7)})
animate(camera, "location", {0: (0, -6, 2.8), 1: (0.1, -6, 3), 2: (0.3, -6.1, 3)})
sheet.shape_key_add(name="Basis")
key = sheet.shape_key_add(name="Bent")
for point in key.data:
    point.co.z += 0.5 * point.co.x
for frame in (0, 1, 2):
    key.value = 0.3 * frame
    key.keyframe_insert("value", frame=frame)
scene.frame_set(1)
"""
    ours, theirs = (ajar.read_channels(str(rendered(text, engine=engine)[0])) for engine in ("AJAR", "CYCLES"))
    for channel in "XYZW":
        mine, his = ours[f"ViewLayer.Vector.{channel}"], theirs[f"ViewLayer.Vector.{channel}"]
        assert np.abs(his).max() > 0.5, channel
        # At edges, the mean over the filter mixes objects.
        assert np.median(np.abs(mine - his)) < 0.01 and np.mean(np.abs(mine - his) > 0.15) < 0.06, channel
    mine, his = ours["ViewLayer.AO.R"], theirs["ViewLayer.AO.R"]
    assert mine.mean() == pytest.approx(his.mean(), rel=0.01) and 0.1 < his.mean() < 0.99
    assert np.sqrt(((mine - his)**2).mean()) < 0.06
