"""Drives a Blender with a window, from inside: blender --python drive.py -- SCRIPT RESULT.json [arguments of the script]

The script defines `steps(arguments, result)`, a generator. Between two steps Blender lives its own life for the seconds that were yielded:
it draws, renders, handles events. What the generator puts into the dictionary `result` is written out when it ends.
"""

from __future__ import annotations

import json
import os
import runpy
import sys
import time
import traceback

import bpy

REFUSED = "can't modify blend data in this state"
LONGEST_SECONDS = 30.0

script, output, *arguments = sys.argv[sys.argv.index("--") + 1:]
result: dict = {"errors": []}
sys.path[:0] = [os.path.dirname(os.path.abspath(__file__)), os.path.dirname(os.path.abspath(script))]


def patient(call):
    """While a render thread runs a piece of Python (for a material's preview, for example), Blender refuses every operator: then it is tried again."""
    def tried(*arguments):
        end = time.monotonic() + LONGEST_SECONDS
        while True:
            try:
                return call(*arguments)
            except RuntimeError as error:
                if REFUSED not in str(error) or time.monotonic() > end:
                    raise
            time.sleep(0.02)   # the other thread goes on
    return tried


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


sys.modules["bpy.ops"]._op_call = patient(sys.modules["bpy.ops"]._op_call)
bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(step, first_interval=0.5, persistent=True)
