#!/usr/bin/python3
"""make compat: tests the zip in every Blender. Ajar and Cycles render each scene alternately in one process; the images are also compared with those
of Blender 3.4.1.

The `bpy` wheels on PyPI are official builds with Cycles and all its libraries. Each is installed into its own environment below build/compat with a
clean profile and the zip; `blender` on the path uses the legacy add-on. Writes docs/compatibility.md.

    compatibility.py [--wheel 4.2.23 ...] [--scene box ...] [--python 3.13=/path/to/python]
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benchmarks"))
import agreement  # noqa: E402

INSIDE = Path(__file__).resolve().parent / "inside.py"
WORK = ROOT / "build" / "compat"
BUILD = Path(os.environ.get("AJAR_BUILD", ROOT / "build" / "release"))
WHEELS = {"4.2.23": "3.11", "4.5.15": "3.11", "5.0.1": "3.11", "5.2.3": "3.13"}   # the newest release of each series, and its Python
NUMPY = {"3.11": "numpy<2", "3.13": "numpy"}
REFERENCE = "3.4.1"
OLDER = "x86-64-v2"
REMARKS = "## Remarks\n"   # the section is written by hand, and this script keeps it
SEEDS = (1, 2)
# Where Ajar cannot agree: the series of Blender, the scene, and why. They are on the page, and no failures.
CANNOT_AGREE = {("4.2", "cloud"): "Its Python cannot read OpenVDB; the volume is left out, and a message names it."}
SAMPLES, PERCENTAGE, BLOCK = 16, 10, 16
MORE_SAMPLES = 512   # for scenes whose pictures differ; the standard errors of few samples may not show rare bright ones
TIMEOUT_SECONDS = 1800


@dataclass(frozen=True)
class Blender:
    """A Blender under test: a command that runs a Python script in it, and the zip to install; None: the add-on that `make` built."""

    name: str
    command: list[str]
    zip: Path | None


class Unavailable(Exception):
    """This Blender is not available on this machine."""


# ---- Blenders -----------------------------------------------------------------------------------------------------------

def zips() -> tuple[Path, Path]:
    """The extension and the legacy add-on of `make extension`."""
    legacy = sorted((ROOT / "out").glob("ajar-*-legacy-linux-x64.zip"))
    extension = [path for path in sorted((ROOT / "out").glob("ajar-*-linux-x64.zip")) if path not in legacy]
    if not extension or not legacy:
        raise SystemExit("There is no zip in out/: make extension.")
    return extension[-1], legacy[-1]


def find_python(version: str) -> str:
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    for path in (f"/usr/bin/python{version}", *map(str, sorted(pyenv.glob(f"{version}.*/bin/python{version}"), reverse=True))):
        if os.access(path, os.X_OK):
            return path
    raise Unavailable(f"there is no Python {version}")


def wheel(version: str, zip_file: Path, work: Path = WORK) -> Blender:
    """The bpy wheel in its own environment, downloaded at the first use."""
    folder = work / f"bpy-{version}"
    python = folder / "bin" / "python"
    if not (folder / "complete").exists():
        shutil.rmtree(folder, ignore_errors=True)
        subprocess.run([find_python(WHEELS[version]), "-m", "venv", folder], check=True)
        result = subprocess.run([python, "-m", "pip", "install", "-q", "--disable-pip-version-check", "--only-binary=:all:", f"bpy=={version}",
                                 NUMPY[WHEELS[version]]], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        if result.returncode != 0:
            raise Unavailable(f"bpy {version} cannot be downloaded: {result.stdout.strip().splitlines()[-1]}")
        (folder / "complete").touch()
    return Blender(f"{version} (official, bpy wheel)", [str(python), str(INSIDE)], zip_file)


def debian(zip_file: Path | None) -> Blender:
    """The Blender on the path. Without a zip it is the reference, whose Ajar is built with Debian's libraries."""
    program = os.environ.get("BLENDER", "blender")
    return Blender(f"{REFERENCE} (Debian 12{', legacy zip' if zip_file else ''})",
                   [program, "-b", "--factory-startup", "--python", str(INSIDE), "--"], zip_file)


def run(blender: Blender, renders: list[dict], out: Path, panels: bool = False, **environment: str) -> dict:
    """The result of inside.py in a clean profile, with the images in `pictures`. `panels`: also compares what Properties shows, and writes out/panels.json."""
    shutil.rmtree(out, ignore_errors=True)
    profile = out / "profile"
    profile.mkdir(parents=True)
    job = out / "job.json"
    job.write_text(json.dumps({"zip": blender.zip and str(blender.zip), "out": str(out), "renders": renders, "panels": panels}))
    variables = os.environ | {"BLENDER_USER_CONFIG": str(profile / "config"), "BLENDER_USER_SCRIPTS": str(profile / "scripts"),
                              "BLENDER_USER_EXTENSIONS": str(profile / "extensions"), "HOME": str(profile), **environment}
    for name in ("config", "scripts", "extensions"):
        (profile / name).mkdir()
    if blender.zip is None:
        subprocess.run([ROOT / "tools" / "install_addon.sh", BUILD, profile], check=True)
    with open(out / "log.txt", "w") as log:
        finished = subprocess.run([*blender.command, str(job)], env=variables, stdout=log, stderr=subprocess.STDOUT, timeout=TIMEOUT_SECONDS, check=False)
    if not (out / "result.json").exists():
        return {"error": f"ended with {finished.returncode}\n" + "\n".join((out / "log.txt").read_text().splitlines()[-15:])}
    result = json.loads((out / "result.json").read_text())
    result["pictures"] = [np.load(out / f"{number}.npy") for number in range(len(result["renders"]))]
    return result


# ---- Comparison ---------------------------------------------------------------------------------------------------------

def jobs(scenes: list[str], engines: tuple[str, ...] = ("CYCLES", "AJAR"), samples: int = SAMPLES) -> list[dict]:
    """The renders of each scene with each seed by each engine. The engines alternate in one process."""
    return [{"blend": str(ROOT / "test_scenes" / f"{scene}.blend"), "samples": samples, "percentage": PERCENTAGE, "engine": engine, "seed": seed}
            for scene in scenes for seed in SEEDS for engine in engines]


def pictures_of(result: dict, scene: str, engine: str = "AJAR") -> list[np.ndarray]:
    return [picture[..., :3] for item, picture in zip(result["renders"], result["pictures"])
            if item["engine"] == engine and Path(item["blend"]).stem == scene]


def compare(ours: list[np.ndarray], theirs: list[np.ndarray]) -> dict:
    """The ratio of the means with its standard error, and the blocks that differ by more than 1 % and three standard errors."""
    pairs = [agreement.mean_and_variance(pictures) for pictures in (ours, theirs)]
    blocks = [agreement.blocks_of_pixels(*pair, len(pictures), BLOCK) for pair, pictures in zip(pairs, (ours, theirs))]
    means = [mean.mean() for mean, _ in pairs]
    errors = [np.sqrt(variance.sum(axis=(0, 1))).mean() / variance[..., 0].size / mean for (_, variance), mean in zip(pairs, means)]
    return {"same": all(np.array_equal(a, b) for a, b in zip(ours, theirs)), "ratio": float(means[0] / means[1]), "error": float(np.hypot(*errors)),
            "out": len(agreement.disagreements(*blocks)), "blocks": int(blocks[0].means.size), "finite": all(np.isfinite(p).all() for p in ours)}


def agrees(comparison: dict) -> bool:
    """With three standard errors, about one block of 370 exceeds the limit by noise alone."""
    return comparison["finite"] and (comparison["same"] or comparison["out"] <= max(1, comparison["blocks"] // 50))


def can_agree(name: str, scene: str) -> bool:
    return not any(name.startswith(f"{series}.") and scene == other for series, other in CANNOT_AGREE)


def beside_cycles(result: dict, scene: str) -> dict:
    """The comparison of Ajar with Cycles, with the pictures of more samples if there are some."""
    again = result.get("again")
    shown = again if again is not None and pictures_of(again, scene) else result
    return compare(pictures_of(shown, scene), pictures_of(shown, scene, "CYCLES"))


def differing(name: str, result: dict, scenes: list[str]) -> list[str]:
    """The scenes that Ajar and Cycles render differently in a Blender that renders both."""
    if "error" in result or "legacy" in name:
        return []
    return [scene for scene in scenes if can_agree(name, scene) and not agrees(beside_cycles(result, scene))]


def look_again(blender: Blender, result: dict, scenes: list[str], out: Path) -> None:
    """Renders the scenes that differ with more samples. A bias remains; noise that the standard errors of few samples do not show does not."""
    doubtful = differing(blender.name, result, scenes)
    if not doubtful:
        return
    print(f"{blender.name}: {MORE_SAMPLES} samples for {', '.join(doubtful)}", flush=True)
    more = run(blender, jobs(doubtful, samples=MORE_SAMPLES), out)
    if "error" not in more:
        result["again"] = more


# ---- Libraries ------------------------------------------------------------------------------------------------------------

def foreign_libraries(result: dict) -> dict[str, list[str]]:
    """Embree, TBB and OpenImageIO in the process: those in the folder of the add-on, and those of Blender."""
    found = {"ours": [], "Blender's": []}
    for path in result["mapped"]:
        name = Path(path).name
        if any(part in name.lower() for part in ("embree", "tbb", "openimageio")):
            found["ours" if "ajar_render" in path else "Blender's"].append(name)
    return found


# ---- The page -------------------------------------------------------------------------------------------------------------

def short(name: str) -> str:
    return name.split(" (")[0] + (" legacy" if "legacy" in name else "")


def table(results: dict[str, dict], scenes: list[str], of: Callable[[dict, str], dict]) -> list[str]:
    lines = ["| scene | " + " | ".join(map(short, results)) + " |", "|---|" + "---|" * len(results)]
    for scene in scenes:
        cells = []
        for name, result in results.items():
            c = of(result, scene)
            text = "identical" if c["same"] else f"{c['ratio']:.3f} ± {c['error']:.3f}, {c['out']} of {c['blocks']}"
            cells.append(text if agrees(c) or not can_agree(name, scene) else f"**{text}**")
        lines.append(f"| {scene} | " + " | ".join(cells) + " |")
    return lines


def page(results: dict[str, dict], scenes: list[str]) -> str:
    lines = ["# Compatibility", "", "Written by `make compat`. The zip of `make extension` is installed into each Blender in a clean profile, and",
             "every use of a deprecated function of its API is an error. Ajar (path tracer) and Cycles alternate in one process:",
             f"{SAMPLES} samples, {len(SEEDS)} seeds, {PERCENTAGE} % of each scene's size. Scenes that differ are rendered again with {MORE_SAMPLES} samples.",
             "", "| Blender | Python | instructions | Embree, TBB, OpenImageIO of Ajar | of Blender, in the same process |", "|---|---|---|---|---|"]
    for name, result in results.items():
        if "error" in result:
            lines.append(f"| {name} | {result.get('python', '')} | | failed: {result['error'].strip().splitlines()[-1]} | |")
            continue
        ours = ", ".join(result["libraries"][key] for key in ("Embree", "TBB", "OpenImageIO"))
        theirs = ", ".join(foreign_libraries(result)["Blender's"]) or "linked into it"
        lines.append(f"| {name} | {result['python']} | {result['instruction_set']} | {ours} | {theirs} |")
    works = {name: result for name, result in results.items() if "error" not in result}
    official = {name: result for name, result in works.items() if "official" in name}
    lines += ["", "## Ajar against Cycles of the same Blender", "", "Ratio of the means with its standard error, and the blocks of "
              f"{BLOCK} x {BLOCK} pixels and channels that differ by more than 1 % and", "three standard errors of the block.", "",
              *table({name: result for name, result in works.items() if pictures_of(result, scenes[0], "CYCLES")}, scenes,
                     beside_cycles)]
    lines += ["", *(f"* {scene} in {series}: {why}" for (series, scene), why in CANNOT_AGREE.items())]
    lines += ["", "## Ajar against Ajar in Blender 3.4.1", "",
              "There Ajar is built with Debian's libraries (Embree 3). Opening a file in 4.0 or newer turns its Principled nodes into the second version,",
              "also for Cycles, so that the images of such scenes differ; only the table above tests them.", "",
              *table({name: result for name, result in works.items() if name != debian(None).name}, scenes,
                     lambda result, scene: compare(pictures_of(result, scene), pictures_of(works[debian(None).name], scene)))]
    first = next(iter(official), None)
    unequal = [f"{scene} in {short(name)}" for name, result in official.items() for scene in scenes
                 if not compare(pictures_of(result, scene), pictures_of(official[first], scene))["same"]]
    if len(official) > 1:
        lines += ["", f"Ajar's pictures in {', '.join(map(short, official))} are the same bit for bit" + (f", except {', '.join(unequal)}." if unequal else ".")]
    return "\n".join([*lines, "", f"Measured on {datetime.date.today().isoformat()}.", ""])


def forced_lines(blender: Blender, forced: dict, results: dict[str, dict], scene: str) -> str:
    """The result of the render with the older instruction set."""
    if "error" in forced:
        return f"\nForced to {OLDER} it failed: {forced['error'].strip().splitlines()[-1]}\n"
    c = compare(pictures_of(forced, scene), pictures_of(results[blender.name], scene))
    return (f"\nForced by `AJAR_INSTRUCTION_SET={OLDER}`, {short(blender.name)} loads the module of {forced['instruction_set']}; the picture of {scene} has "
            f"{c['ratio']:.4f} of the mean with\nthe newest instructions, and {c['out']} of {c['blocks']} blocks differ.\n")


def remarks_on(page_file: Path) -> str:
    """The text that was written by hand below the heading REMARKS."""
    _, line, remarks = page_file.read_text(encoding="utf-8").partition(REMARKS) if page_file.exists() else ("", "", "")
    return f"\n{REMARKS}{remarks}" if line else ""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wheel", nargs="+", choices=WHEELS, default=list(WHEELS))
    parser.add_argument("--scene", nargs="+", default=sorted(path.stem for path in (ROOT / "test_scenes").glob("*.blend")))
    parser.add_argument("--page", type=Path, default=ROOT / "docs" / "compatibility.md")
    options = parser.parse_args()
    blenders = [debian(None), debian(zips()[1])]
    for version in options.wheel:
        try:
            blenders.append(wheel(version, zips()[0]))
        except Unavailable as reason:
            print(f"left out: {reason}", file=sys.stderr)
    results = {}
    for blender in blenders:
        engines = ("AJAR",) if "legacy" in blender.name else ("CYCLES", "AJAR")
        out = WORK / "out" / blender.name.replace(" ", "_")
        result = results[blender.name] = run(blender, jobs(options.scene, engines), out)
        print(f"{blender.name}: {result.get('error', 'rendered')}", flush=True)
        look_again(blender, result, options.scene, out.with_name(out.name + "_again"))
    if "error" in results[debian(None).name]:
        raise SystemExit(1)
    forced = run(blenders[-1], jobs(options.scene[:1], ("AJAR",)), WORK / "out" / "forced", AJAR_INSTRUCTION_SET=OLDER)
    options.page.write_text(page(results, options.scene) + forced_lines(blenders[-1], forced, results, options.scene[0]) + remarks_on(options.page), encoding="utf-8")
    if forced.get("instruction_set") != OLDER:
        raise SystemExit(f"{OLDER} was not used: {forced.get('error', forced.get('instruction_set'))}")
    bad = [name for name, result in results.items() if "error" in result]
    bad += [f"{name}: {scene}" for name, result in results.items() for scene in differing(name, result, options.scene)]
    print("\n".join(f"differs: {item}" for item in bad) or "All agree.")
    sys.exit(bool(bad))


if __name__ == "__main__":
    main()
