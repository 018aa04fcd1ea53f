"""Write docs/coverage.md from the measurements of probe.py in each Blender. A column is a Blender, a row a node or a setting. Reasons are numbered below the tables.

    python tools/coverage/write.py nodes_3.4.json nodes_5.2.json settings_3.4.json settings_5.2.json > docs/coverage.md

after `probe.py` and `settings_probe.py` have written a file in each; `make coverage` does all of it.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from judge import Verdict, verdicts

KINDS = {"plain": "output", "output": "output", "input": "input", "switch": "switch", "choice": "choice"}


# Differences that these spheres do not show.
NOTES = {
    "Bump": "heights a pixel apart as seen by the camera; Cycles measures the pixel along the path",
    "TexNoise": "Blender 4.2 and later repeat it beyond 100 000",
    "Wireframe": "with Pixel Size: pixels as seen by the camera; Cycles measures them along the path",
    "VolumePrincipled": "its attributes are of grids, which are not rendered yet",
}


class Reasons:
    """The reasons of one table, numbered in the order of their use."""

    def __init__(self) -> None:
        self.numbers: dict[str, int] = {}

    def mark(self, reasons: Iterable[str]) -> str:
        return ", ".join(f"[{self.numbers.setdefault(reason.replace('|', '/'), len(self.numbers) + 1)}]" for reason in dict.fromkeys(reasons))

    def lines(self) -> list[str]:
        return ["", *(f"* [{number}] {reason}" for reason, number in self.numbers.items())]


def name_of(found: Verdict) -> str:
    return f"{found.name} {found.value}" if found.kind == "choice" else found.shown or found.name


def summary(founds: list[Verdict], reasons_of: Reasons) -> str:
    """The summary of one node in one Blender: the number of exact parts, and the other parts."""
    if not founds:
        return "–"
    plain = [found for found in founds if KINDS[found.kind] == "output"]
    if all(found.state == "missing" for found in plain):
        return f"**missing** {reasons_of.mark(reason for found in plain for reason in found.reasons)}"
    by_reason: dict[tuple, list[str]] = {}
    for found in founds:
        if found.state != "exact":
            by_reason.setdefault((found.state, *found.reasons), []).append(name_of(found))
    exact = sum(found.state == "exact" for found in founds)
    parts = ["exact" if exact == len(founds) else f"{exact} of {len(founds)} exact"]
    for (state, *reasons), names in by_reason.items():
        listed = "all else" if len(names) > 6 else ", ".join(dict.fromkeys(names))
        parts.append(f"{listed}: {'**missing** ' if state == 'missing' else ''}{reasons_of.mark(reasons) or 'differs, reason unknown'}")
    return "; ".join(parts).replace("|", "/")


def counts(of: str, blenders: list[str], tables: list[list[Verdict]]) -> list[str]:
    lines = [f"| Blender | {of} | exact | approximated | missing | exact, but without effect on these pictures in Cycles either |", "|---|---|---|---|---|---|"]
    for blender, table in zip(blenders, tables):
        count = Counter(found.state for found in table)
        silent = sum(found.state == "exact" and not found.has_effect for found in table)
        lines.append(f"| {blender} | {len(table)} | {count['exact']} | {count['approximated']} | {count['missing']} | {silent} |")
    return lines


def of_nodes(blenders: list[str], tables: list[list[Verdict]]) -> list[str]:
    lines = ["# What Ajar makes of Blender's shader nodes and settings", "",
             "Written by `tools/coverage/write.py`. In each Blender, every output, input, choice and switch of every shader node was changed in a material of its own, and Ajar and that Blender's",
             "Cycles rendered the same spheres with it (`tools/coverage/probe.py`). *Exact*: no difference beyond the noise and 4 % (root mean square over a sphere's pixels; most differ by less than",
             "1 %). Spheres that differ without a known reason are rendered again with 1,024 samples. *Approximated*: another picture, with the reason. *Missing*: the artist is told so by name. `tests/core/node_values*.txt` holds recorded values of Cycles, compared to 10⁻⁴.",
             "A dash: not in this Blender. Numbers in brackets are explained below the table. `tests/blender/panels/inventory.tsv` has every setting, part of a node, choice and pass by its name.", "",
             *counts("outputs, inputs, choices and switches of nodes", blenders, tables), "", f"| node | {' | '.join(blenders)} | besides |", "|---|---|" + "---|" * len(blenders)]
    reasons = Reasons()
    for node in sorted({found.node for table in tables for found in table}):
        cells = [summary([found for found in table if found.node == node], reasons) for table in tables]
        lines.append(f"| {node} | {' | '.join(cells)} | {NOTES.get(node, '')} |")
    return lines + reasons.lines()


def of_settings(blenders: list[str], tables: list[list[Verdict]]) -> list[str]:
    lines = ["", "## Settings", "",
             "Every setting of scene, view layer, objects, meshes, lamps, world, camera and materials that Ajar follows or reports was changed in a small scene that has a bit of everything",
             "(`tools/coverage/settings_probe.py`). The scene has neither hair nor volumes. `tests/blender/panels/inventory.py` has what becomes of all other settings, and",
             "[agreement.md](agreement.md) larger scenes. All settings are exact but for these:", "", *counts("values of settings", blenders, tables), "",
             f"| setting | {' | '.join(blenders)} |", "|---|" + "---|" * len(blenders)]
    reasons = Reasons()
    names = {(found.node, found.name) for table in tables for found in table if found.state != "exact"}
    for node, name in sorted(names):
        cells = []
        for table in tables:
            here = [found for found in table if (found.node, found.name) == (node, name)]
            words = dict.fromkeys(f"{'**missing** ' if found.state == 'missing' else ''}{reasons.mark(found.reasons)}" for found in here if found.state != "exact")
            cells.append("; ".join(words) if words else "exact" if here else "–")
        lines.append(f"| {node}.{name} | {' | '.join(cells)} |")
    return lines + reasons.lines()


def main(paths: list[Path]) -> None:
    results = [json.loads(path.read_text(encoding="utf-8")) for path in paths]
    results.sort(key=lambda result: [int(part) for part in result["blender"].split()[0].split(".")])
    lines: list[str] = []
    for write, is_of in ((of_nodes, True), (of_settings, False)):
        chosen = [result for result in results if any(probe["node"].startswith("ShaderNode") for probe in result["probes"]) == is_of]
        tables = [[found for found in verdicts(result) if found.kind != "context"] for result in chosen]
        if chosen:
            lines += write([result["blender"].removesuffix(" LTS") for result in chosen], tables)
    print("\n".join(lines))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, nargs="+", help="JSON files of the probes")
    main(parser.parse_args().results)
