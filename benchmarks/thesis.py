#!/usr/bin/python3
"""Runs all comparisons with tables of the thesis, as listed in docs/benchmarks/thesis.md:

    benchmarks/thesis.py [--only WORD] [--seeds 5] [--scale 1.0] [--build BUILD]

Direct light (tables 5.2 and 6.1), adaptive pixels (table 5.1), light hints (figure 4.3). Scenes are exported once into build/thesis; the table of
each comparison is printed and stored there. Comparisons of direct light continue after an interruption. They take hours at the size of the thesis.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

import renderers
from scenes import PROJECT

HERE = Path(__file__).resolve().parent


# Comparisons of direct light as in the thesis: scene, width in pixels, samples, direct samples.
DIRECT = (("checker", 500, 12, 16), ("checker", 500, 4, 64), ("plant", 720, 27, 16), ("buddha", 512, 4, 64))


def comparisons(seeds: int, scale: float) -> list[tuple[str, str, str, list[str]]]:
    """Name, script, scene, other arguments."""
    direct = [(f"direct {scene} {spp} x {samples}", "thesis_direct.py", scene,
               ["--keep", f"direct_{spp}_{samples}", "--spp", str(spp), "--direct-samples", str(samples), "--width", str(round(scale * width)), "--seeds", str(seeds)])
              for scene, width, spp, samples in DIRECT]
    image = [("image buddha", "thesis_image.py", "buddha", ["--spp", "10", "--seeds", str(seeds), "--direct-only", "--measure", "perceptual", "--scale", "0.3"]),
             ("image box", "thesis_image.py", "box", ["--spp", "16", "--seeds", str(seeds), "--measure", "perceptual", "--scale", "0.3"])]
    hints = [(f"hints {scene} {integrator}", "thesis_hints.py", scene, ["--integrator", integrator, "--spp", "64", "--seeds", "12", "--scale", "0.15"])
             for scene in ("room", "box", "keyhole") for integrator in ("metropolis", "pmc_pt", "bdpt", "erpt")]
    return direct + image + hints


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="comparisons whose names contain this")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--scale", type=float, default=1.0, help="size of the images of direct light relative to the thesis")
    parser.add_argument("--build", type=Path, default=None)
    options = parser.parse_args()
    ajar = renderers.AjarBuild(options.build.resolve()) if options.build else renderers.AjarBuild.default()
    work = PROJECT / "build" / "thesis"
    environment = {**os.environ, "PYTHONPATH": str(ajar.build / "python")}
    failed = 0
    for name, script, scene, more in comparisons(options.seeds, options.scale):
        if options.only not in name:
            continue
        folder = work / scene
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / "scene.ajar"
        if not file.exists():
            file, _ = ajar.dump(PROJECT / "test_scenes" / f"{scene}.blend", folder, 100)
        mode = ["gains"] if script == "thesis_image.py" else []
        print(f"## {name}", flush=True)
        result = subprocess.run([sys.executable, str(HERE / script), *mode, str(file), *more], cwd=folder, env=environment, capture_output=True, text=True, check=False)
        print(result.stdout if result.returncode == 0 else result.stderr, flush=True)
        (work / f"{name.replace(' ', '_')}.md").write_text(result.stdout)
        failed += result.returncode != 0
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
