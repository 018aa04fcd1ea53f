// Errors count in the image as it is displayed. A scene with 1,024 times the light that is displayed at -10 stops is
// rendered by the same samples as the original, by all integrators.
#include <gtest/gtest.h>

#include "integrators/integrator.h"
#include "renders.h"
#include "transport_scenes.h"

namespace ajar::test_view_exposure {

namespace {

using namespace fixtures;

constexpr float kTimes = 1024.0f;

/// A room with a lamp behind an edge, so that one part is much darker than the other.
SceneDescription half_lit(float times, float view_exposure) {
  SceneDescription d = grey_room(16);
  add_object(d, cube(false), add_diffuse(d, Color(0.3f)), moved(Vec3(-0.25f, -0.1f, 0.0f), 0.3f));
  add_object(d, sphere(8), add_glass(d, 0.0f), moved(Vec3(0.3f, 0.3f, -0.4f), 0.3f));
  d.lights.push_back(area_lamp(Vec3(0.6f, 0.3f, 0.9f), Vec3(0, 0, -1), 0.2f, 0.5f * times));
  d.settings.view_exposure = view_exposure;
  d.settings.image = ImageSampling::PmcIp;
  d.settings.guiding = Guiding::On;
  return d;
}

TEST(ViewExposure, light_that_is_displayed_alike_is_rendered_alike) {
  for (const IntegratorInfo& info : integrator_list()) {
    SCOPED_TRACE(info.name);
    const std::vector<float> plain = render(half_lit(1.0f, 1.0f), info.name, 16, 5),
                             bright = render(half_lit(kTimes, 1.0f / kTimes), info.name, 16, 5);
    ASSERT_EQ(plain.size(), bright.size());
    double sum = 0.0, difference = 0.0;
    for (size_t i = 0; i < plain.size(); ++i) {
      if (i % 4 == 3) continue;
      sum += std::abs(double(plain[i]));
      difference += std::abs(double(bright[i]) / double(kTimes) - double(plain[i]));
    }
    EXPECT_GT(sum, 0.0);
    EXPECT_LT(difference, 1e-5 * sum);
  }
}

}  // namespace

}  // namespace ajar::test_view_exposure
