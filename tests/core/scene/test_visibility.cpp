#include "agreement.h"

namespace ajar::test_visibility {

using namespace fixtures;

namespace {

constexpr uint32_t kNotDiffuse = kVisibleAll & ~kVisibleDiffuse,
                   kOnlyDiffuse = kVisibleAll & ~(kVisibleGlossy | kVisibleTransmission);

/// A floor that is half diffuse and half glossy, with a rough glass ball above it. Light has one bounce.
SceneDescription lit(const std::string& kind, uint32_t visibility) {
  SceneDescription d;
  add_object(d, plane(3.0f), add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.4f), moved(Vec3(0, 0, -0.5f)));
  add_object(d, sphere(8), add_glass(d, 0.4f), moved(Vec3(0.2f, 0.3f, -0.1f), 0.3f));
  set_camera(d, Vec3(0.1f, -3.0f, 1.2f), Vec3(0.0f, 0.0f, -0.25f), 12, 0.4f);
  d.settings.bounces = {1, 1, 1, 1, 8, 0};
  if (kind == "lamp" || kind == "sun") {
    LightDescription light = area_lamp(Vec3(0.1f, 1.5f, 1.5f), Vec3(0, -1, -1), 1.0f, 20.0f);
    if (kind == "sun") {
      light.kind = LightKind::Sun;
      light.energy = 2.0f;
      light.sun_angle = 0.4f;
    }
    light.visibility = visibility;
    d.lights.push_back(light);
  } else if (kind == "emitter") {
    add_object(d, plane(0.4f), add_diffuse(d, Color(0.0f), Color(5.0f)),
               shining(Vec3(0.1f, 1.5f, 1.2f), Vec3(0, -1, -1)));
    d.objects.back().visibility = visibility & ~kVisibleCamera;
  } else {
    set_world(d, Color(0.7f));
    d.world.visibility = visibility & ~kVisibleCamera;
  }
  return d;
}

}  // namespace

class LightVisibility : public ::testing::TestWithParam<const char*> {};

/// The light of diffuse lobes plus the light of other lobes is all light. Four tests; each exceeds four standard errors
/// with the probability 6e-5.
TEST_P(LightVisibility, light_of_diffuse_and_of_other_lobes_sums_to_all_light) {
  const auto mean = [](uint32_t visibility) { return whole(lit(GetParam(), visibility), "path", 64, 16, 300); };
  const RunningMoments all = mean(kVisibleAll), others = mean(kNotDiffuse), diffuse = mean(kOnlyDiffuse);
  const double error = std::sqrt((all.variance() + others.variance() + diffuse.variance()) / 16.0);
  EXPECT_NEAR(all.mean(), others.mean() + diffuse.mean(), 4.0 * error);
  EXPECT_LT(error, 0.01 * all.mean());
  EXPECT_GT(others.mean(), 0.05 * all.mean());
  EXPECT_GT(diffuse.mean(), 0.05 * all.mean());
}

/// Rays of glossy lobes find what light samples find rarely: the noise is not larger than that of a light for all rays.
/// Light samples alone have 18 to 80,000 times the variance.
TEST_P(LightVisibility, sharp_reflections_of_a_light_for_glossy_rays_have_little_noise) {
  const auto variance = [](uint32_t visibility) {
    SceneDescription d = lit(GetParam(), visibility);
    d.objects[0].materials = {add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.1f)};
    return whole(d, "path", 64, 16, 300).variance();
  };
  // A variance of 16 values has a relative standard error of 0.37.
  EXPECT_LT(variance(kNotDiffuse), 3.0 * variance(kVisibleAll));
}

/// The guide samples directions for both kinds of lobes, and chooses the kind of the ray.
TEST_P(LightVisibility, a_path_guide_does_not_change_the_light_of_glossy_rays) {
  SceneDescription d = lit(GetParam(), kNotDiffuse);
  const RunningMoments plain = whole(d, "path", 256, 16, 300);
  d.settings.guiding = Guiding::On;
  const RunningMoments guided = whole(d, "path", 256, 16, 600);
  EXPECT_LT(4.8 * std::sqrt(plain.variance_of_mean() + guided.variance_of_mean()) / plain.mean(), 0.02)
      << "inconclusive";
  EXPECT_TRUE(statistical::means_agree(plain, guided)) << plain.mean() << " and " << guided.mean();
}

INSTANTIATE_TEST_SUITE_P(Kinds, LightVisibility, ::testing::Values("lamp", "sun", "emitter", "world"),
                         [](const auto& info) { return std::string(info.param); });

TEST(Holdout, holdout_objects_are_holes_for_the_camera_and_visible_to_other_objects) {
  for (const char* integrator : {"path", "bdpt", "photon_map", "metropolis"}) {
    SceneDescription d = lit("lamp", kVisibleAll);
    d.settings.bounces = {4, 4, 4, 4, 8, 0};
    set_world(d, Color(0.5f));
    d.instances[1].world_from_object = rows(moved(Vec3(0.1f, -0.5f, 0.1f), 0.7f));
    const auto before = render(d, integrator, 4, 1);
    d.objects[1].holdout = true;  // the ball
    const auto after = render(d, integrator, 4, 1);
    int holes = 0;
    for (size_t y = 1; y < 11; ++y) {
      for (size_t x = 1; x < 11; ++x) {
        const size_t i = 4 * (12 * y + x);
        EXPECT_NEAR(before[i + 3], 1.0f, 1e-5f);
        bool inside = true;  // the pixel filter spreads the surroundings into pixels at the border of the hole
        for (size_t k : {i - 52, i - 48, i - 44, i - 4, i, i + 4, i + 44, i + 48, i + 52})
          inside &= after[k + 3] == 0.0f;
        if (!inside) continue;
        ++holes;
        for (size_t c = 0; c < 3; ++c) EXPECT_EQ(after[i + c], 0.0f) << integrator;
      }
    }
    EXPECT_GT(holes, 0) << integrator;
    EXPECT_LT(holes, 50) << integrator;
  }
}

}  // namespace ajar::test_visibility
