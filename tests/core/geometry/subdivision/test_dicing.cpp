// Adaptive subdivision: the limit surface, the numbers of pieces of edges, closed surfaces, attributes.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "geometry/subdivision/dice.h"

namespace ajar::test_dicing {
namespace {

MeshDescription mesh_of(std::vector<Vec3> positions, const std::vector<std::vector<uint32_t>>& faces,
                        SubdivisionScheme scheme = SubdivisionScheme::CatmullClark) {
  MeshDescription mesh;
  mesh.name = "test";
  mesh.positions = std::move(positions);
  mesh.subdivision.scheme = scheme;
  mesh.subdivision.in_pixels = false;
  for (const auto& face : faces) {
    mesh.subdivision.face_sizes.push_back(uint32_t(face.size()));
    for (const uint32_t vertex : face) mesh.subdivision.corner_vertices.push_back(vertex);
  }
  return mesh;
}

/// From -1 to 1.
MeshDescription cube(SubdivisionScheme scheme = SubdivisionScheme::CatmullClark) {
  std::vector<Vec3> p;
  for (int i = 0; i < 8; ++i) p.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  return mesh_of(p, {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}, scheme);
}

/// A prism over a polygon, closed, with its sides divided into triangles at one place.
MeshDescription prism(uint32_t corners, SubdivisionScheme scheme) {
  std::vector<Vec3> p;
  std::vector<uint32_t> top, bottom;
  for (uint32_t k = 0; k < corners; ++k) {
    const float angle = 2.0f * kPi * float(k) / float(corners);
    p.emplace_back(std::cos(angle), std::sin(angle), 0.0f);
    p.emplace_back(std::cos(angle), std::sin(angle), 1.0f + 0.2f * float(k));
    top.push_back(2 * k + 1);
    bottom.insert(bottom.begin(), 2 * k);
  }
  std::vector<std::vector<uint32_t>> faces{top, bottom};
  for (uint32_t k = 0; k < corners; ++k) {
    const uint32_t next = (k + 1) % corners;
    if (k == 0) {
      faces.push_back({2 * k, 2 * next, 2 * next + 1});
      faces.push_back({2 * k, 2 * next + 1, 2 * k + 1});
    } else {
      faces.push_back({2 * k, 2 * next, 2 * next + 1, 2 * k + 1});
    }
  }
  return mesh_of(p, faces, scheme);
}

MeshDescription grid(int cells, SubdivisionScheme scheme = SubdivisionScheme::CatmullClark) {
  std::vector<Vec3> p;
  std::vector<std::vector<uint32_t>> faces;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) p.emplace_back(float(i) / float(cells), float(j) / float(cells), 0.0f);
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const uint32_t at = uint32_t(j * (cells + 1) + i), up = at + uint32_t(cells) + 1;
      faces.push_back({at, at + 1, up + 1, up});
    }
  return mesh_of(p, faces, scheme);
}

DicingRate rate_of(float edge_length, int most = 12) {
  DicingRate rate;
  rate.edge_length = edge_length;
  rate.max_subdivisions = most;
  return rate;
}

MeshDescription diced(const MeshDescription& mesh, const DicingRate& rate) {
  DicingReport report;
  return dice(mesh, rate, report);
}

Vec3 nearest(const MeshDescription& mesh, Vec3 to) {
  return *std::min_element(mesh.positions.begin(), mesh.positions.end(),
                           [&](Vec3 a, Vec3 b) { return glm::length(a - to) < glm::length(b - to); });
}

void expect_near(Vec3 a, Vec3 b, float tolerance = 1e-5f) {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], tolerance);
}

/// Each edge of a closed surface has two triangles, in opposite directions.
void expect_closed(const MeshDescription& mesh) {
  std::set<std::pair<uint32_t, uint32_t>> edges;
  for (const UVec3& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      ASSERT_LT(t[k], mesh.positions.size());
      ASSERT_TRUE(edges.insert({t[k], t[(k + 1) % 3]}).second);
    }
  for (const auto& [a, b] : edges) ASSERT_TRUE(edges.contains({b, a}));
}

double volume_of(const MeshDescription& mesh) {
  double sum = 0.0;
  for (const UVec3& t : mesh.triangles)
    sum += glm::dot(mesh.positions[t.x], glm::cross(mesh.positions[t.y], mesh.positions[t.z])) / 6.0;
  return sum;
}

CameraDescription camera_at(Vec3 place) {
  CameraDescription camera;
  camera.present = true;
  camera.screen_window = {-0.5f, 0.5f, -0.5f, 0.5f};
  camera.world_from_camera = {1, 0, 0, place.x, 0, 1, 0, place.y, 0, 0, 1, place.z};
  return camera;
}

TEST(Dicing, VerticesOfACubeAreAtTheirLimits) {
  const MeshDescription result = diced(cube(), rate_of(100.0f));
  // (n^2 v + 4 sum of neighbours + sum of opposite corners) / (n (n + 5)) with n = 3.
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner((i & 1) ? 0.5f : -0.5f, (i & 2) ? 0.5f : -0.5f, (i & 4) ? 0.5f : -0.5f);
    const auto at = std::find_if(result.positions.begin(), result.positions.end(),
                                 [&](Vec3 p) { return glm::length(p - corner) < 1e-5f; });
    ASSERT_NE(at, result.positions.end());
    expect_near(result.normals[size_t(at - result.positions.begin())], glm::normalize(corner), 1e-4f);
  }
}

// As in Cycles (3.4.1, 4.2.23, 4.5.15, 5.0.1 and 5.2.3), at any size of the triangles.
TEST(Dicing, EachEdgeOfAFaceHasAtLeastTwoPieces) {
  const MeshDescription result = diced(cube(), rate_of(100.0f));
  EXPECT_EQ(result.positions.size(), 8u + 12u + 6u);
  EXPECT_EQ(result.triangles.size(), 6u * 8u);
}

TEST(Dicing, MiddlesOfACubeAreAtTheirLimits) {
  const MeshDescription result = diced(cube(), rate_of(1e-3f, 1));
  EXPECT_EQ(result.positions.size(), 26u);
  const float height = (16.0f + 12.0f + 4.0f * 5.0f / 9.0f) / 36.0f;
  expect_near(nearest(result, {0, 0, 1}), {0, 0, height});
  expect_near(nearest(result, {-1, 0, 0}), {-height, 0, 0});
}

TEST(Dicing, SharpEdgesStayWhereTheyAre) {
  MeshDescription mesh = cube();
  mesh.subdivision.creased_edges = {{0, 1}, {1, 3}, {3, 2}, {2, 0}, {4, 5}, {5, 7},
                                    {7, 6}, {6, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
  mesh.subdivision.edge_sharpness.assign(12, 10.0f);
  const MeshDescription sharp = diced(mesh, rate_of(0.3f));
  EXPECT_NEAR(volume_of(sharp), 8.0, 1e-3);
  mesh.subdivision.edge_sharpness.assign(12, 2.0f);
  const double half_sharp = volume_of(diced(mesh, rate_of(0.05f)));
  const double smooth = volume_of(diced(cube(), rate_of(0.05f)));
  EXPECT_GT(half_sharp, 1.3 * smooth);
  EXPECT_LT(half_sharp, 7.9);
}

TEST(Dicing, SharpVerticesStayWhereTheyAre) {
  MeshDescription mesh = cube();
  mesh.subdivision.creased_vertices = {7};
  mesh.subdivision.vertex_sharpness = {10.0f};
  const MeshDescription result = diced(mesh, rate_of(100.0f));
  expect_near(nearest(result, Vec3(1.0f)), Vec3(1.0f));
  expect_near(nearest(result, Vec3(-1.0f)), Vec3(-0.5f));
}

TEST(Dicing, CornersOfABoundaryAreKeptIfWanted) {
  MeshDescription mesh = grid(1);
  // The boundary is a cubic B-spline, of which OpenSubdiv ends the refinement early.
  expect_near(nearest(diced(mesh, rate_of(10.0f)), Vec3(0.0f)), Vec3(1.0f / 6.0f, 1.0f / 6.0f, 0.0f), 0.003f);
  mesh.subdivision.keep_corners = true;
  expect_near(nearest(diced(mesh, rate_of(10.0f)), Vec3(0.0f)), Vec3(0.0f));
}

TEST(Dicing, CornersBetweenSharpEdgesAreSharp) {
  MeshDescription mesh = grid(1);
  mesh.subdivision.creased_edges = {{0, 1}, {0, 2}};
  mesh.subdivision.edge_sharpness = {10.0f, 10.0f};
  const MeshDescription result = diced(mesh, rate_of(10.0f));
  expect_near(nearest(result, Vec3(0.0f)), Vec3(0.0f));
  EXPECT_LT(nearest(result, Vec3(1.0f, 1.0f, 0.0f)).x, 0.9f);
}

TEST(Dicing, EdgesHaveTheWantedLength) {
  const MeshDescription result = diced(grid(1, SubdivisionScheme::Simple), rate_of(0.1f));
  EXPECT_EQ(result.positions.size(), 121u);
  EXPECT_EQ(result.triangles.size(), 200u);
  EXPECT_EQ(diced(grid(1, SubdivisionScheme::Simple), rate_of(0.001f, 4)).triangles.size(), 512u);  // 16 x 16 cells
  EXPECT_TRUE(result.normals.empty());
}

TEST(Dicing, ClosedSurfacesStayClosed) {
  for (const SubdivisionScheme scheme : {SubdivisionScheme::CatmullClark, SubdivisionScheme::Simple})
    for (const uint32_t corners : {3u, 5u, 6u})
      for (const float length : {0.02f, 0.1f, 0.37f, 5.0f}) {
        const MeshDescription result = diced(prism(corners, scheme), rate_of(length));
        expect_closed(result);
        EXPECT_GT(volume_of(result), 0.2);
      }
}

TEST(Dicing, ClosedSurfacesStayClosedAtAllDistances) {
  // Edges that lead away from the camera have pieces of different sizes.
  for (const float size : {3.0f, 7.0f, 30.0f}) {
    const PixelSize pixels(camera_at({0.3f, 0.2f, 2.5f}), 200, 200, 4.0f);
    DicingRate rate = rate_of(size);
    rate.pixels = &pixels;
    rate.world_from_object = {glm::scale(Mat4(1.0f), Vec3(20.0f, 3.0f, 1.0f)),
                              glm::translate(Mat4(1.0f), Vec3(0.0f, 0.0f, -20.0f))};
    for (const uint32_t corners : {3u, 4u, 7u}) {
      const MeshDescription result = diced(prism(corners, SubdivisionScheme::CatmullClark), rate);
      EXPECT_GT(result.triangles.size(), 100u);
      expect_closed(result);
    }
  }
}

TEST(Dicing, SurfacesIntoTheDistanceHavePiecesOfThePixelsSize) {
  // A plane below the camera, from near to far.
  MeshDescription mesh = mesh_of({{-1, -0.5f, -1}, {1, -0.5f, -1}, {1, -0.5f, -1000}, {-1, -0.5f, -1000}},
                                 {{0, 1, 2, 3}}, SubdivisionScheme::Simple);
  const PixelSize pixels(camera_at(Vec3(0.0f)), 100, 100, 1.0f);
  DicingRate rate = rate_of(2.0f, 16);
  rate.pixels = &pixels;
  rate.world_from_object = {Mat4(1.0f)};
  const MeshDescription result = diced(mesh, rate);
  size_t small = 0;
  for (const UVec3& t : result.triangles)
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = result.positions[t[k]], b = result.positions[t[(k + 1) % 3]];
      const float length = glm::length(a - b) / pixels.at(0.5f * (a + b));
      EXPECT_LT(length, 5.0f);
      small += length < 0.25f;
    }
  EXPECT_LT(small, result.triangles.size() / 4);
  EXPECT_LT(result.triangles.size(), 100000u);  // equal pieces would be millions
}

TEST(Dicing, TheFinestInstanceDecides) {
  const PixelSize pixels(camera_at(Vec3(0.0f)), 100, 100, 1.0f);
  DicingRate rate = rate_of(1.0f);
  rate.pixels = &pixels;
  const auto count = [&](std::vector<float> distances) {
    rate.world_from_object.clear();
    for (const float z : distances) rate.world_from_object.push_back(glm::translate(Mat4(1.0f), Vec3(0, 0, -z)));
    return diced(cube(), rate).triangles.size();
  };
  EXPECT_EQ(count({10.0f, 50.0f}), count({10.0f}));
  EXPECT_EQ(count({50.0f, 10.0f}), count({10.0f}));
  EXPECT_GT(count({10.0f}), 4 * count({50.0f}));
}

TEST(Dicing, PixelsAreLargerOutsideTheFieldOfView) {
  const CameraDescription camera = camera_at(Vec3(0.0f));
  const PixelSize all(camera, 100, 100, 1.0f), scaled(camera, 100, 100, 4.0f);
  EXPECT_NEAR(all.at({0, 0, -10}), 0.1f, 1e-4f);
  EXPECT_EQ(all.at({1, 2, -10}), scaled.at({1, 2, -10}));
  EXPECT_GT(scaled.at({12, 0, -10}), 1.5f * all.at({12, 0, -10}));
  EXPECT_NEAR(scaled.at({0, 0, 10}), 4.0f * all.at({0, 0, 10}), 1e-3f);
}

TEST(Dicing, AttributesAreInterpolated) {
  for (const bool smooth : {false, true}) {
    MeshDescription mesh = grid(3, smooth ? SubdivisionScheme::CatmullClark : SubdivisionScheme::Simple);
    mesh.subdivision.keep_corners = true;
    mesh.subdivision.uv_smoothing = UvSmoothing::KeepCorners;
    Attribute height{"height", Domain::Vertex, 1, {}}, map{"UVMap", Domain::Corner, 2, {}},
        color{"Col", Domain::Corner, 4, {}}, number{"number", Domain::Face, 1, {}};
    for (const Vec3& p : mesh.positions) height.values.push_back(2.0f * p.x - p.y);
    for (const uint32_t v : mesh.subdivision.corner_vertices) {
      const Vec3 p = mesh.positions[v];
      map.values.insert(map.values.end(), {p.x, p.y});
      color.values.insert(color.values.end(), {p.x, p.y, p.x + p.y, 1.0f});
    }
    for (size_t f = 0; f < 9; ++f) {
      number.values.push_back(float(f));
      mesh.material_slots.push_back(uint16_t(f % 2));
    }
    mesh.attributes = {height, map, color, number};
    const MeshDescription result = diced(mesh, rate_of(0.07f));
    ASSERT_EQ(result.attributes.size(), 4u);
    const auto& a = result.attributes;
    for (size_t v = 0; v < result.positions.size() && !smooth; ++v)
      EXPECT_NEAR(a[0].values[v], 2.0f * result.positions[v].x - result.positions[v].y, 1e-5f);
    for (size_t c = 0; c < 3 * result.triangles.size(); ++c) {
      const Vec3 p = result.positions[result.triangles[c / 3][int(c % 3)]];
      EXPECT_NEAR(a[1].values[2 * c], p.x, 1e-4f);
      EXPECT_NEAR(a[1].values[2 * c + 1], p.y, 1e-4f);
      EXPECT_NEAR(a[2].values[4 * c + 2], a[2].values[4 * c] + a[2].values[4 * c + 1], 1e-5f);
    }
    for (size_t t = 0; t < result.triangles.size(); ++t) {
      const UVec3 v = result.triangles[t];
      const Vec3 p = (result.positions[v.x] + result.positions[v.y] + result.positions[v.z]) / 3.0f;
      const int face = int(std::lround(a[3].values[t]));
      EXPECT_EQ(result.material_slots[t], face % 2);
      if (smooth) continue;
      EXPECT_EQ(face, int(p.x * 3.0f) + 3 * int(p.y * 3.0f));
    }
  }
}

TEST(Dicing, FlatFacesStayFlat) {
  MeshDescription mesh = cube();
  mesh.subdivision.flat_faces = {0, 1, 0, 0, 0, 0};
  const MeshDescription result = diced(mesh, rate_of(0.5f));
  EXPECT_EQ(result.normal_domain, Domain::Corner);
  ASSERT_EQ(result.normals.size(), 3 * result.triangles.size());
  ASSERT_EQ(result.attributes.size(), 1u);
  EXPECT_EQ(result.attributes[0].name, kFlatFaces);
  size_t flat = 0;
  for (size_t t = 0; t < result.triangles.size(); ++t)
    if (result.attributes[0].values[t] != 0.0f) {
      ++flat;
      EXPECT_EQ(result.normals[3 * t], result.normals[3 * t + 1]);
    }
  EXPECT_EQ(flat, result.triangles.size() / 6);
  mesh.subdivision.flat_faces.assign(6, 1);
  EXPECT_TRUE(diced(mesh, rate_of(0.5f)).normals.empty());
}

TEST(Dicing, TooManyTrianglesAreAvoided) {
  DicingRate rate = rate_of(0.001f);
  rate.max_triangles = 5000;
  DicingReport report;
  const MeshDescription result = dice(cube(), rate, report);
  EXPECT_LE(result.triangles.size(), 5000u);
  EXPECT_GT(result.triangles.size(), 500u);
  EXPECT_GT(report.coarser, 5.0f);
}

TEST(Dicing, UnusualMeshesAreDivided) {
  // Three faces at one edge, a face without area, a vertex without faces, two faces that meet at a vertex only.
  MeshDescription mesh = mesh_of({{0, 0, 0},
                                  {1, 0, 0},
                                  {1, 1, 0},
                                  {0, 1, 0},
                                  {1, -1, 0},
                                  {0, -1, 0},
                                  {1, 0, 1},
                                  {0, 0, 1},
                                  {5, 5, 5},
                                  {2, 2, 0},
                                  {2, 1, 0},
                                  {3, 3, 3},
                                  {3, 3, 3},
                                  {3, 3, 3},
                                  {3, 3, 3}},
                                 {{0, 1, 2, 3}, {5, 4, 1, 0}, {0, 1, 6, 7}, {2, 10, 9}, {11, 12, 13, 14}});
  const MeshDescription result = diced(mesh, rate_of(0.1f));
  EXPECT_GT(result.triangles.size(), 300u);
  for (const Vec3& p : result.positions) EXPECT_TRUE(is_finite(p));
  for (const Vec3& n : result.normals) EXPECT_TRUE(is_finite(n));
  mesh.subdivision.scheme = SubdivisionScheme::Simple;
  EXPECT_GT(diced(mesh, rate_of(0.1f)).triangles.size(), 300u);
  EXPECT_TRUE(diced(mesh_of({}, {}), rate_of(0.1f)).triangles.empty());
}

}  // namespace
}  // namespace ajar::test_dicing
