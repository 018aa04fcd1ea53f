"""The same seed gives bitwise the same image with any number of threads; another seed gives another image."""

import numpy as np
import pytest
import scenes


@pytest.mark.parametrize("name", ["box", "room", "plant"])
def test_images_do_not_depend_on_threads(name, ajar_build, exported):
    scene_file, _, folder = exported(scenes.find_scenes([name])[0])
    images = {threads: ajar_build.render(scene_file, folder / f"{threads}_threads", [3], [5], threads)[0].image() for threads in (1, 2, 8)}
    assert np.isfinite(images[1]).all() and images[1].max() > 0
    assert np.array_equal(images[1], images[2])
    assert np.array_equal(images[1], images[8])


def test_another_seed_gives_another_image(ajar_build, exported):
    scene_file, _, folder = exported(scenes.find_scenes(["box"])[0])
    first, second = (render.image() for render in ajar_build.render(scene_file, folder / "seeds", [2], [1, 2], 2))
    assert (first != second).mean() > 0.5
