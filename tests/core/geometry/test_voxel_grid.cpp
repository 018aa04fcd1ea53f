#include <gtest/gtest.h>

#include <cmath>

#include "agreement.h"
#include "description/archive.h"
#include "description/validate.h"
#include "geometry/voxel_grid.h"
#include "transport/media/media.h"

namespace ajar::test_voxel_grid {

using namespace fixtures;

namespace {

/// A grid whose bricks fill the box of `low` to `high` (in bricks, exclusive), with a value for each voxel.
template <class Value>
VolumeGrid filled(const char* name, int low, int high, Value&& value, int components = 1) {
  VolumeGrid grid;
  grid.name = name;
  grid.components = components;
  for (int bz = low; bz < high; ++bz)
    for (int by = low; by < high; ++by)
      for (int bx = low; bx < high; ++bx) {
        grid.bricks.push_back({bx, by, bz});
        for (int z = 0; z < 8; ++z)
          for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 8; ++x)
              for (int c = 0; c < components; ++c)
                grid.values.push_back(value(Vec3(float(8 * bx + x), float(8 * by + y), float(8 * bz + z)), c));
      }
  return grid;
}

/// A cube of two metres with a volume of this material, and its grids.
SceneDescription cube_with_grid(float density, VolumeGrid grid) {
  GraphBuilder b;
  b.graph.volume = {b.node("ShaderNodeVolumePrincipled",
                           {value_input("Density", density), value_input("Color", Vec4(0.0f, 0.0f, 0.0f, 1.0f))},
                           {text_property("Density Attribute", "density")}),
                    "Volume"};
  SceneDescription d;
  MeshDescription mesh = cube();
  mesh.grids.push_back(std::move(grid));
  d.meshes.push_back(std::move(mesh));
  d.materials.push_back({"fog", b.graph});
  d.objects.push_back({.name = "cloud", .mesh = 0, .materials = {0}});
  d.instances.push_back({.object = 0});
  set_camera(d, Vec3(0.0f, -4.0f, 1.0f), Vec3(0.0f), 16);
  return d;
}

}  // namespace

TEST(VoxelGrid, interpolates_linear_functions_exactly_and_across_bricks) {
  const auto value = [](Vec3 v, int c) { return 1.0f + 0.5f * v.x - 0.25f * v.y + 0.125f * v.z + float(c); };
  VolumeGrid description = filled("v", -1, 2, value, 3);
  description.index_from_object = {2, 0, 0, 1, 0, 4, 0, 0, 0, 0, 1, -3};
  const VoxelGrid grid(description);
  for (int i = 0; i < 200; ++i) {
    Pcg32 rng(uint64_t(i), 7);
    const Vec3 index = Vec3(-8.0f) + Vec3(rng.next_float(), rng.next_float(), rng.next_float()) * 23.0f;
    const Vec4 found = grid.at(Vec3((index.x - 1.0f) / 2.0f, index.y / 4.0f, index.z + 3.0f));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], value(index, c), 1e-4f) << index.x << " " << index.y;
    EXPECT_EQ(found.w, 1.0f);
  }
}

TEST(VoxelGrid, colours_are_divided_by_alpha_after_the_interpolation) {
  // Red where alpha is large, blue where it is small, both multiplied by it.
  const auto value = [](Vec3 v, int c) {
    const float alpha = v.x < 1.0f ? 0.75f : v.x < 2.0f ? 0.25f : 0.0f;
    return c == 3 ? alpha : c == 0 ? (v.x < 1.0f ? alpha : 0.0f) : c == 2 ? (v.x < 1.0f ? 0.0f : alpha) : 0.0f;
  };
  const VoxelGrid grid(filled("color", 0, 1, value, 4));
  const auto expect = [&](float x, Vec4 wanted) {
    const Vec4 found = grid.at(Vec3(x, 2.5f, 2.5f));
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(found[k], wanted[k], 1e-6f) << "component " << k << " at " << x;
  };
  expect(0.0f, Vec4(1.0f, 0.0f, 0.0f, 0.75f));
  expect(0.5f, Vec4(0.75f, 0.0f, 0.25f, 0.5f));
  expect(1.5f, Vec4(0.0f, 0.0f, 1.0f, 0.125f));  // empty voxels do not darken the border
  expect(4.0f, Vec4(0.0f));
}

TEST(VoxelGrid, is_zero_outside_its_bricks) {
  const VoxelGrid grid(filled("v", 0, 1, [](Vec3, int) { return 2.0f; }));
  EXPECT_EQ(grid.at(Vec3(3.5f)), Vec4(2.0f, 2.0f, 2.0f, 1.0f));
  EXPECT_FLOAT_EQ(grid.at(Vec3(7.25f, 3.0f, 3.0f)).x, 1.5f);
  EXPECT_EQ(grid.at(Vec3(8.0f, 3.0f, 3.0f)).x, 0.0f);
  EXPECT_FLOAT_EQ(grid.at(Vec3(-0.5f, 3.0f, 3.0f)).x, 1.0f);
  for (const float far : {1e20f, -kInfinity, std::nanf("")}) EXPECT_EQ(grid.at(Vec3(far, 0.0f, 0.0f)).x, 0.0f);
}

TEST(VoxelGrid, a_damaged_grid_is_ignored_with_its_name) {
  const auto one = [](Vec3, int) { return 1.0f; };
  const auto refused = [&](auto&& damage) {
    SceneDescription d = cube_with_grid(1.0f, filled("density", 0, 2, one));
    damage(d.meshes[0].grids[0]);
    Diagnostics diagnostics;
    validate(d, diagnostics);
    bool named = false;
    for (const Diagnostic& item : diagnostics) named |= item.message.find("'density'") != std::string::npos;
    return named && d.meshes[0].grids.empty();
  };
  EXPECT_FALSE(refused([](VolumeGrid&) {}));
  EXPECT_FALSE(refused([](VolumeGrid& g) { g.values[3] = std::nanf(""); }));
  EXPECT_TRUE(refused([](VolumeGrid& g) { g.values.pop_back(); }));
  EXPECT_TRUE(refused([](VolumeGrid& g) { g.components = 2; }));
  EXPECT_TRUE(refused([](VolumeGrid& g) { g.bricks[1] = g.bricks[0]; }));
  EXPECT_TRUE(refused([](VolumeGrid& g) { g.bricks[1] = {1 << 30, 0, 0}; }));
  EXPECT_TRUE(refused([](VolumeGrid& g) { g.index_from_object = {}; }));
  EXPECT_TRUE(refused([](VolumeGrid& g) { g.index_from_object[3] = kInfinity; }));
}

TEST(VoxelGrid, the_transmittance_through_a_grid_is_that_of_its_densities) {
  // The density grows along x from 0 to 1 across the cube, so that a ray along x has an optical depth of 2.
  VolumeGrid grid = filled("density", -1, 3, [](Vec3 v, int) { return std::clamp(v.x / 16.0f, 0.0f, 1.0f); });
  grid.index_from_object = {8, 0, 0, 8, 0, 8, 0, 8, 0, 0, 8, 8};
  for (const bool scaled : {false, true}) {
    SceneDescription d = cube_with_grid(2.0f, grid);
    if (scaled) {  // twice as large: the optical depth stays
      d.instances[0].world_from_object = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0};
      d.meshes[0].density_in_object_space = true;
    }
    Diagnostics diagnostics;
    const auto scene = Scene::build(std::move(d), {}, diagnostics);
    const Media media(*scene);
    Ray ray;
    ray.origin = Vec3(-5.0f, 0.1f, 0.2f);
    ray.direction = Vec3(1.0f, 0.0f, 0.0f);
    MediaCounters counters;
    Pcg32 rng(1, 2);
    double sum = 0.0, squares = 0.0;
    constexpr int kRays = 240000;
    for (int i = 0; i < kRays; ++i) {
      const float through = media.transmittance_to_light(ray, {}, {}, rng, counters).x;
      sum += through;
      squares += double(through) * through;
    }
    const double mean = sum / kRays, error = std::sqrt((squares / kRays - mean * mean) / kRays);
    EXPECT_NEAR(mean, std::exp(-2.0), 4.0 * error) << scaled;
    EXPECT_LT(error, 0.005 * mean);
    EXPECT_EQ(counters.exceeded, 0u);  // majorants come from the voxels
  }
}

namespace {

/// A thin sheet of density around the middle of the cube across x, and a velocity along x that grows with x.
SceneDescription flowing_sheet(float scale, float frame) {
  const auto in_object = [](Vec3 v) { return v / 8.0f - 1.0f; };
  VolumeGrid density = filled("density", -1, 3,
                              [&](Vec3 v, int) { return std::abs(v.x - 8.0f) <= 1.0f ? 1.0f : 0.0f; }),
             velocity = filled(
                 "flow", -1, 3, [&](Vec3 v, int c) { return c == 0 ? 0.5f + 0.25f * in_object(v).x : 0.0f; }, 3);
  density.index_from_object = velocity.index_from_object = {8, 0, 0, 8, 0, 8, 0, 8, 0, 0, 8, 8};
  SceneDescription d = cube_with_grid(3.0f, std::move(density));
  d.meshes[0].grids.push_back(std::move(velocity));
  d.meshes[0].flow = {"flow", scale, frame};
  return d;
}

}  // namespace

TEST(VoxelGrid, a_volume_flows_with_its_velocity) {
  for (const auto& [scale, frame, turned] : {std::tuple(0.8f, 0.5f, false), {-1.0f, 0.0f, false}, {0.6f, 1.0f, true}}) {
    SceneDescription d = flowing_sheet(scale, frame);
    // A turn by 90 degrees about z, and twice the size.
    if (turned) d.instances[0].world_from_object = {0, -2, 0, 0, 2, 0, 0, 0, 0, 0, 2, 0};
    Diagnostics diagnostics;
    const auto scene = Scene::build(std::move(d), {}, diagnostics);
    EXPECT_TRUE(scene->moves());
    const Media media(*scene);
    MediaCounters counters;
    Pcg32 rng(1, 2);
    // Rays along y of the object, from x to x, at the time t.
    for (const float x : {-0.4f, -0.1f, 0.05f, 0.3f})
      for (const float t : {0.0f, 0.3f, 1.0f}) {
        const auto u = [](double at) { return 0.5 + 0.25 * at; };
        const double moved = double(scale) * (double(t) - double(frame));
        const double place = double(x) - moved * u(double(x) - moved * u(double(x)));
        const double voxels = std::abs(8.0 * place);  // from the middle of the sheet
        const double depth = 3.0 * 2.0 * (turned ? 2.0 : 1.0) * std::clamp(2.0 - voxels, 0.0, 1.0);
        Ray ray;
        ray.origin = turned ? Vec3(10.0f, 2.0f * x, 0.0f) : Vec3(x, -5.0f, 0.0f);
        ray.direction = turned ? Vec3(-1.0f, 0.0f, 0.0f) : Vec3(0.0f, 1.0f, 0.0f);
        ray.time = t;
        ShadingPoint path;
        double sum = 0.0, squares = 0.0;
        constexpr int kRays = 4000;
        for (int i = 0; i < kRays; ++i) {
          const double through = double(media.transmittance_to_light(ray, {}, path, rng, counters).x);
          sum += through;
          squares += through * through;
        }
        const double mean = sum / kRays, error = std::sqrt(std::max(squares / kRays - mean * mean, 0.0) / kRays);
        EXPECT_NEAR(mean, std::exp(-depth), 4.0 * error + 2e-3) << x << " " << t << " " << turned;
      }
    EXPECT_EQ(counters.exceeded, 0u);  // majorants include the neighbourhood that flows in
  }
}

TEST(VoxelGrid, a_volume_without_flow_does_not_move) {
  SceneDescription d = flowing_sheet(0.0f, 0.5f);
  Diagnostics diagnostics;
  EXPECT_FALSE(Scene::build(std::move(d), {}, diagnostics)->moves());
  EXPECT_TRUE(diagnostics.empty());
}

TEST(VoxelGrid, a_damaged_flow_is_ignored_with_the_name_of_its_mesh) {
  const auto refused = [&](VolumeFlow flow) {
    SceneDescription d = flowing_sheet(1.0f, 0.5f);
    d.meshes[0].name = "smoke";
    d.meshes[0].flow = flow;
    Diagnostics diagnostics;
    validate(d, diagnostics);
    return diagnostics.size() == 1 && diagnostics[0].object == "smoke" && d.meshes[0].flow.velocity.empty();
  };
  EXPECT_FALSE(refused({"flow", 2.0f, 1.0f}));
  EXPECT_TRUE(refused({"none", 1.0f, 0.5f}));
  EXPECT_TRUE(refused({"density", 1.0f, 0.5f}));
  EXPECT_TRUE(refused({"flow", kInfinity, 0.5f}));
  EXPECT_TRUE(refused({"flow", 1.0f, std::nanf("")}));
}

TEST(VoxelGrid, the_flow_is_kept_in_a_file) {
  SceneDescription d = flowing_sheet(0.25f, 1.0f);
  const SceneDescription read = from_bytes(to_bytes(d));
  EXPECT_EQ(read.meshes[0].flow.velocity, "flow");
  EXPECT_EQ(read.meshes[0].flow.scale, 0.25f);
  EXPECT_EQ(read.meshes[0].flow.frame, 1.0f);
}

}  // namespace ajar::test_voxel_grid
