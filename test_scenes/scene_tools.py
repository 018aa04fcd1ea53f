"""Functions with which the test scenes are built.

Conventions: metres, Z up, world space. Colours are scene-linear RGB. Everything is created by the data API, so that the same script runs in
background mode in every supported Blender. A function returns the object that it creates; objects are linked to the scene. Only shader nodes that
Ajar renders exactly are used, with the GGX distribution where there is a choice. A perfect mirror or glass is GGX of roughness 0.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import bpy
from mathutils import Matrix, Vector

Point = Sequence[float]
Colour = Sequence[float]

LIGHT_HINTS = "Light Paths"

# Socket names that changed in Blender 4.0: current name -> older name.
OLDER_SOCKET_NAMES = {
    "Specular IOR Level": "Specular",
    "Transmission Weight": "Transmission",
    "Coat Weight": "Clearcoat",
    "Coat Roughness": "Clearcoat Roughness",
    "Sheen Weight": "Sheen",
    "Emission Color": "Emission",
    "Subsurface Weight": "Subsurface",
}


# --- The scene -------------------------------------------------------------------------------------------------------

def start_scene(width: int, height: int, *, samples: int = 64, bounces: int = 16) -> bpy.types.Scene:
    """An empty scene with settings of Cycles for the complete light transport, without clamping or omissions."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.unit_settings.system = "METRIC"
    scene.display_settings.display_device = "sRGB"
    scene.view_settings.view_transform = "Standard"
    scene.view_settings.look = "None"
    scene.world = bpy.data.worlds.new("World")
    background(scene, (0.0, 0.0, 0.0))

    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x = width
    render.resolution_y = height
    render.resolution_percentage = 100
    render.film_transparent = False
    render.image_settings.file_format = "PNG"
    render.image_settings.color_mode = "RGB"

    cycles = scene.cycles
    cycles.samples = samples
    cycles.preview_samples = samples
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.use_preview_denoising = False
    cycles.max_bounces = bounces
    cycles.diffuse_bounces = bounces
    cycles.glossy_bounces = bounces
    cycles.transmission_bounces = bounces
    cycles.volume_bounces = bounces
    cycles.transparent_max_bounces = bounces
    cycles.caustics_reflective = True
    cycles.caustics_refractive = True
    cycles.blur_glossy = 0.0
    cycles.sample_clamp_direct = 0.0
    cycles.sample_clamp_indirect = 0.0
    # A value above zero drops dim lights at random, which changes the image.
    cycles.light_sampling_threshold = 0.0
    return scene


def background(scene: bpy.types.Scene, colour: Colour, strength: float = 1.0) -> bpy.types.Node:
    """A constant sky. Returns the Background node."""
    world = scene.world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    node = nodes.new("ShaderNodeBackground")
    set_input(node, "Color", colour)
    set_input(node, "Strength", strength)
    output = nodes.new("ShaderNodeOutputWorld")
    output.location = (240, 0)
    links.new(node.outputs["Background"], output.inputs["Surface"])
    return node


def environment(scene: bpy.types.Scene, image: bpy.types.Image, strength: float = 1.0) -> bpy.types.Node:
    """An equirectangular sky image. Returns the Environment Texture node."""
    shader = background(scene, (1.0, 1.0, 1.0), strength)
    tree = scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.location = (-300, 0)
    texture.image = image
    tree.links.new(texture.outputs["Color"], shader.inputs["Color"])
    return texture


def packed_image(name: str, width: int, height: int, pixels, *, hdr: bool = False) -> bpy.types.Image:
    """An image that is stored in the file. `pixels`: width*height*4 floats, rows from bottom to top; linear with `hdr`, otherwise sRGB."""
    image = bpy.data.images.new(name, width, height, alpha=False, float_buffer=hdr)
    if hdr:
        image.file_format = "HDR"
    image.pixels.foreach_set(pixels)
    image.update()
    image.pack()
    return image


def output_path(script: str) -> Path:
    """The path after `--` on the command line, or else `<name>.blend` beside `build_<name>.py`."""
    here = Path(script).resolve()
    parser = argparse.ArgumentParser(prog=here.name)
    parser.add_argument("path", nargs="?", type=Path, help="the .blend file")
    path = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []).path
    if path is not None:
        return path.resolve()
    return here.with_name(here.stem.removeprefix("build_") + ".blend")


def save(path: Path | str) -> None:
    """Write the scene, compressed and without a backup, and print a summary."""
    bpy.context.preferences.filepaths.save_version = 0
    bpy.context.view_layer.update()
    triangles, lights = count()
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True)
    size = Path(path).stat().st_size
    print(f"{Path(path).name}: {triangles:,} triangles, {lights:,} lights, {size / 1024:,.0f} kB")


def count() -> tuple[int, int]:
    """The numbers of rendered triangles (with modifiers and all instances) and of rendered light objects."""
    graph = bpy.context.evaluated_depsgraph_get()
    triangles_of: dict[int, int] = {}
    triangles = lights = 0
    for instance in graph.object_instances:
        thing = instance.object
        if thing.type == "LIGHT":
            lights += 1
        elif thing.type == "MESH":
            key = thing.data.as_pointer()
            if key not in triangles_of:
                mesh = thing.data
                # A polygon of n corners gives n - 2 triangles.
                triangles_of[key] = len(mesh.loops) - 2 * len(mesh.polygons)
            triangles += triangles_of[key]
    return triangles, lights


# --- Camera and lights -----------------------------------------------------------------------------------------------

def look_at(eye: Point, target: Point, up: Point = (0.0, 0.0, 1.0)) -> Matrix:
    """The transform at `eye` whose -Z axis points to `target`, as for cameras and lights in Blender."""
    z = (Vector(eye) - Vector(target)).normalized()
    x = Vector(up).cross(z)
    if x.length < 1e-6:
        x = Vector((1.0, 0.0, 0.0))
    x.normalize()
    y = z.cross(x)
    rotation = Matrix((x, y, z)).transposed().to_4x4()
    return Matrix.Translation(eye) @ rotation


def camera(eye: Point, target: Point, *, lens: float = 50.0, shift: tuple[float, float] = (0.0, 0.0),
           f_stop: float | None = None, focus: float = 0.0) -> bpy.types.Object:
    """Add the camera. `lens` is in millimetres on a sensor 36 mm wide; with an `f_stop`, the camera has depth of field."""
    data = bpy.data.cameras.new("Camera")
    data.lens = lens
    data.sensor_width = 36.0
    data.shift_x, data.shift_y = shift
    data.clip_start = 0.01
    data.clip_end = 1000.0
    if f_stop is not None:
        data.dof.use_dof = True
        data.dof.aperture_fstop = f_stop
        data.dof.focus_distance = focus or (Vector(eye) - Vector(target)).length
    made = link(bpy.data.objects.new("Camera", data))
    made.matrix_world = look_at(eye, target)
    bpy.context.scene.camera = made
    return made


def _light(name: str, kind: str, watts: float, colour: Colour) -> bpy.types.Object:
    data = bpy.data.lights.new(name, kind)
    data.energy = watts
    data.color = colour[:3]
    return link(bpy.data.objects.new(name, data))


def area_light(name: str, position: Point, target: Point, size: float | tuple[float, float], watts: float,
               colour: Colour = (1.0, 1.0, 1.0), *, disk: bool = False, seen: bool = False) -> bpy.types.Object:
    """A rectangle (or an ellipse) that emits towards `target`. The camera sees it directly only with `seen`."""
    made = _light(name, "AREA", watts, colour)
    size_x, size_y = (size, size) if isinstance(size, (int, float)) else size
    made.data.shape = "ELLIPSE" if disk else "RECTANGLE"
    made.data.size, made.data.size_y = size_x, size_y
    made.visible_camera = seen
    made.matrix_world = look_at(position, target)
    return made


def point_light(name: str, position: Point, watts: float, colour: Colour = (1.0, 1.0, 1.0), *,
                radius: float = 0.0, seen: bool = False) -> bpy.types.Object:
    made = _light(name, "POINT", watts, colour)
    made.data.shadow_soft_size = radius
    made.visible_camera = seen
    made.location = position
    return made


def spot_light(name: str, position: Point, target: Point, watts: float, colour: Colour = (1.0, 1.0, 1.0), *,
               angle: float = math.radians(45.0), blend: float = 0.15, radius: float = 0.0) -> bpy.types.Object:
    """A spot light. `angle` is the full opening angle of the cone."""
    made = _light(name, "SPOT", watts, colour)
    made.data.spot_size = angle
    made.data.spot_blend = blend
    made.data.shadow_soft_size = radius
    made.matrix_world = look_at(position, target)
    return made


def sun_light(name: str, direction: Point, irradiance: float, colour: Colour = (1.0, 1.0, 1.0), *,
              angle: float = math.radians(0.526)) -> bpy.types.Object:
    """A sun light. `direction` is that of the light; `irradiance` is in W/m2 on a perpendicular surface."""
    made = _light(name, "SUN", irradiance, colour)
    made.data.angle = angle
    made.matrix_world = look_at((0.0, 0.0, 0.0), direction)
    return made


# --- Materials -------------------------------------------------------------------------------------------------------

def set_input(node: bpy.types.Node, name: str, value) -> None:
    """Set a socket by its current name, also in older Blenders. A colour may have three numbers."""
    if name not in node.inputs:
        name = OLDER_SOCKET_NAMES[name]
    socket = node.inputs[name]
    if socket.type == "RGBA" and len(value) == 3:
        value = (*value, 1.0)
    socket.default_value = value


def _material(name: str, node_type: str, output: str = "BSDF", **inputs) -> bpy.types.Material:
    """A material of one shader node; the node can be found by `shader_of`."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    shader = nodes.new(node_type)
    shader.name = "Shader"
    if hasattr(shader, "distribution"):
        shader.distribution = "GGX"
    for socket, value in inputs.items():
        set_input(shader, socket.replace("_", " "), value)
    surface = nodes.new("ShaderNodeOutputMaterial")
    surface.location = (300, 0)
    links.new(shader.outputs[output], surface.inputs["Surface"])
    # The colour in the solid mode of the viewport.
    for socket in ("Base_Color", "Color"):
        if socket in inputs:
            material.diffuse_color = (*inputs[socket][:3], 1.0)
    return material


def shader_of(material: bpy.types.Material) -> bpy.types.Node:
    return material.node_tree.nodes["Shader"]


def principled(name: str, colour: Colour, *, roughness: float = 0.5, metallic: float = 0.0, specular: float = 0.5,
               transmission: float = 0.0, ior: float = 1.45, coat: float = 0.0,
               coat_roughness: float = 0.03) -> bpy.types.Material:
    return _material(name, "ShaderNodeBsdfPrincipled", Base_Color=colour, Roughness=roughness, Metallic=metallic,
                     Specular_IOR_Level=specular, Transmission_Weight=transmission, IOR=ior, Coat_Weight=coat,
                     Coat_Roughness=coat_roughness)


def diffuse(name: str, colour: Colour, *, roughness: float = 0.0) -> bpy.types.Material:
    return _material(name, "ShaderNodeBsdfDiffuse", Color=colour, Roughness=roughness)


def glossy(name: str, colour: Colour, roughness: float) -> bpy.types.Material:
    return _material(name, "ShaderNodeBsdfGlossy", Color=colour, Roughness=roughness)


def mirror(name: str, colour: Colour = (0.9, 0.9, 0.9)) -> bpy.types.Material:
    return glossy(name, colour, 0.0)


def glass(name: str, colour: Colour = (1.0, 1.0, 1.0), *, roughness: float = 0.0,
          ior: float = 1.5) -> bpy.types.Material:
    return _material(name, "ShaderNodeBsdfGlass", Color=colour, Roughness=roughness, IOR=ior)


def translucent(name: str, colour: Colour) -> bpy.types.Material:
    return _material(name, "ShaderNodeBsdfTranslucent", Color=colour)


def emission(name: str, colour: Colour, strength: float) -> bpy.types.Material:
    """An emissive material. `strength` is the radiance in W/(m2 sr), which is equal on both sides."""
    return _material(name, "ShaderNodeEmission", "Emission", Color=colour, Strength=strength)


def subsurface(name: str, colour: Colour, radius: Colour, scale: float) -> bpy.types.Material:
    """Subsurface scattering by random walks. The radius of each channel is `radius` times `scale`, in metres."""
    material = _material(name, "ShaderNodeSubsurfaceScattering", "BSSRDF", Color=colour, Radius=radius, Scale=scale)
    shader = shader_of(material)
    renamed = "RANDOM_WALK_SKIN"  # since Blender 4.0, in which RANDOM_WALK is another method
    shader.falloff = renamed if renamed in shader.bl_rna.properties["falloff"].enum_items else "RANDOM_WALK"
    return material


def fog(name: str, colour: Colour, density: float, anisotropy: float) -> bpy.types.Material:
    """A homogeneous volume with `density` scattering events per metre. A renderer without media shows nothing of it."""
    material = _material(name, "ShaderNodeBsdfTransparent")
    nodes, links = material.node_tree.nodes, material.node_tree.links
    scatter = nodes.new("ShaderNodeVolumeScatter")
    scatter.location = (0, -160)
    set_input(scatter, "Color", colour)
    set_input(scatter, "Density", density)
    set_input(scatter, "Anisotropy", anisotropy)
    output = next(node for node in nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    links.new(scatter.outputs["Volume"], output.inputs["Volume"])
    return material


def mixed(name: str, first: bpy.types.Material, second: bpy.types.Material, share: float) -> bpy.types.Material:
    """A mix of two one-node materials with `share` of the second. The two materials are not changed."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.diffuse_color = first.diffuse_color
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    mix = nodes.new("ShaderNodeMixShader")
    mix.inputs["Fac"].default_value = share
    for index, source in enumerate((first, second)):
        original = shader_of(source)
        copy = nodes.new(original.bl_idname)
        copy.name = ("First", "Second")[index]
        copy.location = (-300, -250 * index)
        for choice in ("distribution", "falloff"):
            if hasattr(copy, choice):
                setattr(copy, choice, getattr(original, choice))
        for socket, old in zip(copy.inputs, original.inputs):
            if hasattr(old, "default_value"):
                socket.default_value = old.default_value
        links.new(copy.outputs[0], mix.inputs[1 + index])
    surface = nodes.new("ShaderNodeOutputMaterial")
    surface.location = (300, 0)
    links.new(mix.outputs["Shader"], surface.inputs["Surface"])
    return material


def checker_texture(material: bpy.types.Material, first: Colour, second: Colour, scale: float,
                    *, socket: str = "Color", coordinates: str = "UV") -> bpy.types.Node:
    """Link a colour socket of the shader to a checker pattern over the given texture coordinates."""
    tree = material.node_tree
    checks = tree.nodes.new("ShaderNodeTexChecker")
    checks.location = (-220, 0)
    set_input(checks, "Color1", first)
    set_input(checks, "Color2", second)
    checks.inputs["Scale"].default_value = scale
    where = tree.nodes.new("ShaderNodeTexCoord")
    where.location = (-440, 0)
    tree.links.new(where.outputs[coordinates], checks.inputs["Vector"])
    tree.links.new(checks.outputs["Color"], shader_of(material).inputs[socket])
    return checks


def image_texture(material: bpy.types.Material, image: bpy.types.Image, *, socket: str = "Color") -> bpy.types.Node:
    """Link a colour socket of the shader to an image over the UV map of the mesh."""
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.location = (-320, 0)
    texture.image = image
    tree.links.new(texture.outputs["Color"], shader_of(material).inputs[socket])
    return texture


# --- Objects ---------------------------------------------------------------------------------------------------------

def collection(name: str, *, in_scene: bool = True) -> bpy.types.Collection:
    """The collection with this name, which is created if it does not exist. A collection outside the scene is visible only by its instances."""
    made = bpy.data.collections.get(name) or bpy.data.collections.new(name)
    top = bpy.context.scene.collection
    if in_scene and made.name not in top.children:
        top.children.link(made)
    return made


def link(thing: bpy.types.Object, into: bpy.types.Collection | None = None) -> bpy.types.Object:
    (into or bpy.context.scene.collection).objects.link(thing)
    return thing


def mesh_data(name: str, verts: Iterable[Point], faces: Iterable[Sequence[int]],
              material: bpy.types.Material | None = None, smooth: bool = False) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(v) for v in verts], [], [tuple(f) for f in faces])
    if material is not None:
        mesh.materials.append(material)
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
    mesh.update()
    return mesh


def add_mesh(name: str, verts: Iterable[Point], faces: Iterable[Sequence[int]],
             material: bpy.types.Material | None = None, smooth: bool = False,
             into: bpy.types.Collection | None = None) -> bpy.types.Object:
    return link(bpy.data.objects.new(name, mesh_data(name, verts, faces, material, smooth)), into)


def add_instance(name: str, of: bpy.types.Mesh | bpy.types.Collection, matrix: Matrix,
                 into: bpy.types.Collection | None = None) -> bpy.types.Object:
    """Add an object with a shared mesh, or an instance of a collection."""
    if isinstance(of, bpy.types.Collection):
        made = bpy.data.objects.new(name, None)
        made.instance_type = "COLLECTION"
        made.instance_collection = of
        made.empty_display_size = 0.1
    else:
        made = bpy.data.objects.new(name, of)
    made.matrix_world = matrix
    return link(made, into)


def add_quad(name: str, a: Point, b: Point, c: Point, d: Point, material: bpy.types.Material | None = None,
             into: bpy.types.Collection | None = None) -> bpy.types.Object:
    """Add a quad of four corners, anticlockwise as seen from the side of the normal. UVs are 0 at `a` and 1 at `c`."""
    made = add_mesh(name, (a, b, c, d), ((0, 1, 2, 3),), material, into=into)
    uv = made.data.uv_layers.new(name="UVMap")
    for corner, value in zip(uv.data, ((0, 0), (1, 0), (1, 1), (0, 1))):
        corner.uv = value
    return made


def add_plane(name: str, centre: Point, size: tuple[float, float], material: bpy.types.Material | None = None,
              into: bpy.types.Collection | None = None) -> bpy.types.Object:
    """Add a horizontal rectangle that faces up."""
    x, y, z = centre
    u, v = size[0] / 2.0, size[1] / 2.0
    return add_quad(name, (x - u, y - v, z), (x + u, y - v, z), (x + u, y + v, z), (x - u, y + v, z), material, into)


def box_geometry(low: Point, high: Point) -> tuple[list[Point], list[tuple[int, ...]]]:
    (x, y, z), (u, v, w) = low, high
    verts = [(x, y, z), (u, y, z), (u, v, z), (x, v, z), (x, y, w), (u, y, w), (u, v, w), (x, v, w)]
    faces = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    return verts, faces


def add_box(name: str, low: Point, high: Point, material: bpy.types.Material | None = None, *, bevel: float = 0.0,
            into: bpy.types.Collection | None = None) -> bpy.types.Object:
    """Add an axis-aligned box between two corners. `bevel` is the width of its rounded edges."""
    made = add_mesh(name, *box_geometry(low, high), material, into=into)
    if bevel > 0.0:
        add_bevel(made, bevel)
    return made


def add_bevel(thing: bpy.types.Object, width: float, segments: int = 2) -> None:
    modifier = thing.modifiers.new("Bevel", "BEVEL")
    modifier.width = width
    modifier.segments = segments
    modifier.limit_method = "ANGLE"


def lathe_geometry(profile: Sequence[tuple[float, float]], sides: int) -> tuple[list[Point], list[tuple[int, ...]]]:
    """A surface of revolution around Z. The profile has (radius, height) pairs. If it goes up with the solid on the side of the axis, the faces point
    outwards. A radius of 0 is a pole."""
    verts: list[Point] = []
    rings: list[list[int]] = []
    for radius, height in profile:
        if radius == 0.0:
            rings.append([len(verts)] * sides)
            verts.append((0.0, 0.0, height))
            continue
        rings.append(list(range(len(verts), len(verts) + sides)))
        for i in range(sides):
            angle = 2.0 * math.pi * i / sides
            verts.append((radius * math.cos(angle), radius * math.sin(angle), height))
    faces = []
    for lower, upper in zip(rings, rings[1:]):
        for i in range(sides):
            j = (i + 1) % sides
            corners = (lower[i], lower[j], upper[j], upper[i])
            face = tuple(dict.fromkeys(corners))  # At a pole, two corners coincide.
            if len(face) >= 3:
                faces.append(face)
    return verts, faces


def add_lathe(name: str, profile: Sequence[tuple[float, float]], material: bpy.types.Material | None = None, *,
              position: Point = (0.0, 0.0, 0.0), sides: int = 64, smooth: bool = True,
              into: bpy.types.Collection | None = None) -> bpy.types.Object:
    made = add_mesh(name, *lathe_geometry(profile, sides), material, smooth, into)
    made.location = position
    return made


def add_cylinder(name: str, start: Point, end: Point, radius: float, material: bpy.types.Material | None = None, *,
                 end_radius: float | None = None, sides: int = 32, caps: bool = True,
                 into: bpy.types.Collection | None = None) -> bpy.types.Object:
    """Add a cylinder from `start` to `end`, or a frustum of a cone with another `end_radius`. Its sides are smooth and its caps flat."""
    length = (Vector(end) - Vector(start)).length
    top = radius if end_radius is None else end_radius
    verts, faces = lathe_geometry([(radius, 0.0), (top, length)], sides)
    sides_count = len(faces)
    if caps:
        faces.append(tuple(reversed(range(sides))))
        if top > 0.0:
            faces.append(tuple(range(sides, 2 * sides)))
        # The caps have separate vertices, so that smooth shading ends at the rim.
        verts = verts + verts
        half = len(verts) // 2
        faces[sides_count:] = [tuple(half + i for i in face) for face in faces[sides_count:]]
    made = add_mesh(name, verts, faces, material, into=into)
    made.data.polygons.foreach_set("use_smooth", [i < sides_count for i in range(len(faces))])
    if caps:
        _drop_loose(made.data)
    made.matrix_world = look_at(start, end) @ Matrix.Rotation(math.pi, 4, "X")
    return made


def add_sphere(name: str, centre: Point, radius: float, material: bpy.types.Material | None = None, *,
               sides: int = 64, into: bpy.types.Collection | None = None) -> bpy.types.Object:
    """Add a smooth latitude-longitude sphere with `sides` meridians and half as many parallels."""
    rings = sides // 2
    profile = [(0.0, -radius)]
    for i in range(1, rings):
        angle = math.pi * (i / rings - 0.5)
        profile.append((radius * math.cos(angle), radius * math.sin(angle)))
    profile.append((0.0, radius))
    return add_lathe(name, profile, material, position=centre, sides=sides, into=into)


def _drop_loose(mesh: bpy.types.Mesh) -> None:
    """Remove vertices that no face uses."""
    import bmesh
    work = bmesh.new()
    work.from_mesh(mesh)
    bmesh.ops.delete(work, geom=[v for v in work.verts if not v.link_faces], context="VERTS")
    work.to_mesh(mesh)
    work.free()


# --- Light hints -----------------------------------------------------------------------------------------------------

def light_hint(name: str, points: Sequence[Point]) -> bpy.types.Object:
    """Add a light hint: a poly curve from a light to a visible surface, with one point for each bounce. It is not rendered itself."""
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions = "3D"
    spline = curve.splines.new("POLY")
    spline.points.add(len(points) - 1)
    for corner, place in zip(spline.points, points):
        corner.co = (*place, 1.0)
    return link(bpy.data.objects.new(name, curve), collection(LIGHT_HINTS))
