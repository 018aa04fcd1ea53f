"""Tests with scenes whose radiance is 1 everywhere, described in Python and rendered without Blender.

In a closed room with albedo a and emission 1 - a, and on any lossless surface under a white sky, every pixel is 1. The tests need no reference, and
any lost or gained energy changes the pixels.
"""

import numpy as np
import pytest

ajar = pytest.importorskip("ajar", reason="the Python package was not built for this Python; run the tests by `make test`")

IDENTITY = [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]]
CUBE = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], np.float32)
CUBE_FACES = np.array([[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2],
                       [1, 3, 7], [1, 7, 5]], np.uint32)


def sphere(rings=32):
    """The vertices, faces and smooth normals of the unit sphere."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rings + 1), np.arange(2 * rings) * np.pi / rings, indexing="ij")
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1).reshape(-1, 3)
    faces = []
    for ring in range(rings):
        for segment in range(2 * rings):
            a, b = ring * 2 * rings + segment, ring * 2 * rings + (segment + 1) % (2 * rings)
            if ring > 0:
                faces.append((a, a + 2 * rings, b))
            if ring < rings - 1:
                faces.append((b, a + 2 * rings, b + 2 * rings))
    return points.astype(np.float32), np.array(faces, np.uint32), points.astype(np.float32)


def scene(material, vertices, faces, normals=None, eye=4.0, size=32):
    """One object seen along -y from a distance of `eye` metres, with a field of view of 53 degrees. The limits of bounces are too high to have an effect."""
    description = ajar.SceneDescription()
    mesh = description.add_mesh(name="Mesh", positions=vertices, triangles=faces, normals=normals, normal_domain=ajar.Domain.Vertex)
    description.add_object(name="Object", mesh=mesh, materials=[description.add_material(name="Material", graph=material)])
    description.add_instances(np.array([0], np.int32), np.array(IDENTITY, np.float32))
    camera = description.camera
    camera.present, camera.clip_start, camera.clip_end = True, 1e-4, 1e4
    camera.world_from_camera = [1, 0, 0, 0, 0, 0, -1, -eye, 0, 1, 0, 0]
    camera.screen_window = (-0.5, 0.5, -0.5, 0.5)
    settings = description.settings
    settings.width = settings.height = size
    bounces = settings.bounces
    bounces.total = bounces.diffuse = bounces.glossy = bounces.transmission = 512
    settings.bounces = bounces
    settings.samples, settings.seed, settings.threads = 64, 3, 2
    description.settings, description.camera = settings, camera
    return description


def white_sky(description):
    world = description.world
    world.color = (1.0, 1.0, 1.0)
    description.world = world
    return description


def closure(kind, color=(1.0, 1.0, 1.0), **inputs):
    graph = ajar.NodeGraph()
    node = graph.add_node(kind, kind)
    graph.add_input(node, "Color", (*color, 1.0))
    for name, value in inputs.items():
        graph.add_input(node, name, (value, 0, 0, 0))
    graph.surface = ajar.NodeLink(node, "BSDF")
    return graph


def emitting_diffuse(albedo):
    graph = closure("ShaderNodeBsdfDiffuse", (albedo,) * 3)
    emission = graph.add_node("ShaderNodeEmission", "Emission")
    graph.add_input(emission, "Color", (1 - albedo,) * 3 + (1,))
    graph.add_input(emission, "Strength", (1, 0, 0, 0))
    both = graph.add_node("ShaderNodeAddShader", "Add Shader")
    graph.add_input(both, "Shader", link=ajar.NodeLink(0, "BSDF"))
    graph.add_input(both, "Shader_001", link=ajar.NodeLink(emission, "Emission"))
    graph.surface = ajar.NodeLink(both, "Shader")
    return graph


def render(description):
    session = ajar.Session()
    session.start(description)
    assert session.wait(120), "the render did not end"
    assert session.take_error() == ""
    return np.asarray(session.snapshot("Combined"))[..., :3]


def assert_is_one(image, tolerance):
    """The mean and every 8 x 8-pixel block are 1 within `tolerance` + 4 standard errors, estimated from the pixels of the block."""
    blocks = image.reshape(4, 8, 4, 8, 3).transpose(0, 2, 1, 3, 4).reshape(16, 64, 3)
    errors = blocks.std(axis=1, ddof=1) / 8
    excess = np.abs(blocks.mean(axis=1) - 1) - tolerance - 4 * errors
    assert (excess <= 0).all(), f"block means {blocks.mean(axis=(1, 2))}"
    assert abs(image.mean() - 1) <= tolerance + 4 * image.std() / np.sqrt(image.size / 3)


@pytest.mark.parametrize("albedo", [0.0, 0.2, 0.8])
def test_radiance_in_a_closed_room_is_one(albedo):
    """A high albedo tests Russian roulette and long paths; all cases test light sampling of 12 emissive triangles."""
    assert_is_one(render(scene(emitting_diffuse(albedo), CUBE, CUBE_FACES, eye=0.5)), 1e-4)


@pytest.mark.parametrize("material", [
    closure("ShaderNodeBsdfDiffuse", Roughness=0.0),
    closure("ShaderNodeBsdfGlass", Roughness=0.0, IOR=1.5),
    closure("ShaderNodeBsdfTransparent"),
    closure("ShaderNodeBsdfTranslucent"),
], ids=["diffuse", "glass", "transparent", "translucent"])
def test_radiance_of_a_lossless_ball_under_a_white_sky_is_one(material):
    assert_is_one(render(white_sky(scene(material, *sphere()))), 2e-3)


@pytest.mark.parametrize("roughness", [0.1, 0.4, 0.8])
def test_no_glossy_ball_gains_energy(roughness):
    """Without compensation, GGX loses the energy of multiple scattering. It must not gain energy."""
    graph = closure("ShaderNodeBsdfGlossy", Roughness=roughness)
    graph.add_property(0, "distribution", "MULTI_GGX")
    image = render(white_sky(scene(graph, *sphere())))
    assert 0.97 < image.mean() < 1.003
