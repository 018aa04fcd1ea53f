"""Cornell box with two caustics (thesis, figures 1.5, 4.6, 5.3 and 5.10).

The right wall and the rear ball are mirrors, the front ball is glass, the light is small. The light of the bright caustic passes the glass ball
directly from the light; that of the faint one is reflected by the mirror wall before. Each has a light hint.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import scene_tools as tools
from mathutils import Vector

# The room: x to the right, y away from the camera, z up. Its front is open and exactly fills a 4:3 image.
HALF_WIDTH, DEPTH, HEIGHT = 4.0 / 3.0, 2.3, 2.0
LIGHT = Vector((0.0, 1.15, HEIGHT - 0.005))
LIGHT_SIZE = 0.34
MIRROR_BALL = Vector((-0.55, 1.62, 0.45))
GLASS_BALL = Vector((0.47, 0.80, 0.36))


def add_room() -> None:
    white = tools.diffuse("White", (0.74, 0.73, 0.70))
    red = tools.diffuse("Red", (0.56, 0.055, 0.045))
    blue = tools.diffuse("Blue", (0.22, 0.36, 0.44))
    mirror = tools.mirror("Mirror wall", (0.88, 0.90, 0.90))
    w, d, h = HALF_WIDTH, DEPTH, HEIGHT
    tools.add_quad("Floor", (-w, 0, 0), (w, 0, 0), (w, d, 0), (-w, d, 0), white)
    tools.add_quad("Ceiling", (-w, 0, h), (-w, d, h), (w, d, h), (w, 0, h), white)
    tools.add_quad("Rear wall", (-w, d, 0), (w, d, 0), (w, d, h), (-w, d, h), blue)
    tools.add_quad("Left wall", (-w, 0, 0), (-w, d, 0), (-w, d, h), (-w, 0, h), red)
    tools.add_quad("Right wall", (w, 0, 0), (w, 0, h), (w, d, h), (w, d, 0), mirror)
    # Without a frame the mirror would look like a second room.
    wood = tools.principled("Mirror frame", (0.16, 0.075, 0.035), roughness=0.35)
    band, depth = 0.055, 0.02
    for name, low_y, high_y, low_z, high_z in (
        ("rear", d - band, d, 0, h), ("front", 0, band, 0, h),
        ("top", band, d - band, h - band, h), ("bottom", band, d - band, 0, band),
    ):
        tools.add_box(f"Mirror frame {name}", (w - depth, low_y, low_z), (w, high_y, high_z), wood)


def add_lamp() -> None:
    tools.area_light("Ceiling light", LIGHT, LIGHT - Vector((0, 0, 1)), LIGHT_SIZE, 34.0, (1.0, 0.92, 0.80), seen=True)
    # A thin frame around the light, so that it looks like a lamp.
    metal = tools.principled("Lamp frame", (0.20, 0.20, 0.21), roughness=0.4)
    inner, outer, low = LIGHT_SIZE / 2 + 0.002, LIGHT_SIZE / 2 + 0.02, HEIGHT - 0.02
    x, y = LIGHT.x, LIGHT.y
    for name, left, right, near, far in (
        ("front", -outer, outer, -outer, -inner), ("rear", -outer, outer, inner, outer),
        ("left", -outer, -inner, -inner, inner), ("right", inner, outer, -inner, inner),
    ):
        tools.add_box(f"Lamp frame {name}", (x + left, y + near, low), (x + right, y + far, HEIGHT), metal)


def through_glass_ball(source: Vector) -> list[Vector]:
    """Points of a ray through the centre of the ball, which is not refracted: entry, exit, and hit on the floor."""
    travel = (GLASS_BALL - source).normalized()
    radius = GLASS_BALL.z
    floor = source + travel * (source.z / -travel.z)
    return [GLASS_BALL - travel * radius, GLASS_BALL + travel * radius, floor]


def add_hints() -> None:
    tools.light_hint("Light, glass ball, floor", [LIGHT, *through_glass_ball(LIGHT)])

    # Seen from the ball, the mirror image of the light is behind the wall.
    image = Vector((2.0 * HALF_WIDTH - LIGHT.x, LIGHT.y, LIGHT.z))
    share = (image.x - HALF_WIDTH) / (image.x - GLASS_BALL.x)
    on_wall = image.lerp(GLASS_BALL, share)
    tools.light_hint("Light, mirror wall, glass ball, floor", [LIGHT, on_wall, *through_glass_ball(image)])


def main() -> None:
    tools.start_scene(640, 480)
    add_room()
    add_lamp()
    tools.add_sphere("Mirror ball", MIRROR_BALL, MIRROR_BALL.z, tools.mirror("Mirror ball"), sides=128)
    tools.add_sphere("Glass ball", GLASS_BALL, GLASS_BALL.z, tools.glass("Glass", ior=1.5), sides=128)
    add_hints()
    eye = 4.3
    tools.camera((0, -eye, 0.5 * HEIGHT), (0, 0, 0.5 * HEIGHT), lens=36.0 * eye / (2.0 * HALF_WIDTH) * 1.01)
    tools.save(tools.output_path(__file__))


main()
