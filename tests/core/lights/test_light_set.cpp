// Tests of every light: its samples against its density, its irradiance against closed forms, and its rays against
// samples from receivers.
#include "statistical.h"

#include "lights/sources/lamp.h"
#include "math/warps.h"
#include "scene_fixtures.h"
#include "shading/functions/ies.h"

namespace ajar::test_light_set {

namespace {

using namespace statistical;
using namespace fixtures;

// ---- Scenes -----------------------------------------------------------------------

Mat4 placed(Vec3 position, Vec3 shines, Vec3 scale = Vec3(1.0f)) {
  const Frame frame(-glm::normalize(shines), Vec3(1.0f, 0.2f, 0.1f));
  return Mat4(Vec4(frame.s * scale.x, 0), Vec4(frame.t * scale.y, 0), Vec4(frame.n * scale.z, 0), Vec4(position, 1));
}

LightDescription lamp(LightKind kind, const Mat4& matrix, float energy = 10.0f) {
  LightDescription light;
  light.name = "Lamp";
  light.kind = kind;
  light.world_from_light = rows(matrix);
  light.energy = energy;
  light.color = Color(1.0f, 0.5f, 0.25f);
  return light;
}

LightDescription area_lamp(AreaShape shape, Vec2 size, const Mat4& matrix, float spread = kPi) {
  LightDescription light = lamp(LightKind::Area, matrix);
  light.area_shape = shape;
  light.area_size = size;
  light.spread = spread;
  return light;
}

LightDescription spot(const Mat4& matrix, float radius, float angle = 1.0f, float blend = 0.3f) {
  LightDescription light = lamp(LightKind::Spot, matrix);
  light.radius = radius;
  light.spot_angle = angle;
  light.spot_blend = blend;
  return light;
}

LightDescription softened(LightDescription light) {
  light.soft_falloff = true;
  return light;
}

LightDescription evened(LightDescription light) {
  light.even_spot = true;
  return light;
}

LightDescription sun(Vec3 shines, float angle, float energy = 3.0f) {
  LightDescription light = lamp(LightKind::Sun, placed(Vec3(0.0f), shines), energy);
  light.sun_angle = angle;
  return light;
}

LightDescription even_sun(Vec3 shines, float angle, float energy = 3.0f) {
  LightDescription light = sun(shines, angle, energy);
  light.even_sun = true;
  return light;
}

Vec3 panel_x(const LightDescription& light) { return Vec3(to_matrix(light.world_from_light)[0]); }

/// A scene with one small dark object.
SceneDescription dark() {
  SceneDescription d;
  add_object(d, plane(0.01f), add_diffuse(d, Color(0.5f)), placed(Vec3(0, 0, -5), Vec3(0, 0, -1)));
  set_camera(d, Vec3(0, -8, 0), Vec3(0.0f), 4);
  return d;
}
std::shared_ptr<const Scene> with_lamp(const LightDescription& light) {
  SceneDescription d = dark();
  d.lights.push_back(light);
  return build(std::move(d));
}

MeshDescription triangle(Vec3 a, Vec3 b, Vec3 c) {
  MeshDescription mesh;
  mesh.name = "Triangle";
  mesh.positions = {a, b, c};
  mesh.triangles = {UVec3(0, 1, 2)};
  return mesh;
}

// ---- Densities of directions towards lights ------------------------------------------

struct Crossing {
  float distance;
  Vec3 normal;
};
/// The intersection of light `index` with the ray from p along w, computed independently of the scene.
std::optional<Crossing> crossing(const LightSet& lights, uint32_t index, Vec3 p, Vec3 w) {
  const Light light = lights.light(index);
  switch (light.type) {
    case LightType::Environment: return Crossing{kInfinity, -w};
    case LightType::DistantDisk:
      if (lights.distant_disk_contains(index, w)) return Crossing{kInfinity, -w};
      return std::nullopt;
    case LightType::Triangle: {
      const glm::dvec3 e1(light.edge1), e2(light.edge2), o(p - light.position), dir(w), n = glm::cross(e1, e2);
      const double t = -glm::dot(o, n) / glm::dot(dir, n);
      const glm::dvec3 q = o + t * dir;
      const double b1 = glm::dot(glm::cross(q, e2), n) / glm::dot(n, n),
                   b2 = glm::dot(glm::cross(e1, q), n) / glm::dot(n, n);
      if (!(t > 0.0 && b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0)) return std::nullopt;
      return Crossing{float(t), light.frame.n};
    }
    default: {
      Ray ray;
      ray.origin = p;
      ray.direction = w;
      const auto hit = intersect_lamp_shape(light, ray);
      if (!hit) return std::nullopt;
      return Crossing{hit->t, hit->normal};
    }
  }
}

Map map_of(const LightSet& lights, uint32_t index, Vec3 p) {
  return [&lights, index, p](Vec2 u) -> std::optional<Vec3> {
    const auto s = lights.sample_li(index, p, u, 0.0f);
    if (!s) return std::nullopt;
    return s->wi;
  };
}
Density density_of(const LightSet& lights, uint32_t index, Vec3 p) {
  return [&lights, index, p](Vec3 w) -> double {
    const auto hit = crossing(lights, index, p, w);
    return hit ? lights.pdf_li(index, p, w, hit->distance, hit->normal, 0.0f) : 0.0f;
  };
}

struct Case {
  const char* name;
  std::shared_ptr<const Scene> scene;
  Vec3 p;
  uint32_t light = 0;
};

std::vector<Case> extended_lights() {
  const Mat4 tilted = placed({0.3f, 0.2f, 2.0f}, {0.2f, 0.1f, -1.0f}), down = placed({0, 0, 1}, {0, 0, -1});
  const auto sphere = with_lamp(point_light({0, 0, 2}, 10.0f, 0.5f));
  const auto soft = with_lamp(softened(point_light({0, 0, 2}, 10.0f, 0.5f)));
  const auto rectangle = with_lamp(area_lamp(AreaShape::Rectangle, {2.0f, 1.0f}, tilted));
  const auto ellipse = with_lamp(area_lamp(AreaShape::Ellipse, {2.0f, 1.0f}, tilted));
  const auto beam = with_lamp(area_lamp(AreaShape::Rectangle, {2.0f, 1.0f}, tilted, 0.6f));
  const auto tube = with_lamp(area_lamp(AreaShape::Rectangle, {2.0f, 0.01f}, down));
  std::vector<Case> cases{
      {"sphere", sphere, {0, 0, 0}},
      {"sphere near", sphere, {0, 0, 1.49f}},
      {"sphere inside", sphere, {0.1f, 0.2f, 1.8f}},
      {"sphere far", sphere, {300, 200, 100}},
      {"spot sphere", with_lamp(spot(tilted, 0.3f)), {0, 0, 0}},
      {"soft lamp", soft, {0, 0, 0}},
      {"soft lamp near", soft, {0, 0, 1.49f}},
      {"soft lamp inside", soft, {0.1f, 0.2f, 1.8f}},
      {"soft lamp far", soft, {300, 200, 100}},
      {"even spot inside", with_lamp(evened(spot(tilted, 0.5f))), {0.1f, 0.2f, 1.8f}},
      {"soft spot", with_lamp(softened(spot(tilted, 0.3f))), {0, 0, 0}},
      {"rectangle", rectangle, {0, 0, 0}},
      {"rectangle near", rectangle, {0.3f, 0.2f, 1.99f}},
      {"rectangle grazing", rectangle, {3.0f, 0.0f, 2.4f}},
      {"rectangle far", rectangle, {20, 30, -100}},
      {"tube", tube, {0, 0, 0.9f}},
      {"tube seen along", tube, {1.5f, 0, 0.9f}},
      {"beam", beam, {0.1f, 0, 0}},
      {"beam at its edge", beam, {1.2f, 0, 0}},
      {"ellipse", ellipse, {0, 0, 0}},
      {"ellipse near", ellipse, {0.3f, 0.2f, 1.9f}},
      {"scaled rectangle",
       with_lamp(area_lamp(AreaShape::Rectangle, {1, 1}, placed({0, 0, 2}, {0, 0, -1}, {2.0f, 0.5f, 3.0f}))),
       {0, 1, 0}},
      {"mirrored rectangle",
       with_lamp(area_lamp(AreaShape::Rectangle, {1, 2}, placed({0, 0, 2}, {0, 0, -1}, {-1, 1, 1}))),
       {0, 1, 0}},
      {"sun of half a degree", with_lamp(sun({0.3f, 0.1f, -1.0f}, 0.00918f)), {0, 0, 0}},
      {"sun of ninety degrees", with_lamp(sun({0.3f, 0.1f, -1.0f}, 1.57f)), {0, 0, 0}},
      {"even sun of half a degree", with_lamp(even_sun({0.3f, 0.1f, -1.0f}, 0.00918f)), {0, 0, 0}},
      {"even sun of half the sky", with_lamp(even_sun({0.3f, 0.1f, -1.0f}, kPi)), {0, 0, 0}},
  };
  for (bool bake : {false, true}) {
    SceneDescription d = dark();
    add_object(d, triangle({-1, -1, 0}, {1, -1, 0}, {0, 2, 0}), add_diffuse(d, Color(0.5f), Color(2.0f)),
               placed({0.2f, 0, 2}, {0.2f, 0, 1}, {0.7f, -1.2f, 1.0f}));
    const auto scene = build(d, nullptr, bake);
    cases.push_back({"triangle", scene, {0, 0, 0}});
    if (bake) continue;
    cases.push_back({"triangle from behind", scene, {0, 0.5f, 4}});
    cases.push_back({"triangle near", scene, {0.2f, 0, 1.98f}});
    cases.push_back({"triangle far", scene, {50, 0, 10}});
  }
  SceneDescription d = dark();
  set_world(d, Color(0.3f));
  cases.push_back({"constant world", build(d), {0, 0, 0}});
  set_checker_world(d, Color(5.0f, 3.0f, 1.0f), Color(0.0f), 3.0f);
  cases.push_back({"checkered world", build(d), {0, 0, 0}});
  return cases;
}

TEST(LightSet, directions_follow_their_density) {
  const auto cases = extended_lights();
  for (const Case& c : cases) {
    const LightSet& lights = c.scene->lights();
    ASSERT_EQ(lights.size(), 1u) << c.name;
    // The edges of distant lights are only as precise as a direction of floats.
    DensityTest test{
        .sample_count = 30000, .bin_count = 64, .outside_fraction = 3e-3, .level = {.test_count = int(cases.size())}};
    if (std::string(c.name) == "checkered world") test.bin_count = 600;
    EXPECT_TRUE(chi_square_agrees(from_square(map_of(lights, 0, c.p)), density_of(lights, 0, c.p), test)) << c.name;
  }
}

TEST(LightSet, jacobian_of_directions_is_one_over_their_density) {
  for (const Case& c : extended_lights()) {
    if (std::string(c.name) == "checkered world") continue;  // a step would leave the cell of the checker
    const LightSet& lights = c.scene->lights();
    JacobianTest test{.step = 1.0 / 256.0, .tolerance = 0.05, .smooth_fraction = 0.2};
    // Inside the light, the density that sample_li reports is that of pdf_li.
    EXPECT_TRUE(jacobian_agrees(map_of(lights, 0, c.p), density_of(lights, 0, c.p), test)) << c.name;
  }
}

TEST(LightSet, samples_report_the_values_of_pdf_li_and_radiance) {
  for (const Case& c : extended_lights()) {
    const LightSet& lights = c.scene->lights();
    Pcg32 rng(3);
    for (int i = 0; i < 2000; ++i) {
      const float x = rng.next_float();
      const auto s = lights.sample_li(0, c.p, {x, rng.next_float()}, 0.0f);
      if (!s) continue;
      ASSERT_FALSE(s->delta) << c.name;
      ASSERT_TRUE(is_finite(s->wi) && is_finite(s->radiance) && s->pdf_solid_angle > 0.0f) << c.name;
      ASSERT_NEAR(glm::length(s->wi), 1.0f, 1e-5f) << c.name;
      if (s->distance < kInfinity) {
        ASSERT_LT(glm::length(c.p + s->wi * s->distance - s->position), 1e-5f * (1.0f + s->distance)) << c.name;
      }
      const float pdf = lights.pdf_li(0, c.p, s->wi, s->distance, s->normal, 0.0f);
      if (pdf > 0.0f) {  // zero where the sample was rounded over an edge
        ASSERT_NEAR(s->pdf_solid_angle / pdf, 1.0f, 2e-3f) << c.name;
      }
      const LightType type = lights.flags(0).type;
      Color radiance(0.0f);
      if (type == LightType::Environment) radiance = lights.environment_radiance(s->wi, 0);
      if (type == LightType::Triangle) radiance = Color(2.0f);
      if (lights.lamp_count() > 0) radiance = lights.lamp_radiance(0, s->position, -s->wi, 0.0f, s->distance);
      ASSERT_LE(glm::length(s->radiance - radiance), 1e-3f * glm::length(radiance)) << c.name;
    }
  }
}

// ---- Closed forms --------------------------------------------------------------------

/// The irradiance (first channel) at p with the normal n, estimated by samples of all lights.
RunningMoments irradiance(const LightSet& lights, Vec3 p, Vec3 n, int count, uint64_t seed = 1) {
  Pcg32 rng(seed);
  RunningMoments moments;
  for (int i = 0; i < count; ++i) {
    const auto choice = lights.choose_by_power(rng.next_float());
    const float x = rng.next_float();
    const auto s = lights.sample_li(choice.light, p, {x, rng.next_float()}, 0.0f);
    moments.add(s ? double(s->radiance.x) * std::max(0.0f, glm::dot(n, s->wi)) /
                        (double(s->pdf_solid_angle) * choice.pmf)
                  : 0.0);
  }
  return moments;
}
/// Form factor of a rectangle [0, a] x [0, b] at height c for a point under its corner (Howell, C-3).
double corner_factor(double a, double b, double c) {
  const double x = a / c, y = b / c;
  return (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
          y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
         (2.0 * M_PI);
}

TEST(LightSet, irradiance_agrees_with_closed_forms) {
  const Vec3 up(0, 0, 1), origin(0.0f);
  const double w = 10.0;
  const Mat4 above = placed({0, 0, 2}, {0, 0, -1});
  const Significance level{.test_count = 12};
  const auto e = [&](const LightDescription& light, Vec3 n = Vec3(0, 0, 1)) {
    return irradiance(with_lamp(light)->lights(), Vec3(0.0f), n, 40000);
  };

  EXPECT_TRUE(mean_agrees(e(point_light({0, 0, 2}, 10.0f)), w / (4.0 * M_PI) / 4.0, level));
  // A sphere that is completely above the horizon gives the irradiance of a point light at its centre.
  EXPECT_TRUE(mean_agrees(e(point_light({1, 0, 2}, 10.0f, 0.7f)), w / (4.0 * M_PI) * 2.0 / std::pow(5.0, 1.5), level));
  // A disk of radius r that faces the point: pi L r^2 / (r^2 + d^2), also from inside the sphere.
  for (const float radius : {0.7f, 3.0f})
    EXPECT_TRUE(mean_agrees(e(softened(point_light({1, 0, 2}, 10.0f, radius)), glm::normalize(Vec3(1, 0, 2))),
                            w / (4.0 * M_PI) / (5.0 + sqr(radius)), level));
  // On the axis of a spot, whose profile is the cosine, here 1.
  EXPECT_TRUE(mean_agrees(e(spot(above, 0.0f)), w / (4.0 * M_PI) / 4.0, level));
  EXPECT_TRUE(mean_agrees(e(spot(placed({0, 0, 2}, {1, 0, -1}), 0.0f, 2.0f, 0.0f)),
                          w / (4.0 * M_PI) / 4.0 * std::sqrt(0.5), level));
  // Even spots: no cosine, and a cone in the space of the lamp.
  EXPECT_TRUE(
      mean_agrees(e(evened(spot(placed({0, 0, 2}, {1, 0, -1}), 0.0f, 2.0f, 0.0f))), w / (4.0 * M_PI) / 4.0, level));
  for (const bool wide : {false, true}) {
    Mat4 tilted = placed({0, 0, 2}, {1, 0, -1}, {1, 1, wide ? 0.5f : 1.0f});
    EXPECT_TRUE(mean_agrees(e(evened(spot(tilted, 0.0f, 1.2f, 0.0f))), wide ? w / (4.0 * M_PI) / 4.0 : 0.0, level));
  }
  // In the middle of the blend, smoothstep is one half.
  const float outer = std::cos(0.5f), middle = outer + 0.5f * (1.0f - outer) * 0.4f;
  const Vec3 axis(std::sqrt(1.0f - middle * middle), 0.0f, -middle);
  EXPECT_TRUE(mean_agrees(e(spot(placed({0, 0, 2}, axis), 0.0f, 1.0f, 0.4f)), w / (4.0 * M_PI) / 4.0 * 0.5 * middle,
                          level, 1e-3));
  EXPECT_TRUE(mean_agrees(e(area_lamp(AreaShape::Rectangle, {2, 1}, above)),
                          M_PI * w / 8.0 * 4.0 * corner_factor(1.0, 0.5, 2.0), level));
  // A disk on its axis: pi L r^2 / (r^2 + h^2).
  EXPECT_TRUE(mean_agrees(e(area_lamp(AreaShape::Ellipse, {2, 2}, above)), M_PI * w / (4.0 * M_PI) / 5.0, level));
  EXPECT_TRUE(mean_agrees(e(sun({0, -1, -1}, 0.0f)), 3.0 * std::sqrt(0.5), level));
  EXPECT_TRUE(mean_agrees(e(sun({0, -1, -1}, 0.01f)), 3.0 * std::sqrt(0.5), level, 1e-4));
  // Mean cosine of a disk of radius 1 at distance 1: 2 (sqrt(2) - 1).
  EXPECT_TRUE(mean_agrees(e(sun({0, 0, -1}, float(M_PI / 2))), 3.0 * 2.0 * (std::sqrt(2.0) - 1.0), level));
  // The energy of an even sun is the irradiance of a surface that faces it, for all sizes. A sun of half the sky lights a
  // surface at the angle t by (1 + cos(t)) / 2 of it.
  for (const float angle : {0.0f, 0.01f, 1.0f, 2.5f, 3.055f, kPi})
    EXPECT_TRUE(mean_agrees(e(even_sun({0, 0, -1}, angle)), 3.0, level, 1e-4)) << angle;
  for (const float tilt : {0.5f, 1.4f, 2.0f})
    EXPECT_TRUE(
        mean_agrees(e(even_sun({std::sin(tilt), 0, -std::cos(tilt)}, kPi)), 1.5 * (1.0 + std::cos(tilt)), level, 1e-3))
        << tilt;
  SceneDescription d = dark();
  set_world(d, Color(0.3f));
  EXPECT_TRUE(mean_agrees(irradiance(build(d)->lights(), origin, up, 40000), 0.3 * M_PI, level));
  d = dark();
  add_object(d, plane(1.0f), add_diffuse(d, Color(0.0f), Color(2.0f)), placed({0, 0, 2}, {0, 0, -1}));
  EXPECT_TRUE(mean_agrees(irradiance(build(d)->lights(), origin, up, 40000),
                          2.0 * M_PI * 4.0 * corner_factor(1.0, 1.0, 2.0), level));
}

TEST(LightSet, one_sided_lamps_emit_nothing_backwards_and_spots_nothing_outside_their_cones) {
  const Vec3 origin(0.0f);
  for (const LightDescription& light :
       {area_lamp(AreaShape::Rectangle, {2, 1}, placed({0, 0, 2}, {0, 0, 1})),
        area_lamp(AreaShape::Ellipse, {2, 1}, placed({0, 0, 2}, {0, 0, 1})),
        spot(placed({0, 0, 2}, {1, 0, 0.2f}), 0.0f), spot(placed({0, 0, 2}, {1, 0, 0.2f}), 0.3f),
        area_lamp(AreaShape::Rectangle, {0.5f, 0.5f}, placed({0, 0, 2}, {1, 0, -0.5f}), 0.5f)}) {
    const auto scene = with_lamp(light);
    EXPECT_EQ(irradiance(scene->lights(), origin, Vec3(0, 0, 1), 1000).mean(), 0.0);
  }
}

TEST(LightSet, shaders_multiply_the_emission_of_a_lamp) {
  LightDescription light = point_light({0, 0, 2}, 10.0f);
  Node emission = closure_node("ShaderNodeEmission", Color(0.5f, 1.0f, 1.0f));
  emission.inputs.push_back({"Strength", {}, Vec4(3.0f)});
  light.graph.nodes = {emission};
  light.graph.surface = {0, "Emission"};
  EXPECT_NEAR(irradiance(with_lamp(light)->lights(), Vec3(0.0f), Vec3(0, 0, 1), 10).mean(), 1.5 * 10.0 / (16.0 * M_PI),
              1e-5);
}

/// The radiance or intensity of a lamp whose emission shader is this output of this node, divided by that without a
/// shader.
Color shown_by(LightDescription light, const std::string& node, const std::string& output, Vec3 position, Vec3 wo,
               std::initializer_list<NodeProperty> properties = {}) {
  const Color own = with_lamp(light)->lights().lamp_radiance(0, position, wo, 0.0f, 1.0f);
  Node shown, emission = closure_node("ShaderNodeEmission", Color(0.0f));
  shown.type = node;
  shown.properties = properties;
  for (NodeInput& input : emission.inputs)
    if (input.socket == "Color") input.link = {1, output};
  light.graph.nodes = {emission, shown};
  light.graph.surface = {0, "Emission"};
  return with_lamp(light)->lights().lamp_radiance(0, position, wo, 0.0f, 1.0f) / own;
}

void expect_close(Color a, Color b) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-5f) << i;
}

TEST(LightSet, shaders_of_lamps_use_the_space_of_the_lamp) {
  // The axes x, y and z of the lamp are z, x and y of the world, so that +y of the world is +z of the lamp. Negative
  // colours are clamped to 0.
  const Mat4 turned(Vec4(0, 0, 1, 0), Vec4(1, 0, 0, 0), Vec4(0, 1, 0, 0), Vec4(4, 5, 6, 1));
  const Vec3 wo = glm::normalize(Vec3(0.2f, 0.9f, 0.3f)), at(4, 5, 6);
  const LightDescription bulb = lamp(LightKind::Point, turned),
                         panel = area_lamp(AreaShape::Rectangle, {1, 1}, placed(at, {0.0f, 0.6f, 0.8f}));
  expect_close(shown_by(bulb, "ShaderNodeTexCoord", "Normal", at, wo), Color(wo.z, wo.x, wo.y));
  expect_close(shown_by(bulb, "ShaderNodeNewGeometry", "Normal", at, wo), wo);
  expect_close(shown_by(bulb, "ShaderNodeNewGeometry", "Position", at, wo), at);
  expect_close(shown_by(bulb, "ShaderNodeTexCoord", "Generated", at, wo), at);
  expect_close(shown_by(panel, "ShaderNodeNewGeometry", "Normal", at, wo), {0.0f, 0.6f, 0.8f});
  expect_close(shown_by(panel, "ShaderNodeNewGeometry", "Incoming", at, wo), wo);
  expect_close(shown_by(panel, "ShaderNodeNewGeometry", "Position", at + 0.25f * panel_x(panel), wo),
               at + 0.25f * panel_x(panel));
  expect_close(shown_by(sun(-wo, 0.0f), "ShaderNodeNewGeometry", "Incoming", Vec3(0.0f), wo), wo);
  expect_close(shown_by(sun(-wo, 0.0f), "ShaderNodeNewGeometry", "Position", Vec3(0.0f), wo), wo);
}

TEST(LightSet, ies_profiles_rotate_with_the_lamp) {
  // The profile is bright below the lamp, dark above its horizon, and twice as bright to one side.
  const NodeProperty file{"ies",
                          "TILT=NONE\n1 -1 1 3 5 1 1 0 0 0\n1 1 1\n0 45 90\n0 90 180 270 360\n"
                          "100 60 20\n100 60 20\n100 120 40\n100 60 20\n100 60 20\n",
                          {}};
  std::string problem;
  const auto profile = nodes::IesProfile::read(file.text, problem);
  ASSERT_EQ(problem, "");
  const Mat4 turned(Vec4(0, 0, 2, 0), Vec4(2, 0, 0, 0), Vec4(0, 2, 0, 0), Vec4(4, 5, 6, 1));
  for (const Vec3 local :
       {Vec3(0, 0, -1), Vec3(0.6f, 0, -0.8f), Vec3(0, 0.6f, -0.8f), Vec3(0, -0.6f, -0.8f), Vec3(0.6f, 0.0f, 0.8f)}) {
    const Vec3 wo(local.y, local.z, local.x);
    for (const LightDescription& light : {lamp(LightKind::Point, turned), [&] {
                                            auto l = lamp(LightKind::Point, turned);
                                            l.radius = 0.2f;
                                            return l;
                                          }()})
      for (const float seen_from_eye : {0.0f, 1.0f})
        expect_close(
            shown_by(light, "ShaderNodeTexIES", "Fac", {4, 5, 6}, wo, {file, {"seen_from_eye", "", {seen_from_eye}}}) /
                8.0f,
            Color(profile.towards(local)) / 8.0f);
    // An area lamp sends light along its axis by the profile's first angle, and since Blender 4 by the angle of the light.
    const LightDescription panel = area_lamp(AreaShape::Rectangle, {1, 1}, turned);
    if (local.z < 0.0f) {
      expect_close(shown_by(panel, "ShaderNodeTexIES", "Fac", {4, 5, 6}, wo, {file}) / 8.0f,
                   Color(profile.towards({0, 0, -1})) / 8.0f);
      expect_close(
          shown_by(panel, "ShaderNodeTexIES", "Fac", {4, 5, 6}, wo, {file, {"seen_from_eye", "", {1.0f}}}) / 8.0f,
          Color(profile.towards(local)) / 8.0f);
    }
  }
  EXPECT_GT(profile.towards({0, 0.6f, -0.8f}), 1.5f * profile.towards({0, -0.6f, -0.8f}));
}

TEST(LightSet, texture_coordinates_of_lamps_are_those_of_cycles) {
  // The axes x, y and z of the lamp are z, x and y of the world, twice as long.
  const Mat4 turned(Vec4(0, 0, 2, 0), Vec4(2, 0, 0, 0), Vec4(0, 2, 0, 0), Vec4(4, 5, 6, 1));
  const Vec3 wo = glm::normalize(Vec3(0.2f, -0.9f, 0.3f)), local(wo.z, wo.x, wo.y);
  const auto in_world = [&](Vec3 p) { return transform_point(turned, p); };
  for (const AreaShape shape : {AreaShape::Rectangle, AreaShape::Ellipse}) {
    LightDescription panel = area_lamp(shape, {2, 1}, turned);
    const Vec3 place = in_world({0.3f, 0.2f, 0.0f});
    expect_close(shown_by(panel, "ShaderNodeTexCoord", "UV", place, wo), Color(0.0f));
    panel.has_uv = true;
    expect_close(shown_by(panel, "ShaderNodeTexCoord", "UV", place, wo), Color(0.65f, 0.7f, 0.0f));
    expect_close(shown_by(panel, "ShaderNodeTexCoord", "Object", place, wo), place);
    panel.own_coordinates = true;
    expect_close(shown_by(panel, "ShaderNodeTexCoord", "Object", place, wo), Color(0.3f, 0.2f, 0.0f));
    expect_close(shown_by(panel, "ShaderNodeTexCoord", "Generated", place, wo), Color(0.3f, 0.2f, 0.0f));
  }
  LightDescription spot = lamp(LightKind::Spot, turned), bulb = lamp(LightKind::Point, turned);
  spot.has_uv = bulb.has_uv = true;
  spot.spot_angle = kPi / 2.0f;
  expect_close(shown_by(spot, "ShaderNodeTexCoord", "UV", {4, 5, 6}, wo),
               Color(0.5f - 0.5f * local.x / local.z, 0.5f - 0.5f * local.y / local.z, 0.0f));
  expect_close(shown_by(bulb, "ShaderNodeTexCoord", "UV", {4, 5, 6}, wo),
               Color(0.5f - std::atan2(local.x, local.y) / (2.0f * kPi), 1.0f - std::acos(local.z) / kPi, 0.0f));
}

/// What a lamp shows whose emission is the direction of the light after a Vector Transform, divided by what it shows
/// without one.
Color shown_direction(const LightDescription& light, const std::string& type, const std::string& from,
                      const std::string& to, bool lamp_has_space, Vec3 wo) {
  Node geometry, transform, emission = closure_node("ShaderNodeEmission", Color(0.0f));
  geometry.type = "ShaderNodeNewGeometry";
  transform.type = "ShaderNodeVectorTransform";
  transform.properties = {{"vector_type", type, {}},
                          {"convert_from", from, {}},
                          {"convert_to", to, {}},
                          {"lamp_has_space", "", {float(lamp_has_space)}}};
  transform.inputs = {{"Vector", {1, "Incoming"}, Vec4(0.0f)}};
  for (NodeInput& input : emission.inputs)
    if (input.socket == "Color") input.link = {2, "Vector"};
  LightDescription shining = light;
  shining.graph.nodes = {emission, geometry, transform};
  shining.graph.surface = {0, "Emission"};
  return with_lamp(shining)->lights().lamp_radiance(0, {4, 5, 6}, wo, 0.0f, 1.0f) /
         with_lamp(light)->lights().lamp_radiance(0, {4, 5, 6}, wo, 0.0f, 1.0f);
}

TEST(LightSet, vector_transform_knows_the_space_of_a_lamp_since_blender_4) {
  // The axes x, y and z of the lamp are z, x and y of the world, twice as long.
  const Mat4 turned(Vec4(0, 0, 2, 0), Vec4(2, 0, 0, 0), Vec4(0, 2, 0, 0), Vec4(4, 5, 6, 1));
  const LightDescription bulb = lamp(LightKind::Point, turned);
  const Vec3 wo = glm::normalize(Vec3(0.2f, 0.9f, 0.3f)), local(wo.z, wo.x, wo.y), world(wo.y, wo.z, wo.x);
  expect_close(shown_direction(bulb, "NORMAL", "WORLD", "OBJECT", true, wo), local);
  expect_close(shown_direction(bulb, "VECTOR", "WORLD", "OBJECT", true, wo), 0.5f * local);
  expect_close(shown_direction(bulb, "VECTOR", "OBJECT", "WORLD", true, wo), 2.0f * world);
  expect_close(shown_direction(bulb, "POINT", "OBJECT", "WORLD", true, wo), 2.0f * world + Vec3(4, 5, 6));
  for (const char* type : {"NORMAL", "VECTOR", "POINT"})
    expect_close(shown_direction(bulb, type, "WORLD", "OBJECT", false, wo), wo);
}

TEST(LightSet, emission_can_depend_on_the_object) {
  // Two squares of one material, which reads the colour and the strength from the object.
  SceneDescription d = dark();
  const int material = add_diffuse(d, Color(0.0f), Color(1.0f));
  NodeGraph& graph = d.materials.back().graph;
  Node info, strength;
  info.type = "ShaderNodeObjectInfo";
  strength.type = "ShaderNodeAttribute";
  strength.properties = {{"attribute_type", "OBJECT", {}}, {"attribute_name", "power", {}}};
  graph.nodes.push_back(info), graph.nodes.push_back(strength);
  for (Node& n : graph.nodes)
    for (NodeInput& input : n.inputs) {
      if (n.type == "ShaderNodeEmission" && input.socket == "Color") input.link = {3, "Color"};
      if (n.type == "ShaderNodeEmission" && input.socket == "Strength") input.link = {4, "Fac"};
    }
  const Color colors[] = {Color(1.0f, 0.5f, 0.25f), Color(0.125f, 0.25f, 4.0f)};
  for (int i = 0; i < 2; ++i) {
    const int object = add_object(d, plane(1.0f), material, placed({4.0f * float(i), 0, 2}, {0, 0, -1}));
    d.objects[size_t(object)].color = Vec4(colors[i], 1.0f);
    d.objects[size_t(object)].properties = {{"power", false, Vec4(Vec3(2.0f + float(i)), 1.0f)}};
  }
  const auto scene = build(d);
  const LightSet& lights = scene->lights();
  ASSERT_EQ(lights.size(), 4u);
  for (uint32_t i = 0; i < 4; ++i) {
    const Vec3 p = lights.light(i).position - Vec3(0, 0, 3.0f);
    const auto sample = lights.sample_li(i, p, {0.3f, 0.6f}, 0.0f);
    ASSERT_TRUE(sample);
    const int object = lights.light(i).position.x < 2.0f ? 0 : 1;
    expect_close(sample->radiance, colors[object] * (2.0f + float(object)));
    const auto leaving = lights.sample_le(i, {0.3f, 0.6f}, {0.2f, 0.7f}, 0.0f);
    ASSERT_TRUE(leaving);
    expect_close(leaving->radiance, colors[object] * (2.0f + float(object)));
    // The choice uses the power of this object, not that of a white one.
    EXPECT_NEAR(lights.power_pmf(i),
                luminance(colors[object]) * (2.0f + float(object)) /
                    (4.0f * luminance(colors[0]) + 6.0f * luminance(colors[1])),
                1e-3f);
  }
}

// ---- Emitted rays ------------------------------------------------------------------------

std::vector<std::pair<const char*, SceneDescription>> all_kinds() {
  std::vector<std::pair<const char*, SceneDescription>> all;
  const Mat4 tilted = placed({0.3f, 0.2f, 2.0f}, {0.2f, 0.1f, -1.0f});
  const auto add = [&](const char* name, const LightDescription& light) {
    SceneDescription d = dark();
    d.lights.push_back(light);
    all.push_back({name, d});
  };
  add("point", point_light({0, 0, 2}, 10.0f));
  add("sphere", point_light({0, 0, 2}, 10.0f, 0.5f));
  add("spot", spot(tilted, 0.0f));
  add("spot sphere", spot(tilted, 0.3f));
  add("soft lamp", softened(point_light({0, 0, 1}, 10.0f, 0.7f)));
  add("soft spot", softened(spot(tilted, 0.3f)));
  add("even spot", evened(spot(tilted, 0.3f)));
  const Mat4 stretched = placed({0.3f, 0.2f, 2.0f}, {0.2f, 0.1f, -1.0f}, {2.0f, 0.4f, 0.8f});
  add("stretched spot", evened(spot(stretched, 0.0f)));
  add("soft stretched spot", softened(evened(spot(stretched, 0.2f))));
  add("rectangle", area_lamp(AreaShape::Rectangle, {2, 1}, tilted));
  add("beam", area_lamp(AreaShape::Rectangle, {2, 1}, tilted, 0.6f));
  add("ellipse", area_lamp(AreaShape::Ellipse, {2, 1}, tilted));
  add("sun", sun({0.3f, 0.1f, -1.0f}, 0.0f));
  add("soft sun", sun({0.3f, 0.1f, -1.0f}, 0.5f));
  add("even sun", even_sun({0.3f, 0.1f, -1.0f}, 2.5f));
  SceneDescription d = dark();
  add_object(d, sphere(4), add_diffuse(d, Color(0.0f), Color(2.0f)),
             placed({0, 0, 2}, {1, 0, -1}, {0.5f, 0.5f, -0.7f}));
  all.push_back({"mesh", d});
  d = dark();
  set_checker_world(d, Color(3.0f), Color(0.5f), 2.0f);
  all.push_back({"world", d});
  return all;
}

TEST(LightSet, emitted_rays_have_the_total_power_and_report_their_density) {
  const auto kinds = all_kinds();
  for (const auto& [name, description] : kinds) {
    const auto scene = build(description);
    const LightSet& lights = scene->lights();
    RunningMoments power;
    Pcg32 rng(1);
    for (int i = 0; i < 40000; ++i) {
      const auto choice = lights.choose_by_power(rng.next_float());
      Vec2 u, v;
      for (float* x : {&u.x, &u.y, &v.x, &v.y}) *x = rng.next_float();
      const auto r = lights.sample_le(choice.light, u, v, 0.0f);
      if (!r) {
        power.add(0.0);
        continue;
      }
      const LightType type = lights.flags(choice.light).type;
      const float cosine = is_delta(type) || is_distant(type) ? 1.0f : std::abs(glm::dot(r->normal, r->ray.direction));
      power.add(luminance(r->radiance) * cosine / (double(r->pdf_area) * r->pdf_solid_angle * choice.pmf));
      const auto pdf = lights.pdf_le(choice.light, r->normal, r->ray.direction, 0.0f);
      ASSERT_NEAR(pdf.pdf_area / r->pdf_area, 1.0f, 1e-4f) << name;
      if (type != LightType::DistantDelta && pdf.pdf_solid_angle > 0.0f) {
        ASSERT_NEAR(pdf.pdf_solid_angle / r->pdf_solid_angle, 1.0f, 1e-3f) << name;
      }
    }
    // The power of the world is estimated on its grid.
    EXPECT_TRUE(mean_agrees(power, lights.total_power(), {.test_count = int(kinds.size())},
                            std::string(name) == "world" ? 0.03 : 1e-3))
        << name;
  }
}

TEST(LightSet, directions_of_emitted_rays_follow_their_density) {
  const auto kinds = all_kinds();
  for (const auto& [name, description] : kinds) {
    const auto scene = build(description);
    const LightSet& lights = scene->lights();
    if (lights.flags(0).type == LightType::DistantDelta) continue;
    const uint32_t index = lights.choose_by_power(0.4f).light;
    const Vec2 u(0.85f, 0.1f);  // on a sphere: a point from which the cone of the spot leaves
    const auto map = [&](Vec2 v) -> std::optional<Vec3> {
      const auto r = lights.sample_le(index, u, v, 0.0f);
      if (!r) return std::nullopt;
      return r->ray.direction;
    };
    const auto any = lights.sample_le(index, u, {0.2f, 0.1f}, 0.0f);
    const bool sphere = lights.flags(index).type == LightType::Sphere ||
                        lights.flags(index).type == LightType::SpotSphere;
    const Vec3 normal = any ? any->normal : warp::square_to_sphere(u);
    const auto density = [&](Vec3 w) -> double {
      if (sphere && !(glm::dot(w, normal) > 0.0f)) return 0.0;
      return lights.pdf_le(index, normal, w, 0.0f).pdf_solid_angle;
    };
    DensityTest test{
        .sample_count = 30000, .bin_count = 64, .outside_fraction = 1e-3, .level = {.test_count = int(kinds.size())}};
    if (std::string(name) == "world") test.bin_count = 1000;
    EXPECT_TRUE(chi_square_agrees(from_square(map), density, test)) << name;
  }
}

TEST(LightSet, emitted_rays_and_light_samples_give_the_same_flux) {
  // The flux through a square, estimated by rays from the lights and by light samples from the square.
  const auto kinds = all_kinds();
  for (const auto& [name, description] : kinds) {
    // The bounding sphere of the scene must contain the square.
    SceneDescription d = description;
    add_object(d, plane(4.0f), add_diffuse(d, Color(0.5f)), placed({0, 0, -0.5f}, {0, 0, -1}));
    const auto scene = build(d);
    const LightSet& lights = scene->lights();
    RunningMoments sent, received;
    Pcg32 rng(2);
    for (int i = 0; i < 100000; ++i) {
      const auto choice = lights.choose_by_power(rng.next_float());
      Vec2 u, v;
      for (float* x : {&u.x, &u.y, &v.x, &v.y}) *x = rng.next_float();
      const auto r = lights.sample_le(choice.light, u, v, 0.0f);
      double flux = 0.0;
      if (r && r->ray.direction.z < 0.0f && r->ray.origin.z > 0.0f) {
        const Vec3 p = r->ray.origin - r->ray.direction * (r->ray.origin.z / r->ray.direction.z);
        const LightType type = lights.flags(choice.light).type;
        const float cosine = is_delta(type) || is_distant(type) ? 1.0f
                                                                : std::abs(glm::dot(r->normal, r->ray.direction));
        const bool reaches = !lights.flags(choice.light).soft ||
                             soft_lamp_distance(lights.light(choice.light), p, -r->ray.direction);
        if (std::abs(p.x) < 1.0f && std::abs(p.y) < 1.0f && reaches)
          flux = r->radiance.y * cosine / (double(r->pdf_area) * r->pdf_solid_angle * choice.pmf);
      }
      sent.add(flux);
      const auto from = lights.choose_by_power(rng.next_float());
      const Vec3 p(2.0f * rng.next_float() - 1.0f, 2.0f * rng.next_float() - 1.0f, 0.0f);
      const float x = rng.next_float();
      const auto s = lights.sample_li(from.light, p, {x, rng.next_float()}, 0.0f);
      // A closed mesh occludes its far side.
      const bool mesh = lights.flags(from.light).type == LightType::Triangle;
      const bool hidden = mesh && s && glm::dot(s->normal, s->wi) > 0.0f;
      received.add(
          s && !hidden ? 4.0 * s->radiance.y * std::max(0.0f, s->wi.z) / (double(s->pdf_solid_angle) * from.pmf) : 0.0);
    }
    if (std::string(name) == "mesh") continue;  // rays from its inner side cross the square as well
    EXPECT_TRUE(means_agree(sent, received, {.test_count = int(kinds.size())})) << name;
  }
}

// ---- Choice of a light ---------------------------------------------------------------------

SceneDescription mixed_lights() {
  SceneDescription d = dark();
  d.lights = {point_light({0, 0, 2}, 10.0f), point_light({0, 1, 2}, 0.0f, 0.3f),
              area_lamp(AreaShape::Rectangle, {1, 1}, placed({1, 0, 2}, {0, 0, -1})), sun({0, 0, -1}, 0.01f)};
  const int glowing = add_diffuse(d, Color(0.0f), Color(4.0f)), grey = add_diffuse(d, Color(0.5f));
  add_object(d, cube(), grey, placed({3, 0, 0}, {0, 0, -1}));
  MeshDescription mixed = cube();
  mixed.name = "Mixed";
  mixed.material_slots = {0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 7};
  const int object = add_object(d, mixed, grey, placed({-3, 0, 0}, {0, 0, -1}, {0.2f, 0.2f, 0.2f}));
  d.objects[size_t(object)].materials = {grey, glowing};
  d.instances.push_back(d.instances.back());
  d.instances.back().world_from_object = rows(placed({-3, 2, 0}, {0, 0, -1}, {0.2f, -0.2f, 0.2f}));
  set_checker_world(d, Color(0.2f), Color(0.0f), 4.0f);
  return d;
}

TEST(LightSet, probabilities_sum_to_one_and_dark_lights_are_never_chosen) {
  const auto scene = build(mixed_lights());
  const LightSet& lights = scene->lights();
  ASSERT_EQ(lights.size(), 4u + 12u + 12u + 1u);
  EXPECT_EQ(lights.environment_index(), 28);
  const Vec3 p(0.0f), n(0, 0, 1);
  double sum = 0.0, power_sum = 0.0;
  for (uint32_t i = 0; i < lights.size(); ++i) {
    sum += lights.choice_pmf(p, n, i);
    power_sum += lights.power_pmf(i);
  }
  EXPECT_NEAR(sum, 1.0, 1e-6);
  EXPECT_NEAR(power_sum, 1.0, 1e-6);
  EXPECT_EQ(lights.choice_pmf(p, n, 1), 0.0f);   // a lamp without power
  EXPECT_EQ(lights.choice_pmf(p, n, 4), 0.0f);   // a grey triangle
  EXPECT_GT(lights.choice_pmf(p, n, 6), 0.0f);   // an emissive triangle
  EXPECT_GT(lights.choice_pmf(p, n, 15), 0.0f);  // a slot that does not exist: the last one is used
  std::vector<int> counts(lights.size(), 0);
  std::vector<RunningMoments> remapped(lights.size());
  const int total = 1 << 20;
  for (int i = 0; i < total; ++i) {
    const auto choice = lights.choose(p, n, (float(i) + 0.5f) / float(total));
    ASSERT_EQ(choice.pmf, lights.choice_pmf(p, n, choice.light));
    ++counts[choice.light];
    remapped[choice.light].add(choice.u_remapped);
  }
  for (uint32_t i = 0; i < lights.size(); ++i) {
    EXPECT_NEAR(counts[i], lights.choice_pmf(p, n, i) * total, 2.0) << i;
    if (counts[i] > 0) {
      EXPECT_NEAR(remapped[i].mean(), 0.5, 1e-3) << i;
      EXPECT_NEAR(remapped[i].variance(), 1.0 / 12.0, 1e-3) << i;
    }
  }
}

TEST(LightSet, of_a_receiver_set_only_its_lights_are_chosen) {
  SceneDescription d = mixed_lights();
  d.lights[0].links.receivers = 0b010;
  d.objects[1].links.receivers = 0b100;
  const auto scene = build(d);
  const LightSet& lights = scene->lights();
  EXPECT_TRUE(lights.any_linked());
  EXPECT_FALSE(build(mixed_lights())->lights().any_linked());
  const Vec3 p(0.0f), n(0, 0, 1);
  for (const uint32_t set : {0u, 1u, 2u, 63u, kEveryLight}) {
    double sum = 0.0;
    for (uint32_t i = 0; i < lights.size(); ++i) {
      const float pmf = lights.choice_pmf(p, n, i, set);
      sum += pmf;
      EXPECT_TRUE(pmf == 0.0f || lights.flags(i).lights(set)) << i << " " << set;
    }
    EXPECT_NEAR(sum, 1.0, 1e-6) << set;
    for (int i = 0; i < 1024; ++i) {
      const auto choice = lights.choose(p, n, (float(i) + 0.5f) / 1024.0f, set);
      ASSERT_EQ(choice.pmf, lights.choice_pmf(p, n, choice.light, set));
      EXPECT_TRUE(lights.flags(choice.light).lights(set));
    }
  }
  EXPECT_EQ(lights.choice_pmf(p, n, 0, 0), 0.0f);
  EXPECT_GT(lights.choice_pmf(p, n, 0, 1), 0.0f);
  EXPECT_GT(lights.choice_pmf(p, n, 0, kEveryLight), 0.0f);
}

TEST(LightSet, with_media_half_of_the_choices_among_few_lights_are_uniform) {
  SceneDescription clear = dark();
  clear.lights = {point_light({0, 0, 3}, 1e6f, 0.1f), point_light({0, 1, 3}, 1.0f, 0.1f), point_light({1, 1, 3}, 0.0f)};
  set_checker_world(clear, Color(0.2f), Color(0.0f), 4.0f);
  const auto foggy = [](SceneDescription d) {
    Node fog;
    fog.type = fog.name = "ShaderNodeVolumeScatter";
    fog.inputs = {{"Color", {}, Vec4(0.5f)}, {"Density", {}, Vec4(0.1f)}};
    d.materials.push_back({"Fog", {}, 0});
    d.materials.back().graph.nodes = {fog};
    d.materials.back().graph.volume = {0, "Volume"};
    add_object(d, cube(), int(d.materials.size()) - 1);
    return d;
  };
  SceneDescription many = clear, one = dark();
  for (int i = 0; i < 9; ++i) many.lights.push_back(point_light({float(i), 0, 5}, 2.0f));
  one.lights = {point_light({0, 0, 3}, 5.0f)};
  for (const Vec3 n : {Vec3(0.0f), Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
    for (const SceneDescription* d : {&clear, &many, &one}) {
      const Vec3 p(0.0f);
      const auto with_fog = build(foggy(*d)), without = build(*d);
      const LightSet& lights = with_fog->lights();
      std::vector<int> counts(lights.size(), 0);
      std::vector<RunningMoments> remapped(lights.size());
      double sum = 0.0;
      for (uint32_t i = 0; i < lights.size(); ++i) {
        sum += lights.choice_pmf(p, n, i);
        const float estimate = without->lights().choice_pmf(p, n, i),
                    even = i == 2 ? 0.0f : 1.0f / 3.0f;  // two lamps and the world; the third lamp has no power
        EXPECT_FLOAT_EQ(lights.choice_pmf(p, n, i), d == &clear ? 0.5f * even + 0.5f * estimate : estimate) << i;
      }
      EXPECT_NEAR(sum, 1.0, 1e-6);
      const int total = 1 << 18;
      for (int i = 0; i < total; ++i) {
        const auto choice = lights.choose(p, n, (float(i) + 0.5f) / float(total));
        ASSERT_EQ(choice.pmf, lights.choice_pmf(p, n, choice.light));
        ++counts[choice.light];
        remapped[choice.light].add(choice.u_remapped);
      }
      for (uint32_t i = 0; i < lights.size(); ++i) {
        EXPECT_NEAR(counts[i], lights.choice_pmf(p, n, i) * total, 3.0) << i;
        if (counts[i] > 1000) {
          EXPECT_NEAR(remapped[i].mean(), 0.5, 0.01) << i;
        }
      }
    }
  }
}

TEST(LightSet, hits_find_their_light) {
  const auto scene = build(mixed_lights());
  const LightSet& lights = scene->lights();
  const auto sees = [&](Vec3 origin, Vec3 direction) {
    Ray ray;
    ray.origin = origin;
    ray.direction = direction;
    return scene->intersect(ray, kRayDiffuse);
  };
  const Hit grey = sees({3, 0, 5}, {0, 0, -1});
  ASSERT_TRUE(grey.found());
  EXPECT_EQ(scene->light_of(grey), -1);
  for (float y : {0.0f, 2.0f})
    for (Vec3 direction : {Vec3(0, 0, -1), Vec3(0, 0, 1), Vec3(1, 0, 0), Vec3(0, 1, 0)}) {
      const Hit hit = sees(Vec3(-3.01f, y + 0.02f, 0.03f) - 5.0f * direction, direction);
      ASSERT_TRUE(hit.found());
      const int index = scene->light_of(hit);
      ASSERT_GE(index, 0);
      const Light light = lights.light(uint32_t(index));
      EXPECT_EQ(light.type, LightType::Triangle);
      EXPECT_EQ(light.instance, hit.instance);
      EXPECT_EQ(light.primitive, hit.primitive);
      // The hit lies in the triangle of the light, and both have the same outside, also when mirrored.
      ShadingPoint point;
      Ray ray;
      ray.origin = Vec3(-3.01f, y + 0.02f, 0.03f) - 5.0f * direction;
      ray.direction = direction;
      scene->shading_point(ray, hit, point);
      EXPECT_NEAR(glm::dot(point.position - light.position, light.frame.n), 0.0f, 1e-6f);
      EXPECT_FALSE(point.backfacing);
      EXPECT_LT(glm::dot(light.frame.n, direction), 0.0f);
    }
}

TEST(LightSet, every_light_has_a_minimum_probability) {
  // A sun, a world and a weak lamp in a very large scene.
  SceneDescription d = dark();
  add_object(d, plane(1000.0f), add_diffuse(d, Color(0.5f)), placed({0, 0, -6}, {0, 0, -1}));
  d.lights = {sun({0, 0, -1}, 0.01f, 1000.0f), point_light({0, 0, 2}, 1.0f)};
  set_checker_world(d, Color(0.02f), Color(0.0f), 4.0f);  // its bright half exceeds the mean
  const auto scene = build(d);
  for (Vec3 normal : {Vec3(0.0f), Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
    EXPECT_GE(scene->lights().choice_pmf(Vec3(0.0f), normal, 1), 0.1999f);
    EXPECT_GE(scene->lights().choice_pmf(Vec3(0.0f), normal, 2),
              0.1f);  // the world, whose irradiance is a thousandth of that of the sun
  }
  EXPECT_GE(scene->lights().choice_pmf(Vec3(0.0f), Vec3(0, 0, 1), 0), 0.5f);
}

TEST(LightSet, a_constant_world_is_not_sampled_as_a_light) {
  SceneDescription d = dark();
  set_world(d, Color(1.0f));
  auto scene = build(d);
  EXPECT_FALSE(scene->lights().can_choose());
  EXPECT_EQ(scene->lights().choose(Vec3(0.0f), Vec3(0, 0, 1), 0.5f).pmf, 0.0f);
  EXPECT_EQ(scene->lights().choice_pmf(Vec3(0.0f), Vec3(0, 0, 1), 0), 0.0f);
  EXPECT_EQ(scene->lights().power_pmf(0), 1.0f);
  d.lights = {point_light({0, 0, 2}, 1e-3f)};
  scene = build(d);
  EXPECT_EQ(scene->lights().choice_pmf(Vec3(0.0f), Vec3(0, 0, 1), 0), 1.0f);
}

TEST(LightSet, a_scene_in_which_nothing_emits_has_no_lights) {
  SceneDescription d = dark();
  d.lights = {point_light({0, 0, 2}, 0.0f), area_lamp(AreaShape::Rectangle, {0, 1}, placed({0, 0, 2}, {0, 0, -1}))};
  const auto scene = build(d);
  EXPECT_TRUE(scene->lights().empty());
  EXPECT_EQ(scene->lights().environment_index(), -1);
}

// ---- Limits ---------------------------------------------------------------------------------

TEST(LightSet, unusable_strength_is_reported_by_name) {
  SceneDescription d = dark();
  d.lights = {point_light({0, 0, 2}, 3e38f, 1e-3f), point_light({0, 0, 2}, 10.0f)};
  d.lights[0].name = "Too Bright";
  Diagnostics diagnostics;
  const auto scene = build(d, &diagnostics);
  EXPECT_TRUE(std::any_of(diagnostics.begin(), diagnostics.end(),
                          [](const Diagnostic& m) { return m.object == "Too Bright"; }));
  EXPECT_EQ(scene->lights().choice_pmf(Vec3(0.0f), Vec3(0.0f), 0), 0.0f);
  EXPECT_EQ(scene->lights().choice_pmf(Vec3(0.0f), Vec3(0.0f), 1), 1.0f);
}

TEST(LightSet, extreme_points_and_lights_give_finite_samples_or_none) {
  std::vector<std::pair<std::shared_ptr<const Scene>, std::vector<Vec3>>> cases;
  const Mat4 down = placed({0, 0, 1}, {0, 0, -1});
  const std::vector<Vec3> around{{0, 0, 1},          {0.5f, 0.5f, 1},     {0.5f, 0.5f, 0.99999f}, {7, 0, 1},
                                 {0, 0, 0.9999999f}, {1e6f, 1e6f, -1e6f}, {0, 0, -1e15f},         {5, 5, 0.999f}};
  for (Vec2 size : {Vec2(1, 1), Vec2(1e-6f, 1e-6f), Vec2(1e6f, 1e-3f), Vec2(1e6f, 1e6f)})
    for (float spread : {kPi, 0.3f, 0.0f}) {
      cases.push_back({with_lamp(area_lamp(AreaShape::Rectangle, size, down, spread)), around});
      cases.push_back({with_lamp(area_lamp(AreaShape::Ellipse, size, down, spread)), around});
    }
  for (float radius : {0.0f, 1e-7f, 0.5f, 1e5f}) {
    cases.push_back({with_lamp(point_light({0, 0, 1}, 10.0f, radius)), around});
    cases.push_back({with_lamp(spot(down, radius, 3.1415927f, 1.0f)), around});
    cases.push_back({with_lamp(spot(down, radius, 0.017f, 0.0f)), around});
  }
  for (float angle : {0.0f, 1e-5f, 1.0f, 3.1415927f}) cases.push_back({with_lamp(sun({0, 0, -1}, angle)), around});
  for (float size : {1e-10f, 1.0f, 1e10f}) {
    SceneDescription d = dark();
    add_object(d, triangle({0, 0, 1}, {size, 0, 1}, {0, size, 1}), add_diffuse(d, Color(0.5f), Color(2.0f)));
    cases.push_back({build(d), around});
  }
  for (const auto& [scene, points] : cases) {
    if (scene->lights().empty()) continue;
    for (Vec3 p : points)
      for (float x : {0.0f, 0.3f, kOneMinusEpsilon})
        for (float y : {0.0f, 0.7f, kOneMinusEpsilon}) {
          const auto s = scene->lights().sample_li(0, p, {x, y}, 0.0f);
          if (!s) continue;
          EXPECT_TRUE(is_finite(s->wi) && is_finite(s->radiance) && s->pdf_solid_angle > 0.0f &&
                      std::isfinite(s->pdf_solid_angle) && s->distance > 0.0f)
              << "light type " << int(scene->lights().flags(0).type) << " at " << p.x << " " << p.y << " " << p.z;
          const float pdf = scene->lights().pdf_li(0, p, s->wi, s->distance, s->normal, 0.0f);
          EXPECT_TRUE(pdf >= 0.0f && std::isfinite(pdf));
        }
  }
}

TEST(LightSet, the_irradiance_of_many_lamps_and_triangles_is_their_sum) {
  SceneDescription d = dark();
  Pcg32 rng(1);
  for (int i = 0; i < 10000; ++i)
    d.lights.push_back(point_light({rng.next_float(), rng.next_float(), rng.next_float()}, rng.next_float() + 0.1f));
  const int glowing = add_diffuse(d, Color(0.0f), Color(1.0f));
  add_object(d, sphere(250), glowing);  // 250,000 triangles
  const auto scene = build(d);
  const LightSet& lights = scene->lights();
  EXPECT_EQ(lights.size(), 10000u + scene->statistics().triangles - 2u);
  // The irradiance of all is that of the lamps plus that of the sphere.
  const Vec3 p(0, 0, 3), down(0, 0, -1);
  double expected = 0.0;
  for (uint32_t i = 0; i < 10000; ++i) {
    const auto s = lights.sample_li(i, p, Vec2(0.5f), 0.0f);
    expected += s->radiance.x * std::max(0.0f, glm::dot(s->wi, down));
  }
  // Nothing occludes the far side of the sphere in this test, so that the sphere counts twice.
  RunningMoments all = irradiance(lights, p, down, 200000, 5);
  RunningMoments sphere_only;
  for (int i = 0; i < 200000; ++i) {
    const auto choice = lights.choose(p, down, rng.next_float());
    const float x = rng.next_float();
    const auto s = lights.sample_li(choice.light, p, {x, rng.next_float()}, 0.0f);
    const bool triangle = choice.light >= 10000;
    sphere_only.add(s && triangle
                        ? s->radiance.x * std::max(0.0f, glm::dot(s->wi, down)) / (s->pdf_solid_angle * choice.pmf)
                        : 0.0);
  }
  // The near and the far side of the sphere without occlusion: 2 pi (r / d)^2.
  EXPECT_TRUE(mean_agrees(sphere_only, 2.0 * M_PI / 9.0, {.test_count = 2}, 1e-3));
  EXPECT_TRUE(mean_agrees(all, expected + 2.0 * M_PI / 9.0, {.test_count = 2}, 1e-3));
}

TEST(LightSet, every_direction_of_a_textured_world_can_be_sampled) {
  SceneDescription d = dark();
  set_checker_world(d, Color(5.0f), Color(0.0f), 40.0f);  // cells of a few degrees
  const auto scene = build(d);
  const LightSet& lights = scene->lights();
  Pcg32 rng(1);
  RunningMoments brute, sampled = irradiance(lights, Vec3(0.0f), Vec3(0, 0, 1), 100000);
  for (int i = 0; i < 100000; ++i) {
    const float x = rng.next_float();
    const Vec3 wi = warp::square_to_sphere({x, rng.next_float()});
    ASSERT_GT(lights.pdf_li(0, Vec3(0.0f), wi, kInfinity, -wi, 0.0f), 0.0f);
    brute.add(lights.environment_radiance(wi, 0).x * std::max(0.0f, wi.z) * 4.0 * M_PI);
  }
  for (Vec3 pole : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(-1, 0, 0)})
    EXPECT_GT(lights.pdf_li(0, Vec3(0.0f), pole, kInfinity, -pole, 0.0f), 0.0f);
  EXPECT_TRUE(means_agree(brute, sampled));
}

TEST(LightSet, the_world_is_black_for_rays_to_which_it_is_invisible) {
  SceneDescription d = dark();
  set_world(d, Color(0.3f));
  d.world.visibility = kVisibleAll & ~uint32_t(kVisibleCamera);
  const auto scene = build(d);
  EXPECT_EQ(scene->lights().environment_radiance(Vec3(0, 0, 1), kRayCamera), Color(0.0f));
  EXPECT_EQ(scene->lights().environment_radiance(Vec3(0, 0, 1), kRayDiffuse), Color(0.3f));
}

TEST(LampShape, a_ray_hits_a_sphere_lamp_once) {
  const auto scene = with_lamp(point_light({0, 0, 0}, 10.0f, 1.0f));
  const Light light = scene->lights().light(0);
  Ray ray;
  ray.direction = Vec3(0, 0, -1);
  for (float z : {5.0f, 0.5f}) {
    ray.origin = Vec3(0, 0, z);
    ray.t_min = 0.0f;
    const float expected = z > 1.0f ? 4.0f : 1.5f;
    const auto crossing = intersect_lamp_shape(light, ray);
    ASSERT_TRUE(crossing);
    EXPECT_NEAR(crossing->t, expected, 1e-5f);
    const LampHit hit = scene->intersect_lamp(ray, kRayDiffuse);
    ASSERT_EQ(hit.light, 0u);
    EXPECT_NEAR(hit.t, expected, 1e-4f);
    ray.t_min = expected * 1.001f;
    EXPECT_FALSE(intersect_lamp_shape(light, ray));
    EXPECT_EQ(scene->intersect_lamp(ray, kRayDiffuse).light, ~0u);
  }
}

/// The disk faces the point from which the light is followed, not the surface that the ray passed last. One lamp is
/// tested by itself, more than eight are in a structure.
TEST(LampShape, a_soft_lamp_faces_the_start_of_a_straight_path) {
  SceneDescription few = dark(), many = dark();
  few.lights = {softened(point_light({0, 0, 2}, 10.0f, 1.0f))};
  many.lights = few.lights;
  for (int i = 0; i < 9; ++i) many.lights.push_back(softened(point_light({20.0f + float(i), 0, 2}, 10.0f, 0.1f)));
  const auto alone = build(few), structured = build(many);
  Ray ray;
  ray.origin = Vec3(0.6f, 0, 0);
  ray.direction = Vec3(0, 0, 1);
  for (const auto& scene : {alone, structured}) {
    const LampHit hit = scene->intersect_lamp(ray, kRayCamera);
    ASSERT_EQ(hit.light, 0u);
    // The plane through (0, 0, 2) that is perpendicular to (-0.6, 0, 2).
    EXPECT_NEAR(hit.t, 2.0f + 0.6f * 0.6f / 2.0f, 1e-5f);
    EXPECT_LT(glm::length(hit.normal - glm::normalize(Vec3(0.6f, 0, -2))), 1e-5f);
    Ray further = ray;
    further.origin.z = 1.8f;
    further.travelled = 1.8f;
    EXPECT_NEAR(scene->intersect_lamp(further, kRayCamera).t, hit.t - 1.8f, 1e-5f);
    further.travelled = 0.0f;  // from here, the disk fills less of the view
    EXPECT_EQ(scene->intersect_lamp(further, kRayCamera).light, ~0u);
    further.travelled = 1.8f;
    further.t_max = hit.t - 1.9f;
    EXPECT_EQ(scene->intersect_lamp(further, kRayCamera).light, ~0u);
  }
}

TEST(LightSet, shaders_of_lamps_can_depend_on_the_distance) {
  SceneDescription d;
  add_object(d, plane(1.0f), add_diffuse(d, Color(0.5f)));
  set_camera(d, Vec3(0, 0, 3), Vec3(0), 4);
  LightDescription light = lamp(LightKind::Point, placed(Vec3(0), Vec3(0, 0, -1)));
  Node falloff{
      "ShaderNodeLightFalloff", "Light Falloff", {{"Strength", {}, Vec4(1.0f)}, {"Smooth", {}, Vec4(0.0f)}}, {}};
  Node emission{
      "ShaderNodeEmission", "Emission", {{"Color", {}, Vec4(1.0f)}, {"Strength", {0, "Linear"}, Vec4(1.0f)}}, {}};
  light.graph.nodes = {falloff, emission};
  light.graph.surface = {1, "Emission"};
  d.lights.push_back(light);
  const auto scene = build(d);
  const auto near = scene->lights().sample_li(0, Vec3(0, 0, 1), {0.5f, 0.5f}, 0.0f),
             far = scene->lights().sample_li(0, Vec3(0, 0, 3), {0.5f, 0.5f}, 0.0f);
  ASSERT_TRUE(near && far);
  // With linear falloff, the intensity is proportional to the distance, which cancels one of its two powers.
  EXPECT_GT(near->radiance.x, 0.0f);
  EXPECT_NEAR(far->radiance.x / near->radiance.x, 3.0f / 9.0f, 1e-5f);
}

TEST(LightSet, suns_have_a_falloff_or_none) {
  for (const float none : {0.0f, 1.0f})
    for (const char* output : {"Quadratic", "Linear", "Constant"}) {
      SceneDescription d;
      add_object(d, plane(1.0f), add_diffuse(d, Color(0.5f)));
      set_camera(d, Vec3(0, 0, 3), Vec3(0), 4);
      LightDescription sun = lamp(LightKind::Sun, placed(Vec3(0), Vec3(0, 0, -1)));
      Node falloff{"ShaderNodeLightFalloff",
                   "Light Falloff",
                   {{"Strength", {}, Vec4(1.0f)}, {"Smooth", {}, Vec4(1.0f)}},
                   {number_property("suns_have_none", {none})}};
      Node emission{
          "ShaderNodeEmission", "Emission", {{"Color", {}, Vec4(1.0f)}, {"Strength", {0, output}, Vec4(1.0f)}}, {}};
      sun.graph.nodes = {falloff, emission};
      sun.graph.surface = {1, "Emission"};
      d.lights.push_back(sun);
      const auto scene = build(d);
      const auto sample = scene->lights().sample_li(0, Vec3(0, 0, 1), {0.5f, 0.5f}, 0.0f);
      const bool shines = none != 0.0f || output == std::string("Quadratic");
      EXPECT_EQ(sample && sample->radiance.x > 0.0f, shines) << output << " " << none;
    }
}

/// Lights of the same strength at the distance 1, of which the emission of some grows with the distance, are chosen by the
/// light that arrives.
TEST(LightSet, lights_whose_emission_grows_with_the_distance_are_chosen_by_what_arrives) {
  const char* const outputs[] = {"Quadratic", "Linear", "Constant"};
  const auto graph_of = [](const char* output, float strength) {
    Node falloff{
        "ShaderNodeLightFalloff", "Light Falloff", {{"Strength", {}, Vec4(strength)}, {"Smooth", {}, Vec4(0.0f)}}, {}};
    Node emission{
        "ShaderNodeEmission", "Emission", {{"Color", {}, Vec4(1.0f)}, {"Strength", {0, output}, Vec4(1.0f)}}, {}};
    NodeGraph graph;
    graph.nodes = {falloff, emission};
    graph.surface = {1, "Emission"};
    return graph;
  };
  SceneDescription lamps = dark(), meshes = dark();
  for (int i = 0; i < 3; ++i) {
    const Vec3 place(std::cos(float(i) * 2.1f), std::sin(float(i) * 2.1f), 0.0f);
    lamps.lights.push_back(point_light(place, 10.0f));
    lamps.lights.back().graph = graph_of(outputs[i], 1.0f);
    meshes.materials.push_back({outputs[i], graph_of(outputs[i], 3.0f), 0});
    add_object(meshes, triangle({-0.05f, 0, 0}, {0.05f, 0, 0}, {0, 0.05f, 0}), int(meshes.materials.size()) - 1,
               placed(place, {0, 0, 1}));
  }
  for (const SceneDescription& d : {lamps, meshes}) {
    const auto scene = build(d);
    for (const float z : {0.5f, 2.0f, 6.0f}) {
      const Vec3 p(0, 0, z);
      const float distance = std::sqrt(1.0f + z * z), still = scene->lights().choice_pmf(p, Vec3(0.0f), 0);
      float sum = still;
      for (uint32_t i = 1; i < 3; ++i) {
        const float pmf = scene->lights().choice_pmf(p, Vec3(0.0f), i), expected = std::pow(distance, float(i));
        // A node of two lights bounds them together.
        EXPECT_GT(pmf / still, 0.4f * expected) << i << " from " << z;
        EXPECT_LT(pmf / still, 2.5f * expected) << i << " from " << z;
        sum += pmf;
      }
      EXPECT_NEAR(sum, 1.0f, 1e-5f);
    }
  }
}

}  // namespace

// A large mesh whose emission was found black everywhere takes few of the samples from the lights that shine: a choice
// of it adds nothing, which is noise.
// A wall of light dots: two triangles, and a mask that is dark at the corners of a fine grid.
TEST(LightSet, a_screen_of_dots_has_the_power_of_its_dots) {
  SceneDescription d = dark();
  GraphBuilder g;
  const int place = g.node("ShaderNodeTexCoord");
  const int scaled = g.node(
      "ShaderNodeVectorMath",
      {linked_input("Vector", place, "Generated"), value_input("Vector_001", Vec4(192.0f, 96.0f, 0.0f, 0.0f))},
      {text_property("operation", "MULTIPLY")});
  const int in_cell = g.node("ShaderNodeVectorMath", {linked_input("Vector", scaled, "Vector")},
                             {text_property("operation", "FRACTION")});
  const int distance = g.node(
      "ShaderNodeVectorMath",
      {linked_input("Vector", in_cell, "Vector"), value_input("Vector_001", Vec4(0.5f, 0.5f, 0.0f, 0.0f))},
      {text_property("operation", "DISTANCE")});
  const int dot = g.node("ShaderNodeMath", {linked_input("Value", distance, "Value"), value_input("Value_001", 0.38f)},
                         {text_property("operation", "LESS_THAN")});
  const int emission = g.node("ShaderNodeEmission",
                              {value_input("Color", Vec4(1.0f)), linked_input("Strength", dot, "Value")});
  const int material = add_diffuse(d, Color(0.5f));
  d.materials[size_t(material)].graph = g.graph;
  d.materials[size_t(material)].graph.surface = {emission, "Emission"};
  add_object(d, plane(1.0f), material, Mat4(1.0f));
  const auto scene = build(d);
  const LightSet& lights = scene->lights();
  ASSERT_EQ(lights.size(), 2u);
  // Both sides of 4 m^2 emit on pi 0.38^2 of their area.
  const double watts = 2.0 * M_PI * 4.0 * M_PI * 0.38 * 0.38;
  EXPECT_NEAR(lights.total_power(), watts, 0.1 * watts);
}

TEST(LightSet, large_meshes_that_were_found_dark_are_chosen_rarely) {
  SceneDescription d = dark();
  d.lights.push_back(sun({0, 0, -1}, 0.0f));
  Node checker, emission = closure_node("ShaderNodeEmission", Color(0.0f));
  checker.type = checker.name = "ShaderNodeTexChecker";
  checker.inputs = {{"Color1", {}, Vec4(0.0f)}, {"Color2", {}, Vec4(0.0f)}, {"Scale", {}, Vec4(5.0f)}};
  emission.inputs = {{"Color", {0, "Color"}, Vec4(1.0f)}, {"Strength", {}, Vec4(1.0f)}};
  for (const int rings : {3, 48}) {
    SceneDescription one = d;
    const int material = add_diffuse(one, Color(0.5f));
    one.materials[size_t(material)].graph.nodes = {checker, emission};
    one.materials[size_t(material)].graph.surface = {1, "Emission"};
    add_object(one, sphere(rings), material, placed({0, 0, 2}, {0, 0, 1}));
    const auto scene = build(one);
    const LightSet& lights = scene->lights();
    ASSERT_GT(lights.size(), 1u);
    const float of_sun = lights.choice_pmf(Vec3(0.0f), Vec3(0, 0, 1), 0);
    EXPECT_GT(lights.choice_pmf(Vec3(0.0f), Vec3(0, 0, 1), 1 + uint32_t(lights.size()) / 2), 0.0f) << "it may emit";
    if (rings == 48) {
      EXPECT_GT(of_sun, 0.9f);
      EXPECT_GT(lights.power_pmf(0), 0.999f);
    } else {
      EXPECT_LT(lights.power_pmf(0), 0.997f);
    }
  }
}

}  // namespace ajar::test_light_set
