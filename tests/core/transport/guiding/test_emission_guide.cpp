// Starts of walks from lights that are learned: their densities, what is learned, and that no mean changes.
#include "agreement.h"
#include "hint_fixtures.h"

#include "transport/guiding/emission_guide.h"
#include "transport/hints/emission_training.h"
#include "transport/hints/followed_hints.h"
#include "transport/paths/walk.h"

namespace ajar::test_emission_guide {

namespace {

using namespace fixtures;
using namespace statistical;

/// A floor with a light of each kind.
struct Lit {
  const char* name;
  LightType type;
  double measure;  ///< of all its starts, without the directions: area, or solid angle of a distant light
  std::function<void(SceneDescription&)> add;
};

LightDescription lamp_of(LightKind kind, float radius) {
  LightDescription light = area_lamp(Vec3(0.2f, 0.1f, 1.0f), Vec3(0.1f, 0.2f, -1.0f), 0.2f, 5.0f);
  light.kind = kind;
  light.radius = radius;
  return light;
}

LightDescription sun(float angle) {
  LightDescription light = lamp_of(LightKind::Sun, 0.0f);
  light.sun_angle = angle;
  return light;
}

/// A lamp of Blender 4, whose places face the direction of the ray.
LightDescription soft_ball() {
  LightDescription light = lamp_of(LightKind::Point, 0.1f);
  light.soft_falloff = true;
  return light;
}

constexpr float kSunAngle = 0.1f;

std::vector<Lit> lights() {
  const auto add_lamp = [](LightDescription light) {
    return [light](SceneDescription& d) { d.lights.push_back(light); };
  };
  return {
      {"area", LightType::Rectangle, 0.04, add_lamp(lamp_of(LightKind::Area, 0.0f))},
      {"point", LightType::Point, 1.0, add_lamp(lamp_of(LightKind::Point, 0.0f))},
      {"sphere", LightType::Sphere, 2.0 * M_PI * 0.01, add_lamp(lamp_of(LightKind::Point, 0.1f))},
      {"soft sphere", LightType::Sphere, 2.0 * M_PI * 0.01, add_lamp(soft_ball())},
      {"parallel sun", LightType::DistantDelta, 1.0, add_lamp(sun(0.0f))},
      {"sun", LightType::DistantDisk, 2.0 * M_PI * (1.0 - std::cos(0.5 * double(kSunAngle))), add_lamp(sun(kSunAngle))},
      {"mesh", LightType::Triangle, 0.16,
       [](SceneDescription& d) {
         add_object(d, plane(0.2f), add_diffuse(d, Color(0.5f), Color(3.0f)), moved(Vec3(0.2f, 0.1f, 1.0f)));
       }},
      {"world", LightType::Environment, 1.0,
       [](SceneDescription& d) { set_checker_world(d, Color(2.0f), Color(1.0f), 3.0f); }}};
}

SceneDescription floor_with(const Lit& lit) {
  SceneDescription d;
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.6f, 0.5f, 0.7f)), moved(Vec3(0, 0, -0.5f)));
  set_camera(d, Vec3(0.1f, -3.0f, 1.2f), Vec3(0.0f, 0.0f, -0.25f), 12, 0.5f);
  lit.add(d);
  return d;
}

const Vec3 kAim(0.5f, 0.3f, -0.5f);  // on the floor

/// Starts of all lights towards places near kAim.
std::vector<LightStart> starts_towards_aim(const Scene& scene) {
  std::vector<LightStart> starts;
  Pcg32 rng(7);
  for (const LightSet::SourceRange& source : scene.lights().sources())
    for (int i = 0; i < 3000; ++i) {
      const uint32_t light = source.first + rng.next() % source.count;
      const Vec3 at = kAim + 0.2f * Vec3(rng.next_float() - 0.5f, rng.next_float() - 0.5f, 0.0f);
      const Vec2 u(rng.next_float(), rng.next_float()), v(rng.next_float(), rng.next_float());
      const auto ray = scene.lights().sample_le(light, u, v, kMidShutter);
      if (!ray) continue;
      const Vec3 direction = source.distant ? ray->ray.direction : glm::normalize(at - ray->ray.origin);
      starts.push_back({light, source.distant ? at : ray->ray.origin, direction, 1.0f});
    }
  return starts;
}

std::shared_ptr<const EmissionMap> map_of(const Scene& scene) {
  return std::make_shared<const EmissionMap>(scene.lights(), EmissionMap::Extent{kAim, scene.center(), scene.radius()},
                                             starts_towards_aim(scene));
}

}  // namespace

/// The expectation of 1 / pdf over the starts in a region is the measure of the region.
TEST(EmissionGuide, starts_have_the_density_of_the_mixture) {
  for (const Lit& lit : lights()) {
    const auto scene = build(floor_with(lit));
    const LightSet& lights = scene->lights();
    const auto map = map_of(*scene);
    ASSERT_FALSE(map->empty()) << lit.name;
    const EmissionGuide guide(map, 0.6f, nullptr);
    const bool distant = is_distant(lit.type);
    const uint32_t samples = distant ? 1200000 : 300000;
    for (const bool aimed : {true, false}) {
      const bool world = lit.type == LightType::Environment;
      const double cone = world ? 0.2 : 0.02, radius = world ? 0.6 : 0.15;
      // Directions within a cone, and for distant lights also rays that pass near a point.
      const Vec3 through = aimed ? kAim : Vec3(-1.0f, -0.8f, -0.5f);
      const Vec3 axis = world ? glm::normalize(Vec3(0.2f, aimed ? 0.3f : -0.6f, -0.8f))
                              : glm::normalize(through - Vec3(0.2f, 0.1f, 1.0f));
      double measure = lit.measure;
      if (!distant || world) measure *= 2.0 * M_PI * cone;
      if (distant) measure *= M_PI * sqr(radius);
      RunningMoments moments;
      Sampler sampler(Sampler::Kind::Independent, 3);
      PathVertex light, next;
      next.kind = VertexKind::Lens;
      for (uint32_t i = 0; i < samples; ++i) {
        sampler.start(i, 0);
        const float u = sampler.get_1d();
        const Vec2 a = sampler.get_2d(), b = sampler.get_2d();
        Ray ray;
        double value = 0.0;
        if (start_at_light(*scene, &guide, {u, a, b}, kMidShutter, light, ray) &&
            lights.flags(uint32_t(light.light)).type == lit.type) {
          const bool in_cone = double(0.5f * length_squared(ray.direction - axis)) <= cone;
          const bool passes = double(glm::length(glm::cross(through - ray.origin, ray.direction))) <= radius;
          const bool inside = !distant ? in_cone : passes && (in_cone || !world);
          // Half of a sphere faces away.
          if (inside && (lit.type != LightType::Sphere || glm::dot(light.point.ng, ray.direction) > 0.0f)) {
            PathEdge edge;
            edge.to_eye = ray.direction;
            next.point.position = ray.origin + glm::dot(through - ray.origin, ray.direction) * ray.direction;
            const LightEnd end = light_end(*scene, light, next, edge, &guide);
            ASSERT_GT(end.pdf_origin * end.pdf_direction, 0.0f) << lit.name;
            value = 1.0 / (double(end.pdf_origin) * double(end.pdf_direction));
          }
        }
        moments.add(value);
      }
      EXPECT_TRUE(mean_agrees(moments, measure, {0.01, 14})) << lit.name << (aimed ? ", aimed" : ", elsewhere");
      EXPECT_LT(std::sqrt(moments.variance_of_mean()), 0.05 * measure) << lit.name << ": inconclusive";
    }
  }
}

/// The light that photons store does not depend on the guide, and the guide sends more of them to the aim.
TEST(EmissionGuide, photons_store_the_same_light) {
  for (const Lit& lit : lights()) {
    const auto scene = build(floor_with(lit));
    const EmissionGuide guide(map_of(*scene), 0.6f, nullptr);
    RunningMoments flux[2];
    const uint32_t passes = lit.type == LightType::Environment ? 256 : lit.type == LightType::Sphere ? 128 : 64;
    uint64_t near_aim[2] = {0, 0};
    for (const bool guided : {false, true})
      for (uint32_t pass = 0; pass < passes; ++pass) {
        PhotonEmission emission;
        emission.plan.global = true;
        emission.seed = guided ? 5 : 6;
        emission.pass = pass;
        emission.count = 4000;
        emission.guide = guided ? &guide : nullptr;
        const PhotonBatch batch = trace_photons(*scene, nullptr, emission, std::atomic<bool>{false});
        double sum = 0.0;
        for (const Photon& photon : batch.global) {
          sum += double(luminance(photon.flux_over_cosine));
          near_aim[guided] += length_squared(photon.point.position - kAim) < sqr(0.15f);
        }
        flux[guided].add(sum);
      }
    EXPECT_TRUE(means_agree(flux[0], flux[1], {0.01, 7})) << lit.name;
    EXPECT_LT(std::sqrt(flux[0].variance_of_mean() + flux[1].variance_of_mean()), 0.005 * flux[0].mean())
        << lit.name << ": a bias of 2 % would not be seen";
    EXPECT_GT(near_aim[1], 5 * near_aim[0]) << lit.name;
  }
}

namespace {

/// A dim room whose light comes from a sun through a small pane of glass, on a ground that is much larger.
SceneDescription room_on_ground(float ground) {
  SceneDescription d = grey_room(12);
  // The wall at +x has a hole.
  MeshDescription& walls = d.meshes[0];
  std::erase_if(walls.triangles, [&](const UVec3& t) {
    return walls.positions[t.x].x > 0 && walls.positions[t.y].x > 0 && walls.positions[t.z].x > 0;
  });
  const auto wall = [&](float y0, float y1, float z0, float z1) {
    add_object(d, plane(1.0f), 0,
               Mat4(Vec4(0, 0.5f * (y1 - y0), 0, 0), Vec4(0, 0, 0.5f * (z1 - z0), 0), Vec4(1, 0, 0, 0),
                    Vec4(1.0f, 0.5f * (y0 + y1), 0.5f * (z0 + z1), 1)));
  };
  wall(-1.0f, -0.3f, -1.0f, 1.0f);
  wall(0.3f, 1.0f, -1.0f, 1.0f);
  wall(-0.3f, 0.3f, -1.0f, 0.2f);
  wall(-0.3f, 0.3f, 0.8f, 1.0f);
  add_object(d, cube(), add_glass(d, 0.0f),
             Mat4(Vec4(0.01f, 0, 0, 0), Vec4(0, 0.3f, 0, 0), Vec4(0, 0, 0.3f, 0), Vec4(1.02f, 0.0f, 0.5f, 1)));
  add_object(d, plane(ground), 0, moved(Vec3(0, 0, -1.01f)));
  LightDescription light = sun(0.02f);
  light.world_from_light = rows(shining(Vec3(0.0f), Vec3(-1.0f, 0.1f, -0.8f)));
  d.lights.push_back(light);
  return d;
}

LearnedEmission learned_in(const SceneDescription& d, uint32_t seed = 1) {
  const auto scene = build(d);
  return learn_emission({*scene, nullptr, seed}, std::atomic<bool>{false});
}

}  // namespace

TEST(EmissionTraining, learns_where_few_starts_matter) {
  for (const uint32_t seed : {1u, 2u, 3u}) {
    const LearnedEmission learned = learned_in(room_on_ground(20.0f), seed);
    ASSERT_TRUE(learned.map);
    EXPECT_GT(learned.gain, 20.0) << seed;
    EXPECT_GT(learned.share, 0.0f);
    EXPECT_LT(learned.map->memory_bytes(), size_t(4) << 20);
  }
}

TEST(EmissionTraining, costs_nothing_where_no_surface_is_smooth) {
  SceneDescription d = grey_room();
  d.lights.push_back(area_lamp(Vec3(0, 0, 0.9f), Vec3(0, 0, -1), 0.5f, 8.0f));
  const LearnedEmission learned = learned_in(d);
  EXPECT_FALSE(learned.map);
  EXPECT_EQ(learned.rays, 0u);
}

TEST(EmissionTraining, is_not_used_where_most_starts_matter) {
  const LearnedEmission learned = learned_in(scene_named("glass_ball"));
  EXPECT_FALSE(learned.map);
  EXPECT_GT(learned.rays, 0u);
}

TEST(EmissionTraining, one_bright_photon_does_not_hide_the_sharp_paths) {
  std::vector<PhotonValue> values(2000, {LightStart{0, Vec3(0.0f), Vec3(0, 0, 1), 1.0f}, 1.0f, false});
  for (size_t i = 0; i < values.size(); i += 5) values[i].sharp_first = true;
  EXPECT_NEAR(sharp_share(values), 0.2, 1e-9);
  values[1].start.value = 10000.0f;
  EXPECT_GT(sharp_share(values), 0.15);
}

TEST(EmissionTraining, is_shared_until_the_camera_moves) {
  const auto scene = build(room_on_ground(20.0f));
  SharedEmission shared;
  const std::atomic<bool> stop{false};
  uint64_t rays = 0, again = 0;
  const auto first = shared.get({*scene, nullptr, 1}, stop, rays);
  const auto second = shared.get({*scene, nullptr, 2}, stop, again);
  EXPECT_GT(rays, 0u);
  EXPECT_EQ(again, 0u);
  EXPECT_EQ(first.map, second.map);
  SceneDescription d = room_on_ground(20.0f);
  set_camera(d, Vec3(0.2f, -0.9f, 0.1f), Vec3(0.0f, 0.5f, -0.25f), 12, 0.7f);
  const auto moved_scene = build(d);
  shared.get({*moved_scene, nullptr, 2}, stop, again);
  EXPECT_GT(again, 0u);
}

/// Nothing is kept of a training that was stopped.
TEST(EmissionTraining, stops) {
  const auto scene = build(room_on_ground(20.0f));
  SharedEmission shared;
  uint64_t rays = 0;
  EXPECT_FALSE(shared.get({*scene, nullptr, 1}, std::atomic<bool>{true}, rays).map);
  EXPECT_TRUE(shared.get({*scene, nullptr, 1}, std::atomic<bool>{false}, rays).map);
}

/// Bidirectional path tracing, with learned starts and without them.
TEST(EmissionTraining, changes_no_mean_and_reduces_noise) {
  const auto scene = build(room_on_ground(6.0f));
  const std::atomic<bool> stop{false};
  RunningMoments means[2];
  for (const bool learns : {false, true})
    for (uint32_t seed = 0; seed < 20; ++seed) {
      AttachedHints hints = attach_hints(*scene);
      if (!learns) hints.emission = nullptr;
      const auto integrator = make_integrator("bdpt");
      integrator->prepare(
          scene, make_render_plan(*scene, find_integrator("bdpt"), std::make_shared<const AttachedHints>(hints)),
          seed + (learns ? 1000 : 0));
      Film film(0, 0, 12, 12, {"Combined"});
      integrator->run_iteration(film, learns ? 64 : 256, stop);
      EXPECT_EQ(integrator->statistics().extra["emission_gain"] > 0.0, learns);
      double sum = 0.0;
      for (const float value : film.resolve("Combined", 1.0f)) sum += double(value);
      means[learns].add(sum);
    }
  EXPECT_TRUE(means_agree(means[0], means[1], {0.01, 1})) << means[0].mean() << " " << means[1].mean();
  EXPECT_LT(4.0 * std::sqrt(means[1].variance_of_mean() + means[0].variance_of_mean()), 0.02 * means[0].mean())
      << "inconclusive";
  EXPECT_LT(4.0 * means[1].variance_of_mean(), 4.0 * means[0].variance_of_mean());
}

}  // namespace ajar::test_emission_guide
