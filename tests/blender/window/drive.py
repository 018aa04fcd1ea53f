"""Runs a script step by step inside a Blender with a window: blender --python drive.py -- SCRIPT RESULT.json [arguments of the script]

The script defines `steps(arguments, result)`, a generator. It yields seconds, during which Blender runs as usual: it draws, renders and handles
events. The dictionary `result` is written to the file when the generator ends.
"""

from __future__ import annotations

import argparse
import json
import os
import runpy
import sys
import traceback

import bpy

parser = argparse.ArgumentParser(prog="drive.py", description=__doc__.splitlines()[0])
parser.add_argument("script", help="defines steps(arguments, result)")
parser.add_argument("output", help="JSON file of the results")
parser.add_argument("arguments", nargs=argparse.REMAINDER, help="of the script")
options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
script, output, arguments = options.script, options.output, options.arguments
result: dict = {"errors": []}
sys.path[:0] = [os.path.dirname(os.path.abspath(__file__)), os.path.dirname(os.path.abspath(script))]
from permission import allowed  # noqa: E402


def remember_error(kind, error, trace) -> None:
    result["errors"].append("".join(traceback.format_exception(kind, error, trace)))
    print(result["errors"][-1], flush=True)


def steps():
    yield from runpy.run_path(script)["steps"](arguments, result)


generator = steps()


def step() -> float | None:
    try:
        return next(generator)
    except StopIteration:
        pass
    except BaseException:
        remember_error(*sys.exc_info())
    with open(output, "w", encoding="utf-8") as file:
        json.dump(result, file)
    sys.stdout.flush()
    os._exit(1 if result["errors"] else 0)


sys.modules["bpy.ops"]._op_call = allowed(sys.modules["bpy.ops"]._op_call)
bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(step, first_interval=0.5, persistent=True)
