"""Every supported setting, and every output, input, choice and switch of every shader node gives the same image as with Cycles, or a warning is
shown, or the difference is listed with a reason."""

import json
import os
import subprocess
import sys
from pathlib import Path

from blender_process import BUILD, ROOT, TIMEOUT_SECONDS

COVERAGE = ROOT / "tools" / "coverage"
sys.path.insert(0, str(COVERAGE))
import judge  # noqa: E402


def probed(command: list[object], python_path: Path, out: Path) -> dict:
    result = subprocess.run([*map(str, command), str(out)], env=os.environ | {"PYTHONPATH": str(python_path), "PYTHONDONTWRITEBYTECODE": "1"}, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=4 * TIMEOUT_SECONDS, check=False)
    assert result.returncode == 0, result.stdout[-4000:]
    return json.loads(out.read_text())


def test_nodes_agree_with_cycles(tmp_path):
    program = os.environ.get("BLENDER", "blender")
    result = probed([program, "-b", "--factory-startup", "--python", COVERAGE / "probe.py", "--"], BUILD / "python", tmp_path / "probes.json")
    assert judge.faults(result) == []
    found = judge.verdicts(result)
    assert len(found) > 800
    assert sum(verdict.has_effect for verdict in found) > 0.8 * len(found)   # otherwise the probes test little


def test_settings_agree_with_cycles(tmp_path, monkeypatch):
    whole = "AJAR_ALL_TESTS" in os.environ
    if not whole:
        monkeypatch.setenv("AJAR_SHORT_PROBES", "1")   # the other half, and the changes, are for `make test-all` and `make coverage`
    program = os.environ.get("BLENDER", "blender")
    result = probed([program, "-b", "--factory-startup", "--python", COVERAGE / "settings_probe.py", "--"], BUILD / "python", tmp_path / "settings.json")
    assert judge.faults(result) == []
    assert len(result["probes"]) > (200 if whole else 100)
    assert sum(verdict.has_effect for verdict in judge.verdicts(result)) > (80 if whole else 40)


def entry(**changes) -> dict:
    return {"node": "ShaderNodeGamma", "kind": "input", "name": "Gamma", "value": "", "shown": "Gamma", "said": [], "difference": 0.0, "error": 0.001, "change": 0.3,
            "change_error": 0.001} | changes


def test_a_difference_is_a_fault_unless_it_is_reported_listed_or_noise():
    def faults(**changes) -> int:
        return len(judge.faults({"blender": "5.2.3", "probes": [entry(**changes)]}))

    assert faults() == 0
    assert faults(difference=0.06) == 1
    assert faults(difference=0.06, error=0.06) == 0
    assert faults(difference=0.06, said=["node 'Gamma' (ShaderNodeGamma): its Gamma is not supported yet"]) == 0
    assert faults(difference=0.06, node="ShaderNodeBsdfToon", name="Smooth") == 0


def test_probes_without_an_effect_in_cycles_are_marked():
    said, silent = judge.verdicts({"blender": "5.2.3", "probes": [entry(), entry(change=0.001)]})
    assert said.has_effect and not silent.has_effect
