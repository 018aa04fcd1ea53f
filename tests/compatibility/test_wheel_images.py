"""Images, colour spaces and working spaces of the newest Blender, compared with its Cycles."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import compatibility
import pytest

NEWEST = "5.2.3"
MOST = 2e-3   # a camera ray of the other engine passes up to 1/200 pixel away


def test_images_and_colors_are_those_of_cycles(zips, tmp_path):
    try:
        blender = compatibility.wheel(NEWEST, zips[0])
    except compatibility.Unavailable as reason:
        pytest.skip(f"not tried in Blender {NEWEST}: {reason}")
    out = tmp_path / "differences.json"
    result = subprocess.run([blender.command[0], Path(__file__).with_name("images_inside.py"), zips[0], out], text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, env=os.environ | {"BLENDER_USER_RESOURCES": str(tmp_path / "profile")}, timeout=300, check=False)
    assert out.is_file(), result.stdout
    differences = json.loads(out.read_text())
    assert len(differences) > 70
    assert {name: difference for name, difference in differences.items() if difference > MOST} == {}
