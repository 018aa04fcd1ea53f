"""Warnings before a render. A warning that a click can fix has a button.

There are two types: settings, which are checked whenever the panel is drawn, and diagnostics of the export and the build of the scene (unknown nodes,
missing images, invalid meshes), which Check Scene finds without rendering.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy

from . import hints, inherited
from .ajar_module import ajar
from .export import camera, export_contents, settings
from .export.context import ExportContext
from .headless import Options
from .translations import report

HINT_INTEGRATORS = {info.name for info in ajar.integrator_list() if info.follows_hints}


@dataclass(frozen=True)
class Fix:
    """A setting that makes the image worse, with the operator that changes it."""

    name: str
    text: str
    button: str
    applies: Callable[[bpy.types.Scene], bool]
    fix: Callable[[bpy.types.Scene], None]


def _set(**values) -> Callable[[bpy.types.Scene], None]:
    def fix(scene: bpy.types.Scene) -> None:
        for name, value in values.items():
            setattr(scene.ajar, name, value)
    return fix


def _take_camera(scene: bpy.types.Scene) -> None:
    found = next((thing for thing in scene.objects if thing.type == "CAMERA"), None)
    if found is None:
        found = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        found.location, found.rotation_euler = (7.36, -6.93, 4.96), (1.109, 0.0, 0.815)  # as in Blender's default scene
        scene.collection.objects.link(found)
    scene.camera = found


def _is_biased(scene: bpy.types.Scene) -> bool:
    return any(info.biased for info in ajar.direct_method_list() if info.name == scene.ajar.direct)


FIXES = (
    Fix("CAMERA", "The scene has no camera, so there is nothing to render.", "Use or Add a Camera",
        lambda scene: scene.camera is None or scene.camera.type != "CAMERA", _take_camera),   # any object can be the camera of a scene
    Fix("CLAMPING", "Clamping removes light: bright parts of the picture become too dark.", "Switch Clamping Off",
         lambda scene: scene.ajar.integrator == "path" and (scene.ajar.clamp_direct > 0 or scene.ajar.clamp_indirect > 0),
         _set(clamp_direct=0.0, clamp_indirect=0.0)),
    Fix("CAUSTICS", "Caustics are switched off: light from mirrors and through glass is missing.", "Switch Caustics On",
         lambda scene: not (scene.ajar.reflective_caustics and scene.ajar.refractive_caustics),
         _set(reflective_caustics=True, refractive_caustics=True)),
    Fix("HINTS", "Light hints are drawn, but the integrator does not follow them.", "Use Auto",
         lambda scene: scene.ajar.integrator not in HINT_INTEGRATORS and any(curve.ajar.hint_enabled for curve in hints.curves_of(scene)),
         _set(integrator="auto")),
    Fix("BIASED", "The direct light method is biased: an error remains after any number of samples.", "Use MIS", _is_biased, _set(direct="mis")),
)


def found_in(scene: bpy.types.Scene) -> list[Fix]:
    return [fix for fix in FIXES if fix.applies(scene)]


def missing_images() -> list[str]:
    """Names of used images whose files do not exist at their paths."""
    return [image.name for image in bpy.data.images
            if image.source == "FILE" and image.users > 0 and image.packed_file is None and image.filepath and "<UDIM>" not in image.filepath
            and not Path(bpy.path.abspath(image.filepath, library=image.library)).is_file()]


_messages: dict[str, list[tuple[str, str]]] = {}


def messages_of(scene: bpy.types.Scene) -> list[tuple[str, str]] | None:
    """Names and texts of the last Check Scene, or None if it was not run yet."""
    return _messages.get(scene.name)


def check(context: bpy.types.Context) -> list[tuple[str, str]]:
    """Export and build the scene, and return the warnings."""
    depsgraph = context.evaluated_depsgraph_get()
    exported = ExportContext(depsgraph, lambda: False, lambda step: None)
    settings.export(exported, Options({"samples": 1, "integrator": "path"}), ["Combined"])
    camera.export(exported, depsgraph.scene_eval.camera)
    export_contents(exported)
    limits = exported.description.settings
    limits.width = limits.height = 1
    limits.region = [0, 0, 0, 0]
    session = ajar.Session()
    session.start(exported.description)
    while not session.wait(0.2):
        pass
    error = session.take_error()
    if error:
        raise RuntimeError(error)
    return [(name, text) for name, text in exported.warnings] + [(found.object, found.message) for found in session.diagnostics()]


class AJAR_OT_fix(bpy.types.Operator):
    bl_idname = "ajar.fix"
    bl_label = "Fix"
    bl_description = "Change the setting that this warning is about"
    bl_options = {"REGISTER", "UNDO"}

    what: bpy.props.EnumProperty(name="Warning", items=[(fix.name, fix.button, fix.text) for fix in FIXES])

    def execute(self, context: bpy.types.Context) -> set[str]:
        next(fix for fix in FIXES if fix.name == self.what).fix(context.scene)
        return {"FINISHED"}


class AJAR_OT_check_scene(bpy.types.Operator):
    bl_idname = "ajar.check_scene"
    bl_label = "Check Scene"
    bl_description = "Read and build the scene without rendering it, and list what is not supported, approximated, missing or invalid"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine == "AJAR"

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            found = check(context)
        except RuntimeError as error:  # a message of the core
            _messages[context.scene.name] = [("", str(error))]
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        _messages[context.scene.name] = found
        if len(found) == 1:
            self.report({"WARNING"}, report("1 warning, listed in the render properties"))
        elif found:
            self.report({"WARNING"}, report("{number} warnings, listed in the render properties", number=len(found)))
        else:
            self.report({"INFO"}, report("No problems found"))
        return {"FINISHED"}


class AJAR_OT_inherit_settings(bpy.types.Operator):
    bl_idname = "ajar.inherit_settings"
    bl_label = "Take All from Cycles"
    bl_description = "Discard the values set in Ajar, wherever Cycles has the same setting"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene.ajar.use_cycles_settings

    def execute(self, context: bpy.types.Context) -> set[str]:
        inherited.forget_own(context.scene.ajar)
        return {"FINISHED"}


CLASSES = (AJAR_OT_fix, AJAR_OT_check_scene, AJAR_OT_inherit_settings)


register, unregister = bpy.utils.register_classes_factory(CLASSES)
