#!/usr/bin/python3
"""Writes the manual as HTML for the add-on, from docs/manual/*.md and the pages that these link to.

    tools/manual/pages.py FOLDER

FOLDER gets the layout of docs/: pages of docs/manual at the top, linked pages in their folders. Other links become plain text. A link or a picture
that does not exist is an error.
"""

from __future__ import annotations

import argparse
import html
import os
import re
import shutil
import sys
import xml.etree.ElementTree as etree
from pathlib import Path

import markdown
from markdown.extensions import Extension
from markdown.treeprocessors import Treeprocessor

DOCS = Path(__file__).resolve().parents[2] / "docs"
MANUAL = DOCS / "manual"
FIRST = "index"
CONTENTS_FROM = 4    # minimum number of headings of a page with a table of contents
STYLE = """
body { margin: 0 auto; padding: 1.5em; max-width: 60em; font: 16px/1.5 sans-serif; color: #222; background: #fff; }
nav { font-size: 0.9em; border-bottom: 1px solid #ccc; padding-bottom: 0.5em; }
nav a { margin-right: 1em; }
.contents { border: 0; background: #f4f4f4; padding: 0.5em 1em; columns: 3 14em; }
.contents ul { margin: 0; padding-left: 1.2em; }
table { border-collapse: collapse; }
th, td { border: 1px solid #ccc; padding: 0.3em 0.6em; text-align: left; vertical-align: top; }
pre, code { background: #f4f4f4; }
pre { padding: 0.7em; overflow-x: auto; }
img { max-width: 100%; }
h1, h2, h3 { line-height: 1.2; }
:target, a:target + strong, p:has(> a:target) { background: #ffe9b0; }
@media (prefers-color-scheme: dark) {
  body { color: #ddd; background: #1d1d1d; }
  a { color: #8ab4f8; }
  pre, code, .contents { background: #2b2b2b; }
  th, td, nav { border-color: #555; }
  :target, a:target + strong, p:has(> a:target) { background: #5a4a1a; }
}
"""


class BrokenLink(Exception):
    """A page links to a file that does not exist."""


class Rewrite(Treeprocessor):
    """Rewrites the links of one page for the folder of HTML, and collects the pictures."""

    def __init__(self, page: Path, pages: set[Path], pictures: set[Path]) -> None:
        super().__init__()
        self.page, self.pages, self.pictures = page, pages, pictures

    def run(self, root: etree.Element) -> None:
        for link in root.iter("a"):
            self._link(link)
        for picture in root.iter("img"):
            target, _ = resolve(self.page, picture.get("src", ""))
            self.pictures.add(target)
            picture.set("src", between(self.page, target))

    def _link(self, link: etree.Element) -> None:
        address = link.get("href", "")
        if not address or is_elsewhere(address):
            return
        target, anchor = resolve(self.page, address)
        if target in self.pages:
            link.set("href", between(self.page, target) + anchor)
        else:   # plain text
            link.tag = "span"
            del link.attrib["href"]


class RewriteLinks(Extension):
    def __init__(self, rewrite: Rewrite) -> None:
        super().__init__()
        self.rewrite = rewrite

    def extendMarkdown(self, md: markdown.Markdown) -> None:
        md.treeprocessors.register(self.rewrite, "rewrite", 0)   # after the links were created


def is_elsewhere(address: str) -> bool:
    return re.match(r"[a-z]+:", address) is not None


def resolve(page: Path, address: str) -> tuple[Path, str]:
    """The file that a page links to, and the anchor with its #."""
    path, mark, anchor = address.partition("#")
    target = (page.parent / path).resolve() if path else page
    if not target.exists():
        raise BrokenLink(f"{page.relative_to(DOCS)} links to {address}, which does not exist")
    return target, mark + anchor


def output_of(source: Path) -> Path:
    """The output path of a page or a picture, relative to the folder of HTML."""
    place = source.relative_to(MANUAL if source.is_relative_to(MANUAL) else DOCS)
    return place.with_suffix(".html") if source.suffix == ".md" else place


def between(page: Path, target: Path) -> str:
    return "" if target == page else os.path.relpath(output_of(target), output_of(page).parent)


def linked_pages(page: Path) -> set[Path]:
    """Pages of docs/ that a page links to."""
    addresses = re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8"))
    targets = {resolve(page, address)[0] for address in addresses if not is_elsewhere(address)}
    return {target for target in targets if target.suffix == ".md" and target.is_relative_to(DOCS)}


def title_of(page: Path) -> str:
    found = re.search(r"^# (.+)$", page.read_text(encoding="utf-8"), re.M)
    if found is None:
        raise ValueError(f"{page} has no title")
    return found[1]


def to_html(page: Path, pages: set[Path], pictures: set[Path], menu: list[Path]) -> str:
    converter = markdown.Markdown(extensions=["tables", "toc", "sane_lists", RewriteLinks(Rewrite(page, pages, pictures))], extension_configs={"toc": {"toc_depth": "2-3"}})
    body = converter.convert(page.read_text(encoding="utf-8"))
    contents = ""
    if body.count("<h2") + body.count("<h3") >= CONTENTS_FROM:
        before, heading_end, rest = body.partition("</h1>")
        contents = converter.toc.replace('class="toc"', 'class="contents"')
        body = f"{before}{heading_end}\n{contents}{rest}"
    links = "".join(f'<a href="{between(page, item) or output_of(item).name}">{html.escape(title_of(item))}</a>' for item in menu)
    style = os.path.relpath("style.css", output_of(page).parent)
    return (f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<meta name="viewport" content="width=device-width">\n<title>{html.escape(title_of(page))}</title>\n'
            f'<link rel="stylesheet" href="{style}">\n</head>\n<body>\n<nav>{links}</nav>\n{body}\n</body>\n</html>\n')


def write_pages(folder: Path) -> None:
    """Write all pages and replace the old content of the folder."""
    own = sorted(MANUAL.glob("*.md"), key=lambda page: (page.stem != FIRST, page.stem))
    pages = set(own).union(*map(linked_pages, own))
    pictures: set[Path] = set()
    shutil.rmtree(folder, ignore_errors=True)
    for page in sorted(pages):
        target = folder / output_of(page)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(to_html(page, pages, pictures, own), encoding="utf-8")
    for picture in sorted(pictures):
        target = folder / output_of(picture)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(picture, target)
    (folder / "style.css").write_text(STYLE.lstrip(), encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    try:
        write_pages(parser.parse_args().folder)
    except BrokenLink as error:
        sys.exit(f"{Path(__file__).name}: {error}")


if __name__ == "__main__":
    main()
