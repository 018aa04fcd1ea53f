// A scene as plain data, in Blender's axes and units, with the artist's names. It is the only input of the engine,
// which uses no objects of Blender.
//
// Any program can build, save, load and render a description. It holds indices, never pointers. `validate` (validate.h)
// reports its errors before anything is built; `Scene::build` consumes it.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "description/settings.h"
#include "math/types.h"

namespace ajar {

// ---- Shader node graphs -----------------------------------------------------------

/// An output of a node; node < 0: nothing is connected.
struct NodeLink {
  int node = -1;
  std::string socket;
};

/// An input socket: its Blender identifier, the output that is linked to it, and its value without a link (a number in
/// x; colours and vectors in xyz[w]).
struct NodeInput {
  std::string socket;
  NodeLink link;
  Vec4 value{0.0f};
};

/// Data of a node that is not a socket: enums and paths as text, numbers and baked curves as numbers. Names are
/// Blender's RNA identifiers.
struct NodeProperty {
  std::string name;
  std::string text;
  std::vector<float> numbers;
};

/// `type` is Blender's bl_idname ("ShaderNodeBsdfPrincipled"). The exporter has resolved groups, reroutes and muted
/// nodes.
struct Node {
  std::string type;
  std::string name;
  std::vector<NodeInput> inputs;
  std::vector<NodeProperty> properties;
};

struct NodeGraph {
  std::vector<Node> nodes;
  NodeLink surface, volume, displacement;
  bool empty() const { return nodes.empty(); }
};

/// What the displacement of a material does.
enum class DisplacementMethod : uint8_t {
  Bump,          ///< bends the shading normals
  Displacement,  ///< moves the vertices
  Both           ///< moves the vertices, and bends the normals that the surface had before
};

struct MaterialDescription {
  std::string name;
  NodeGraph graph;
  int pass_index = 0;
  DisplacementMethod displacement_method = DisplacementMethod::Bump;
  bool transparent_shadow = true;  ///< whether light passes its transparent parts on a straight way; else it is blocked
  bool bump_map_correction = true;  ///< whether light fades softly where a bump faces it and the surface does not
};

/// How the colours and the alpha of an image are related. With the first two, an image file decides by itself whether
/// its colours are multiplied by alpha; with the last two, it does not.
enum class AlphaMode : uint8_t {
  Straight,            ///< not multiplied
  Premultiplied,       ///< multiplied
  ChannelPacked,       ///< alpha is a channel of its own
  None,                ///< alpha is 1
  AlwaysStraight,      ///< not multiplied, whatever the file says
  AlwaysPremultiplied  ///< multiplied, whatever the file says
};

/// A tile of an image: 1001 + u + 10 v covers the square from (u, v) to (u + 1, v + 1), with u from 0 to 9.
struct ImageTile {
  int number = 1001;
  int image = -1;  ///< index of an image without tiles
  bool operator==(const ImageTile&) const = default;
};

/// An image for textures. It has exactly one source: `path`, `packed` (bytes of an image file), `pixels` (float RGBA,
/// rows from the bottom up) or `tiles`. An image that has no source or cannot be read renders magenta and is reported
/// by its name, as is the place of a tile that is missing.
struct ImageDescription {
  std::string name;
  std::string path;
  std::vector<uint8_t> packed;
  std::vector<float> pixels;
  int width = 0, height = 0;  ///< of `pixels`
  /// Its name in the OpenColorIO configuration. "Non-Color" are no colours, "scene_linear" is the working space.
  std::string color_space = "sRGB";
  AlphaMode alpha_mode = AlphaMode::Straight;
  std::vector<ImageTile> tiles;
  /// The texture is halved until its longer side has at most this number of texels; 0: no limit.
  int size_limit = 0;
  /// The texture has at most this fraction of the sides of the image: 1, 1/2, 1/4 and so on.
  float resolution = 1.0f;
};

/// The meaning of the names of colour spaces, and of all colours in the scene.
struct ColorDescription {
  std::string config;                            ///< path of an OpenColorIO configuration; empty: none
  std::string working_space = "Linear Rec.709";  ///< its name in the configuration
  bool operator==(const ColorDescription&) const = default;
};

// ---- Geometry ------------------------------------------------------------------------

enum class Domain : uint8_t { Vertex, Corner, Face };

/// A named attribute: `components` floats for each element of its domain. UV maps have 2 per corner, colours 4 (linear
/// RGBA).
struct Attribute {
  std::string name;
  Domain domain = Domain::Corner;
  int components = 2;
  std::vector<float> values;
};

/// Values on voxels, which the shader of a volume reads by name. Only bricks of 8 x 8 x 8 voxels are listed; all other
/// voxels are 0. Voxel (i, j, k) has its centre at the index coordinates (i, j, k).
struct VolumeGrid {
  static constexpr int kBrick = 8;                             ///< voxels along an axis of a brick
  static constexpr size_t kVoxels = kBrick * kBrick * kBrick;  ///< of a brick
  std::string name;
  int components = 1;  ///< 1; 3: a colour or a vector; 4: a colour multiplied by the alpha that follows it
  std::array<float, 12> index_from_object{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};  ///< three rows of four
  std::vector<std::array<int, 3>> bricks;  ///< index of the first voxel of each brick, divided by 8; all different
  std::vector<float> values;               ///< of all voxels of all bricks; the first index varies fastest
};

/// How a volume flows while the shutter is open. At a time t of the shutter interval [0, 1], a place p shows what the grids
/// have at p - (t - frame) * scale * u, where u is the velocity at p - (t - frame) * scale * u(p).
struct VolumeFlow {
  std::string velocity;  ///< name of a grid with 3 components, a vector in object space; empty: nothing flows
  float scale = 0.0f;    ///< by how much of the velocity the volume moves while the shutter is open
  float frame = 0.5f;    ///< the time at which the grids are as they are
};

/// Name of the vertex attribute (3 components) that holds the positions before modifiers moved the vertices. Generated
/// coordinates follow it; without it, they follow the positions.
inline constexpr const char* kUndeformedPosition = ".undeformed_position";

/// Name of the face attribute (1 component) that is not 0 for the flat faces of a mesh with normals of corners. They stay
/// flat when a displacement moves their vertices.
inline constexpr const char* kFlatFaces = ".flat_faces";

/// Names of the vertex attributes (3 components) that hold the positions one frame before and one after, for the pass
/// Vector.
inline constexpr const char *kPositionBefore = ".position_before", *kPositionAfter = ".position_after";

enum class StrandShape : uint8_t {
  Ribbon,  ///< flat, faces each ray, shaded as if it were round
  Round,   ///< a tube
  Linear   ///< a tube of straight pieces between the points, with round joints and ends
};

enum class SubdivisionScheme : uint8_t {
  None,
  CatmullClark,  ///< the smooth surface to which repeated subdivision converges
  Simple         ///< the faces as they are
};

/// Which boundaries of a UV map stay as they are when the map is made smooth with the surface.
enum class UvSmoothing : uint8_t {
  None,  ///< the map is not smooth
  KeepCorners,
  KeepCornersAndJunctions,
  KeepCornersJunctionsAndConcave,
  KeepBoundaries,
  All  ///< the map is smooth everywhere
};

/// Adaptive subdivision: faces that are divided into triangles of about the size of a pixel when the scene is built
/// (geometry/subdivision). In a mesh with faces, there are no triangles; data per triangle are per face, and a corner is
/// one of `corner_vertices`.
struct SubdivisionDescription {
  SubdivisionScheme scheme = SubdivisionScheme::None;
  std::vector<uint32_t> face_sizes;       ///< number of corners of each face, which follow one another
  std::vector<uint32_t> corner_vertices;  ///< counter-clockwise in each face
  std::vector<uint8_t> flat_faces;        ///< whether a face is shaded flat; empty: none
  /// Sharpness as in OpenSubdiv: 0 is smooth, 10 is sharp.
  std::vector<std::array<uint32_t, 2>> creased_edges;
  std::vector<float> edge_sharpness;
  std::vector<uint32_t> creased_vertices;
  std::vector<float> vertex_sharpness;
  bool keep_corners = false;  ///< a vertex with one face is sharp
  UvSmoothing uv_smoothing = UvSmoothing::KeepBoundaries;
  bool in_pixels = true;              ///< whether `edge_length` is in pixels, not in object space
  float edge_length = 1.0f;           ///< of the triangles
  std::vector<std::string> tangents;  ///< names of the attributes of smooth tangents that the triangles get
  bool empty() const { return face_sizes.empty(); }
};

/// Triangles in object space, or strands of hair, or a point cloud, which both have no triangles. A corner is one vertex of
/// one triangle, with the index 3*t+k.
struct MeshDescription {
  std::string name;
  std::vector<Vec3> positions;
  std::vector<UVec3> triangles;
  std::vector<uint16_t> material_slots;   ///< per triangle; empty means slot 0 everywhere
  Domain normal_domain = Domain::Corner;  ///< Vertex or Corner
  std::vector<Vec3> normals;              ///< shading normals; empty means flat everywhere
  std::vector<Attribute> attributes;
  std::string active_uv;                                        ///< name of the default UV map
  Vec3 texture_space_location{0.0f}, texture_space_size{1.0f};  ///< for Generated coordinates
  /// Index of the first position of each strand, ascending from 0; a strand ends where the next one begins. In a mesh
  /// of strands, data per vertex are per point, and data per triangle or face are per strand.
  std::vector<uint32_t> strands;
  /// Of strands or of a point cloud, for each position. A mesh with radii and without strands and triangles is a point
  /// cloud: spheres around the positions. Its data per vertex, triangle or face are per point.
  std::vector<float> radii;
  StrandShape strand_shape = StrandShape::Ribbon;
  int strand_subdivisions = 2;  ///< each segment of a ribbon has 2^strand_subdivisions straight pieces
  /// Grids inside a closed mesh that encloses a volume.
  std::vector<VolumeGrid> grids;
  /// The volume keeps its optical depth when an instance is scaled: its coefficients are per unit of object space.
  bool density_in_object_space = false;
  VolumeFlow flow;
  SubdivisionDescription subdivision;
  /// The shape at evenly spaced times while the shutter is open: the positions of the first time, then those of the
  /// second, and so on; normals and radii likewise, as many for each time as in `normals` and `radii`. `positions` has
  /// the shape of the frame. Empty: the shape stays as it is.
  std::vector<Vec3> motion_positions, motion_normals;
  std::vector<float> motion_radii;
  /// If set, that mesh is used and no other field is read. A scene takes over the meshes that it shares with the one
  /// before, with their structures.
  std::shared_ptr<const MeshDescription> shared;

  bool is_points() const { return !radii.empty() && strands.empty() && triangles.empty(); }
};

/// The kinds of rays that see an object. Bits of `ObjectDescription::visibility`.
enum VisibilityBits : uint32_t {
  kVisibleCamera = 1,
  kVisibleDiffuse = 2,
  kVisibleGlossy = 4,
  kVisibleTransmission = 8,
  kVisibleVolumeScatter = 16,
  kVisibleShadow = 32,
  kVisibleAll = 63
};

/// What an emitter lights, and what casts shadows of its light (light linking and shadow linking of Blender). For each of
/// both, the objects of the scene are divided into sets; an object is in one set.
struct LightLinks {
  static constexpr int kReceiverSets = 64, kBlockerSets = 26;
  uint64_t receivers = ~uint64_t(0);  ///< bit s: lights objects whose receiver_set is s
  uint32_t blockers = ~0u;            ///< bit s: objects whose blocker_set is s block its light
  bool operator==(const LightLinks&) const = default;
};

/// A number or colour that Attribute nodes read by name, from the object or from its instancer.
struct ObjectProperty {
  std::string name;
  bool of_instancer = false;
  Vec4 value{0.0f};
  int column =
      -1;  ///< of SceneDescription::instance_values, for instances with values of their own; -1: all have `value`
};

/// The data that instances share: a mesh and the materials of its slots.
struct ObjectDescription {
  std::string name;
  int mesh = -1;
  std::vector<int> materials;  ///< per slot; -1 is the default grey
  uint32_t visibility = kVisibleAll;
  bool holdout = false, shadow_catcher = false;
  int pass_index = 0;
  Vec4 color{1.0f};  ///< Object Info > Color
  /// Importance of the pixels that show it, for adaptive sampling. The mean of the image does not depend on it.
  float importance = 1.0f;
  /// Shadow rays from smooth triangles start at the curved surface that the triangles approximate if the cosine to the
  /// light is below this value; 0: never (transport/paths/shadow_terminator.h).
  float shadow_terminator_offset = 0.0f;
  float light_importance = 1.0f;              ///< if it emits: importance of its light (render/importance_map.h)
  std::vector<ObjectProperty> properties;     ///< the properties that materials read
  uint8_t receiver_set = 0, blocker_set = 0;  ///< see LightLinks
  LightLinks links;                           ///< if it emits
  std::string asset;                          ///< its topmost parent, for Cryptomatte; empty: itself
  std::string light_group;                    ///< of the light that it emits; empty: none
};

/// Data of an instance from the instancer that placed it, for the nodes Particle Info, and Texture Coordinate and UV Map
/// with From Instancer. All numbers are 0 if the instancer does not have them.
struct InstanceOrigin {
  Vec3 generated{0.0f};  ///< Generated coordinates of the place on the instancer
  Vec2 uv{0.0f};
  // Particles; lengths in metres, times in frames:
  float index = 0.0f, age = 0.0f, lifetime = 0.0f, size = 0.0f;
  Vec3 location{0.0f}, velocity{0.0f}, angular_velocity{0.0f};
};

/// Values that instances have from attributes of the geometry that placed them: a row for each of these instances, a
/// column for each name.
struct InstanceValues {
  int columns = 0;
  std::vector<Vec4> values;
};

struct InstanceDescription {
  int object = -1;
  std::array<float, 12> world_from_object{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};  ///< three rows of four
  float random = 0.0f;                                                          ///< Object Info > Random
  /// Transforms at evenly spaced times while the shutter is open: a range of SceneDescription::motion_keys. Count 0:
  /// the instance does not move.
  int first_motion_key = 0, motion_key_count = 0;
  int origin = -1;           ///< index into SceneDescription::instance_origins; -1: all numbers are 0
  int values = -1;           ///< row of SceneDescription::instance_values; -1: it has no values of its own
  int first_frame_key = -1;  ///< index of the transforms one frame before and one after, in motion_keys; -1: the same
};

// ---- Lights, world, camera --------------------------------------------------------------

enum class LightKind : uint8_t { Point, Spot, Sun, Area };
enum class AreaShape : uint8_t { Rectangle, Ellipse };

/// A Blender lamp. It emits along its local -z. `color` * `energy` is in Blender's units: watts for point, spot and
/// area, W/m^2 for sun, with the same meaning as in Cycles.
struct LightDescription {
  std::string name;
  LightKind kind = LightKind::Point;
  std::array<float, 12> world_from_light{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  Color color{1.0f};
  float energy = 1.0f;
  float radius = 0.0f;                               ///< point, spot: of the sphere, in metres
  float spot_angle = 0.785398f, spot_blend = 0.15f;  ///< full angle in radians
  float sun_angle = 0.0f;                            ///< full angle in radians
  AreaShape area_shape = AreaShape::Rectangle;
  Vec2 area_size{1.0f};  ///< full extents along local x and y
  float spread = kPi;    ///< area: full angle of the beam
  NodeGraph graph;       ///< optional; its Emission multiplies the emission of the lamp
  uint32_t visibility = kVisibleAll;
  bool cast_shadow = true, multiple_importance = true;
  float light_importance = 1.0f;  ///< see ObjectDescription
  /// spot: the intensity does not fall with the cosine to the axis, and the cone has the scale of the lamp
  bool even_spot = false;
  bool
      even_sun = false;  ///< sun: the same radiance everywhere in its cone; otherwise 1 / cos^3 (lights/sources/lamp.h)
  /// Coordinates in its nodes: whether UV exists, and whether Object and Generated are in its space, not the world's.
  bool has_uv = false, own_coordinates = false;
  bool soft_falloff = false;  ///< point, spot: a disk that faces the lit point instead of the sphere
  LightLinks links;
  int max_bounces = 1024;   ///< after more bounces, the light is not sampled any more, as in Cycles
  std::string light_group;  ///< empty: none
};

struct WorldDescription {
  std::string name;
  NodeGraph graph;  ///< empty: `color` in all directions
  Color color{0.0f};
  uint32_t visibility = kVisibleAll;
  float light_importance = 1.0f;  ///< see ObjectDescription
  int max_bounces = 1024;         ///< see LightDescription
  std::string light_group;        ///< empty: none
};

enum class CameraKind : uint8_t {
  Perspective,
  Orthographic,
  Panorama,
  Texels  ///< each pixel of the film sees its own place on a surface, for baking
};
enum class PanoramaKind : uint8_t {
  Equirectangular,
  FisheyeEquidistant,
  FisheyeEquisolid,
  FisheyePolynomial,
  MirrorBall,
  CubemapFace
};

/// The map of a panoramic camera from directions to its film (geometry/panorama.h).
struct PanoramaDescription {
  PanoramaKind kind = PanoramaKind::Equirectangular;
  /// Equirectangular: minimum and maximum longitude, minimum and maximum latitude, in radians.
  Vec4 limits{-kPi, kPi, -0.5f * kPi, 0.5f * kPi};
  float fisheye_fov = kPi;     ///< full angle in radians
  float fisheye_lens = 10.5f;  ///< equisolid: focal length in mm
  Vec2 sensor{36.0f, 24.0f};   ///< equisolid, polynomial: in mm
  /// Angle from the axis in radians = -sum of k_i r^i, with r in mm from the centre of the sensor.
  std::array<float, 5> polynomial{};
  bool operator==(const PanoramaDescription&) const = default;
};

/// The place that a pixel of the film sees, with CameraKind::Texels.
struct Texel {
  bool shown = false;                    ///< false: the pixel sees nothing
  std::array<Vec3, 3> corners{}, eye{};  ///< of a triangle, in world space; unit directions to the eye at its corners
  Vec2 barycentric{0.0f};                ///< of the first two corners, in the middle of the pixel
  Vec2 dx{0.0f}, dy{0.0f};               ///< how they change to the next pixel along x and y
  bool operator==(const Texel&) const = default;
};

/// The camera looks along its local -z with +y up. With CameraKind::Texels, its transform and screen_window only give
/// nodes a camera: an orthographic one, whose pixels are as wide as the texels.
/// Spherical stereoscopy: each ray starts at the eye, beside the camera and perpendicular to the ray.
struct StereoDescription {
  float offset = 0.0f;       ///< of the eye to the right of the centre, in metres; 0: no stereoscopy
  float convergence = 0.0f;  ///< distance at which the rays of both eyes meet; 0: they are parallel
  /// Angles above and below the horizon, in radians, between which both eyes move to the centre; `merge_to` 0: they stay.
  float merge_from = 0.0f, merge_to = 0.0f;
  bool operator==(const StereoDescription&) const = default;
};

struct CameraDescription {
  std::string name;
  bool present = false;
  CameraKind kind = CameraKind::Perspective;
  std::array<float, 12> world_from_camera{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  /// Left, right, bottom, top on the plane z = -1; in metres for orthographic cameras; 0, 1, 0, 1 for a whole panorama.
  Vec4 screen_window{-1, 1, -0.75f, 0.75f};
  float clip_start = 0.1f, clip_end = 1000.0f;
  float aperture_radius = 0.0f, focus_distance = 10.0f;
  int blades = 0;
  float blade_rotation = 0.0f, aperture_ratio = 1.0f;
  PanoramaDescription panorama;
  /// world_from_camera at evenly spaced times while the shutter is open; empty: the camera does not move.
  std::vector<std::array<float, 12>> motion;
  /// Times in [0, 1] at which equal shares of the light have arrived; the first is 0 and the last is 1. Empty: the
  /// shutter opens and closes instantly.
  std::vector<float> shutter;
  std::vector<Texel> texels;  ///< for each pixel of the film, rows from the bottom up; scene files do not store them
  /// world_from_camera one frame before and one after, for the pass Vector; empty: the camera does not move.
  std::vector<std::array<float, 12>> frames;
  /// screen_window at evenly spaced times while the shutter is open; empty: it does not change.
  std::vector<Vec4> window_motion;
  /// Rolling shutter: the part of the shutter interval while which one row of pixels is exposed. The top row begins
  /// first, and the bottom row ends last. 1: all rows are exposed together.
  float row_exposure = 1.0f;
  StereoDescription stereo;
  bool operator==(const CameraDescription&) const = default;
};

// ---- Hints --------------------------------------------------------------------------------

/// A curve drawn by the artist: from a light, over the surfaces on which light should bounce, to something that the
/// camera sees. It only adds proposals; transport/hints/hints.h describes how its points are attached.
struct HintDescription {
  std::string name;
  std::vector<Vec3> points;    ///< in world space; the first is near a light
  std::vector<float> spreads;  ///< half-angle of the cone of each segment in radians; `spread` replaces missing ones
  float spread = 0.0872665f, weight = 1.0f;
  bool enabled = true;
};

/// What adaptive subdivision of all meshes follows.
struct DicingDescription {
  CameraDescription camera;      ///< whose pixels count; not present: that of the scene
  float offscreen_scale = 4.0f;  ///< how much coarser surfaces become with the distance from the field of view
  int max_subdivisions = 12;     ///< an edge of a face has at most 2^max_subdivisions pieces
};

struct SceneDescription {
  std::vector<MeshDescription> meshes;
  std::vector<ObjectDescription> objects;
  std::vector<InstanceDescription> instances;
  std::vector<std::array<float, 12>> motion_keys;
  std::vector<InstanceOrigin> instance_origins;  ///< only if a material reads them
  InstanceValues instance_values;                ///< likewise
  std::vector<MaterialDescription> materials;
  std::vector<ImageDescription> images;
  ColorDescription color;
  std::vector<LightDescription> lights;
  WorldDescription world;
  CameraDescription camera;
  std::vector<HintDescription> hints;
  DicingDescription dicing;
  RenderSettings settings;
};

/// Whether the instance is a shadow catcher.
inline bool is_catcher(const SceneDescription& d, const InstanceDescription& instance) {
  return instance.object >= 0 && size_t(instance.object) < d.objects.size() &&
         d.objects[size_t(instance.object)].shadow_catcher;
}
/// Whether there are shadow catchers.
inline bool has_catchers(const SceneDescription& d) {
  for (const InstanceDescription& instance : d.instances)
    if (is_catcher(d, instance)) return true;
  return false;
}

/// Rows of a 3x4 affine transform as a matrix.
inline Mat4 to_matrix(const std::array<float, 12>& rows) {
  return Mat4(Vec4(rows[0], rows[4], rows[8], 0.0f), Vec4(rows[1], rows[5], rows[9], 0.0f),
              Vec4(rows[2], rows[6], rows[10], 0.0f), Vec4(rows[3], rows[7], rows[11], 1.0f));
}

}  // namespace ajar
