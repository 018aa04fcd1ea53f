"""With Ajar, the Properties editor shows the same as with Cycles, except for the differences that are listed with a reason."""

import json
import sys
from pathlib import Path

import pytest

PANELS = Path(__file__).parent / "panels"
sys.path.insert(0, str(PANELS))
import differences  # noqa: E402
import inventory  # noqa: E402


@pytest.fixture(scope="module")
def compared(blender, tmp_path_factory):
    out = tmp_path_factory.mktemp("panels") / "cases.json"
    result = blender("--python-exit-code", 1, "--python", PANELS / "compare.py", "--", out)
    assert result.returncode == 0, result.stdout
    return json.loads(out.read_text())


@pytest.fixture(scope="module")
def cases(compared):
    return compared["cases"]


def problems(cases: list[dict]) -> list[str]:
    """Differences that are not in the list, and listed replacements that are not shown."""
    found = []
    for case in cases:
        cycles, ajar = ({tuple(shown) for shown in case[engine]} for engine in ("cycles", "ajar"))
        where = f"{case['tab']} {case['of']}".strip()
        for shown in sorted(cycles - ajar):
            if shown in differences.REPLACED:
                if differences.REPLACED[shown] not in ajar:
                    found.append(f"{where}: {'.'.join(differences.REPLACED[shown])} should stand for {'.'.join(shown)}")
            elif shown not in differences.ABSENT and shown[0] not in differences.ABSENT_STRUCTS:
                found.append(f"{where}: {'.'.join(shown)} is missing")
        found += [f"{where}: {'.'.join(shown)} is shown only by Ajar" for shown in sorted(ajar - cycles)
                  if not shown[0].startswith("Ajar") and shown not in differences.ADDED]
    return found


def different_passes(passes: dict[str, list[list[str]]]) -> list[str]:
    """Passes that are "read" in the inventory but differ between Ajar and Cycles, so that the compositor would lose links."""
    ours = {name: pass_ for name, *pass_ in passes["AJAR"]}
    return [f"{name}: {ours.get(name)} instead of {pass_}" for name, *pass_ in passes["CYCLES"]
            if inventory.fate_of(f"pass {name}") == "read" and name not in differences.PASSES and ours.get(name) != pass_]


def test_passes_have_the_names_and_channels_of_cycles(compared):
    assert different_passes(compared["passes"]) == []
    assert len(compared["passes"]["AJAR"]) > 25
    assert different_passes({"CYCLES": [["Depth", "Z", "VALUE"], ["Mist", "Z", "VALUE"]], "AJAR": [["Depth", "Z", "VALUE"]]}) == ["Mist: None instead of ['Z', 'VALUE']"]


def test_the_shader_editor_offers_the_nodes_that_it_offers_for_cycles(compared):
    assert compared["nodes"]["AJAR"] == compared["nodes"]["CYCLES"] and len(compared["nodes"]["AJAR"]) > 0


def test_all_differences_are_listed(cases):
    assert problems(cases) == []


def test_each_kind_of_object_was_recorded(cases):
    """The recorder finds important properties of each kind."""
    seen = {(case["tab"], case["of"]): {tuple(shown) for shown in case["ajar"]} for case in cases}
    assert len(seen) > 30
    assert {("template_node_view", "Surface"), ("template_node_view", "Volume"), ("template_node_view", "Displacement"),
            ("template_ID", "active_material")} <= seen["material", ""]
    assert {("Light", "type"), ("Light", "color"), ("AreaLight", "energy"), ("AreaLight", "size_y")} <= seen["data", "area lamp"]
    assert ("template_node_view", "Surface") in seen["world", ""]
    assert ("CameraDOFSettings", "aperture_fstop") in seen["data", "persp camera"]
    assert ("AjarObjectSettings", "hint_weight") in seen["object", "light hint"]
    assert ("Object", "visible_camera") in seen["object", "mesh"] and ("Object", "visible_camera") in seen["object", "sun lamp"]


def test_a_property_that_is_not_listed_is_found(cases):
    changed = json.loads(json.dumps(cases))
    changed[0]["cycles"].append(["RenderSettings", "new_in_the_next_version"])
    changed[0]["ajar"] = [shown for shown in changed[0]["ajar"] if shown != ["AjarSceneSettings", "samples"]]
    found = problems(changed)
    assert any("new_in_the_next_version is missing" in problem for problem in found)
    assert any("AjarSceneSettings.samples should stand for" in problem for problem in found)
