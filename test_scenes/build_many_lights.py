"""A night market: more than two thousand lights, a ninth of which are in view (thesis, section 5.6.3).

Nine parallel lanes are between rows of houses. Each lane has strings of bulbs, stall lamps and lanterns. The lanes out of view also have floodlights
with a thousand times the power of a bulb, and the houses contain lamps behind closed shutters. A choice of lights by power alone therefore nearly
always chooses an occluded light.
"""

from __future__ import annotations

import math
import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import scene_tools as tools
from mathutils import Matrix, Vector

LANES = range(-4, 5)  # Lane 0 is in view.
PITCH, LANE_WIDTH = 11.0, 5.4
NEAR, FAR = -6.0, 36.0
STALL_STEP = 2.9
STALL_X = 1.95  # From the middle of the lane to the middle of a stall.

WARM, AMBER, RED, TEAL, WHITE = ((1.0, 0.62, 0.28), (1.0, 0.45, 0.12), (1.0, 0.16, 0.06), (0.25, 0.85, 0.80),
                                 (0.85, 0.92, 1.0))

# From the centre of a window sill: left, right, low, high.
WINDOW_BARS = ((-0.42, -0.36, -0.06, 1.06), (0.36, 0.42, -0.06, 1.06), (-0.36, 0.36, 1.0, 1.06),
               (-0.42, 0.42, -0.10, 0.0), (-0.02, 0.02, 0.0, 1.0), (-0.36, 0.36, 0.55, 0.58))

# The fruits of the stalls, and the colours of their cloths.
PLUM, CHERRY, APPLE, ORANGE, LEMON, LIME = ((0.20, 0.03, 0.10), (0.55, 0.03, 0.02), (0.70, 0.10, 0.03),
                                            (0.75, 0.22, 0.02), (0.62, 0.50, 0.04), (0.25, 0.42, 0.04))
STALLS = (((0.45, 0.05, 0.04), (ORANGE, CHERRY, LEMON, LIME)), ((0.03, 0.20, 0.24), (LEMON, PLUM, ORANGE, CHERRY)),
          ((0.48, 0.26, 0.03), (LIME, APPLE, LEMON, ORANGE)))


class Parts:
    """Geometry that is collected by material; each material becomes one mesh."""

    def __init__(self, into: bpy.types.Collection) -> None:
        self.into = into
        self.verts: list[tools.Point] = []
        self.faces: list[tuple[int, ...]] = []
        self.slots: list[int] = []
        self.smooth: list[bool] = []
        self.materials: list[bpy.types.Material] = []

    def add(self, geometry, material: bpy.types.Material, *, at: tools.Point = (0, 0, 0), smooth: bool = False) -> None:
        if material not in self.materials:
            self.materials.append(material)
        verts, faces = geometry
        base = len(self.verts)
        self.verts += [(x + at[0], y + at[1], z + at[2]) for x, y, z in verts]
        self.faces += [tuple(base + i for i in face) for face in faces]
        self.slots += [self.materials.index(material)] * len(faces)
        self.smooth += [smooth] * len(faces)

    def box(self, low: tools.Point, high: tools.Point, material: bpy.types.Material) -> None:
        self.add(tools.box_geometry(low, high), material)

    def make(self, name: str) -> bpy.types.Object:
        made = tools.add_mesh(name, self.verts, self.faces, into=self.into)
        for material in self.materials:
            made.data.materials.append(material)
        made.data.polygons.foreach_set("material_index", self.slots)
        made.data.polygons.foreach_set("use_smooth", self.smooth)
        return made


def ball(radius: float, sides: int = 10) -> tuple[list, list]:
    rings = sides // 2
    angles = [math.pi * i / rings for i in range(1, rings)]
    middle = [(radius * math.sin(a), -radius * math.cos(a)) for a in angles]
    return tools.lathe_geometry([(0.0, -radius), *middle, (0.0, radius)], sides)


# --- Things that repeat ----------------------------------------------------------------------------------------------

def stall(number: int, cloth: tools.Colour, fruits: tuple[tools.Colour, ...]) -> bpy.types.Collection:
    """A stall. It is open to +X, where the lane is; its length is along Y."""
    pick = random.Random(number)
    parts = Parts(tools.collection(f"Stall {number}", in_scene=False))
    wood = tools.principled(f"Stall wood {number}", (0.23, 0.12, 0.06), roughness=0.55)
    dyed = tools.diffuse(f"Canopy {number}", cloth)
    plain = tools.diffuse(f"Canopy plain {number}", (0.72, 0.66, 0.54))
    for x in (-0.55, 0.55):
        for y in (-1.1, 1.1):
            parts.box((x - 0.03, y - 0.03, 0), (x + 0.03, y + 0.03, 2.0 if x > 0 else 2.5), wood)
    parts.box((-0.1, -1.12, 0.72), (0.62, 1.12, 0.80), wood)
    for k in range(11):  # The front is boarded.
        parts.box((0.54, -1.08 + 0.198 * k, 0.06), (0.565, -0.90 + 0.198 * k, 0.72), wood)
    # A striped canopy whose front edge hangs in scallops.
    stripes, steps = 9, 6
    for k in range(stripes):
        low, width = -1.25 + 2.5 * k / stripes, 2.5 / stripes
        verts = [(-0.75, low, 2.56), (0.85, low, 1.98), (0.85, low + width, 1.98), (-0.75, low + width, 2.56)]
        faces = [(0, 1, 2, 3)]
        verts += [(0.85, low + width * i / steps, 1.98) for i in range(steps + 1)]
        verts += [(0.87, low + width * i / steps, 1.84 - 0.07 * math.sin(math.pi * i / steps))
                  for i in range(steps + 1)]
        faces += [(4 + i, 4 + steps + 1 + i, 5 + steps + 1 + i, 5 + i) for i in range(steps)]
        parts.add((verts, faces), plain if k % 2 else dyed)
    # Crates of fruit, tilted towards the customer.
    for k, colour in enumerate(fruits):
        skin = tools.principled(f"Fruit {number}-{k + 1}", colour, roughness=0.3)
        y = -0.78 + 0.52 * k
        for x, left, right, high in ((0.0, -0.23, 0.23, 0.84), (0.56, -0.23, 0.23, 0.91), (0.0, -0.23, -0.21, 0.93),
                                     (0.0, 0.21, 0.23, 0.93)):
            parts.box((x, y + left, 0.80), (0.58, y + right, high), wood)
        radius = pick.uniform(0.042, 0.06)
        for layer in range(3):
            for i in range(5 - layer):
                for j in range(4 - layer):
                    x = 0.08 + (i + 0.5 * layer) * 0.098 + pick.gauss(0, 0.006)
                    where = (x, y + (j + 0.5 * layer - 1.5) * 0.098 + pick.gauss(0, 0.006), 0.88 + 0.07 * layer)
                    parts.add(ball(radius), skin, at=where, smooth=True)
    parts.make(f"Stall {number}")
    return parts.into


def lantern(name: str, colour: tools.Colour, strength: float) -> bpy.types.Collection:
    """A paper lantern: an emissive barrel between two dark rings."""
    parts = Parts(tools.collection(name, in_scene=False))
    paper = tools.emission(f"{name} paper", colour, strength)
    dark = tools.principled(f"{name} rim", (0.03, 0.02, 0.02), roughness=0.4)
    profile = [(0.085, -0.17), (0.150, -0.09), (0.165, 0.0), (0.150, 0.09), (0.085, 0.17)]
    parts.add(tools.lathe_geometry(profile, 12), paper, smooth=True)
    for low, high in ((-0.19, -0.165), (0.165, 0.19)):
        parts.add(tools.lathe_geometry([(0.0, low), (0.09, low), (0.09, high), (0.0, high)], 12), dark)
    parts.add(tools.lathe_geometry([(0.012, -0.34), (0.018, -0.19)], 6), dark)
    parts.make(name)
    return parts.into


# --- The town --------------------------------------------------------------------------------------------------------

def add_paving(pick: random.Random) -> None:
    """Wet slabs with slightly different positions in the lane in view; plain ground elsewhere."""
    wet = [tools.principled(f"Wet stone {k + 1}", (0.055 + 0.02 * k, 0.052 + 0.018 * k, 0.052 + 0.016 * k),
                            roughness=0.16 + 0.07 * k) for k in range(3)]
    parts = Parts(bpy.context.scene.collection)
    half, x_step, y_step = LANE_WIDTH / 2.0, LANE_WIDTH / 9.0, 0.42
    for row in range(int((FAR - NEAR) / y_step)):
        shift = 0.5 * (row % 2)
        for i in range(10):
            low = max(-half, -half + (i - shift) * x_step) + 0.008
            high = min(half, -half + (i + 1 - shift) * x_step) - 0.008
            if high - low < 0.05:
                continue
            y = NEAR + row * y_step
            a, b = pick.gauss(0, 0.0035), pick.gauss(0, 0.0035)
            corners = [(low, y, a), (high, y, b), (high, y + y_step - 0.016, -a), (low, y + y_step - 0.016, -b)]
            parts.add((corners, [(0, 1, 2, 3)]), pick.choice(wet))
    parts.make("Paving").location.z = 0.012
    tools.add_plane("Ground", (0, 15, 0), (120, 60), tools.diffuse("Ground", (0.035, 0.033, 0.032)))


def add_houses(pick: random.Random) -> None:
    """Hollow rows of houses between the lanes, closed on all sides, and gates at both ends of the lane in view."""
    plasters = [tools.diffuse(f"Plaster {k + 1}", colour) for k, colour in enumerate(
        ((0.42, 0.30, 0.22), (0.50, 0.40, 0.29), (0.30, 0.21, 0.18), (0.40, 0.36, 0.32), (0.22, 0.24, 0.27)))]
    frame = tools.principled("Window frame", (0.10, 0.055, 0.03), roughness=0.5)
    shutter = tools.diffuse("Shutter", (0.06, 0.11, 0.11))
    tiles = tools.diffuse("Roof tiles", (0.13, 0.06, 0.045))
    panes = [tools.emission(f"Lit pane {k + 1}", colour, strength)
             for k, (colour, strength) in enumerate(((WARM, 1.6), (AMBER, 0.8), (TEAL, 0.5)))]
    half = LANE_WIDTH / 2.0
    for row in range(LANES.start - 1, LANES.stop):
        parts = Parts(bpy.context.scene.collection)
        left, right = row * PITCH + half, (row + 1) * PITCH - half
        y = NEAR
        while y < FAR - 0.1:
            length = min(pick.uniform(3.6, 5.6), FAR - y)
            if FAR - y - length < 2.0:
                length = FAR - y
            height = pick.uniform(5.0, 7.2)
            parts.box((left, y, 0), (right, y + length, height), pick.choice(plasters))
            parts.box((left - 0.28, y - 0.02, height), (right + 0.28, y + length + 0.02, height + 0.16), tiles)
            if row in (-1, 0):  # The fronts in view.
                x, out = (right, 1.0) if row == -1 else (left, -1.0)
                for k in range(2):
                    middle = y + length * (0.27 + 0.46 * k)
                    for low in (3.05,) if height < 6.2 else (3.05, 4.75):
                        lit = pick.random() < 0.55
                        pane = pick.choice(panes) if lit else shutter
                        depth = sorted((x, x + 0.02 * out))
                        parts.box((depth[0], middle - 0.36, low), (depth[1], middle + 0.36, low + 1.0), pane)
                        depth = sorted((x, x + 0.06 * out))
                        for a, b, c, d in WINDOW_BARS:
                            parts.box((depth[0], middle + a, low + c), (depth[1], middle + b, low + d), frame)
            y += length
        parts.make(f"Houses {row - LANES.start + 2}")
    # The gate house at the far end closes the lane, and so does one behind the camera.
    gate = Parts(bpy.context.scene.collection)
    brick = tools.diffuse("Gate brick", (0.34, 0.13, 0.08))
    for low, high in ((FAR, FAR + 2.0), (NEAR - 2.0, NEAR)):
        gate.box((-half, low, 0), (half, high, 8.5), brick)
        gate.box((-half - 0.3, low - 0.3, 8.5), (half + 0.3, high + 0.3, 8.75), tiles)
    gate.make("Gates")


# --- Lights ----------------------------------------------------------------------------------------------------------

def add_bulbs(lane: int, pick: random.Random, wire: bpy.types.Material) -> None:
    """Strings of bulbs that sag from front to front."""
    half, bulbs = LANE_WIDTH / 2.0, 10
    x0 = lane * PITCH
    for string in range(14):
        y = NEAR + 1.5 + string * (FAR - NEAR - 3.0) / 13.0
        side = 1.0 if string % 2 else -1.0
        tone = (WARM, AMBER, WARM, WHITE)[string % 4]

        def hang(t: float, side: float = side, y: float = y) -> Vector:
            return Vector((x0 + side * half * (2.0 * t - 1.0), y + 1.6 * (t - 0.5), 4.25 - 2.4 * t * (1.0 - t)))

        for i in range(bulbs):
            watts = 5.0 * math.exp(pick.gauss(0.0, 0.8))
            tools.point_light(f"Bulb {lane:+d} {string:02}-{i}", hang((i + 0.5) / bulbs) - Vector((0, 0, 0.045)), watts,
                              tone, radius=0.03, seen=True)
        if lane == 0:
            for i in range(20):
                tools.add_cylinder(f"Wire {string:02}-{i:02}", hang(i / 20), hang((i + 1) / 20), 0.006, wire, sides=5,
                                   caps=False)


def add_lights(pick: random.Random) -> None:
    wire = tools.diffuse("Wire", (0.02, 0.02, 0.02))
    lanterns = [lantern("Red lantern", (1.0, 0.09, 0.025), 1.6), lantern("Amber lantern", (1.0, 0.36, 0.06), 1.4)]
    stalls = [stall(k + 1, cloth, fruits) for k, (cloth, fruits) in enumerate(STALLS)]
    half = LANE_WIDTH / 2.0
    for lane in LANES:
        x0 = lane * PITCH
        add_bulbs(lane, pick, wire)
        for k in range(14):
            for side in (-1, 1):
                tag = f"{lane:+d} {k:02}{'LR'[side > 0]}"
                y = NEAR + 1.8 + k * STALL_STEP + 0.3 * side
                turn = Matrix.Rotation(0.0 if side < 0 else math.pi, 4, "Z")
                place = Matrix.Translation((x0 + side * STALL_X, y, 0)) @ turn
                tools.add_instance(f"Stall {tag}", stalls[(k * 2 + (side > 0) + lane) % 3], place)
                lamp = place @ Vector((0.1, 0.0, 2.15))
                tools.spot_light(f"Stall lamp {tag}", lamp, place @ Vector((0.35, 0, 0.8)),
                                 pick.uniform(20, 70), pick.choice((WARM, WARM, WHITE)), angle=math.radians(105),
                                 blend=0.5, radius=0.04)
                if (lane == 0 and k >= 2) or (lane != 0 and k % 4 == 0):
                    hook = place @ Vector((0.80, 1.35, 2.30))
                    tools.add_instance(f"Lantern {tag}", lanterns[(k + (side > 0)) % 2],
                                       Matrix.Translation(hook))
        for k in range(10):  # Lamps under the eaves.
            side = -1 if k % 2 else 1
            tools.point_light(f"Wall lamp {lane:+d} {k}", (x0 + side * (half - 0.25), NEAR + 3 + 4 * k, 3.0),
                              pick.uniform(4, 30), pick.choice((WARM, AMBER, TEAL)), radius=0.06, seen=True)
        if lane != 0:
            for k in range(4):
                y = NEAR + 5 + 10 * k
                tools.area_light(f"Floodlight {lane:+d} {k}", (x0, y, 4.8), (x0, y + 1, 0), (0.9, 0.3),
                                 10.0 ** pick.uniform(2.5, 4.0), WHITE)
    for row in range(LANES.start, LANES.stop - 1):  # Storerooms behind closed walls.
        for k in range(64):
            x = row * PITCH + PITCH / 2.0 + (k % 4 - 1.5) * 1.1
            tools.point_light(f"Storeroom lamp {row:+d} {k:02}", (x, NEAR + 1.6 + 2.5 * (k // 4), 2.6),
                              10.0 ** pick.uniform(-1.0, 3.0), WARM, radius=0.05)


def main() -> None:
    scene = tools.start_scene(640, 400)
    scene.view_settings.view_transform = "Filmic"  # Bulbs and dark corners in one image.
    tools.background(scene, (0.010, 0.018, 0.045), 0.6)
    pick = random.Random(7)
    add_paving(pick)
    add_houses(pick)
    add_lights(pick)
    tools.camera((0.35, -3.6, 2.05), (-0.15, 10.0, 2.15), lens=30.0)
    tools.save(tools.output_path(__file__))


main()
