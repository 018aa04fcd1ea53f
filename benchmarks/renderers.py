"""The compared renderers with the same interface: from a .blend to images and times."""

from __future__ import annotations

import json
import os
import re
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import images
import numpy as np

HERE = Path(__file__).resolve().parent
PROJECT = HERE.parent
BLENDER = os.environ.get("BLENDER", "blender")


class RenderFailed(RuntimeError):
    """A renderer ended with an error or without its images. The text contains the end of its log."""


@dataclass
class Render:
    """An image and its times. `seconds` is the render itself; scene export and build are `sync_seconds`."""

    renderer: str
    path: Path
    samples: float
    seed: int
    threads: int
    seconds: float
    sync_seconds: float
    statistics: dict = field(default_factory=dict)

    def image(self) -> np.ndarray:
        return images.read_exr(self.path)


def run(command: list[str], what: str, environment: dict[str, str] | None = None) -> str:
    """The output of a command. RenderFailed names the failure and the last lines of the output."""
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                            env=environment, check=False)
    if result.returncode != 0:
        raise RenderFailed(f"{what} ended with code {result.returncode}:\n" + "\n".join(result.stdout.splitlines()[-20:]))
    return result.stdout


def parse_cycles_log(log: str) -> list[Render]:
    """Renders from the lines that cycles_render.py prints. The time of --debug-cycles in microseconds is before each."""
    renders, wall = [], None
    for line in log.splitlines():
        if match := re.match(r"\s*Path Tracing\s+(\d+\.\d+)\s+\d+\.\d+\s*$", line):
            wall = (wall or 0.0) + float(match[1])
        elif line.startswith("CYCLES "):
            record = json.loads(line[7:])
            seconds = wall if wall is not None else record["seconds"]
            renders.append(Render(record["renderer"], Path(record["path"]), record["samples"], record["seed"], record["threads"],
                                  seconds, record["sync_seconds"], {"frame": record["frame"], "cpu_seconds": record.get("cpu_seconds", 0.0)}))
            wall = None
    return renders


def render_cycles(blend: Path, out: Path, samples: list[int], seeds: list[int], threads: int, percentage: int | None = None,
                  adaptive: bool = False, guiding: bool = False, python: str | None = None, denoise: bool = False) -> list[Render]:
    """All pairs of samples and seeds in one start of Blender, or of the bpy wheel of the interpreter `python`."""
    script = [str(HERE / "cycles_render.py"), "--", "--out", str(out), "--samples", ",".join(map(str, samples)),
              "--seeds", ",".join(map(str, seeds)), "--threads", str(threads), "--adaptive", "on" if adaptive else "off",
              "--guiding", "on" if guiding else "off", "--denoise", "on" if denoise else "off"]
    if percentage:
        script += ["--percentage", str(percentage)]
    if python:
        command = [python] + script + ["--blend", str(blend)]
    else:
        command = [BLENDER, "-b", "--factory-startup", "--debug-cycles", "--python-exit-code", "1", str(blend), "--python"] + script
    log = run(command, f"Cycles on {blend.name}")
    renders = parse_cycles_log(log)
    if len(renders) != len(samples) * len(seeds):
        raise RenderFailed(f"Cycles on {blend.name} left {len(renders)} images of {len(samples) * len(seeds)}:\n"
                           + "\n".join(log.splitlines()[-20:]))
    return renders


def export_by_wheel(blend: Path, out: Path, python: str, extension: Path, percentage: int | None = None) -> Path:
    """The scene file for the core, exported by the newer Blender of a bpy wheel with an unpacked extension. Its materials are those of that Blender."""
    out.mkdir(parents=True, exist_ok=True)
    scene = out / "scene.ajar"
    wheel_export([(blend, scene)], python, extension, ["--percentage", str(percentage or 0)])
    return scene


def wheel_export(files: Sequence[tuple[Path, Path]], python: str, extension: Path, options: Sequence[str]) -> None:
    """Exports pairs of a .blend and a scene file in one start of a bpy wheel. Options are those of wheel_export.py."""
    command = [python, str(HERE / "wheel_export.py"), *options, *(str(file) for pair in files for file in pair)]
    log = run(command, f"the export of {files[0][0].name}", environment=os.environ | {"PYTHONPATH": str(extension)})
    if missing := [scene for _, scene in files if not scene.exists()]:
        raise RenderFailed(f"the export left no {missing[0]}:\n{log}")


# ---- Ajar ----------------------------------------------------------------------------------------------

# Render the current frame of the file, as F12 does (-f would change it). Without clamping, the problem is that of cycles_render.py.
RENDER = """
import bpy
render, ajar = bpy.context.scene.render, bpy.context.scene.ajar
if {unclamped}:
    ajar.clamp_direct = ajar.clamp_indirect = 0
ajar.reflective_caustics = ajar.refractive_caustics = True
render.resolution_percentage = {percentage} or render.resolution_percentage
render.filepath = {path!r}
image = render.image_settings
image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGBA", "32", "ZIP"
render.use_compositing = render.use_sequencer = False
bpy.ops.render.render(write_still=True)
"""


@dataclass(frozen=True)
class AjarBuild:
    """The build tree of `make`, with the Blender profile that contains the add-on."""

    build: Path

    @classmethod
    def default(cls) -> AjarBuild:
        return cls(Path(os.environ.get("AJAR_BUILD", PROJECT / "build" / "release")))

    def blender(self, blend: Path, image: Path, options: list[str], percentage: int | None = None, unclamped: bool = True) -> str:
        """Render a .blend with the add-on inside Blender. Returns the log."""
        profile = self.build / "blender_profile"
        environment = os.environ | {"BLENDER_USER_CONFIG": str(profile / "config"), "BLENDER_USER_SCRIPTS": str(profile / "scripts")}
        script = RENDER.format(percentage=percentage, path=str(image), unclamped=unclamped)
        command = [BLENDER, "-b", "--factory-startup", "--addons", "ajar_render", str(blend), "-E", "AJAR", "--python-exit-code", "1",
                   "--python-expr", script, "--", *options]
        return run(command, f"Ajar on {blend.name}", environment=environment)

    def dump(self, blend: Path, out: Path, percentage: int | None = None, unclamped: bool = True) -> tuple[Path, dict]:
        """The scene file for the core, in `out`, and the statistics of its export."""
        out.mkdir(parents=True, exist_ok=True)
        scene, statistics = out / "scene.ajar", out / "export.json"
        self.blender(blend, out / "export.exr", ["--ajar-samples", "1", "--ajar-dump-scene", str(scene), "--ajar-stats", str(statistics)],
                     percentage, unclamped)
        if not scene.exists():
            raise RenderFailed(f"Ajar on {blend.name} left no scene file")
        return scene, json.loads(statistics.read_text())

    def render(self, scene: Path, out: Path, samples: list[int], seeds: list[int], threads: int, extra: Sequence[str] = ()) -> list[Render]:
        """All pairs of samples and seeds of a scene file, rendered by the program `ajar-render`."""
        renders = []
        for seed in seeds:
            for count in samples:
                path, statistics = out / f"{count}_{seed}.exr", out / f"{count}_{seed}.json"
                out.mkdir(parents=True, exist_ok=True)
                run([str(self.build / "ajar-render"), str(scene), str(path), "--samples", str(count), "--seed", str(seed),
                     "--threads", str(threads), "--stats", str(statistics), *extra], f"ajar-render on {scene}")
                found = json.loads(statistics.read_text())
                renders.append(Render(f"Ajar {found['version']}", path, count, seed, threads, found["render_seconds"],
                                      found["build_seconds"], found))
        return renders
