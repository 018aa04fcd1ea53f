"""Every difference between Blender versions, in one place. Written for 3.4 and newer."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from itertools import chain, islice
from typing import Any

import bpy
import mathutils
import numpy as np

from . import plain

# Enumerations of Cycles as a file stores them, for use when its add-on is not enabled.
_CYCLES_ENUMS = {
    "pixel_filter_type": ("BOX", "GAUSSIAN", "BLACKMAN_HARRIS"),
    "motion_blur_position": ("START", "CENTER", "END"),
    "rolling_shutter_type": ("NONE", "TOP"),
    "shape": ("RIBBONS", "THICK", "THICK_LINEAR"),
    **dict.fromkeys(("texture_limit", "texture_limit_render"), ("OFF", "128", "256", "512", "1024", "2048", "4096", "8192")),
    "displacement_method": ("BUMP", "DISPLACEMENT", "BOTH"),
    "feature_set": ("SUPPORTED", "EXPERIMENTAL"),
    "panorama_type": ("EQUIRECTANGULAR", "FISHEYE_EQUIDISTANT", "FISHEYE_EQUISOLID", "MIRRORBALL", "FISHEYE_LENS_POLYNOMIAL",
                      "EQUIANGULAR_CUBEMAP_FACE"),
}


# ---- Settings of Cycles in a file ---------------------------------------------------------------------------------

def _stored(owner: bpy.types.bpy_struct, group: str) -> dict:
    """Properties of a group as the file stores them. Empty where Python cannot read them any more (5.0)."""
    try:
        value = owner.get(group)
    except (TypeError, AttributeError):
        return {}
    return value if value is not None else {}


def has_cycles_settings(owner: bpy.types.bpy_struct) -> bool:
    """Whether a property of Cycles was set on this scene (light, world, ...). A pointer to nothing was only read."""
    cycles = getattr(owner, "cycles", None)
    if cycles is None:
        return any(value is not None for value in _stored(owner, "cycles").values())
    return any(cycles.is_property_set(item.identifier) and (item.type != "POINTER" or getattr(cycles, item.identifier) is not None)
               for item in cycles.bl_rna.properties if item.identifier not in ("rna_type", "name"))


def cycles_value(owner: bpy.types.bpy_struct, name: str, default: Any, group: str = "cycles") -> Any:
    """A Cycles property of `owner`, from the add-on or from the file; `default` if neither has it."""
    cycles = getattr(owner, group, None)
    if cycles is not None:
        return getattr(cycles, name, default)
    value = _stored(owner, group).get(name, default)
    if name in _CYCLES_ENUMS and isinstance(value, int):
        return _CYCLES_ENUMS[name][value]
    return value


# Each of these functions returns the struct that has a setting: Blender's own in versions that have one, otherwise Ajar's, which inherits from
# Cycles.

def panorama_owner(camera: bpy.types.Camera) -> bpy.types.bpy_struct:
    """The owner of panorama settings: the camera itself since 5.0."""
    return camera if hasattr(camera, "panorama_type") else camera.ajar


def shadow_owner(light: bpy.types.Light) -> tuple[bpy.types.bpy_struct, str]:
    """The owner and the name of the property. Before 4.2, `use_shadow` was a property of Eevee only."""
    return (light, "use_shadow") if bpy.app.version >= (4, 2) else (light.ajar, "cast_shadow")


def displacement_owner(material: bpy.types.Material) -> bpy.types.bpy_struct:
    return material if bpy.app.version >= (4, 1) else material.ajar


def transparency_owner(material: bpy.types.Material) -> bpy.types.bpy_struct:
    """The owner of Transparent Shadows: the material itself since 4.2."""
    return material if hasattr(material, "use_transparent_shadow") else material.ajar


def has_texture_resolution() -> bool:
    """Whether Cycles has Texture Resolution (since 5.2)."""
    return bpy.app.version >= (5, 2)


def texture_cache_owner(scene: bpy.types.Scene) -> bpy.types.bpy_struct:
    """The owner of Texture Cache and Auto Generate: Blender's render settings since 5.2."""
    return scene.render if hasattr(scene.render, "use_texture_cache") else scene.ajar


def texture_cache_folder(scene: bpy.types.Scene) -> str:
    """Absolute or relative to the file of each image; empty: beside it. Since 5.2 it is one of Blender's preferences."""
    if texture_cache_owner(scene) != scene.ajar:
        return bpy.context.preferences.filepaths.texture_cache_directory.removeprefix("//")
    folder = scene.ajar.texture_cache_directory
    return os.path.normpath(bpy.path.abspath(folder)) if folder else ""


def has_bump_correction() -> bool:
    """Whether Cycles has the switch Bump Map Correction (since 4.1)."""
    return bpy.app.version >= (4, 1)


def shutter_owner(scene: bpy.types.Scene) -> bpy.types.bpy_struct:
    return scene.render if hasattr(scene.render, "motion_blur_position") else scene.ajar


def terminator_owner(thing: bpy.types.Object) -> bpy.types.bpy_struct:
    return thing if hasattr(thing, "shadow_terminator_geometry_offset") else thing.ajar


# ---- Node trees -------------------------------------------------------------------------------------------------------

def node_tree(owner: bpy.types.Material | bpy.types.World | bpy.types.Light) -> bpy.types.NodeTree | None:
    """The node tree of `owner`, or None if its plain colour is used. Newer versions always use the tree."""
    always = (5, 2) if isinstance(owner, bpy.types.Light) else (5, 0)
    return owner.node_tree if bpy.app.version >= always or owner.use_nodes else None


_PLAIN_NODES = {"NodeReroute", "NodeFrame", "NodeGroupInput", "NodeGroupOutput", "NodeUndefined"}


def inlined(owner: bpy.types.Material | bpy.types.World | bpy.types.Light, tree: bpy.types.NodeTree) -> Any | None:
    """What Blender makes of a tree with groups, repeat zones, closures, bundles or menus: a tree without them, `node_tree`, which lives as long as the
    result. Cycles renders it since 5.0. There the value of a group's input counts like a link: it replaces the default coordinates of a texture.
    None for a tree that has none of them, before 5.0, and for a tree whose groups have lost their trees, which the exporter reports."""
    if not hasattr(owner, "inline_shader_nodes"):
        return None
    nodes = [node for inner in _with_groups(tree, set()) for node in inner.nodes]
    groups = [node for node in nodes if node.type == "GROUP"]
    has_zones = any(not node.bl_idname.startswith("ShaderNode") and node.bl_idname not in _PLAIN_NODES for node in nodes)
    return owner.inline_shader_nodes() if has_zones or (groups and all(node.node_tree is not None for node in groups)) else None


def _with_groups(tree: bpy.types.NodeTree, seen: set[bpy.types.NodeTree]) -> Iterator[bpy.types.NodeTree]:
    """A tree and the trees of its groups, each once."""
    seen.add(tree)
    yield tree
    for node in tree.nodes:
        inner = getattr(node, "node_tree", None)
        if inner is not None and inner not in seen:
            yield from _with_groups(inner, seen)


def default_is_principled() -> bool:
    """Whether objects without a material are shown with the default Principled BSDF (since 5.0) or with a diffuse BSDF."""
    return bpy.app.version >= (5, 0)


def softens_bumps_by_microfacets() -> bool:
    """Whether Cycles uses the microfacet formula for the falloff of light at bumps, which it has since 4.5."""
    return bpy.app.version >= (4, 5)


def normal_map_generation() -> str:
    """How Cycles uses the strength of a normal map: "1" up to 3.6, "2" up to 5.0, "3" later (docs/developer/node_contract.md)."""
    return "3" if bpy.app.version >= (5, 1) else "2" if bpy.app.version >= (4, 0) else "1"


def hair_tilt() -> str:
    """Which direction Cycles turns by the Offset of Principled Hair: that of the "LIGHT" up to 3.6, of the "EYE" later."""
    return "EYE" if bpy.app.version >= (4, 0) else "LIGHT"


def poly_curves_are_straight() -> bool:
    """Whether Cycles shows poly curves as straight tubes, whatever the shape of hair is (since 5.0)."""
    return bpy.app.version >= (5, 0)


def ies_is_seen_from_eye() -> bool:
    """Whether IES textures without a vector use the direction to the eye; up to 3.6, the normal."""
    return bpy.app.version >= (4, 0)


def lamps_have_a_space() -> bool:
    """Whether Vector Transform in the nodes of a lamp knows the space of the lamp. Up to 3.6 it is that of the world."""
    return bpy.app.version >= (4, 0)


def normals_stay_perpendicular() -> bool:
    """Whether Vector Transform keeps normals perpendicular to surfaces that are scaled unevenly. In 3.4 they are transformed like vectors; 4.2 to 5.2
    keep them. The versions between were not tried."""
    return bpy.app.version >= (4, 0)


def suns_have_no_falloff() -> bool:
    """Whether a sun shines with any output of Light Falloff. It does in 4.5 to 5.2; in 3.4 and 4.2 it is black with Linear and Constant.
    The versions between were not tried."""
    return bpy.app.version >= (4, 5)


def lamps_have_uv() -> bool:
    """Whether the nodes of a lamp have UV coordinates. In 3.4 they are 0; in 4.2 to 5.2 Cycles has them. The versions between were not tried."""
    return bpy.app.version >= (4, 0)


def lamps_have_coordinates() -> bool:
    """Whether Object and Generated coordinates in the nodes of a lamp are in its own space, as in 4.5 to 5.2. In 4.2 they are those of the world. The
    versions between were not tried."""
    return bpy.app.version >= (4, 4)


def last_of_tables() -> int:
    """The last index of the tables by which Cycles evaluates colour ramps and curves: 255 in 3.4, 256 in 4.2 to 5.2. Steep ramps differ by several per cent
    of their range between the two. The versions between 3.4 and 4.2 were not tried."""
    return 256 if bpy.app.version >= (4, 0) else 255


# ---- Lights -------------------------------------------------------------------------------------------------------------

def casts_shadow(light: bpy.types.Light) -> bool:
    owner, name = shadow_owner(light)
    return getattr(plain.of(owner), name)


def light_energy(light: bpy.types.Light) -> float:
    """The energy by the definition of 3.4. It includes the exposure of newer versions, and the size of lamps that are not normalized."""
    energy = light.energy * 2.0 ** getattr(light, "exposure", 0.0)
    if not getattr(light, "normalize", True):
        energy *= _extent(light) or 1.0
    if light.type == "AREA" and bpy.app.version >= (4, 0):
        energy *= 4.0 / math.pi   # since 4.0 the value is the emitted power; 3.4 divides it by 4 instead of pi
    return energy


def _extent(light: bpy.types.Light) -> float:
    """The divisor of the power in Cycles unless `normalize` is off: an area in square metres, or for a sun the projected solid angle."""
    if light.type == "SUN":
        return math.pi * math.sin(0.5 * light.angle) ** 2
    if light.type != "AREA":
        return 4.0 * math.pi * light.shadow_soft_size**2
    height = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
    return light.size * height * (0.25 * math.pi if light.shape in ("DISK", "ELLIPSE") else 1.0)


def has_soft_falloff(light: bpy.types.Light) -> bool:
    """Whether a lamp is a disk that faces the lit point, or a sphere. Until 3.6 all lamps are disks, in 4.0 and 4.1 spheres."""
    return getattr(light, "use_soft_falloff", bpy.app.version < (4, 0))


def spots_are_even() -> bool:
    """Whether spot lamps are as strong everywhere in their cone, which has the scale of the lamp (since 4.0), or fall with the cosine."""
    return bpy.app.version >= (4, 0)


def suns_are_even() -> bool:
    """Whether a sun has the same radiance everywhere and its strength is the irradiance of a surface that faces it (since 4.0), or emits 1 / cos^3."""
    return bpy.app.version >= (4, 0)


def light_color(light: bpy.types.Light) -> tuple[float, float, float]:
    """The colour of the light, times that of its temperature if it is used."""
    color = light.color
    if getattr(light, "use_temperature", False):
        color = [a * b for a, b in zip(color, light.temperature_color)]
    return tuple(color)


def light_linking(thing: bpy.types.Object) -> bpy.types.bpy_struct | None:
    """The collections of light linking and shadow linking of an object (4.0)."""
    return getattr(thing, "light_linking", None)


# ---- Vectors --------------------------------------------------------------------------------------------------------

_BLOCK = 1 << 16   # vectors that exist at the same time


def coordinates(vectors: Iterator[mathutils.Vector], count: int) -> np.ndarray:
    """`count` vectors of three numbers as an array, [count, 3] of float32. Since 5.0, vectors are buffers, which is faster to read."""
    if bpy.app.version < (5, 0):
        return np.fromiter(chain.from_iterable(vectors), dtype=np.float32, count=3 * count).reshape(count, 3)
    result = np.empty((count, 3), dtype=np.float32)
    for first in range(0, count, _BLOCK):
        block = np.frombuffer(b"".join(islice(vectors, _BLOCK)), dtype=np.float32)
        result[first:first + _BLOCK] = block.reshape(-1, 3)
    return result


# ---- Meshes ---------------------------------------------------------------------------------------------------------

def numbers(collection: bpy.types.bpy_prop_collection, name: str, columns: int, kind: type) -> np.ndarray:
    """A property of all items: an array of [n], or of [n, columns]. Blender copies in bulk where `kind` is the type that it stores."""
    values: np.ndarray = np.empty(len(collection) * columns, dtype=kind)
    collection.foreach_get(name, values)
    return values.reshape(-1, columns) if columns > 1 else values


# Blender asks a function for each item of the older properties, which takes 20 to 50 times as long.

def vertex_positions(mesh: bpy.types.Mesh) -> np.ndarray:
    """[n, 3]"""
    attribute = mesh.attributes.get("position")
    if attribute is None or attribute.data_type != "FLOAT_VECTOR" or len(attribute.data) != len(mesh.vertices):
        return numbers(mesh.vertices, "co", 3, np.float32)
    return numbers(attribute.data, "vector", 3, np.float32)


def corner_vertices(mesh: bpy.types.Mesh) -> np.ndarray:
    """The vertex of each polygon corner, unsigned."""
    attribute = mesh.attributes.get(".corner_vert")
    if attribute is None or attribute.data_type != "INT" or len(attribute.data) != len(mesh.loops):
        return numbers(mesh.loops, "vertex_index", 1, np.uint32)
    return numbers(attribute.data, "value", 1, np.int32).view(np.uint32)


def triangle_polygons(mesh: bpy.types.Mesh) -> np.ndarray:
    """The polygon of each triangle, unsigned."""
    if not hasattr(mesh, "loop_triangle_polygons"):
        return numbers(mesh.loop_triangles, "polygon_index", 1, np.uint32)
    return numbers(mesh.loop_triangle_polygons, "value", 1, np.int32).view(np.uint32)


def uv_coordinates(layer: bpy.types.MeshUVLoopLayer) -> np.ndarray:
    """[n, 2], of the polygon corners"""
    if not hasattr(layer, "uv"):
        return numbers(layer.data, "uv", 2, np.float32)
    return numbers(layer.uv, "vector", 2, np.float32)


def polygon_materials(mesh: bpy.types.Mesh) -> np.ndarray | None:
    """The material index of each polygon, or None if all are 0."""
    attribute = mesh.attributes.get("material_index")
    if attribute is None or attribute.domain != "FACE" or len(attribute.data) != len(mesh.polygons):
        return None if bpy.app.version >= (3, 4) else numbers(mesh.polygons, "material_index", 1, np.int32)
    return numbers(attribute.data, "value", 1, np.int32)


def polygon_smooth(mesh: bpy.types.Mesh) -> np.ndarray:
    """Whether each polygon is shaded smooth. Without a flag for each, none is if all edges are sharp."""
    if bpy.app.version >= (4, 1):
        sharp = mesh.attributes.get("sharp_face")
        if sharp is None or sharp.domain != "FACE":
            return np.full(len(mesh.polygons), mesh.normals_domain != "FACE")
        return ~numbers(sharp.data, "value", 1, bool)
    return numbers(mesh.polygons, "use_smooth", 1, bool)


def has_split_normals(mesh: bpy.types.Mesh) -> bool:
    """Whether Cycles has a normal for each corner. Those of a flat face are all that of the polygon. Otherwise, the normals of smooth faces are those of
    the vertices, and a flat face has those of its triangles. Measured in 3.4.1, 4.2.23, 4.5.15, 5.0.1 and 5.2.3."""
    if bpy.app.version < (4, 1):
        return mesh.use_auto_smooth
    return mesh.normals_domain == "CORNER" and (bpy.app.version >= (5, 1) or mesh.has_custom_normals or "sharp_edge" in mesh.attributes)


def has_custom_normals(mesh: bpy.types.Mesh) -> bool:
    """Whether the mesh has custom normals, which flat faces use as well."""
    return mesh.has_custom_normals and (bpy.app.version >= (4, 1) or mesh.use_auto_smooth)


def corner_normals(mesh: bpy.types.Mesh) -> np.ndarray:
    """Split normals, one for each polygon corner."""
    if bpy.app.version >= (4, 1):
        return numbers(mesh.corner_normals, "vector", 3, np.float32)
    mesh.calc_normals_split()
    normals = numbers(mesh.loops, "normal", 3, np.float32)
    mesh.free_normals_split()
    return normals


def vertex_normals(mesh: bpy.types.Mesh) -> np.ndarray:
    return numbers(mesh.vertex_normals, "vector", 3, np.float32)


def adapts_by_modifier() -> bool:
    """Whether adaptive subdivision is a setting of the modifier (since 5.0) or of the object."""
    return bpy.app.version >= (5, 0)


def adapts_before_modifier() -> bool:
    """Whether Cycles divides the mesh before the Subdivision Surface modifier (since 4.5) or the mesh that the modifier has made."""
    return bpy.app.version >= (4, 5)


def is_experimental(scene: bpy.types.Scene) -> bool:
    """Whether Cycles uses its experimental features, such as adaptive subdivision before 5.0."""
    return cycles_value(scene, "feature_set", "SUPPORTED") == "EXPERIMENTAL"


def edge_creases(mesh: bpy.types.Mesh) -> np.ndarray | None:
    if bpy.app.version >= (4, 0):
        return _crease_attribute(mesh, "crease_edge", "EDGE", len(mesh.edges))
    return numbers(mesh.edges, "crease", 1, np.float32)


def vertex_creases(mesh: bpy.types.Mesh) -> np.ndarray | None:
    if bpy.app.version >= (4, 0):
        return _crease_attribute(mesh, "crease_vert", "POINT", len(mesh.vertices))
    return numbers(mesh.vertex_creases[0].data, "value", 1, np.float32) if len(mesh.vertex_creases) else None


def _crease_attribute(mesh: bpy.types.Mesh, name: str, domain: str, count: int) -> np.ndarray | None:
    attribute = mesh.attributes.get(name)
    if attribute is None or attribute.domain != domain or attribute.data_type != "FLOAT" or len(attribute.data) != count:
        return None
    return numbers(attribute.data, "value", 1, np.float32)


def texture_space(mesh: bpy.types.Mesh) -> tuple[tuple[float, ...], tuple[float, ...]]:
    return tuple(mesh.texspace_location), tuple(mesh.texspace_size)


# ---- Render results ---------------------------------------------------------------------------------------------------

_PASSES_SINCE_5 = {
    "AO": "Ambient Occlusion", "IndexOB": "Object Index", "IndexMA": "Material Index", "Emit": "Emission", "Env": "Environment",
    **{short + part: f"{kind} {name}" for short, kind in (("Diff", "Diffuse"), ("Gloss", "Glossy"), ("Trans", "Transmission"), ("Volume", "Volume"))
       for part, name in (("Dir", "Direct"), ("Ind", "Indirect"), ("Col", "Color"))},
}


def pass_name(name: str) -> str:
    """Blender's name of a pass and of its socket in the compositor. Since 5.0, the names are not abbreviated."""
    return _PASSES_SINCE_5.get(name, name) if bpy.app.version >= (5, 0) else name


def aov_name(node: bpy.types.ShaderNodeOutputAOV) -> str:
    """The name of the AOV that the node writes. Before 4.2 it replaces the name of the node."""
    return getattr(node, "aov_name", node.name)


def write_pass(target: bpy.types.RenderPass, values: np.ndarray) -> None:
    """Write `values` [pixels, channels]. Newer versions take a flat array, older ones an array of pixels."""
    try:
        target.rect.foreach_set(values.ravel())
    except TypeError:
        target.rect.foreach_set(values)


def read_pass(source: bpy.types.RenderPass, pixels: int) -> np.ndarray:
    """The values [pixels, channels] of a pass."""
    values = np.empty((pixels, source.channels), dtype=np.float32)
    try:
        source.rect.foreach_get(values.ravel())
    except TypeError:
        source.rect.foreach_get(values)
    return values


# ---- Images -----------------------------------------------------------------------------------------------------------

def packed_bytes(image: bpy.types.Image) -> bytes:
    """The bytes of the file that is packed into the .blend, or no bytes."""
    packed = image.packed_file or (image.packed_files[0].packed_file if len(image.packed_files) else None)
    return _bytes(packed)


def packed_tiles(image: bpy.types.Image) -> dict[int, bytes]:
    """The bytes of the packed files of tiles, by the numbers of the tiles."""
    return {packed.tile_number: _bytes(packed.packed_file) for packed in image.packed_files}


def _bytes(packed: bpy.types.PackedFile | None) -> bytes:
    return bytes(packed.data) if packed is not None and packed.size > 0 else b""


def image_decides_about_alpha() -> bool:
    """Whether the alpha mode of an image, instead of its file, states if colours are multiplied by alpha."""
    return bpy.app.version >= (5, 1)


def color_spaces() -> tuple[str, str]:
    """The path of the OpenColorIO configuration, and the name of the working space in it."""
    folder = bpy.utils.system_resource("DATAFILES", path="colormanagement")
    config = os.environ.get("OCIO") or os.path.join(folder or "", "config.ocio")
    if hasattr(bpy.data, "colorspace"):   # 5.0
        return config, bpy.data.colorspace.working_space
    if "OCIO" in os.environ:
        return config, "scene_linear"
    # The name of Linear Rec. 709 in Blender's own configuration.
    return config, "Linear Rec.709" if bpy.app.version >= (4, 0) else "Linear"


# ---- Compositor ---------------------------------------------------------------------------------------------------------

def compositor_output(scene: bpy.types.Scene) -> tuple[bpy.types.NodeTree, bpy.types.NodeSocket]:
    """The compositing tree of the scene and the input of its output node. Both are created if they do not exist."""
    if bpy.app.version >= (5, 0):
        if scene.compositing_node_group is None:
            scene.compositing_node_group = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
        tree, kind = scene.compositing_node_group, "NodeGroupOutput"
        sockets = [item for item in tree.interface.items_tree if item.item_type == "SOCKET" and item.in_out == "OUTPUT"]
        if not sockets:
            tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    else:
        scene.use_nodes = True
        tree, kind = scene.node_tree, "CompositorNodeComposite"
    output = next((node for node in tree.nodes if node.bl_idname == kind), None) or tree.nodes.new(kind)
    return tree, output.inputs[0]


# ---- Drawing --------------------------------------------------------------------------------------------------------------

POLYLINE_SHADER = "POLYLINE_UNIFORM_COLOR" if bpy.app.version >= (4, 0) else "3D_POLYLINE_UNIFORM_COLOR"
FLAT_SHADER = "UNIFORM_COLOR" if bpy.app.version >= (4, 0) else "2D_UNIFORM_COLOR"
# Since 4.5, points have their own shaders.
POINT_SHADER = "POINT_FLAT_COLOR" if bpy.app.version >= (4, 5) else "FLAT_COLOR" if bpy.app.version >= (4, 0) else "3D_FLAT_COLOR"


def label_points(style: bpy.types.ThemeStyle) -> float:
    """Size of the text in panels. Newer versions have one size for all widgets."""
    return (style.widget_label if hasattr(style, "widget_label") else style.widget).points


def font_size(font: int, size: int) -> None:
    import blf

    if bpy.app.version >= (4, 0):
        blf.size(font, size)
    else:
        blf.size(font, size, 72)
