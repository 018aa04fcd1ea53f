#!/usr/bin/python3
"""Builds out/ajar-<version>-windows-x64-untested.zip, an extension for official Blender 4.2 and newer on Windows. Nobody has run it in Blender yet.

It contains the modules for processors with AVX2 and the DLLs of Embree. Open Image Denoise is Blender's own.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import libraries

sys.path.insert(0, str(libraries.ROOT / "tools" / "extension"))
import build

LEVEL = "x86-64-v3"
TREE = libraries.WORK / "ajar"
LICENSES = ("LICENSE*", "COPYING*", "THIRD-PARTY*")
OF_COMPILER = Path("/usr/share/doc/mingw-w64-common/copyright")   # the runtime that is linked into the modules


def suffix(version: str) -> str:
    return f".cp{version.replace('.', '')}-win_amd64.pyd"


def compile_modules() -> Path:
    """Compile the modules for all Pythons and return their folder."""
    includes = ";".join(str(libraries.PREFIX / f"python{version}" / "include") for version in libraries.PYTHONS)
    configure = ["cmake", TREE, "-DAJAR_PYTHON=ON", f"-DAJAR_PYTHON_INCLUDE={includes}", f"-DAJAR_PYTHON_SUFFIX={';'.join(map(suffix, libraries.PYTHONS))}"]
    log = TREE / "module.log"
    log.unlink(missing_ok=True)
    libraries.run(configure, log)
    libraries.run(["nice", "-n", "5", "ninja", "-C", TREE, f"-j{libraries.JOBS}", "ajar_module"], log)
    return TREE / "python" / "ajar"


def take_licenses(target: Path) -> None:
    """Copy the licence of every library that is part of the modules."""
    shutil.copytree(libraries.PREFIX / "licenses", target)
    shutil.copy2(OF_COMPILER, target / "mingw-w64.txt")
    for library in libraries.LIBRARIES:
        if library.name in ("googletest", "cli11"):
            continue
        found = [path for pattern in LICENSES for path in sorted((libraries.WORK / "source" / library.name).glob(f"**/{pattern}")) if path.is_file()]
        if not found:
            raise SystemExit(f"{library.name} has no file with its licence")
        for path in found[:1] + [path for path in found if path.name.startswith("THIRD-PARTY")]:
            shutil.copy2(path, target / f"{library.name}{'_third_party' if path.name.startswith('THIRD') else ''}.txt")


def main() -> None:
    modules = compile_modules()
    package = libraries.WORK / "package" / "ajar"
    shutil.rmtree(package, ignore_errors=True)
    shutil.copytree(build.ROOT / "bindings" / "ajar", package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(libraries.PREFIX / "bin", package / "lib", ignore=lambda _folder, names: [name for name in names if not name.endswith(".dll")])
    take_licenses(package / "licenses")
    (package / LEVEL).mkdir()
    for version in libraries.PYTHONS:
        module = package / LEVEL / f"_ajar{suffix(version)}"
        subprocess.run(["x86_64-w64-mingw32-strip", "-o", module, modules / module.name], check=True)
    manifest = build.MANIFEST.read_text()
    for old, new in (('platforms = ["linux-x64"]', 'platforms = ["windows-x64"]'), ('tagline = "Path', 'tagline = "Untested on Windows. Path')):
        if old not in manifest:
            raise SystemExit(f"{os.path.relpath(build.MANIFEST)} does not contain {old}")
        manifest = manifest.replace(old, new)
    build.pack(build.ROOT / "out" / f"ajar-{build.version()}-windows-x64-untested.zip", package, (), "", manifest)


if __name__ == "__main__":
    main()
