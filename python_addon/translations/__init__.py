"""Translations of the texts that the add-on shows.

Blender translates names and descriptions of properties, titles of panels and literal texts of buttons by itself. A text that contains values is a template, which is translated
before the values are filled in; the functions below do both. `german.py` is the table of one language; for another language, copy it, translate the right-hand sides, and add
it to LANGUAGES. Blender's own translation of a text has precedence over ours.

Text from the core (reasons, names of steps) and everything on the command line and in self-check reports stays English.
"""

from __future__ import annotations

import bpy

from . import german

# Language code of Blender, without a country: "de" serves `de_DE` and newer versions' `de`.
LANGUAGES = {"de": german}
DEFAULT_CONTEXT, OPERATOR_CONTEXT = "*", "Operator"

_translations = bpy.app.translations
_translate_report = getattr(_translations, "pgettext_rpt", _translations.pgettext_tip)   # reports are a kind of their own since 4.1


def interface(text: str, **values: object) -> str:
    """A label or a title; `values` are filled into its format fields."""
    return _fill(_translations.pgettext_iface(text), values)


def report(text: str, /, **values: object) -> str:
    """A message to the artist."""
    return _fill(_translate_report(text), values)


def tooltip(text: str, **values: object) -> str:
    return _fill(_translations.pgettext_tip(text), values)


def _fill(text: str, values: dict[str, object]) -> str:
    return text.format(**values) if values else text


def table() -> dict[str, dict[tuple[str, str], str]]:
    """As bpy.app.translations.register takes it: language -> (context, English) -> translation."""
    return {code: {(DEFAULT_CONTEXT, text): translated for text, translated in language.TEXTS.items()}
            | {(OPERATOR_CONTEXT, text): translated for text, translated in language.OPERATORS.items()} for code, language in LANGUAGES.items()}


def register() -> None:
    bpy.app.translations.register(__package__, table())


def unregister() -> None:
    bpy.app.translations.unregister(__package__)
