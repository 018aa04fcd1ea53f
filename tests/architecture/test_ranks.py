"""The folders of the core depend on each other in one direction: a file includes only its own folder and lower folders."""
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# The folders of the core from the lowest to the highest; each has its own rank.
ROOMS = ["platform", "math", "sampling", "description", "geometry", "geometry/subdivision", "shading/models", "shading/bsdf", "shading/media", "shading/images", "shading/functions", "shading/skies", "shading/program", "shading/nodes", "shading", "lights/sources", "lights",
         "film", "denoise", "scene", "scene/ray_nodes", "transport/media", "transport/paths", "transport/guiding", "transport/direct", "transport/direct/estimators", "transport/photons", "transport/bidirectional",
         "transport/hints", "transport/chains/mutations", "transport/chains", "integrators", "choice", "view", "render"]
RANKS = {room: rank for rank, room in enumerate(ROOMS)}
MAX_FILES = 25
MAX_LINES = 500
# The coefficients of the sky model of Hosek and Wilkie: a table of numbers.
DATA = {"core/shading/skies/sky_hosek_data.cpp"}
SOURCES = [p for p in (ROOT / "core").rglob("*") if p.suffix in {".h", ".cpp"}]


def includes(path: Path) -> list[str]:
    return re.findall(r'^\s*#include\s+[<"]([^">]+)[">]', path.read_text(), re.M)


def room_of(path: Path) -> str:
    return str(path.relative_to(ROOT / "core").parent)


def test_core_includes_only_lower_folders():
    wrong = []
    for path in SOURCES:
        for include in includes(path):
            if not (ROOT / "core" / include).is_file():
                continue
            room = str(Path(include).parent)
            if RANKS[room] > RANKS[room_of(path)]:
                wrong.append(f"{path.relative_to(ROOT)} includes {include}")
    assert len(SOURCES) > 200
    assert not wrong, wrong


def test_every_folder_is_listed_and_small():
    rooms = {room_of(path) for path in SOURCES}
    assert rooms == set(ROOMS)
    crowded = {room: count for room in ROOMS if (count := sum(room_of(path) == room for path in SOURCES)) > MAX_FILES}
    assert not crowded, crowded


def test_only_data_is_in_long_files():
    assert {str(path.relative_to(ROOT)) for path in SOURCES if path.read_text().count("\n") > MAX_LINES} == DATA


def test_tests_of_the_core_are_in_the_folders_of_the_core():
    tests = ROOT / "tests" / "core"
    for path in tests.rglob("test_*.cpp"):
        if path.parent != tests:
            assert (ROOT / "core" / path.parent.relative_to(tests)).is_dir(), path


def test_each_library_is_included_in_one_place():
    doors = {"embree": {"core/scene/embree.h"}, "OpenImageIO": {"core/shading/images/image_file.cpp", "core/shading/images/color_spaces.cpp", "core/shading/images/tiled_file.cpp",
                                                                        "core/shading/images/tile_cache.cpp", "core/film/image_io.cpp"},
             "pybind11": set(), "Python.h": set()}
    for path in SOURCES:
        name = str(path.relative_to(ROOT))
        for include in includes(path):
            for library, allowed in doors.items():
                if include.startswith(library):
                    assert name in allowed, f"{name} includes {include}"


def test_core_does_not_print_and_does_not_mention_blender():
    for path in SOURCES:
        text = path.read_text()
        assert not re.search(r"std::cout|\bprintf\(|\bputs\(", text), f"{path} prints"
        assert "bpy" not in text, f"{path} mentions bpy"


def test_bpy_is_imported_only_by_the_addon_and_scripts_that_run_inside_blender():
    allowed = ("python_addon/", "tests/blender/", "tests/render/", "test_scenes/", "benchmarks/", "tools/",
               "tests/core/make_node_values.py")
    for path in ROOT.rglob("*.py"):
        name = str(path.relative_to(ROOT))
        if name.startswith(("build", ".")) or name.startswith(allowed) or re.fullmatch(r"tests/compatibility/(\w+_)?inside\.py", name):
            continue
        assert not re.search(r"^\s*(import|from)\s+bpy\b", path.read_text(), re.M), name


def test_system_headers_are_included_by_the_platform_alone():
    system = re.compile(r"unistd\.h|dlfcn\.h|fcntl\.h|windows\.h|io\.h|psapi\.h|(sys|arpa|netinet|linux)/.*|\w*intrin\.h|arm_neon\.h")
    for path in SOURCES:
        found = [include for include in includes(path) if system.fullmatch(include)]
        assert not found or path.name == "platform.cpp", f"{path} includes {found}"


def test_objects_of_threads_outlive_thread_local_memory():
    """On Windows, thread_local memory is given back before destructors run (platform::of_thread)."""
    plain = re.compile(r"thread_local (\w+\* \w+ = nullptr|(bool|int|uint64_t|float) \w+ = [^;]+);")
    for path in SOURCES:
        if path.name == "platform.cpp":
            continue
        for line in path.read_text().splitlines():
            code = line.partition("//")[0]
            assert "thread_local " not in code or plain.search(code), f"{path}: {line.strip()}"
