#!/usr/bin/python3
"""Measures the memory and the time with which both engines prepare a scene, in Blender's own process.

    /usr/bin/python3 benchmarks/geometry.py [--wheel PYTHON ZIP] [--rounds N] SCENE ...

SCENE is a .blend file, or "triangles:20000000", "one_mesh:20000000" or "instances:1000000": such a scene is made (large_scenes.py).

Each measurement is a process of its own, which renders 16 pixels with one sample. When an engine begins, Blender has evaluated the scene: from there on
count the CPU time, and the highest memory of the process minus the memory at that point. Of Ajar, the steps are listed too. A third engine, which only reads
the evaluated scene, gives the memory of Blender alone. The order of the engines alternates.
--wheel: the Python of a bpy wheel and the zip of the extension, instead of Debian's Blender.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve()
ROOT = HERE.parents[1]
ENGINES = ("NOTHING", "AJAR", "CYCLES")
MIB = 1 << 20


# ---- In Blender ------------------------------------------------------------------------------------------------------

def memory(field: str) -> int:
    """A field of /proc/self/status in bytes: VmRSS, or VmHWM, the highest since the last call of forget_highest."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(field + ":"):
            return int(line.split()[1]) * 1024
    raise KeyError(field)


def forget_highest() -> None:
    Path("/proc/self/clear_refs").write_text("5")


def add_nothing(found: dict) -> None:
    """Registers an engine that only reads the evaluated scene."""
    import bpy

    class Nothing(bpy.types.RenderEngine):
        bl_idname = "NOTHING"
        bl_label = "Nothing"

        def render(self, depsgraph: bpy.types.Depsgraph) -> None:
            begin(found)
            for instance in depsgraph.object_instances:
                _ = instance.object.data

    bpy.utils.register_class(Nothing)


def begin(found: dict) -> None:
    """Called when Blender has evaluated the scene, before the engine does anything."""
    found["blender"], found["evaluation peak"] = memory("VmRSS"), memory("VmHWM")
    forget_highest()
    found["begin"] = time.process_time()


def watch(engine: str, found: dict) -> None:
    """Lets an engine record its begin, and Ajar the memory during and after the export."""
    module: Any
    if engine == "CYCLES":
        module = sys.modules["cycles.engine" if "cycles.engine" in sys.modules else "bl_ext.core.cycles.engine"]
        create = module.create

        def created(*arguments, **named):
            begin(found)
            create(*arguments, **named)
        module.create = created
    if engine == "AJAR":
        module = next(module for name, module in sys.modules.items() if name.endswith("ajar_render.engine"))
        export = module.export_scene

        def exported(*arguments, **named):
            begin(found)
            context = export(*arguments, **named)
            found["export seconds"] = time.process_time() - found["begin"]
            found["after export"], found["export peak"] = memory("VmRSS"), memory("VmHWM")
            forget_highest()
            return context
        module.export_scene = exported


def inside(engine: str, blend: str, out: str, options: dict) -> None:
    import bpy
    sys.path.insert(0, str(HERE.parent))
    from small_render import make_small
    if options["zip"]:
        bpy.ops.extensions.package_install_files(filepath=options["zip"], repo="user_default", enable_on_install=True)
    if blend.endswith(".blend"):
        bpy.ops.wm.open_mainfile(filepath=blend, load_ui=False)
    else:
        import large_scenes
        large_scenes.make(blend)
    if "cycles" not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="cycles")
    found: dict = {}
    add_nothing(found)
    scene = bpy.context.scene
    make_small(scene)
    for name, value in options["ajar"].items():
        setattr(scene.ajar, name, value)
    watch(engine, found)
    scene.render.engine = engine
    found["loaded"] = memory("VmRSS")
    forget_highest()
    bpy.ops.render.render()
    found["seconds"] = time.process_time() - found["begin"]
    found["peak"] = memory("VmHWM")
    if engine == "AJAR":
        last = next(module for name, module in sys.modules.items() if name.endswith("ajar_render.last_render"))
        found["scene"], found["build seconds"] = (last.of(scene)[name] for name in ("scene", "build_seconds"))
        found["rendering peak"] = found["peak"]
        found["peak"] = max(found["peak"], found["export peak"])
    Path(out).write_text(json.dumps(found))
    sys.stdout.flush()
    os._exit(0)


# ---- Outside ---------------------------------------------------------------------------------------------------------

def measure(engine: str, scene: str, options: argparse.Namespace) -> dict:
    settings = dict(pair.split("=") for pair in options.set)
    values = {name: json.loads(value) for name, value in settings.items()}
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "found.json"
        script = ["--inside", engine, scene, str(out), json.dumps({"zip": options.wheel[1] if options.wheel else "", "ajar": values})]
        environment = dict(os.environ)
        if options.wheel:
            environment["BLENDER_USER_RESOURCES"] = folder
            command = [options.wheel[0], str(HERE), *script]
        else:
            profile = options.build / "blender_profile"
            environment |= {"BLENDER_USER_CONFIG": str(profile / "config"), "BLENDER_USER_SCRIPTS": str(profile / "scripts")}
            command = ["blender", "-b", "--factory-startup", "--addons", "ajar_render", "--python", str(HERE), "--", *script]
        done = subprocess.run(command, check=False, env=environment, capture_output=True, text=True)
        if not out.is_file():
            raise RuntimeError(f"{engine} {scene}: no result\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
        return json.loads(out.read_text())


def spread(values: list[float], form: str) -> str:
    low, high = min(values), max(values)
    return format(low, form) if format(low, form) == format(high, form) else f"{low:{form}} to {high:{form}}"


def report(scene_name: str, found: dict[str, list[dict]], of_wheel: bool) -> None:
    base = min(f["blender"] for f in found["NOTHING"])
    print(f"\n{Path(scene_name).stem}, {'the wheel' if of_wheel else 'Debian'}: Blender {base / MIB:.0f} MiB with the evaluated scene, "
          f"peak of the evaluation {min(f['evaluation peak'] for f in found['NOTHING']) / MIB:.0f} MiB")
    for engine in ENGINES[1:]:
        peaks = [(f["peak"] - f["blender"]) / MIB for f in found[engine]]
        print(f"  {engine:7} peak {spread(peaks, '.0f')} MiB, {spread([f['seconds'] for f in found[engine]], '.3f')} CPU s", end="")
        if engine == "AJAR":
            f = found[engine][0]
            scene = f["scene"]
            triangles = max(1, scene["triangles"])
            print(f"; export peak {(f['export peak'] - f['blender']) / MIB:.0f}, description {(f['after export'] - f['blender']) / MIB:.0f}, "
                  f"rendering peak {(f['rendering peak'] - f['blender']) / MIB:.0f} MiB; export {spread([f['export seconds'] for f in found[engine]], '.3f')} CPU s, "
                  f"build {spread([f['build seconds'] for f in found[engine]], '.3f')} s; {triangles} triangles: arrays "
                  f"{scene['geometry_bytes'] / triangles:.1f}, Embree {scene['accel_bytes'] / triangles:.1f} bytes each", end="")
        print()
    ajar, cycles = ({name: min(f[name] - f.get(start, 0) for f in found[engine]) for name, start in (("peak", "blender"), ("seconds", ""))}
                    for engine in ENGINES[1:])
    print(f"  Ajar to Cycles: memory {ajar['peak'] / cycles['peak']:.2f}, time {ajar['seconds'] / cycles['seconds']:.2f}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "release")
    parser.add_argument("--wheel", nargs=2, metavar=("PYTHON", "ZIP"))
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--set", action="append", default=[], metavar="PROPERTY=JSON", help="a property of Ajar in the scene")
    options = parser.parse_args()
    for given in options.scenes:
        scene = str(Path(given).resolve()) if given.endswith(".blend") else given
        found: dict[str, list[dict]] = {engine: [] for engine in ENGINES}
        for number in range(options.rounds):
            for engine in ENGINES if number % 2 == 0 else reversed(ENGINES):
                found[engine].append(measure(engine, scene, options))
        report(scene, found, options.wheel is not None)


if __name__ == "__main__":
    if "--inside" in sys.argv:
        at = sys.argv.index("--inside")
        engine, blend, out, settings = sys.argv[at + 1:at + 5]
        inside(engine, blend, out, json.loads(settings))
    else:
        main()
