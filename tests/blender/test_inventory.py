"""What becomes of every setting, part of a shader node, choice and pass is known, in Debian's Blender and in each bpy wheel that `make compat` has brought."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from blender_process import ROOT, TIMEOUT_SECONDS

PANELS = Path(__file__).parent / "panels"
sys.path.insert(0, str(PANELS))
import inventory  # noqa: E402

COMPAT = ROOT / "build" / "compat"
EXPECTED = ("bpy-4.2.23", "bpy-4.5.15", "bpy-5.0.1", "bpy-5.2.3")
WHEELS = sorted({*EXPECTED, *(path.parents[1].name for path in COMPAT.glob("bpy-*/bin/python"))})
NEW = "new_in_the_next_version"


def listed(folder: Path, name: str, *more: str) -> dict:
    """What things.py finds in a Blender; `more` are arguments of the program on the path."""
    out, script = folder / "things.json", PANELS / "things.py"
    python = COMPAT / name / "bin" / "python"
    if name != "installed" and not python.exists():
        pytest.skip(f"{python} is not there (make compat)")
    command = [os.environ.get("BLENDER", "blender"), "-b", "--factory-startup", *more, "--python", script, "--", out] if name == "installed" else [python, script, out]
    private = {key: str(folder) for key in ("BLENDER_USER_CONFIG", "BLENDER_USER_SCRIPTS", "BLENDER_USER_EXTENSIONS")}
    result = subprocess.run(list(map(str, command)), env=os.environ | private | {"PYTHONDONTWRITEBYTECODE": "1"}, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            timeout=TIMEOUT_SECONDS, check=False)
    assert result.returncode == 0, result.stdout[-4000:]
    return json.loads(out.read_text())


def parts(things: dict[str, list[str]]) -> set[tuple[str, str]]:
    return {(thing, choice) for thing, choices in inventory.relevant(things).items() for choice in choices or [""]}


def in_table(series: str | None = None) -> set[tuple[str, str]]:
    """Of one Blender, or of any."""
    return {(row.thing, choice) for row in inventory.rows() for choice in row.choices or [""] if series is None or row.states[series] != "-"}


def unlisted(found: dict) -> list[str]:
    """What the Blender has of which the table does not say what becomes of it."""
    series = inventory.series(found["blender"])
    known = in_table(series if series in inventory.rows()[0].states else None)
    return sorted(f"{thing} {choice}".strip() for thing, choice in parts(found["things"]) - known)


@pytest.mark.parametrize("name", ["installed", *WHEELS])
def test_all_that_a_blender_has_is_in_the_table(tmp_path, name):
    found = listed(tmp_path, name)
    assert len(found["things"]) > 1200
    assert unlisted(found) == []
    series = inventory.series(found["blender"])
    if series in inventory.rows()[0].states:
        assert sorted(in_table(series) - parts(found["things"])) == [], "make coverage writes the table anew"


def test_a_new_setting_fails(tmp_path):
    found = listed(tmp_path, "installed", "--python-expr", f"import bpy; bpy.types.Camera.{NEW} = bpy.props.FloatProperty()")
    assert unlisted(found) == [f"Camera.{NEW}"]


def test_a_blender_that_is_not_in_the_table_fails_with_what_it_has_more(tmp_path):
    found = listed(tmp_path, "installed") | {"blender": "9.1.0"}
    assert unlisted(found) == []   # all of it is known from another Blender
    found["things"] |= {"CyclesRenderSettings.new": [], "ShaderNodeNew output BSDF": [], "pass New": [], "Camera.type": ["PERSP", "NEW"]}
    assert unlisted(found) == ["Camera.type NEW", "CyclesRenderSettings.new", "ShaderNodeNew output BSDF", "pass New"]


def test_the_table_says_what_the_lists_say():
    rows = inventory.rows()
    words = {"exact", "same", "approximated", "reported", "read", "none", "-"}
    assert [row.thing for row in rows if not set(row.states.values()) <= words or set(row.states.values()) == {"-"}] == []
    assert [row.thing for row in rows if set(row.states.values()) & {"approximated", "none"} and not row.reason] == []
    settled = {row.thing: inventory.state_of(inventory.fate_of(row.thing)) for row in rows if not row.thing.startswith(("ShaderNode", "Node"))}
    contradicted = {"read": {"none"}, "none": {"read", "reported", "exact", "same", "approximated"}, "reported": {"none", "read"}}
    assert [row.thing for row in rows if row.thing in settled and (not settled[row.thing] or set(row.states.values()) & contradicted[settled[row.thing]])] == []
