"""Buttons that pause and continue the current render, and the rendered views."""

from __future__ import annotations

import bpy

_wanted = False
_wanted_in_views = False


def end(is_preview: bool) -> None:
    """Called when a render has ended, so that the next one is not paused. Previews of materials do not affect a paused render."""
    global _wanted
    if not is_preview:
        _wanted = False


def is_wanted() -> bool:
    return _wanted


def is_wanted_in_views() -> bool:
    return _wanted_in_views


class AJAR_OT_pause_render(bpy.types.Operator):
    bl_idname = "ajar.pause_render"
    bl_label = "Pause Render"
    bl_description = "Pause the render after the samples it is taking now, or continue it. The time limit does not count the pause"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return bpy.app.is_job_running("RENDER") if hasattr(bpy.app, "is_job_running") else True

    def execute(self, context: bpy.types.Context) -> set[str]:
        global _wanted
        _wanted = not _wanted
        return {"FINISHED"}


class AJAR_OT_pause_views(bpy.types.Operator):
    bl_idname = "ajar.pause_views"
    bl_label = "Pause Rendered Views"
    bl_description = "Pause the rendered views after they show an edit, or continue their sampling"

    def execute(self, context: bpy.types.Context) -> set[str]:
        global _wanted_in_views
        _wanted_in_views = not _wanted_in_views
        for window in context.window_manager.windows:
            for area in window.screen.areas:
                if area.type == "VIEW_3D":
                    area.tag_redraw()
        return {"FINISHED"}


def _draw_button_in_view(self, context: bpy.types.Context) -> None:
    """Draw the button in the header of a rendered view, at the position of that of Cycles."""
    if context.engine == "AJAR" and context.space_data.shading.type == "RENDERED":
        self.layout.operator("ajar.pause_views", text="", icon="PLAY" if _wanted_in_views else "PAUSE", depress=_wanted_in_views)


def _draw_button(self, context: bpy.types.Context) -> None:
    """Draw the button in the header of the image editor, while it shows a render."""
    if context.scene.render.engine == "AJAR" and bpy.app.is_job_running("RENDER"):
        self.layout.operator("ajar.pause_render", text="Continue" if _wanted else "Pause", icon="PLAY" if _wanted else "PAUSE")


_register_class, _unregister_class = bpy.utils.register_classes_factory((AJAR_OT_pause_render, AJAR_OT_pause_views))


def register() -> None:
    _register_class()
    bpy.types.IMAGE_HT_header.append(_draw_button)
    bpy.types.VIEW3D_HT_header.append(_draw_button_in_view)


def unregister() -> None:
    bpy.types.VIEW3D_HT_header.remove(_draw_button_in_view)
    bpy.types.IMAGE_HT_header.remove(_draw_button)
    _unregister_class()
