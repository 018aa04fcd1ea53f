"""Images of Ajar agree with those of Cycles: the means of 16 x 16-pixel blocks are within 1 % + 3 standard errors of the references in test_scenes/references.

AJAR_TEST_SAMPLES sets the samples per pixel of each of eight replicates (default 32). More samples make the tests stricter. A difference of a block
that is caused by noise disappears with four times the samples; a bias does not.

The test takes long: `make agreement` runs it, `make test` does not.
"""

import os

import agreement
import exceptions
import images
import numpy as np
import pytest
import references
import scenes

pytestmark = pytest.mark.skipif("AJAR_AGREEMENT" not in os.environ, reason="a long study: make agreement")

REPLICATES = 8
CONVERGED = 0.03
SAMPLES = int(os.environ.get("AJAR_TEST_SAMPLES", "32"))
THREADS = os.cpu_count() or 1
# The image that belongs to the scene, and the texture outside of its folder that the scene needs.
IGNIS = {"shared/ignis_box": ("ref-cycles-box-4096.exr", None), "shared/ignis_roughness": ("ref-cycles-roughness-8192.exr", "grid_weight.png"),
         "shared/ignis_tex": ("ref-cycles-tex-4096.exr", "boats.jpg")}


def need_scene(scene):
    if not scene.path.exists():
        if scene in scenes.SHARED_SCENES:
            pytest.skip(f"{scene.path} does not exist: shared scenes are not part of the project")
        pytest.fail(f"{scene.path} is missing")


def replicates_of(ajar_build, scene_file, folder):
    """Images of independent renders without refused samples."""
    renders = ajar_build.render(scene_file, folder / "replicates", [SAMPLES], list(range(1, REPLICATES + 1)), THREADS)
    assert [render.statistics["refused_samples"] for render in renders] == [0] * REPLICATES
    return [render.image() for render in renders]


def report(scene, found, blocks):
    lines = [f"{scene.name}: {len({(d.row, d.column) for d in found})} of {blocks.means[..., 0].size} blocks disagree; the worst:"]
    return "\n".join(lines + [f"  {disagreement}" for disagreement in found[:12]])


@pytest.mark.parametrize("scene", scenes.ALL_SCENES, ids=lambda scene: scene.name)
def test_blocks_agree_with_cycles(scene, ajar_build, exported):
    need_scene(scene)
    if not scene.reference.exists():
        pytest.skip(f"no reference yet; make it: benchmarks/references.py {scene.name}")
    reference = references.load_reference(scene)
    assert reference.origin["blend_sha256"] == references.file_hash(scene.path), (
        f"{scene.path.name} changed since its reference was made; make it again: benchmarks/references.py {scene.name}")
    if reference.noise > CONVERGED:
        # A reference with few samples can miss rare bright paths. Then its mean and its standard error are not reliable.
        pytest.skip(f"the reference is not converged ({reference.noise:.0%}); make it again with more time: "
                    f"benchmarks/references.py {scene.name} --seconds 1800")
    scene_file, _, folder = exported(scene)
    mean, variance = agreement.mean_and_variance(replicates_of(ajar_build, scene_file, folder))
    ours = agreement.blocks_of_pixels(mean, variance, REPLICATES, reference.origin["block_size"])
    found = exceptions.unexpected(scene.name, agreement.disagreements(ours, reference.blocks))
    assert not found, report(scene, found, ours)


@pytest.mark.parametrize("scene", [s for s in scenes.SHARED_SCENES if s.name in IGNIS], ids=lambda scene: scene.name)
def test_blocks_agree_with_the_references_of_ignis(scene, ajar_build, tmp_path):
    """Images that others rendered with Cycles, with a known number of samples and the clamps of their files. Their noise is assumed to be that of
    Ajar, scaled to their number of samples."""
    need_scene(scene)
    image_name, texture = IGNIS[scene.name]
    if texture and not (scenes.SHARED.parent / "textures" / texture).exists():
        pytest.skip(f"{scenes.SHARED.parent / 'textures' / texture} does not exist: the texture of the scene was not shared")
    image = images.read_exr(scenes.SHARED / "ignis" / image_name)
    samples = int(images.read_exr_text(scenes.SHARED / "ignis" / image_name)["cycles.ViewLayer.samples"])
    scene_file, _ = ajar_build.dump(scene.path, tmp_path, scene.percentage, unclamped=False)
    mean, variance = agreement.mean_and_variance(replicates_of(ajar_build, scene_file, tmp_path))
    ours = agreement.blocks_of_pixels(mean, variance, REPLICATES)
    theirs = agreement.Blocks(agreement.block_means(image), ours.standard_errors * np.sqrt(SAMPLES * REPLICATES / samples), REPLICATES, 16)
    found = exceptions.unexpected(scene.name, agreement.disagreements(ours, theirs))
    assert not found, report(scene, found, ours)
