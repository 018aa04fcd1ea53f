"""Baking: a render whose pixels see the texels of an image instead of the film of a camera.

Blender calls the engine for each object and image. It says which triangle each texel shows; the core sends one ray down to it from just above the surface
(CameraKind.Texels), so that every pass of a render can be baked. A pass is one of the film's, or a sum of parts (`composed`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np
from bpy.app.handlers import persistent

from . import compat, messages, plain
from .ajar_module import ajar
from .export import ExportContext, export_scene, export_view
from .headless import Options
from .translations import report

POLL_SECONDS = 0.1
LOWEST_EYE = math.sin(math.radians(5.0))   # cosine between the normal and the direction to the camera, for baking from the view of the camera

# Bits of the argument `pass_filter`.
EMIT, DIFFUSE, GLOSSY, TRANSMISSION, DIRECT, INDIRECT, COLOR = 2, 4, 8, 16, 64, 128, 256
LOBES = {"DIFFUSE": "Diff", "GLOSSY": "Gloss", "TRANSMISSION": "Trans"}
LOBE_BITS = {"DIFFUSE": DIFFUSE, "GLOSSY": GLOSSY, "TRANSMISSION": TRANSMISSION}
ALL_LIGHT = EMIT | DIFFUSE | GLOSSY | TRANSMISSION | DIRECT | INDIRECT
SHADOW_CATCHER = "Shadow Catcher"   # the exporter then makes the baked object a catcher
DATA = {"NORMAL": "Normal", "POSITION": "Position", "UV": "UV", "EMIT": "Emit", "AO": "AO", "ROUGHNESS": "Roughness", "ENVIRONMENT": "Env",
        "SHADOW": SHADOW_CATCHER}
FAR = 1e6   # metres; nothing is there to hide the world
OF_FIRST_SAMPLE = {"NORMAL", "POSITION", "UV"}   # passes that keep the first sample of a pixel: it must be the middle of the texel


class CannotBake(Exception):
    """The message is shown to the artist."""


@dataclass(frozen=True)
class Texels:
    """For each pixel of the image, rows from the bottom up. `triangle` is -1 where the object is not shown."""

    triangle: np.ndarray      # [pixels] int32, index of a loop triangle
    barycentric: np.ndarray   # [pixels, 6] float32: of the first two corners, their changes along x, and along y


def read_texels(layer: bpy.types.RenderLayer, width: int, height: int) -> Texels:
    """What Blender says about the texels. Up to Blender 4 a seed stands before the triangle and its coordinates; later the triangle is last."""
    passes = {item.name: item for item in layer.passes}
    primitive, differential = (compat.read_pass(passes[name], width * height) for name in ("BakePrimitive", "BakeDifferential"))
    has_seed = primitive.shape[1] == 4
    triangle = np.ascontiguousarray(primitive[:, 1 if has_seed else 2]).view(np.int32)
    uv = primitive[:, 2:4] if has_seed else primitive[:, 0:2]
    du_dx, du_dy, dv_dx, dv_dy = differential.T
    barycentric = np.stack([uv[:, 0], uv[:, 1], du_dx, dv_dx, du_dy, dv_dy], axis=1).astype(np.float32)
    barycentric[triangle < 0] = 0.0
    return Texels(triangle, np.nan_to_num(barycentric))


@dataclass(frozen=True)
class Surface:
    """The triangles of an object in world space."""

    corners: np.ndarray   # [triangles, 3, 3] float32
    normals: np.ndarray   # [triangles, 3, 3] float32, unit: at the corners


def surface_of(thing: bpy.types.Object) -> Surface:
    mesh = thing.to_mesh()
    try:
        mesh.calc_loop_triangles()
        count = len(mesh.loop_triangles)
        indices, polygons = np.empty(count * 3, dtype=np.int32), compat.triangle_polygons(mesh)
        positions, of_vertices = compat.vertex_positions(mesh), np.empty(len(mesh.vertices) * 3, dtype=np.float32)
        of_faces, smooth = np.empty(count * 3, dtype=np.float32), np.empty(len(mesh.polygons), dtype=bool)
        mesh.loop_triangles.foreach_get("vertices", indices)
        mesh.loop_triangles.foreach_get("normal", of_faces)
        mesh.vertices.foreach_get("normal", of_vertices)
        mesh.polygons.foreach_get("use_smooth", smooth)
    finally:
        thing.to_mesh_clear()
    corners = positions[indices].reshape(count, 3, 3)
    normals = np.where(smooth[polygons][:, None, None], of_vertices.reshape(-1, 3)[indices].reshape(count, 3, 3), of_faces.reshape(count, 1, 3))
    matrix = np.array(thing.matrix_world, dtype=np.float64)
    turn = np.linalg.inv(matrix[:3, :3]) if abs(np.linalg.det(matrix[:3, :3])) > 1e-30 else np.eye(3)
    return Surface((corners @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32), _unit(normals @ turn).astype(np.float32))


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-30)


def directions_to_eye(surface: Surface, camera: bpy.types.Object | None) -> np.ndarray:
    """[triangles, 3, 3]: at each corner the normal (as in Cycles), or the direction to `camera`, which is raised above the surface."""
    if camera is None:
        return surface.normals
    frame = np.array(camera.matrix_world)
    towards = _unit(np.broadcast_to(frame[:3, 2], surface.corners.shape) if camera.data.type == "ORTHO" else frame[:3, 3] - surface.corners)
    cosine = (towards * surface.normals).sum(axis=-1, keepdims=True)
    return _unit(towards + np.maximum(LOWEST_EYE - cosine, 0.0) * surface.normals).astype(np.float32)


def of_world(surface: Surface) -> tuple[Surface, np.ndarray]:
    """A surface and directions to the eye that show the world in the directions from the origin to the places of `surface`, as in Cycles."""
    return Surface(np.full_like(surface.corners, FAR), surface.normals), -surface.corners


def see(camera: ajar.CameraDescription, settings: ajar.RenderSettings, name: str, texels: Texels, surface: Surface, eye: np.ndarray, width: int, height: int) -> None:
    """Make the texels what the camera sees."""
    if len(surface.corners) <= texels.triangle.max(initial=-1):
        raise CannotBake(report("{name}: its mesh has other triangles in the render than Blender bakes", name=name))
    triangle = np.maximum(texels.triangle, 0)
    camera.present, camera.name, camera.kind = True, name, ajar.CameraKind.Texels
    camera.motion, camera.shutter, camera.aperture_radius = [], [], 0.0
    camera.set_texels(texels.triangle >= 0, surface.corners[triangle].reshape(-1, 9), eye[triangle].reshape(-1, 9), texels.barycentric)
    side = _side_of_texels(texels, surface)
    camera.screen_window = (0.0, side * width, 0.0, side * height)
    settings.width, settings.height, settings.region = width, height, [0, 0, width, height]
    settings.filter, settings.filter_width = ajar.FilterKind.Box, 1.0
    settings.transparent_film = False


def _side_of_texels(texels: Texels, surface: Surface) -> float:
    """The median side of a texel on the surface, in metres."""
    shown = texels.triangle >= 0
    corners = surface.corners[texels.triangle[shown]].astype(np.float64)
    first, second = corners[:, 0] - corners[:, 2], corners[:, 1] - corners[:, 2]
    change = texels.barycentric[shown].astype(np.float64)
    along_x, along_y = (first * change[:, i:i + 1] + second * change[:, i + 1:i + 2] for i in (2, 4))
    areas = np.linalg.norm(np.cross(along_x, along_y), axis=1)
    areas = areas[areas > 0.0]
    return float(np.sqrt(np.median(areas))) if len(areas) else 1e-3


def passes_for(kind: str, bits: int) -> list[str]:
    """The passes of the film that a bake needs. Raises CannotBake for a kind that Ajar does not bake."""
    if kind in DATA:
        return [DATA[kind]]
    if kind == "COMBINED":
        if bits & ALL_LIGHT == ALL_LIGHT:
            return ["Combined"]
        lobes = [name for name, bit in LOBE_BITS.items() if bits & bit]
        return [item for lobe in lobes for item in _parts(lobe, bits | COLOR)] + (["Emit"] if bits & EMIT else [])
    if kind in LOBES:
        return _parts(kind, bits)
    raise CannotBake(report("Ajar does not bake {kind}. Cycles does.", kind=kind.title()))


def _parts(lobe: str, bits: int) -> list[str]:
    return [LOBES[lobe] + part for part, bit in (("Dir", DIRECT), ("Ind", INDIRECT), ("Col", COLOR)) if bits & bit]


def composed(kind: str, bits: int, values: Callable[[str], np.ndarray], pixels: int) -> np.ndarray:
    """[pixels, 4]: the baked image. `values(pass)` is an array [pixels, channels]."""
    result = np.zeros((pixels, 4), dtype=np.float32)
    result[:, 3] = 1.0
    if kind in DATA:   # Blender turns normals into the space of the bake
        source = values(DATA[kind])
        result[:, :3] = source[:, :3]   # a number is grey
        if kind == "UV":
            result[:, 2] = 1.0
    elif kind == "COMBINED" and bits & ALL_LIGHT == ALL_LIGHT:
        result[:] = values("Combined")
    elif kind == "COMBINED":
        for lobe, bit in LOBE_BITS.items():
            if bits & bit:
                result[:, :3] += _light(lobe, bits | COLOR, values, pixels)
        if bits & EMIT:
            result[:, :3] += values("Emit")[:, :3]
    else:
        result[:, :3] = _light(kind, bits, values, pixels)
    return result


def _light(lobe: str, bits: int, values: Callable[[str], np.ndarray], pixels: int) -> np.ndarray:
    """Light times colour; the light or the colour alone if only one of them is asked for."""
    light = [values(LOBES[lobe] + part)[:, :3] for part, bit in (("Dir", DIRECT), ("Ind", INDIRECT)) if bits & bit]
    colour = values(LOBES[lobe] + "Col")[:, :3] if bits & COLOR else None
    if not light:
        return colour if colour is not None else np.zeros((pixels, 3), dtype=np.float32)
    total = np.add.reduce(light)
    return total if colour is None else total * colour


@dataclass
class Kept:
    """A session whose scene the next image of the same bake shows, too."""

    depsgraph: int   # its address
    passes: list[str]
    baked: bpy.types.Object   # the original
    fits_others: bool         # whether the scene is the same when another selected object is baked
    session: ajar.Session


class _Shared:
    """What the objects of one bake share. Blender tells the beginning and the end of a bake only if it was started in the interface."""

    is_known = False
    kept: Kept | None = None


@persistent
def _begin(*_unused: object) -> None:
    _Shared.is_known, _Shared.kept = True, None


@persistent
def _end(*_unused: object) -> None:
    _Shared.is_known, _Shared.kept = False, None


HANDLERS = {"object_bake_pre": _begin, "object_bake_complete": _end, "object_bake_cancel": _end}


def _fits_others(depsgraph: bpy.types.Depsgraph, kind: str) -> bool:
    """Whether the selected objects can be baked to the active one in the same scene. A baked object is not displaced, and catches its shadow."""
    materials = [slot.material for thing in depsgraph.view_layer.objects if thing.select_get() for slot in thing.material_slots if slot.material is not None]
    return kind != "SHADOW" and not any(_displaces(material) for material in materials)


def _displaces(material: bpy.types.Material) -> bool:
    return material.node_tree is not None and any(node.type == "OUTPUT_MATERIAL" and node.inputs["Displacement"].is_linked for node in material.node_tree.nodes)


def bake(engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph, thing: bpy.types.Object, kind: str, bits: int, width: int, height: int) -> None:
    """Bake one object into the image that Blender has prepared. Blender calls this for each image of the object. Raises CannotBake."""
    passes = passes_for(kind, bits)
    # Blender finds the image of a result by the name of its layer, so that each image needs another one.
    engine.baked_images += 1
    result = engine.begin_result(0, 0, width, height, layer=f"Image {engine.baked_images}", view="")
    is_done = False
    try:
        layer = result.layers[0]
        texels = read_texels(layer, width, height)
        if kind in OF_FIRST_SAMPLE:
            texels.barycentric[:, 2:] = 0.0
        if (texels.triangle >= 0).any():
            session = _start(engine, depsgraph, thing, kind, passes, (texels, width, height))
            if not _follow(engine, session):
                return
            image = composed(kind, bits, lambda name: session.snapshot(name).reshape(width * height, -1), width * height)
            image[texels.triangle < 0] = 0.0
            compat.write_pass(next(item for item in layer.passes if item.name == "Combined"), image)
        is_done = True
    finally:
        engine.end_result(result, cancel=not is_done)


def _start(engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph, thing: bpy.types.Object, kind: str, passes: list[str],
           image: tuple[Texels, int, int]) -> ajar.Session:
    """A session that renders the texels. The scene is exported and built for the first image of an object only, or of all selected objects."""
    scene = depsgraph.scene_eval
    from_camera = scene.render.bake.view_from == "ACTIVE_CAMERA" and scene.camera is not None
    surface = surface_of(thing)
    eye = directions_to_eye(surface, scene.camera if from_camera else None)
    if kind == "ENVIRONMENT":
        surface, eye = of_world(surface)
    kept, (texels, width, height) = _Shared.kept if _Shared.is_known else engine.baked, image
    is_known = kept is not None and (kept.depsgraph, kept.passes) == (depsgraph.as_pointer(), passes) and (kept.baked == thing.original or kept.fits_others)
    exported = _export(engine, depsgraph, passes, thing, is_known)
    description = exported.description
    see(description.camera, description.settings, thing.name, texels, surface, eye, width, height)
    if is_known and kept is not None:
        kept.session.change_view(description.camera, description.settings)
        return kept.session
    session = ajar.Session()
    session.start(description)
    engine.baked = Kept(depsgraph.as_pointer(), passes, thing.original, _fits_others(depsgraph, kind), session)
    if _Shared.is_known:
        _Shared.kept = engine.baked
    return session


def _export(engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph, passes: list[str], thing: bpy.types.Object, is_view_only: bool) -> ExportContext:
    """The scene, with an integrator that can bake these passes. Path tracing bakes all of them. `is_view_only`: camera and settings alone."""
    scene = depsgraph.scene_eval
    chosen = next((item for item in ajar.integrator_list() if item.name == plain.of(scene.ajar).integrator), None)
    is_able = chosen is not None and chosen.bakes and passes == ["Combined"]
    options = Options({} if is_able else {"integrator": "path"})
    all_passes = list(dict.fromkeys(["Combined", *passes]))
    if is_view_only:
        return export_view(depsgraph, options, all_passes, scene.camera)
    exported = export_scene(depsgraph, options, all_passes, scene.camera, engine.test_break, lambda step: None, baked=thing)
    messages.report_warnings(engine, exported)
    return exported


def _follow(engine: bpy.types.RenderEngine, session: ajar.Session) -> bool:
    """Wait until the session ends. Returns False if the user cancels."""
    while not session.wait(POLL_SECONDS):
        engine.update_progress(session.progress().fraction)
        if engine.test_break():
            session.cancel()
            session.wait(60.0)
            return False
    for diagnostic in session.diagnostics():
        messages.report_diagnostic(engine, diagnostic)
    if error := session.take_error():
        raise CannotBake(error)
    return True


def register() -> None:
    for name, handler in HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    for name, handler in HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
