"""What the probes of one Blender say: for each node, output, input, choice and switch, whether Ajar shows what Cycles shows.

A probe *differs* where the spheres differ by more than LEAST and the noise. Differences that are known stand in KNOWN with a reason; any other one is a fault.
"""

from __future__ import annotations

import json
import math
import sys
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

LEAST = 0.04      # a root mean square over a sphere's pixels; of sampled light, whose noise stays above 2 % with these samples
EFFECT = 0.002    # a change smaller than this shows nothing

OLD, NEW = "3", "45"      # first digits of the Blenders that a difference is of
COMPENSATED = "Multiscatter GGX: the energy that one bounce loses is put back; Blender 3 walks between facets (docs/agreement.md)"
LEANING = "normals that lean away from the eye are bent towards it for diffuse light as well, as in Blender 3; newer Blenders do so for reflections only"
OREN_NAYAR = "Oren and Nayar's model of Blender 3; newer Blenders keep the energy of further bounces"


@dataclass(frozen=True)
class Known:
    node: str
    name: str        # of the output, input or property
    value: str       # of the choice
    blenders: str
    reason: str


KNOWN = (
    Known("BsdfAnisotropic", "distribution", "MULTI_GGX", OLD, COMPENSATED),
    Known("BsdfAnisotropic", "*", "*", OLD, "stretched highlights differ by up to 5 % near the rim of a sphere, Beckmann's by 15 %; the cause is not known"),
    Known("BsdfAnisotropic", "*", "*", NEW, COMPENSATED),
    Known("BsdfGlossy", "*", "*", NEW, COMPENSATED),
    Known("BsdfToon", "*", "*", OLD + NEW, "where the edge is smooth, Cycles takes its fall-off at another angle than the direction it returns"),
    Known("BsdfTranslucent", "Normal", "", OLD + NEW, "a normal that leans: Cycles dims directions beyond the surface otherwise"),
    Known("BsdfPrincipled", "Clearcoat*", "", OLD, "Cycles samples one distribution of the coat and states the density of another (docs/agreement.md)"),
    Known("BsdfPrincipled", "Subsurface*", "", OLD, "a random walk; of Burley's profile one of the same radius"),
    Known("SubsurfaceScattering", "*", "*", OLD + NEW, "Burley's profile is a random walk of the same radius; Skin is a plain random walk"),
    Known("BsdfDiffuse", "Roughness", "", NEW, OREN_NAYAR),
    Known("BsdfPrincipled", "Diffuse Roughness", "", NEW, OREN_NAYAR),
    Known("BsdfDiffuse", "Normal", "", NEW, LEANING),
    Known("BsdfPrincipled", "Normal", "", NEW, LEANING),
    Known("BsdfPrincipled", "Coat Normal", "", NEW, LEANING),
    Known("NormalMap", "*", "*", NEW, LEANING),
    Known("Bump", "*", "*", NEW, LEANING),
    Known("Displacement", "*", "*", NEW, LEANING),
    Known("VectorDisplacement", "*", "*", NEW, LEANING),
    Known("BsdfPrincipled", "*", "*", NEW, "layers dim what is below them by their albedo towards the eye; differences of up to 6 % with coats, sheen and emission"),
    Known("CyclesRenderSettings", "sample_clamp_direct", "*", OLD + NEW, "both limit what one sample brings; the samples of the two engines are cut otherwise into lights and surfaces"),
    Known("PointLight", "shadow_soft_size", "*", OLD + NEW, "close to a lamp of that size: Cycles takes a disk that faces the point, Ajar a sphere (docs/agreement.md)"),
    Known("SunLight", "angle", "*", NEW, "a wide sun is brighter towards its rim, as in Blender 3; in newer Blenders it is as bright everywhere"),
    Known("TexIES", "*", "*", NEW, "without a vector, on a mesh: newer Blenders take the direction to the eye, Ajar the normal as Blender 3"),
)


@dataclass
class Verdict:
    """Of one output, input, switch or choice; of a property with choices, of each choice."""

    node: str
    kind: str
    name: str
    value: str
    shown: str
    state: str                    # "exact", "approximated", "missing" or "wrong"
    reasons: list[str] = field(default_factory=list)
    difference: float = 0.0
    has_effect: bool = True       # Cycles' picture changes; where it does not, equal pictures say little


def known_reason(node: str, name: str, value: str, blender: str) -> str | None:
    for entry in KNOWN:
        if entry.node == node and fnmatchcase(name, entry.name) and fnmatchcase(value, entry.value) and blender[0] in entry.blenders:
            return entry.reason
    return None


def verdict(probe: dict, blender: str) -> Verdict:
    node = probe["node"].removeprefix("ShaderNode")
    differs = probe["difference"] > math.hypot(LEAST, probe["error"])
    effect = probe["kind"] in ("plain", "output", "context") or probe["change"] > max(EFFECT, probe["change_error"])
    found = Verdict(node, probe["kind"], probe["name"], probe["value"], probe["shown"], "exact", [], probe["difference"] if differs else 0.0, effect)
    said = [message.split("): ", 1)[-1] for message in probe["said"]]
    reason = known_reason(node, probe["name"], probe["value"], blender)
    if any("not supported" in message for message in said):
        found.state, found.reasons = "missing", said
    elif said:
        found.state, found.reasons = "approximated", said
    elif differs and reason is not None:
        found.state, found.reasons = "approximated", [reason]
    elif differs:
        found.state = "wrong"
    return found


def verdicts(result: dict) -> list[Verdict]:
    return [verdict(probe, result["blender"]) for probe in result["probes"]]


def main(paths: list[str]) -> int:
    found = [fault for path in paths for fault in faults(json.loads(Path(path).read_text(encoding="utf-8")))]
    print("\n".join(found) or "no difference is unknown")
    return 1 if found else 0


def faults(result: dict) -> list[str]:
    """A line for each probe that shows something else than Cycles although nothing was said."""
    return [f"Blender {result['blender']}: {found.node}: {found.kind} {found.name} {found.value} differs by {100 * found.difference:.1f} %"
            for found in verdicts(result) if found.state == "wrong"]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
