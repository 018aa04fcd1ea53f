"""Renders for statistical tests. Blender exports each scene once, and `ajar-render` renders it as often as needed."""

import os
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(PROJECT / "benchmarks"))
sys.path.insert(0, str(Path(os.environ.get("AJAR_BUILD", PROJECT / "build" / "release")) / "python"))

import renderers  # noqa: E402


@pytest.fixture(scope="session")
def ajar_build():
    """The build under test, set by `make test`."""
    build = renderers.AjarBuild.default()
    for needed in (build.build / "ajar-render", build.build / "blender_profile" / "scripts" / "addons" / "ajar_render"):
        if not needed.exists():
            pytest.skip(f"{needed} was not built; run the tests by `make test`")
    return build


@pytest.fixture(scope="session")
def exported(ajar_build, tmp_path_factory):
    """exported(scene): the exported file of the scene, and the folder for its renders."""
    known = {}

    def export(scene):
        if scene.name not in known:
            folder = tmp_path_factory.mktemp(scene.name.replace("/", "_"))
            known[scene.name] = (*ajar_build.dump(scene.path, folder, scene.percentage), folder)
        return known[scene.name]

    return export
