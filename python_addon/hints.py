"""Light hints of the artist: how the core attached them, and the operators that create them.

Any curve in the collection of the render settings is a light hint. Its attachment to lights and surfaces is known after a render, while a view is
rendered, or after Check Light Hints. The overlay (`hint_overlay.py`) and the panels show it until the curve changes.
"""

# No `from __future__ import annotations`: Blender needs the annotations as objects, not as text.

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from bpy_extras import view3d_utils
from mathutils import Vector

from .ajar_module import ajar
from .export import ExportContext, camera, export_contents, hints as export_hints, settings
from .headless import Options
from .translations import interface, report, tooltip

SNAP_DISTANCE = 1e-3      # in metres, of drawn points to their surface
NOT_CHECKED = "Not checked yet"


@dataclass
class Attachment:
    """The attachment of one light hint."""

    points: np.ndarray                     # control points at the time of the attachment
    attached: bool
    reason: str
    positions: list[tuple[float, float, float]]
    segments: list[ajar.HintReport.Segment]


_attachments: dict[str, Attachment] = {}


def points_of(description: ajar.SceneDescription) -> dict[str, np.ndarray]:
    return {hint.name: hint.points for hint in description.hints}


def remember(reports: list[ajar.HintReport], points: dict[str, np.ndarray]) -> None:
    _attachments.clear()
    for told in reports:
        if told.name in points:
            _attachments[told.name] = Attachment(points[told.name], told.attached, told.reason, told.positions, told.segments)


def attachment_of(curve: bpy.types.Object) -> Attachment | None:
    """The attachment of a curve in its present form; for a curve with several splines, that of the first."""
    if curve.type != "CURVE" or not curve.data.splines:
        return None
    known = _attachments.get(curve.name) or _attachments.get(f"{curve.name}, part 1")
    if known is None:
        return None
    points = export_hints.points_of(curve, curve.data.splines[0], curve.matrix_world, curve.ajar.hint_light)
    same = points.shape == known.points.shape and np.allclose(points, known.points, atol=1e-5)
    return known if same else None


def status_of(curve: bpy.types.Object) -> str:
    """The state of a hint as a text for the artist."""
    if not curve.ajar.hint_enabled:
        return interface("Not used")
    known = attachment_of(curve)
    if known is None:
        return interface(NOT_CHECKED)
    if not known.attached:
        return interface("Failed: {reason}", reason=known.reason)
    bounced = sum(segment == ajar.HintReport.Segment.Bounced for segment in known.segments)
    if bounced:
        return interface("Attached, {number} segments, {bounced} by mirrors or glass", number=len(known.segments), bounced=bounced)
    return interface("Attached, {number} segments", number=len(known.segments))


def curves_of(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    collection = export_hints.collection_of(scene)
    return [thing for thing in collection.all_objects if thing.type == "CURVE"] if collection is not None else []


def make_collection(context: bpy.types.Context) -> bpy.types.Collection:
    """The collection of light hints. It is created and linked to the scene if it does not exist."""
    scene = context.scene
    collection = export_hints.collection_of(scene)
    if collection is None:
        collection = bpy.data.collections.new(scene.ajar.hint_collection or export_hints.COLLECTION)
        scene.ajar.hint_collection = collection.name
    if collection not in scene.collection.children_recursive:
        scene.collection.children.link(collection)
    return collection


def new_path(context: bpy.types.Context, points: list[Vector], name: str = "Light Hint") -> bpy.types.Object:
    """Create a curve of straight segments in the collection of light hints, and select only it."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    set_points(data, points)
    curve = bpy.data.objects.new(name, data)
    make_collection(context).objects.link(curve)
    for thing in context.selected_objects:
        thing.select_set(False)
    curve.select_set(True)
    context.view_layer.objects.active = curve
    return curve


def set_points(data: bpy.types.Curve, points: list[Vector]) -> None:
    data.splines.clear()
    spline = data.splines.new("POLY")
    spline.points.add(len(points) - 1)
    spline.points.foreach_set("co", [number for point in points for number in (*point, 1.0)])


def _describe(context: bpy.types.Context) -> ajar.SceneDescription:
    """The description of the present scene."""
    depsgraph = context.evaluated_depsgraph_get()
    exported = ExportContext(depsgraph, lambda: False, lambda step: None)
    settings.export(exported, Options(), ["Combined"])
    camera.export(exported, depsgraph.scene_eval.camera)
    export_contents(exported)
    return exported.description


def check(context: bpy.types.Context) -> None:
    """Attach the light hints of the present scene."""
    description = _describe(context)
    points = points_of(description)
    remember(ajar.attach_hints(description), points)
    redraw_views(context)


def redraw_views(context: bpy.types.Context) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in ("VIEW_3D", "PROPERTIES"):
                area.tag_redraw()


def _is_ours(context: bpy.types.Context) -> bool:
    return context.engine == "AJAR" and context.mode == "OBJECT"


class AJAR_OT_mark_light_hint(bpy.types.Operator):
    bl_idname = "ajar.mark_light_hint"
    bl_label = "Mark as Light Hint"
    bl_description = "Let the selected curves show the renderer where light goes"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _is_ours(context) and any(thing.type == "CURVE" for thing in context.selected_objects)

    def execute(self, context: bpy.types.Context) -> set[str]:
        collection = make_collection(context)
        for thing in context.selected_objects:
            if thing.type == "CURVE" and thing.name not in collection.objects:
                collection.objects.link(thing)
        return {"FINISHED"}


class AJAR_OT_unmark_light_hint(bpy.types.Operator):
    bl_idname = "ajar.unmark_light_hint"
    bl_label = "Unmark Light Hint"
    bl_description = "The selected curves are ordinary curves again"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        marked = curves_of(context.scene) if _is_ours(context) else []
        return any(thing in marked for thing in context.selected_objects)

    def execute(self, context: bpy.types.Context) -> set[str]:
        collection = export_hints.collection_of(context.scene)
        if collection is None:
            return {"CANCELLED"}
        for thing in context.selected_objects:
            for owner in [collection, *collection.children_recursive]:
                if thing.type == "CURVE" and thing.name in owner.objects:
                    owner.objects.unlink(thing)
            if thing.type == "CURVE" and not thing.users_collection:
                context.scene.collection.objects.link(thing)
        return {"FINISHED"}


class AJAR_OT_check_light_hints(bpy.types.Operator):
    bl_idname = "ajar.check_light_hints"
    bl_label = "Check Light Hints"
    bl_description = "Find out whether each light hint meets its light and surfaces"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _is_ours(context) and bool(curves_of(context.scene))

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            check(context)
        except RuntimeError as error:  # a message of the core
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        failed = [curve.name for curve in curves_of(context.scene) if (known := attachment_of(curve)) is not None and not known.attached]
        if failed:
            self.report({"WARNING"}, report("Not attached: {names}", names=", ".join(failed)))
        else:
            self.report({"INFO"}, report("All light hints are attached"))
        return {"FINISHED"}


class AJAR_OT_suggest_light_hints(bpy.types.Operator):
    bl_idname = "ajar.suggest_light_hints"
    bl_label = "Suggest Light Hints"
    bl_description = "Search for light that path tracing rarely finds, and draw its paths as curves that can be edited"
    bl_options = {"REGISTER", "UNDO"}

    count: bpy.props.IntProperty(name="At Most", description="Maximum number of curves that are drawn", default=6, min=1, max=50)
    samples: bpy.props.IntProperty(name="Samples", description="Samples of the search. More samples find rarer light", default=40000, min=1000, max=10**7)
    seed: bpy.props.IntProperty(name="Seed", description="A different seed searches with different random numbers", default=0, min=0)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _is_ours(context) and context.scene.camera is not None

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            found = ajar.suggest_hints(_describe(context), self.count, self.samples, self.seed)
            for points, _ in found:
                curve = new_path(context, [Vector(point) for point in points], "Suggested Hint")
                lamp = curve.ajar.hint_light = _lamp_at(context, points[0])
                if lamp is not None:
                    curve.ajar.hint_offset = lamp.matrix_world.inverted_safe() @ Vector(points[0])
            if found:
                check(context)
        except RuntimeError as error:  # a message of the core
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not found:
            self.report({"INFO"}, report("Path tracing finds the light of this scene well: there is nothing to suggest"))
            return {"CANCELLED"}
        share = sum(share for _, share in found)
        self.report({"INFO"}, report("{number} light hints suggested. About {share:.0%} of the noise of path tracing comes from light near them", number=len(found), share=share))
        return {"FINISHED"}


def _lamp_at(context: bpy.types.Context, place: tuple[float, float, float]) -> bpy.types.Object | None:
    """The lamp at which a path starts, or None if it starts at an emissive surface."""
    def distance(lamp: bpy.types.Object) -> float:
        data = lamp.data
        extent = max(data.size, data.size_y) * max(lamp.scale) if data.type == "AREA" else data.shadow_soft_size
        return (lamp.matrix_world.translation - Vector(place)).length - extent
    lamps = [thing for thing in context.visible_objects if thing.type == "LIGHT" and thing.data.type != "SUN"]
    lamp = min(lamps, key=distance, default=None)
    return lamp if lamp is not None and distance(lamp) < 1e-3 else None


class AJAR_OT_draw_light_hint(bpy.types.Operator):
    bl_idname = "ajar.draw_light_hint"
    bl_label = "Draw Light Hint"
    bl_description = "From the active lamp, click from surface to surface to where the light should arrive"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if context.object is None or context.object.type != "LIGHT":
            cls.poll_message_set(tooltip("Select the lamp that the light comes from"))
            return False
        return _is_ours(context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if context.area is None or context.area.type != "VIEW_3D":
            self.report({"ERROR"}, report("Draw in a 3D view"))
            return {"CANCELLED"}
        lamp = context.object
        self.points = [lamp.matrix_world.translation.copy()]
        self.curve = new_path(context, self.points * 2, f"{lamp.name} Hint")
        self.curve.ajar.hint_light = lamp
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set(interface("Click: add a point on the surface    Backspace: remove it    Enter or right click: finish    Esc: cancel"))
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        context.area.tag_redraw()
        if event.type == "ESC" and event.value == "PRESS":
            return self.leave(context, keep=False)
        if event.type in ("RET", "NUMPAD_ENTER", "RIGHTMOUSE") and event.value == "PRESS":
            return self.leave(context, keep=len(self.points) > 1)
        if event.type == "BACK_SPACE" and event.value == "PRESS":
            if len(self.points) > 1:
                self.points.pop()
            self.show(self.points)
            return {"RUNNING_MODAL"}
        if event.type in ("MOUSEMOVE", "LEFTMOUSE") and event.value != "RELEASE":
            place = self.surface_under(context, event)
            if place is not None:
                if event.type == "LEFTMOUSE":
                    self.points.append(place)
                self.show([*self.points, place])
            return {"RUNNING_MODAL"}
        return {"PASS_THROUGH"}  # navigation

    def cancel(self, context: bpy.types.Context) -> None:
        """Called when Blender ends the operator, for example because another file is opened."""
        context.workspace.status_text_set(None)

    def surface_under(self, context: bpy.types.Context, event: bpy.types.Event) -> Vector | None:
        region, region_3d = context.region, context.region_data
        if region is None or region_3d is None:
            return None
        mouse = (event.mouse_x - region.x, event.mouse_y - region.y)
        origin = view3d_utils.region_2d_to_origin_3d(region, region_3d, mouse)
        direction = view3d_utils.region_2d_to_vector_3d(region, region_3d, mouse)
        found, place, normal, *_ = context.scene.ray_cast(context.evaluated_depsgraph_get(), origin, direction)
        if not found:
            return None
        return place + normal * (SNAP_DISTANCE if normal.dot(direction) < 0.0 else -SNAP_DISTANCE)

    def show(self, points: list[Vector]) -> None:
        set_points(self.curve.data, points if len(points) > 1 else points * 2)

    def leave(self, context: bpy.types.Context, keep: bool) -> set[str]:
        context.workspace.status_text_set(None)
        if not keep:
            bpy.data.curves.remove(self.curve.data)  # also removes its object
            return {"CANCELLED"}
        self.show(self.points)
        try:
            check(context)
        except RuntimeError as error:
            self.report({"WARNING"}, str(error))
        return {"FINISHED"}


CLASSES = (AJAR_OT_mark_light_hint, AJAR_OT_unmark_light_hint, AJAR_OT_check_light_hints, AJAR_OT_suggest_light_hints,
           AJAR_OT_draw_light_hint)


def _menu(self, context: bpy.types.Context) -> None:
    if context.engine == "AJAR":
        self.layout.separator()
        self.layout.operator(AJAR_OT_mark_light_hint.bl_idname)


def _under_old_name(operator: Any) -> type:
    """The operator under its old name, which contains "light path", for scripts and key maps."""
    old = operator.__name__.replace("light_hint", "light_path")
    values = {name: value for name, value in vars(operator).items() if name not in ("bl_rna", "__dict__", "__weakref__")}
    return type(old, operator.__bases__, values | {"bl_idname": operator.bl_idname.replace("light_hint", "light_path"),
                                                   "bl_options": set(getattr(operator, "bl_options", ())) | {"INTERNAL"}})


_register_classes, _unregister_classes = bpy.utils.register_classes_factory((*CLASSES, *map(_under_old_name, CLASSES)))


def register() -> None:
    _register_classes()
    bpy.types.VIEW3D_MT_object.append(_menu)


def unregister() -> None:
    bpy.types.VIEW3D_MT_object.remove(_menu)
    _unregister_classes()
    _attachments.clear()
