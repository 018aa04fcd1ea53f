"""Drives a Blender with a window, from inside: blender --python drive.py -- SCRIPT RESULT.json [arguments of the script]

The script defines `steps(arguments, result)`, a generator. Between two steps Blender lives its own life for the seconds that were yielded:
it draws, renders, handles events. What the generator puts into the dictionary `result` is written out when it ends.
"""

from __future__ import annotations

import json
import os
import runpy
import sys
import traceback

import bpy

REFUSED = "can't modify blend data in this state"

script, output, *arguments = sys.argv[sys.argv.index("--") + 1:]
result: dict = {"errors": []}
sys.path[:0] = [os.path.dirname(os.path.abspath(__file__)), os.path.dirname(os.path.abspath(script))]


refused: list = []    # an operator that Blender refused, with its arguments; then what it gave


def call_again(_manager: bpy.types.WindowManager) -> bool:
    call, arguments = refused.pop()
    refused.append(call(*arguments))
    return True


bpy.types.WindowManager.calls_again = bpy.props.BoolProperty(get=call_again)


def allowed(call):
    """Blender keeps one flag for all threads that says whether Python may write. When a render thread enters Python while a panel is drawn, it takes the panel's state for its own and restores
    it when it leaves: from then on every operator that a timer calls is refused. Within the getter of a property they are allowed."""
    def called(*arguments):
        try:
            return call(*arguments)
        except RuntimeError as error:
            if REFUSED not in str(error):
                raise
        refused.append((call, arguments))
        assert bpy.context.window_manager.calls_again
        return refused.pop()
    return called


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
