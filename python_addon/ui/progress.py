"""Panels with the noise over time and the samples of each pixel: in the render tab, and beside the image during a render."""

from __future__ import annotations

import bpy
import bpy.utils.previews
import numpy as np
from bpy.types import Panel

from .. import graph, render_progress
from ..translations import interface
from .common import ENGINE, AjarPanel, WithManual

ICON_UNIT = 20          # size of an icon of scale 1 in pixels
ICON_PADDING = 4        # pixels that Blender leaves free on each side of an icon
MARGINS = 64            # pixels beside the images, including the scroll bar
SMALLEST, LARGEST, BESIDE = 6, 24, 11   # scales: minimum and maximum of an image, and the minimum at which two are side by side

_pictures: bpy.utils.previews.ImagePreviewCollection | None = None
_drawn: dict[str, tuple] = {}   # name of an image -> key of its content


def _show(name: str, key: tuple, draw) -> int:
    """The number of an icon that shows the image of `draw`. It is drawn again only if `key` has changed."""
    assert _pictures is not None   # created by register()
    preview = _pictures.get(name) or _pictures.new(name)
    if _drawn.get(name) != key:
        picture = draw()
        preview.image_size = picture.shape[1], picture.shape[0]
        preview.image_pixels_float.foreach_set(np.ascontiguousarray(picture).reshape(-1))
        _drawn[name] = key
    return preview.icon_id


class _Progress:
    """The content of the panel, in all editors."""

    bl_label = "Progress"

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.ajar
        noted = render_progress.show_in(context.area, context.scene)
        column = self.layout.column()
        column.prop(settings, "show_sample_density")
        if noted is None:
            column.label(text="Shown from the next render on")
            return
        for line in _lines(noted):
            column.label(text=line)
        scale = context.preferences.system.ui_scale or 1.0
        available = (context.region.width / scale - MARGINS) / ICON_UNIT
        beside = settings.show_sample_density and available >= 2 * BESIDE
        size = min(max(available / 2 if beside else available, SMALLEST), LARGEST)
        side = round(size * ICON_UNIT * scale) - 2 * ICON_PADDING
        where = context.area.type
        pictures = column.row() if beside else column
        left = pictures.column()
        if len(noted.seconds) == 0:
            left.label(text="The noise is not known yet" if noted.is_running else "The noise was not estimated")
        else:
            left.label(text="Noise over time")
            end = noted.seconds[-1] + noted.remaining_seconds if noted.is_running and noted.remaining_seconds > 0.0 else 0.0
            left.template_icon(_show(f"noise {where}", (noted.number, context.scene.name, side),
                                     lambda: graph.draw(noted.seconds, noted.noise, noted.target, end, side, side, max(1, round(scale)))), scale=size)
        if settings.show_sample_density:
            self._draw_density(pictures.column(), noted, where, context.scene.name, size)

    def _draw_density(self, column: bpy.types.UILayout, noted: render_progress.Noted, where: str, scene_name: str, size: float) -> None:
        density = noted.density
        if density is None:
            column.label(text="Counting the samples" if noted.is_running else "Counted in the next render")
            return
        column.label(text=interface("{least:.0f} to {most:.0f} per pixel", least=density.least, most=density.most))
        column.label(text=interface("Mean {mean:.4g}", mean=density.mean))
        column.template_icon(_show(f"density {where}", (noted.number, scene_name), lambda: graph.density(density.means)), scale=size)


def _lines(noted: render_progress.Noted) -> list[str]:
    lines = [interface("{number:.4g} samples", number=noted.samples)]
    if len(noted.noise) > 0:
        lines.append(interface("Noise {noise}", noise=render_progress.noise_words(float(noted.noise[-1]), noted.target)))
    if noted.is_running and noted.remaining_seconds >= 0.0:
        lines.append(interface("Remaining {time}", time=render_progress.clock(noted.remaining_seconds)))
    return lines


class AJAR_RENDER_PT_progress(_Progress, AjarPanel, Panel):
    bl_options = {"DEFAULT_CLOSED"}


class AJAR_IMAGE_PT_progress(_Progress, WithManual, Panel):
    """In the sidebar of the image editor, which shows the render."""
    bl_space_type = "IMAGE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Ajar"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene.render.engine == ENGINE


class AJAR_VIEW3D_PT_pass(WithManual, Panel):
    """In the shading menu of a 3D view that Ajar renders."""
    bl_label = "Ajar"
    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"
    bl_parent_id = "VIEW3D_PT_shading"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine == ENGINE and context.space_data.shading.type == "RENDERED"

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.space_data.shading.ajar, "show_sample_density")


CLASSES = (AJAR_RENDER_PT_progress, AJAR_IMAGE_PT_progress, AJAR_VIEW3D_PT_pass)


def register() -> None:
    global _pictures
    _pictures = bpy.utils.previews.new()


def unregister() -> None:
    global _pictures
    bpy.utils.previews.remove(_pictures)
    _pictures = None
    _drawn.clear()
