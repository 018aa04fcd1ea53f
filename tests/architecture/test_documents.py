"""The files, functions and link targets that the documents name exist."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import unquote

import pytest

ROOT = Path(__file__).resolve().parents[2]
DEVELOPER = sorted((ROOT / "docs" / "developer").glob("*.md"))
FOLDERS = ("core", "bindings", "python_addon", "tests", "benchmarks", "tools", "test_scenes", "docs", "cmake", ".ci")
PAGES = sorted(path for path in [*ROOT.glob("*.md"), *(page for folder in FOLDERS for page in (ROOT / folder).rglob("*.md"))])
CODE = re.compile(r"\.(h|cpp|py)$")
LINK = re.compile(r"!?\[(?:[^\]\[]|\[[^\]]*\])*\]\(([^()\s]*(?:\([^()\s]*\)[^()\s]*)*)\)")


def files_by_name() -> dict[str, list[Path]]:
    found: dict[str, list[Path]] = {}
    for folder in FOLDERS:
        for path in (ROOT / folder).rglob("*"):
            if CODE.search(path.name) and path.is_file():
                found.setdefault(path.name, []).append(path)
    return found


FILES = files_by_name()


def without_blocks(text: str) -> str:
    return re.sub(r"^(```|~~~).*?^\1", "", text, flags=re.M | re.S)


def quoted_files(text: str) -> set[str]:
    """Names of source files in back quotes, with or without a folder, without patterns (*) and templates (<...>)."""
    names = set()
    for quoted in re.findall(r"`([^`\n]+)`", without_blocks(text)):
        names |= {word for word in re.findall(r"[\w./*<>-]+", quoted) if CODE.search(word) and not re.search(r"[*<>]", word) and word[0] != "."}
    return names


def named_functions(text: str) -> list[tuple[str, str]]:
    """The pairs (file, name) of thesis_map.md. In a cell of a table, the names after a file belong to it."""
    found = []
    for line in text.splitlines():
        if not line.startswith("|"):
            continue
        file = ""
        for quoted in re.findall(r"`([^`]+)`", line.rstrip("| ").rpartition("|")[2]):
            if CODE.search(quoted):
                file = quoted
            elif file:
                found.append((file, quoted))
    return found


def anchors_of(text: str) -> set[str]:
    """The anchors of headings, by GitHub's rule, and the explicit anchors."""
    anchors: set[str] = set(re.findall(r'<a id="([^"]+)">', text))
    for heading in re.findall(r"^#+ +(.*?) *#*$", without_blocks(text), re.M):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").lower()
        anchor = re.sub(r"[^\w\- ]", "", plain).replace(" ", "-")
        count = 1
        while (numbered := anchor if count == 1 else f"{anchor}-{count - 1}") in anchors:
            count += 1
        anchors.add(numbered)
    return anchors


def faults_of_links(page: Path, text: str) -> list[str]:
    faults = []
    for target in LINK.findall(without_blocks(text)):
        if re.match(r"[a-z][a-z0-9+.-]*:", target):
            continue
        path, _, anchor = unquote(target).partition("#")
        there = (page.parent / path).resolve() if path else page
        if not there.exists():
            faults.append(f"{target}: no such file")
        elif anchor and there.suffix == ".md" and anchor not in anchors_of(text if there == page else there.read_text()):
            faults.append(f"{target}: no such heading")
    return faults


@pytest.mark.parametrize("page", DEVELOPER, ids=lambda page: page.name)
def test_files_that_developer_pages_name_exist(page):
    missing = [name for name in quoted_files(page.read_text()) if not (ROOT / name).is_file() and Path(name).name not in FILES]
    assert not missing, f"{page.name} names {missing}"


def test_functions_of_the_thesis_map_are_in_their_files():
    found = named_functions((ROOT / "docs" / "developer" / "thesis_map.md").read_text())
    assert len(found) > 150
    missing = []
    for file, name in found:
        word = re.compile(rf"\b{re.escape(name.split('::')[-1])}\b")
        if not any(word.search(path.read_text()) for path in FILES.get(file, [])):
            missing.append(f"{file}: {name}")
    assert not missing, missing


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_targets_of_relative_links_exist(page):
    faults = faults_of_links(page, page.read_text())
    assert not faults, f"{page.relative_to(ROOT)}: {faults}"


def test_faults_are_found():
    assert quoted_files("`photon_map.h` and `core/x/never.cpp`, `run a.py --b`, not `x*.cpp`") == {"photon_map.h", "core/x/never.cpp", "a.py"}
    assert named_functions("| 2.1 | by `x.h`: `no` | `a.h`: `f`, `G`; `b.cpp`: `h` |") == [("a.h", "f"), ("a.h", "G"), ("b.cpp", "h")]
    page = ROOT / "README.md"
    text = "# A b: c\n[x](nowhere.md) [y](#a-b-c) [z](#d) ![p](docs/none.jpg) [w](https://example.org) [m](docs/manual/index.md)\n```\n[q](none)\n```\n"
    assert faults_of_links(page, text) == ["nowhere.md: no such file", "#d: no such heading", "docs/none.jpg: no such file"]
    assert anchors_of("## A\n## A\n## `b` (c), d\n") == {"a", "a-1", "b-c-d"}
