#include <gtest/gtest.h>

#include "lights/sources/lamp.h"
#include "math/random.h"
#include "math/warps.h"
#include "scene_fixtures.h"

namespace ajar::test_lamp_cones {

using namespace fixtures;

TEST(Lamps, rays_are_clipped_to_the_cone_of_a_spot_or_area_lamp) {
  Pcg32 rng(11);
  int inside = 0;
  for (int i = 0; i < 4000; ++i) {
    LightDescription d;
    const bool is_area = i % 2 == 1;
    d.kind = is_area ? LightKind::Area : LightKind::Spot;
    d.spot_angle = 0.05f + 3.0f * rng.next_float();
    d.spread = i % 4 == 1 ? kPi : 0.05f + 3.0f * rng.next_float();
    d.even_spot = true;
    d.world_from_light = rows(shining(Vec3(0), warp::square_to_sphere({rng.next_float(), rng.next_float()})));
    if (i % 8 >= 4) d.radius = 0.3f;
    d.area_size = i % 8 >= 4 ? Vec2(0.5f, 0.2f) : Vec2(0.0f);
    const Light light = make_lamp(d);
    const bool is_point = i % 8 < 4;
    const auto random_point = [&] { return Vec3(rng.next_float(), rng.next_float(), rng.next_float()) * 4.0f - 2.0f; };
    Ray ray;
    ray.origin = random_point();
    ray.direction = glm::normalize(random_point() - ray.origin);
    float begin = 0.1f, end = 3.0f;
    clip_to_cone(light, ray, begin, end);
    for (int k = 0; k < 60; ++k) {
      const float t = 0.1f + 2.9f * (float(k) + 0.5f) / 60.0f;
      const Vec3 at = ray.origin + t * ray.direction;
      const float u = 2.0f * rng.next_float() - 1.0f, v = 2.0f * rng.next_float() - 1.0f;
      const Vec3 from = is_area ? u * light.edge1 + v * light.edge2
                                : light.radius * warp::square_to_sphere({0.5f * u + 0.5f, 0.5f * v + 0.5f});
      const bool lit = lamp_profile(light, glm::normalize(at - from)) > 0.0f;
      inside += lit;
      if (t < begin - 1e-3f || t > end + 1e-3f) {
        EXPECT_FALSE(lit) << i << " at " << t << ": " << begin << " to " << end;
      } else if (is_point && t > begin + 1e-3f && t < end - 1e-3f) {
        EXPECT_TRUE(lit) << i << " at " << t << ": " << begin << " to " << end;
      }
    }
  }
  EXPECT_GT(inside, 20000);
}

}  // namespace ajar::test_lamp_cones
