#include "description/archive.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <type_traits>

#include "description/diagnostics.h"
#include "description/settings_table.h"
#include "platform/atomic_file.h"
#include "platform/platform.h"

namespace ajar {

namespace {

constexpr char kMagic[] = {'A', 'J', 'A', 'R', 'S', 'C', 'N', 'T'};
constexpr char kOldestVersion = '2';

/// Types that are stored as their bytes.
template <class T>
struct IsPlain : std::bool_constant<std::is_arithmetic_v<T> || std::is_enum_v<T>> {};
template <>
struct IsPlain<Vec2> : std::true_type {};
template <>
struct IsPlain<Vec3> : std::true_type {};
template <>
struct IsPlain<Vec4> : std::true_type {};
template <>
struct IsPlain<UVec3> : std::true_type {};
template <class T, size_t N>
struct IsPlain<std::array<T, N>> : IsPlain<T> {};

class Writer {
 public:
  char version = kMagic[7];
  bool has(char since) const { return version >= since; }
  std::vector<char> bytes;
  void raw(const void* data, size_t size) {
    const char* begin = static_cast<const char*>(data);
    bytes.insert(bytes.end(), begin, begin + size);
  }
  template <class T>
  void count(const T& container) {
    const uint64_t n = container.size();
    raw(&n, sizeof n);
  }
  template <class T>
  void resize(T& container, size_t) {
    count(container);
  }
};

/// Receives the bytes that a Writer would write and keeps a 64-bit hash of them.
class Hasher {
 public:
  bool has(char) const { return true; }
  uint64_t state = 0x9e3779b97f4a7c15u;
  void raw(const void* data, size_t size) {
    const char* bytes = static_cast<const char*>(data);
    for (; size > 0; size -= std::min<size_t>(size, 8), bytes += 8) {
      uint64_t word = size;
      std::memcpy(&word, bytes, std::min<size_t>(size, 8));
      // The finalizer of MurmurHash3 between words.
      state = (state ^ word) * 0xff51afd7ed558ccdu;
      state = (state ^ (state >> 33)) * 0xc4ceb9fe1a85ec53u;
      state ^= state >> 33;
    }
  }
  template <class T>
  void resize(T& container, size_t) {
    const uint64_t n = container.size();
    raw(&n, sizeof n);
  }
};

/// Counts the minimum number of bytes of a value: the oldest version, with every list empty.
class MinimumSize {
 public:
  bool has(char) const { return false; }
  size_t bytes = 0;
  void raw(const void*, size_t size) { bytes += size; }
  template <class T>
  void resize(T& container, size_t) {
    container.clear();
    bytes += sizeof(uint64_t);
  }
};

class Reader {
 public:
  explicit Reader(const std::vector<char>& bytes) : bytes_(bytes) {}
  char version = kMagic[7];
  /// Whether the file has the fields that this version added. Missing fields keep their defaults.
  bool has(char since) const { return version >= since; }
  void raw(void* data, size_t size) {
    if (size > bytes_.size() - position_) throw SceneError("The scene file ends too early.");
    std::memcpy(data, bytes_.data() + position_, size);
    position_ += size;
  }
  template <class T>
  void resize(T& container, size_t min_bytes_each) {
    uint64_t n;
    raw(&n, sizeof n);
    if (n > (bytes_.size() - position_) / min_bytes_each) throw SceneError("The scene file is damaged.");
    container.resize(n);
  }
  bool at_end() const { return position_ == bytes_.size(); }

 private:
  const std::vector<char>& bytes_;
  size_t position_ = 0;
};

template <class A, class T>
void visit(A& a, T& value);

/// Minimum number of bytes of an element in a file; exact for types that are stored as their bytes.
template <class T>
size_t min_bytes() {
  if constexpr (IsPlain<T>::value) {
    return sizeof(T);
  } else {
    static const size_t bytes = [] {
      MinimumSize minimum;
      T value;
      visit(minimum, value);
      return minimum.bytes;
    }();
    return bytes;
  }
}

template <class A, class T>
void visit(A& a, std::vector<T>& values) {
  a.resize(values, min_bytes<T>());
  if constexpr (IsPlain<T>::value) {
    if (!values.empty()) a.raw(values.data(), values.size() * sizeof(T));
  } else {
    for (T& value : values) visit(a, value);
  }
}
template <class A>
void visit(A& a, std::string& text) {
  a.resize(text, 1);
  if (!text.empty()) a.raw(text.data(), text.size());
}
/// A byte that is neither 0 nor 1 must not be copied into a bool.
template <class A>
void visit(A& a, bool& value) {
  uint8_t byte = value;
  a.raw(&byte, 1);
  value = byte != 0;
}
/// A choice among the settings: by its name if it is known by that.
template <class A, class E>
void visit_choice(A& a, E& value) {
  if constexpr (kKnownByName<E>) {
    std::string name = name_of(value);
    visit(a, name);
    if constexpr (std::is_same_v<A, Reader>) value = choice_named<E>(name);
  } else {
    visit(a, value);
  }
}

template <class A, class... T>
void all(A& a, T&... values) {
  (visit(a, values), ...);
}

template <class A>
void fields(A& a, NodeLink& v) {
  all(a, v.node, v.socket);
}
template <class A>
void fields(A& a, NodeInput& v) {
  all(a, v.socket, v.link, v.value);
}
template <class A>
void fields(A& a, NodeProperty& v) {
  all(a, v.name, v.text, v.numbers);
}
template <class A>
void fields(A& a, Node& v) {
  all(a, v.type, v.name, v.inputs, v.properties);
}
template <class A>
void fields(A& a, NodeGraph& v) {
  all(a, v.nodes, v.surface, v.volume, v.displacement);
}
template <class A>
void fields(A& a, MaterialDescription& v) {
  all(a, v.name, v.graph, v.pass_index);
  if (a.has('H')) all(a, v.displacement_method);
  if (a.has('L')) all(a, v.transparent_shadow, v.bump_map_correction);
}
template <class A>
void fields(A& a, ImageTile& v) {
  all(a, v.number, v.image);
}
template <class A>
void fields(A& a, ImageDescription& v) {
  all(a, v.name, v.path, v.packed, v.pixels, v.width, v.height, v.color_space, v.alpha_mode);
  if (a.has('E')) visit(a, v.tiles);
  if (a.has('M')) all(a, v.size_limit, v.resolution);
}
template <class A>
void fields(A& a, ColorDescription& v) {
  all(a, v.config, v.working_space);
}
template <class A>
void fields(A& a, Attribute& v) {
  all(a, v.name, v.domain, v.components, v.values);
}
template <class A>
void fields(A& a, VolumeGrid& v) {
  all(a, v.name, v.components, v.index_from_object, v.bricks, v.values);
}
template <class A>
void fields(A& a, VolumeFlow& v) {
  all(a, v.velocity, v.scale, v.frame);
}
template <class A>
void fields(A& a, SubdivisionDescription& v) {
  all(a, v.scheme, v.face_sizes, v.corner_vertices, v.flat_faces, v.creased_edges, v.edge_sharpness, v.creased_vertices,
      v.vertex_sharpness, v.keep_corners, v.uv_smoothing, v.in_pixels, v.edge_length, v.tangents);
}
template <class A>
void fields(A& a, MeshDescription& mesh) {
  if constexpr (std::is_same_v<A, Hasher>) {
    const MeshDescription* shared = mesh.shared.get();
    a.raw(&shared, sizeof shared);
    if (shared) return;
  }
  // A shared mesh is only written, and writing changes nothing.
  MeshDescription& v = mesh.shared ? const_cast<MeshDescription&>(*mesh.shared) : mesh;
  all(a, v.name, v.positions, v.triangles, v.material_slots, v.normal_domain, v.normals, v.attributes, v.active_uv,
      v.texture_space_location, v.texture_space_size);
  if (a.has('B')) all(a, v.strands, v.radii, v.strand_shape, v.strand_subdivisions);
  if (a.has('G')) all(a, v.grids, v.density_in_object_space);
  if (a.has('I')) visit(a, v.subdivision);
  if (a.has('L')) all(a, v.motion_positions, v.motion_normals, v.motion_radii);
  if (a.has('T')) visit(a, v.flow);
}
template <class A>
void fields(A& a, ObjectProperty& v) {
  all(a, v.name, v.of_instancer, v.value);
  if (a.has('R')) visit(a, v.column);
}
template <class A>
void fields(A& a, LightLinks& v) {
  all(a, v.receivers, v.blockers);
}
template <class A>
void fields(A& a, ObjectDescription& v) {
  all(a, v.name, v.mesh, v.materials, v.visibility, v.holdout, v.shadow_catcher, v.pass_index, v.color);
  if (a.has('3')) visit(a, v.importance);
  if (a.has('4')) visit(a, v.shadow_terminator_offset);
  if (a.has('9')) visit(a, v.light_importance);
  if (a.has('A')) visit(a, v.properties);
  if (a.has('J')) all(a, v.receiver_set, v.blocker_set, v.links);
  if (a.has('K')) all(a, v.asset, v.light_group);
}
template <class A>
void fields(A& a, InstanceOrigin& v) {
  all(a, v.generated, v.uv, v.index, v.age, v.lifetime, v.size, v.location, v.velocity, v.angular_velocity);
}
template <class A>
void fields(A& a, InstanceValues& v) {
  all(a, v.columns, v.values);
}
template <class A>
void fields(A& a, InstanceDescription& v) {
  all(a, v.object, v.world_from_object, v.random);
  if (a.has('6')) all(a, v.first_motion_key, v.motion_key_count);
  if (a.has('F')) visit(a, v.origin);
  if (a.has('K')) visit(a, v.first_frame_key);
  if (a.has('R')) visit(a, v.values);
}
template <class A>
void fields(A& a, LightDescription& v) {
  all(a, v.name, v.kind, v.world_from_light, v.color, v.energy, v.radius, v.spot_angle, v.spot_blend, v.sun_angle,
      v.area_shape, v.area_size, v.spread, v.graph, v.visibility, v.cast_shadow, v.multiple_importance);
  if (a.has('9')) visit(a, v.light_importance);
  if (a.has('E')) all(a, v.soft_falloff, v.even_spot);
  if (a.has('J')) all(a, v.links, v.max_bounces);
  if (a.has('K')) visit(a, v.light_group);
  if (a.has('P')) visit(a, v.even_sun);
  if (a.has('S')) all(a, v.has_uv, v.own_coordinates);
}
template <class A>
void fields(A& a, WorldDescription& v) {
  all(a, v.name, v.graph, v.color, v.visibility);
  if (a.has('9')) visit(a, v.light_importance);
  if (a.has('J')) visit(a, v.max_bounces);
  if (a.has('K')) visit(a, v.light_group);
}
template <class A>
void fields(A& a, PanoramaDescription& v) {
  all(a, v.kind, v.limits, v.fisheye_fov, v.fisheye_lens, v.sensor, v.polynomial);
}
template <class A>
void fields(A& a, StereoDescription& v) {
  all(a, v.offset, v.convergence, v.merge_from, v.merge_to);
}
template <class A>
void fields(A& a, CameraDescription& v) {
  all(a, v.name, v.present, v.kind, v.world_from_camera, v.screen_window, v.clip_start, v.clip_end, v.aperture_radius,
      v.focus_distance, v.blades, v.blade_rotation, v.aperture_ratio);
  if (a.has('4')) visit(a, v.panorama);
  if (a.has('6')) all(a, v.motion, v.shutter);
  if (a.has('K')) visit(a, v.frames);
  if (a.has('L')) all(a, v.window_motion, v.row_exposure);
  if (a.has('M')) visit(a, v.stereo);
}
template <class A>
void fields(A& a, DicingDescription& v) {
  all(a, v.camera, v.offscreen_scale, v.max_subdivisions);
}
template <class A, class Struct>
void visit_settings(A& a, Struct& v) {
  for (const Setting<Struct>& row : setting_table<Struct>()) {
    if (!a.has(row.since)) continue;
    const auto visit_field = [&a]<class T>(T* field) {
      if constexpr (std::is_enum_v<T>)
        visit_choice(a, *field);
      else
        visit(a, *field);
    };
    std::visit(visit_field, row.field(v));
  }
}
template <class A>
void fields(A& a, BounceLimits& v) {
  visit_settings(a, v);
}
template <class A>
void fields(A& a, MistDescription& v) {
  all(a, v.start, v.depth, v.exponent);
}
template <class A>
void fields(A& a, RenderSettings& v) {
  visit_settings(a, v);
}
template <class A>
void fields(A& a, HintDescription& v) {
  all(a, v.name, v.points, v.spreads, v.spread, v.weight, v.enabled);
}
template <class A>
void fields(A& a, SceneDescription& v) {
  all(a, v.meshes, v.objects, v.instances, v.materials, v.images, v.lights, v.world, v.camera, v.hints, v.settings);
  if (a.has('6')) visit(a, v.motion_keys);
  if (a.has('E')) visit(a, v.color);
  if (a.has('F')) visit(a, v.instance_origins);
  if (a.has('I')) visit(a, v.dicing);
  if (a.has('R')) visit(a, v.instance_values);
}

template <class A, class T>
void visit(A& a, T& value) {
  if constexpr (IsPlain<T>::value) {
    a.raw(&value, sizeof(T));
  } else {
    fields(a, value);
  }
}

/// A file stores enums as bytes; a value outside the list is refused.
template <class E>
void check_enum(E value, E last) {
  if (uint8_t(value) > uint8_t(last)) throw SceneError("The scene file is damaged.");
}

void check_enums(const SceneDescription& d) {
  for (const MeshDescription& mesh : d.meshes) {
    check_enum(mesh.normal_domain, Domain::Face);
    check_enum(mesh.strand_shape, StrandShape::Linear);
    check_enum(mesh.subdivision.scheme, SubdivisionScheme::Simple);
    check_enum(mesh.subdivision.uv_smoothing, UvSmoothing::All);
    for (const Attribute& attribute : mesh.attributes) check_enum(attribute.domain, Domain::Face);
  }
  for (const MaterialDescription& material : d.materials)
    check_enum(material.displacement_method, DisplacementMethod::Both);
  for (const ImageDescription& image : d.images) check_enum(image.alpha_mode, AlphaMode::AlwaysPremultiplied);
  for (const LightDescription& light : d.lights) {
    check_enum(light.kind, LightKind::Area);
    check_enum(light.area_shape, AreaShape::Ellipse);
  }
  check_enum(d.camera.kind, CameraKind::Panorama);
  check_enum(d.camera.panorama.kind, PanoramaKind::CubemapFace);
  check_enum(d.dicing.camera.kind, CameraKind::Panorama);
  check_enum(d.dicing.camera.panorama.kind, PanoramaKind::CubemapFace);
  check_enum(d.settings.filter, FilterKind::BlackmanHarris);
  check_enum(d.settings.bump_terminator, BumpTerminator::Microfacet);
}

}  // namespace

uint64_t fingerprint(const SceneDescription& description) {
  Hasher hasher;
  auto& d = const_cast<SceneDescription&>(description);
  all(hasher, d.meshes, d.objects, d.instances, d.motion_keys, d.instance_origins, d.instance_values, d.materials,
      d.images, d.color, d.lights, d.world, d.hints, d.dicing, d.settings.reflective_caustics,
      d.settings.refractive_caustics, d.settings.bump_terminator);
  return hasher.state;
}

uint64_t view_fingerprint(const CameraDescription& camera, const RenderSettings& settings) {
  Hasher hasher;
  auto& c = const_cast<CameraDescription&>(camera);
  auto& s = const_cast<RenderSettings&>(settings);
  all(hasher, c, s.filter, s.filter_width, s.transparent_film, s.bounces, s.clamp_direct, s.clamp_indirect, s.mist,
      s.pass_alpha_threshold, s.ao_distance);
  if (s.texture_cache) visit(hasher, s.texture_cache);  // far surfaces show means of texels
  return hasher.state;
}

uint64_t fingerprint(const NodeGraph& graph) {
  Hasher hasher;
  visit(hasher, const_cast<NodeGraph&>(graph));
  return hasher.state;
}

uint64_t fingerprint(const ColorDescription& color) {
  Hasher hasher;
  visit(hasher, const_cast<ColorDescription&>(color));
  return hasher.state;
}

uint64_t fingerprint(const MaterialDescription& material) {
  Hasher hasher;
  visit(hasher, const_cast<MaterialDescription&>(material));
  return hasher.state;
}

std::vector<char> to_bytes(const SceneDescription& description, char version) {
  Writer writer;
  if (version != 0) writer.version = version;
  writer.raw(kMagic, sizeof kMagic);
  // The visitor takes mutable references, because it also reads; writing changes nothing.
  visit(writer, const_cast<SceneDescription&>(description));
  writer.bytes[7] = writer.version;
  return std::move(writer.bytes);
}

SceneDescription from_bytes(const std::vector<char>& bytes) {
  Reader reader(bytes);
  char magic[sizeof kMagic];
  reader.raw(magic, sizeof magic);
  if (std::memcmp(magic, kMagic, sizeof magic - 1) != 0 || magic[7] < kOldestVersion || magic[7] > kMagic[7])
    throw SceneError("This is not an Ajar scene file, or one of another version.");
  reader.version = magic[7];
  SceneDescription description;
  visit(reader, description);
  if (!reader.at_end()) throw SceneError("The scene file is damaged.");
  check_enums(description);
  return description;
}

void save_description(const SceneDescription& description, const std::string& path) {
  const std::vector<char> bytes = to_bytes(description);
  AtomicFile file(path);
  file.write(bytes.data(), bytes.size());
  if (const std::string why = file.commit(); !why.empty())
    throw SceneError("Cannot write the scene file '" + path + "': " + why + ".");
}

SceneDescription load_description(const std::string& path) {
  std::ifstream file(platform::file_path(path), std::ios::binary | std::ios::ate);
  if (!file) throw SceneError("Cannot open the scene file '" + path + "'.");
  const std::streamoff size = file.tellg();
  file.seekg(0);
  // The size of a folder or a pipe has no meaning.
  std::error_code unknown;
  if (!file || !std::filesystem::is_regular_file(platform::file_path(path), unknown))
    throw SceneError("Cannot read the scene file '" + path + "'.");
  std::vector<char> bytes(static_cast<size_t>(size));
  file.read(bytes.data(), size);
  if (!file) throw SceneError("Cannot read the scene file '" + path + "'.");
  return from_bytes(bytes);
}

}  // namespace ajar
