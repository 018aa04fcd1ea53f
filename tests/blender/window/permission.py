"""Calls what Blender refuses to a timer.

Blender has one flag for all threads that permits Python to write. A render thread that enters Python while a panel is drawn saves the state of the
panel and restores it when it leaves. After this, Blender refuses every operator that a timer calls, and every change of a datablock. Within the
getter of a property it permits them.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy

REFUSED = ("can't modify blend data in this state", "Writing to ID classes in this context is not allowed")

refused: list = []    # a call that Blender refused, with its arguments; afterwards its result


def call_again(_manager: bpy.types.WindowManager) -> bool:
    call, arguments = refused.pop()
    refused.append(call(*arguments))
    return True


bpy.types.WindowManager.calls_again = bpy.props.BoolProperty(get=call_again)


def allowed(call: Callable) -> Callable:
    """A function that does the same where Blender refuses `call`."""
    def called(*arguments):
        try:
            return call(*arguments)
        except (RuntimeError, AttributeError) as error:
            if not any(text in str(error) for text in REFUSED):
                raise
        refused.append((call, arguments))
        assert bpy.context.window_manager.calls_again
        return refused.pop()
    return called


def set_value(owner: object, name: str, value: object) -> None:
    allowed(setattr)(owner, name, value)
