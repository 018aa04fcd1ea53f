"""Verdicts on the probes of one Blender: whether Ajar and Cycles agree, for each node, output, input, choice and switch.

A probe *differs* if the spheres differ by more than MIN_DIFFERENCE and the noise. KNOWN lists the known differences with their reasons; all others
are faults.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

MIN_DIFFERENCE = 0.04   # root mean square over the pixels of a sphere; sampled light has a noise above 2 % with these samples
EFFECT = 0.002    # a smaller change counts as no effect

OLD, NEW = "3", "45"      # first digits of the Blender versions with a difference
COMPENSATED = "Multiscatter GGX: the energy that a single bounce loses is compensated; Blender 3 simulates bounces between facets (docs/agreement.md)"


@dataclass(frozen=True)
class Known:
    node: str
    name: str        # name of the output, input or property
    value: str       # name of the choice
    blenders: str
    reason: str

HALF_OF_HAIR = "light sampling of Cycles drops a part of the reflection that its sampled directions keep; Ajar keeps it in both"

KNOWN = (
    Known("BsdfAnisotropic", "distribution", "MULTI_GGX", OLD, COMPENSATED),
    Known("BsdfAnisotropic", "*", "*", OLD, "anisotropic highlights differ by up to 5 % near the rim of a sphere, with Beckmann by 15 %; the cause is not known"),
    Known("BsdfAnisotropic", "*", "*", NEW, COMPENSATED),
    # Not its transmission, which has to agree. All other probes have the default, reflection.
    Known("BsdfHair", "[A-Z]*", "*", OLD + NEW, HALF_OF_HAIR),
    Known("BsdfHair", "component", "Reflection", OLD + NEW, HALF_OF_HAIR),
    Known("BsdfHairPrincipled", "Color", "", "5", "on meshes, Cycles 5 drops light samples by its test for bumps; bright hair passes light on many times (docs/agreement.md)"),
    Known("BsdfHairPrincipled", "IOR", "", OLD + NEW, "below 1, Cycles loses light where it reflects totally; Ajar does not"),
    Known("BsdfHairPrincipled", "model", "HUANG", NEW, "on meshes, Cycles 5 drops light samples by its test for bumps, and it integrates the width of a fibre coarsely (docs/agreement.md)"),
    Known("BsdfToon", "*", "*", OLD + NEW, "with a smooth edge, Cycles evaluates the falloff at another angle than that of the sampled direction"),
    Known("BsdfTranslucent", "Normal", "", OLD + NEW, "with a tilted normal, Cycles attenuates directions below the surface differently"),
    Known("BsdfPrincipled", "Clearcoat*", "", OLD, "Cycles samples one distribution of the coat and uses the density of another (docs/agreement.md)"),
    Known("CyclesRenderSettings", "sample_clamp_direct", "*", OLD + NEW, "both engines clamp samples, but they divide samples differently into those of lights and surfaces"),
    Known("PointLight", "shadow_soft_size", "*", OLD, "close to a lamp of this size, Cycles weighs samples of its disk as if they faced the point (docs/agreement.md)"),
    Known("SunLight", "angle", "*", NEW, "a wide sun is brighter towards its rim, as in Blender 3; in newer Blenders its radiance is constant"),
)

# Nodes that Cycles does not have. It renders black, or ignores their links.
NOT_OF_CYCLES = {"EeveeSpecular", "ShaderToRGB", "Squeeze", "UVAlongStroke"}
NO_NODE_OF_CYCLES = "Cycles does not have this node: it renders black, or ignores the links"


@dataclass
class Verdict:
    """The verdict on one output, input, switch or choice. A property with choices has one for each choice."""

    node: str
    kind: str
    name: str
    value: str
    shown: str
    state: str                    # "exact", "approximated", "missing" or "wrong"
    reasons: list[str] = field(default_factory=list)
    difference: float = 0.0
    has_effect: bool = True       # whether the image of Cycles changes; otherwise, equal images are weak evidence


def known_reason(node: str, name: str, value: str, blender: str) -> str | None:
    for entry in KNOWN:
        if entry.node == node and fnmatchcase(name, entry.name) and fnmatchcase(value, entry.value) and blender[0] in entry.blenders:
            return entry.reason
    return None


def differs(probe: dict) -> bool:
    return probe["difference"] > math.hypot(MIN_DIFFERENCE, probe["error"])


def verdict(probe: dict, blender: str) -> Verdict:
    node = probe["node"].removeprefix("ShaderNode")
    effect = probe["kind"] in ("plain", "output", "context") or probe["change"] > max(EFFECT, probe["change_error"])
    found = Verdict(node, probe["kind"], probe["name"], probe["value"], probe["shown"], "exact", [], probe["difference"] if differs(probe) else 0.0, effect)
    said = [message.split("): ", 1)[-1] for message in probe["said"]]
    reason = known_reason(node, probe["name"], probe["value"], blender)
    if node in NOT_OF_CYCLES and said:
        found.state, found.reasons = "approximated", [*said, NO_NODE_OF_CYCLES]
    elif any("not supported" in message for message in said):
        found.state, found.reasons = "missing", said
    elif said:
        found.state, found.reasons = "approximated", said
    elif differs(probe) and reason is not None:
        found.state, found.reasons = "approximated", [reason]
    elif differs(probe):
        found.state = "wrong"
    return found


def verdicts(result: dict) -> list[Verdict]:
    return [verdict(probe, result["blender"]) for probe in result["probes"]]


def main(paths: list[Path]) -> int:
    found = [fault for path in paths for fault in faults(json.loads(path.read_text(encoding="utf-8")))]
    print("\n".join(found) or "all differences are known")
    return 1 if found else 0


def faults(result: dict) -> list[str]:
    """A line for each probe that differs from Cycles without a message."""
    return [f"Blender {result['blender']}: {found.node}: {found.kind} {found.name} {found.value} differs by {100 * found.difference:.1f} %"
            for found in verdicts(result) if found.state == "wrong"]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, nargs="+", help="JSON files of the probes")
    sys.exit(main(parser.parse_args().results))
