"""Light hints in the 3D view: attached segments are green, segments after mirrors and glass blue, failed ones red with the reason."""

from __future__ import annotations

import bpy
from bpy_extras import view3d_utils
from mathutils import Vector

from . import compat, hints
from .ajar_module import ajar

COLORS = {
    ajar.HintReport.Segment.Attached: (0.2, 0.9, 0.3, 1.0),
    ajar.HintReport.Segment.Bounced: (0.3, 0.6, 1.0, 1.0),
    ajar.HintReport.Segment.Failed: (1.0, 0.2, 0.15, 1.0),
}
LINE_WIDTH, TEXT_SIZE = 3.0, 13
BACKGROUND = (0.0, 0.0, 0.0, 0.75)   # of texts

_handles: list[object] = []


def segments_of(known: hints.Attachment) -> list[tuple[Vector, Vector, ajar.HintReport.Segment]]:
    """The segments of a hint. A segment without a hit ends at the artist's control point."""
    positions = [Vector(position) for position in known.positions]
    found = []
    for i, segment in enumerate(known.segments):
        if i >= len(positions):
            break
        end = positions[i + 1] if i + 1 < len(positions) else Vector(known.points[min(i + 1, len(known.points) - 1)])
        found.append((positions[i], end, segment))
    return found


def _shown(context: bpy.types.Context) -> list[tuple[bpy.types.Object, hints.Attachment]]:
    if context.engine != "AJAR" or not context.space_data.overlay.show_overlays:
        return []
    pairs = [(curve, hints.attachment_of(curve)) for curve in hints.curves_of(context.scene) if curve.visible_get()]
    return [(curve, known) for curve, known in pairs if known is not None]


def _draw_lines() -> None:
    shown = _shown(bpy.context)
    if not shown:
        return
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin(compat.POLYLINE_SHADER)
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", LINE_WIDTH * bpy.context.preferences.system.ui_scale)
    for _, known in shown:
        for kind, color in COLORS.items():
            ends = [end for a, b, segment in segments_of(known) if segment == kind for end in (a, b)]
            if ends:
                shader.uniform_float("color", color)
                batch_for_shader(shader, "LINES", {"pos": ends}).draw(shader)


def _draw_words() -> None:
    context = bpy.context
    failed = [(curve, known) for curve, known in _shown(context) if not known.attached]
    if not failed:
        return
    import blf
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin(compat.FLAT_SHADER)
    size = round(TEXT_SIZE * context.preferences.system.ui_scale)
    compat.font_size(0, size)
    blf.color(0, *COLORS[ajar.HintReport.Segment.Failed])
    for number, (curve, known) in enumerate(failed):
        end = known.positions[-1] if known.positions else (known.points[0] if len(known.points) else curve.matrix_world.translation)
        text = f"{curve.name}: {known.reason}"
        place = view3d_utils.location_3d_to_region_2d(context.region, context.region_data, Vector(end), default=Vector((0, 2 * number * size)))
        # Inside the part of the view that no panel covers.
        left, right, bottom, top = _free_of_panels(context.area, context.region)
        width = blf.dimensions(0, text)[0]
        x, y = max(left + size, min(place.x + size, right - size - width)), max(bottom + size, min(place.y, top - 2 * size))
        edges = (x - 0.5 * size, y - 0.5 * size, x + width + 0.5 * size, y + 1.1 * size)
        gpu.state.blend_set("ALPHA")
        shader.bind()
        shader.uniform_float("color", BACKGROUND)
        batch_for_shader(shader, "TRI_STRIP", {"pos": [(edges[i], edges[j]) for i in (0, 2) for j in (1, 3)]}).draw(shader)
        gpu.state.blend_set("NONE")
        blf.position(0, x, y, 0.0)
        blf.draw(0, text)


def _free_of_panels(area: bpy.types.Area, region: bpy.types.Region) -> tuple[float, float, float, float]:
    """Left, right, bottom, top of the part of the region that toolbar, sidebar and headers do not cover."""
    left, right, bottom, top = 0, region.width, 0, region.height
    for other in area.regions:
        if other.type == "TOOLS" and other.width > 1:
            left = max(left, other.x + other.width - region.x)
        if other.type == "UI" and other.width > 1:
            right = min(right, other.x - region.x)
        if other.type in ("HEADER", "TOOL_HEADER") and other.height > 1:
            if other.y > region.y + region.height / 2:
                top = min(top, other.y - region.y)
            else:
                bottom = max(bottom, other.y + other.height - region.y)
    return left, right, bottom, top


def register() -> None:
    if bpy.app.background:
        return
    add = bpy.types.SpaceView3D.draw_handler_add
    _handles.append(add(_draw_lines, (), "WINDOW", "POST_VIEW"))
    _handles.append(add(_draw_words, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
