"""Shared functions of the scripts for `drive.py`: the 3D view, rendered shading, screenshots."""

from __future__ import annotations

import os
import tempfile

import bpy
import numpy as np
from bpy_extras import view3d_utils
from mathutils import Vector


def area(kind: str = "VIEW_3D") -> bpy.types.Area:
    return next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == kind)


def space() -> bpy.types.SpaceView3D:
    return area().spaces.active


def override(**more):
    """Runs operators in the context of the 3D view."""
    window, view = bpy.context.window_manager.windows[0], area()
    region = next(region for region in view.regions if region.type == "WINDOW")
    return bpy.context.temp_override(window=window, screen=window.screen, area=view, region=region, **more)


def shade(kind: str) -> None:
    space().shading.type = kind


def look_through_camera(yes: bool = True) -> None:
    space().region_3d.view_perspective = "CAMERA" if yes else "PERSP"


def place_of(point) -> tuple[int, int]:
    """The position in the window of a point of the scene."""
    region = next(region for region in area().regions if region.type == "WINDOW")
    place = view3d_utils.location_3d_to_region_2d(region, space().region_3d, Vector(point))
    return round(region.x + place.x), round(region.y + place.y)


def event(kind: str, value: str = "PRESS", x: int = 0, y: int = 0) -> None:
    """Simulates an event of the mouse or the keyboard. Blender must have been started with --enable-event-simulate."""
    bpy.context.window_manager.windows[0].event_simulate(type=kind, value=value, x=x, y=y)


def click(x: int, y: int):
    """Steps: moves the mouse to the position, presses and releases the button."""
    for kind, value in (("MOUSEMOVE", "NOTHING"), ("LEFTMOUSE", "PRESS"), ("LEFTMOUSE", "RELEASE")):
        event(kind, value, x, y)
        yield 0.1


def screenshot(path: str) -> None:
    """Saves a screenshot of the whole window."""
    window = bpy.context.window_manager.windows[0]
    if not grab(path, 0, 0, window.width, window.height):
        with override():
            bpy.ops.screen.screenshot(filepath=path)


def screenshot_of_area(path: str, shown: bpy.types.Area) -> None:
    window = bpy.context.window_manager.windows[0]
    if not grab(path, shown.x, shown.y, shown.width, shown.height):
        with bpy.context.temp_override(window=window, screen=window.screen, area=shown, region=shown.regions[-1]):
            bpy.ops.screen.screenshot_area(filepath=path)


def grab(path: str, x: int, y: int, width: int, height: int) -> bool:
    """Saves a region of the window (origin at the bottom left) from the display, for Blenders whose own screenshots are black with OpenGL in software."""
    if bpy.app.version < (5, 0):
        return False
    from PIL import ImageGrab
    picture = ImageGrab.grab(xdisplay=os.environ["DISPLAY"])
    window = bpy.context.window_manager.windows[0]
    left, top = window.x + x, picture.height - (window.y + y + height)
    picture.crop((left, top, left + width, top + height)).save(path)
    return True


def pixels_of_view() -> np.ndarray:
    """The pixels that the 3D view shows: [height, width, 3], rows from the bottom up."""
    with tempfile.TemporaryDirectory() as folder:
        screenshot_of_view(f"{folder}/view.png")
        image = bpy.data.images.load(f"{folder}/view.png")
        pixels = np.empty(image.size[0] * image.size[1] * 4, dtype=np.float32)
        image.pixels.foreach_get(pixels)
        pixels = pixels.reshape(image.size[1], image.size[0], 4)[..., :3]
        bpy.data.images.remove(image)
    return pixels


def screenshot_of_view(path: str) -> None:
    screenshot_of_area(path, area())
