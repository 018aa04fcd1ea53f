"""The inventory lists every setting, part of a shader node, choice and pass, of Debian's Blender and of each bpy wheel that `make compat` has downloaded."""

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
    """The result of things.py in a Blender. `more` are further arguments of Blender."""
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
    """The parts that the table lists for one Blender, or for any."""
    return {(row.thing, choice) for row in inventory.rows() for choice in row.choices or [""] if series is None or row.states[series] != "-"}


def unlisted(found: dict) -> list[str]:
    """The parts of the Blender that the table does not list."""
    series = inventory.series(found["blender"])
    known = in_table(series if series in inventory.rows()[0].states else None)
    return sorted(f"{thing} {choice}".strip() for thing, choice in parts(found["things"]) - known)


@pytest.mark.parametrize("name", ["installed", *WHEELS])
def test_all_parts_of_a_blender_are_in_the_table(tmp_path, name):
    found = listed(tmp_path, name)
    assert len(found["things"]) > 1200
    assert unlisted(found) == []
    series = inventory.series(found["blender"])
    if series in inventory.rows()[0].states:
        assert sorted(in_table(series) - parts(found["things"])) == [], "run make coverage to write the table again"


def test_a_new_setting_is_found(tmp_path):
    found = listed(tmp_path, "installed", "--python-expr", f"import bpy; bpy.types.Camera.{NEW} = bpy.props.FloatProperty()")
    assert unlisted(found) == [f"Camera.{NEW}"]


def test_new_parts_of_an_unlisted_blender_are_found(tmp_path):
    found = listed(tmp_path, "installed") | {"blender": "9.1.0"}
    assert unlisted(found) == []   # the table lists all of them for another Blender
    found["things"] |= {"CyclesRenderSettings.new": [], "ShaderNodeNew output BSDF": [], "pass New": [], "Camera.type": ["PERSP", "NEW"]}
    assert unlisted(found) == ["Camera.type NEW", "CyclesRenderSettings.new", "ShaderNodeNew output BSDF", "pass New"]


def test_the_table_agrees_with_the_lists():
    rows = inventory.rows()
    words = {"exact", "same", "approximated", "reported", "read", "none", "-"}
    assert [row.thing for row in rows if not set(row.states.values()) <= words or set(row.states.values()) == {"-"}] == []
    assert [row.thing for row in rows if set(row.states.values()) & {"approximated", "none"} and not row.reason] == []
    settled = {row.thing: inventory.state_of(inventory.fate_of(row.thing)) for row in rows if not row.thing.startswith(("ShaderNode", "Node"))}
    contradicted = {"read": {"none"}, "none": {"read", "reported", "exact", "same", "approximated"}, "reported": {"none", "read"}}
    assert [row.thing for row in rows if row.thing in settled and (not settled[row.thing] or set(row.states.values()) & contradicted[settled[row.thing]])] == []
