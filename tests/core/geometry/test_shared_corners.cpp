// Values of corners that are stored with vertices: the same lookups, less memory.
#include "geometry/shared_corners.h"

#include <cstring>

#include <gtest/gtest.h>

#include "scene_fixtures.h"

namespace ajar::test_shared_corners {
namespace {

using namespace fixtures;

/// What the corners of a triangle show: positions, normals, and every attribute by its name.
std::vector<float> seen(const BuiltMesh& mesh, uint32_t triangle) {
  std::vector<float> all;
  const auto add = [&](const Corners& corners) {
    for (const Vec3 v : corners)
      for (int i = 0; i < 3; ++i) all.push_back(v[i]);
  };
  add(mesh.corners(triangle, 0.3f));
  if (!mesh.normals.empty()) add(mesh.corner_normals(triangle, 0.3f));
  for (const Attribute& attribute : mesh.attributes)
    for (const Vec2 b : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(0.3f, 0.25f)}) {
      const Vec4 value = mesh.interpolate(attribute, triangle, b);
      for (int i = 0; i < 4; ++i) all.push_back(value[i]);
    }
  return all;
}

bool is_same(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

/// Shares the corners of a mesh. Expects that every lookup stays the same to the bit. Returns the new mesh.
BuiltMesh shared(const BuiltMesh& before) {
  BuiltMesh after = before;
  share_corners(after);
  EXPECT_EQ(after.triangles.size(), before.triangles.size());
  EXPECT_LE(after.memory_bytes(), before.memory_bytes());
  for (uint32_t t = 0; t < before.triangles.size(); ++t) {
    if (is_same(seen(before, t), seen(after, t))) continue;
    ADD_FAILURE() << "triangle " << t;
    break;
  }
  return after;
}

/// Values of the corners of `mesh` from a function of the triangle and its vertex.
template <class Of>
std::vector<float> of_corners(const MeshDescription& mesh, const Of& of) {
  std::vector<float> values;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      for (const float x : of(t, mesh.triangles[t][k])) values.push_back(x);
  return values;
}

constexpr int kRings = 12, kSegments = 2 * kRings;

/// A sphere with a UV map that has a seam at one meridian, and colours of corners without a seam.
MeshDescription mapped_sphere() {
  MeshDescription mesh = sphere(kRings);
  mesh.attributes.push_back({"UVMap", Domain::Corner, 2, of_corners(mesh, [&](uint32_t t, uint32_t v) {
                               const uint32_t segment = t / 2 % kSegments, at = v % kSegments;
                               const bool wraps = segment == kSegments - 1 && at == 0;
                               return std::vector<float>{wraps ? 1.0f : float(at) / kSegments, float(v / kSegments)};
                             })});
  mesh.attributes.push_back({"Paint", Domain::Corner, 4, of_corners(mesh, [](uint32_t, uint32_t v) {
                               return std::vector<float>{float(v), 0.5f, -0.0f, 1.0f};
                             })});
  return mesh;
}

/// Normals of corners: those of the vertices, except for triangles that are flat.
template <class IsFlat>
void split_normals(MeshDescription& mesh, const IsFlat& is_flat) {
  std::vector<Vec3> normals;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      normals.push_back(is_flat(t) ? Vec3(0, 0, float(t)) : mesh.positions[mesh.triangles[t][k]]);
  mesh.normals = normals;
  mesh.normal_domain = Domain::Corner;
}

TEST(SharedCorners, of_a_map_with_a_seam_divide_its_vertices_only) {
  const BuiltMesh mesh = shared(take_mesh(mapped_sphere()));
  EXPECT_TRUE(mesh.divided);
  EXPECT_EQ(mesh.positions.size(), size_t((kRings + 1) * kSegments + kRings + 1 + 1));  // the seam, and the padding
  EXPECT_EQ(mesh.normals.size() + 1, mesh.positions.size());
  for (const Attribute& attribute : mesh.attributes) EXPECT_EQ(attribute.domain, Domain::Vertex) << attribute.name;
}

TEST(SharedCorners, that_agree_everywhere_divide_nothing) {
  MeshDescription description = sphere(kRings);
  split_normals(description, [](uint32_t) { return false; });
  const BuiltMesh mesh = shared(take_mesh(std::move(description)));
  EXPECT_FALSE(mesh.divided);
  EXPECT_EQ(mesh.normal_domain, Domain::Vertex);
  EXPECT_EQ(mesh.normals.size() + 1, mesh.positions.size());
}

TEST(SharedCorners, with_sharp_edges_and_flat_parts_look_the_same) {
  for (const uint32_t every : {2u, 5u, 50u}) {
    MeshDescription description = mapped_sphere();
    split_normals(description, [&](uint32_t t) { return t % every == 0; });
    description.attributes.push_back(
        {"Faces", Domain::Face, 1, std::vector<float>(description.triangles.size(), 3.0f)});
    description.attributes.push_back({"Vertices", Domain::Vertex, 1, std::vector<float>(description.positions.size())});
    for (size_t v = 0; v < description.positions.size(); ++v) description.attributes.back().values[v] = float(v);
    shared(take_mesh(std::move(description)));
  }
}

TEST(SharedCorners, that_all_differ_stay_with_the_corners) {
  MeshDescription description = mapped_sphere();
  split_normals(description, [](uint32_t) { return true; });
  const BuiltMesh mesh = shared(take_mesh(std::move(description)));
  EXPECT_EQ(mesh.normal_domain, Domain::Corner);
  EXPECT_EQ(mesh.attributes[0].domain, Domain::Vertex) << "the map is not affected";
}

TEST(SharedCorners, of_vertices_without_triangles_are_no_problem) {
  MeshDescription description = mapped_sphere();
  description.positions.insert(description.positions.end(), 7, Vec3(9.0f));
  description.normals.insert(description.normals.end(), 7, Vec3(0, 0, 1));
  shared(take_mesh(std::move(description)));
}

TEST(SharedCorners, of_deforming_meshes_are_left_alone) {
  MeshDescription description = mapped_sphere();
  for (const float scale : {1.0f, 2.0f})
    for (const Vec3 p : description.positions) description.motion_positions.push_back(scale * p);
  const BuiltMesh mesh = shared(take_mesh(std::move(description)));
  ASSERT_TRUE(mesh.deformation);
  EXPECT_FALSE(mesh.divided);
  EXPECT_EQ(mesh.attributes[0].domain, Domain::Corner);
}

/// Random values at random corners: each lookup goes through chains of divided vertices.
TEST(SharedCorners, with_random_values_look_the_same) {
  Pcg32 rng(5);
  for (int round = 0; round < 40; ++round) {
    MeshDescription description = sphere(6);
    const int values = 1 + round % 5;
    for (const int components : {1, 2, 3, 4})
      description.attributes.push_back({"A" + std::to_string(components), Domain::Corner, components,
                                        of_corners(description, [&](uint32_t, uint32_t v) {
                                          const float x = float(int(rng.next_float() * float(values)));
                                          return std::vector<float>(size_t(components), x + float(v));
                                        })});
    shared(take_mesh(std::move(description)));
  }
}

}  // namespace
}  // namespace ajar::test_shared_corners
