// Hypothesis tests for sampling functions: does `sample` draw from `pdf`? A density is defined on a domain. An
// equal-area map from the unit square parametrizes the domain, so that a pdf value times `domain_measure` is a density
// over the square. Points of all domains are Vec3 (z = 0 on the square and the disk). `sample` draws its random numbers
// from a Pcg32 (`from_square` converts a map of the square). It may refuse (std::nullopt); the refused fraction must
// then be the mass that is missing from the integral of the pdf.
//
// * chi_square_agrees: Pearson's test on bins that follow a pilot set of samples,
//   so that a peak of 1e-4 rad gets as many bins as a uniform density. Expected
//   counts are integrated adaptively. Bins of small expectation are merged: below
//   about five the chi-square distribution is no longer that of the statistic.
// * integral_agrees: the integral of the pdf is the stated mass.
// * jacobian_agrees: 1 / |det| of the sampling map equals the pdf, by central differences [lajolla's test]. It needs no
// bins and works in the tails.
// * means_agree (Welch) and mean_agrees (one sample): t-tests.
// A test that is repeated `test_count` times at `significance` uses Šidák's threshold 1 - (1 - significance)^(1 /
// test_count), so that the whole family raises a false alarm with probability `significance`. Seeds are fixed, so that
// results do not change from run to run.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <vector>

#include "math/random.h"
#include "math/statistics.h"
#include "math/types.h"

namespace ajar::statistical {

// ---- Distribution functions -------------------------------------------------------

inline double sidak_threshold(double significance, int test_count) {
  return -std::expm1(std::log1p(-significance) / std::max(1, test_count));
}

/// Probability that a chi-square variable exceeds `statistic`.
double chi_square_p_value(double statistic, double degrees_of_freedom);
/// Probability that |T| of Student's distribution exceeds |t|.
double student_p_value(double t, double degrees_of_freedom);

// ---- t-tests -----------------------------------------------------------------------

struct Significance {
  double significance = 0.01;  ///< probability of a false alarm in the whole family of tests
  int test_count = 1;          ///< size of that family
  double threshold() const { return sidak_threshold(significance, test_count); }
};

/// Welch's test: two sets of samples with unknown and different variances have the same mean.
inline testing::AssertionResult means_agree(const RunningMoments& a, const RunningMoments& b, Significance level = {}) {
  const double va = a.variance_of_mean(), vb = b.variance_of_mean(), v = va + vb;
  if (v == 0.0) {
    if (a.mean() == b.mean()) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "means " << a.mean() << " and " << b.mean() << " without any variance";
  }
  const double t = (a.mean() - b.mean()) / std::sqrt(v);
  const double dof = v * v /
                     (va * va / std::max(1.0, double(a.count()) - 1.0) +
                      vb * vb / std::max(1.0, double(b.count()) - 1.0));
  const double p = student_p_value(t, dof);
  if (p >= level.threshold()) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "means " << a.mean() << " and " << b.mean() << " differ: t = " << t
                                     << ", p = " << p << " below " << level.threshold();
}

/// One-sample test: the samples have the mean `expected`. `relative_slack` is the allowed relative error of `expected`
/// itself (floats, a truncated integral).
inline testing::AssertionResult mean_agrees(const RunningMoments& a, double expected, Significance level = {},
                                            double relative_slack = 1e-5) {
  const double difference = std::max(0.0, std::abs(a.mean() - expected) - relative_slack * std::abs(expected));
  if (difference == 0.0) return testing::AssertionSuccess();
  const double error = std::sqrt(a.variance_of_mean());
  const double p = error > 0.0 ? student_p_value(difference / error, double(a.count()) - 1.0) : 0.0;
  if (p >= level.threshold()) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "mean " << a.mean() << " +- " << error << " instead of " << expected
                                     << ": p = " << p << " below " << level.threshold();
}

// ---- Domains -----------------------------------------------------------------------

enum class SampleDomain { Square, Disk, Hemisphere, Sphere };

inline double domain_measure(SampleDomain domain) {
  switch (domain) {
    case SampleDomain::Disk: return kPi;
    case SampleDomain::Hemisphere: return 2.0 * kPi;
    case SampleDomain::Sphere: return 4.0 * kPi;
    default: return 1.0;
  }
}
/// Equal-area map of the unit square onto the domain: polar coordinates with the angle along v.
inline Vec3 domain_point(SampleDomain domain, double u, double v) {
  if (domain == SampleDomain::Square) return {float(u), float(v), 0.0f};
  const double phi = 2.0 * M_PI * v;
  const double z = domain == SampleDomain::Sphere ? 1.0 - 2.0 * u : 1.0 - u;  // the pole +z is at u = 0
  const double r = domain == SampleDomain::Disk ? std::sqrt(u) : std::sqrt(std::max(0.0, (1.0 - z) * (1.0 + z)));
  return {float(r * std::cos(phi)), float(r * std::sin(phi)), domain == SampleDomain::Disk ? 0.0f : float(z)};
}
inline std::array<double, 2> domain_square(SampleDomain domain, Vec3 p) {
  if (domain == SampleDomain::Square) return {p.x, p.y};
  const double r2 = double(p.x) * p.x + double(p.y) * p.y;
  double v = std::atan2(double(p.y), double(p.x)) / (2.0 * M_PI);
  if (v < 0.0) v += 1.0;
  if (domain == SampleDomain::Disk) return {std::min(1.0, r2), v};
  // 1 - z without cancellation near the pole.
  const double one_minus_z = p.z > 0.0f ? r2 / (1.0 + p.z) : 1.0 - p.z;
  return {std::min(1.0, domain == SampleDomain::Sphere ? 0.5 * one_minus_z : one_minus_z), v};
}

using Sample = std::function<std::optional<Vec3>(Pcg32&)>;
using Density = std::function<double(Vec3)>;
using Map = std::function<std::optional<Vec3>(Vec2)>;

inline Sample from_square(Map map) {
  return [map = std::move(map)](Pcg32& rng) {
    const float x = rng.next_float();
    return map(Vec2(x, rng.next_float()));
  };
}

struct DensityTest {
  SampleDomain domain = SampleDomain::Sphere;
  int sample_count = 100000;
  int bin_count = 256;               ///< before merging
  double minimum_expected = 5.0;     ///< bins with a smaller expected count are merged
  double integral_tolerance = 3e-3;  ///< absolute, of the numerical integral
  double outside_fraction = 1e-4;    ///< allowed fraction of samples where the pdf is 0 (rounding at an edge)
  Significance level{};
  uint64_t seed = 1;
};

namespace detail {

struct Cell {
  double u0, v0, u1, v1;
};
using SquarePoint = std::array<double, 2>;

/// Integral of the density over cells of the square. A cell is halved at the median of its pilot samples until it has
/// few of them. It is then cut into strips that become wider with the distance from the bounding box of the samples, so
/// that no small peak is missed. Each piece is refined until Simpson's 3x3 rule agrees with that of its quarters.
class Integrator {
 public:
  Integrator(const Density& pdf, SampleDomain domain, double tolerance)
      : pdf_(pdf), domain_(domain), tolerance_(tolerance) {}

  double integrate(const Cell& cell, SquarePoint* first, SquarePoint* last, int axis = 0) const {
    if (last - first > 8) {
      SquarePoint* middle = first + (last - first) / 2;
      std::nth_element(first, middle, last,
                       [=](const SquarePoint& p, const SquarePoint& q) { return p[axis] < q[axis]; });
      Cell a = cell, b = cell;
      (axis == 0 ? a.u1 : a.v1) = (axis == 0 ? b.u0 : b.v0) = (*middle)[axis];
      return integrate(a, first, middle, 1 - axis) + integrate(b, middle, last, 1 - axis);
    }
    const auto us = graded(cell.u0, cell.u1, first, last, 0), vs = graded(cell.v0, cell.v1, first, last, 1);
    double sum = 0.0;
    for (size_t i = 0; i + 1 < us.size(); ++i)
      for (size_t j = 0; j + 1 < vs.size(); ++j) {
        const Cell piece{us[i], vs[j], us[i + 1], vs[j + 1]};
        sum += refine(piece, rule(piece), tolerance_, 0);
      }
    return sum;
  }

 private:
  /// Cuts of [low, high] along `axis`. The steps double with the distance from the range of the samples. A gap that
  /// divides the samples in two gets such steps as well, since the tails of two peaks may share a cell.
  static std::vector<double> graded(double low, double high, const SquarePoint* first, const SquarePoint* last,
                                    int axis) {
    if (first == last) return {low, 0.5 * (low + high), high};
    std::vector<double> at;
    for (const SquarePoint* p = first; p != last; ++p) at.push_back((*p)[axis]);
    std::sort(at.begin(), at.end());
    const double a = at.front(), b = at.back();
    std::vector<double> cuts{low, a, 0.5 * (a + b), b, high};
    const auto cut_away = [&](double from, double until, double step) {
      for (double x = from + step; step > 0.0 ? x < until : x > until; x += step *= 2.0) cuts.push_back(x);
    };
    const double step = b > a ? 0.25 * (b - a) : 1e-3 * (high - low);
    cut_away(a, low, -step);
    cut_away(b, high, step);
    size_t widest = 1;
    for (size_t i = 2; i < at.size(); ++i)
      if (at[i] - at[i - 1] > at[widest] - at[widest - 1]) widest = i;
    if (at.size() > 2 && at[widest] - at[widest - 1] > 0.5 * (b - a)) {
      const double left = at[widest - 1], right = at[widest], least = 1e-3 * (right - left),
                   middle = 0.5 * (left + right);
      cut_away(left, middle, std::max(0.25 * (left - a), least));
      cut_away(right, middle, -std::max(0.25 * (b - right), least));
      cuts.insert(cuts.end(), {left, right});
    }
    std::sort(cuts.begin(), cuts.end());
    cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
    return cuts;
  }
  double rule(const Cell& c) const {
    // Simpson's rule with end points slightly inside the cell: a jump next to an edge counts, a jump on the edge does
    // not.
    constexpr double a = 1.0 - 2e-4, x[3] = {0.5 - 0.5 * a, 0.5, 0.5 + 0.5 * a};
    constexpr double w[3] = {1.0 / (6.0 * a * a), 1.0 - 1.0 / (3.0 * a * a), 1.0 / (6.0 * a * a)};
    double sum = 0.0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        sum += w[i] * w[j] * density(c.u0 + x[i] * (c.u1 - c.u0), c.v0 + x[j] * (c.v1 - c.v0));
    return sum * (c.u1 - c.u0) * (c.v1 - c.v0);
  }
  double density(double u, double v) const { return pdf_(domain_point(domain_, u, v)) * domain_measure(domain_); }
  double refine(const Cell& c, double whole, double tolerance, int depth) const {
    const double u = 0.5 * (c.u0 + c.u1), v = 0.5 * (c.v0 + c.v1);
    const Cell quarters[4] = {{c.u0, c.v0, u, v}, {u, c.v0, c.u1, v}, {c.u0, v, u, c.v1}, {u, v, c.u1, c.v1}};
    double parts[4], sum = 0.0;
    for (int i = 0; i < 4; ++i) sum += parts[i] = rule(quarters[i]);
    if (depth >= 7 || std::abs(sum - whole) <= tolerance) return sum;
    sum = 0.0;
    for (int i = 0; i < 4; ++i) sum += refine(quarters[i], parts[i], 0.5 * tolerance, depth + 1);
    return sum;
  }

  const Density& pdf_;
  SampleDomain domain_;
  double tolerance_;
};

struct Bin {
  Cell cell;
  int first, last;  // range of the pilot samples
};

/// Halves the pilot samples at their median until there are `count` bins. The bins cover the square without overlap.
inline void make_bins(std::vector<SquarePoint>& points, const Bin& bin, int count, int axis, std::vector<Bin>& bins) {
  if (count <= 1 || bin.last - bin.first < 2) {
    bins.push_back(bin);
    return;
  }
  const int middle = (bin.first + bin.last) / 2;
  std::nth_element(points.begin() + bin.first, points.begin() + middle, points.begin() + bin.last,
                   [axis](const SquarePoint& a, const SquarePoint& b) { return a[axis] < b[axis]; });
  const double split = points[middle][axis];
  Bin a{bin.cell, bin.first, middle}, b{bin.cell, middle, bin.last};
  (axis == 0 ? a.cell.u1 : a.cell.v1) = split;
  (axis == 0 ? b.cell.u0 : b.cell.v0) = split;
  make_bins(points, a, count / 2, 1 - axis, bins);
  make_bins(points, b, count - count / 2, 1 - axis, bins);
}

inline bool contains(const Cell& c, const SquarePoint& p) {
  // The last cell of the square is closed.
  return p[0] >= c.u0 && (p[0] < c.u1 || c.u1 == 1.0) && p[1] >= c.v0 && (p[1] < c.v1 || c.v1 == 1.0);
}

struct Tally {
  std::vector<double> expected, observed;
  double integral = 0.0;
  int outside = 0;  // samples whose pdf is <= 0 or not finite
  std::string complaint;
};

inline Tally tally(const Sample& sample, const Density& pdf, const DensityTest& test) {
  Tally out;
  std::vector<SquarePoint> pilot;
  Pcg32 pilot_rng(test.seed, 1);
  for (int i = 0; i < test.bin_count * 32; ++i)
    if (const auto p = sample(pilot_rng)) pilot.push_back(domain_square(test.domain, *p));
  std::vector<Bin> bins;
  make_bins(pilot, Bin{{0.0, 0.0, 1.0, 1.0}, 0, int(pilot.size())}, test.bin_count, 0, bins);

  const Integrator integrator(pdf, test.domain, 0.1 * test.integral_tolerance / test.bin_count);
  out.expected.assign(bins.size() + 1, 0.0);
  out.observed.assign(bins.size() + 1, 0.0);
  for (size_t i = 0; i < bins.size(); ++i) {
    const double mass = integrator.integrate(bins[i].cell, pilot.data() + bins[i].first, pilot.data() + bins[i].last);
    out.expected[i] = mass * test.sample_count;
    out.integral += mass;
  }
  out.expected.back() = std::max(0.0, 1.0 - out.integral) * test.sample_count;  // refused samples

  Pcg32 rng(test.seed, 2);
  for (int i = 0; i < test.sample_count; ++i) {
    const auto p = sample(rng);
    if (!p) {
      out.observed.back() += 1.0;
      continue;
    }
    const double density = pdf(*p);
    if (!(density > 0.0) || !std::isfinite(density)) ++out.outside;
    const SquarePoint q = domain_square(test.domain, *p);
    const auto bin = std::find_if(bins.begin(), bins.end(), [&](const Bin& b) { return contains(b.cell, q); });
    if (bin == bins.end()) {
      out.complaint = "a sample lies outside the domain";
      return out;
    }
    out.observed[size_t(bin - bins.begin())] += 1.0;
  }
  return out;
}

}  // namespace detail

/// The samples follow the pdf, and the integral of the pdf is the fraction of samples that are not refused.
inline testing::AssertionResult chi_square_agrees(const Sample& sample, const Density& pdf, const DensityTest& test) {
  detail::Tally tally = detail::tally(sample, pdf, test);
  if (!tally.complaint.empty()) return testing::AssertionFailure() << tally.complaint << " (seed " << test.seed << ")";
  if (!(tally.integral <= 1.0 + test.integral_tolerance))
    return testing::AssertionFailure() << "the pdf integrates to " << tally.integral << " (seed " << test.seed << ")";
  if (tally.outside > test.outside_fraction * test.sample_count)
    return testing::AssertionFailure() << tally.outside << " of " << test.sample_count
                                       << " samples have no density (seed " << test.seed << ")";
  // The expected count of refused samples contains the error of the integral, so it is compared separately.
  const double refused = tally.observed.back() / test.sample_count, missing = 1.0 - tally.integral;
  if (std::abs(refused - missing) >
      test.integral_tolerance + 5.0 * std::sqrt(refused * (1.0 - refused) / test.sample_count))
    return testing::AssertionFailure() << "the pdf integrates to " << tally.integral << " but " << refused
                                       << " of the samples are refused (seed " << test.seed << ")";
  tally.expected.pop_back();
  tally.observed.pop_back();
  // Given the number of accepted samples, the counts of the bins are multinomial.
  const double accepted = std::accumulate(tally.observed.begin(), tally.observed.end(), 0.0);
  const double scale = tally.integral > 0.0 ? accepted / (tally.integral * test.sample_count) : 0.0;
  std::vector<size_t> order(tally.expected.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return tally.expected[a] < tally.expected[b]; });
  double statistic = 0.0, expected = 0.0, observed = 0.0;
  int used = 0;
  for (size_t k = 0; k < order.size(); ++k) {
    expected += tally.expected[order[k]] * scale;
    observed += tally.observed[order[k]];
    if (expected < test.minimum_expected && k + 1 < order.size()) continue;
    if (expected > 0.0) {
      statistic += (observed - expected) * (observed - expected) / expected;
      ++used;
    }
    expected = observed = 0.0;
  }
  if (used < 2) return testing::AssertionFailure() << "only " << used << " bins have enough samples";
  const double p = chi_square_p_value(statistic, used - 1);
  if (p >= test.level.threshold()) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "chi-square " << statistic << " with " << used - 1
                                     << " degrees of freedom, p = " << p << " below " << test.level.threshold()
                                     << ", integral " << tally.integral << " (seed " << test.seed << ")";
}

/// The pdf integrates to `mass`. `sample` is used only to find where the density is large.
inline testing::AssertionResult integral_agrees(const Sample& sample, const Density& pdf, double mass,
                                                const DensityTest& test) {
  DensityTest short_test = test;
  short_test.sample_count = 0;
  const double integral = detail::tally(sample, pdf, short_test).integral;
  if (std::abs(integral - mass) <= test.integral_tolerance) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "the pdf integrates to " << integral << " instead of " << mass;
}

struct JacobianTest {
  int grid = 24;                 ///< grid x grid points of the square, jittered
  double step = 1.0 / 512.0;     ///< step of the central difference; larger for narrow peaks in floats
  double tolerance = 0.02;       ///< relative
  double smooth_fraction = 0.7;  ///< minimum fraction of the points at which the map is smooth
  uint64_t seed = 1;
};

/// |d map / du x d map / dv| * pdf(map(u)) = 1 wherever the map is smooth, that is where the one-sided determinants on
/// the four sides agree. This holds for surfaces in space and therefore for all domains.
inline testing::AssertionResult jacobian_agrees(const Map& map, const Density& pdf, const JacobianTest& test = {}) {
  Pcg32 rng(test.seed, 3);
  int smooth = 0;
  for (int i = 0; i < test.grid * test.grid; ++i) {
    const double margin = 2.0 * test.step;
    const double u = margin + (1.0 - 2.0 * margin) * (i % test.grid + rng.next_float()) / test.grid;
    const double v = margin + (1.0 - 2.0 * margin) * (i / test.grid + rng.next_float()) / test.grid;
    const auto at = [&](double du, double dv) {
      return map(Vec2(float(u + du * test.step), float(v + dv * test.step)));
    };
    const auto c = at(0, 0), u0 = at(-1, 0), u1 = at(1, 0), v0 = at(0, -1), v1 = at(0, 1);
    if (!c || !u0 || !u1 || !v0 || !v1) continue;
    const auto determinant = [&](glm::dvec3 du, glm::dvec3 dv) {
      return glm::length(glm::cross(du, dv)) / (test.step * test.step);
    };
    const glm::dvec3 dc(*c), du0 = dc - glm::dvec3(*u0), du1 = glm::dvec3(*u1) - dc, dv0 = dc - glm::dvec3(*v0),
                             dv1 = glm::dvec3(*v1) - dc;
    const double sides[4] = {determinant(du0, dv0), determinant(du0, dv1), determinant(du1, dv0),
                             determinant(du1, dv1)};
    const auto [low, high] = std::minmax_element(sides, sides + 4);
    if (*high > *low * (1.0 + 1.5 * test.tolerance)) continue;
    ++smooth;
    const double expected = 1.0 / determinant(0.5 * (du0 + du1), 0.5 * (dv0 + dv1)), density = pdf(*c);
    if (!(std::abs(density / expected - 1.0) <= test.tolerance))
      return testing::AssertionFailure() << "pdf " << density << " where 1 / |det| is " << expected << " at u = (" << u
                                         << ", " << v << ")";
  }
  if (smooth < test.smooth_fraction * test.grid * test.grid)
    return testing::AssertionFailure() << "the map is smooth at only " << smooth << " of " << test.grid * test.grid
                                       << " points";
  return testing::AssertionSuccess();
}

}  // namespace ajar::statistical
