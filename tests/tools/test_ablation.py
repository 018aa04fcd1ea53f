"""The table of what each part of a default render is worth."""

import math

import ablation


def scene(**errors: list[float]) -> dict:
    """A scene with the errors of some variants, one for each seed."""
    return {"scene": "box", "runs": [{"name": name.replace("_", " ").replace("no PMC IP", "no PMC-IP"), "seed": seed, "technique": "bdpt", "relmse": error, "noisy": 2.0 * error}
                                     for name, found in errors.items() for seed, error in enumerate(found, 1)]}


def test_a_part_is_worth_the_median_error_without_it_over_that_of_the_default():
    found = scene(default=[1.0, 9.0, 2.0], no_PMC_IP=[3.0, 4.0, 90.0])
    assert ablation.ratio(found, "no PMC-IP", "relmse") == 2.0
    assert math.isnan(ablation.ratio(found, "no hints", "relmse"))   # a scene without hints
    assert math.isnan(ablation.ratio(scene(default=[-0.1], no_PMC_IP=[1.0]), "no PMC-IP", "relmse"))   # the reference is not precise enough


def test_the_page_counts_the_scenes_in_which_a_part_pays():
    found = scene(default=[1.0], no_PMC_IP=[1.3], no_OCV=[1.1])
    page = ablation.page({"seconds": 10.0, "machine": {"threads": 2}, "scenes": [found, found]})
    assert "| box | bdpt | 1.10 | 1.30 | – | – |" in page
    assert "| at least 1.2 | | 0 of 2 | 2 of 2 | 0 of 0 | 0 of 0 |" in page
