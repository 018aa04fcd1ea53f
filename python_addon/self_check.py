"""Self-check: the parts of this installation, and a test render. It helps to find out why Ajar does not work."""

from __future__ import annotations

import platform
import sys
import traceback
from pathlib import Path

import bpy

from .documentation import AJAR_OT_open_manual
from .translations import report

MODULE = __package__
TEXT_NAME = "Ajar Self-Check"
import_failure = ""   # the error when the compiled module was loaded


def lines() -> list[str]:
    """The lines of the report. Never raises an exception: errors are part of the report."""
    found = [f"Blender {bpy.app.version_string} ({_word(bpy.app.build_commit_date)}), Python {platform.python_version()}",
             f"System: {platform.platform()}, {' '.join(platform.libc_ver())}", f"Add-on: {Path(__file__).parent}"]
    if import_failure:
        return [*found, *_packaged(), "FAILED: the renderer cannot be loaded:", *import_failure.strip().splitlines()]
    try:
        return found + _renderer()
    except Exception:
        return [*found, "FAILED:", *traceback.format_exc().strip().splitlines()]


def _word(value: bytes | str) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else value


def _packaged() -> list[str]:
    """The Python versions and processors for which there are modules."""
    modules = sorted(path for path in (Path(__file__).parent / "ajar").rglob("_ajar.*") if path.suffix in (".so", ".pyd"))
    return [f"Modules inside: {', '.join(f'{path.parent.name}/{path.name}' for path in modules) or 'none'}",
            f"Module wanted: for {sys.implementation.cache_tag}"]


def _renderer() -> list[str]:
    from .ajar_module import ajar

    versions = ", ".join(f"{name} {version}" for name, version in sorted(ajar.library_versions().items()))
    found = [f"Ajar {ajar.version}, {ajar.instruction_set}, from {ajar._ajar.__file__}", f"Its libraries: {versions}"]
    files = {Path(path).name for path in ajar.system.loaded_libraries()}
    others = sorted(name for name in files if not name.startswith(("libajar_", "ajar_", "ajtbb"))
                    and any(word in name.lower() for word in ("embree", "tbb", "openimageio", "openimagedenoise")))
    found.append(f"Others in this process: {', '.join(others) or 'none'}")
    brightness = _render(ajar)
    found.append(f"{'OK' if abs(brightness - 0.5) < 1e-3 else 'FAILED'}: a grey world of 0.5 renders as {brightness:.4f}")
    return found


def _render(ajar) -> float:
    """The mean of an image with a known result."""
    description = ajar.SceneDescription()
    description.world.color = (0.5, 0.5, 0.5)
    camera, settings = description.camera, description.settings
    camera.present, camera.world_from_camera = True, [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    camera.screen_window = (-1.0, 1.0, -1.0, 1.0)
    settings.width = settings.height = 8
    settings.region = (0, 0, 8, 8)
    settings.samples, settings.passes, settings.integrator = 4, ["Combined"], "path"
    session = ajar.Session()
    session.start(description)
    while not session.wait(0.1):
        pass
    error = session.take_error()
    if error:
        raise RuntimeError(error)
    return float(session.snapshot("Combined")[..., :3].mean())


class AJAR_OT_self_check(bpy.types.Operator):
    bl_idname = "ajar.self_check"
    bl_label = "Self-Check"
    bl_description = "Print versions, instruction set and libraries, and render a test picture; the result is copied to the clipboard"

    def execute(self, context: bpy.types.Context) -> set[str]:
        found = lines()
        text = "\n".join(found)
        print(text, flush=True)
        sheet = bpy.data.texts.get(TEXT_NAME) or bpy.data.texts.new(TEXT_NAME)
        sheet.clear()
        sheet.write(text + "\n")
        if not bpy.app.background:
            context.window_manager.clipboard = text
        failed = any(line.startswith("FAILED") for line in found)
        self.report({"ERROR" if failed else "INFO"}, report("{result} (copied; text \"{name}\")", result=found[-1], name=TEXT_NAME))
        return {"FINISHED"}


class AjarPreferences(bpy.types.AddonPreferences):
    bl_idname = MODULE

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column()
        if import_failure:
            column.label(text=import_failure.strip().splitlines()[-1], icon="ERROR", translate=False)
        column.operator(AJAR_OT_open_manual.bl_idname, icon="HELP")
        column.operator(AJAR_OT_self_check.bl_idname, icon="CHECKMARK")
        sheet = bpy.data.texts.get(TEXT_NAME)
        for line in sheet.lines if sheet is not None else ():
            column.label(text=line.body, translate=False)


CLASSES = (AJAR_OT_self_check, AjarPreferences)


register, unregister = bpy.utils.register_classes_factory(CLASSES)
