"""Runs each file of inside/ in its own Blender."""

from pathlib import Path

import pytest

INSIDE = Path(__file__).parent / "inside"


@pytest.mark.parametrize("name", sorted(path.name for path in INSIDE.glob("test_*.py")))
def test_inside(blender, name):
    result = blender("--python", INSIDE / "run.py", "--", INSIDE / name)
    assert result.returncode == 0, result.stdout
