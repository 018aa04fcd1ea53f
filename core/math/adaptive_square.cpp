#include "math/adaptive_square.h"

#include <algorithm>
#include <cmath>

#include "math/random.h"

namespace ajar {

namespace {

constexpr int kMaxDepth = 14;
constexpr double kMinPoints = 16.0;   // of a cell that is divided, in points of equal weight
constexpr double kPrior = 0.5;        // points added to each quarter
constexpr float kSpread = 0.2f;       // part of a point's weight that goes to its copy
constexpr float kNearest = 0x1p-12f;  // distances of copies
constexpr float kFarthest = 0.5f;

/// Moves the number into the half that it chooses, with the probability `low` of the lower one.
bool choose_upper(float& u, float low) {
  const bool upper = u >= low;
  u = upper ? (u - low) / (1.0f - low) : u / low;
  u = std::clamp(u, 0.0f, kOneMinusEpsilon);
  return upper;
}

}  // namespace

AdaptiveSquare::AdaptiveSquare(std::vector<Point> points) {
  std::erase_if(points, [](const Point& p) {
    return !(p.weight > 0.0f) || !std::isfinite(p.weight) || !(p.at.x >= 0.0f && p.at.x < 1.0f) ||
           !(p.at.y >= 0.0f && p.at.y < 1.0f);
  });
  if (points.empty()) return;
  const size_t count = points.size();
  points.reserve(2 * count);
  for (size_t i = 0; i < count; ++i) {
    Pcg32 rng(i, 0x636f7079U);
    const float distance = kNearest * std::pow(kFarthest / kNearest, rng.next_float());
    const float angle = 2.0f * kPi * rng.next_float();
    const Vec2 at = points[i].at + distance * Vec2(std::cos(angle), std::sin(angle));
    if (at.x < 0.0f || at.x >= 1.0f || at.y < 0.0f || at.y >= 1.0f) continue;
    points.push_back({at, kSpread * points[i].weight});
    points[i].weight *= 1.0f - kSpread;
  }
  divide(points.data(), points.data() + points.size(), 0);
}

/// Adds the node of these points, whose coordinates are those in its cell. They are sorted and changed.
uint32_t AdaptiveSquare::divide(Point* begin, Point* end, int depth) {
  const auto index = uint32_t(nodes_.size());
  nodes_.push_back({});
  Point* bounds[5] = {begin, nullptr, nullptr, nullptr, end};
  bounds[2] = std::stable_partition(begin, end, [](const Point& p) { return p.at.y < 0.5f; });
  const auto left = [](const Point& p) { return p.at.x < 0.5f; };
  bounds[1] = std::stable_partition(begin, bounds[2], left);
  bounds[3] = std::stable_partition(bounds[2], end, left);
  double weights[4] = {}, all = 0.0, squares = 0.0;
  for (int q = 0; q < 4; ++q) {
    for (Point* p = bounds[q]; p != bounds[q + 1]; ++p) {
      weights[q] += double(p->weight);
      squares += sqr(double(p->weight));
      p->at = glm::fract(2.0f * p->at);
    }
    all += weights[q];
  }
  // The number of points of equal weight that would be as reliable.
  const double count = sqr(all) / squares;
  for (int q = 0; q < 4; ++q) {
    nodes_[index].share[q] = float((weights[q] / all * count + kPrior) / (count + 4.0 * kPrior));
    if (count * weights[q] / all < kMinPoints || bounds[q + 1] - bounds[q] < 2 || depth + 1 >= kMaxDepth) continue;
    const uint32_t child = divide(bounds[q], bounds[q + 1], depth + 1);
    nodes_[index].child[q] = child;
  }
  return index;
}

Vec2 AdaptiveSquare::sample(Vec2 u) const {
  Vec2 corner(0.0f);
  float size = 1.0f;
  for (uint32_t index = 0;;) {
    const Node& node = nodes_[index];
    const float below = node.share[0] + node.share[1], above = node.share[2] + node.share[3];
    const int y = choose_upper(u.y, below / (below + above));
    const float left = node.share[2 * y], right = node.share[2 * y + 1];
    const int x = choose_upper(u.x, left / (left + right));
    size *= 0.5f;
    corner += size * Vec2(float(x), float(y));
    index = node.child[2 * y + x];
    if (index == 0) return glm::min(corner + size * u, Vec2(kOneMinusEpsilon));
  }
}

float AdaptiveSquare::density(Vec2 at) const {
  if (!(at.x >= 0.0f && at.x < 1.0f) || !(at.y >= 0.0f && at.y < 1.0f)) return 0.0f;
  float density = 1.0f;
  for (uint32_t index = 0;;) {
    const Node& node = nodes_[index];
    const int quarter = (at.y >= 0.5f ? 2 : 0) + (at.x >= 0.5f ? 1 : 0);
    density *= 4.0f * node.share[quarter];
    index = node.child[quarter];
    if (index == 0) return density;
    at = glm::fract(2.0f * at);
  }
}

}  // namespace ajar
