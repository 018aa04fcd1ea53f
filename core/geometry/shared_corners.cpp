#include "geometry/shared_corners.h"

#include <cstddef>
#include <cstring>

namespace ajar {

namespace {

constexpr uint32_t kNone = ~0u;

/// The vertices of a mesh while they are divided.
class Division {
 public:
  explicit Division(BuiltMesh& mesh) : mesh_(mesh), vertices_(mesh.positions.size() - 1) {}

  /// Moves an array of corners, with `width` floats each, to the vertices. Returns false and changes nothing if that takes
  /// no less memory.
  template <class Element>
  bool share(std::vector<Element>& values, size_t width) {
    const size_t corners = 3 * mesh_.triangles.size(), of_vertex = bytes_of_vertex(), bytes = width * sizeof(float);
    const size_t most = (corners * bytes + vertices_ * of_vertex) / (bytes + of_vertex);
    const auto* const of_corners = reinterpret_cast<const std::byte*>(values.data());
    if (most <= vertices_ || !divide(of_corners, bytes, most)) return false;
    std::vector<Element> shared(first_corner_.size() * bytes / sizeof(Element), Element(0.0f));
    auto* const of_vertices = reinterpret_cast<std::byte*>(shared.data());
    for (size_t v = 0; v < first_corner_.size(); ++v)
      if (first_corner_[v] != kNone) std::memcpy(of_vertices + v * bytes, of_corners + first_corner_[v] * bytes, bytes);
    values = std::move(shared);
    add_vertices();
    return true;
  }

 private:
  size_t bytes_of_vertex() const {
    size_t bytes = sizeof(Vec3);
    if (!mesh_.normals.empty() && mesh_.normal_domain == Domain::Vertex) bytes += sizeof(Vec3);
    for (const Attribute& attribute : mesh_.attributes)
      if (attribute.domain == Domain::Vertex) bytes += size_t(attribute.components) * sizeof(float);
    return bytes;
  }

  /// Lets the triangles refer to as many vertices as there are different values. Gives up at more than `most`.
  bool divide(const std::byte* values, size_t bytes, size_t most) {
    first_corner_.assign(vertices_, kNone);
    next_.assign(vertices_, kNone);
    parent_.clear();
    for (size_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const auto corner = uint32_t(3 * t + size_t(k));
        uint32_t v = mesh_.triangles[t][k];
        if (first_corner_[v] == kNone) first_corner_[v] = corner;
        while (std::memcmp(values + corner * bytes, values + first_corner_[v] * bytes, bytes) != 0) {
          if (next_[v] == kNone) {
            next_[v] = uint32_t(first_corner_.size());
            parent_.push_back(mesh_.triangles[t][k]);
            first_corner_.push_back(corner);
            next_.push_back(kNone);
          }
          v = next_[v];
        }
        mesh_.triangles[t][k] = v;
      }
      if (first_corner_.size() > most) {
        undo();
        return false;
      }
    }
    return true;
  }

  void undo() {
    for (UVec3& triangle : mesh_.triangles)
      for (int k = 0; k < 3; ++k)
        if (triangle[k] >= vertices_) triangle[k] = parent_[triangle[k] - vertices_];
  }

  /// Gives the new vertices the values of those that they come from.
  void add_vertices() {
    if (parent_.empty()) return;
    const auto grow = [&](auto& array, size_t width) {
      array.reserve((vertices_ + parent_.size()) * width + 1);
      array.resize(vertices_ * width);
      for (const uint32_t from : parent_)
        for (size_t i = 0; i < width; ++i) array.push_back(array[from * width + i]);
    };
    grow(mesh_.positions, 1);
    mesh_.positions.push_back(Vec3(0.0f));
    if (!mesh_.normals.empty() && mesh_.normal_domain == Domain::Vertex) grow(mesh_.normals, 1);
    for (Attribute& attribute : mesh_.attributes)
      if (attribute.domain == Domain::Vertex) grow(attribute.values, size_t(attribute.components));
    vertices_ += parent_.size();
    mesh_.divided = true;
  }

  BuiltMesh& mesh_;
  size_t vertices_;
  std::vector<uint32_t> first_corner_;  // of each vertex; kNone: no triangle has it
  std::vector<uint32_t> next_;          // the next vertex that comes from the same one; kNone: there is none
  std::vector<uint32_t> parent_;        // of each new vertex
};

}  // namespace

void share_corners(BuiltMesh& mesh) {
  if (mesh.triangles.empty() || mesh.deformation || mesh.undisplaced) return;
  Division division(mesh);
  // Normals come first: other arrays then find the vertices divided at sharp edges, where maps often have seams as well.
  if (!mesh.normals.empty() && mesh.normal_domain == Domain::Corner && division.share(mesh.normals, 3))
    mesh.normal_domain = Domain::Vertex;
  for (Attribute& attribute : mesh.attributes)
    if (attribute.domain == Domain::Corner && division.share(attribute.values, size_t(attribute.components)))
      attribute.domain = Domain::Vertex;
}

}  // namespace ajar
