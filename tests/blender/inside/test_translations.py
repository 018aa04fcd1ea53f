"""Tests of the table of translations: it has only texts of the add-on, it has all texts that Blender looks up, and Blender shows them."""

from __future__ import annotations

import ast
import string
import types
from collections.abc import Iterator
from pathlib import Path

import ajar_render
import bpy
import pytest
from ajar_render import checks, documentation, engine, hints, presets, translations, unsupported
from ajar_render.ajar_module import ajar

ADDON = Path(ajar_render.__file__).parent
SOURCES = [path for path in sorted(ADDON.rglob("*.py")) if path.relative_to(ADDON).parts[0] not in ("ajar", "translations")]
TEXT_ARGUMENT = {"interface": 0, "report": 0, "tooltip": 0, "say": 1, "warn": 1}   # functions of the add-on that translate, and the index of the argument
KEYWORDS = {"text", "heading"}                                                     # arguments of layout functions that Blender translates
BUILT_AT_RUN_TIME = {"status_text_set": 0, "poll_message_set": 0}                  # functions of Blender that do not translate, and the index of the argument
UNSUPPORTED = (unsupported.SCENE, unsupported.VIEW_LAYER, unsupported.OBJECT, unsupported.WORLD, unsupported.CAMERA)
LANGUAGES = list(translations.LANGUAGES)


# ---- Texts of the add-on --------------------------------------------------------------------------------------------------

def own_classes(*kinds: type) -> Iterator[type]:
    for kind in kinds:
        yield from documentation.own(kind)


def labels() -> set[str]:
    """The titles of panels and menus, and the names of properties and of their choices."""
    found = {kind.bl_label for kind in own_classes(bpy.types.Panel, bpy.types.Menu)}
    for prop in own_properties():
        found.add(prop.name)
        found |= {item.name for item in prop.enum_items} if prop.type == "ENUM" else set()
    return found - {""}


def own_properties() -> Iterator[bpy.types.Property]:
    for group in own_classes(bpy.types.PropertyGroup):
        yield from (prop for name, prop in group.bl_rna.properties.items() if name not in ("rna_type", "name"))
    for operator in own_classes(bpy.types.Operator):
        known = getattr(bpy.ops.ajar, operator.bl_idname.partition(".")[2]).get_rna_type().properties
        yield from (known[name] for name in getattr(operator, "__annotations__", ()))


def descriptions() -> set[str]:
    found = {operator.bl_description for operator in own_classes(bpy.types.Operator)}
    for prop in own_properties():
        found.add(prop.description)
        found |= {item.description for item in prop.enum_items} if prop.type == "ENUM" else set()
    return found - {""}


def operator_labels() -> set[str]:
    """The labels of operators, and the texts of buttons that replace them."""
    return {operator.bl_label for operator in own_classes(bpy.types.Operator)} | {fix.button for fix in checks.FIXES} | {label for label, _, _ in presets.PRESETS.values()}


def calls() -> Iterator[tuple[Path, ast.Call, str]]:
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call):
                yield path, node, node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")


def shown_arguments() -> Iterator[tuple[Path, ast.expr]]:
    """The expressions in the source that are texts of the user interface."""
    for path, call, name in calls():
        number = (TEXT_ARGUMENT | BUILT_AT_RUN_TIME).get(name)
        if name == "report" and isinstance(call.func, ast.Attribute):   # of an operator or an engine; the arguments are kind and text
            number = 1
        if number is not None and len(call.args) > number:
            yield path, call.args[number]
        if name != "add_property":   # a text in a graph of shader nodes is data
            yield from ((path, word.value) for word in call.keywords if word.arg in KEYWORDS)


def choices(node: ast.expr) -> list[ast.expr]:
    """Both texts of `one if condition else other`."""
    return [*choices(node.body), *choices(node.orelse)] if isinstance(node, ast.IfExp) else [node]


def messages() -> set[str]:
    """The literal texts among the shown arguments, and the texts of warnings, fixes and presets."""
    found = {part.value for _, node in shown_arguments() for part in choices(node) if isinstance(part, ast.Constant) and isinstance(part.value, str)}
    found |= {text for settings in UNSUPPORTED for text in (setting.text for setting in settings)} | {fix.text for fix in checks.FIXES} | {tip for _, tip, _ in presets.PRESETS.values()}
    return found - {""}


def constants() -> set[str]:
    """All strings in the source, and the texts of the core."""
    found = {node.value for path in SOURCES for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    found |= {text for info in [*ajar.integrator_list(), *ajar.direct_method_list()] for text in (info.label, info.sentence)}
    for info in ajar.setting_list():
        found |= {info.label, info.description} | {text for _, label, sentence, _ in info.choices for text in (label, sentence)}
    return found


def fields(text: str) -> set[str]:
    return {name for _, name, _, _ in string.Formatter().parse(text) if name is not None}


# ---- The source -----------------------------------------------------------------------------------------------------------

def is_made_of_parts(node: ast.expr) -> bool:
    """Whether the text already contains values, so that Blender cannot look it up."""
    return any(isinstance(part, (ast.JoinedStr, ast.BinOp)) or (isinstance(part, ast.Call) and isinstance(part.func, ast.Attribute) and part.func.attr == "format")
               for part in choices(node))


def test_values_are_not_inserted_before_the_translation():
    assert [f"{path.relative_to(ADDON)}:{node.lineno}" for path, node in shown_arguments() if is_made_of_parts(node)] == []
    assert is_made_of_parts(ast.parse('f"{a} warnings"', mode="eval").body) and not is_made_of_parts(ast.parse('"warnings"', mode="eval").body)


def test_texts_that_blender_does_not_translate_are_translated_by_the_add_on():
    for path, call, name in calls():
        if name in BUILT_AT_RUN_TIME and call.args and isinstance(call.args[0], ast.Constant):
            assert call.args[0].value is None, f"{path.relative_to(ADDON)}:{call.lineno}"


# ---- The tables -----------------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("code", LANGUAGES)
def test_every_key_is_a_text_of_the_add_on(code):
    language = translations.LANGUAGES[code]
    assert sorted(set(language.TEXTS) - labels() - descriptions() - messages() - constants()) == []
    assert sorted(set(language.OPERATORS) - operator_labels() - messages()) == []


@pytest.mark.parametrize("code", LANGUAGES)
def test_all_titles_names_and_messages_are_in_the_table(code):
    language = translations.LANGUAGES[code]
    assert sorted((labels() | messages() | descriptions()) - set(language.TEXTS) - set(language.OPERATORS)) == []
    assert sorted(operator_labels() - set(language.OPERATORS)) == []
    assert len(labels()) > 100 and len(messages()) > 60 and len(operator_labels()) > 15


@pytest.mark.parametrize("code", LANGUAGES)
def test_format_fields_are_those_of_the_original(code):
    for table in (translations.LANGUAGES[code].TEXTS, translations.LANGUAGES[code].OPERATORS):
        for text, translated in table.items():
            assert translated.strip(), text
            assert fields(translated) == fields(text), text


@pytest.mark.parametrize("code", LANGUAGES)
def test_no_text_has_two_translations(code):
    """Python would silently use the second of two entries for the same text."""
    source = Path(translations.LANGUAGES[code].__file__).read_text(encoding="utf-8")
    for table in (node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Dict)):
        keys = [key.value for key in table.keys if isinstance(key, ast.Constant)]
        assert sorted({key for key in keys if keys.count(key) > 1}) == []


# ---- Blender --------------------------------------------------------------------------------------------------------------

@pytest.fixture
def german():
    """Switches Blender to German. The test is skipped in a Blender without languages."""
    view = bpy.context.preferences.view
    if not bpy.app.build_options.international:
        pytest.skip("this Blender was built without languages")
    before = view.language
    view.language = next(name for name in bpy.app.translations.locales if name in ("de_DE", "de"))
    switches = [name for name in ("use_translate_interface", "use_translate_tooltips", "use_translate_reports") if hasattr(view, name)]
    for name in switches:
        setattr(view, name, True)
    yield view
    for name in switches:
        setattr(view, name, False)
    view.language = before


def test_blender_shows_the_table(german):
    """Blender's own translation has precedence over that of the add-on."""
    translations.unregister()
    own = {key: bpy.app.translations.pgettext(key[1], key[0]) for key in translations.table()["de"]}
    translations.register()
    assert sum(translated == key[1] for key, translated in own.items()) > 100
    shown = {key: bpy.app.translations.pgettext(key[1], key[0]) for key in own}
    assert {key: text for key, text in shown.items() if text not in (translations.table()["de"][key], own[key])} == {}
    assert sum(text == translations.table()["de"][key] for key, text in shown.items()) > 0.9 * len(shown)


def test_no_text_is_translated_in_an_english_interface(scene):
    assert translations.interface("Light Hints") == "Light Hints"
    assert translations.interface("{share:.0%} accepted", share=0.5) == "50% accepted"


def test_values_are_filled_in_after_the_translation(german):
    assert translations.interface("{share:.0%} accepted", share=0.5) == "50% angenommen"
    german.use_translate_interface = False
    assert translations.interface("{share:.0%} accepted", share=0.5) == "50% accepted"


def test_reports_and_states_are_german(german, scene):
    curve = hints.new_path(bpy.context, [hints.Vector((0, 0, 0)), hints.Vector((1, 0, 0))], "Path")
    assert hints.status_of(curve) == translations.german.TEXTS["Not checked yet"]
    curve.ajar.hint_enabled = False
    assert hints.status_of(curve) == translations.german.TEXTS["Not used"]
    progress = types.SimpleNamespace(phase=ajar.Progress.Phase.Building, step="shaders", samples=8.0, shown_relmse=1e-4, remaining_seconds=75.0)
    assert engine.describe(progress, 0.0).startswith("Aufbau: ")
    progress.phase = None
    assert engine.describe(progress, 1e-4) == "8 Abtastwerte | Rauschen 1 % von 1 % | Verbleibend 01:15"


def test_warnings_of_the_export_are_german(german, scene, export_context):
    scene.view_layers[0].ajar.light_groups.add().name = "Gone"
    text = translations.german.TEXTS["its light group {group} does not exist, so that the importance of this group is not used"]
    assert (scene.view_layers[0].name, text.format(group="Gone")) in export_context().warnings
