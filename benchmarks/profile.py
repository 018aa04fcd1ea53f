#!/usr/bin/python3
"""Where the CPU time of path tracing goes, by phase:

    benchmarks/profile.py [SCENE ...] [--seconds 6] [--integrator path]

Needs `perf` and llvm-symbolizer. Builds ajar-render with debug information in build/profile, with the same optimization as the release. `perf` samples
the program while it renders. Each sample belongs to the innermost function of the project at its address, inlined functions included, and the folder of
this function is the phase. Vector mathematics (core/math, GLM, the standard library) counts for the function that uses it. Writes
docs/benchmarks/profile.md.
"""

from __future__ import annotations

import argparse
import collections
import json
import re
import subprocess
import sys
from pathlib import Path

import machine
import renderers
from scenes import PROJECT, find_scenes

SCENES = ["box", "room", "rooms", "buddha", "plant", "outdoor"]
FREQUENCY = 997
BUILD = PROJECT / "build" / "profile"
PAGE = PROJECT / "docs" / "benchmarks" / "profile.md"
# The first part of a path that matches names the phase.
PHASES = [
    ("core/sampling/", "random points"), ("core/math/random", "random points"), ("core/shading/bsdf/", "BSDF"), ("core/shading/images/", "textures"),
    ("core/shading/", "shader programs"), ("core/lights/", "lights"), ("core/transport/direct/", "direct light, MIS"), ("core/film/", "film"),
    ("core/transport/media/", "media"), ("core/scene/", "rays and hits"), ("core/geometry/", "rays and hits"), ("core/integrators/", "path loop"),
    ("core/transport/paths/", "path loop"), ("core/transport/", "other techniques"), ("core/", "other"),
]
LIBRARIES = [("embree", "Embree"), ("tbb", "threads"), ("libm", "mathematics"), ("libc", "C library"), ("kernel", "kernel")]
ORDER = list(dict.fromkeys([name for _, name in LIBRARIES[:1]] + [name for _, name in PHASES] + [name for _, name in LIBRARIES[1:]] + ["not known"]))


def build() -> Path:
    """ajar-render at fixed addresses, with the debug information that tells inlined functions."""
    subprocess.run(["cmake", "--preset", "release", "-B", str(BUILD), "-DCMAKE_CXX_FLAGS=-g1 -fno-pie", "-DCMAKE_EXE_LINKER_FLAGS=-no-pie", "-DAJAR_TESTS=OFF",
                    "-DAJAR_PYTHON_INCLUDE=unused", "-DAJAR_PYTHON_SUFFIX=.unused"], cwd=PROJECT, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", str(BUILD), "--target", "ajar_cli"], check=True, stdout=subprocess.DEVNULL)
    return BUILD / "ajar-render"


def samples_of(program: Path, scene: Path, seconds: float, integrator: str, work: Path) -> list[tuple[int, str]]:
    """The address and the library of each sample, taken after the scene was built."""
    command = [str(program), str(scene), str(work / "profile.exr"), "--integrator", integrator, "--threads", "2", "--stats", str(work / "profile.json"), "--seconds"]
    renderers.run([*command, "0.1"], "ajar-render")
    delay = json.loads((work / "profile.json").read_text())["build_seconds"]
    data = work / "perf.data"
    renderers.run(["perf", "record", "-q", "-e", "cpu-clock", "-F", str(FREQUENCY), "-D", str(int(1000 * delay) + 200), "-o", str(data), "--", *command,
                   str(seconds)], "perf")
    text = subprocess.run(["perf", "script", "-i", str(data), "-F", "ip,sym,dso"], check=True, text=True, capture_output=True).stdout
    return [(int(match[1], 16), match[2]) for match in re.finditer(r"^\s*([0-9a-f]+) .*\(([^()]*)\)$", text, re.MULTILINE)]


def phase_of_file(path: str) -> str | None:
    """None: mathematics or a library of headers, so that the caller's file decides."""
    if "core/" not in path or ("core/math/" in path and "core/math/random" not in path):
        return None
    inner = path[path.rindex("core/"):]
    return next(name for part, name in PHASES if inner.startswith(part))


def phases_of(program: Path, addresses: list[int]) -> dict[int, str]:
    """The phase of each address in the program."""
    asked = "".join(f"{address:#x}\n" for address in addresses)
    found = json.loads("[" + ",".join(subprocess.run(["llvm-symbolizer", "--output-style=JSON", "--inlines", f"--obj={program}"], input=asked, check=True, text=True,
                                                     capture_output=True).stdout.splitlines()) + "]")
    result = {}
    for address, entry in zip(addresses, found, strict=True):
        files = (phase_of_file(frame["FileName"]) for frame in entry.get("Symbol", []))
        result[address] = next((phase for phase in files if phase), "not known")
    return result


def profile(program: Path, scene: Path, options: argparse.Namespace, work: Path) -> dict[str, float]:
    """The share of each phase in the CPU time."""
    taken = samples_of(program, scene, options.seconds, options.integrator, work)
    own = phases_of(program, sorted({address for address, library in taken if library.endswith("ajar-render")}))
    counts: collections.Counter[str] = collections.Counter()
    for address, library in taken:
        counts[own[address] if library.endswith("ajar-render") else next((name for part, name in LIBRARIES if part in library), "other")] += 1
    return {phase: count / len(taken) for phase, count in counts.items()}


def page(shares: dict[str, dict[str, float]], options: argparse.Namespace) -> str:
    lines = ["# Where the time of path tracing goes", "", f"Shares of the CPU time of rendering with `{options.integrator}`, in per cent.", "",
             "| phase | " + " | ".join(shares) + " |", "|---|" + "---|" * len(shares)]
    for phase in ORDER:
        if any(phase in found for found in shares.values()):
            lines.append(f"| {phase} | " + " | ".join(f"{100 * found.get(phase, 0.0):.1f}" for found in shares.values()) + " |")
    lines += ["", "## Method", "", "`benchmarks/profile.py` (`make profile`) writes this page; do not edit it. `perf` takes " + str(FREQUENCY) +
              f" samples a second of each thread for {options.seconds:g} seconds, after the scene was built. A sample belongs to the innermost function of the project at its "
              "address, inlined functions included; the folder of its file is the phase. Vector mathematics counts for the function that uses it. *Embree* is the time in "
              "its library. *rays and hits* makes rays, calls Embree and computes the surface at the hit.", "", "## Machine", ""]
    return "\n".join(lines + [f"* {key}: {value}" for key, value in machine.describe(2).items()]) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", help=f"names; without any, {', '.join(SCENES)}")
    parser.add_argument("--seconds", type=float, default=6.0, help="of each render")
    parser.add_argument("--integrator", default="path")
    parser.add_argument("--build", type=Path, default=PROJECT / "build" / "release", help="for the export of scenes")
    options = parser.parse_args()
    program, exporter = build(), renderers.AjarBuild(options.build.resolve())
    shares = {}
    for scene in find_scenes(options.scenes or SCENES):
        work = BUILD / "scenes" / scene.name
        scene_file, _ = exporter.dump(scene.path, work, scene.percentage)
        shares[scene.name] = profile(program, scene_file, options, work)
        print(scene.name, *(f"{phase} {100 * shares[scene.name].get(phase, 0.0):.1f} %" for phase in ORDER), sep=", ", flush=True)
    PAGE.write_text(page(shares, options))
    return 0


if __name__ == "__main__":
    sys.exit(main())
