#include "geometry/deformation.h"

namespace ajar {

Vec3 Deformation::reach(UVec3 v, float time) const {
  const KeyPair at = keys_at(time, keys.size());
  Vec3 largest(0.0f);
  for (const Key* key : {&keys[at.first], &keys[at.first + 1]})
    for (int k = 0; k < 3; ++k) largest = glm::max(largest, glm::abs(key->positions[v[k]]));
  return largest;
}

size_t Deformation::memory_bytes() const {
  size_t bytes = 0;
  for (const Key& key : keys) bytes += (key.positions.size() + key.normals.size()) * sizeof(Vec3);
  return bytes;
}

std::shared_ptr<const Deformation> make_deformation(const MeshDescription& mesh) {
  const size_t shapes = shape_count(mesh), vertices = mesh.positions.size(), normals = mesh.normals.size();
  if (shapes < 2) return nullptr;
  auto made = std::make_shared<Deformation>();
  for (size_t i = 0; i < shapes; ++i) {
    Deformation::Key key;
    const auto position = mesh.motion_positions.begin() + ptrdiff_t(i * vertices);
    key.positions.reserve(vertices + 1);
    key.positions.assign(position, position + ptrdiff_t(vertices));
    key.positions.push_back(Vec3(0.0f));
    if (mesh.motion_normals.empty()) {
      key.normals = mesh.normals;
    } else {
      const auto normal = mesh.motion_normals.begin() + ptrdiff_t(i * normals);
      key.normals.assign(normal, normal + ptrdiff_t(normals));
    }
    made->keys.push_back(std::move(key));
  }
  return made;
}

std::shared_ptr<const Deformation> transformed(const Deformation& deformation, const Mat4& matrix,
                                               const Mat3& normal_matrix) {
  auto moved = std::make_shared<Deformation>(deformation);
  for (Deformation::Key& key : moved->keys) {
    for (size_t i = 0; i + 1 < key.positions.size(); ++i) key.positions[i] = transform_point(matrix, key.positions[i]);
    for (Vec3& n : key.normals) {
      n = normal_matrix * n;
      const float length = glm::length(n);
      n = length > 0.0f ? n / length : Vec3(0.0f);
    }
  }
  return moved;
}

}  // namespace ajar
