// Every map of warps.h draws from the density that is declared with it.
#include "statistical.h"

#include "math/warps.h"

namespace ajar::test_warps {

namespace {

using namespace statistical;

struct Warp {
  const char* name;
  SampleDomain domain;
  Map map;
  Density pdf;
};

float angle_complement(Vec3 w) {  // 1 - z without cancellation near the pole
  return w.z > 0.0f ? (w.x * w.x + w.y * w.y) / (1.0f + w.z) : 1.0f - w.z;
}

std::vector<Warp> warps() {
  std::vector<Warp> all{
      {"disk", SampleDomain::Disk, [](Vec2 u) { return Vec3(warp::square_to_disk(u), 0.0f); },
       [](Vec3) { return warp::disk_pdf_area(); }},
      {"cosine hemisphere", SampleDomain::Hemisphere, [](Vec2 u) { return warp::square_to_cosine_hemisphere(u); },
       [](Vec3 w) { return warp::cosine_hemisphere_pdf_solid_angle(w.z); }},
      {"sphere", SampleDomain::Sphere, [](Vec2 u) { return warp::square_to_sphere(u); },
       [](Vec3) { return warp::sphere_pdf_solid_angle(); }},
      {"hemisphere", SampleDomain::Hemisphere, [](Vec2 u) { return warp::square_to_hemisphere(u); },
       [](Vec3) { return warp::hemisphere_pdf_solid_angle(); }},
      {"triangle", SampleDomain::Square, [](Vec2 u) { return Vec3(warp::square_to_triangle(u), 0.0f); },
       [](Vec3 b) { return b.x + b.y <= 1.0f ? warp::triangle_pdf_barycentric() : 0.0f; }}};
  for (float angle : {3.1f, 1.0f, 0.1f, 0.0046f, 1e-4f}) {
    const float size = warp::one_minus_cos(angle);
    all.push_back(
        {"cone", SampleDomain::Sphere, [=](Vec2 u) { return warp::square_to_cone(u, size); },
         [=](Vec3 w) { return angle_complement(w) <= size * 1.00001f ? warp::cone_pdf_solid_angle(size) : 0.0f; }});
  }
  return all;
}

TEST(Warps, samples_follow_their_density) {
  for (const Warp& w : warps())
    EXPECT_TRUE(chi_square_agrees(from_square(w.map), w.pdf, {.domain = w.domain, .level = {.test_count = 10}}))
        << w.name;
}

TEST(Warps, jacobian_is_one_over_the_density) {
  for (const Warp& w : warps())
    EXPECT_TRUE(jacobian_agrees(w.map, w.pdf, {.step = 1.0 / 128.0, .tolerance = 0.04})) << w.name;
}

TEST(Warps, corners_of_the_square_stay_in_the_domain) {
  const float edge[] = {0.0f, 0x1p-24f, 0.5f, kOneMinusEpsilon};
  for (const Warp& w : warps())
    for (float x : edge)
      for (float y : edge) {
        const Vec3 p = *w.map({x, y});
        EXPECT_TRUE(is_finite(p)) << w.name;
        if (w.domain == SampleDomain::Sphere || w.domain == SampleDomain::Hemisphere) {
          EXPECT_NEAR(glm::length(p), 1.0f, 1e-6f) << w.name;
        }
        if (w.domain == SampleDomain::Disk) {
          EXPECT_LE(glm::length(p), 1.0f + 1e-6f) << w.name;
        }
        if (w.domain == SampleDomain::Square) {
          EXPECT_TRUE(p.x >= 0.0f && p.y >= 0.0f && p.x + p.y <= 1.0f) << w.name;
        }
      }
}

TEST(Warps, an_empty_cone_cannot_be_sampled) {
  EXPECT_EQ(warp::cone_pdf_solid_angle(0.0f), 0.0f);
  EXPECT_EQ(warp::cosine_hemisphere_pdf_solid_angle(-0.1f), 0.0f);
}

TEST(Warps, one_minus_cos_does_not_cancel) {
  for (double angle : {1e-6, 1e-4, 0.0046, 0.5, 3.0})
    EXPECT_NEAR(warp::one_minus_cos(float(angle)) / (2.0 * std::pow(std::sin(0.5 * angle), 2.0)), 1.0, 1e-5);
}

}  // namespace

}  // namespace ajar::test_warps
