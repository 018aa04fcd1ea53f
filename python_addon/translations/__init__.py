"""Translations of the texts that the add-on shows.

Blender itself translates names and descriptions of properties, titles of panels and literal texts of buttons. A text with values is a template: it is
translated before the values are filled in, and the functions below do both. `german.py` is the table of one language; for another language, copy it,
translate the right-hand sides, and add it to LANGUAGES. Blender's translation of a text has precedence over that of Ajar.

Texts of the core (reasons, names of steps), of the command line and of self-check reports are in English.
"""

from __future__ import annotations

import bpy

from . import german

# Language code of Blender, without a country: "de" serves `de_DE` and newer versions' `de`.
LANGUAGES = {"de": german}
DEFAULT_CONTEXT, OPERATOR_CONTEXT = "*", "Operator"

_translations = bpy.app.translations
_translate_report = getattr(_translations, "pgettext_rpt", _translations.pgettext_tip)   # reports have a separate function since 4.1


def interface(text: str, **values: object) -> str:
    """Translate a label or a title. `values` are filled into its format fields."""
    return _fill(_translations.pgettext_iface(text), values)


def report(text: str, /, **values: object) -> str:
    """Translate a message to the artist."""
    return _fill(_translate_report(text), values)


def tooltip(text: str, **values: object) -> str:
    return _fill(_translations.pgettext_tip(text), values)


def _fill(text: str, values: dict[str, object]) -> str:
    return text.format(**values) if values else text


def table() -> dict[str, dict[tuple[str, str], str]]:
    """The argument of bpy.app.translations.register: language -> (context, English) -> translation."""
    return {code: {(DEFAULT_CONTEXT, text): translated for text, translated in language.TEXTS.items()}
            | {(OPERATOR_CONTEXT, text): translated for text, translated in language.OPERATORS.items()} for code, language in LANGUAGES.items()}


def register() -> None:
    bpy.app.translations.register(__package__, table())


def unregister() -> None:
    bpy.app.translations.unregister(__package__)
