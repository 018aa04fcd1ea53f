#include "shading/functions/voronoi.h"

#include <algorithm>
#include <cmath>

#include "math/hash.h"

namespace ajar::nodes {
namespace {

/// Distance of a random point from the looked up one; its square for the Euclidean metric.
template <int N>
float comparable(const VoronoiParameters& v, const float (&d)[N]) {
  float sum = 0.0f, most = 0.0f;
  switch (v.metric) {
    case VoronoiMetric::Euclidean:
      for (int axis = 0; axis < N; ++axis) sum += d[axis] * d[axis];
      return sum;
    case VoronoiMetric::Manhattan:
      for (int axis = 0; axis < N; ++axis) sum += std::abs(d[axis]);
      return sum;
    case VoronoiMetric::Chebychev:
      for (int axis = 0; axis < N; ++axis) most = std::max(most, std::abs(d[axis]));
      return most;
    case VoronoiMetric::Minkowski:
      for (int axis = 0; axis < N; ++axis) sum += std::pow(std::abs(d[axis]), v.exponent);
      return std::pow(sum, 1.0f / v.exponent);
  }
  return 0.0f;
}
template <int N>
bool compares_squares(const VoronoiParameters& v) {
  return N > 1 && v.metric == VoronoiMetric::Euclidean;
}

template <int N>
Color random_color(const VoronoiParameters& v, Point<N> cell) {
  if constexpr (N > 1) {
    if (v.generation == VoronoiGeneration::Third) {
      if constexpr (N == 2)
        return hash_cell(Point<3>(cell, 0.0f));
      else
        return Color(hash_cell(cell));
    }
  }
  return hash_color(cell);
}

/// Offsets of the cells up to kReach away on every axis, x fastest. The table is filled up to a multiple of eight with
/// entries that do not count.
template <int N, int kReach>
struct Offsets {
  static constexpr int kSide = 2 * kReach + 1;
  static constexpr int kCount = N == 1   ? kSide
                                : N == 2 ? kSide * kSide
                                : N == 3 ? kSide * kSide * kSide
                                         : kSide * kSide * kSide * kSide;
  static constexpr int kPadded = (kCount + 7) / 8 * 8;
  static constexpr int kCentre = kCount / 2;
  int value[N][kPadded]{};
  constexpr Offsets() {
    for (int i = 0; i < kCount; ++i)
      for (int axis = 0, rest = i; axis < N; ++axis, rest /= kSide) value[axis][i] = rest % kSide - kReach;
  }
};
template <int N, int kReach>
constexpr Offsets<N, kReach> kOffsets;

/// The random points of the cells around a position, relative to its own cell. All loops are over cells, and simple, so
/// that the compiler computes eight cells at a time.
template <int N, int kReach>
struct Points {
  using Table = Offsets<N, kReach>;
  static constexpr int kCount = Table::kCount, kPadded = Table::kPadded;
  const VoronoiParameters& v;
  Point<N> cell;
  float at[N][kPadded];

  Points(const VoronoiParameters& v, Point<N> cell) : v(v), cell(cell) {
    if constexpr (N > 1) {
      if (v.generation == VoronoiGeneration::Third) {
        permuted<N>([&](int i, const auto& word) {
          for (int axis = 0; axis < N; ++axis)
            at[axis][i] = float(kOffsets<N, kReach>.value[axis][i]) + v.randomness * permuted_unit(word[axis]);
        });
        return;
      }
    }
    hashed();
  }
  Point<N> offset(int i) const {
    Point<N> result;
    for (int axis = 0; axis < N; ++axis) result[axis] = float(kOffsets<N, kReach>.value[axis][i]);
    return result;
  }
  Point<N> point(int i) const {
    Point<N> result;
    for (int axis = 0; axis < N; ++axis) result[axis] = at[axis][i];
    return result;
  }
  Color color(int i) const { return random_color<N>(v, cell + offset(i)); }

  /// The colours of all cells.
  void find_colors(float (&colors)[3][kPadded]) const {
    if constexpr (N > 1) {
      if (v.generation == VoronoiGeneration::Third) {
        permuted<std::max(N, 3)>([&](int i, const auto& word) {
          for (int channel = 0; channel < 3; ++channel) colors[channel][i] = permuted_unit(word[channel]);
        });
        return;
      }
    }
    for (int i = 0; i < kPadded; ++i) {
      const Color own = hash_color(cell + offset(i));
      for (int channel = 0; channel < 3; ++channel) colors[channel][i] = own[channel];
    }
  }
  /// Distances of the points from `p`, which is relative to the cell; their squares if the metric compares squares.
  void measure(Point<N> p, float (&distances)[kPadded]) const {
    if constexpr (N == 1) {
      for (int i = 0; i < kPadded; ++i) distances[i] = std::abs(at[0][i] - p[0]);
    } else {
      switch (v.metric) {
        case VoronoiMetric::Euclidean: return measure_by<VoronoiMetric::Euclidean>(p, distances);
        case VoronoiMetric::Manhattan: return measure_by<VoronoiMetric::Manhattan>(p, distances);
        case VoronoiMetric::Chebychev: return measure_by<VoronoiMetric::Chebychev>(p, distances);
        case VoronoiMetric::Minkowski: break;
      }
      measure_by<VoronoiMetric::Minkowski>(p, distances);
    }
  }

 private:
  /// Passes the permuted words of each cell to `take`; with more words than axes, the others are those of 0.
  template <int kWords, class F>
  void permuted(F&& take) const {
    uint32_t own[kWords]{};
    for (int axis = 0; axis < N; ++axis) own[axis] = cell_word(cell[axis]);
    for (int i = 0; i < kPadded; ++i) {
      uint32_t word[kWords]{};
      for (int axis = 0; axis < N; ++axis) word[axis] = own[axis] + uint32_t(kOffsets<N, kReach>.value[axis][i]);
      permute(word);
      take(i, word);
    }
  }
  void hashed() {
    for (int i = 0; i < kPadded; ++i) {
      const Point<N> from = offset(i), unit = hash_point(cell + from);
      for (int axis = 0; axis < N; ++axis) at[axis][i] = from[axis] + v.randomness * unit[axis];
    }
  }
  template <VoronoiMetric kMetric>
  void measure_by(Point<N> p, float (&distances)[kPadded]) const {
    VoronoiParameters metric = v;
    metric.metric = kMetric;
    for (int i = 0; i < kPadded; ++i) {
      float d[N];
      for (int axis = 0; axis < N; ++axis) d[axis] = at[axis][i] - p[axis];
      distances[i] = comparable<N>(metric, d);
    }
  }
};

template <int N>
Vec4 padded(Point<N> p) {
  Vec4 result(0.0f);
  if constexpr (N == 1)
    result.w = p.x;
  else
    for (int axis = 0; axis < N; ++axis) result[axis] = p[axis];
  return result;
}

float farthest(const VoronoiParameters& v) { return v.generation == VoronoiGeneration::First ? 8.0f : kInfinity; }

/// The nearest or the second nearest point. Of points at the same distance, the first one counts.
template <int N>
VoronoiResult nearest(const VoronoiParameters& v, Point<N> p, bool second) {
  const Point<N> cell = glm::floor(p);
  const Points<N, 1> points(v, cell);
  float distances[Points<N, 1>::kPadded];
  points.measure(p - cell, distances);
  const bool squares = compares_squares<N>(v);
  struct Candidate {
    float distance;
    int index = -1;
  };
  Candidate best{squares ? sqr(farthest(v)) : farthest(v)}, next = best;
  for (int i = 0; i < Points<N, 1>::kCount; ++i) {
    if (distances[i] < best.distance)
      next = best, best = {distances[i], i};
    else if (distances[i] < next.distance)
      next = {distances[i], i};
  }
  const Candidate& chosen = second ? next : best;
  const float distance = squares ? std::sqrt(chosen.distance) : chosen.distance;
  if (chosen.index < 0) return {distance, random_color<N>(v, cell), padded<N>(cell)};
  return {distance, points.color(chosen.index), padded<N>(points.point(chosen.index) + cell)};
}

template <int N>
VoronoiResult smooth_nearest(const VoronoiParameters& v, Point<N> p) {
  const auto mix = [](auto a, auto b, float t) { return a * (1.0f - t) + b * t; };
  const Point<N> cell = glm::floor(p);
  const Points<N, 2> points(v, cell);
  float distances[Points<N, 2>::kPadded];
  points.measure(p - cell, distances);
  if (compares_squares<N>(v))
    for (float& distance : distances) distance = std::sqrt(distance);
  float colors[3][Points<N, 2>::kPadded];
  points.find_colors(colors);
  float smooth = farthest(v);
  Color color(0.0f);
  Point<N> position(0.0f);
  for (int i = 0; i < Points<N, 2>::kCount; ++i) {
    const float d = distances[i];
    float h = 1.0f;  // share of this point
    if (std::isfinite(smooth))
      h = saturate(0.5f + 0.5f * (smooth - d) / v.smoothness), h = h * h * (3.0f - 2.0f * h);
    else
      smooth = d;
    if (h == 0.0f) continue;
    const float correction = v.smoothness * h * (1.0f - h), shared = correction / (1.0f + 3.0f * v.smoothness);
    smooth = mix(smooth, d, h) - correction;
    color = mix(color, Color(colors[0][i], colors[1][i], colors[2][i]), h) - shared;
    position = mix(position, points.point(i), h) - shared;
  }
  return {smooth, color, padded<N>(cell + position)};
}

/// The index of the point that is nearest to `p` by the Euclidean metric, without the one number `without`; -1 if none is.
template <int N>
int nearest_index(const VoronoiParameters& v, const Points<N, 1>& points, Point<N> p, int without = -1) {
  float least = sqr(farthest(v));
  int nearest = -1;
  float squares[Points<N, 1>::kPadded];
  for (int i = 0; i < Points<N, 1>::kPadded; ++i) {
    squares[i] = 0.0f;
    for (int axis = 0; axis < N; ++axis) squares[i] += sqr(points.at[axis][i] - p[axis]);
  }
  for (int i = 0; i < Points<N, 1>::kCount; ++i)
    if (squares[i] < least && i != without) least = squares[i], nearest = i;
  return nearest;
}

template <int N>
float distance_to_edge(const VoronoiParameters& v, Point<N> p) {
  const Point<N> cell = glm::floor(p), local = p - cell;
  const Points<N, 1> points(v, cell);
  if constexpr (N == 1) {
    const auto to_edge = [&](int side) { return std::abs(0.5f * (points.at[0][1] + points.at[0][side]) - local.x); };
    return std::min(to_edge(0), to_edge(2));
  } else {
    const int nearest = nearest_index<N>(v, points, local);
    if (nearest < 0) return farthest(v);
    const Point<N> own = points.point(nearest);
    float edges[Points<N, 1>::kPadded];  // to the middle between the nearest point and every other point
    for (int i = 0; i < Points<N, 1>::kPadded; ++i) {
      float length2 = 0.0f, along = 0.0f;
      for (int axis = 0; axis < N; ++axis) {
        const float across = points.at[axis][i] - own[axis];
        length2 += across * across;
        along += (0.5f * (own[axis] + points.at[axis][i]) - local[axis]) * across;
      }
      edges[i] = length2 > 0.0001f ? along / std::sqrt(length2) : kInfinity;
    }
    float least = farthest(v);
    for (int i = 0; i < Points<N, 1>::kCount; ++i) least = std::min(least, edges[i]);
    return least;
  }
}

/// Half the distance between the nearest point and its own nearest neighbour.
template <int N>
float sphere_radius(const VoronoiParameters& v, Point<N> p) {
  const Point<N> cell = glm::floor(p);
  const Points<N, 1> points(v, cell);
  const int nearest = nearest_index<N>(v, points, p - cell);
  if (nearest < 0) return 0.0f;
  const Point<N> offset = points.offset(nearest), own = points.point(nearest) - offset;
  const Points<N, 1> around(v, cell + offset);
  const int neighbour = nearest_index<N>(v, around, own, Offsets<N, 1>::kCentre);
  return neighbour < 0 ? 0.5f * glm::length(own + offset) : 0.5f * glm::distance(around.point(neighbour), own);
}

template <int N>
VoronoiResult octave(const VoronoiParameters& v, Point<N> p) {
  if (v.feature == VoronoiFeature::SmoothF1 && (v.smoothness > 0.0f || v.generation == VoronoiGeneration::First))
    return smooth_nearest<N>(v, p);
  return nearest<N>(v, p, v.feature == VoronoiFeature::F2);
}

// Distances and colours of octaves are summed; positions and distances to edges are mixed.
template <int N>
VoronoiResult octaves(const VoronoiParameters& v, Point<N> p) {
  const auto mix = [](auto a, auto b, float t) { return a * (1.0f - t) + b * t; };
  const float reach = 0.5f + 0.5f * v.randomness;
  float amplitude = 1.0f, scale = 1.0f;
  const bool single = v.detail == 0.0f || v.roughness == 0.0f;
  const int last = single ? 0 : int(std::ceil(v.detail));
  VoronoiResult sum;

  if (v.feature == VoronoiFeature::DistanceToEdge) {
    sum.distance = 8.0f;
    float most = reach;
    for (int i = 0; i <= last; ++i) {
      const float d = distance_to_edge<N>(v, p * scale) / scale;
      if (single) {
        sum.distance = d;
        break;
      }
      const float mixed = mix(sum.distance, std::min(sum.distance, d), amplitude),
                  mixed_most = mix(most, reach / scale, amplitude);
      const float part = float(i) <= v.detail ? 1.0f : v.detail - std::floor(v.detail);
      sum.distance = part == 1.0f ? mixed : mix(sum.distance, std::min(sum.distance, mixed), part);
      most = mix(most, mixed_most, part);
      scale *= v.lacunarity;
      amplitude *= v.roughness;
    }
    if (v.normalize) sum.distance /= most;
    return sum;
  }

  float total = 0.0f;
  for (int i = 0; i <= last; ++i) {
    const VoronoiResult one = octave<N>(v, p * scale);
    if (single) {
      sum = one, total = 1.0f;
      break;
    }
    const float part = float(i) <= v.detail ? 1.0f : v.detail - std::floor(v.detail);
    total += part * amplitude;
    sum.distance += part * amplitude * one.distance;
    sum.color += part * amplitude * one.color;
    sum.position = mix(sum.position, mix(sum.position, one.position / scale, amplitude), part);
    scale *= v.lacunarity;
    amplitude *= v.roughness;
  }
  if (v.normalize) {
    float corner[N];
    std::fill_n(corner, N, reach);
    const float farthest_corner = N == 1 ? reach : comparable<N>(v, corner);
    const float most = (compares_squares<N>(v) ? std::sqrt(farthest_corner) : farthest_corner) *
                       (v.feature == VoronoiFeature::F2 ? 2.0f : 1.0f);
    sum.distance /= total * most;
    sum.color /= total;
  }
  sum.position = v.scale != 0.0f ? sum.position / v.scale : Vec4(0.0f);
  return sum;
}

}  // namespace

VoronoiResult voronoi(const VoronoiParameters& v, Vec3 p, float w) {
  return with_dimensions(v.dimensions, p, w, [&]<int N>(Point<N> q) {
    if (v.feature != VoronoiFeature::NSphereRadius) return octaves<N>(v, q);
    VoronoiResult result;
    result.distance = sphere_radius<N>(v, q);
    return result;
  });
}

}  // namespace ajar::nodes
