"""The machine on which the numbers of a benchmark page were measured."""

from __future__ import annotations

import os
import platform
import subprocess
from pathlib import Path

import renderers


def _first_match(path: str, key: str) -> str:
    for line in Path(path).read_text().splitlines():
        if line.startswith(key):
            return line.split(":", 1)[1].strip()
    return "unknown"


def _output(command: list[str]) -> str:
    try:
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()
    except OSError:
        return ""


def commit() -> str:
    return _output(["git", "-C", str(renderers.PROJECT), "rev-parse", "--short", "HEAD"]) or "unknown"


def describe(threads: int) -> dict[str, str]:
    """Processor, memory, system and versions, as text."""
    kilobytes = int(_first_match("/proc/meminfo", "MemTotal").split()[0])
    system = next((line.split("=", 1)[1].strip('"') for line in Path("/etc/os-release").read_text().splitlines()
                   if line.startswith("PRETTY_NAME")), platform.system())
    blender = _output([renderers.BLENDER, "--version"]).splitlines()
    return {
        "processor": f"{_first_match('/proc/cpuinfo', 'model name')}, {os.cpu_count()} hardware threads",
        "memory": f"{kilobytes / 2**20:.0f} GiB",
        "system": f"{system}, Linux {platform.release()}",
        "blender": blender[0] if blender else "none",
        "compiler": _output(["c++", "--version"]).splitlines()[0] if _output(["c++", "--version"]) else "unknown",
        "commit": commit(),
        "threads": str(threads),
        "load before": f"{os.getloadavg()[0]:.2f}",
    }
