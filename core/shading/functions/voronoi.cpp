#include "shading/functions/voronoi.h"

#include <algorithm>

#include "math/hash.h"

namespace ajar::nodes {
namespace {

template <int N>
float distance(const VoronoiParameters& v, Point<N> d) {
  if constexpr (N == 1) return std::abs(d.x);
  float sum = 0.0f, most = 0.0f;
  switch (v.metric) {
    case VoronoiMetric::Euclidean: return glm::length(d);
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

/// The random point of a cell in its unit cube.
template <int N>
Point<N> random_point(const VoronoiParameters& v, Point<N> cell) {
  if constexpr (N > 1)
    if (v.generation == VoronoiGeneration::Third) return hash_cell(cell);
  return hash_point(cell);
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

/// The unit cell of a position, and the random points of the surrounding cells relative to it.
template <int N>
struct Cells {
  const VoronoiParameters& v;
  Point<N> cell, local;
  Cells(const VoronoiParameters& v, Point<N> p) : v(v), cell(glm::floor(p)), local(p - cell) {}
  Point<N> point(Point<N> offset) const { return offset + v.randomness * random_point<N>(v, cell + offset); }
  Color color(Point<N> offset) const { return random_color<N>(v, cell + offset); }
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

/// The nearest or the second nearest point.
template <int N>
VoronoiResult nearest(const VoronoiParameters& v, Point<N> p, bool second) {
  const Cells<N> cells(v, p);
  struct Candidate {
    float distance;
    Point<N> offset{0.0f}, position{0.0f};
  };
  Candidate best{farthest(v)}, next{farthest(v)};
  for_each_cell<N>(1, [&](Point<N> offset) {
    const Point<N> position = cells.point(offset);
    const float d = distance<N>(v, position - cells.local);
    if (d < best.distance)
      next = best, best = {d, offset, position};
    else if (d < next.distance)
      next = {d, offset, position};
  });
  const Candidate& chosen = second ? next : best;
  return {chosen.distance, cells.color(chosen.offset), padded<N>(chosen.position + cells.cell)};
}

template <int N>
VoronoiResult smooth_nearest(const VoronoiParameters& v, Point<N> p) {
  const Cells<N> cells(v, p);
  const auto mix = [](auto a, auto b, float t) { return a * (1.0f - t) + b * t; };
  float smooth = farthest(v);
  Color color(0.0f);
  Point<N> position(0.0f);
  for_each_cell<N>(2, [&](Point<N> offset) {
    const Point<N> point = cells.point(offset);
    const float d = distance<N>(v, point - cells.local);
    float h = 1.0f;  // share of this point
    if (std::isfinite(smooth))
      h = saturate(0.5f + 0.5f * (smooth - d) / v.smoothness), h = h * h * (3.0f - 2.0f * h);
    else
      smooth = d;
    const float correction = v.smoothness * h * (1.0f - h), shared = correction / (1.0f + 3.0f * v.smoothness);
    smooth = mix(smooth, d, h) - correction;
    color = mix(color, cells.color(offset), h) - shared;
    position = mix(position, point, h) - shared;
  });
  return {smooth, color, padded<N>(cells.cell + position)};
}

template <int N>
float distance_to_edge(const VoronoiParameters& v, Point<N> p) {
  const Cells<N> cells(v, p);
  if constexpr (N == 1) {
    const float middle = cells.point(p * 0.0f).x;
    const auto to_edge = [&](float side) {
      return std::abs(0.5f * (middle + cells.point(Point<1>(side)).x) - cells.local.x);
    };
    return std::min(to_edge(-1.0f), to_edge(1.0f));
  } else {
    Point<N> nearest(0.0f);
    float least = farthest(v);
    for_each_cell<N>(1, [&](Point<N> offset) {
      const Point<N> to_point = cells.point(offset) - cells.local;
      const float d2 = glm::dot(to_point, to_point);
      if (d2 < least) least = d2, nearest = to_point;
    });
    least = farthest(v);
    for_each_cell<N>(1, [&](Point<N> offset) {  // the middle between the nearest point and every other point
      const Point<N> to_point = cells.point(offset) - cells.local, across = to_point - nearest;
      if (glm::dot(across, across) > 0.0001f)
        least = std::min(least, glm::dot(0.5f * (nearest + to_point), glm::normalize(across)));
    });
    return least;
  }
}

/// Half the distance between the nearest point and its own nearest neighbour.
template <int N>
float sphere_radius(const VoronoiParameters& v, Point<N> p) {
  const Cells<N> cells(v, p);
  Point<N> nearest(0.0f), nearest_offset(0.0f);
  float least = farthest(v);
  for_each_cell<N>(1, [&](Point<N> offset) {
    const Point<N> point = cells.point(offset);
    const float d = glm::distance(point, cells.local);
    if (d < least) least = d, nearest = point, nearest_offset = offset;
  });
  Point<N> neighbour(0.0f);
  least = farthest(v);
  for_each_cell<N>(1, [&](Point<N> offset) {
    if (offset == Point<N>(0.0f)) return;
    const Point<N> point = cells.point(offset + nearest_offset);
    const float d = glm::distance(point, nearest);
    if (d < least) least = d, neighbour = point;
  });
  return 0.5f * glm::distance(neighbour, nearest);
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
    const float most = distance<N>(v, Point<N>(reach)) * (v.feature == VoronoiFeature::F2 ? 2.0f : 1.0f);
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
