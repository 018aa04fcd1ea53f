"""The manual describes each integrator as the renderer does, and its pictures exist."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(Path(os.environ.get("AJAR_BUILD", ROOT / "build" / "release")) / "python"))
import ajar  # noqa: E402

MANUAL = ROOT / "docs" / "manual"
MAX_BYTES = 200_000


def test_every_integrator_has_a_paragraph_with_its_bias():
    text = (MANUAL / "rendering.md").read_text()
    for info in ajar.integrator_list():
        assert f"### {info.label}\n*{info.bias.name}: {info.sentence}*\n" in text, info.label
    assert re.findall(r"^### (.*)", text, re.M)[: len(ajar.integrator_list())] == [info.label for info in ajar.integrator_list()]


@pytest.mark.parametrize("page", sorted(path.name for path in MANUAL.glob("*.md")))
def test_pictures_and_pages_that_a_page_names_exist(page):
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", (MANUAL / page).read_text()):
        assert (MANUAL / target).is_file(), target


def test_pictures_are_small_and_all_are_used():
    pages = "".join(path.read_text() for path in [*MANUAL.glob("*.md"), ROOT / "README.md"])
    for picture in MANUAL.glob("*.jpg"):
        assert picture.stat().st_size <= MAX_BYTES and picture.name in pages, picture
