#!/usr/bin/python3
"""Builds the libraries of Ajar for Windows on Debian: static ones by mingw-w64, from sources of Debian, and the DLLs of Embree from PyPI.

    build/windows/prefix/include, lib    what Ajar includes and links
    build/windows/prefix/bin             the DLLs beside a program: Embree 4 and its TBB
    build/windows/prefix/oidn            the DLLs of Open Image Denoise, which is loaded at run time
    build/windows/prefix/python3.*       the headers of Pythons for Windows and their import libraries
    build/windows/prefix/opensubdiv      the part of OpenSubdiv that is compiled with Ajar

*.lock list every file with its sha256. Headers without a library (GLM, nlohmann-json, Boost) are those of the build machine. A library is built once for a version of
this folder; `--again NAME` builds it again.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "tools" / "extension"))
import dependencies  # noqa: E402
import python_headers  # noqa: E402

WORK = ROOT / "build" / "windows"
PREFIX = WORK / "prefix"
JOBS = os.environ.get("AJAR_JOBS", str(os.cpu_count()))
PYTHONS = ("3.11", "3.13")   # of official Blender 4.2 to 5.0, and since 5.1
HEADERS = ("glm", "nlohmann", "boost")
TBB, OUR_TBB = b"tbb12.dll", b"ajtbb.dll"   # equally long: the name is replaced inside Embree's DLL
RENAMED = {"embree4.dll": "ajar_embree4.dll", TBB.decode(): OUR_TBB.decode()}
STATIC = "-DYAML_CPP_STATIC_DEFINE -DXML_STATIC -DOpenColorIO_SKIP_IMPORTS -DOIIO_STATIC_DEFINE"   # the libraries call each other as static ones
EXIT_UNREACHABLE = 3


@dataclass(frozen=True)
class Library:
    """One source archive of sources.lock: how CMake is called, and texts of its files that are replaced."""
    name: str                       # the beginning of the archive's name
    options: tuple[str, ...] = ()
    folder: str = ""                # of CMakeLists.txt in the archive
    project: Path | None = None     # instead of that folder
    replaced: tuple[tuple[str, str, str], ...] = field(default=())


def off(*names: str) -> tuple[str, ...]:
    return tuple(f"-D{name}=OFF" for name in names)


LIBRARIES = (
    # The DLL is left out: its resource file is not in Debian's source.
    Library("zlib", off("ZLIB_BUILD_EXAMPLES"), replaced=(("CMakeLists.txt", "add_library(zlib SHARED", "add_library(zlib STATIC EXCLUDE_FROM_ALL"),
                                                          ("CMakeLists.txt", "install(TARGETS zlib zlibstatic", "install(TARGETS zlibstatic"),
                                                          ("CMakeLists.txt", "\nif(MINGW)\n", "\nif(FALSE)\n"), ("CMakeLists.txt", "endif(MINGW)", "endif()"))),
    Library("libpng1.6", off("PNG_SHARED", "PNG_TESTS", "PNG_EXECUTABLES")),
    Library("libjpeg-turbo", off("ENABLE_SHARED", "WITH_TURBOJPEG")),
    Library("tiff", off("tiff-tools", "tiff-tests", "tiff-contrib", "tiff-docs", "tiff-deprecated", "lzma", "zstd", "webp", "jbig", "lerc", "libdeflate", "cxx")),
    Library("imath", off("BUILD_TESTING", "PYTHON")),
    Library("openexr", off("BUILD_TESTING", "OPENEXR_BUILD_TOOLS", "OPENEXR_INSTALL_TOOLS", "OPENEXR_INSTALL_EXAMPLES", "OPENEXR_BUILD_EXAMPLES")),
    Library("expat", off("EXPAT_BUILD_TESTS", "EXPAT_BUILD_TOOLS", "EXPAT_BUILD_EXAMPLES", "EXPAT_BUILD_DOCS", "EXPAT_SHARED_LIBS"), folder="expat"),
    Library("yaml-cpp", off("YAML_CPP_BUILD_TESTS", "YAML_CPP_BUILD_TOOLS", "YAML_CPP_BUILD_CONTRIB")),
    Library("pystring", project=HERE / "shims" / "pystring"),
    Library("opencolorio", off("OCIO_BUILD_APPS", "OCIO_BUILD_TESTS", "OCIO_BUILD_GPU_TESTS", "OCIO_BUILD_DOCS", "OCIO_BUILD_PYTHON", "OCIO_WARNING_AS_ERROR")
            + ("-DOCIO_INSTALL_EXT_PACKAGES=NONE", f"-Dyaml-cpp_ROOT={PREFIX}")),
    Library("robin-map"),
    Library("fmtlib", off("FMT_TEST", "FMT_DOC")),
    Library("openimageio", off("OIIO_BUILD_TOOLS", "OIIO_BUILD_TESTS", "USE_PYTHON", "USE_QT", "BUILD_DOCS", "INSTALL_DOCS", "INSTALL_FONTS", "STOP_ON_WARNING",
                               "BUILD_MISSING_FMT", "BUILD_MISSING_ROBINMAP", *(f"USE_{name}" for name in (
                                   "FREETYPE", "OPENCV", "TBB", "DCMTK", "FFMPEG", "GIF", "LIBHEIF", "LIBRAW", "OPENJPEG", "OPENVDB", "PTEX", "WEBP", "NUKE")),
                               *(f"ENABLE_{name}" for name in ("FITS", "ICO", "IFF", "RLA", "SOFTIMAGE", "TERM", "ZFILE")))
            + ("-DCMAKE_CXX_STANDARD=17", "-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_UNITY_BUILD_MODE=BATCH", "-DLINKSTATIC=ON", "-DOPENCOLORIO_NO_CONFIG=ON", "-DUSE_STD_FILESYSTEM=ON",
               "-DOIIO_DISABLE_BOOST_STACKTRACE=ON", f"-DBoost_INCLUDE_DIR={PREFIX / 'include'}"),
            replaced=(("src/cmake/externalpackages.cmake", "set (Boost_COMPONENTS thread)", "set (Boost_COMPONENTS)"),)),
    # GCC 12 for Windows fails at the first of these flags; the others need libssp.
    Library("onetbb", off("TBB_TEST", "TBB_STRICT", "TBBMALLOC_BUILD", "TBB_EXAMPLES"),
            replaced=(("cmake/compilers/GNU.cmake", "-fstack-clash-protection", ""), ("cmake/compilers/GNU.cmake", "-fstack-protector-strong", ""),
                      ("cmake/compilers/GNU.cmake", "-D_FORTIFY_SOURCE=2", ""))),
    Library("googletest", off("BUILD_GMOCK")),
    Library("cli11", off("CLI11_BUILD_TESTS", "CLI11_BUILD_EXAMPLES", "CLI11_BUILD_DOCS")),
)


def run(command: list[object], log: Path) -> None:
    with open(log, "a") as out:
        flags = {"CFLAGS": STATIC, "CXXFLAGS": f"{STATIC} -I{HERE / 'shims'}"}
        if subprocess.run(list(map(str, command)), env={**os.environ, **flags}, stdout=out, stderr=subprocess.STDOUT, check=False).returncode != 0:
            raise SystemExit(f"{log.read_text()[-6000:]}\n{' '.join(map(str, command))} failed; see {log}")


def sources() -> dict[str, Path]:
    """Download what is missing. Returns the archives by the beginning of their names."""
    downloads = WORK / "downloads"
    downloads.mkdir(parents=True, exist_ok=True)
    archives = {}
    headers = [line for line in (dependencies.HERE / "debs.lock").read_text().splitlines() if "libembree-dev" in line]
    for line in (HERE / "sources.lock").read_text().splitlines() + headers:
        if not line.startswith("#"):
            sha256, path = line.split()
            archives[path.rsplit("/", 1)[1].split("_")[0]] = dependencies.download_pool_file(sha256, path, downloads)
    wheels = downloads / "wheels"
    dependencies.run([*dependencies.pip_of(WORK / "venv"), "download", "--require-hashes", "--no-deps", "--only-binary=:all:",
                      "--platform=win_amd64", "--python-version=3.11", "-d", wheels, "-r", HERE / "wheels.lock"])
    return archives


def unpack(archive: Path, target: Path) -> Path:
    """Unpack a source archive and return its folder."""
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    with tarfile.open(archive) as members:
        if hasattr(tarfile, "data_filter"):
            members.extractall(target, filter="data")
        else:                                    # Debian 12's Python
            members.extractall(target)
    folders = [path for path in target.iterdir() if path.is_dir()]
    return folders[0] if len(folders) == 1 else target


def build(library: Library, archive: Path) -> None:
    """Configure, compile and install one library."""
    source = unpack(archive, WORK / "source" / library.name)
    for path, old, new in library.replaced:
        text = (source / path).read_text()
        if old not in text:
            raise SystemExit(f"{library.name}: {path} does not contain {old!r}")
        (source / path).write_text(text.replace(old, new))
    tree = WORK / "build" / library.name
    shutil.rmtree(tree, ignore_errors=True)
    tree.mkdir(parents=True)
    log = tree / "build.log"
    run(["cmake", "-S", library.project or source / library.folder, "-B", tree, "-G", "Ninja", f"-DCMAKE_TOOLCHAIN_FILE={ROOT / 'cmake' / 'mingw.cmake'}",
         f"-DAJAR_WINDOWS={PREFIX}", f"-DAJAR_SOURCE={source}", f"-DCMAKE_PREFIX_PATH={PREFIX}", f"-DCMAKE_INSTALL_PREFIX={PREFIX}", "-DCMAKE_INSTALL_LIBDIR:STRING=lib",
         "-DCMAKE_BUILD_TYPE=Release", "-DBUILD_SHARED_LIBS=OFF", *library.options], log)
    run(["nice", "-n", "5", "ninja", "-C", tree, f"-j{JOBS}", "install"], log)


def take_wheels() -> None:
    """The DLLs of the wheels. Embree and its TBB get names of their own, because Blender has DLLs with these names in the process."""
    parts = WORK / "source" / "wheels"
    shutil.rmtree(parts, ignore_errors=True)
    for wheel in (WORK / "downloads" / "wheels").glob("*.whl"):
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(parts / wheel.name.split("-")[0])
    libraries = parts / "embreex" / "embreex.libs"
    for path in libraries.glob("*.dll"):
        content = path.read_bytes()
        if path.name == "embree4.dll":
            if content.count(TBB + b"\0") != 1:
                raise SystemExit(f"{path} does not name {TBB.decode()} once")
            content = content.replace(TBB + b"\0", OUR_TBB + b"\0")
        (PREFIX / "bin" / RENAMED.get(path.name, path.name)).write_bytes(content)
    definitions = parts / "embree4.def"
    names = subprocess.run(["x86_64-w64-mingw32-objdump", "-p", libraries / "embree4.dll"], text=True, stdout=subprocess.PIPE, check=True).stdout
    exported = re.findall(r"^\s*\[ *\d+\] (?:\+base\[ *\d+\]  ?[0-9a-f]+ )?(rtc\w+)$", names, re.M)
    definitions.write_text("\n".join([f"LIBRARY {RENAMED['embree4.dll']}", "EXPORTS", *sorted(set(exported))]))
    subprocess.run(["x86_64-w64-mingw32-dlltool", "-d", definitions, "-l", PREFIX / "lib" / "libajar_embree4.a"], check=True)
    shutil.copytree(parts / "pybind11/pybind11/include/pybind11", PREFIX / "include" / "pybind11", dirs_exist_ok=True)
    for name in ("OpenImageDenoise.dll", "OpenImageDenoise_core.dll", "OpenImageDenoise_device_cpu.dll", "tbb12.dll"):
        (PREFIX / "oidn").mkdir(exist_ok=True)
        shutil.copy2(parts / "pyoidn/pyoidn/oidn/bin" / name, PREFIX / "oidn" / name)


def take_headers(embree: Path) -> None:
    """The headers of Embree from Debian's package, and those of the build machine."""
    parts = WORK / "source" / "embree"
    shutil.rmtree(parts, ignore_errors=True)
    parts.mkdir(parents=True, exist_ok=True)
    subprocess.run(["dpkg-deb", "-x", embree, parts], check=True)
    shutil.copytree(parts / "usr/include/embree4", PREFIX / "include" / "embree4", dirs_exist_ok=True)
    (PREFIX / "licenses").mkdir(exist_ok=True)
    shutil.copy2(parts / "usr/share/doc/libembree-dev/copyright", PREFIX / "licenses" / "Embree.txt")
    for name in HEADERS:
        link = PREFIX / "include" / name
        link.unlink(missing_ok=True)
        link.symlink_to(Path("/usr/include") / name)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--again", nargs="+", default=[], metavar="NAME", choices=[library.name for library in LIBRARIES], help="build these libraries again")
    again = parser.parse_args().again
    try:
        archives = sources()
    except dependencies.Unreachable as error:
        print(f"A download failed:\n{error}", file=sys.stderr)
        sys.exit(EXIT_UNREACHABLE)
    for folder in ("include", "lib", "bin", "state"):
        (PREFIX / folder).mkdir(parents=True, exist_ok=True)
    locks = b"".join(path.read_bytes() for path in (*sorted(HERE.glob("*.lock")), Path(__file__), Path(python_headers.__file__)))
    taken, stamp = hashlib.sha256(locks).hexdigest(), PREFIX / "state" / "headers"
    if not stamp.is_file() or stamp.read_text() != taken:   # new times of headers would let everything be compiled again
        take_headers(archives["libembree-dev"])
        take_wheels()
        dependencies.unpack_opensubdiv(archives["opensubdiv"], PREFIX)
        for version in PYTHONS:
            python_headers.take_python(version, unpack(archives[f"python{version}"], WORK / "source" / f"python{version}"), PREFIX / f"python{version}")
        stamp.write_text(taken)
    for library in LIBRARIES:
        state = hashlib.sha256(repr((library, archives[library.name].name)).encode()).hexdigest()
        stamp = PREFIX / "state" / library.name
        if library.name in again or not stamp.is_file() or stamp.read_text() != state:
            print(f"{library.name} ...", flush=True)
            build(library, archives[library.name])
            stamp.write_text(state)


if __name__ == "__main__":
    main()
