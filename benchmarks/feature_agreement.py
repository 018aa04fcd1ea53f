#!/usr/bin/python3
"""Tests whether both engines show every feature in the same way: scenes of one feature each (test_scenes/features.py), rendered by both in one Blender:

    benchmarks/feature_agreement.py [NAME ...] [--build build/release] [--samples 128] [--table docs/agreement.md] [--wheel 5.2.3]

The means of 8 x 8-pixel blocks of 64 x 64-pixel images, over eight independent seeds each, must agree within 1 % plus three standard errors of the
difference. Of thousands of blocks, a few exceed this at random. Such a feature is rendered again with new seeds and four times the samples, and only
blocks that exceed it again disagree. --table writes the results to the page between its marks. With --wheel, both engines render in the newer Blender of a
bpy wheel, which opens the files of Debian's Blender; the zip of Ajar is in out/.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import agreement
import images
import numpy as np
from renderers import run

PROJECT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(PROJECT / "tests" / "compatibility"))
import compatibility  # noqa: E402

RENDER = PROJECT / "benchmarks" / "feature_render.py"
BLENDER = os.environ.get("BLENDER", "blender")
REPLICATES, BLOCK, AGAIN = 8, 8, 4
BEGIN, END = "<!-- features: begin -->", "<!-- features: end -->"

# Features with known differences and their reasons. All other differences are bugs.
EXPECTED_DIFFERENCES: dict[str, str] = {
    "toon_smooth": "Cycles evaluates the falloff of the edge at another angle than that of the sampled direction",
    "custom_normals": "world light below the horizon of a face and above that of its normals counts fully; Cycles weights it by a density with which no sample is drawn",
    "volume_anisotropies": "Cycles adds the phase functions of different anisotropies in light sampling, instead of weighting them",
    "translucent_transparent": "the image of Cycles is not linear in the colour of Translucent: with red it is redder than the images with black and white predict; that of Ajar is linear",
    "hair_reflection": "in Cycles, light sampling drops half of the reflection of the Hair BSDF where its sampled directions keep it; Ajar keeps it in both",
    "hair_reflection_mesh": "as hair_reflection",
    "hair_chiang": "rays are drawn with another tilt than that of the density by which they are weighed, in Cycles of Blender 3",
    "hair_chiang_thick": "as hair_chiang",
    "curves_instances_chiang": "as hair_chiang",
    "smoke_object": "Cycles of Blender 3.4.1 shows its voxels at slightly other places; Blender 5.2 agrees in every block",
    "smoke_by_nodes": "as smoke_object",
    "smoke_by_particles": "as smoke_object",
    "hair_chiang_mesh": "as hair_chiang",
    "hair_absorption": "with Coat, Cycles draws reflections with the roughness without it, and weighs them by the density with it",
    "displacement_both": "where the surface turns far, Cycles compares heights in the plane of the moved surface, and Ajar in that of the original",
    "displacement_both_flat": "as displacement_both; and Blender 3 bends the normals of the moved faces, so that they turn twice",
    "displacement_shared_both": "as displacement_both",
    "displacement_squeezed_both": "as displacement_both",
    "displacement_position": "as displacement_both",
    "displacement_tangent": "Blender 3 has other tangents on a mesh without a UV map that moves; the cause is not known, and Blender 5.2 agrees",
    "attribute_point_int8": "Cycles of Blender 3 does not read integers of 8 bits",
    "deform_displaced": "smooth normals of a displaced mesh at the other times of the shutter: with flat faces it agrees (deform_displaced_flat); Ajar computes them from the displaced faces",
    "motion_emission": "Cycles of Blender 3 differs by 2 % in one block from the light that random rays find; Blender 5.2 agrees in every block",
    "lamp_without_glossy": "light sampling does not separate types of rays, only hits do; this is reported",
}

# The features that `make test` renders.
SAMPLE = ["sun_wide", "camera_dof_blades", "principled_plastic", "noise", "coarse_smooth_ball", "particles", "volume_principled"]


@dataclass(frozen=True)
class Found:
    """`ratio`: ratio of the means of the images; `allowance`: relative allowance of the median block; `outside`: blocks that disagree twice."""

    name: str
    ratio: float
    allowance: float
    outside: int
    blocks: int
    worst: str

    @property
    def agrees(self) -> bool:
        return self.outside == 0

    @property
    def is_expected(self) -> bool:
        return self.agrees or self.name in EXPECTED_DIFFERENCES


def features() -> dict[str, dict[str, str]]:
    """The type and description of each feature by name. features.py runs in Blender."""
    with tempfile.TemporaryDirectory() as folder:
        listed = Path(folder) / "features.json"
        run([BLENDER, "-b", "--factory-startup", "--python-exit-code", "1", "--python", str(PROJECT / "test_scenes" / "features.py"), "--",
             "--list", str(listed)], "the list of features")
        return json.loads(listed.read_text())


def write_scenes(folder: Path, names: list[str]) -> None:
    run([BLENDER, "-b", "--factory-startup", "--python-exit-code", "1", "--python", str(PROJECT / "test_scenes" / "features.py"), "--",
         str(folder), *names], "the features' scenes")


@dataclass(frozen=True)
class Blender:
    """A Blender that renders the scenes: the command before the arguments of feature_render.py, and its environment."""

    command: list[str]
    environment: dict[str, str]


def debian_blender(build: Path) -> Blender:
    profile = build / "blender_profile"
    return Blender([BLENDER, "-b", "--factory-startup", "--addons", "ajar_render", "--python-exit-code", "1", "--python", str(RENDER)],
                   os.environ | {"BLENDER_USER_CONFIG": str(profile / "config"), "BLENDER_USER_SCRIPTS": str(profile / "scripts")})


def wheel_blender(version: str, folder: Path) -> Blender:
    wheel = compatibility.wheel(version, compatibility.zips()[0].resolve())
    return Blender([wheel.command[0], str(RENDER), "--zip", str(wheel.zip)], os.environ | {"BLENDER_USER_RESOURCES": str(folder / "profile")})


def render(blender: Blender, folder: Path, names: list[str], samples: int, first_seed: int) -> None:
    log = run([*blender.command, "--", str(folder), str(samples), f"{first_seed}:{REPLICATES}", *names], "the features' renders", blender.environment)
    (folder / f"log_{first_seed}.txt").write_text(log)


def blocks_of(folder: Path, name: str, engine: str, first_seed: int) -> agreement.Blocks:
    stack = np.stack([images.read_exr(folder / f"{name}_{engine}_{first_seed + i}.exr").astype(np.float64) for i in range(REPLICATES)])
    return agreement.blocks_of_pixels(stack.mean(axis=0), stack.var(axis=0, ddof=1) / REPLICATES, REPLICATES, BLOCK)


def places(found) -> set[tuple[int, int, int]]:
    return {(d.row, d.column, d.channel) for d in found}


def compare(blender: Blender, folder: Path, names: list[str], samples: int) -> list[Found]:
    """Render and compare. Scenes and images stay in the folder."""
    write_scenes(folder, names)
    render(blender, folder, names, samples, 1)
    first = {name: (blocks_of(folder, name, "ajar", 1), blocks_of(folder, name, "cycles", 1)) for name in names}
    found = {name: agreement.disagreements(*first[name]) for name in names}
    doubtful = [name for name in names if found[name]]
    if doubtful:
        render(blender, folder, doubtful, AGAIN * samples, 1 + REPLICATES)
    results = []
    for name in names:
        ours, theirs = first[name]
        outside = []
        if found[name]:
            ours, theirs = (blocks_of(folder, name, engine, 1 + REPLICATES) for engine in ("ajar", "cycles"))
            before = places(found[name])
            outside = [d for d in agreement.disagreements(ours, theirs) if (d.row, d.column, d.channel) in before]
        colours = theirs.means[..., :3]
        lit = colours > 1e-4
        error = 3.0 * np.hypot(ours.standard_errors, theirs.standard_errors)[..., :3]
        allowance = float(np.median(0.01 + error[lit] / colours[lit])) if lit.any() else 0.01
        ratio = float(ours.means[..., :3].mean() / max(colours.mean(), 1e-12))
        results.append(Found(name, ratio, allowance, len({(d.row, d.column) for d in outside}), colours[..., 0].size, str(outside[0]) if outside else ""))
    return results


def table(results: list[Found], known: dict[str, dict[str, str]]) -> str:
    lines = ["| kind | feature | blocks outside | ratio of means | allowance of a median block |", "|---|---|---|---|---|"]
    for kind in dict.fromkeys(entry["kind"] for entry in known.values()):
        for found in (f for f in results if known[f.name]["kind"] == kind):
            reason = "" if found.agrees else ": " + EXPECTED_DIFFERENCES.get(found.name, "not explained")
            lines.append(f"| {kind} | {known[found.name]['what']} | {found.outside} of {found.blocks}{reason} | {found.ratio:.4f} | {found.allowance:.1%} |")
    agreeing = sum(found.agrees for found in results)
    return f"{agreeing} of {len(results)} features agree in every block.\n\n" + "\n".join(lines)


def put_into(page: Path, text: str) -> None:
    content = page.read_text()
    before, rest = content.split(BEGIN)
    page.write_text(before + BEGIN + "\n" + text + "\n" + END + rest.split(END)[1])


def main() -> int:
    parser = argparse.ArgumentParser(description="Compare single features with Cycles.")
    parser.add_argument("names", nargs="*", help="names of features; all by default")
    parser.add_argument("--build", type=Path, default=Path(os.environ.get("AJAR_BUILD", PROJECT / "build" / "release")))
    parser.add_argument("--samples", type=int, default=128, help="per pixel and seed")
    parser.add_argument("--keep", type=Path, help="folder for scenes and pictures, instead of a temporary one")
    parser.add_argument("--wheel", choices=compatibility.WHEELS, help="render in this Blender")
    parser.add_argument("--table", type=Path, help="page to which the results are written")
    options = parser.parse_args()
    known = features()
    names = options.names or list(known)
    if unknown := [name for name in names if name not in known]:
        parser.error(f"no feature {', '.join(unknown)}; there are {', '.join(known)}")
    results = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        blender = wheel_blender(options.wheel, folder) if options.wheel else debian_blender(options.build.resolve())
        for start in range(0, len(names), 8):
            for found in compare(blender, folder, names[start:start + 8], options.samples):
                results.append(found)
                state = "agrees" if found.agrees else ("differs as expected" if found.is_expected else "DISAGREES")
                print(f"{found.name}: {state}, {found.outside} of {found.blocks} blocks outside, ratio {found.ratio:.4f}, "
                      f"allowance {found.allowance:.1%} {found.worst}", flush=True)
    if options.table:
        put_into(options.table, table(results, known))
    return 0 if all(found.is_expected for found in results) else 1


if __name__ == "__main__":
    sys.exit(main())
