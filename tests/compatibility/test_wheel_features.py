"""Light linking, shadow linking, shadow catchers, ray portals, attributes at the hits of Raycast, suns with extent, steep colour ramps, attributes of
instances, and what nodes read in many kinds of instances. Blender 3.4 has them not, only in part or in another form. They are compared with Cycles of a newer Blender."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import compatibility
import pytest


# `make test` renders each script in one Blender, `make agreement` in both.
SAMPLE = [("4.2.23", "linking_inside.py"), ("5.2.3", "portals_inside.py"), ("5.2.3", "suns_inside.py"), ("5.2.3", "instances_inside.py"),
          ("5.2.3", "outputs_inside.py")]
ALL = [*SAMPLE, ("5.2.3", "linking_inside.py"), ("4.2.23", "portals_inside.py"), ("4.2.23", "suns_inside.py"), ("4.2.23", "outputs_inside.py")]


@pytest.mark.parametrize("version, script", ALL if "AJAR_AGREEMENT" in os.environ else SAMPLE)
def test_features_of_newer_blenders_are_those_of_cycles(zips, tmp_path, version, script):
    try:
        blender = compatibility.wheel(version, zips[0])
    except compatibility.Unavailable as reason:
        pytest.skip(f"not tried in Blender {version}: {reason}")
    out = tmp_path / "differences.json"
    result = subprocess.run([blender.command[0], Path(__file__).with_name(script), zips[0], out], text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, env=os.environ | {"BLENDER_USER_RESOURCES": str(tmp_path / "profile")}, timeout=600, check=False)
    assert out.is_file(), result.stdout
    differences = json.loads(out.read_text())
    assert {name: found for name, found in differences.items() if found["excess"] > 1.0} == {}
