#include "shading/functions/gabor.h"

#include <algorithm>

#include "math/hash.h"

namespace ajar::nodes {
namespace {

constexpr int kImpulses = 8;  // of a cell

/// The random numbers of an impulse: `use` is 0 for its direction, 1 for its place, 2 for its sign.
struct ImpulseHash {
  int impulse;
  float word(int use) const { return float(3 * impulse + use); }

  float turn(Point<2> cell) const { return hash_unit(cell.x, cell.y, word(0)); }
  Vec2 turn(Point<3> cell) const { return Vec2(hash_color(Point<4>(cell, word(0)))); }
  Point<2> place(Point<2> cell) const {
    return {hash_unit(cell.x, cell.y, word(1)), hash_unit(word(1), cell.x, cell.y)};
  }
  Point<3> place(Point<3> cell) const { return hash_color(Point<4>(cell, word(1))); }
  float sign(Point<2> cell) const { return hash_unit(cell.x, cell.y, word(2)) < 0.5f ? -1.0f : 1.0f; }
  float sign(Point<3> cell) const { return hash_unit(cell.x, cell.y, cell.z, word(2)) < 0.5f ? -1.0f : 1.0f; }
};

/// The directions of waves: a base that random angles turn by up to half a turn, in proportion to the isotropy.
template <int N>
class Directions;

template <>
class Directions<2> {
 public:
  Directions(const GaborParameters& g, float isotropy) : angle_(g.angle), isotropy_(isotropy) {}
  Point<2> of(const ImpulseHash& hash, Point<2> cell) const {
    const float angle = angle_ + (hash.turn(cell) - 0.5f) * kPi * isotropy_;
    return {std::cos(angle), std::sin(angle)};
  }

 private:
  float angle_, isotropy_;
};

template <>
class Directions<3> {
 public:
  Directions(const GaborParameters& g, float isotropy) : isotropy_(isotropy) {
    const float length = glm::length(g.direction);
    if (length > 0.0f) base_ = g.direction / length;
    polar_ = {std::acos(std::clamp(base_.z, -1.0f, 1.0f)), std::atan2(base_.y, base_.x)};
  }
  Point<3> of(const ImpulseHash& hash, Point<3> cell) const {
    if (isotropy_ == 0.0f) return base_;
    const Vec2 polar = polar_ + hash.turn(cell) * kPi * isotropy_;
    return {std::sin(polar.x) * std::cos(polar.y), std::sin(polar.x) * std::sin(polar.y), std::cos(polar.x)};
  }

 private:
  Vec3 base_{0.0f};
  Vec2 polar_;  ///< angle from the z axis, azimuth
  float isotropy_;
};

/// Visits the cells up to `reach` away on every axis, x fastest.
template <int N, class F>
void for_each_cell(int reach, F&& visit) {
  int count = 1;
  for (int axis = 0; axis < N; ++axis) count *= 2 * reach + 1;
  for (int i = 0; i < count; ++i) {
    Point<N> offset;
    for (int axis = 0, rest = i; axis < N; ++axis, rest /= 2 * reach + 1)
      offset[axis] = float(rest % (2 * reach + 1) - reach);
    visit(offset);
  }
}

/// The sum of the impulses around a point, as complex numbers: waves under a Gaussian that ends smoothly at a distance
/// of 1.
template <int N>
Vec2 phasor(const GaborParameters& g, Point<N> p) {
  const Directions<N> directions(g, 1.0f - std::clamp(g.anisotropy, 0.0f, 1.0f));
  const float frequency = std::max(g.frequency, 0.001f);
  const Point<N> home = glm::floor(p), local = p - home;
  Vec2 sum(0.0f);
  for_each_cell<N>(1, [&](Point<N> offset) {
    const Point<N> cell = home + offset;
    for (int i = 0; i < kImpulses; ++i) {
      const ImpulseHash hash{i};
      const Point<N> d = local - offset - hash.place(cell);
      const float distance2 = glm::dot(d, d);
      if (distance2 >= 1.0f) continue;
      const float envelope = std::exp(-kPi * distance2) * (0.5f + 0.5f * std::cos(kPi * distance2));
      const float angle = 2.0f * kPi * frequency * glm::dot(d, directions.of(hash, cell));
      sum += hash.sign(cell) * envelope * Vec2(std::cos(angle), std::sin(angle));
    }
  });
  return sum;
}

}  // namespace

Vec3 gabor(const GaborParameters& g, Vec3 p) {
  const Vec2 sum = g.dimensions == 2 ? phasor(g, Point<2>(p)) : phasor(g, Point<3>(p));
  // Six standard deviations of the value: the variance of an impulse is half of the integral of its squared wave, which
  // is 2^(-1 - N / 2) for high frequencies.
  const float deviation = std::sqrt(kImpulses * 0.5f * (g.dimensions == 2 ? 0.25f : 0.17677669f));
  const float scale = 1.0f / (6.0f * deviation);
  return {0.5f + 0.5f * scale * sum.y, (std::atan2(sum.y, sum.x) + kPi) / (2.0f * kPi), scale * glm::length(sum)};
}

}  // namespace ajar::nodes
