// Descriptions of small scenes for tests, built in code so that the correct results are known.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "math/frame.h"
#include "math/random.h"
#include "math/warps.h"
#include "scene/scene.h"

namespace ajar::fixtures {

inline std::array<float, 12> rows(const Mat4& m) {
  return {m[0][0], m[1][0], m[2][0], m[3][0], m[0][1], m[1][1], m[2][1], m[3][1], m[0][2], m[1][2], m[2][2], m[3][2]};
}

/// Camera at `eye` looking at `target`, square frame of `size` pixels, field of view 2 atan(half_extent).
inline void set_camera(SceneDescription& d, Vec3 eye, Vec3 target, int size, float half_extent = 0.5f) {
  const Vec3 back = glm::normalize(eye - target);
  const Vec3 helper = std::abs(back.z) < 0.9f ? Vec3(0, 0, 1) : Vec3(0, 1, 0);
  const Vec3 right = glm::normalize(glm::cross(helper, back)), up = glm::cross(back, right);
  d.camera.present = true;
  d.camera.name = "Camera";
  d.camera.clip_start = 1e-6f;
  d.camera.clip_end = 1e12f;
  d.camera.world_from_camera = rows(Mat4(Vec4(right, 0), Vec4(up, 0), Vec4(back, 0), Vec4(eye, 1)));
  d.camera.screen_window = Vec4(-half_extent, half_extent, -half_extent, half_extent);
  d.settings.width = d.settings.height = size;
}

inline Node closure_node(const std::string& type, Color color) {
  Node node;
  node.type = type;
  node.name = type;
  node.inputs.push_back({"Color", {}, Vec4(color, 1.0f)});
  return node;
}

/// Material of one diffuse closure, optionally adding emission of strength 1 and colour `emission`.
inline int add_diffuse(SceneDescription& d, Color albedo, Color emission = Color(0.0f)) {
  MaterialDescription material;
  material.name = "Material";
  material.graph.nodes.push_back(closure_node("ShaderNodeBsdfDiffuse", albedo));
  material.graph.surface = {0, "BSDF"};
  if (!is_black(emission)) {
    Node emit = closure_node("ShaderNodeEmission", emission);
    emit.inputs.push_back({"Strength", {}, Vec4(1.0f)});
    material.graph.nodes.push_back(emit);
    Node sum;
    sum.type = "ShaderNodeAddShader";
    sum.name = "Add Shader";
    sum.inputs.push_back({"Shader", {0, "BSDF"}, Vec4(0.0f)});
    sum.inputs.push_back({"Shader_001", {1, "Emission"}, Vec4(0.0f)});
    material.graph.nodes.push_back(sum);
    material.graph.surface = {2, "Shader"};
  }
  d.materials.push_back(material);
  return int(d.materials.size()) - 1;
}

inline void set_world(SceneDescription& d, Color color) { d.world.color = color; }

/// A world with a checker texture of colours `a` and `b`.
inline void set_checker_world(SceneDescription& d, Color a, Color b, float scale) {
  Node checker;
  checker.type = checker.name = "ShaderNodeTexChecker";
  checker.inputs = {{"Color1", {}, Vec4(a, 1)}, {"Color2", {}, Vec4(b, 1)}, {"Scale", {}, Vec4(scale)}};
  Node background;
  background.type = background.name = "ShaderNodeBackground";
  background.inputs = {{"Color", {0, "Color"}, Vec4(1.0f)}, {"Strength", {}, Vec4(1.0f)}};
  d.world.name = "World";
  d.world.graph.nodes = {checker, background};
  d.world.graph.surface = {1, "Background"};
}

/// Add the mesh as an object with one instance.
inline int add_object(SceneDescription& d, MeshDescription mesh, int material,
                      const Mat4& world_from_object = Mat4(1.0f)) {
  ObjectDescription object;
  object.name = mesh.name;
  object.mesh = int(d.meshes.size());
  object.materials = {material};
  d.meshes.push_back(std::move(mesh));
  d.objects.push_back(object);
  InstanceDescription instance;
  instance.object = int(d.objects.size()) - 1;
  instance.world_from_object = rows(world_from_object);
  d.instances.push_back(instance);
  return instance.object;
}

/// The axis-aligned cube [-1, 1]^3; normals outwards, or inwards for rooms.
inline MeshDescription cube(bool inwards = false) {
  MeshDescription mesh;
  mesh.name = "Cube";
  for (int i = 0; i < 8; ++i) mesh.positions.push_back(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  const uint32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : quads) {
    mesh.triangles.push_back(UVec3(q[0], q[1], q[2]));
    mesh.triangles.push_back(UVec3(q[0], q[2], q[3]));
  }
  if (inwards) {
    for (UVec3& t : mesh.triangles) std::swap(t.y, t.z);
  }
  return mesh;
}

/// The cube with generated coordinates in [0, 1]: a box in which a medium can be.
inline MeshDescription textured_cube() {
  MeshDescription mesh = cube();
  mesh.texture_space_size = Vec3(1.0f);  // half extents
  return mesh;
}

/// Strands through these points. All strands have the radius `root` at the root and `tip` at the tip.
inline MeshDescription hair(const std::vector<std::vector<Vec3>>& strands, float root, float tip,
                            StrandShape shape = StrandShape::Ribbon) {
  MeshDescription mesh;
  mesh.name = "Hair";
  mesh.strand_shape = shape;
  for (const std::vector<Vec3>& points : strands) {
    mesh.strands.push_back(uint32_t(mesh.positions.size()));
    for (size_t i = 0; i < points.size(); ++i) {
      mesh.positions.push_back(points[i]);
      mesh.radii.push_back(root + (tip - root) * float(i) / float(points.size() - 1));
    }
  }
  return mesh;
}

/// Curls from the middle of a ball outwards, with radii between 0.002 and 0.02.
inline MeshDescription curls(int count, StrandShape shape) {
  Pcg32 rng(5);
  std::vector<std::vector<Vec3>> strands;
  for (int i = 0; i < count; ++i) {
    const Vec3 out = warp::square_to_sphere({rng.next_float(), rng.next_float()});
    const Frame frame(out);
    std::vector<Vec3> points;
    for (int k = 0; k < 12; ++k) {
      const float turn = 0.9f * float(k);
      points.push_back(out * (0.5f + 0.1f * float(k)) + 0.1f * (frame.s * std::cos(turn) + frame.t * std::sin(turn)));
    }
    strands.push_back(points);
  }
  return hair(strands, 0.02f, 0.002f, shape);
}

/// A point cloud.
inline MeshDescription cloud(const std::vector<Vec3>& positions, const std::vector<float>& radii) {
  MeshDescription mesh;
  mesh.name = "Cloud";
  mesh.positions = positions;
  mesh.radii = radii;
  mesh.texture_space_location = mesh.texture_space_size = Vec3(0.5f);
  return mesh;
}

/// Points in the unit ball, with radii between `smallest` and three times of it.
inline MeshDescription random_cloud(int count, float smallest) {
  Pcg32 rng(9);
  std::vector<Vec3> positions;
  std::vector<float> radii;
  for (int i = 0; i < count; ++i) {
    positions.push_back(std::cbrt(rng.next_float()) * warp::square_to_sphere({rng.next_float(), rng.next_float()}));
    radii.push_back(smallest * (1.0f + 2.0f * rng.next_float()));
  }
  return cloud(positions, radii);
}

/// Square [-half, half]^2 in the plane z = 0, facing +z.
inline MeshDescription plane(float half) {
  MeshDescription mesh;
  mesh.name = "Plane";
  mesh.positions = {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}};
  mesh.triangles = {UVec3(0, 1, 2), UVec3(0, 2, 3)};
  return mesh;
}

/// Unit sphere of latitude-longitude triangles with smooth normals.
inline MeshDescription sphere(int rings = 24) {
  MeshDescription mesh;
  mesh.name = "Sphere";
  const int segments = 2 * rings;
  mesh.normal_domain = Domain::Vertex;
  for (int r = 0; r <= rings; ++r) {
    for (int s = 0; s < segments; ++s) {
      const float theta = kPi * float(r) / float(rings), phi = 2.0f * kPi * float(s) / float(segments);
      mesh.positions.push_back(Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)));
    }
  }
  mesh.normals = mesh.positions;
  for (int r = 0; r < rings; ++r) {
    for (int s = 0; s < segments; ++s) {
      const uint32_t a = uint32_t(r * segments + s), b = uint32_t(r * segments + (s + 1) % segments);
      mesh.triangles.push_back(UVec3(a, a + uint32_t(segments), b + uint32_t(segments)));
      mesh.triangles.push_back(UVec3(a, b + uint32_t(segments), b));
    }
  }
  return mesh;
}

inline LightDescription point_light(Vec3 position, float watts, float radius = 0.0f) {
  LightDescription light;
  light.name = "Light";
  light.energy = watts;
  light.radius = radius;
  light.world_from_light = rows(Mat4(Vec4(1, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(0, 0, 1, 0), Vec4(position, 1)));
  return light;
}

inline std::shared_ptr<const Scene> build(SceneDescription d, Diagnostics* diagnostics = nullptr, bool bake = true) {
  Diagnostics ignored;
  Scene::Options options;
  options.bake_single_instances = bake;
  return Scene::build(std::move(d), options, diagnostics ? *diagnostics : ignored);
}

/// `count` instances of a square side by side.
inline SceneDescription many_instances(int count) {
  SceneDescription d;
  d.lights.push_back(point_light(Vec3(0, 0, 5), 100.0f));
  set_camera(d, Vec3(0, -4, 1), Vec3(0), 16);
  const int object = add_object(d, plane(1.0f), add_diffuse(d, Color(0.5f)));
  for (int i = 0; i < count; ++i) {
    InstanceDescription instance;
    instance.object = object;
    instance.world_from_object = rows(Mat4(Vec4(1, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(0, 0, 1, 0),
                                           Vec4(float(i % 141) * 3.0f, float(i / 141) * 3.0f, 0, 1)));
    d.instances.push_back(instance);
  }
  return d;
}

/// Seconds to wait for a session. No test may depend on the machine's speed, so only a session that hangs reaches it.
constexpr double kHang = 3600.0;

}  // namespace ajar::fixtures
