#!/usr/bin/python3
"""make extension: builds out/ajar-<version>-linux-x64.zip for Blender 4.2 and newer, and the legacy add-on for 3.4 to 4.1.

Both contain the add-on with its manual, the compiled module for each Python of Blender and each level of x86-64, and all libraries that it needs.
Their installation downloads nothing.

    tools/extension/build.py [--python 3.11 ...] [--level x86-64-v3 ...]    a part of it, for tests
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

import dependencies
import isolate

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools" / "manual"))
import pages  # noqa: E402

WORK = ROOT / "build" / "extension"
MANIFEST = ROOT / "python_addon" / "blender_manifest.toml"
LEVELS = ("x86-64-v2", "x86-64-v3")
# Official Blender: 3.10 up to 4.0, 3.11 up to 5.0, 3.13 since 5.1. Debian's: 3.13 (4.3.2), 3.14 (5.2).
PYTHONS = ("3.10", "3.11", "3.13", "3.14")
PYTHONS_OF_LEGACY = ("3.10", "3.11", "3.13")
PYTHONS_OF_EXTENSION = ("3.11", "3.13", "3.14")
PYTHONS_OF_SID = ("3.14",)
REQUIRED = ("3.11", "3.13")
ADDON = "ajar_render"
EXIT_UNREACHABLE = 3


@dataclass(frozen=True)
class Python:
    version: str
    include: Path

    @property
    def suffix(self) -> str:
        return f".cpython-{self.version.replace('.', '')}-x86_64-linux-gnu.so"


def find_python(version: str, prefix: Path, named: dict[str, str]) -> Python | None:
    """Find the headers: those of the command line, of the prefix, of the system, of pyenv, or of Debian sid."""
    if version in named:
        return Python(version, Path(named[version]))
    bundled = prefix / f"python{version}" / "include"
    if bundled.is_dir():
        return Python(version, bundled)
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    for include in (Path("/usr/include") / f"python{version}", *sorted(pyenv.glob(f"{version}.*/include/python{version}"))):
        if (include / "Python.h").is_file():
            return Python(version, include)
    of_sid = dependencies.sid_headers(version, WORK / "sid") if version in PYTHONS_OF_SID else None
    return Python(version, of_sid) if of_sid else None


def version() -> str:
    found = re.search(r'^version = "(.*)"', MANIFEST.read_text(), re.M)
    if found is None:
        raise ValueError(f"{MANIFEST} has no version")
    return found[1]


def compile_modules(level: str, pythons: list[Python], prefix: Path) -> Path:
    """Compile the modules of one level and return their folder."""
    build = WORK / level
    build.mkdir(parents=True, exist_ok=True)
    configure = ["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DAJAR_TESTS=OFF",
                 f"-DAJAR_ARCH={level}", f"-DAJAR_BUNDLE={prefix}",
                 f"-DAJAR_PYTHON_INCLUDE={';'.join(str(python.include) for python in pythons)}",
                 f"-DAJAR_PYTHON_SUFFIX={';'.join(python.suffix for python in pythons)}"]
    for command in (configure, ["cmake", "--build", build, "--target", "ajar_module"]):
        with open(build / "build.log", "w") as log:
            if subprocess.run(list(map(str, command)), stdout=log, stderr=subprocess.STDOUT, check=False).returncode != 0:
                raise SystemExit((build / "build.log").read_text()[-4000:])
    return build / "python" / "ajar"


def make_package(levels: list[str], pythons: list[Python], prefix: Path) -> Path:
    """Make the package `ajar` as in the zip: ajar/<level>/_ajar.*.so, and their libraries in ajar/lib."""
    package = WORK / "package" / "ajar"
    shutil.rmtree(package, ignore_errors=True)
    shutil.copytree(ROOT / "bindings" / "ajar", package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(prefix / "licenses", package / "licenses")
    (package / "lib").mkdir()
    originals = sorted((prefix / "lib").glob("*.so*"))
    renames = WORK / "renames.txt"
    isolate.write_renames(originals, renames)
    patchelf = prefix / "bin" / "patchelf"
    for library in originals:
        soname = isolate.soname_for(library.name)
        if soname is None:
            raise ValueError(f"{library} is not one of the libraries of the extension")
        ours = package / "lib" / soname
        subprocess.run(["strip", "--strip-unneeded", "-o", ours, library], check=True)
        isolate.isolate(patchelf, ours, renames, "$ORIGIN")
    for level in levels:
        modules = compile_modules(level, pythons, prefix)
        (package / level).mkdir()
        for python in pythons:
            module = package / level / f"_ajar{python.suffix}"
            shutil.copyfile(modules / module.name, module)
            subprocess.run(["strip", "--strip-unneeded", module], check=True)
            isolate.isolate(patchelf, module, renames, "$ORIGIN/../lib")
    return package


def pack(path: Path, package: Path, pythons: tuple[str, ...], top: str, manifest: str | None = None) -> None:
    """Write one zip: the add-on below the folder `top`, with the modules of these Pythons, or of all if none is named; and a manifest instead of the add-on's."""
    suffixes = tuple(Python(version, Path()).suffix for version in pythons)
    manual = WORK / "manual"
    pages.write_pages(manual)
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for folder, below in ((ROOT / "python_addon", ""), (package, "ajar/"), (manual, "manual/")):
            for file in sorted(folder.rglob("*")):
                if not file.is_file() or "__pycache__" in file.parts or (suffixes and file.name.startswith("_ajar.") and not file.name.endswith(suffixes)):
                    continue
                name = f"{top}{below}{file.relative_to(folder)}"
                if manifest and file == MANIFEST:
                    archive.writestr(name, manifest)
                else:
                    archive.write(file, name)
        archive.write(ROOT / "LICENSE", f"{top}LICENSE")
    print(f"{os.path.relpath(path)}: {path.stat().st_size / 2**20:.1f} MB")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", nargs="+", choices=PYTHONS, default=PYTHONS)
    parser.add_argument("--level", nargs="+", choices=LEVELS, default=LEVELS)
    parser.add_argument("--out", type=Path, default=ROOT / "out")
    parser.add_argument("--headers", nargs="+", default=[], metavar="3.14=FOLDER", help="where Python.h of a version lies")
    options = parser.parse_args()
    named = dict(item.split("=", 1) for item in options.headers)

    try:
        prefix = dependencies.prepare(WORK)
    except dependencies.Unreachable as error:
        print(f"A download failed:\n{error}", file=sys.stderr)
        sys.exit(EXIT_UNREACHABLE)
    found = {version: find_python(version, prefix, named) for version in options.python}
    for name, python in found.items():
        if python is None:
            message = f"no headers of Python {name} (looked in /usr/include, pyenv and, for 3.14, Debian sid)"
            if name in REQUIRED:
                raise SystemExit(f"There are {message}.")
            print(f"left out: {message}", file=sys.stderr)
    pythons = [python for python in found.values() if python]
    package = make_package(list(options.level), pythons, prefix)
    pack(options.out / f"ajar-{version()}-linux-x64.zip", package, PYTHONS_OF_EXTENSION, "")
    pack(options.out / f"ajar-{version()}-legacy-linux-x64.zip", package, PYTHONS_OF_LEGACY, f"{ADDON}/")


if __name__ == "__main__":
    main()
