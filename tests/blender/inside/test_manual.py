"""Every panel, setting and operator has a link to an existing place in the manual."""

from __future__ import annotations

import sys
import types
import urllib.parse
from html.parser import HTMLParser
from pathlib import Path

import bpy
import pytest
from ajar_render import documentation, ui

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tools" / "manual"))
import settings  # noqa: E402


class Page(HTMLParser):
    """The anchors and links of a page."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.file, self.anchors, self.links = file, [], []
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        values = dict(attributes)
        if "id" in values:
            self.anchors.append(values["id"])
        self.links += [values[name] for name in ("href", "src") if name in values]


class Layout:
    """Records the buttons that are drawn into it."""

    def __init__(self) -> None:
        self.buttons: list[types.SimpleNamespace] = []

    def separator(self) -> None:
        pass

    def operator(self, name: str, **_) -> types.SimpleNamespace:
        self.buttons.append(types.SimpleNamespace(operator=name))
        return self.buttons[-1]


@pytest.fixture(scope="module")
def pages() -> dict[Path, Page]:
    found = {file.resolve(): Page(file) for file in documentation.FOLDER.rglob("*.html")}
    assert len(found) > 8
    return found


def is_there(url: str, pages: dict[Path, Page]) -> bool:
    """Whether a file:// address is that of a file of the manual and of an anchor in it."""
    parts = urllib.parse.urlsplit(url)
    assert parts.scheme == "file"
    file = Path(urllib.parse.unquote(parts.path)).resolve()
    if file not in pages:
        return not parts.fragment and file.is_file() and file.is_relative_to(documentation.FOLDER.resolve())
    return not parts.fragment or parts.fragment in pages[file].anchors


def blenders_answer(rna_id: str) -> str | None:
    """The address that Online Manual opens."""
    operator = bpy.types.WM_OT_doc_view_manual
    for prefix, pairs in bpy.utils.manual_map():
        found = operator._find_reference(rna_id, pairs, verbose=False)
        if found is not None:
            return prefix + found
    return None


def test_every_setting_and_operator_has_its_own_anchor(pages):
    ids = [*documentation.ids_of_properties(), *documentation.ids_of_operators()]
    assert len(ids) > 100
    for rna_id in ids:
        url = blenders_answer(rna_id)
        assert url is not None and url.startswith(documentation.FOLDER.as_uri()), rna_id
        assert is_there(url, pages), f"{rna_id} leads to {url}"
        assert url.partition("#")[2] == rna_id.lower().replace(".", "-").replace("light_path", "light_hint"), rna_id


def test_no_registered_setting_is_left_out():
    """Compares with Blender's own lists of types, not with those of the add-on."""
    groups = [group for group in bpy.types.PropertyGroup.__subclasses__() if group.__name__.startswith("Ajar")]
    wanted = {f"bpy.types.{group.__name__}.{prop.identifier}" for group in groups for prop in group.bl_rna.properties if prop.identifier not in ("rna_type", "name")}
    assert set(documentation.ids_of_properties()) == wanted
    assert {f"bpy.ops.ajar.{name}" for name in dir(bpy.ops.ajar)} == set(documentation.ids_of_operators())


def test_a_setting_that_does_not_exist_has_no_address(pages):
    assert blenders_answer("bpy.types.AjarSceneSettings.nothing") is None
    assert not is_there(documentation.url_of("settings.html#nothing"), pages)
    assert not is_there(documentation.url_of("nothing.html"), pages)


def test_blender_finds_the_id_of_a_setting_and_of_an_operator():
    """The identifiers have the form that buttons use."""
    from bl_operators.wm import _wm_doc_get_id

    assert _wm_doc_get_id("AjarSceneSettings.samples", do_url=False) in documentation.ids_of_properties()
    assert _wm_doc_get_id("ajar.check_scene", do_url=False) in documentation.ids_of_operators()
    assert _wm_doc_get_id("AJAR_OT_suggest_light_hints.count", do_url=False) in documentation.ids_of_operators()


def test_every_panel_has_a_button_with_its_anchor(pages):
    with_title = [panel for panel in ui.CLASSES if issubclass(panel, bpy.types.Panel) and panel.bl_label]
    assert len(with_title) > 40
    for panel in with_title:
        assert hasattr(panel, "draw_header_preset"), panel.__name__
        layout = Layout()
        documentation.draw_button(layout, panel)
        assert layout.buttons[0].operator == "ajar.open_manual" and "#" in layout.buttons[0].page
        assert is_there(documentation.url_of(layout.buttons[0].page), pages), panel.__name__


def test_the_help_menu_opens_the_manual():
    menu = types.SimpleNamespace(layout=Layout())
    documentation._draw_in_help_menu(menu, bpy.context)
    assert [button.operator for button in menu.layout.buttons] == ["ajar.open_manual"]


def test_every_link_and_picture_of_the_pages_exists(pages):
    for file, page in pages.items():
        assert len(page.anchors) == len(set(page.anchors)), f"{file.name} has an anchor twice"
        for link in page.links:
            assert is_there(urllib.parse.urljoin(file.as_uri(), link), pages), f"{file.name} links to {link}"


def test_the_manual_opens_in_the_browser(monkeypatch):
    opened = []
    monkeypatch.setattr(documentation.webbrowser, "open", opened.append)
    assert bpy.ops.ajar.open_manual() == {"FINISHED"}
    assert bpy.ops.ajar.open_manual(page="settings.html#ajar_render_pt_sampling") == {"FINISHED"}
    assert bpy.ops.wm.doc_view_manual(doc_id="AjarSceneSettings.samples") == {"FINISHED"}
    assert opened == [documentation.url_of(page) for page in ("index.html", "settings.html#ajar_render_pt_sampling", "settings.html#bpy-types-ajarscenesettings-samples")]


def test_a_missing_page_is_reported_by_name():
    with pytest.raises(RuntimeError, match="nowhere.html"):
        bpy.ops.ajar.open_manual(page="nowhere.html")


def test_the_page_of_settings_is_up_to_date():
    """`make manual` writes it with tools/manual/settings.py."""
    assert (ROOT / "docs" / "manual" / "settings.md").read_text(encoding="utf-8") == settings.page()
