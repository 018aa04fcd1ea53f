#include "description/validate.h"

#include <algorithm>
#include <cmath>

#include "description/settings_table.h"
#include "description/validate_curves.h"

namespace ajar {

namespace {

using Severity = Diagnostic::Severity;

template <class Container>
uint64_t replace_non_finite(Container& values, float replacement) {
  uint64_t replaced = 0;
  for (float& value : values) {
    if (!std::isfinite(value)) {
      value = replacement;
      ++replaced;
    }
  }
  return replaced;
}

/// Replaces components that are not finite by 0.
template <class Vector>
void mend(Vector& v) {
  for (int i = 0; i < Vector::length(); ++i) v[i] = std::isfinite(v[i]) ? v[i] : 0.0f;
}

/// Number of elements that an attribute must have in its domain.
size_t domain_size(const MeshDescription& mesh, Domain domain) {
  if (!mesh.subdivision.empty() && domain != Domain::Vertex)
    return domain == Domain::Face ? mesh.subdivision.face_sizes.size() : mesh.subdivision.corner_vertices.size();
  switch (domain) {
    case Domain::Vertex: return mesh.positions.size();
    case Domain::Corner: return mesh.triangles.size() * 3;
    case Domain::Face:
      return mesh.is_points()       ? mesh.positions.size()
             : mesh.strands.empty() ? mesh.triangles.size()
                                    : mesh.strands.size();
  }
  return 0;
}

/// Removes triangles from every per-triangle and per-corner array; `keep` has one flag for each triangle.
void compact_triangles(MeshDescription& mesh, const std::vector<uint8_t>& keep) {
  const auto compact = [&](auto& array, size_t per_triangle) {
    if (array.empty()) return;
    size_t out = 0;
    for (size_t t = 0; t < keep.size(); ++t) {
      if (!keep[t]) continue;
      for (size_t k = 0; k < per_triangle; ++k) array[out++] = array[t * per_triangle + k];
    }
    array.resize(out);
  };
  for (Attribute& attribute : mesh.attributes) {
    if (attribute.domain == Domain::Corner) compact(attribute.values, 3 * size_t(attribute.components));
    if (attribute.domain == Domain::Face) compact(attribute.values, size_t(attribute.components));
  }
  if (mesh.normal_domain == Domain::Corner) compact(mesh.normals, 3);
  compact(mesh.material_slots, 1);
  compact(mesh.triangles, 1);
}

}  // namespace

uint64_t validate_attributes(MeshDescription& mesh, Diagnostics& diagnostics) {
  std::erase_if(mesh.attributes, [&](const Attribute& attribute) {
    const bool bad = attribute.components < 1 || attribute.components > 4 ||
                     (attribute.domain == Domain::Corner && (mesh.is_points() || !mesh.strands.empty())) ||
                     attribute.values.size() != domain_size(mesh, attribute.domain) * size_t(attribute.components);
    if (bad)
      report_once(diagnostics, {Severity::Warning, mesh.name,
                                "Attribute '" + attribute.name + "' does not match the mesh and is ignored."});
    return bad;
  });
  uint64_t repaired = 0;
  for (Attribute& attribute : mesh.attributes) repaired += replace_non_finite(attribute.values, 0.0f);
  return repaired;
}

namespace {

/// Removes grids that are damaged. Returns the number of replaced values in the others.
uint64_t validate_grids(MeshDescription& mesh, Diagnostics& diagnostics) {
  constexpr int64_t kFarthestBrick = 1 << 26;  // the indices of voxels stay below those of VoxelGrid::at
  std::erase_if(mesh.grids, [&](const VolumeGrid& grid) {
    const auto known = [&](const VolumeGrid& other) { return &other < &grid && other.name == grid.name; };
    const auto near = [](std::array<int, 3> brick) {
      return std::all_of(brick.begin(), brick.end(), [](int x) { return std::abs(int64_t(x)) < kFarthestBrick; });
    };
    std::vector<std::array<int, 3>> sorted = grid.bricks;
    std::sort(sorted.begin(), sorted.end());
    const Mat4 matrix = to_matrix(grid.index_from_object);
    const float determinant = glm::determinant(Mat3(matrix));
    const bool good = (grid.components == 1 || grid.components == 3 || grid.components == 4) &&
                      grid.values.size() == grid.bricks.size() * VolumeGrid::kVoxels * size_t(grid.components) &&
                      std::all_of(grid.bricks.begin(), grid.bricks.end(), near) &&
                      std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end() && std::isfinite(determinant) &&
                      determinant != 0.0f && is_finite(Vec3(matrix[3])) &&
                      std::none_of(mesh.grids.begin(), mesh.grids.end(), known);
    if (!good)
      report_once(diagnostics, {Severity::Warning, mesh.name, "Grid '" + grid.name + "' is damaged and is ignored."});
    return !good;
  });
  uint64_t repaired = 0;
  for (VolumeGrid& grid : mesh.grids) repaired += replace_non_finite(grid.values, 0.0f);
  const VolumeFlow& flow = mesh.flow;
  const auto gives_velocity = [&](const VolumeGrid& grid) {
    return grid.name == flow.velocity && grid.components == 3;
  };
  if (!flow.velocity.empty() && (!std::isfinite(flow.scale) || !(flow.frame >= 0.0f && flow.frame <= 1.0f) ||
                                 std::none_of(mesh.grids.begin(), mesh.grids.end(), gives_velocity))) {
    report_once(diagnostics, {Severity::Warning, mesh.name, "Its velocity is damaged; its motion is not blurred."});
    mesh.flow = VolumeFlow();
  }
  return repaired;
}

/// Removes faces from every array per face and per corner; `keep` has one flag for each face.
void compact_faces(MeshDescription& mesh, const std::vector<uint8_t>& keep) {
  SubdivisionDescription& s = mesh.subdivision;
  const std::vector<uint32_t> sizes = s.face_sizes;
  const auto compact = [&](auto& array, bool per_corner, size_t each) {
    size_t in = 0, out = 0;
    for (size_t f = 0; f < keep.size() && !array.empty(); ++f) {
      const size_t count = each * (per_corner ? sizes[f] : 1);
      for (size_t k = 0; keep[f] && k < count; ++k) array[out++] = array[in + k];
      in += count;
    }
    array.resize(out);
  };
  for (Attribute& attribute : mesh.attributes)
    if (attribute.domain != Domain::Vertex)
      compact(attribute.values, attribute.domain == Domain::Corner, size_t(attribute.components));
  if (mesh.normal_domain == Domain::Corner) compact(mesh.normals, true, 1);
  compact(mesh.material_slots, false, 1);
  compact(s.flat_faces, false, 1);
  compact(s.corner_vertices, true, 1);
  compact(s.face_sizes, false, 1);
}

/// Removes creases that the mesh does not have, and brings the others into their range.
template <class Element, class Known>
void validate_creases(std::vector<Element>& elements, std::vector<float>& sharpness, const Known& known) {
  constexpr float kSharpest = 10.0f;
  sharpness.resize(elements.size(), 0.0f);
  size_t out = 0;
  for (size_t i = 0; i < elements.size(); ++i) {
    if (!known(elements[i]) || !(sharpness[i] > 0.0f)) continue;
    elements[out] = elements[i];
    sharpness[out++] = std::min(sharpness[i], kSharpest);
  }
  elements.resize(out);
  sharpness.resize(out);
}

/// A mesh for adaptive subdivision.
void validate_faces(MeshDescription& mesh, ValidationCounts& counts, Diagnostics& diagnostics) {
  const auto warn = [&](const std::string& text) { report_once(diagnostics, {Severity::Warning, mesh.name, text}); };
  SubdivisionDescription& s = mesh.subdivision;
  const size_t faces = s.face_sizes.size(), vertices = mesh.positions.size();
  uint64_t corners = 0;
  for (const uint32_t size : s.face_sizes) corners += size;
  if (corners != s.corner_vertices.size() || corners > 0x7fffffffu || !mesh.triangles.empty()) {
    warn("The corners do not match the faces; the mesh is left out.");
    const std::string name = mesh.name;
    mesh = MeshDescription();
    mesh.name = name;
    return;
  }
  if (mesh.material_slots.size() != faces) mesh.material_slots.clear();
  if (s.flat_faces.size() != faces) s.flat_faces.clear();
  if (mesh.normal_domain == Domain::Face || mesh.normals.size() != domain_size(mesh, mesh.normal_domain))
    mesh.normals.clear();
  for (Vec3& n : mesh.normals)
    if (!is_finite(n)) n = Vec3(0.0f);
  if (!(s.edge_length > 0.0f) || !std::isfinite(s.edge_length)) s.edge_length = 1.0f;
  const uint64_t repaired = validate_attributes(mesh, diagnostics);
  if (repaired > 0) warn(count_of(repaired, "invalid normal or attribute value") + " replaced.");
  counts.repaired_values += repaired;
  constexpr float kFarthest = 1e18f;
  std::vector<uint8_t> bad_vertex(vertices, 0), keep(faces, 1);
  for (size_t v = 0; v < vertices; ++v) {
    bad_vertex[v] = !is_finite(mesh.positions[v]) || max_component(glm::abs(mesh.positions[v])) > kFarthest;
    if (bad_vertex[v]) mesh.positions[v] = Vec3(0.0f);
  }
  uint64_t bad_faces = 0;
  std::vector<uint32_t> sorted;
  for (size_t f = 0, first = 0; f < faces; first += s.face_sizes[f++]) {
    sorted.assign(s.corner_vertices.begin() + ptrdiff_t(first),
                  s.corner_vertices.begin() + ptrdiff_t(first + s.face_sizes[f]));
    std::sort(sorted.begin(), sorted.end());
    const bool bad = sorted.size() < 3 || sorted.back() >= vertices ||
                     std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end() ||
                     std::any_of(sorted.begin(), sorted.end(), [&](uint32_t v) { return bad_vertex[v] != 0; });
    keep[f] = !bad;
    bad_faces += bad;
  }
  if (bad_faces > 0) {
    warn(count_of(bad_faces, "face") + " with invalid vertices left out.");
    compact_faces(mesh, keep);
  }
  counts.skipped_triangles += bad_faces;
  validate_creases(s.creased_edges, s.edge_sharpness,
                   [&](const auto& edge) { return edge[0] < vertices && edge[1] < vertices && edge[0] != edge[1]; });
  validate_creases(s.creased_vertices, s.vertex_sharpness, [&](uint32_t v) { return v < vertices; });
}

void validate_shape(MeshDescription& mesh, ValidationCounts& counts, Diagnostics& diagnostics) {
  if (!mesh.strands.empty()) {
    mesh.subdivision = {};
    validate_strands(mesh, counts, diagnostics);
    return;
  }
  if (mesh.is_points()) {
    validate_points(mesh, counts, diagnostics);
    return;
  }
  if (mesh.subdivision.scheme == SubdivisionScheme::None) mesh.subdivision = {};
  if (!mesh.subdivision.empty()) {
    validate_faces(mesh, counts, diagnostics);
    return;
  }
  mesh.radii.clear();
  const size_t triangle_count = mesh.triangles.size();
  const auto warn = [&](const std::string& text) { report_once(diagnostics, {Severity::Warning, mesh.name, text}); };

  // Arrays of the wrong length cannot be trusted.
  if (!mesh.material_slots.empty() && mesh.material_slots.size() != triangle_count) {
    warn("Material slots do not match the triangles; slot 0 is used everywhere.");
    mesh.material_slots.clear();
  }
  if (!mesh.normals.empty() &&
      (mesh.normal_domain == Domain::Face || mesh.normals.size() != domain_size(mesh, mesh.normal_domain))) {
    warn("Normals do not match the mesh; it is shaded flat.");
    mesh.normals.clear();
  }
  uint64_t repaired = validate_attributes(mesh, diagnostics) + validate_grids(mesh, diagnostics);

  std::vector<uint8_t> bad_vertex;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    if (is_finite(mesh.positions[v])) continue;
    if (bad_vertex.empty()) bad_vertex.assign(mesh.positions.size(), 0);
    bad_vertex[v] = 1;
    mesh.positions[v] = Vec3(0.0f);
  }
  std::vector<uint8_t> keep;
  uint64_t bad_triangles = 0, degenerate = 0;
  for (size_t t = 0; t < triangle_count; ++t) {
    const UVec3 i = mesh.triangles[t];
    const size_t n = mesh.positions.size();
    bool bad = i.x >= n || i.y >= n || i.z >= n;
    bool flat = false;
    if (!bad && !bad_vertex.empty()) bad = bad_vertex[i.x] || bad_vertex[i.y] || bad_vertex[i.z];
    if (!bad) {
      const Vec3 p = mesh.positions[i.x], q = mesh.positions[i.y], r = mesh.positions[i.z];
      flat = mesh.motion_positions.empty() && (p == q || q == r || r == p);
    }
    if (!bad && !flat) continue;
    if (keep.empty()) keep.assign(triangle_count, 1);
    keep[t] = 0;
    (bad ? bad_triangles : degenerate) += 1;
  }
  if (!keep.empty()) compact_triangles(mesh, keep);
  if (bad_triangles > 0) warn(count_of(bad_triangles, "triangle") + " with invalid vertices left out.");
  counts.skipped_triangles += bad_triangles + degenerate;

  for (Vec3& n : mesh.normals) {
    if (is_finite(n)) continue;
    n = Vec3(0.0f);  // a zero normal means "use the normal of the triangle"
    ++repaired;
  }
  if (repaired > 0) warn(count_of(repaired, "invalid normal or attribute value") + " replaced.");
  counts.repaired_values += repaired;
}

/// The number of shapes of a mesh while the shutter is open; 0 if they do not match the mesh or are not finite.
size_t usable_shapes(const MeshDescription& mesh) {
  const size_t vertices = mesh.positions.size(), normals = mesh.normals.size();
  if (vertices == 0 || mesh.motion_positions.size() % vertices != 0) return 0;
  const size_t count = mesh.motion_positions.size() / vertices;
  const bool matches = count >= 2 && count <= 129 && mesh.subdivision.empty() &&
                       (mesh.motion_normals.empty() || mesh.motion_normals.size() == count * normals) &&
                       (mesh.motion_radii.empty() || mesh.motion_radii.size() == count * vertices);
  const auto all_finite = [](const auto& values, auto test) { return std::all_of(values.begin(), values.end(), test); };
  const auto vector = [](Vec3 v) { return is_finite(v); };
  return matches && all_finite(mesh.motion_positions, vector) && all_finite(mesh.motion_normals, vector) &&
                 all_finite(mesh.motion_radii, [](float x) { return std::isfinite(x); })
             ? count
             : 0;
}

/// A mesh whose shapes cannot be used keeps that of the frame.
void validate_mesh(MeshDescription& mesh, ValidationCounts& counts, Diagnostics& diagnostics) {
  if (mesh.motion_positions.empty()) {
    validate_shape(mesh, counts, diagnostics);
    return;
  }
  const size_t shapes = usable_shapes(mesh);
  if (shapes > 0) validate_shape(mesh, counts, diagnostics);
  if (shapes > 0 && usable_shapes(mesh) == shapes) return;
  mesh.motion_positions.clear();
  mesh.motion_normals.clear();
  mesh.motion_radii.clear();
  if (shapes == 0) validate_shape(mesh, counts, diagnostics);
  report_once(diagnostics,
              {Severity::Warning, mesh.name,
               "Its shapes while the shutter is open do not match the mesh; it is rendered without deformation."});
}

bool finite(const std::array<float, 12>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](float x) { return std::isfinite(x); });
}

/// Whether surfaces keep an area under the transform. A transform that flattens them does.
bool leaves_area(const std::array<float, 12>& rows) {
  Mat3 linear(to_matrix(rows));
  const float largest = std::max(
      {max_component(glm::abs(linear[0])), max_component(glm::abs(linear[1])), max_component(glm::abs(linear[2]))});
  if (!(largest > 0.0f)) return false;
  for (int axis = 0; axis < 3; ++axis) linear[axis] /= largest;
  constexpr float kSmallest = 1e-12f;
  return length_squared(glm::cross(linear[0], linear[1])) > sqr(kSmallest) ||
         length_squared(glm::cross(linear[1], linear[2])) > sqr(kSmallest) ||
         length_squared(glm::cross(linear[2], linear[0])) > sqr(kSmallest);
}

void validate_camera(const CameraDescription& camera) {
  if (!camera.present) throw SceneError("The scene has no camera. Add one, or make one active.");
  if (!finite(camera.world_from_camera)) throw SceneError("Camera '" + camera.name + "' has an invalid transform.");
  if (!std::all_of(camera.motion.begin(), camera.motion.end(), finite))
    throw SceneError("Camera '" + camera.name + "' has an invalid motion.");
  if (!std::all_of(camera.frames.begin(), camera.frames.end(), finite))
    throw SceneError("Camera '" + camera.name + "' has an invalid motion.");
  const auto is_window = [](Vec4 w) {
    return w.y > w.x && w.w > w.z && std::isfinite(w.y - w.x) && std::isfinite(w.w - w.z);
  };
  if (!std::all_of(camera.window_motion.begin(), camera.window_motion.end(), is_window))
    throw SceneError("Camera '" + camera.name + "' has an invalid motion.");
  if (!is_window(camera.screen_window)) throw SceneError("Camera '" + camera.name + "' has an empty field of view.");
  const PanoramaDescription& p = camera.panorama;
  const bool empty = p.limits.x == p.limits.y || p.limits.z == p.limits.w || !(p.fisheye_fov > 0.0f) ||
                     !(p.fisheye_lens > 0.0f) || !(p.sensor.x > 0.0f) || !(p.sensor.y > 0.0f);
  if (camera.kind == CameraKind::Panorama &&
      (empty || !std::isfinite(p.limits.x + p.limits.y + p.limits.z + p.limits.w + p.fisheye_fov + p.fisheye_lens +
                               p.sensor.x + p.sensor.y)))
    throw SceneError("Camera '" + camera.name + "' has an empty panorama.");
  const float lens[] = {camera.aperture_radius, camera.focus_distance, camera.blade_rotation, camera.aperture_ratio};
  if (!std::all_of(std::begin(lens), std::end(lens), [](float x) { return std::isfinite(x); }) ||
      (camera.aperture_radius > 0.0f && !(camera.aperture_ratio > 0.0f)))
    throw SceneError("Camera '" + camera.name + "' has an invalid aperture.");
  const StereoDescription& eye = camera.stereo;
  if (!std::isfinite(eye.offset + eye.convergence + eye.merge_from + eye.merge_to))
    throw SceneError("Camera '" + camera.name + "' has an invalid stereoscopy.");
  if (!(camera.clip_end > camera.clip_start))
    throw SceneError("Camera '" + camera.name + "': Clip End must be greater than Clip Start.");
}

/// A dicing camera that sees nothing is not used.
void validate_dicing(DicingDescription& dicing) {
  dicing.max_subdivisions = std::clamp(dicing.max_subdivisions, 0, 16);
  if (!(dicing.offscreen_scale >= 1.0f) || !std::isfinite(dicing.offscreen_scale)) dicing.offscreen_scale = 1.0f;
  if (!dicing.camera.present) return;
  try {
    validate_camera(dicing.camera);
  } catch (const SceneError&) {
    dicing.camera.present = false;
  }
}

/// Numbers from instancers that are not finite become 0, and so do all numbers of an instance with an invalid index.
void validate_origins(SceneDescription& d) {
  for (InstanceOrigin& origin : d.instance_origins) {
    for (float* x : {&origin.index, &origin.age, &origin.lifetime, &origin.size}) *x = std::isfinite(*x) ? *x : 0.0f;
    for (Vec3* v : {&origin.generated, &origin.location, &origin.velocity, &origin.angular_velocity}) mend(*v);
    mend(origin.uv);
  }
  for (InstanceDescription& instance : d.instances)
    if (instance.origin >= int(d.instance_origins.size())) instance.origin = -1;
}

/// Values that are not finite become 0. Instances without a complete row have the values of their object.
void validate_instance_values(SceneDescription& d) {
  auto& [columns, values] = d.instance_values;
  columns = std::max(columns, 0);
  const int rows = columns > 0 ? int(values.size() / size_t(columns)) : 0;
  for (Vec4& value : values) mend(value);
  for (InstanceDescription& instance : d.instances)
    if (instance.values >= rows) instance.values = -1;
  for (ObjectDescription& object : d.objects)
    for (ObjectProperty& property : object.properties)
      if (property.column >= columns) property.column = -1;
}

/// Removes the motion of instances whose keys cannot be used.
void validate_motion(SceneDescription& d, Diagnostics& diagnostics) {
  const auto usable = [&](int first, int count) {
    if (first < 0 || count < 2 || count > 129 || count > int(d.motion_keys.size()) ||
        first > int(d.motion_keys.size()) - count)
      return false;
    return std::all_of(d.motion_keys.begin() + first, d.motion_keys.begin() + first + count, finite);
  };
  for (InstanceDescription& instance : d.instances)
    if (instance.first_frame_key >= 0 && !usable(instance.first_frame_key, 2)) instance.first_frame_key = -1;
  for (InstanceDescription& instance : d.instances) {
    if (instance.motion_key_count == 0 || usable(instance.first_motion_key, instance.motion_key_count)) continue;
    instance.motion_key_count = 0;
    report_once(diagnostics, {Severity::Warning, d.objects[instance.object].name,
                              "The object's motion is invalid; the object is rendered without motion."});
  }
}

void validate_settings(RenderSettings& s) {
  apply_ranges(s);
  auto& r = s.region;
  if (r == std::array<int, 4>{0, 0, 0, 0}) r = {0, 0, s.width, s.height};
  if (r[0] < 0 || r[1] < 0 || r[2] > s.width || r[3] > s.height || r[0] >= r[2] || r[1] >= r[3])
    throw SceneError("The render region is empty or outside the frame.");
  if (s.samples == 0 && s.seconds == 0.0 && s.target_error == 0.0)
    throw SceneError("The render would never end: set samples, a time limit or a noise target.");
}

}  // namespace

void validate_view(const CameraDescription& camera, RenderSettings& settings) {
  validate_settings(settings);
  validate_camera(camera);
  if (camera.kind == CameraKind::Texels && camera.texels.size() != size_t(settings.width) * size_t(settings.height))
    throw SceneError("Camera '" + camera.name + "' must have a texel for each pixel.");
}

ValidationCounts validate(SceneDescription& d, Diagnostics& diagnostics) {
  ValidationCounts counts;
  validate_view(d.camera, d.settings);
  validate_dicing(d.dicing);
  for (MeshDescription& mesh : d.meshes) validate_mesh(mesh, counts, diagnostics);
  const auto repair = [](float& importance) {
    if (!std::isfinite(importance) || importance < 0.0f) importance = 1.0f;
  };
  repair(d.world.light_importance);
  for (LightDescription& light : d.lights) {
    repair(light.light_importance);
    light.max_bounces = std::max(light.max_bounces, 0);
  }
  d.world.max_bounces = std::max(d.world.max_bounces, 0);
  for (ObjectDescription& object : d.objects) {
    if (object.mesh >= int(d.meshes.size())) object.mesh = -1;
    repair(object.importance);
    repair(object.light_importance);
    object.receiver_set = std::min<uint8_t>(object.receiver_set, LightLinks::kReceiverSets - 1);
    object.blocker_set = std::min<uint8_t>(object.blocker_set, LightLinks::kBlockerSets - 1);
    for (ObjectProperty& property : object.properties) mend(property.value);
    for (int& material : object.materials) {
      if (material >= int(d.materials.size())) material = -1;
    }
  }
  std::erase_if(d.instances, [&](const InstanceDescription& instance) {
    if (instance.object < 0 || instance.object >= int(d.objects.size()) || d.objects[instance.object].mesh < 0) {
      ++counts.skipped_instances;
      return true;
    }
    if (finite(instance.world_from_object)) {
      const bool unseen = !leaves_area(instance.world_from_object);
      counts.skipped_instances += unseen;
      return unseen;
    }
    report_once(diagnostics, {Severity::Warning, d.objects[instance.object].name,
                              "The object's transform is invalid (not a number); it is left out."});
    ++counts.skipped_instances;
    return true;
  });
  validate_motion(d, diagnostics);
  validate_origins(d);
  validate_instance_values(d);
  std::erase_if(d.lights, [&](LightDescription& light) {
    const float shape[] = {light.energy,    light.radius,      light.spot_angle,  light.spot_blend,
                           light.sun_angle, light.area_size.x, light.area_size.y, light.spread};
    const bool good = finite(light.world_from_light) && is_finite(light.color) &&
                      std::all_of(std::begin(shape), std::end(shape), [](float x) { return std::isfinite(x); });
    if (!good)
      report_once(diagnostics, {Severity::Warning, light.name, "The light has invalid values; it is left out."});
    return !good;
  });
  return counts;
}

}  // namespace ajar
