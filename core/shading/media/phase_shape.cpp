#include "shading/media/phase_shape.h"

#include <algorithm>

namespace ajar {

namespace {

constexpr float kMinAnisotropy = 1e-3f;    ///< smaller ones count as 0: the inversion would cancel
constexpr double kMinSin2 = 4e-6;          ///< of half the angle; floats do not resolve directions below it
constexpr float kMaxBackscatter = 0.499f;  ///< 0.5 would scatter straight backwards
constexpr float kMinIor = 1.001f;

/// The root of an increasing function between `low` and `high`, by Newton's method. Steps that leave the bracket are
/// replaced by bisection. `function(x, slope)` returns the value and sets the slope.
template <class Function>
double root_of(double low, double high, double start, Function&& function) {
  double x = std::clamp(start, low, high);
  for (int i = 0; i < 60; ++i) {
    double slope = 0.0;
    const double value = function(x, slope);
    (value > 0.0 ? high : low) = x;
    double next = x - value / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - x) < 1e-8) return next;
    x = next;
  }
  return x;
}

/// The integral of Henyey-Greenstein times 1 + alpha cos^2 over cosines from -1 to c, without its constant factor. With
/// t^2 = 1 + g^2 - 2 g c, the integrand is (1 + alpha c^2) / t^2 dt / g.
double draine_integral(double c, double g, double alpha) {
  const double s = 1.0 + g * g;
  const auto at = [&](double t) {
    return 1.0 / t + alpha / (4.0 * g * g) * (s * s / t + 2.0 * s * t - t * t * t / 3.0);
  };
  return (at(std::sqrt(s - 2.0 * g * c)) - at(1.0 + g)) / g;
}

/// The parts of Fournier-Forand at x = sin^2 of half the angle.
struct FournierForand {
  double delta, power, missing, missing_power;
  FournierForand(double x, double scale, double v)
      : delta(scale * x), power(std::pow(delta, v)), missing(1.0 - delta), missing_power(1.0 - power) {}

  /// Near a delta of 1, both have a removable singularity: Taylor series of the first order.
  bool is_near_one() const { return std::abs(missing) < 1e-3; }
  /// 4 pi times the density, without the polar term.
  double density(double x, double v) const {
    if (is_near_one())
      return 0.5 * v * ((v - 1.0) - (v + 1.0) / x) +
             v * (v + 1.0) * missing * (2.0 * (v - 1.0) - (2.0 * v + 1.0) / x) / 6.0;
    return (v * missing - missing_power + (delta * missing_power - v * missing) / x) / (missing * missing * power);
  }
  /// The fraction of light that is scattered by less than the angle, without the polar term.
  double fraction(double x, double v) const {
    if (is_near_one()) return 1.0 + v * (1.0 - x) * (1.0 - 0.5 * (v + 1.0) * missing);
    return (1.0 - power * delta - missing_power * x) / (missing * power);
  }
};

double polar_density(double cosine) { return 0.25 * (3.0 * cosine * cosine - 1.0); }
double polar_fraction(double cosine) { return 0.125 * cosine * (1.0 - cosine * cosine); }

/// The fraction of light within the angle for which x = sin^2 of its half.
double fraction_within(double x, double scale, double v, double polar) {
  return FournierForand(x, scale, v).fraction(x, v) + polar * polar_fraction(1.0 - 2.0 * x);
}

}  // namespace

PhaseShape PhaseShape::draine(float anisotropy, float alpha) {
  PhaseShape shape;
  shape.a_ = std::abs(anisotropy) < kMinAnisotropy ? 0.0f : anisotropy;
  shape.b_ = alpha;
  shape.c_ = 3.0f / (3.0f + alpha * (1.0f + 2.0f * shape.a_ * shape.a_));
  return shape;
}

PhaseShape PhaseShape::fournier_forand(float backscatter, float ior) {
  const double b = std::min(std::abs(backscatter), kMaxBackscatter), n = std::max(ior, kMinIor);
  const double scale = 4.0 / (3.0 * (n - 1.0) * (n - 1.0));  // delta is scale * sin^2
  PhaseShape shape;
  shape.kind_ = Kind::FournierForand;
  shape.a_ = float(scale);
  // The slope for which the given fraction is scattered by more than 90 degrees. Where delta is 1 there, its limit.
  const double right = 0.5 * scale, log_right = std::log(right);
  shape.b_ = float(std::abs(log_right) < 1e-6 ? -2.0 * b : -std::log(2.0 * b * (right - 1.0) + 1.0) / log_right);
  const double v = shape.b_;
  shape.c_ = float(std::abs(scale - 1.0) < 1e-6 ? -v : (std::pow(scale, -v) - 1.0) / (scale - 1.0));
  return shape;
}

float PhaseShape::evaluate_fournier_forand(float cosine) const {
  const double x = 0.5 * (1.0 - std::clamp(double(cosine), -1.0, 1.0)), v = b_;
  // The density has no bound straight ahead. Within the smallest angle, it is constant.
  if (x <= kMinSin2) return float(0.25 * double(kInvPi) * fraction_within(kMinSin2, a_, v, c_) / kMinSin2);
  const double density = FournierForand(x, a_, v).density(x, v) + c_ * polar_density(cosine);
  return std::max(float(0.25 * double(kInvPi) * density), 0.0f);
}

float PhaseShape::sample(float u) const {
  if (kind_ == Kind::FournierForand) return sample_fournier_forand(u);
  if (b_ > 0.0f) return sample_draine(u);
  if (a_ == 0.0f) return 1.0f - 2.0f * u;
  const float k = (1.0f - a_ * a_) / (1.0f - a_ + 2.0f * a_ * u);
  return std::clamp((1.0f + a_ * a_ - k * k) / (2.0f * a_), -1.0f, 1.0f);
}

float PhaseShape::sample_draine(float u) const {
  const double g = a_, alpha = b_;
  if (a_ == 0.0f) {
    const double end = 1.0 + alpha / 3.0, wanted = (2.0 * double(u) - 1.0) * end;
    return float(root_of(-1.0, 1.0, wanted / end, [&](double c, double& slope) {
      slope = 1.0 + alpha * c * c;
      return c + alpha * c * c * c / 3.0 - wanted;
    }));
  }
  const double wanted = double(u) * draine_integral(1.0, g, alpha);
  // The start is a sample of Henyey-Greenstein.
  const double k = (1.0 - g * g) / (1.0 - g + 2.0 * g * double(u)), start = (1.0 + g * g - k * k) / (2.0 * g);
  return float(root_of(-1.0, 1.0, start, [&](double c, double& slope) {
    const double d = 1.0 + g * (g - 2.0 * c);
    slope = (1.0 + alpha * c * c) / (d * std::sqrt(d));
    return draine_integral(c, g, alpha) - wanted;
  }));
}

float PhaseShape::sample_fournier_forand(float u) const {
  const double scale = a_, v = b_, polar = c_, wanted = u;
  const double within = fraction_within(kMinSin2, scale, v, polar);
  if (wanted <= within) return float(1.0 - 2.0 * kMinSin2 * wanted / within);
  // In the logarithm of x, which is even for the forward peak.
  const double log_x = root_of(
      std::log(kMinSin2), 0.0, std::log(kMinSin2) * (1.0 - wanted), [&](double y, double& slope) {
        const double x = std::exp(y), cosine = 1.0 - 2.0 * x;
        slope = x * (FournierForand(x, scale, v).density(x, v) + polar * polar_density(cosine));
        return fraction_within(x, scale, v, polar) - wanted;
      });
  return float(1.0 - 2.0 * std::exp(log_x));
}

float PhaseShape::mean_cosine() const {
  if (kind_ == Kind::Draine) return a_ * (1.0f + b_ * (3.0f + 2.0f * a_ * a_) / 5.0f) * c_;
  // The mean over equal fractions of the light.
  constexpr int kParts = 8;
  float sum = 0.0f;
  for (int i = 0; i < kParts; ++i) sum += sample((float(i) + 0.5f) / kParts);
  return sum / kParts;
}

MieShapes mie_shapes(float diameter) {
  const float d = std::clamp(diameter, 0.0f, 50.0f), log_d = std::log(d);
  float g_hg, g_draine, alpha, share;
  if (d <= 0.1f) {
    g_hg = 13.8f * d * d;
    g_draine = 1.1456f * d * std::sin(9.29044f * d);
    alpha = 250.0f;
    share = 0.252977f - 312.983f * std::pow(d, 4.3f);
  } else if (d < 1.5f) {
    g_hg = 0.862f - 0.143f * log_d * log_d;
    const float a = (log_d - 0.238604f) * (log_d + 1.00667f), b = 0.507522f - 0.15677f * log_d;
    const float c = 1.19692f * std::cos(a / b) + 1.37932f * log_d + 0.0625835f;
    g_draine = 0.379685f * std::cos(c) + 0.344213f;
    alpha = 250.0f;
    share = 0.146209f * std::cos(3.38707f * log_d + 2.11193f) + 0.316072f + 0.0778917f * log_d;
  } else if (d < 5.0f) {
    const float log_log = std::log(log_d);
    g_hg = 0.0604931f * log_log + 0.940256f;
    g_draine = 0.500411f - 0.081287f / (-2.0f * log_d + std::tan(log_d) + 1.27551f);
    alpha = 7.30354f * log_d + 6.31675f;
    share = 0.026914f * (log_d - std::cos(5.68947f * (log_log - 0.0292149f))) + 0.3764f;
  } else {
    g_hg = std::exp(-0.0990567f / (d - 1.67154f));
    g_draine = std::exp(-2.20679f / (d + 3.91029f) - 0.428934f);
    alpha = std::exp(3.62489f - 8.29288f / (d + 5.52825f));
    share = std::exp(-0.599085f / (d - 0.641583f) - 0.665888f);
  }
  constexpr float kMost = 1.0f - 1e-3f;
  return {PhaseShape::henyey_greenstein(std::clamp(g_hg, -kMost, kMost)),
          PhaseShape::draine(std::clamp(g_draine, -kMost, kMost), alpha), saturate(share)};
}

}  // namespace ajar
