"""The scenes of comparisons, and the size of their references."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
SHARED = Path(os.environ.get("AJAR_SHARED_SCENES", PROJECT.parent / "shared" / "scenes"))


@dataclass(frozen=True)
class Scene:
    """With `percentage` of the resolution of the file, an image is about 190 pixels wide, so that 16 x 16-pixel blocks are details of the scene and a
    reference takes minutes."""

    name: str
    path: Path
    percentage: int = 30

    @property
    def reference(self) -> Path:
        """The file of block means in the repository."""
        return PROJECT / "test_scenes" / "references" / f"{self.name}.npz"

    @property
    def pixel_reference(self) -> Path:
        """The file of the mean and variance of every pixel, in the build tree."""
        return PROJECT / "build" / "references" / f"{self.name}.npz"


PROJECT_SCENES = [
    Scene(name, PROJECT / "test_scenes" / f"{name}.blend")
    for name in ("checker", "box", "rooms", "room", "lantern", "buddha", "plant", "outdoor", "many_lights", "volume")
]

# Only for techniques.py: the repository has no references of these, so that `make bench` and `make agreement` omit them.
TECHNIQUE_SCENES = [
    Scene(name, PROJECT / "test_scenes" / f"{name}.blend", percentage)
    for name, percentage in (
        ("keyhole", 30), ("bar", 30), ("kitchen", 30), ("attic", 30), ("room_fog", 30), ("room_hair", 30), ("room_motion", 30), ("room_skin", 30),
        ("rooms_panorama", 24), ("ocean", 30), ("fur", 30), ("cloud", 30),
    )
]

# Files of third parties, beside the project or at AJAR_SHARED_SCENES. They are not part of the project.
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
    """Scenes by name, in the given order. An unknown name raises a ValueError that lists the known ones."""
    known = {scene.name: scene for scene in ALL_SCENES + TECHNIQUE_SCENES}
    for name in names:
        if name not in known:
            raise ValueError(f"no scene '{name}'; there are {', '.join(known)}")
    return [known[name] for name in names]
