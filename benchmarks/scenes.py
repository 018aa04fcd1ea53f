"""The scenes that are compared, and the size at which references of them are kept."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
SHARED = Path(os.environ.get("AJAR_SHARED_SCENES", PROJECT.parent / "shared" / "scenes"))


@dataclass(frozen=True)
class Scene:
    """`percentage` of the file's resolution makes a picture about 190 pixels wide: 16 x 16-pixel blocks are then
    details of the scene, and a reference takes minutes."""

    name: str
    path: Path
    percentage: int = 30

    @property
    def reference(self) -> Path:
        """Block means committed with the project."""
        return PROJECT / "test_scenes" / "references" / f"{self.name}.npz"

    @property
    def pixel_reference(self) -> Path:
        """Mean and variance of every pixel, in the build tree."""
        return PROJECT / "build" / "references" / f"{self.name}.npz"


PROJECT_SCENES = [
    Scene(name, PROJECT / "test_scenes" / f"{name}.blend")
    for name in ("checker", "box", "rooms", "room", "lantern", "buddha", "plant", "outdoor", "many_lights", "volume")
]

# For techniques alone: no reference of them is committed, so `make bench` and `make agreement` leave them out.
TECHNIQUE_SCENES = [Scene(name, PROJECT / "test_scenes" / f"{name}.blend") for name in ("keyhole", "bar")]

# Files by other people, beside the project (or where AJAR_SHARED_SCENES says) and never part of it.
SHARED_SCENES = [
    Scene(f"shared/{name.replace('/', '_')}", SHARED / f"{name}.blend", percentage)
    for name, percentage in (
        ("armory/material_bake", 10), ("armory/teapots", 12), ("blenderseed/area_light", 10), ("blenderseed/camera_shift", 25),
        ("blenderseed/dof", 32), ("blenderseed/dupli_groups", 25), ("blenderseed/motion_blur_mesh", 30),
        ("blenderseed/multiple_materials", 10), ("blenderseed/no_node_tree", 10), ("blenderseed/particle_emitter", 40),
        ("blenderseed/split_normals", 30), ("clevr/base_scene", 60), ("ignis/box", 100), ("ignis/roughness", 100), ("ignis/tex", 100),
    )
]

ALL_SCENES = PROJECT_SCENES + SHARED_SCENES


def find_scenes(names: list[str]) -> list[Scene]:
    """Scenes by name, in the order given; an unknown name is a ValueError that lists the known ones."""
    known = {scene.name: scene for scene in ALL_SCENES + TECHNIQUE_SCENES}
    for name in names:
        if name not in known:
            raise ValueError(f"no scene '{name}'; there are {', '.join(known)}")
    return [known[name] for name in names]
