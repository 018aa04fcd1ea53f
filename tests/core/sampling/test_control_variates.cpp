#include <gtest/gtest.h>

#include "sampling/control_variates.h"
#include "statistical.h"
#include "toy_mixture.h"

namespace ajar::test_control_variates {

namespace {

constexpr double kMeans[3] = {toy::kIntegral, 0.5 * toy::kIntegral, 0.08};

toy::Mixture<toy::Component> half_bsdf() {
  auto m = toy::mixture();
  m.set_shares({0.5f, 0.25f, 0.25f}, 0.01f);
  return m;
}

/// Moments of many independent estimates, for each channel.
template <class Estimate>
std::array<RunningMoments, 3> replicate(int replicates, Estimate&& estimate) {
  std::array<RunningMoments, 3> moments;
  for (int r = 0; r < replicates; ++r) {
    Pcg32 rng(23, uint64_t(r));
    const Color e = estimate(rng);
    for (int c = 0; c < 3; ++c) moments[size_t(c)].add(double(e[c]));
  }
  return moments;
}

Color cross_fitted(const toy::Mixture<toy::Component>& m, int n, Pcg32& rng) {
  const auto a = toy::control_samples(m, n / 2, rng), b = toy::control_samples(m, n - n / 2, rng);
  return ocv_cross_fitted(a, b, int(m.size()));
}

}  // namespace

class TinyBudget : public ::testing::TestWithParam<int> {};

TEST_P(TinyBudget, cross_fitting_is_unbiased) {
  const auto m = half_bsdf();
  const auto moments = replicate(40000, [&](Pcg32& rng) { return cross_fitted(m, GetParam(), rng); });
  for (size_t c = 0; c < 3; ++c)
    EXPECT_TRUE(statistical::mean_agrees(moments[c], kMeans[c], {0.001, 15})) << "channel " << c;
}
INSTANTIATE_TEST_SUITE_P(Samples, TinyBudget, ::testing::Values(4, 8, 12, 16, 25));

TEST(ControlVariates, coefficients_of_earlier_iterations_are_unbiased) {
  const auto m = half_bsdf();
  const auto moments = replicate(20000, [&](Pcg32& rng) {
    NormalEquations past(int(m.size()));
    Color sum(0.0f);
    for (int iteration = 0; iteration < 6; ++iteration) {
      const auto samples = toy::control_samples(m, 2, rng);
      sum += control_estimate(samples, past.fit(kRidgeMany, 6)) / 6.0f;
      for (const ControlSample& s : samples) past.add(s);
    }
    return sum;
  });
  for (size_t c = 0; c < 3; ++c)
    EXPECT_TRUE(statistical::mean_agrees(moments[c], kMeans[c], {0.0003})) << "channel " << c;
}

TEST(ControlVariates, the_test_detects_the_bias_of_the_published_estimator) {
  const auto m = half_bsdf();
  const auto moments = replicate(
      20000, [&](Pcg32& rng) { return ocv_paper(toy::control_samples(m, 16, rng), int(m.size())); });
  const double error = moments[0].mean() - toy::kIntegral;
  EXPECT_GT(std::abs(error), 5.0 * std::sqrt(moments[0].variance_of_mean()));
  EXPECT_FALSE(statistical::mean_agrees(moments[0], toy::kIntegral, {0.001}));
}

TEST(ControlVariates, fitting_on_the_corrected_samples_is_biased_even_without_a_ridge_on_the_intercept) {
  const auto m = half_bsdf();
  const auto moments = replicate(40000, [&](Pcg32& rng) {
    const auto samples = toy::control_samples(m, 8, rng);
    NormalEquations own(int(m.size()));
    for (const ControlSample& s : samples) own.add(s);
    return control_estimate(samples, own.fit(1e-6, 4));
  });
  EXPECT_FALSE(statistical::mean_agrees(moments[0], toy::kIntegral, {0.001}));
}

TEST(ControlVariates, the_bias_of_the_published_estimator_falls_with_the_number_of_samples) {
  const auto m = half_bsdf();
  const auto bias = [&](int n) {
    const auto moments = replicate(
        20000, [&](Pcg32& rng) { return ocv_paper(toy::control_samples(m, n, rng), int(m.size())); });
    return std::abs(moments[0].mean() / toy::kIntegral - 1.0);
  };
  EXPECT_LT(bias(128), 0.5 * bias(16));
}

TEST(ControlVariates, an_integrand_in_the_span_of_the_components_is_integrated_without_variance) {
  const auto m = half_bsdf();
  NormalEquations past(3);
  Pcg32 rng(1);
  const auto linear = [&](int n) {
    auto samples = toy::control_samples(m, n, rng);
    for (ControlSample& s : samples) s.y = Color(3.0f * s.z[0] + 0.5f * s.z[1] + 7.0f * s.z[2]);
    return samples;
  };
  for (const ControlSample& s : linear(400)) past.add(s);
  const ControlCoefficients beta = past.fit(0.0, 6);
  for (int i = 0; i < 100; ++i) EXPECT_NEAR(control_estimate(linear(4), beta).x, 10.5f, 1e-3f);
}

TEST(ControlVariates, well_fitted_coefficients_have_less_variance_than_the_plain_mixture) {
  const auto m = half_bsdf();
  NormalEquations past(3);
  Pcg32 learning(99);
  for (const ControlSample& s : toy::control_samples(m, 4000, learning)) past.add(s);
  const ControlCoefficients beta = past.fit(kRidgeMany, 6);
  ASSERT_EQ(beta.count, 3);
  const auto plain = replicate(20000,
                               [&](Pcg32& rng) { return control_estimate(toy::control_samples(m, 16, rng), {}); });
  const auto optimal = replicate(20000,
                                 [&](Pcg32& rng) { return control_estimate(toy::control_samples(m, 16, rng), beta); });
  const auto folds = replicate(20000, [&](Pcg32& rng) { return cross_fitted(m, 64, rng); });
  const auto plain64 = replicate(20000,
                                 [&](Pcg32& rng) { return control_estimate(toy::control_samples(m, 64, rng), {}); });
  EXPECT_LT(optimal[0].variance(), 0.9 * plain[0].variance());
  EXPECT_LT(folds[0].variance(), 0.95 * plain64[0].variance());
}

TEST(ControlVariates, degenerate_systems_fall_back_to_the_plain_mixture) {
  // Samples without variation, two identical columns, and samples of value zero.
  NormalEquations constant(3), twins(3), dark(3);
  Pcg32 rng(3);
  for (int i = 0; i < 64; ++i) {
    constant.add({Color(1.0f), {1.0f, 1.0f, 1.0f}});
    const float z = rng.next_float(), noise = rng.next_float();
    twins.add({Color(z + 0.1f * noise), {z, z, 2.0f - 2.0f * z}});
    dark.add({Color(0.0f), {z, noise, 1.0f}});
  }
  EXPECT_EQ(constant.fit(kRidgeFew, 6).count, 0);
  EXPECT_EQ(dark.fit(kRidgeFew, 6).count, 0);
  // The ridge divides the coefficient between identical columns. Without a ridge there is no unique solution.
  const ControlCoefficients shared = twins.fit(kRidgeMany, 6);
  ASSERT_EQ(shared.count, 3);
  EXPECT_NEAR(shared.beta[0].x, 0.5f, 0.05f);
  EXPECT_NEAR(shared.beta[1].x, 0.5f, 0.05f);
  EXPECT_EQ(twins.fit(0.0, 6).count, 0);
}

/// For nearly identical components and integrands of any scale, the fit returns no coefficients or coefficients that do
/// not increase the variance of other samples.
TEST(ControlVariates, nearly_singular_systems_do_not_increase_the_variance) {
  constexpr int kComponents = 8;
  for (const float apart : {0.0f, 1e-7f, 1e-5f, 1e-3f, 0.1f}) {
    for (const float scale : {1e-18f, 1.0f, 1e15f}) {
      const auto draw = [&](int n, Pcg32& rng) {
        std::vector<ControlSample> samples(static_cast<size_t>(n));
        for (ControlSample& s : samples) {
          const float shared = 2.0f * rng.next_float();
          float sum = 0.0f;
          for (int j = 0; j + 1 < kComponents; ++j) sum += s.z[j] = shared + apart * (rng.next_float() - 0.5f);
          s.z[kComponents - 1] = float(kComponents) - sum;  // the mean is 1, as for equal shares
          s.y = Color(scale * shared * (0.5f + rng.next_float()), scale * rng.next_float(), 0.0f);
        }
        return samples;
      };
      Pcg32 rng(11);
      NormalEquations past(kComponents);
      for (const ControlSample& s : draw(64, rng)) past.add(s);
      for (const double ridge : {0.0, kRidgeMany, kRidgeFew}) {
        const ControlCoefficients beta = past.fit(ridge, 16);
        RunningMoments plain, corrected;
        for (int i = 0; i < 500; ++i) {
          const auto samples = draw(16, rng);
          plain.add(double(control_estimate(samples, {}).x / scale));
          corrected.add(double(control_estimate(samples, beta).x / scale));
        }
        ASSERT_TRUE(std::isfinite(corrected.variance())) << apart << " " << scale << " " << ridge;
        EXPECT_LT(corrected.variance(), 1.1 * plain.variance()) << apart << " " << scale << " " << ridge;
        EXPECT_TRUE(statistical::means_agree(corrected, plain, {0.0001})) << apart << " " << scale << " " << ridge;
      }
    }
  }
}

TEST(ControlVariates, normal_equations_can_be_merged) {
  const auto m = half_bsdf();
  Pcg32 rng(17);
  NormalEquations whole(3), first(3), second(3);
  for (int i = 0; i < 40; ++i) {
    for (const ControlSample& s : toy::control_samples(m, 4, rng)) {
      whole.add(s);
      (i % 2 ? first : second).add(s);
    }
  }
  first.merge(second);
  const auto a = whole.fit(kRidgeMany, 6), b = first.fit(kRidgeMany, 6);
  for (int j = 0; j < 3; ++j) EXPECT_NEAR(a.beta[j].x, b.beta[j].x, 1e-5f);
}

}  // namespace ajar::test_control_variates
