"""Images, colour spaces and working spaces, compared with Cycles."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import compatibility
import pytest

LEAST = {"5.2.3": 70, "4.2.23": 50}   # cases. `make test` renders those of the first Blender, `make agreement` of both.
MOST = 2e-3   # a camera ray of the other engine passes up to 1/200 pixel away


@pytest.mark.parametrize("version", LEAST if "AJAR_AGREEMENT" in os.environ else list(LEAST)[:1])
def test_images_and_colors_are_those_of_cycles(zips, tmp_path, version):
    try:
        blender = compatibility.wheel(version, zips[0])
    except compatibility.Unavailable as reason:
        pytest.skip(f"not tried in Blender {version}: {reason}")
    out = tmp_path / "differences.json"
    result = subprocess.run([blender.command[0], Path(__file__).with_name("images_inside.py"), zips[0], out], text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, env=os.environ | {"BLENDER_USER_RESOURCES": str(tmp_path / "profile")}, timeout=300, check=False)
    assert out.is_file(), result.stdout
    differences = json.loads(out.read_text())
    assert len(differences) > LEAST[version]
    assert {name: difference for name, difference in differences.items() if difference > MOST} == {}
