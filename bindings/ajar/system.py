"""What differs between operating systems: the processor, and the libraries of this process."""

from __future__ import annotations

import ctypes
import os
import sys
from pathlib import Path

# The flags that each level of x86-64 adds to the one below (System V ABI for AMD64, 3.1.1), with the names of /proc/cpuinfo, from the highest on.
LEVELS = {
    "x86-64-v3": {"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "xsave"},
    "x86-64-v2": {"cx16", "lahf_lm", "popcnt", "sse4_1", "sse4_2", "ssse3"},
}

if sys.platform == "win32":
    from ctypes import wintypes

    # Windows tells of a few features by number. A processor with AVX2, or with SSE4.2, has the others of that level.
    _FEATURES = {"x86-64-v3": 40, "x86-64-v2": 38}
    _LONGEST_PATH = 32768

    def processor_flags() -> set[str]:
        """The flags of the processor, with the names of Linux."""
        kernel = ctypes.WinDLL("kernel32")
        return {flag for level, feature in _FEATURES.items() if kernel.IsProcessorFeaturePresent(feature) for flag in LEVELS[level]}

    def loaded_libraries() -> list[str]:
        """The files of the libraries in this process."""
        kernel = ctypes.WinDLL("kernel32")
        kernel.GetCurrentProcess.restype = wintypes.HANDLE
        kernel.K32EnumProcessModules.argtypes = [wintypes.HANDLE, ctypes.POINTER(wintypes.HMODULE), wintypes.DWORD, ctypes.POINTER(wintypes.DWORD)]
        kernel.GetModuleFileNameW.argtypes = [wintypes.HMODULE, wintypes.LPWSTR, wintypes.DWORD]
        modules, used = (wintypes.HMODULE * 4096)(), wintypes.DWORD()
        if not kernel.K32EnumProcessModules(kernel.GetCurrentProcess(), modules, ctypes.sizeof(modules), ctypes.byref(used)):
            return []
        names = []
        for module in modules[:used.value // ctypes.sizeof(wintypes.HMODULE)]:
            name = ctypes.create_unicode_buffer(_LONGEST_PATH)
            if kernel.GetModuleFileNameW(module, name, _LONGEST_PATH):
                names.append(name.value)
        return sorted(names)

    def use_libraries_of(folder: Path) -> None:
        """Let modules that are imported later find their libraries in a folder."""
        if folder.is_dir():
            os.add_dll_directory(str(folder))
else:
    def processor_flags(cpuinfo: Path = Path("/proc/cpuinfo")) -> set[str]:
        """The flags of the processor, with the names of Linux."""
        for line in cpuinfo.read_text(encoding="ascii", errors="replace").splitlines():
            if line.startswith("flags"):
                return set(line.partition(":")[2].split())
        return set()

    def loaded_libraries() -> list[str]:
        """The files of the libraries in this process."""
        try:
            lines = Path("/proc/self/maps").read_text(encoding="utf-8", errors="replace").splitlines()
        except OSError:
            return []
        return sorted({line.split(None, 5)[-1] for line in lines if ".so" in line})

    def use_libraries_of(folder: Path) -> None:
        """Nothing: the modules name the folder themselves."""
