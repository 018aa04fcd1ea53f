#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "bsdf_fixtures.h"
#include "math/observer.h"
#include "shading/bsdf/thin_film.h"
#include "shading/models/fresnel.h"

namespace ajar::test_thin_film {

namespace {

/// The reflectance of a film on a dielectric at one wavelength, by the exact Airy formula (Born and Wolf, section 7.6),
/// integrated over the spectrum for each colour.
Color integrated(float thickness, float ior, float eta, float cosine) {
  using Complex = std::complex<double>;
  const double n[3] = {1.0, double(ior), double(eta)}, sine = std::sqrt(1.0 - double(cosine) * double(cosine));
  double c[3];
  for (int i = 0; i < 3; ++i) c[i] = std::sqrt(1.0 - sine * sine / (n[i] * n[i]));
  const auto s = [&](int a, int b) { return (n[a] * c[a] - n[b] * c[b]) / (n[a] * c[a] + n[b] * c[b]); };
  const auto p = [&](int a, int b) { return (n[b] * c[a] - n[a] * c[b]) / (n[b] * c[a] + n[a] * c[b]); };
  Color sum(0.0f), whole(0.0f);
  for (float wave = 380.0f; wave <= 780.0f; wave += 0.5f) {
    const Complex shift = std::polar(1.0, 4.0 * M_PI * n[1] * double(thickness) * c[1] / double(wave));
    const auto reflected = [&](double top, double bottom) {
      return std::norm((top + bottom * shift) / (1.0 + top * bottom * shift));
    };
    const float mean = float(0.5 * (reflected(s(0, 1), s(1, 2)) + reflected(p(0, 1), p(1, 2))));
    const Color matching = xyz_to_rgb(observer::xyz(wave));
    sum += matching * mean;
    whole += matching;
  }
  return sum / whole;
}

}  // namespace

TEST(ThinFilm, reflectance_is_the_airy_formula_integrated_over_the_spectrum) {
  for (const float thickness : {50.0f, 200.0f, 450.0f, 900.0f})
    for (const float ior : {1.3f, 1.8f})
      for (const float cosine : {1.0f, 0.7f, 0.3f}) {
        const Color found = thin_film::on_dielectric({thickness, ior}, cosine, 1.5f);
        const Color expected = integrated(thickness, ior, 1.5f, cosine);
        for (int i = 0; i < 3; ++i)
          EXPECT_NEAR(found[i], glm::clamp(expected[i], 0.0f, 1.0f), 2e-3f)
              << thickness << " nm, " << ior << ", " << cosine << ", colour " << i;
      }
}

TEST(ThinFilm, a_film_that_is_not_there_changes_nothing) {
  for (const float cosine : {1.0f, 0.5f, 0.1f}) {
    EXPECT_NEAR(thin_film::on_dielectric({1e-3f, 1.7f}, cosine, 1.5f).y, fresnel::dielectric(cosine, 1.5f), 1e-3f);
    const Color n(0.2f, 0.9f, 1.2f), k(3.0f, 2.5f, 2.0f);
    const Color with = thin_film::on_conductor({1e-3f, 1.7f}, cosine, n, k), bare = fresnel::conductor(cosine, n, k);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(with[i], bare[i], 2e-3f) << cosine;
  }
}

TEST(ThinFilm, light_is_reflected_completely_beyond_the_critical_angle) {
  EXPECT_EQ(thin_film::on_dielectric({300.0f, 1.2f}, 0.5f, 1.0f / 1.5f), Color(1.0f));
}

TEST(ThinFilm, before_blender_5_no_film_covers_the_metal_of_a_principled_bsdf) {
  const auto reflected = [](float thickness, bool film_on_metal) {
    const fixtures::Material metal = {"metal", [=](Bsdf& bsdf, const closures::Surface& surface) {
                                        closures::PrincipledInputs inputs;
                                        inputs.version = 2;
                                        inputs.metallic = 1.0f;
                                        inputs.normal = surface.ng;
                                        inputs.film = {thickness, 1.5f};
                                        inputs.film_on_metal = film_on_metal;
                                        closures::add_principled(bsdf, surface, Color(1.0f), inputs);
                                      }};
    const Vec3 wo = fixtures::direction(0.6f);
    return fixtures::make_bsdf(metal, wo).evaluate(wo, fixtures::direction(0.6f, 3.3f)).f_cos;
  };
  EXPECT_EQ(reflected(400.0f, false), reflected(0.0f, true));
  EXPECT_GT(glm::distance(reflected(400.0f, true), reflected(0.0f, true)), 0.02f);
}

}  // namespace ajar::test_thin_film
