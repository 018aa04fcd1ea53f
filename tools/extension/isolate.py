"""Renames the bundled libraries, so that they cannot conflict with those of Blender or of other add-ons.

A new file name is not sufficient: the dynamic linker searches the program first, and official Blender exports Embree, TBB and OpenImageIO. Therefore
every symbol that a bundled library defines is renamed, in the library and in its users. The soname is renamed as well, since the linker identifies
libraries by it.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

PREFIX = "ajar_"
SONAMES = {"libembree4": "libajar_embree4.so", "libtbb": "libajar_tbb.so", "libOpenImageIO_Util": "libajar_OpenImageIO_Util.so",
           "libOpenImageIO": "libajar_OpenImageIO.so", "libOpenImageDenoise": "libajar_OpenImageDenoise.so",
           "libOpenImageDenoise_core": "libajar_OpenImageDenoise_core.so",
           # Open Image Denoise loads this file by its name, and calls it by the name of its function.
           "libOpenImageDenoise_device_cpu": "libOpenImageDenoise_device_cpu.so.2.5.1"}
KEPT = "oidn"   # names that begin with this are looked up at run time


def soname_for(file_name: str) -> str | None:
    """The new name of a bundled library, or None for a library of the system."""
    match = re.match(r"(libembree4|libtbb|libOpenImage(IO|IO_Util|Denoise|Denoise_core|Denoise_device_cpu))\b", file_name)
    return SONAMES[match[1]] if match else None


def exported(library: Path) -> list[str]:
    """Names of the dynamic symbols that a library defines, without versions."""
    lines = subprocess.run(["nm", "-D", "--defined-only", library], text=True, check=True, stdout=subprocess.PIPE).stdout.splitlines()
    return sorted({line.split()[-1].split("@")[0] for line in lines})


def needed(library: Path) -> list[str]:
    text = subprocess.run(["readelf", "-d", library], text=True, check=True, stdout=subprocess.PIPE).stdout
    return re.findall(r"\(NEEDED\).*\[(.*)\]", text)


def write_renames(libraries: list[Path], path: Path) -> None:
    names = sorted({name for library in libraries for name in exported(library) if not name.startswith(KEPT)})
    path.write_text("".join(f"{name} {PREFIX}{name}\n" for name in names))


def isolate(patchelf: Path, library: Path, renames: Path, search: str) -> None:
    """Rename in place the symbols of bundled libraries that `library` defines or needs. It will find these libraries in `search`."""
    arguments = ["--page-size", "4096", "--rename-dynamic-symbols", str(renames)]
    if soname_for(library.name) or library.name in SONAMES.values():
        arguments += ["--set-soname", library.name]
    for name in needed(library):
        soname = soname_for(name)
        if soname:
            arguments += ["--replace-needed", name, soname]
    arguments += ["--force-rpath", "--set-rpath", search]
    subprocess.run([patchelf, *arguments, library], check=True)
