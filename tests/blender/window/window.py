"""What scripts for `drive.py` share: finding the 3D view, rendered shading, screenshots."""

from __future__ import annotations

import bpy


def area(kind: str = "VIEW_3D") -> bpy.types.Area:
    return next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == kind)


def space() -> bpy.types.SpaceView3D:
    return area().spaces.active


def override(**more):
    """Operators run as if called in the 3D view."""
    window, view = bpy.context.window_manager.windows[0], area()
    region = next(region for region in view.regions if region.type == "WINDOW")
    return bpy.context.temp_override(window=window, screen=window.screen, area=view, region=region, **more)


def shade(kind: str) -> None:
    space().shading.type = kind


def look_through_camera(yes: bool = True) -> None:
    space().region_3d.view_perspective = "CAMERA" if yes else "PERSP"


def screenshot(path: str) -> None:
    with override():
        bpy.ops.screen.screenshot(filepath=path)


def screenshot_of_view(path: str) -> None:
    with override():
        bpy.ops.screen.screenshot_area(filepath=path)
