#include "shading/functions/radial_tiling.h"

#include <algorithm>
#include <cmath>

// A polygon of size 1 has sides at a distance of 1 from the origin, except for the last one, which is farther away if it
// belongs to a smaller sector. Its corners are replaced by arcs that touch both sides. A point lies on the boundary of
// one scaled polygon, whose scale is its size. Angles are seen from the origin. Where it is on the boundary is given by
// the length on the straight part of the side, and then by the angle on the arc; between them the one changes to the
// other.

namespace ajar::nodes {
namespace {

/// One half of a side, from its middle to a corner.
struct HalfSide {
  float straight, arc;  ///< angles of both parts
  float roundness;

  float transition() const { return (1.0f - roundness) * arc; }  ///< part of the arc where lengths change to angles
  /// The place at the corner, for a side at distance h.
  float end(float h) const { return h * std::tan(straight) + transition() * (0.5f * h + 0.5f) + roundness * arc; }
  /// The place at an angle after the start of the arc.
  float on_arc(float h, float angle) const {
    const float t = transition();
    return h * std::tan(straight) +
           (angle < t ? h * angle + 0.5f * (1.0f - h) * sqr(angle) / t : t * (0.5f * h - 0.5f) + angle);
  }
};

/// The angle of the arc at the corner of a side whose half has the angle `half`.
float arc_of(float half, float roundness) {
  return roundness > 0.0f ? half - std::atan((1.0f - roundness) * std::tan(half)) : 0.0f;
}

struct Circle {
  Vec2 center;
  float radius;

  /// The distance of its far side in a direction.
  float distance(float angle) const {
    const float along = center.x * std::cos(angle) + center.y * std::sin(angle);
    return along + std::sqrt(sqr(along) + sqr(radius) - glm::dot(center, center));
  }
};

/// The place of a point on a side at distance 1, and the size of the polygon of this side.
struct OnSide {
  float along, size;
};

OnSide on_straight(const HalfSide& half, bool normalize, float length, float from_middle) {
  const float size = length * std::cos(from_middle), along = size * std::tan(from_middle);
  return {normalize ? along / half.end(size) : along, size};
}

OnSide on_arc(const HalfSide& half, bool normalize, float length, float from_corner, float size) {
  const float h = length * std::cos(half.straight), angle = half.arc - from_corner;
  const float along = half.on_arc(h, angle);
  return {normalize ? along / glm::mix(half.end(size), half.end(h), angle / half.arc) : along, size};
}

/// The last sector of a polygon whose number of sides is not whole, and the corners on both of its sides, which are
/// symmetric. The angles of `arc` are measured from a corner towards the other sectors.
struct LastSector {
  float half;      ///< half of its angle
  HalfSide inner;  ///< in the last sector
  HalfSide outer;  ///< in the sector beside it
  float scale;     ///< 1 / distance of the side
  Circle arc;      ///< of the polygon whose last side has the distance 1

  LastSector(float sides, float regular_half, float roundness) : half(kPi - std::floor(sides) * regular_half) {
    inner.arc = arc_of(half, roundness);
    inner.straight = half - inner.arc;
    inner.roundness = roundness;
    scale = std::cos(regular_half) / std::cos(half);
    const Vec2 touched = Vec2(std::cos(inner.arc), -std::sin(inner.arc)) / std::cos(inner.straight);
    arc.radius = roundness * std::tan(half) / std::tan(0.5f * (regular_half + half));
    arc.center = touched - arc.radius * Vec2(std::cos(half), -std::sin(half));
    const Vec2 end = arc.center + arc.radius * Vec2(std::cos(regular_half), std::sin(regular_half));
    outer.arc = roundness > 0.0f ? std::atan(end.y / end.x) : 0.0f;
    outer.straight = regular_half - outer.arc;
    outer.roundness = 1.0f - std::tan(outer.straight) / std::tan(regular_half);
  }
  float width() const {
    return std::tan(inner.straight) +
           scale * (inner.transition() * (0.5f / scale + 0.5f) + inner.roundness * inner.arc);
  }
};

}  // namespace

RadialTile radial_tile(float sides, float roundness, bool normalize, Vec2 p) {
  sides = std::max(sides, 2.0f);
  roundness = std::clamp(roundness, 0.0f, 1.0f);
  const float length = glm::length(p), polar = std::atan2(p.y, p.x), angle = polar + (p.y < 0.0f ? 2.0f * kPi : 0.0f);
  const float half = kPi / sides, number = std::floor(angle / (2.0f * half)), local = angle - number * 2.0f * half;
  const bool endless = sides == 2.0f && roundness == 0.0f;  // two parallel sides
  const float arc = arc_of(half, roundness);
  const HalfSide regular{half - arc, arc, roundness};

  RadialTile tile;
  tile.sector = std::floor(sides * (polar / (2.0f * kPi) + (p.y < 0.0f ? 1.0f : 0.0f)));
  tile.width = endless ? 0.0f : regular.end(1.0f);
  float middle = half;
  OnSide place;
  const auto at_regular_corner = [&] {
    const float from_corner = local > half ? 2.0f * half - local : local;
    const Circle circle{{(1.0f - roundness) / std::cos(half), 0.0f}, roundness};
    return on_arc(regular, normalize, length, from_corner, length / circle.distance(from_corner));
  };
  const float from_middle = std::abs(half - local);
  const bool on_corner = regular.arc > 0.0f && (local < regular.arc || local >= 2.0f * half - regular.arc);
  if (sides == std::floor(sides)) {
    place = on_corner ? at_regular_corner() : on_straight(regular, normalize && !endless, length, from_middle);
  } else {
    const LastSector last(sides, half, roundness);
    const float begin = 2.0f * kPi - 2.0f * last.half;
    // The angle after the nearest corner of the last sector, away from this sector.
    const float after = angle >= 2.0f * kPi - last.half ? angle - 2.0f * kPi : angle < half ? angle : begin - angle;
    if (after < 0.0f) {
      middle = last.half;
      place = after <= -last.inner.arc
                  ? on_straight(last.inner, normalize, length, std::abs(last.half - local))
                  : on_arc(last.inner, normalize, length, -after, length / last.arc.distance(after));
      place.size *= last.scale;
      if (!normalize) place.along *= last.scale;
      tile.width = last.width();
    } else if (after < last.outer.arc) {
      place = on_arc(last.outer, normalize, length, after, last.scale * length / last.arc.distance(after));
    } else if (after < half) {
      place = on_straight(last.outer, normalize, length, from_middle);
    } else {
      place = on_corner ? at_regular_corner() : on_straight(regular, normalize, length, from_middle);
    }
  }
  if (local < middle) place.along = -place.along;
  if (p == Vec2(0.0f)) place.along = 0.0f;
  tile.place = normalize ? Vec2(0.5f * place.along + 0.5f, place.size) : Vec2(place.along, place.size - 1.0f);
  tile.turn = number * 2.0f * half + middle;
  return tile;
}

}  // namespace ajar::nodes
