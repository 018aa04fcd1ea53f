"""The content of the zip can be loaded together with other libraries, on any system that official Blender supports."""

from __future__ import annotations

import re
import subprocess
import tomllib

import isolate

MAX_MEGABYTES = 92   # 44 of them are the weights of Open Image Denoise, and 17 to 18 the modules of one Python for two levels of x86-64
FOUND_AT_RUN_TIME = {"libajar_OpenImageDenoise.so", "libOpenImageDenoise_device_cpu.so.2.5.1"}
NEWEST_GLIBC = (2, 35)
NEWEST_LIBSTDCXX = (3, 4, 25)   # the version of GCC 8, as on the system for which official Blender is built (VFX platform, glibc 2.28)
SYSTEM = {"libc.so.6", "libm.so.6", "libdl.so.2", "libpthread.so.0", "libgcc_s.so.1", "libstdc++.so.6", "libz.so.1", "ld-linux-x86-64.so.2"}


def libraries(folder):
    found = sorted(folder.rglob("*.so*"))
    assert len(found) >= 5, found
    return found


def newest(library, name: str) -> tuple[int, ...]:
    text = subprocess.run(["objdump", "-T", library], text=True, check=True, stdout=subprocess.PIPE).stdout
    versions = re.findall(rf"\b{name}_([0-9.]+)\b", text)
    return max((tuple(map(int, version.split("."))) for version in versions), default=(0,))


def test_size(zips):
    for path in zips:
        assert path.stat().st_size < MAX_MEGABYTES * 2**20, path


def test_manifest(unpacked):
    manifest = tomllib.loads((unpacked / "blender_manifest.toml").read_text())
    assert manifest["id"] == "ajar_render" and manifest["type"] == "add-on" and manifest["platforms"] == ["linux-x64"]
    assert manifest["blender_version_min"] == "4.2.0"
    assert not {"network"} & set(manifest.get("permissions", {}))
    init = (unpacked / "__init__.py").read_text()
    assert tuple(map(int, manifest["version"].split("."))) == tuple(map(int, re.search(r'"version": \((.*?)\)', init)[1].split(",")))


def test_every_library_is_in_the_zip_or_in_every_system(unpacked):
    inside = {path.name for path in libraries(unpacked)}
    for library in libraries(unpacked):
        assert set(isolate.needed(library)) <= inside | SYSTEM, library


def test_runs_on_older_systems(unpacked):
    for library in libraries(unpacked):
        assert newest(library, "GLIBC") <= NEWEST_GLIBC, library
        assert newest(library, "GLIBCXX") <= NEWEST_LIBSTDCXX, library


def test_no_name_is_shared_with_blender_or_another_add_on(unpacked):
    """Neither sonames nor symbols may be shared, because the linker would merge them."""
    for library in libraries(unpacked):
        text = subprocess.run(["readelf", "-d", library], text=True, check=True, stdout=subprocess.PIPE).stdout
        for name in isolate.needed(library) + re.findall(r"\(SONAME\).*\[(.*)\]", text):
            assert isolate.soname_for(name) in (None, name), (library, name)
        for symbol in isolate.exported(library):
            assert symbol.startswith((isolate.PREFIX, isolate.KEPT, "PyInit__ajar")), (library, symbol)


def test_modules_have_the_instructions_of_their_level(unpacked):
    wide = {}
    for module in unpacked.rglob("_ajar.*.so"):
        code = subprocess.run(["objdump", "-d", "--no-show-raw-insn", module], text=True, check=True, stdout=subprocess.PIPE).stdout
        wide[module] = "%ymm" in code
    assert wide and all(found == (module.parent.name == "x86-64-v3") for module, found in wide.items()), wide


def test_bundled_libraries_are_used_by_the_module(unpacked):
    """The zip has no unused library of a wheel."""
    wanted = {name for library in libraries(unpacked) for name in isolate.needed(library)}
    assert {path.name for path in (unpacked / "ajar" / "lib").iterdir()} <= wanted | FOUND_AT_RUN_TIME
