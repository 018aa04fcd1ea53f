// A one-dimensional model of direct light: a "BSDF" and two "lights", one of which is half occluded.
#pragma once

#include <cmath>
#include <vector>

#include "math/random.h"
#include "sampling/control_variates.h"
#include "sampling/mixture.h"

namespace ajar::toy {

/// A density that is uniform over an interval of [0, 1), or that rises linearly over all of [0, 1).
struct Component {
  using State = float;
  float begin, end;
  bool linear = false;
  float sample(Vec2 u) const { return linear ? std::sqrt(u.x) : begin + (end - begin) * u.x; }
  float pdf(float x) const { return linear ? 2.0f * x : (x >= begin && x < end ? 1.0f / (end - begin) : 0.0f); }
};

/// A mixture over components of one type, each with `State sample(Vec2 u) const` and `float pdf(const State&) const`.
template <class Component>
class Mixture {
 public:
  using State = typename Component::State;

  explicit Mixture(std::vector<Component> components)
      : components_(std::move(components)), shares_(components_.size(), 1.0f / float(components_.size())) {}

  size_t size() const { return components_.size(); }
  std::span<const float> shares() const { return shares_; }
  void set_shares(std::vector<float> shares, float floor) {
    shares_ = std::move(shares);
    apply_floor(shares_, floor);
  }
  const Component& component(size_t k) const { return components_[k]; }

  float pdf(const State& x) const {
    float sum = 0.0f;
    for (size_t k = 0; k < size(); ++k) sum += shares_[k] * components_[k].pdf(x);
    return sum;
  }
  /// Draws n samples and calls visit(state, component) for each. `next_1d` and `next_2d` return random numbers.
  template <class Next1d, class Next2d, class Visit>
  void draw(int n, Next1d&& next_1d, Next2d&& next_2d, Visit&& visit) const {
    std::vector<int> counts(size());
    deterministic_counts(shares_, n, next_1d(), counts);
    for (size_t k = 0; k < size(); ++k) {
      for (int i = 0; i < counts[k]; ++i) visit(components_[k].sample(next_2d()), k);
    }
  }

 private:
  std::vector<Component> components_;
  std::vector<float> shares_;
};

inline Mixture<Component> mixture() { return Mixture<Component>({{0, 1, true}, {0.1f, 0.3f}, {0.6f, 0.7f}}); }

/// Emission times the "BSDF" 2x. The emission is 1 on the first light and `second` on the other, whose part [0.65, 0.7)
/// is occluded.
inline float integrand(float x, float second = 8.0f) {
  if (x >= 0.1f && x < 0.3f) return 2.0f * x;
  return x >= 0.6f && x < 0.65f ? second * 2.0f * x : 0.0f;
}
constexpr double integral(double second = 8.0) { return (0.09 - 0.01) + second * (0.65 * 0.65 - 0.36); }
constexpr double kIntegral = integral();

/// The estimate 1/n sum f / p. `sums` collects the weights for each component.
inline double plain_estimate(const Mixture<Component>& m, int n, Pcg32& rng, std::vector<double>* sums = nullptr,
                             float second = 8.0f) {
  double sum = 0.0;
  m.draw(
      n, [&] { return rng.next_float(); }, [&] { return Vec2(rng.next_float(), 0.5f); },
      [&](float x, size_t k) {
        const double w = double(integrand(x, second) / m.pdf(x));
        sum += w;
        if (sums) (*sums)[k] += w;
      });
  return sum / n;
}

/// The same samples with the ratios of densities. The channels have different scales, so that each needs its own
/// coefficients.
inline std::vector<ControlSample> control_samples(const Mixture<Component>& m, int n, Pcg32& rng) {
  std::vector<ControlSample> samples;
  m.draw(
      n, [&] { return rng.next_float(); }, [&] { return Vec2(rng.next_float(), 0.5f); },
      [&](float x, size_t) {
        ControlSample s{};
        const float p = m.pdf(x), f = integrand(x);
        s.y = Color(f, 0.5f * f, x < 0.5f ? f : 0.0f) / p;
        for (size_t j = 0; j < m.size(); ++j) s.z[j] = m.component(j).pdf(x) / p;
        samples.push_back(s);
      });
  return samples;
}

}  // namespace ajar::toy
