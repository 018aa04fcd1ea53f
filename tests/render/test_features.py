"""Every feature gives the same image in both engines. benchmarks/feature_agreement.py compares scenes with one feature each
(test_scenes/features.py). `make test` renders some of them, `make agreement` all."""

import os

import feature_agreement


def test_features_agree_with_cycles(ajar_build, tmp_path):
    known = feature_agreement.features()
    names = list(known) if "AJAR_AGREEMENT" in os.environ else feature_agreement.SAMPLE
    samples = int(os.environ.get("AJAR_TEST_SAMPLES", "32"))
    found = [f for start in range(0, len(names), 8) for f in feature_agreement.compare(feature_agreement.debian_blender(ajar_build.build), tmp_path, names[start:start + 8], samples)]
    assert len(found) == len(names)
    differing = [f"{f.name}: {f.outside} of {f.blocks} blocks, {f.worst}" for f in found if not f.is_expected]
    assert not differing, "\n".join(differing)


def test_names_of_expected_differences_exist():
    """The name of an expected difference must be the name of an existing feature."""
    known = feature_agreement.features()
    assert set(feature_agreement.EXPECTED_DIFFERENCES) | set(feature_agreement.SAMPLE) <= set(known)
