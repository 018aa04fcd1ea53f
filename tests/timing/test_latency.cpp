// Limits of time: how soon a render stops after a request, and how long large sets of lights take to build.
#include <chrono>
#include <cstdio>

#include <gtest/gtest.h>

#include "math/random.h"
#include "render/session.h"
#include "transport_scenes.h"

using namespace ajar;
using namespace ajar::fixtures;

namespace {

double seconds_of(const std::function<void()>& act) {
  const auto start = std::chrono::steady_clock::now();
  act();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

SceneDescription lit_room(int size) {
  SceneDescription d = grey_room(size);
  d.lights.push_back(area_lamp(Vec3(0, 0, 0.9f), Vec3(0, 0, -1), 0.5f, 20.0f));
  return d;
}

}  // namespace

TEST(Session, cancel_returns_within_a_fifth_of_a_second) {
  SceneDescription d = lit_room(1024);
  d.settings.samples = 1 << 20;
  Session session;
  session.start(d);
  session.wait(0.5);
  EXPECT_LT(seconds_of([&] {
              session.cancel();
              session.wait(kHang);
            }),
            0.2);
}

// One sample of every pixel of this image takes long, so that iterations must be interrupted. The pilot and learning
// are within the limit.
TEST(Session, a_time_limit_is_kept) {
  for (const char* integrator : {"auto", "path", "bdpt", "metropolis", "erpt", "pmc_pt", "photon_map", "mps"}) {
    SceneDescription d = lit_room(512);
    d.settings.integrator = integrator;
    d.settings.samples = 0;
    d.settings.seconds = 6.0;
    Session session;
    session.start(d);
    double seconds = 0.0;
    while (session.progress().phase == Progress::Phase::Building) session.wait(0.01);
    seconds = seconds_of([&] { session.wait(kHang); });
    EXPECT_LT(seconds, 6.0 + 0.5) << integrator;
    RecordProperty(integrator, std::to_string(seconds));
    std::printf("%s: %.2f s, %.3g samples a pixel\n", integrator, seconds, double(session.progress().samples));
  }
}

TEST(LightSet, many_lamps_and_triangles_build_within_five_seconds) {
  SceneDescription d;
  set_camera(d, Vec3(0, -4, 1), Vec3(0), 16);
  Pcg32 rng(1);
  for (int i = 0; i < 10000; ++i)
    d.lights.push_back(point_light({rng.next_float(), rng.next_float(), rng.next_float()}, rng.next_float() + 0.1f));
  add_object(d, sphere(250), add_diffuse(d, Color(0.0f), Color(1.0f)));  // 250,000 triangles
  EXPECT_LT(build(d)->statistics().seconds, 5.0);
}
