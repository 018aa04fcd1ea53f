#include "scene/displace.h"

#include <tbb/parallel_for.h>

#include "geometry/uv_tangents.h"

namespace ajar {

namespace {

constexpr uint32_t kNone = ~0u;

Vec3 unit_or_zero(Vec3 v) {
  const float len = glm::length(v);
  return len > 0.0f && len < kInfinity ? v / len : Vec3(0.0f);
}

bool is_tangent(const Attribute& attribute) {
  return attribute.name.starts_with(kTangentOf) && attribute.domain == Domain::Corner && attribute.components == 4;
}

/// The unit normal of a triangle, on the side of the smooth normals; 0 for a triangle without area.
Vec3 face_normal(const BuiltMesh& mesh, UVec3 v, bool inverted) {
  const Vec3 p = mesh.positions[v.x];
  const Vec3 n = unit_or_zero(glm::cross(mesh.positions[v.y] - p, mesh.positions[v.z] - p));
  return inverted ? -n : n;
}

/// The mean of the normals of the triangles around each vertex, weighted by their angles, as in Blender.
std::vector<Vec3> angle_weighted_normals(const BuiltMesh& mesh, bool inverted) {
  std::vector<Vec3> normals(mesh.positions.size(), Vec3(0.0f));
  for (const UVec3& v : mesh.triangles) {
    const Vec3 n = face_normal(mesh, v, inverted);
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = mesh.positions[v[k]];
      const Vec3 a = unit_or_zero(mesh.positions[v[(k + 1) % 3]] - p);
      const Vec3 b = unit_or_zero(mesh.positions[v[(k + 2) % 3]] - p);
      normals[v[k]] += n * std::acos(glm::clamp(glm::dot(a, b), -1.0f, 1.0f));
    }
  }
  for (Vec3& n : normals) n = unit_or_zero(n);
  return normals;
}

/// The mean of the normals of the triangles around each vertex, all with the same weight, as in Cycles.
template <class Counts>
std::vector<Vec3> mean_normals(const BuiltMesh& mesh, bool inverted, const Counts& counts) {
  std::vector<Vec3> normals(mesh.positions.size(), Vec3(0.0f));
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!counts(t)) continue;
    const Vec3 n = face_normal(mesh, mesh.triangles[t], inverted);
    for (int k = 0; k < 3; ++k) normals[mesh.triangles[t][k]] += n;
  }
  for (Vec3& n : normals) n = unit_or_zero(n);
  return normals;
}

class Displacer {
 public:
  Displacer(BuiltMesh& mesh, const BuiltInstance& instance, const ObjectDescription& object,
            std::span<const uint32_t> materials, const std::vector<ShaderProgram>& programs)
      : mesh_(mesh), instance_(instance), object_(object), materials_(materials), programs_(programs) {
    instance_.motion = nullptr;
    instance_.motion_count = 0;
    inverted_ = mesh.baked && instance.flips_orientation;
  }

  size_t run(const std::atomic<bool>* stop) {
    std::vector<uint32_t> corners(vertex_count(), kNone);
    bool bends_normals = false;
    for (size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const ShaderProgram& program = program_of(t);
      if (!program.displaces()) continue;
      bends_normals |= program.bends_undisplaced_normal();
      for (int k = 0; k < 3; ++k) {
        uint32_t& corner = corners[mesh_.triangles[t][k]];
        if (corner == kNone) corner = uint32_t(3 * t + k);
      }
    }
    if (mesh_.normals.empty()) smooth_ = angle_weighted_normals(mesh_, inverted_);
    std::vector<Vec3> offsets(vertex_count(), Vec3(0.0f));
    std::atomic<size_t> broken{0};
    tbb::parallel_for(size_t(0), corners.size(), [&](size_t i) {
      if (corners[i] == kNone || (stop && stop->load(std::memory_order_relaxed))) return;
      const Vec3 offset = offset_at(corners[i]);
      if (is_finite(offset) && is_finite(mesh_.positions[i] + offset))
        offsets[i] = offset;
      else
        ++broken;
    });
    keep_the_original(bends_normals);
    move(offsets);
    renew_tangents();
    if (mesh_.deformation) move_other_shapes(offsets);
    mesh_.displaced = true;
    mesh_.structure.reset();
    return broken;
  }

 private:
  size_t vertex_count() const { return mesh_.positions.size() - 1; }
  const ShaderProgram& program_of(size_t triangle) const {
    const size_t slot = mesh_.material_slots.empty() ? 0 : mesh_.material_slots[triangle];
    return programs_[materials_[std::min(slot, materials_.size() - 1)]];
  }

  /// In the space of the positions.
  Vec3 offset_at(uint32_t corner) const {
    const uint32_t t = corner / 3, k = corner % 3;
    const UVec3 v = mesh_.triangles[t];
    ShadingPoint point;
    point.position = mesh_.positions[v[k]];
    point.dpdu = mesh_.positions[v.y] - mesh_.positions[v.x];
    point.dpdv = mesh_.positions[v.z] - mesh_.positions[v.x];
    point.barycentric = Vec2(k == 1 ? 1.0f : 0.0f, k == 2 ? 1.0f : 0.0f);
    point.primitive = t;
    point.mesh = &mesh_;
    point.instance = &instance_;
    point.object = &object_;
    point.ray_kind = 0;
    point.ns = mesh_.normals.empty()                   ? smooth_[v[k]]
               : mesh_.normal_domain == Domain::Vertex ? mesh_.normals[v[k]]
                                                       : mesh_.normals[corner];
    if (!mesh_.baked) {
      const Mat3 linear(instance_.world_from_object);
      point.position = transform_point(instance_.world_from_object, point.position);
      point.dpdu = linear * point.dpdu;
      point.dpdv = linear * point.dpdv;
      point.ns = point.ns * Mat3(instance_.object_from_world);
    }
    point.ng = unit_or_zero(glm::cross(point.dpdu, point.dpdv)) * (instance_.flips_orientation ? -1.0f : 1.0f);
    point.ns = unit_or_zero(point.ns);
    if (point.ns == Vec3(0.0f)) point.ns = point.ng;
    if (point.ng == Vec3(0.0f)) point.ng = point.ns;
    point.wo = point.ns;
    const Vec3 offset = program_of(t).displacement(point);
    return mesh_.baked ? offset : Mat3(instance_.object_from_world) * offset;
  }

  /// Generated coordinates and bump mapping use the positions before the displacement.
  void keep_the_original(bool bends_normals) {
    if (bends_normals) {
      Undisplaced original{mesh_.positions, mesh_.normals, {}};
      std::copy_if(mesh_.attributes.begin(), mesh_.attributes.end(), std::back_inserter(original.tangents),
                   [](const Attribute& attribute) { return is_tangent(attribute); });
      mesh_.undisplaced = std::make_shared<const Undisplaced>(std::move(original));
    }
    if (mesh_.undeformed_position >= 0) return;
    Attribute original;
    original.name = kUndeformedPosition;
    original.domain = Domain::Vertex;
    original.components = 3;
    original.values.reserve(3 * vertex_count());
    for (size_t i = 0; i < vertex_count(); ++i) {
      const Vec3 p = in_object_space(mesh_.positions[i]);
      original.values.insert(original.values.end(), {p.x, p.y, p.z});
    }
    mesh_.undeformed_position = int(mesh_.attributes.size());
    mesh_.attributes.push_back(std::move(original));
  }

  Vec3 in_object_space(Vec3 position) const {
    return mesh_.baked ? transform_point(instance_.object_from_world, position) : position;
  }

  /// Moves the vertices and turns the normals.
  void move(const std::vector<Vec3>& offsets) {
    const auto move_vertices = [&] {
      for (size_t i = 0; i < offsets.size(); ++i) mesh_.positions[i] += offsets[i];
    };
    if (mesh_.normals.empty() || mesh_.normal_domain == Domain::Vertex) {
      move_vertices();
      if (!mesh_.normals.empty()) renew_vertex_normals();
    } else {
      const auto all = [](size_t) { return true; };
      const std::vector<Vec3> before = mean_normals(mesh_, inverted_, all);
      move_vertices();
      turn_corner_normals(before, mean_normals(mesh_, inverted_, all));
    }
  }

  /// The shapes at other times are displaced by the same distances, as in Cycles.
  void move_other_shapes(const std::vector<Vec3>& offsets) {
    auto moved = std::make_shared<Deformation>(*mesh_.deformation);
    for (Deformation::Key& key : moved->keys) {
      std::swap(mesh_.positions, key.positions);
      std::swap(mesh_.normals, key.normals);
      move(offsets);
      std::swap(mesh_.positions, key.positions);
      std::swap(mesh_.normals, key.normals);
    }
    mesh_.deformation = std::move(moved);
  }

  void renew_vertex_normals() {
    const auto counts = [&](size_t t) {
      return program_of(t).displaces() && !program_of(t).bends_undisplaced_normal();
    };
    const std::vector<Vec3> renewed = mean_normals(mesh_, inverted_, counts);
    for (size_t i = 0; i < mesh_.normals.size(); ++i)
      if (renewed[i] != Vec3(0.0f)) mesh_.normals[i] = renewed[i];
  }

  /// Corner normals turn by the difference between the mean normals of their vertices, so that sharp edges stay sharp.
  void turn_corner_normals(const std::vector<Vec3>& before, const std::vector<Vec3>& after) {
    const int index = mesh_.find_attribute(kFlatFaces);
    const Attribute* marks = index < 0 ? nullptr : &mesh_.attributes[size_t(index)];
    const float* flat = marks && marks->domain == Domain::Face && marks->components == 1 ? marks->values.data()
                                                                                         : nullptr;
    for (size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const UVec3 v = mesh_.triangles[t];
      for (int k = 0; k < 3; ++k) {
        Vec3& n = mesh_.normals[3 * t + size_t(k)];
        const Vec3 turned = flat && flat[t] != 0.0f ? face_normal(mesh_, v, inverted_)
                                                    : unit_or_zero(n + after[v[k]] - before[v[k]]);
        if (turned != Vec3(0.0f)) n = turned;
      }
    }
  }

  void renew_tangents() {
    std::vector<Vec3> positions, normals;
    for (Attribute& attribute : mesh_.attributes) {
      if (!is_tangent(attribute)) continue;
      if (positions.empty()) {
        for (size_t i = 0; i < vertex_count(); ++i) positions.push_back(in_object_space(mesh_.positions[i]));
        const Mat3 to_object = mesh_.baked ? glm::transpose(Mat3(instance_.world_from_object)) : Mat3(1.0f);
        for (size_t c = 0; c < 3 * mesh_.triangles.size(); ++c) {
          const UVec3 v = mesh_.triangles[c / 3];
          const Vec3 n = mesh_.normals.empty()                   ? face_normal(mesh_, v, inverted_)
                         : mesh_.normal_domain == Domain::Vertex ? mesh_.normals[v[int(c % 3)]]
                                                                 : mesh_.normals[c];
          normals.push_back(unit_or_zero(to_object * n));
        }
      }
      const std::string uv_map = attribute.name.substr(std::string_view(kTangentOf).size());
      const int index = uv_map.empty() ? mesh_.active_uv : mesh_.find_attribute(uv_map);
      std::vector<Vec2> uvs;
      if (index >= 0) {
        const Attribute& map = mesh_.attributes[size_t(index)];
        if (map.domain != Domain::Corner || map.components != 2) continue;
        for (size_t c = 0; c < normals.size(); ++c) uvs.push_back({map.values[2 * c], map.values[2 * c + 1]});
      }
      const std::vector<Vec4> tangents = uv_tangents(positions, mesh_.triangles, normals, uvs);
      for (size_t c = 0; c < tangents.size(); ++c)
        for (int k = 0; k < 4; ++k) attribute.values[4 * c + size_t(k)] = tangents[c][k];
    }
  }

  BuiltMesh& mesh_;
  BuiltInstance instance_;
  const ObjectDescription& object_;
  const std::span<const uint32_t> materials_;
  const std::vector<ShaderProgram>& programs_;
  bool inverted_;             // the triangles wind the other way round
  std::vector<Vec3> smooth_;  // of a mesh with flat faces only
};

}  // namespace

std::vector<bool> moved_meshes(const SceneDescription& d) {
  std::vector<bool> moved(d.meshes.size(), false);
  for (const ObjectDescription& object : d.objects) {
    if (object.mesh < 0 || size_t(object.mesh) >= moved.size()) continue;
    for (const int index : object.materials) {
      if (index < 0 || size_t(index) >= d.materials.size()) continue;
      const MaterialDescription& material = d.materials[size_t(index)];
      if (material.graph.displacement.node >= 0 && material.displacement_method != DisplacementMethod::Bump)
        moved[size_t(object.mesh)] = true;
    }
  }
  return moved;
}

size_t displace(BuiltMesh& mesh, const BuiltInstance& instance, const ObjectDescription& object,
                std::span<const uint32_t> materials, const std::vector<ShaderProgram>& programs,
                const std::atomic<bool>* stop) {
  return Displacer(mesh, instance, object, materials, programs).run(stop);
}

namespace {

/// Moves the sides of the box around a mesh outwards by `distance`, in the space of the positions, and all vertices with
/// them.
void widen(BuiltMesh& mesh, float distance) {
  Vec3 lower(kInfinity), upper(-kInfinity);
  for (size_t i = 0; i + 1 < mesh.positions.size(); ++i) {
    lower = glm::min(lower, mesh.positions[i]);
    upper = glm::max(upper, mesh.positions[i]);
  }
  const Vec3 center = 0.5f * lower + 0.5f * upper, half = 0.5f * upper - 0.5f * lower;
  const auto move = [&](std::vector<Vec3>& positions) {
    for (size_t i = 0; i + 1 < positions.size(); ++i)
      for (int axis = 0; axis < 3; ++axis)
        if (half[axis] > 0.0f) positions[i][axis] += distance * ((positions[i][axis] - center[axis]) / half[axis]);
  };
  move(mesh.positions);
  if (mesh.deformation) {
    auto moved = std::make_shared<Deformation>(*mesh.deformation);
    for (Deformation::Key& key : moved->keys) move(key.positions);
    mesh.deformation = std::move(moved);
  }
  mesh.displaced = true;
}

/// The largest coordinate of an instance of a mesh, in the scale of its positions.
float largest_coordinate(const BuiltMesh& mesh, const BuiltInstance& instance) {
  const Mat4 place = mesh.baked ? Mat4(1.0f) : instance.world_from_object;
  float coordinate = 0.0f;
  for (size_t i = 0; i + 1 < mesh.positions.size(); ++i)
    coordinate = std::max(coordinate, max_component(glm::abs(transform_point(place, mesh.positions[i]))));
  return coordinate / std::min({glm::length(place[0]), glm::length(place[1]), glm::length(place[2])});
}

}  // namespace

void widen_media(std::vector<BuiltMesh>& meshes, const std::vector<BuiltInstance>& instances,
                 std::span<const uint32_t> material_table, const std::vector<ShaderProgram>& programs) {
  constexpr float kStep = 1e-5f;  // of the largest coordinate
  constexpr uint32_t kDistances = 8;
  std::vector<float> largest(meshes.size(), 0.0f);
  for (const BuiltInstance& instance : instances) {
    const BuiltMesh& mesh = meshes[instance.mesh];
    const auto materials = material_table.subspan(instance.first_material, instance.material_count);
    const bool stays = mesh.triangles.empty() || !mesh.grids.empty() ||
                       !std::all_of(materials.begin(), materials.end(),
                                    [&](uint32_t material) { return programs[material].only_encloses(); });
    float& found = largest[instance.mesh];
    found = stays ? kInfinity : std::max(found, found < kInfinity ? largest_coordinate(mesh, instance) : 0.0f);
  }
  uint32_t number = 0;
  for (size_t i = 0; i < meshes.size(); ++i) {
    if (!(largest[i] > 0.0f) || !(largest[i] < kStep * std::numeric_limits<float>::max())) continue;
    widen(meshes[i], kStep * largest[i] * (1.0f + float(number % kDistances)));
    ++number;
  }
}

}  // namespace ajar
