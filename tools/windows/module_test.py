#!/usr/bin/python3
"""Runs the module for Windows in official Python under Wine: a picture by the module of the zip in Python 3.11 and 3.13, and tests/bindings in 3.11.

    build/windows/python3.*/python.exe    starts the DLL of Python; its library Lib is that of the source of Python
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import libraries
from libraries import ROOT, WORK, dependencies

TREE = WORK / "ajar"

LAUNCHER = """#include <wchar.h>
__declspec(dllimport) int Py_Main(int, wchar_t **);
int wmain(int argc, wchar_t **argv) { return Py_Main(argc, argv); }
"""
CHECK = """import ajar, sys
d = ajar.SceneDescription()
d.world.color = (0.5, 0.5, 0.5)
d.camera.present = True
d.settings.width = d.settings.height = 8
d.settings.region = (0, 0, 8, 8)
d.settings.samples, d.settings.integrator = 4, "path"
s = ajar.Session()
s.start(d)
while not s.wait(0.1): pass
assert not s.take_error()
print("Python", sys.version.split()[0], "rendered", s.progress().samples, "samples with", ajar.library_versions())
"""


def prepare(version: str) -> Path:
    """Make the folder of one Python and return it."""
    folder = WORK / f"python{version}"
    if (folder / "python.exe").is_file():
        return folder
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "wheels").mkdir(parents=True)
    (folder / "site").mkdir()
    dependencies.run([*dependencies.pip_of(WORK / "venv"), "download", "--require-hashes", "--no-deps", "--only-binary=:all:", "--platform=win_amd64",
                      f"--python-version={version}", "-d", folder / "wheels", "-r", libraries.HERE / f"python{version.replace('.', '')}.lock"])
    for wheel in (folder / "wheels").glob("*.whl"):
        with zipfile.ZipFile(wheel) as archive:
            if wheel.name.startswith("panda3d-"):
                for name in archive.namelist():
                    if name.startswith("deploy_libs/") and "t-win_amd64" not in name:      # not those of the Python without a lock
                        (folder / Path(name).name).write_bytes(archive.read(name))
            else:
                archive.extractall(folder / "site")
    (folder / "Lib").symlink_to(next((WORK / "source" / f"python{version}").iterdir()) / "Lib")
    source = folder / "launcher.c"
    source.write_text(LAUNCHER)
    subprocess.run(["x86_64-w64-mingw32-gcc-posix", "-municode", source, libraries.PREFIX / f"python{version}" / "python.a", "-static", "-o", folder / "python.exe"], check=True)
    return folder


def run(version: str, arguments: list[str], package: Path = TREE / "python") -> int:
    """Run Python under Wine, which imports Ajar from the folder `package`. Its standard streams must be pipes there."""
    folder = prepare(version)
    paths = [package, folder / "site"]
    environment = {**os.environ, "PYTHONPATH": ";".join(f"Z:{path}" for path in paths), "PYTHONDONTWRITEBYTECODE": "1", "AJAR_BUILD": f"Z:{TREE}",
                   "AJAR_DENOISER": f"Z:{libraries.PREFIX / 'oidn' / 'OpenImageDenoise.dll'}"}
    command = [ROOT / "tools" / "windows" / "wine.sh", folder / "python.exe", "-S", *arguments]
    process = subprocess.Popen(list(map(str, command)), env=environment, cwd=ROOT, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    with process:
        if process.stdin is not None:
            process.stdin.close()
        for line in process.stdout or ():
            print(line, end="", flush=True)
    return process.returncode


def main() -> None:
    if len(sys.argv) > 2:                       # a version and the arguments of Python
        sys.exit(run(sys.argv[1], sys.argv[2:]))
    library = TREE / "python" / "ajar" / "lib"
    library.unlink(missing_ok=True)
    library.symlink_to(libraries.PREFIX / "bin")
    unpacked = WORK / "unpacked"
    shutil.rmtree(unpacked, ignore_errors=True)
    with zipfile.ZipFile(max((ROOT / "out").glob("ajar-*-windows-x64-untested.zip"), key=os.path.getmtime)) as archive:
        archive.extractall(unpacked)
    codes = [run(version, ["-c", CHECK], unpacked) for version in libraries.PYTHONS]
    codes.append(run("3.11", ["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/bindings"]))
    if any(codes):
        raise SystemExit(f"exit codes {codes}")


if __name__ == "__main__":
    main()
