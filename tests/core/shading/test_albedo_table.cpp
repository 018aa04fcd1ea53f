#include "shading/models/albedo_table.h"

#include <gtest/gtest.h>

#include "bsdf_fixtures.h"
#include "math/random.h"
#include "math/statistics.h"
#include "math/warps.h"
#include "shading/models/fresnel.h"
#include "shading/models/sheen.h"

namespace ajar::test_albedo_table {

using namespace fixtures;
using closures::Distribution;

namespace {

/// The directional albedo of the lobe: the mean weight of its samples.
double sampled_albedo(const Material& material, Vec3 wo) {
  const Bsdf bsdf = make_bsdf(material, wo);
  Pcg32 rng(17);
  RunningMoments moments;
  for (int i = 0; i < 20000; ++i) {
    const float u = rng.next_float(), ux = rng.next_float();
    const auto s = bsdf.sample(wo, u, {ux, rng.next_float()});
    moments.add(s ? s->f_cos.y / s->pdf_solid_angle : 0.0);
  }
  return moments.mean();
}

}  // namespace

TEST(AlbedoTable, mirror_albedo_is_that_of_the_single_scattering_lobe) {
  for (float roughness : {0.2f, 0.55f, 0.83f, 1.0f})
    for (float c : {0.98f, 0.4f, 0.13f, 0.03f}) {
      const Material m{
          "", [=](Bsdf& b, const closures::Surface& s) {
            closures::add_glossy(b, s, Color(1.0f), s.ng, {Distribution::Ggx, roughness}, {{1, 0, 0}, 0.0f, 0.0f});
          }};
      EXPECT_NEAR(albedo_table::ggx(c, sqr(roughness)), sampled_albedo(m, direction(c)), 0.012)
          << roughness << " " << c;
    }
}

TEST(AlbedoTable, means_are_cosine_weighted_and_correlated_masking_loses_less) {
  for (float alpha : {0.05f, 0.4f, 1.0f}) {
    double sum = 0.0;
    for (int i = 0; i < 200; ++i) sum += 2.0 * (i + 0.5) / 200 * albedo_table::ggx(float((i + 0.5) / 200), alpha) / 200;
    EXPECT_NEAR(albedo_table::ggx_mean(alpha), sum, 2e-3);
    EXPECT_GE(albedo_table::ggx_correlated_mean(alpha), albedo_table::ggx_mean(alpha) - 1e-4f);
    EXPECT_LE(albedo_table::ggx_correlated_mean(alpha), 1.0f + 1e-4f);
  }
}

TEST(AlbedoTable, smooth_glass_loses_nothing) {
  for (float eta : {1.0f / 1.5f, 1.2f, 2.0f})
    for (float c : {0.2f, 0.9f}) EXPECT_NEAR(albedo_table::ggx_glass(c, 1e-4f, eta), 1.0f, 2e-3f);
  EXPECT_LT(albedo_table::ggx_glass(0.5f, 1.0f, 1.5f), 0.9f);
  EXPECT_LT(albedo_table::ggx_glass_mean(1.0f, 1.0f / 1.5f), albedo_table::ggx_glass_mean(0.1f, 1.0f / 1.5f));
}

TEST(Sheen, albedo_fits_agree_with_the_lobes) {
  for (float c : {0.9f, 0.5f, 0.15f}) {
    const Vec3 wo = direction(c);
    double disney = 0.0;
    constexpr int kSide = 400;
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j) {
        const Vec3 wi = warp::square_to_cosine_hemisphere({(i + 0.5f) / kSide, (j + 0.5f) / kSide});
        disney += kPi * sheen::disney(glm::dot(wo, wi)) / (kSide * kSide);
      }
    EXPECT_NEAR(sheen::disney_albedo(c), disney, 2e-4);
  }
}

TEST(AlbedoTable, dielectric_layers_dim_what_is_below_as_in_cycles) {
  // Measured in Cycles 5.2.3: Principled of IOR 1.5 with single scattering in white light, with a grey base minus with a
  // black one. Seen 70, 40, 20 and 8 degrees above the surface.
  const std::array<float, 4> sines{0.9397f, 0.6428f, 0.3420f, 0.1392f};
  const std::array<std::pair<float, std::array<float, 4>>, 4> measured{{{0.1f, {0.0403f, 0.0581f, 0.1706f, 0.4574f}},
                                                                        {0.3f, {0.0406f, 0.0593f, 0.1575f, 0.3352f}},
                                                                        {0.6f, {0.0419f, 0.0567f, 0.0984f, 0.1452f}},
                                                                        {1.0f, {0.0419f, 0.0468f, 0.0587f, 0.0743f}}}};
  const float f0 = fresnel::f0_from_eta(1.5f);
  for (const auto& [roughness, albedos] : measured)
    for (size_t i = 0; i < sines.size(); ++i)
      for (const float eta : {1.5f, 1.0f / 1.5f})
        EXPECT_NEAR(glm::mix(f0, 1.0f, albedo_table::dielectric_position(sines[i], sqr(roughness), eta)), albedos[i],
                    0.003f)
            << roughness << " " << sines[i];
}

}  // namespace ajar::test_albedo_table
