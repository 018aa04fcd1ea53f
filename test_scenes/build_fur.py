"""`fur`: a furry toy with the Principled Hair BSDF in a studio.

The fur is particle hair: 10,000 parents with ten children each, which are the 100,000 rendered strands.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import build_buddha as buddha
import scene_tools as tools
from build_room_hair import bear
from furniture import put
from implicit_mesh import axis
from mathutils import Matrix
from shapes import sphere

PARENTS, CHILDREN = 10000, 10
LENGTH, RADIUS = 0.035, 0.00035  # of the strands, in metres
TURN = Matrix.Rotation(math.radians(-20), 4, "Z")


def build() -> None:
    scene = tools.start_scene(640, 640)
    tools.background(scene, (0.05, 0.06, 0.08))
    tools.camera((0.0, -1.25, 0.42), (0.0, 0.0, 0.20), lens=60)
    tools.add_plane("Floor", (0, 0, 0), (4, 4), tools.diffuse("Paper", (0.5, 0.48, 0.45)))
    tools.area_light("Key", (-0.9, -0.9, 1.2), (0, 0, 0.2), 0.5, 22, (1.0, 0.93, 0.85))
    tools.area_light("Rim", (0.8, 0.9, 0.9), (0, 0, 0.25), 0.4, 16, (0.8, 0.9, 1.0))
    build_toy()


def build_toy() -> None:
    body = buddha.add_part("Bear", bear, axis(-0.2, 0.2, 0.01), axis(-0.26, 0.12, 0.01), axis(-0.03, 0.45, 0.01), tools.diffuse("Hide", (0.25, 0.12, 0.05)))
    body.matrix_world = TURN
    fur = tools._material("Fur", "ShaderNodeBsdfHairPrincipled", Roughness=0.3, Radial_Roughness=0.4, Random_Roughness=0.2, Random_Color=0.3, Melanin=0.35,
                          Melanin_Redness=0.7)
    tools.shader_of(fur).parametrization = "MELANIN"
    body.data.materials.append(fur)
    settings = body.modifiers.new("Fur", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count, settings.hair_length, settings.hair_step = "HAIR", PARENTS, LENGTH, 4
    settings.use_advanced_hair = True
    settings.brownian_factor, settings.effector_weights.gravity = 0.004, 0.15
    settings.child_type, settings.rendered_child_count, settings.child_radius = "SIMPLE", CHILDREN, 0.01
    settings.roughness_2, settings.roughness_2_size = 0.01, 0.5
    settings.render_step, settings.material = 3, 2
    settings.root_radius, settings.tip_radius, settings.radius_scale = 1.0, 0.15, 2.0 * RADIUS
    black = tools.principled("Button", (0.02, 0.015, 0.015), roughness=0.1)
    buttons = sphere(0.015, 24, 12).moved(0, -0.130, 0.300)
    for side in (-1, 1):
        buttons += sphere(0.012, 24, 12).moved(0.034 * side, -0.100, 0.335)
    put("Buttons", buttons.placed(TURN), black, True)


if __name__ == "__main__":
    build()
    tools.save(tools.output_path(__file__))
