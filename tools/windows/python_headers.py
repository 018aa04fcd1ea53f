"""The headers of a Python for Windows and the import library of its DLL, from the source of Python: neither needs Windows.

The library lists what the headers declare as part of the DLL. A module that uses something else does not link.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

# PyAPI_FUNC(type) name(...) and PyAPI_DATA(type) name; types can contain brackets of one depth.
DECLARED = re.compile(r"\bPyAPI_(FUNC|DATA)\((?:[^()]|\([^()]*\))*\)\s*(_?Py\w+)")
COMPILER = '#define COMPILER "[gcc]"\n'


def take_python(version: str, source: Path, target: Path) -> None:
    """Write `target`/include and `target`/python.a for one version, from its unpacked source."""
    include = target / "include"
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(source / "Include", include)
    config = next(path for path in (source / "PC" / "pyconfig.h", source / "PC" / "pyconfig.h.in") if path.is_file()).read_text()
    if "__MINGW32__" not in config:          # before 3.13, the header told only Microsoft's compiler that pointers have 64 bits
        config = config.replace(COMPILER, COMPILER + "#define MS_WIN64\n")
    (include / "pyconfig.h").write_text(config)
    declared: dict[str, str] = {}
    for header in sorted(include.rglob("*.h")):
        for kind, name in DECLARED.findall(header.read_text()):
            declared[name] = " DATA" if kind == "DATA" else ""
    definitions = target / "python.def"
    definitions.write_text("\n".join([f"LIBRARY python{version.replace('.', '')}.dll", "EXPORTS", *(name + data for name, data in sorted(declared.items()))]) + "\n")
    subprocess.run(["x86_64-w64-mingw32-dlltool", "-d", definitions, "-l", target / "python.a"], check=True)
