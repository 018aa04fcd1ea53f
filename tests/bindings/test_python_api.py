"""The page of the Python module is the output of tools/python_api.py, and everything that is bound has a docstring."""

from __future__ import annotations

import os
import sys
import types
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(Path(os.environ.get("AJAR_BUILD", ROOT / "build" / "release")) / "python")]
import ajar  # noqa: E402
import python_api  # noqa: E402


def test_page_is_the_output_of_the_script():
    assert python_api.PAGE.read_text() == python_api.page(ajar), "run tools/python_api.py"


def test_page_names_everything_that_is_bound():
    text = python_api.page(ajar)
    for name, item in vars(ajar._ajar).items():
        if name.startswith("_"):
            continue
        assert f"`{name}" in text or f"### {name}\n" in text, name
        if isinstance(item, type):
            section = text.partition(f"### {name}\n")[2].partition("\n### ")[0]
            for member, value in vars(item).items():
                if isinstance(value, property) and not hasattr(item, "__members__"):
                    assert f"* `{member}`" in section, f"{name}.{member}"


def test_error_of_a_missing_docstring_names_the_member():
    class Bare:
        """A class."""
        width = property(lambda self: 1)

    module = types.SimpleNamespace(__doc__="One.\n\n    two", _ajar=types.SimpleNamespace(__doc__="", Bare=Bare))
    with pytest.raises(python_api.MissingDocstring, match="Bare.width"):
        python_api.page(module)


@pytest.mark.parametrize("first, signature", [
    ("f(self: ajar._ajar.A, n: int = 3, x: float = 0.08726649731397629) -> int", "f(n=3, x=0.0872665) -> int"),
    ("f(a: Tuple[int, str] = (1, 'b, c'), *, d: ajar._ajar.Domain = <Domain.Corner: 1>) -> numpy.ndarray[numpy.float32]", "f(a=(1, 'b, c'), *, d=Domain.Corner)"),
    ("f(link: ajar._ajar.NodeLink = <ajar._ajar.NodeLink object at 0x7f0000000000>) -> None", "f(link=default)"),
])
def test_signatures_have_names_and_defaults(first, signature):
    item = types.SimpleNamespace(__doc__=first + "\n\nText.\n")
    assert python_api.signature_and_text(item, "f") == (signature, "Text.")
