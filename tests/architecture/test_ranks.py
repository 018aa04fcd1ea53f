"""The house keeps one direction of dependence: a file includes only its own room, its peers, and lower rooms."""
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RANKS = {"math": 0, "sampling": 1, "scene": 2, "shading": 2, "lights": 2, "film": 3, "transport": 4,
         "integrators": 5, "render": 6}
SOURCES = [p for p in (ROOT / "core").rglob("*") if p.suffix in {".h", ".cpp"}]


def includes(path: Path) -> list[str]:
    return re.findall(r'^\s*#include\s+[<"]([^">]+)[">]', path.read_text(), re.M)


def test_core_includes_only_lower_rooms():
    wrong = []
    for path in SOURCES:
        rank = RANKS[path.relative_to(ROOT / "core").parts[0]]
        for include in includes(path):
            room = include.split("/")[0]
            if room in RANKS and RANKS[room] > rank:
                wrong.append(f"{path.relative_to(ROOT)} includes {include}")
    assert len(SOURCES) > 20
    assert not wrong, wrong


def test_each_library_has_one_door():
    doors = {"embree": {"core/scene/embree.h"}, "OpenImageIO": {"core/shading/texture.cpp", "core/film/image_io.cpp"},
             "pybind11": set(), "Python.h": set()}
    for path in SOURCES:
        name = str(path.relative_to(ROOT))
        for include in includes(path):
            for library, allowed in doors.items():
                if include.startswith(library):
                    assert name in allowed, f"{name} includes {include}"


def test_core_never_prints_and_never_knows_blender():
    for path in SOURCES:
        text = path.read_text()
        assert not re.search(r"std::cout|\bprintf\(|\bputs\(", text), f"{path} prints"
        assert "bpy" not in text, f"{path} mentions bpy"


def test_bpy_is_imported_only_by_the_addon_and_scripts_that_run_inside_blender():
    allowed = ("python_addon/", "tests/blender/", "tests/render/", "tests/compatibility/inside.py", "test_scenes/", "benchmarks/", "tools/",
               "tests/core/make_node_values.py")
    for path in ROOT.rglob("*.py"):
        name = str(path.relative_to(ROOT))
        if name.startswith(("build", ".")) or name.startswith(allowed):
            continue
        assert not re.search(r"^\s*(import|from)\s+bpy\b", path.read_text(), re.M), name
