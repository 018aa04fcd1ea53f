"""With Ajar, the editors other than Properties offer the same as with Cycles: headers, sidebars, menus and operators. New datablocks and dropped
materials are the same.

Quick Favourites are not tested: Blender makes them from the same operators and properties.
"""

import json
import os
import shutil
import subprocess
import sys
from fnmatch import fnmatchcase
from pathlib import Path

import pytest
from blender_process import TIMEOUT_SECONDS, environment

PANELS = Path(__file__).parent / "panels"
WINDOW = Path(__file__).parent / "window"
sys.path.insert(0, str(PANELS))
import differences  # noqa: E402

pytestmark = pytest.mark.skipif(shutil.which("Xvfb") is None, reason="needs Xvfb (tools/setup.sh test)")

OURS = ("AJAR_", "NODE_AJAR_", "CYCLES_", "NODE_CYCLES_")   # panels of one engine; their contents are compared together


@pytest.fixture(scope="module")
def result(profile, display, tmp_path_factory):
    folder = tmp_path_factory.mktemp("editors")
    process = subprocess.run(
        [os.environ.get("BLENDER", "blender"), "--factory-startup", "--enable-event-simulate", "--window-geometry", "0", "0", "960", "600", "--addons", "ajar_render", "--python",
         str(WINDOW / "drive.py"), "--", str(WINDOW / "editors.py"), str(folder / "result.json"), str(folder)],
        env=environment(profile) | {"DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1"}, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=2 * TIMEOUT_SECONDS, check=False)
    assert process.returncode == 0, f"exit code {process.returncode}\n{process.stdout}"
    return json.loads((folder / "result.json").read_text())


def shown_by(seen: dict[str, list[list[str]]], of_engines: bool) -> dict[str, set[tuple[str, str]]]:
    """What the panels of the engines show, all together, or what every other header, panel and menu shows, by its name."""
    found: dict[str, set[tuple[str, str]]] = {}
    for name, shown in seen.items():
        if name.startswith(OURS) == of_engines:
            found.setdefault("panels" if of_engines else name, set()).update((kind, what) for kind, what in shown if not kind.startswith("ajar.") and not what.startswith("ajar."))
    return found


def problems(editors: dict[str, dict]) -> list[str]:
    """The differences that are in no list."""
    found = []
    for editor, engines in editors.items():
        cycles, ajar = (shown_by(engines[engine]["seen"], False) for engine in ("CYCLES", "AJAR"))
        for name in sorted({*cycles, *ajar}):
            a, b = cycles.get(name, set()), ajar.get(name, set())
            found += [f"{editor}: {name}: {what} is {'missing' if what in a else 'shown by Ajar alone'}" for what in sorted(a ^ b) if what not in differences.ABSENT_IN_EDITORS]
        cycles, ajar = (shown_by(engines[engine]["seen"], True).get("panels", set()) for engine in ("CYCLES", "AJAR"))
        for shown in sorted(cycles - ajar):
            stands = differences.REPLACED.get(shown)
            if stands not in ajar and shown not in differences.ABSENT and shown not in differences.ABSENT_IN_EDITORS:
                found.append(f"{editor}: {stands or shown} is missing in the panels")
        found += [f"{editor}: {shown} is shown only by Ajar's panels" for shown in sorted(ajar - cycles)
                  if not shown[0].startswith("Ajar") and shown not in differences.ADDED and shown not in differences.ADDED_IN_EDITORS]
        cycles, ajar = (set(engines[engine]["operators"]) for engine in ("CYCLES", "AJAR"))
        found += [f"{editor}: the operator {name} can be called with {'Cycles' if name in cycles else 'Ajar'} alone" for name in sorted(cycles ^ ajar)
                  if not (name.startswith("ajar.") and name in ajar) and not any(fnmatchcase(name, pattern) for pattern in differences.OPERATORS)]
    return found


def test_all_differences_are_listed(result):
    assert problems(result["editors"]) == []


def test_a_difference_that_is_not_listed_is_found(result):
    changed = json.loads(json.dumps(result["editors"]))
    material = changed["shader editor, BsdfPrincipled"]
    material["CYCLES"]["seen"]["NODE_CYCLES_MATERIAL_PT_settings"].append(["Material", "new_in_the_next_version"])
    material["CYCLES"]["seen"]["MATERIAL_MT_context_menu"].append(["operator", "material.new_in_the_next_version"])
    material["AJAR"]["operators"].remove("material.new")
    found = problems(changed)
    assert len(found) == 3 and all(any(word in problem for problem in found) for word in ("Material', 'new_in", "material.new_in", "operator material.new "))


def test_each_editor_was_recorded(result):
    editors = result["editors"]
    assert len(editors) == 13
    for engines in editors.values():
        for engine in engines.values():
            assert len(engine["operators"]) > 500 and len(engine["seen"]) > 300
    everywhere = {"MATERIAL_MT_context_menu", "VIEW3D_MT_object_quick_effects", "VIEW3D_MT_light_add"}
    for name, wanted in (("3D view, mesh", {"VIEW3D_HT_header", "VIEW3D_MT_object_context_menu", "VIEW3D_PT_shading_color"}),
                         ("shader editor, TexImage", {"NODE_HT_header", "NODE_MT_add", "NODE_MT_context_menu", "NODE_PT_texture_mapping", "NODE_PT_active_node_generic", "NODE_AJAR_MATERIAL_PT_settings"}),
                         ("shader editor, lamp", {"NODE_HT_header", "NODE_MT_add", "NODE_AJAR_LIGHT_PT_light"}),
                         ("shader editor, world", {"NODE_HT_header", "NODE_MT_add", "NODE_AJAR_WORLD_PT_settings", "NODE_AJAR_WORLD_PT_ray_visibility"})):
        assert everywhere | wanted <= set(editors[name]["AJAR"]["seen"])


def test_the_add_menus_offer_the_nodes_of_their_tree(result):
    for editor, offered, left_out in (("shader editor, BsdfPrincipled", "ShaderNodeBsdfPrincipled", "ShaderNodeBackground"), ("shader editor, world", "ShaderNodeBackground", "ShaderNodeBsdfPrincipled")):
        seen = result["editors"][editor]["AJAR"]["seen"]
        nodes = {what for shown in seen.values() for kind, what in shown if kind == "node.add_node"}
        assert f"type = {offered}" in nodes and f"type = {left_out}" not in nodes


def test_new_datablocks_are_the_same(result):
    made = result["made"]
    assert made["AJAR"] == made["CYCLES"]
    assert {"ShaderNodeBsdfPrincipled", "ShaderNodeOutputMaterial"} == {node[0] for node in made["AJAR"]["material.new"]["nodes"]} and len(made["AJAR"]["material.new"]["links"]) == 1
    assert {"ShaderNodeEmission", "ShaderNodeOutputLight"} == {node[0] for node in made["AJAR"]["AREA lamp with nodes"]["nodes"]}


def test_a_dropped_material_is_assigned_to_the_object_below_the_mouse(result):
    assert result["dropped"]["AJAR"] == result["dropped"]["CYCLES"] == [["Dropped"], ["Asset"]]


def test_a_paused_rendered_view_does_not_render(result):
    paused = result["paused"]
    assert paused["at_pause"] == paused["later"] >= 2 and paused["status"].startswith("Paused") and not paused["busy"]
    assert paused["edit_is_shown"] and paused["goes_on"], paused
