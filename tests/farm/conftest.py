"""A scene that renders in a second, and the program ajar-farm with a Slurm that is none."""
from __future__ import annotations

from pathlib import Path

import pytest
from farm_program import ROOT, Farm

import ajar  # after farm_program, which finds it

SIZE = 24


@pytest.fixture(scope="session")
def scene(tmp_path_factory) -> Path:
    description = ajar.load_description(str(ROOT / "tests" / "render" / "materials_5.ajar"))
    description.settings.width = description.settings.height = SIZE
    description.settings.region = [0, 0, SIZE, SIZE]
    description.settings.passes = ["Combined", "Depth"]
    path = tmp_path_factory.mktemp("scene") / "scene.ajar"
    ajar.save_description(description, str(path))
    return path


@pytest.fixture
def farm(tmp_path) -> Farm:
    return Farm(tmp_path)
