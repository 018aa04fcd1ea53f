"""Messages of an export and of the core in Blender's reports."""

from __future__ import annotations

import bpy

from .ajar_module import ajar
from .export import ExportContext
from .translations import report

_KINDS = {ajar.Diagnostic.Severity.Info: "INFO", ajar.Diagnostic.Severity.Warning: "WARNING"}


def report_warnings(engine: bpy.types.RenderEngine, exported: ExportContext) -> None:
    for name, message in exported.warnings:
        engine.report({"WARNING"}, report("{name}: {message}", name=name, message=message))


def report_diagnostic(engine: bpy.types.RenderEngine, diagnostic: ajar.Diagnostic) -> None:
    message = report(diagnostic.message)
    engine.report({_KINDS.get(diagnostic.severity, "ERROR")},
                  report("{name}: {message}", name=diagnostic.object, message=message) if diagnostic.object else message)
