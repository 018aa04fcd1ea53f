// True displacement: positions, normals and coordinates of displaced meshes.
#include <gtest/gtest.h>

#include "graph_fixtures.h"
#include "render/memory_estimate.h"
#include "scene_fixtures.h"

namespace ajar::test_displacement {
namespace {

using namespace fixtures;

enum class Shading { Flat, Vertex, Corner };

/// A square [-1, 1]^2 in the plane z = 0 of n x n quads, facing +z.
MeshDescription grid(int n, Shading shading) {
  MeshDescription mesh;
  mesh.name = "Grid";
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) mesh.positions.push_back(Vec3(2.0f * x / n - 1.0f, 2.0f * y / n - 1.0f, 0.0f));
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const uint32_t a = uint32_t(y * (n + 1) + x), b = a + 1, c = a + uint32_t(n) + 1;
      mesh.triangles.push_back({a, b, c + 1});
      mesh.triangles.push_back({a, c + 1, c});
    }
  mesh.normal_domain = shading == Shading::Corner ? Domain::Corner : Domain::Vertex;
  if (shading != Shading::Flat)
    mesh.normals.assign(shading == Shading::Vertex ? mesh.positions.size() : 3 * mesh.triangles.size(), Vec3(0, 0, 1));
  return mesh;
}

MaterialDescription material(GraphBuilder g, DisplacementMethod method) {
  const int diffuse = g.node("ShaderNodeBsdfDiffuse", {value_input("Color", 0.5f)});
  g.graph.surface = {diffuse, "BSDF"};
  MaterialDescription m;
  m.name = "Moved";
  m.graph = g.graph;
  m.displacement_method = method;
  return m;
}

/// The surface moves along its normal by `height`.
MaterialDescription lifted(float height, DisplacementMethod method = DisplacementMethod::Displacement) {
  GraphBuilder g;
  const int node = g.node("ShaderNodeDisplacement",
                          {value_input("Height", height), value_input("Midlevel", 0.0f), value_input("Scale", 1.0f)},
                          {text_property("space", "WORLD")});
  g.graph.displacement = {node, "Displacement"};
  return material(g, method);
}

/// The surface moves along its normal by `slope` times x in world space.
MaterialDescription ramp(float slope, DisplacementMethod method) {
  GraphBuilder g;
  const int geometry = g.node("ShaderNodeNewGeometry");
  const int parts = g.node("ShaderNodeSeparateXYZ", {linked_input("Vector", geometry, "Position")});
  const int node = g.node(
      "ShaderNodeDisplacement",
      {linked_input("Height", parts, "X"), value_input("Midlevel", 0.0f), value_input("Scale", slope)},
      {text_property("space", "WORLD")});
  g.graph.displacement = {node, "Displacement"};
  return material(g, method);
}

std::shared_ptr<Scene> build(SceneDescription d, Diagnostics* diagnostics = nullptr,
                             std::shared_ptr<Scene> previous = nullptr) {
  Diagnostics ignored;
  set_camera(d, Vec3(0, 0, 10), Vec3(0.0f), 8);
  return Scene::build(std::move(d), {}, diagnostics ? *diagnostics : ignored, std::move(previous));
}

SceneDescription scene_of(MaterialDescription m, MeshDescription mesh, const Mat4& transform = Mat4(1.0f)) {
  SceneDescription d;
  d.materials.push_back(std::move(m));
  add_object(d, std::move(mesh), 0, transform);
  return d;
}

/// The point that a ray from above sees at (x, y).
ShadingPoint seen(const Scene& scene, float x, float y) {
  Ray ray;
  ray.origin = Vec3(x, y, 50.0f);
  ray.direction = Vec3(0, 0, -1);
  const Hit hit = scene.intersect(ray, kRayCamera);
  EXPECT_TRUE(hit.found());
  ShadingPoint point;
  if (hit.found()) scene.shading_point(ray, hit, point);
  return point;
}

Vec3 shaded_normal(const Scene& scene, const ShadingPoint& point) {
  SurfaceShading shading;
  scene.programs()[0].evaluate_surface(point, shading);
  return shading.bsdf.n;
}

void expect_near(Vec3 a, Vec3 b, float tolerance) {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], tolerance) << "component " << k;
}

constexpr float kSlope = 0.3f;
const Vec3 kTilted = glm::normalize(Vec3(-kSlope, 0.0f, 1.0f));

TEST(Displacement, MovesVerticesAlongTheNormal) {
  for (const Shading shading : {Shading::Flat, Shading::Vertex, Shading::Corner}) {
    const auto scene = build(scene_of(lifted(0.75f), grid(4, shading)));
    EXPECT_NEAR(seen(*scene, 0.3f, 0.1f).position.z, 0.75f, 1e-6f);
  }
}

TEST(Displacement, IsInWorldSpaceForScaledAndSharedMeshes) {
  const Mat4 scaled = glm::scale(Mat4(1.0f), Vec3(3.0f, 3.0f, 2.0f));
  EXPECT_NEAR(seen(*build(scene_of(lifted(0.75f), grid(4, Shading::Vertex), scaled)), 0.3f, 0.1f).position.z, 0.75f,
              1e-6f);
  SceneDescription d = scene_of(lifted(0.75f), grid(4, Shading::Vertex), scaled);
  d.instances.push_back(d.instances[0]);  // shows the same mesh, which stays in object space
  d.instances[1].world_from_object = rows(glm::translate(Mat4(1.0f), Vec3(20, 0, 0)));
  const auto scene = build(d);
  EXPECT_NEAR(seen(*scene, 0.3f, 0.1f).position.z, 0.75f, 1e-6f);
  EXPECT_NEAR(seen(*scene, 20.0f, 0.1f).position.z, 0.375f, 1e-6f);  // the mesh moved in the space of the first
}

TEST(Displacement, OfAMirroredObjectFollowsItsNormals) {
  const Mat4 mirrored = glm::scale(Mat4(1.0f), Vec3(1.0f, 1.0f, -1.0f));
  for (const Shading shading : {Shading::Flat, Shading::Vertex, Shading::Corner})
    EXPECT_NEAR(seen(*build(scene_of(lifted(0.75f), grid(4, shading), mirrored)), 0.3f, 0.1f).position.z, -0.75f,
                1e-6f);
  for (const Shading shading : {Shading::Vertex, Shading::Corner}) {
    const auto scene = build(scene_of(ramp(kSlope, DisplacementMethod::Displacement), grid(8, shading), mirrored));
    const ShadingPoint point = seen(*scene, 0.3f, 0.1f);
    EXPECT_NEAR(point.position.z, -kSlope * 0.3f, 1e-5f);
    expect_near(point.ns, glm::normalize(Vec3(kSlope, 0.0f, 1.0f)), 1e-5f);
  }
}

TEST(Displacement, TurnsSmoothNormals) {
  for (const Shading shading : {Shading::Flat, Shading::Vertex, Shading::Corner}) {
    const auto scene = build(scene_of(ramp(kSlope, DisplacementMethod::Displacement), grid(8, shading)));
    const ShadingPoint point = seen(*scene, 0.3f, 0.1f);
    EXPECT_NEAR(point.position.z, kSlope * 0.3f, 1e-5f);
    expect_near(point.ns, kTilted, 1e-5f);
    expect_near(shaded_normal(*scene, point), kTilted, 1e-5f);
  }
}

TEST(Displacement, WithBumpBendsTheNormalOfTheOriginalSurface) {
  for (const bool shared : {false, true}) {
    for (const Shading shading : {Shading::Flat, Shading::Vertex, Shading::Corner}) {
      SceneDescription d = scene_of(ramp(kSlope, DisplacementMethod::Both), grid(8, shading));
      if (shared) {
        d.instances.push_back(d.instances[0]);
        d.instances[1].world_from_object = rows(glm::translate(Mat4(1.0f), Vec3(20, 0, 0)));
      }
      const auto scene = build(std::move(d));
      const ShadingPoint point = seen(*scene, 0.3f, 0.1f);
      EXPECT_NEAR(point.position.z, kSlope * 0.3f, 1e-5f);
      expect_near(shaded_normal(*scene, point), kTilted, 2e-3f);  // not tilted twice
    }
  }
}

TEST(Displacement, KeepsFlatFacesFlat) {
  MeshDescription mesh = grid(2, Shading::Corner);
  mesh.attributes.push_back({kFlatFaces, Domain::Face, 1, std::vector<float>(mesh.triangles.size(), 1.0f)});
  GraphBuilder g;  // a ridge: z = |x|
  const int geometry = g.node("ShaderNodeNewGeometry");
  const int parts = g.node("ShaderNodeSeparateXYZ", {linked_input("Vector", geometry, "Position")});
  const int size = g.node("ShaderNodeMath", {linked_input("Value", parts, "X")},
                          {text_property("operation", "ABSOLUTE")});
  const int node = g.node(
      "ShaderNodeDisplacement",
      {linked_input("Height", size, "Value"), value_input("Midlevel", 0.0f), value_input("Scale", 1.0f)},
      {text_property("space", "WORLD")});
  g.graph.displacement = {node, "Displacement"};
  const auto scene = build(scene_of(material(g, DisplacementMethod::Displacement), mesh));
  const ShadingPoint point = seen(*scene, 0.1f, 0.3f);
  EXPECT_NEAR(point.position.z, 0.1f, 1e-5f);
  expect_near(point.ns, point.ng, 1e-6f);
}

TEST(Displacement, LeavesGeneratedCoordinates) {
  for (const bool shared : {false, true}) {
    MaterialDescription m = lifted(0.75f);
    GraphBuilder g;
    g.graph = m.graph;
    const int coordinates = g.node("ShaderNodeTexCoord");
    g.emit(coordinates, "Generated");
    m.graph = g.graph;
    MeshDescription mesh = grid(4, Shading::Vertex);
    mesh.texture_space_size = Vec3(1.0f);
    SceneDescription d = scene_of(m, mesh);
    if (shared) d.instances.push_back(d.instances[0]);
    const auto scene = build(std::move(d));
    expect_near(scene->programs()[0].evaluate_emission(seen(*scene, 0.5f, 0.0f)), Vec3(0.75f, 0.5f, 0.5f), 1e-5f);
  }
}

TEST(Displacement, ThatIsNotFiniteIsReportedAndTheVertexStays) {
  Diagnostics diagnostics;
  const auto scene = build(scene_of(ramp(3e38f, DisplacementMethod::Displacement), grid(4, Shading::Vertex),
                                    glm::scale(Mat4(1.0f), Vec3(100.0f))),
                           &diagnostics);
  EXPECT_NEAR(seen(*scene, 30.0f, 10.0f).position.z, 0.0f, 1e-6f);
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_EQ(diagnostics[0].object, "Grid");
  EXPECT_EQ(diagnostics[0].message,
            "its displacement is not a finite number at 20 vertices, which stay where they are");
}

TEST(Displacement, IsInTheEstimateOfMemory) {
  for (const DisplacementMethod method :
       {DisplacementMethod::Bump, DisplacementMethod::Displacement, DisplacementMethod::Both}) {
    SceneDescription d = scene_of(ramp(0.5f, method), grid(100, Shading::Vertex));
    const auto part = [&] {
      for (const MemoryPart& p : estimate_memory(d).parts)
        if (p.what == "geometry") return p.bytes;
      return uint64_t(0);
    };
    const uint64_t estimated = part();
    SceneDescription plain = d;
    plain.materials[0].graph.displacement = {};
    const uint64_t added = estimated - [&] {
      d = plain;
      return part();
    }();
    d.materials[0] = ramp(0.5f, method);
    EXPECT_EQ(added, build(d)->statistics().geometry_bytes - build(plain)->statistics().geometry_bytes);
    EXPECT_EQ(added > 0, method != DisplacementMethod::Bump);
  }
}

TEST(Displacement, StartsFromTheOriginalMeshInEachScene) {
  const auto shared = std::make_shared<const MeshDescription>(grid(4, Shading::Vertex));
  const auto next = [&](MaterialDescription m, std::shared_ptr<Scene> previous) {
    SceneDescription d = scene_of(std::move(m), MeshDescription());
    d.meshes[0].shared = shared;
    return build(std::move(d), nullptr, std::move(previous));
  };
  std::shared_ptr<Scene> scene = next(lifted(0.5f, DisplacementMethod::Bump), nullptr);
  EXPECT_NEAR(seen(*scene, 0.3f, 0.1f).position.z, 0.0f, 1e-6f);
  for (const float height : {0.5f, 0.25f}) {
    scene = next(lifted(height), scene);
    EXPECT_NEAR(seen(*scene, 0.3f, 0.1f).position.z, height, 1e-6f);
  }
  scene = next(lifted(0.5f, DisplacementMethod::Bump), scene);
  EXPECT_NEAR(seen(*scene, 0.3f, 0.1f).position.z, 0.0f, 1e-6f);
}

// Vertices that are divided at the seam of a map would tear apart.
TEST(Displacement, LeavesVerticesUndivided) {
  MeshDescription mesh = grid(4, Shading::Corner);
  std::vector<float> uvs;
  for (size_t t = 0; t < mesh.triangles.size(); ++t)  // an island for each half
    for (int k = 0; k < 3; ++k)
      for (const float x : {mesh.positions[mesh.triangles[t][k]].x, t < mesh.triangles.size() / 2 ? 0.0f : 5.0f})
        uvs.push_back(x);
  mesh.attributes.push_back({"UVMap", Domain::Corner, 2, uvs});
  const size_t vertices = mesh.positions.size();
  const auto shared = std::make_shared<const MeshDescription>(std::move(mesh));
  const auto next = [&](MaterialDescription m, std::shared_ptr<Scene> previous) {
    SceneDescription d = scene_of(std::move(m), MeshDescription());
    d.meshes[0].shared = shared;
    return build(std::move(d), nullptr, std::move(previous));
  };
  std::shared_ptr<Scene> scene = next(lifted(0.5f, DisplacementMethod::Bump), nullptr);
  EXPECT_EQ(scene->meshes()[0].positions.size(), vertices + 5 + 1);
  EXPECT_TRUE(scene->meshes()[0].divided);
  scene = next(lifted(0.5f), scene);  // does not take over the divided mesh
  EXPECT_EQ(scene->meshes()[0].positions.size(), vertices + 1);
  EXPECT_FALSE(scene->meshes()[0].divided);
  scene = next(lifted(0.5f, DisplacementMethod::Bump), scene);
  EXPECT_EQ(scene->meshes()[0].positions.size(), vertices + 5 + 1);
}

}  // namespace
}  // namespace ajar::test_displacement
