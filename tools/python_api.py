#!/usr/bin/env python3
"""Write docs/developer/python_api.md from the docstrings of the module `ajar`:

    PYTHONPATH=build/release/python python3 tools/python_api.py

A class, function, property or enumerator without a docstring is an error that names it.
"""

from __future__ import annotations

import inspect
import sys
from pathlib import Path

PAGE = Path(__file__).resolve().parents[1] / "docs" / "developer" / "python_api.md"
HEAD = """# The Python module `ajar`

Written by `tools/python_api.py` from the docstrings in `bindings/`; do not edit this page.

"""
# The spelling of types in signatures depends on the version of pybind11, so that signatures show names and defaults only.
SHORT_RETURNS = {"None", "int", "bool", "str", "float", "tuple", "list", "object"}


class MissingDocstring(Exception):
    pass


def split_top(text: str, separator: str = ",") -> list[str]:
    """Parts of `text` between separators outside of brackets and quotes."""
    parts, depth, quote, start = [], 0, "", 0
    for i, c in enumerate(text):
        if quote:
            quote = "" if c == quote else quote
        elif c in "'\"":
            quote = c
        elif c in "([{<":
            depth += 1
        elif c in ")]}>" and text[i - 1] != "-":
            depth -= 1
        elif c == separator and depth == 0:
            parts.append(text[start:i].strip())
            start = i + 1
    return [*parts, text[start:].strip()] if text[start:].strip() else parts


def argument(text: str) -> str:
    """`name: Type = default` without the type."""
    name = split_top(text, ":")[0].strip()
    default = split_top(text, "=")[1:]
    if not default:
        return name
    value = "=".join(default).strip()
    if value.startswith("<") and ":" in value:   # an enumerator: <Domain.Corner: 1>
        value = value[1:].split(":")[0].rpartition("ajar.")[2]
    elif value.startswith("<"):                  # an object of a class: its default
        value = "default"
    try:                                         # floats in their shortest form
        value = f"{float(value):.6g}"
    except ValueError:
        pass
    return f"{name}={value}"


def signature_and_text(item, name: str) -> tuple[str, str]:
    """The signature in a docstring of pybind11, without types, and the text after it."""
    first, _, text = (item.__doc__ or "").partition("\n")
    text = " ".join(text.split())
    if not text:
        raise MissingDocstring(name)
    opening = first.index("(")
    inside, _, returns = first[opening + 1:].rpartition(") -> ")
    arguments = [argument(part) for part in split_top(inside) if not part.startswith("self:")]
    arrow = f" -> {returns}" if returns in SHORT_RETURNS - {"None"} else ""
    return f"{first[:opening]}({', '.join(arguments)}){arrow}", text


def text_of(item, name: str) -> str:
    text = " ".join((item.__doc__ or "").split())
    if not text:
        raise MissingDocstring(name)
    return text


def is_enum(kind: type) -> bool:
    return hasattr(kind, "__members__") and hasattr(kind, "__entries")


def enum_lines(kind: type, name: str) -> list[str]:
    lines = []
    for member, (_, text) in getattr(kind, "__entries").items():
        if not text:
            raise MissingDocstring(f"{name}.{member}")
        lines.append(f"* `{member}`: {text}")
    return [(kind.__doc__ or "").partition("\n")[0], "", *lines, ""]


def class_lines(kind: type, name: str) -> list[str]:
    lines, properties, methods, inner = [text_of(kind, name), ""], [], [], []
    for key, item in vars(kind).items():
        full = f"{name}.{key}"
        if isinstance(item, property):
            properties.append(f"* `{key}`{' (read-only)' if item.fset is None else ''}: {text_of(item, full)}")
        elif inspect.isclass(item):
            inner += [f"### {full}", "", *(enum_lines if is_enum(item) else class_lines)(item, full)]
        elif key == "__init__" and (item.__doc__ or "").startswith("__init__(self"):
            signature, text = signature_and_text(item, full)
            methods.append(f"* `{signature.replace('__init__', name)}`: {text}")
        elif not key.startswith("_") and callable(item):
            signature, text = signature_and_text(item, full)
            methods.append(f"* `{signature}`: {text}")
    for part in (methods, properties):
        lines += [*part, ""] if part else []
    return [*lines, *inner]


def page(module) -> str:
    """The whole page for a module `ajar`."""
    functions: list[str] = []
    enums: list[tuple[str, type]] = []
    classes: list[tuple[str, type]] = []
    errors: list[str] = []
    for name, item in sorted(vars(module._ajar).items()):
        if name.startswith("_"):
            continue
        if inspect.isclass(item) and issubclass(item, Exception):
            errors.append(f"* `{name}` (a {item.__bases__[0].__name__}): {text_of(item, name)}")
        elif inspect.isclass(item):
            (enums if is_enum(item) else classes).append((name, item))
        elif callable(item):
            signature, text = signature_and_text(item, name)
            functions.append(f"* `{signature}`: {text}")
    introduction, _, example = module.__doc__.strip().partition("\n\n")
    lines = [introduction, "", "```python", *inspect.cleandoc("\n" + example).split("\n"), "```", "", *inspect.cleandoc(module._ajar.__doc__).partition("\n\n")[2].split("\n"), "",
             "## Functions", "", *functions, "", "## Errors", "", *errors, "", "## Classes", ""]
    for name, item in classes:
        lines += [f"### {name}", "", *class_lines(item, name)]
    lines += ["## Enumerations", ""]
    for name, item in enums:
        lines += [f"### {name}", "", *enum_lines(item, name)]
    return HEAD + "\n".join(lines).rstrip() + "\n"


def main() -> None:
    import ajar
    try:
        PAGE.write_text(page(ajar))
    except MissingDocstring as missing:
        sys.exit(f"{missing} has no docstring")


if __name__ == "__main__":
    main()
