// Extreme scenes, rendered by every integrator. All pixels are finite and not negative, and no sample is refused.
// Scenes that differ only in their units give the same image.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "integrators/integrator.h"
#include "render/session.h"
#include "transport/paths/path_vertex.h"
#include "transport_scenes.h"

namespace ajar::test_stress {

namespace {

using namespace fixtures;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();
constexpr int kSize = 8, kSamples = 4;
const std::atomic<bool> kGoOn{false};

const LightDescription kLamp = area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.5f, 8.0f);
const Mat4 kBall = moved(Vec3(0.2f, 0.3f, -0.4f), 0.4f);

SceneDescription lit_room() {
  SceneDescription d = grey_room(kSize);
  d.lights.push_back(kLamp);
  d.settings.photons = 500;
  return d;
}

/// An integrator, with settings of direct light, guiding and vertex merging.
struct Technique {
  std::string name, integrator;
  DirectMethod direct = DirectMethod::Mis;
  Guiding guiding = Guiding::Off;
  Merging merging = Merging::Off;
};
std::ostream& operator<<(std::ostream& out, const Technique& technique) { return out << technique.name; }

std::vector<Technique> techniques() {
  std::vector<Technique> all;
  for (const IntegratorInfo& info : integrator_list()) {
    if (std::string(info.name) != "auto") all.push_back({info.name, info.name});
    if (info.can_merge)
      all.push_back({std::string(info.name) + "_merging", info.name, DirectMethod::Mis, Guiding::Off, Merging::On});
  }
  for (const Choice<DirectMethod>& method : choices<DirectMethod>().all)
    if (method.value != DirectMethod::Mis) all.push_back({"path_" + std::string(method.name), "path", method.value});
  all.push_back({"path_guided", "path", DirectMethod::Mis, Guiding::On});
  return all;
}

/// The image by this technique, or by path tracing where the technique cannot render the scene, as in a session.
std::vector<float> picture(const Technique& by, SceneDescription d, uint32_t seed = 1, uint64_t* refused = nullptr) {
  d.settings.direct = by.direct;
  d.settings.guiding = by.guiding;
  d.settings.vertex_merging = by.merging;
  const auto scene = build(std::move(d));
  const auto technique = make_integrator(by.integrator);
  technique->prepare(scene, seed);
  const RenderSettings& s = scene->settings();
  Film film(0, 0, s.width, s.height, {"Combined"});
  technique->run_iteration(film, kSamples, kGoOn);
  if (refused) *refused = film.refused();
  return film.resolve("Combined", 1.0f);
}

double mean(const std::vector<float>& rgba) {
  double sum = 0.0;
  for (size_t i = 0; i < rgba.size(); ++i) sum += i % 4 == 3 ? 0.0 : double(rgba[i]);
  return sum / (0.75 * double(rgba.size()));
}

struct Stress {
  const char* name;
  void (*change)(SceneDescription&);
};
std::ostream& operator<<(std::ostream& out, const Stress& stress) { return out << stress.name; }

const Stress kStresses[] = {
    {"far_from_the_origin",
     [](SceneDescription& d) {
       const Vec3 away(16384.0f, -8192.0f, 4096.0f);
       add_object(d, sphere(), add_diffuse(d, Color(0.5f)), kBall);
       const auto move = [&](std::array<float, 12>& m) {
         for (int i = 0; i < 3; ++i) m[size_t(4 * i + 3)] += away[i];
       };
       for (InstanceDescription& instance : d.instances) move(instance.world_from_object);
       for (LightDescription& light : d.lights) move(light.world_from_light);
       move(d.camera.world_from_camera);
     }},
    {"triangles_of_no_area",
     [](SceneDescription& d) {
       MeshDescription needles = sphere();
       const uint32_t n = uint32_t(needles.positions.size());
       needles.positions.insert(needles.positions.end(), {{-1, 0, 0}, {1, 0, 0}, {0, 1e-7f, 0}});
       needles.normals.insert(needles.normals.end(), 3, Vec3(0, 0, 1));
       needles.triangles.insert(needles.triangles.end(), {UVec3(n, n + 1, n + 2), UVec3(n, n, n), UVec3(n, n + 1, n)});
       add_object(d, needles, add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.1f), kBall);
     }},
    {"a_lamp_of_triangles_of_no_area",
     [](SceneDescription& d) {
       MeshDescription shape = plane(0.2f);
       shape.positions.push_back(Vec3(0.0f));
       shape.triangles.insert(shape.triangles.end(), {UVec3(4, 4, 4), UVec3(0, 4, 2)});
       add_object(d, shape, add_diffuse(d, Color(0.5f), Color(2.0f)), moved(Vec3(0.0f, 0.3f, 0.5f)));
     }},
    {"surfaces_in_one_plane",
     [](SceneDescription& d) {
       for (int i = 0; i < 3; ++i)
         add_object(d, plane(0.6f), add_diffuse(d, Color(0.2f + 0.2f * float(i))), moved(Vec3(0, 0.2f, -0.6f)));
       add_object(d, sphere(), add_glass(d, 0.0f), kBall);
       add_object(d, sphere(), add_glass(d, 0.0f), kBall);
     }},
    {"invalid_vertices_normals_and_attributes",
     [](SceneDescription& d) {
       MeshDescription mesh = sphere();
       mesh.positions[30] = Vec3(kNan, 0, 0);
       mesh.positions[40] = Vec3(0, kInfinity, 0);
       mesh.normals[50] = Vec3(kNan);
       mesh.normals[60] = Vec3(0.0f);
       Attribute uv;
       uv.name = "UVMap";
       uv.values.assign(6 * mesh.triangles.size(), kNan);
       mesh.attributes.push_back(uv);
       add_object(d, mesh, add_glossy(d, 0.2f), kBall);
     }},
    {"invalid_pixels",
     [](SceneDescription& d) {
       ImageDescription image;
       image.name = "Broken";
       image.color_space = "Linear";
       image.width = image.height = 2;
       image.pixels = {kNan, 0, 0, 1, 0, kInfinity, 0, 1, -1, -1, -1, 1, 0.5f, 0.5f, 0.5f, kNan};
       d.images.push_back(image);
       GraphBuilder b;
       const int texture = b.node("ShaderNodeTexImage", {}, {number_property("image", {0.0f})});
       b.graph.surface = {b.node("ShaderNodeBsdfDiffuse", {linked_input("Color", texture, "Color")}), "BSDF"};
       add_object(d, sphere(), add_material(d, b), kBall);
     }},
    {"scales_of_zero_and_below",
     [](SceneDescription& d) {
       const int grey = add_diffuse(d, Color(0.5f));
       add_object(d, sphere(), grey, moved(Vec3(0.2f, 0.3f, -0.4f), 0.0f));
       add_object(d, sphere(), add_glass(d, 0.1f), moved(Vec3(0.2f, 0.3f, -0.4f), -0.4f));
       Mat4 flat = kBall;
       flat[2] = Vec4(0.0f);
       add_object(d, sphere(), grey, flat);
     }},
    {"empty_meshes",
     [](SceneDescription& d) {
       MeshDescription empty;
       empty.name = "Empty";
       add_object(d, empty, add_diffuse(d, Color(0.5f)));
     }},
    {"albedo_one", [](SceneDescription& d) { d.materials[0] = d.materials[size_t(add_diffuse(d, Color(1.0f)))]; }},
    {"albedo_zero",
     [](SceneDescription& d) {
       d.materials[0] = d.materials[size_t(add_diffuse(d, Color(0.0f)))];
       add_object(d, sphere(), add_glossy(d, 0.0f, Color(0.0f)), kBall);
     }},
    {"every_roughness",
     [](SceneDescription& d) {
       float x = -0.8f;
       for (float roughness : {0.0f, 1e-6f, 1e-3f, 0.01f, 0.999f, 1.0f}) {
         add_object(d, sphere(12), add_glossy(d, roughness, Color(1.0f)), moved(Vec3(x, 0.3f, -0.6f), 0.15f));
         add_object(d, sphere(12), add_glass(d, roughness), moved(Vec3(x, 0.3f, 0.0f), 0.15f));
         x += 0.32f;
       }
     }},
    {"odd_indices_of_refraction",
     [](SceneDescription& d) {
       float x = -0.8f;
       for (float ior : {0.0f, 0.5f, 0.999f, 1.0f, 1.0001f, 1000.0f}) {
         add_object(d, sphere(12), add_glass(d, 0.0f, ior), moved(Vec3(x, 0.3f, -0.5f), 0.15f));
         add_object(d, sphere(12), add_glass(d, 0.3f, ior), moved(Vec3(x, 0.3f, 0.0f), 0.15f));
         x += 0.32f;
       }
       add_object(d, sphere(12), add_glass(d, 0.0f, 1.3f), moved(Vec3(-0.8f, 0.3f, -0.5f), 0.1f));  // nested
     }},
    {"a_lamp_on_a_surface",
     [](SceneDescription& d) { d.lights[0].world_from_light = rows(shining(Vec3(0, 0, 1), Vec3(0, 0, -1))); }},
    {"a_lamp_within_a_lamp",
     [](SceneDescription& d) {
       d.lights.push_back(point_light(Vec3(0.2f, 0.3f, 0.4f), 2.0f, 0.3f));
       d.lights.push_back(point_light(Vec3(0.2f, 0.3f, 0.4f), 2.0f, 0.1f));
       d.lights.push_back(point_light(Vec3(0.2f, 0.3f, 0.4f), 2.0f));
       const int glow = add_diffuse(d, Color(0.5f), Color(1.0f));
       add_object(d, sphere(12), glow, moved(Vec3(-0.4f, 0.3f, 0.2f), 0.2f));
       add_object(d, sphere(12), glow, moved(Vec3(-0.4f, 0.3f, 0.2f), 0.1f));
     }},
    {"a_camera_inside_glass",
     [](SceneDescription& d) { add_object(d, sphere(), add_glass(d, 0.0f), moved(Vec3(0.1f, -0.9f, 0.1f), 0.05f)); }},
    {"a_camera_inside_a_lamp",
     [](SceneDescription& d) { d.lights.push_back(point_light(Vec3(0.1f, -0.9f, 0.1f), 2.0f, 0.2f)); }},
    {"ten_thousand_lamps",
     [](SceneDescription& d) {
       for (int i = 0; i < 10000; ++i)
         d.lights.push_back(
             point_light(Vec3(float(i % 100) / 51 - 0.97f, float(i / 100) / 51 - 0.97f, 0.9f), 1e-3f * float(i % 7)));
     }},
    {"lamps_of_no_extent_or_power",
     [](SceneDescription& d) {
       d.lights[0].area_size = Vec2(0.0f);
       LightDescription dark = kLamp;
       dark.energy = 0.0f;
       d.lights.push_back(dark);
       LightDescription spot = point_light(Vec3(0, 0, 0.5f), 5.0f);
       spot.kind = LightKind::Spot;
       spot.spot_angle = 0.0f;
       d.lights.push_back(spot);
     }},
    {"no_light", [](SceneDescription& d) { d.lights.clear(); }},
    {"no_geometry",
     [](SceneDescription& d) {
       d.instances.clear();
       d.objects.clear();
       d.meshes.clear();
     }},
    {"surfaces_through_each_other",
     [](SceneDescription& d) {
       const int glass = add_glass(d, 0.1f);
       for (int i = 0; i < 3; ++i)
         add_object(d, sphere(12), i == 1 ? add_diffuse(d, Color(0.5f)) : glass,
                    moved(Vec3(0.2f * float(i), 0.3f, -0.4f), 0.4f));
       add_object(d, cube(), add_glossy(d, 0.3f), moved(Vec3(0.0f, 0.3f, -1.0f), 0.3f));  // half below the floor
     }},
    {"a_lamp_in_a_closed_box",  // chains would start from samples without light
     [](SceneDescription& d) {
       d.lights[0] = area_lamp(Vec3(0.1f, 0.1f, 0.7f), Vec3(0, 0, -1), 0.4f, 8.0f);
       add_object(d, cube(), add_diffuse(d, Color(0.5f)), moved(Vec3(0.1f, 0.1f, 0.6f), 0.3f));
     }},
    {"a_lamp_in_a_tiny_box",  // its size is a hundred-thousandth of the distance, as for the shade of a street lamp
     [](SceneDescription& d) {
       d.lights[0] = point_light(Vec3(0.1f, 0.1f, 0.7f), 8.0f);
       add_object(d, cube(), add_diffuse(d, Color(0.0f)), moved(Vec3(0.1f, 0.1f, 0.7f), 2e-5f));
     }},
    {"a_lamp_in_a_tiny_box_in_fog",
     [](SceneDescription& d) {
       d.lights[0] = point_light(Vec3(0.1f, 0.1f, 0.7f), 8.0f, 5e-6f);
       add_object(d, cube(), add_diffuse(d, Color(0.0f)), moved(Vec3(0.1f, 0.1f, 0.7f), 2e-5f));
       GraphBuilder b;
       b.graph.volume = {
           b.node("ShaderNodeVolumeScatter", {value_input("Color", Vec4(0.8f)), value_input("Density", 0.5f)}),
           "Volume"};
       d.world.graph = b.graph;
       d.settings.bounces.volume = 2;
     }},
    {"a_lamp_behind_a_keyhole",
     [](SceneDescription& d) {
       MeshDescription box = cube();
       box.positions[0] += Vec3(0.02f, 0.0f, 0.0f);  // one corner has an opening of 0.02
       box.triangles[0] = UVec3(8, 2, 3);
       box.positions.push_back(Vec3(-0.98f, -1.0f, -1.0f));
       d.lights[0] = area_lamp(Vec3(0.1f, 0.1f, 0.7f), Vec3(0, 0, -1), 0.4f, 8.0f);
       add_object(d, box, add_diffuse(d, Color(0.9f)), moved(Vec3(0.1f, 0.1f, 0.6f), 0.3f));
     }},
    {"every_subsurface",
     [](SceneDescription& d) {
       float x = -0.8f;
       for (const float radius : {0.0f, 1e-9f, 0.1f, 1e6f, kNan}) {
         for (const float albedo : {0.0f, 0.8f, 1.0f}) {
           GraphBuilder b;
           b.graph.surface = {b.node("ShaderNodeSubsurfaceScattering",
                                     {value_input("Color", Vec4(albedo, 0.5f, 1.0f, 1.0f)), value_input("Scale", 1.0f),
                                      value_input("Radius", Vec4(radius, 0.05f, radius, 0.0f))}),
                              "BSSRDF"};
           add_object(d, sphere(8), add_material(d, b), moved(Vec3(x, 0.4f, 0.3f * (albedo - 1.0f)), 0.1f));
         }
         x += 0.35f;
       }
     }},
    {"every_volume",
     [](SceneDescription& d) {
       float x = -0.8f;
       const auto add = [&](float density, float anisotropy, float emission, bool varies) {
         GraphBuilder b;
         NodeInput amount = value_input("Density", density);
         if (varies) {
           const int coordinates = b.node("ShaderNodeTexCoord");
           const int times = b.node(
               "ShaderNodeMath", {linked_input("Value", coordinates, "Generated"), value_input("Value_001", density)},
               {text_property("operation", "MULTIPLY")});
           amount = linked_input("Density", times, "Value");
         }
         b.graph.volume = {
             b.node("ShaderNodeVolumePrincipled",
                    {value_input("Color", Vec4(0.9f, 0.5f, 1.0f, 1.0f)), amount, value_input("Anisotropy", anisotropy),
                     value_input("Emission Strength", emission), value_input("Emission Color", Vec4(1.0f))}),
             "Volume"};
         add_object(d, sphere(8), add_material(d, b), moved(Vec3(x, 0.3f, varies ? -0.3f : -0.6f), 0.15f));
       };
       for (const float density : {0.0f, 1e-9f, 1.0f, 1e12f, -1.0f, kNan, kInfinity}) {
         add(density, 0.99999f, 0.0f, false);
         add(density, -1.0f, 0.1f, true);
         x += 0.25f;  // neighbours overlap
       }
       d.settings.bounces.volume = 8;
     }},
    {"a_camera_inside_fog_without_end",
     [](SceneDescription& d) {
       GraphBuilder b;
       b.graph.volume = {
           b.node("ShaderNodeVolumeScatter",
                  {value_input("Color", Vec4(1.0f)), value_input("Density", 3.0f), value_input("Anisotropy", 0.9f)}),
           "Volume"};
       d.world.graph = b.graph;
       d.settings.bounces.volume = 64;
     }},
    {"objects_that_move",
     [](SceneDescription& d) {
       const int grey = add_diffuse(d, Color(0.5f));
       const auto add = [&](const Mat4& from, const Mat4& to) {
         add_object(d, sphere(8), grey, from);
         d.instances.back().first_motion_key = int(d.motion_keys.size());
         d.instances.back().motion_key_count = 2;
         d.motion_keys.insert(d.motion_keys.end(), {rows(from), rows(to)});
       };
       add(moved(Vec3(-0.5f, 0.3f, -0.5f), 0.2f), moved(Vec3(1e6f, 0.3f, -0.5f), 0.2f));
       add(moved(Vec3(0.0f, 0.3f, -0.5f), 0.2f), moved(Vec3(0.0f, 0.3f, -0.5f), -0.2f));  // the scale passes zero
       add(moved(Vec3(0.5f, 0.3f, -0.5f), 0.2f), moved(Vec3(0.5f, 0.3f, -0.5f), 0.0f));
       Mat4 flat = moved(Vec3(0.8f, 0.3f, 0.0f), 0.2f);
       flat[2] = Vec4(0.0f);
       for (const Mat4& to : {moved(Vec3(0.5f, 0.3f, 0.0f), 0.0f), flat}) {  // a third key is equal to the second
         add(moved(Vec3(0.5f, 0.3f, 0.0f), 0.2f), to);
         d.motion_keys.push_back(rows(to));
         ++d.instances.back().motion_key_count;
       }
       const int shared = d.instances.back().object;  // instances of one mesh with very small scales
       for (const float scale : {1e-6f, 1e-11f, 1e-13f, 1e-20f, 1e-38f}) {
         InstanceDescription instance;
         instance.object = shared;
         instance.world_from_object = rows(moved(Vec3(0.0f, 0.3f, 0.3f), scale));
         d.instances.push_back(instance);
       }
       d.camera.motion = {d.camera.world_from_camera, d.camera.world_from_camera};
       d.camera.motion[1][3] += 0.1f;
     }},
    {"one_pixel", [](SceneDescription& d) { d.settings.width = d.settings.height = 1; }},
    {"one_row",
     [](SceneDescription& d) {
       d.settings.width = 16384;
       d.settings.height = 1;
     }},
};

/// Factors of length and power in a scene that otherwise equals the plain one.
struct Units {
  const char* name;
  float length, watts;
};
std::ostream& operator<<(std::ostream& out, const Units& units) { return out << units.name; }
// Floats are scaled by powers of two without rounding, so that only a constant with the unit of a length or a power can
// cause a difference.
const Units kUnits[] = {{"hundredths_of_a_millimetre", 0x1p-17f, 1.0f},
                        {"thousand_kilometres", 0x1p20f, 1.0f},
                        {"dim", 1.0f, 0x1p-20f},
                        {"blinding", 1.0f, 0x1p40f}};

SceneDescription in_units(const Units& units) {
  SceneDescription d = lit_room();
  add_object(d, sphere(), add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.2f), kBall);
  add_object(d, sphere(), add_glass(d, 0.0f), moved(Vec3(-0.4f, 0.3f, -0.6f), 0.3f));
  const auto scale = [&](std::array<float, 12>& m, bool all) {
    for (size_t i = 0; i < 12; ++i) m[i] *= all || i % 4 == 3 ? units.length : 1.0f;
  };
  for (InstanceDescription& instance : d.instances) scale(instance.world_from_object, true);
  for (LightDescription& light : d.lights) {
    scale(light.world_from_light, false);
    light.area_size *= units.length;
    light.energy *= units.watts * units.length * units.length;
  }
  scale(d.camera.world_from_camera, false);
  d.camera.clip_start *= units.length;
  d.camera.clip_end *= units.length;
  d.settings.exposure = 1.0f / units.watts;  // the brightness of the displayed image is the same
  return d;
}

using Case = std::tuple<Technique, Stress>;
class StressTest : public testing::TestWithParam<Case> {};

TEST_P(StressTest, gives_a_valid_image) {
  const auto& [technique, stress] = GetParam();
  SceneDescription d = lit_room();
  stress.change(d);
  const std::string name = stress.name;
  // Control variates, media above their majorant and plain photons of MPS give negative samples; the mean is positive.
  const bool signed_samples = std::string(name_of(technique.direct)).starts_with("ocv") ||
                              technique.direct == DirectMethod::Correlated || technique.integrator == "mps" ||
                              name == "every_volume";
  uint64_t refused = 1;
  const std::vector<float> image = picture(technique, std::move(d), 1, &refused);
  EXPECT_EQ(refused, 0u);
  for (float value : image) {
    ASSERT_TRUE(std::isfinite(value));
    ASSERT_TRUE(signed_samples || value >= 0.0f) << value;
  }
  const std::set<std::string> dark{"no_light",
                                   "no_geometry",
                                   "albedo_zero",
                                   "lamps_of_no_extent_or_power",
                                   "a_lamp_in_a_closed_box",
                                   "a_lamp_in_a_tiny_box",
                                   "a_lamp_in_a_tiny_box_in_fog"};
  if (name == "a_lamp_behind_a_keyhole" || technique.direct == DirectMethod::Bsdf)
    return;  // few samples may or may not find the lamp
  // By rounding, two points on different sides of a wall can see each other at grazing angles: cosines of 1e-8 give a
  // radiance of 1e-14.
  EXPECT_EQ(mean(image) > 1e-10, !dark.count(name)) << "mean " << mean(image);
}

std::string case_name(const testing::TestParamInfo<Case>& info) {
  return std::get<0>(info.param).name + "_" + std::get<1>(info.param).name;
}
INSTANTIATE_TEST_SUITE_P(Scenes, StressTest,
                         testing::Combine(testing::ValuesIn(techniques()), testing::ValuesIn(kStresses)), case_name);

using UnitsCase = std::tuple<Technique, Units>;
class UnitsTest : public testing::TestWithParam<UnitsCase> {};

TEST_P(UnitsTest, give_the_same_image) {
  const auto& [technique, units] = GetParam();
  uint64_t refused = 1;
  const std::vector<float> plain = picture(technique, in_units({"plain", 1.0f, 1.0f})),
                           image = picture(technique, in_units(units), 1, &refused);
  EXPECT_EQ(refused, 0u);
  // If one ray passes an edge on the other side, the rest of a chain is different. This happens with few seeds.
  const std::set<std::string> of_chains{"mps", "metropolis", "erpt", "pmc_pt"};
  if (of_chains.count(technique.integrator)) {
    std::vector<double> ratios{mean(image) / (double(units.watts) * mean(plain))};
    for (uint32_t seed = 2; seed < 6; ++seed)
      ratios.push_back(mean(picture(technique, in_units(units), seed)) /
                       (double(units.watts) * mean(picture(technique, in_units({"plain", 1.0f, 1.0f}), seed))));
    std::sort(ratios.begin(), ratios.end());
    EXPECT_NEAR(ratios[2], 1.0, 0.01);
    return;
  }
  EXPECT_NEAR(mean(image) / double(units.watts), mean(plain), 0.01 * mean(plain));
  double difference = 0.0;
  for (size_t i = 0; i < image.size(); ++i)
    if (i % 4 != 3) difference += std::abs(double(image[i]) / double(units.watts) - double(plain[i]));
  EXPECT_LT(difference / (0.75 * double(image.size())), 1e-3 * mean(plain));
}

std::string units_name(const testing::TestParamInfo<UnitsCase>& info) {
  return std::get<0>(info.param).name + "_" + std::get<1>(info.param).name;
}
INSTANTIATE_TEST_SUITE_P(Scenes, UnitsTest,
                         testing::Combine(testing::ValuesIn(techniques()), testing::ValuesIn(kUnits)), units_name);

TEST(Stress, invalid_scenes_are_refused_with_a_message) {
  const auto refusal = [](void (*change)(SceneDescription&)) -> std::string {
    SceneDescription d = lit_room();
    change(d);
    try {
      build(std::move(d));
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refusal([](SceneDescription& d) { d.camera.present = false; }).find("camera"), std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& d) { d.camera.clip_end = d.camera.clip_start; }).find("Clip End"),
            std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& d) { d.camera.world_from_camera[3] = kNan; }).find("Camera"),
            std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& d) { d.settings.width = 0; }).find("'width'"), std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& d) { d.settings.samples = 0; }).find("would never end"), std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& d) {
              d.settings.samples = 0, d.settings.seconds = double(kNan);
            }).find("would never end"),
            std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& d) {
              d.settings.samples = 0, d.settings.target_error = double(kNan);
            }).find("would never end"),
            std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& d) { d.settings.exposure = kInfinity; }).find("exposure"), std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& d) {
              d.settings.gather_rays = std::numeric_limits<int>::max();
            }).find("'gather_rays'"),
            std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& d) {
              d.settings.direct_samples = std::numeric_limits<int>::max();
            }).find("'direct_samples'"),
            std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& d) { d.camera.aperture_radius = kInfinity; }).find("aperture"),
            std::string::npos);
  EXPECT_NE(refusal([](SceneDescription& d) {
              d.camera.aperture_radius = 0.1f, d.camera.aperture_ratio = 0.0f;
            }).find("aperture"),
            std::string::npos);
}

/// Sums of limits must not overflow, since some users enter the maximum integer for "no limit".
TEST(Stress, limits_of_the_maximum_integer_do_not_overflow) {
  SceneDescription d = lit_room();
  constexpr int kMax = std::numeric_limits<int>::max();
  d.settings.bounces = {kMax, kMax, kMax, kMax, kMax, kMax};
  d.settings.threads = kMax;
  d.settings.samples = 1;
  EXPECT_EQ(max_path_vertices(build(d)->settings().bounces), kMaxPathVertices);
  for (const char* integrator : {"path", "bdpt", "photon_map"}) {
    d.settings.integrator = integrator;
    Session session;
    session.start(d);
    ASSERT_TRUE(session.wait(kHang));
    EXPECT_EQ(session.take_error(), "");
    EXPECT_GT(mean(session.snapshot("Combined")), 0.0) << integrator;
  }
}

TEST(Stress, filter_widths_are_limited_to_the_image_size) {
  SceneDescription d = lit_room();
  d.settings.width = d.settings.height = 8;
  d.settings.filter = FilterKind::Gaussian;
  d.settings.samples = 2;
  for (const char* integrator : {"path", "metropolis"}) {
    d.settings.integrator = integrator;
    for (const float width : {1.5e38f, 1001.0f}) {
      d.settings.filter_width = width;
      Session session;
      session.start(d);
      ASSERT_TRUE(session.wait(kHang));
      EXPECT_NE(session.take_error().find("filter"), std::string::npos) << integrator << ", " << width;
    }
    // A region of one pixel, far from the corner of the image, with very small filter widths.
    SceneDescription pixel = d;
    pixel.settings.width = 65536;
    pixel.settings.region = {60001, 3, 60002, 4};
    for (const float width : {1000.0f, 1e-38f, 0.0f, -1.0f, std::nanf("")}) {
      SceneDescription& filtered = width > 1.0f ? d : pixel;
      filtered.settings.filter_width = width;
      Session session;
      session.start(filtered);
      ASSERT_TRUE(session.wait(kHang));
      EXPECT_EQ(session.take_error(), "");
      EXPECT_GT(mean(session.snapshot("Combined")), 0.0) << integrator << ", " << width;
    }
  }
}

TEST(Stress, a_million_instances_are_rendered) {
  constexpr int kSide = 1000;
  SceneDescription d = lit_room();
  const int object = add_object(d, plane(0.4f / kSide), add_diffuse(d, Color(0.5f)));
  d.instances.pop_back();
  for (int i = 0; i < kSide * kSide; ++i) {
    InstanceDescription instance;
    instance.object = object;
    instance.world_from_object = rows(moved(Vec3(float(i % kSide) / kSide - 0.5f, float(i / kSide) / kSide, -0.5f)));
    d.instances.push_back(instance);
  }
  uint64_t refused = 1;
  const std::vector<float> image = picture(techniques()[0], std::move(d), 1, &refused);
  EXPECT_EQ(refused, 0u);
  for (float value : image) ASSERT_TRUE(std::isfinite(value) && value >= 0.0f);
  EXPECT_GT(mean(image), 0.0);
}

/// Ten million samples of 0.1 in one pixel. A sum in floats would not grow beyond 2^24 ulps; the mean must not drift.
TEST(Stress, ten_million_samples_in_a_pixel_do_not_drift) {
  Film film(0, 0, 1, 1, {"Combined"});
  for (int i = 0; i < 10'000'000; ++i) film.add_sample(0, 0, Color(0.1f, 1e-3f, 12345.678f), 1.0f, nullptr);
  const std::vector<float> rgba = film.resolve("Combined", 1.0f);
  EXPECT_FLOAT_EQ(rgba[0], 0.1f);
  EXPECT_FLOAT_EQ(rgba[1], 1e-3f);
  EXPECT_FLOAT_EQ(rgba[2], 12345.678f);
}

}  // namespace

}  // namespace ajar::test_stress
