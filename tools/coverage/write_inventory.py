"""Write tests/blender/panels/inventory.tsv from the lists of things.py and the measurements of the probes in each Blender.

    python tools/coverage/write_inventory.py FILE.json ... > tests/blender/panels/inventory.tsv

The files are those of `things.py`, `probe.py` and `settings_probe.py`, in any order; `make coverage` does all of it. A row is a setting, a part of a
shader node or a pass, with those of its choices that are handled in the same way. Each Blender has a column:

    exact         in a small scene, the change has the same effect on the images of Ajar and Cycles same          the change affects neither image in
    this scene approximated  the images differ, with the reason reported      not supported, and reported by name read          supported; another
    test covers it none          has no meaning for a renderer, with the reason
    -             this Blender does not have it
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[2] / "tests" / "blender" / "panels")]

import inventory  # noqa: E402
from judge import Verdict, verdicts  # noqa: E402

WORST_FIRST = ("wrong", "missing", "approximated", "exact")
Part = tuple[str, str]   # a thing and its choice


def thing_of(probe: dict) -> str:
    """The name as by probes.thing, which cannot be imported outside of Blender."""
    owner, name = probe["node"], probe["name"]
    return f"{owner}.{name}" if probe["kind"] in ("choice", "switch") else f"{owner} {'input' if probe['kind'] == 'input' else 'output'} {name}"


def measured(results: list[dict]) -> dict[Part, list[Verdict]]:
    """The verdicts of one Blender."""
    found: dict[Part, list[Verdict]] = defaultdict(list)
    for result in results:
        for probe, verdict in zip(result["probes"], verdicts(result)):
            if probe["kind"] != "context":
                found[thing_of(probe), probe["value"] if probe["kind"] == "choice" else ""].append(verdict)
    return found


def cell(part: Part, founds: list[Verdict]) -> tuple[str, str]:
    """State and reason in one Blender."""
    if not founds:
        fate = inventory.fate_of(part[0])
        return inventory.state_of(fate), "" if fate in ("read", "reported", "") else fate
    state = min((found.state for found in founds), key=WORST_FIRST.index)
    if state == "exact":
        return ("exact" if any(found.has_effect for found in founds) else "same"), ""
    reasons = dict.fromkeys(reason for found in founds for reason in found.reasons)
    return {"missing": "reported"}.get(state, state), "; ".join(reasons)


def table(listings: dict[str, dict], probed: dict[str, list[dict]]) -> list[str]:
    blenders = sorted(listings, key=lambda name: [int(part) for part in name.split(".")])
    cells: dict[Part, dict[str, tuple[str, str]]] = defaultdict(dict)
    for blender in blenders:
        verdicts_of = measured(probed.get(blender, []))
        for thing, choices in inventory.relevant(listings[blender]).items():
            for choice in choices or [""]:
                founds = verdicts_of.get((thing, choice), []) or ([] if choice else [v for key, group in verdicts_of.items() if key[0] == thing for v in group])
                cells[thing, choice][blender] = cell((thing, choice), founds)
    rows: dict[tuple, list[str]] = defaultdict(list)
    for (thing, choice), states in cells.items():
        reasons = dict.fromkeys(reason for _, reason in states.values() if reason)
        rows[thing, tuple(states.get(blender, ("-", ""))[0] for blender in blenders), "; ".join(reasons)].append(choice)
    lines = ["\t".join(("thing", "choices", *(inventory.series(blender) for blender in blenders), "reason"))]
    lines += ["\t".join((thing, " ".join(choices), *states, reason)) for (thing, states, reason), choices in sorted(rows.items())]
    return lines


def main(paths: list[Path]) -> None:
    listings: dict[str, dict] = {}
    probed: dict[str, list[dict]] = defaultdict(list)
    for path in paths:
        content = json.loads(path.read_text(encoding="utf-8"))
        blender = content["blender"].split()[0]
        if "things" in content:
            listings[blender] = content["things"]
        else:
            probed[blender].append(content)
    print("\n".join(table(listings, probed)))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, nargs="+", help="JSON files of the listings and the probes")
    main(parser.parse_args().results)
