// Adaptive subdivision in a scene: triangles, displacement, damaged meshes, files and the estimate of memory.
#include <gtest/gtest.h>

#include "description/archive.h"
#include "description/validate.h"
#include "graph_fixtures.h"
#include "math/random.h"
#include "render/memory_estimate.h"
#include "scene_fixtures.h"

namespace ajar::test_dice_meshes {

using namespace fixtures;

namespace {

/// A cube from -1 to 1 with adaptive subdivision by pixels.
MeshDescription cube(SubdivisionScheme scheme = SubdivisionScheme::CatmullClark) {
  MeshDescription mesh;
  mesh.name = "Cube";
  for (int i = 0; i < 8; ++i) mesh.positions.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  mesh.subdivision.scheme = scheme;
  mesh.subdivision.face_sizes.assign(6, 4);
  mesh.subdivision.corner_vertices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  return mesh;
}

/// Diffuse; moved outwards by a chequered height, so that the surface has steps.
MaterialDescription stepped(float height) {
  GraphBuilder g;
  const int geometry = g.node("ShaderNodeNewGeometry");
  const int checker = g.node("ShaderNodeTexChecker",
                             {linked_input("Vector", geometry, "Position"), value_input("Scale", 3.7f)});
  const int node = g.node(
      "ShaderNodeDisplacement",
      {linked_input("Height", checker, "Fac"), value_input("Midlevel", 0.0f), value_input("Scale", height)},
      {text_property("space", "WORLD")});
  g.graph.displacement = {node, "Displacement"};
  const int diffuse = g.node("ShaderNodeBsdfDiffuse", {value_input("Color", 0.5f)});
  g.graph.surface = {diffuse, "BSDF"};
  MaterialDescription m;
  m.name = "Moved";
  m.graph = g.graph;
  m.displacement_method = DisplacementMethod::Displacement;
  return m;
}

SceneDescription scene_of(MeshDescription mesh, float height = 0.0f) {
  SceneDescription d;
  d.materials.push_back(stepped(height));
  add_object(d, std::move(mesh), 0, Mat4(1.0f));
  set_camera(d, Vec3(0, 0, 10), Vec3(0.0f), 64);
  return d;
}

std::shared_ptr<Scene> built(SceneDescription d, Diagnostics* diagnostics = nullptr) {
  Diagnostics ignored;
  return Scene::build(std::move(d), {}, diagnostics ? *diagnostics : ignored);
}

}  // namespace

TEST(DiceMeshes, ASmoothCubeIsRound) {
  const auto scene = built(scene_of(cube()));
  EXPECT_GT(scene->statistics().triangles, 500u);
  Ray ray;
  ray.origin = Vec3(0.01f, 0.02f, 50.0f);
  ray.direction = Vec3(0, 0, -1);
  const Hit hit = scene->intersect(ray, kRayCamera);
  ASSERT_TRUE(hit.found());
  EXPECT_NEAR(50.0f - hit.t, 0.8395f, 0.005f);
}

TEST(DiceMeshes, DisplacedSurfacesStayClosed) {
  // From the inside, every ray must hit the surface, also where it has steps.
  for (const SubdivisionScheme scheme : {SubdivisionScheme::CatmullClark, SubdivisionScheme::Simple}) {
    const auto scene = built(scene_of(cube(scheme), 0.4f));
    Pcg32 rng(7);
    for (int i = 0; i < 200000; ++i) {
      Ray ray;
      ray.origin = Vec3(0.01f, -0.02f, 0.03f);
      const float z = 2.0f * rng.next_float() - 1.0f, phi = 2.0f * kPi * rng.next_float(), r = std::sqrt(1.0f - z * z);
      ray.direction = Vec3(r * std::cos(phi), r * std::sin(phi), z);
      ASSERT_TRUE(scene->intersect(ray, kRayDiffuse).found()) << i;
    }
  }
}

TEST(DiceMeshes, NearerInstancesAreFiner) {
  SceneDescription d = scene_of(cube());
  const uint64_t alone = built(SceneDescription(d))->statistics().triangles;
  InstanceDescription other = d.instances[0];
  other.world_from_object[11] = -30.0f;
  d.instances.push_back(other);
  EXPECT_EQ(built(SceneDescription(d))->statistics().triangles, alone);
  d.instances[0].world_from_object[11] = -30.0f;
  EXPECT_LT(built(SceneDescription(d))->statistics().triangles, alone / 4);
  d.dicing.camera = d.camera;
  d.dicing.camera.world_from_camera[11] = -20.0f;
  EXPECT_GE(built(SceneDescription(d))->statistics().triangles, alone / 2);
}

TEST(DiceMeshes, DamagedMeshesAreReported) {
  Diagnostics diagnostics;
  MeshDescription mesh = cube();
  mesh.positions[7].x = std::nanf("");
  mesh.subdivision.corner_vertices[0] = 99;
  mesh.subdivision.creased_edges = {{0, 1}, {0, 99}};
  mesh.subdivision.edge_sharpness = {3.0f, 1.0f};
  mesh.material_slots.assign(6, 0);
  const auto scene = built(scene_of(mesh), &diagnostics);
  EXPECT_GT(scene->statistics().triangles, 100u);
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_EQ(diagnostics[0].object, "Cube");
  EXPECT_EQ(diagnostics[0].message, "4 faces with invalid vertices left out.");
  mesh = cube();
  mesh.subdivision.face_sizes.push_back(4);
  EXPECT_EQ(built(scene_of(mesh), &diagnostics)->statistics().triangles, 0u);
}

TEST(DiceMeshes, FilesKeepTheFaces) {
  SceneDescription d = scene_of(cube());
  MeshDescription& mesh = d.meshes[0];
  mesh.subdivision.creased_edges = {{0, 1}};
  mesh.subdivision.edge_sharpness = {3.0f};
  mesh.subdivision.creased_vertices = {5};
  mesh.subdivision.vertex_sharpness = {2.0f};
  mesh.subdivision.flat_faces = {0, 1, 0, 0, 0, 0};
  mesh.subdivision.keep_corners = true;
  mesh.subdivision.in_pixels = false;
  mesh.subdivision.tangents = {".tangent:"};
  d.dicing.max_subdivisions = 5;
  const SceneDescription again = from_bytes(to_bytes(d));
  EXPECT_EQ(to_bytes(again), to_bytes(d));
  EXPECT_EQ(again.meshes[0].subdivision.edge_sharpness, mesh.subdivision.edge_sharpness);
  EXPECT_TRUE(from_bytes(to_bytes(d, 'H')).meshes[0].subdivision.empty());
}

TEST(DiceMeshes, TheEstimateOfMemoryCountsTriangles) {
  SceneDescription d = scene_of(cube(SubdivisionScheme::Simple));
  d.meshes[0].subdivision.edge_length = 0.1f;
  const auto scene = built(SceneDescription(d));
  const uint64_t measured = scene->statistics().geometry_bytes + scene->statistics().accel_bytes;
  for (const MemoryPart& part : estimate_memory(d).parts) {
    if (part.what != "geometry") continue;
    EXPECT_GT(part.bytes, measured / 3);
    EXPECT_LT(part.bytes, 4 * measured);
  }
}

TEST(DiceMeshes, TangentsBelongToTheTriangles) {
  SceneDescription d = scene_of(cube());
  d.meshes[0].subdivision.tangents = {".tangent:"};
  const auto scene = built(std::move(d));
  const BuiltMesh& mesh = scene->meshes()[0];
  const int index = mesh.find_attribute(".tangent:");
  ASSERT_GE(index, 0);
  EXPECT_EQ(mesh.attributes[size_t(index)].values.size(), 12 * mesh.triangles.size());
}

}  // namespace ajar::test_dice_meshes
