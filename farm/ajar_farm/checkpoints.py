"""What the header of a checkpoint says. Its data and its checksums are the business of ajar-render (core/render/checkpoint.h)."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

MAGIC = b"AJARCHP3"
LONGEST_HEADER = 1 << 20


@dataclass(frozen=True)
class Header:
    samples: float
    relmse: float          # estimated; negative: unknown
    ranges: list[tuple[int, int, int]]
    seeds: list[int]
    seconds: float
    version: str
    scene: int             # fingerprints: of the scene, and of the camera with the settings that define the image
    view: int

    def difference(self, identity: dict) -> str:
        """Why it is no checkpoint of this scene with these settings (ajar-render --identity); empty if it is one."""
        if self.version != identity["version"]:
            return f"it is of version {self.version} of Ajar, not {identity['version']}"
        if self.scene != identity["scene"]:
            return "it is of another scene or frame"
        return "its camera or settings differ" if self.view != identity["view"] else ""


def read_header(path: Path) -> Header | None:
    """The header, or None if there is no file or it is none of this version."""
    try:
        with path.open("rb") as file:
            if file.read(8) != MAGIC:
                return None
            length = int.from_bytes(file.read(8), "little")
            file.read(8)   # the checksum of the header
            if length > LONGEST_HEADER:
                return None
            header = json.loads(file.read(length))
        return Header(float(header["samples"]), float(header["relmse"]), [(int(s), int(first), int(end)) for s, first, end in header["ranges"]],
                      [int(seed) for seed in header["seeds"]], float(header["seconds"]), str(header["version"]), int(header["scene"]), int(header["view"]))
    except (OSError, ValueError, KeyError, TypeError):
        return None
