// A single light: a lamp with or without extent, an emissive triangle, a sun, or the environment.
//
// Conventions: `p` is the lit point, `wi` points from p to the light, `wo` from the light to p. Densities of directions
// are per solid angle at p. `sample_le` gives rays that leave the light, with a density per area times solid angle (for
// suns and the environment: the area of the disk around the scene). Units and shapes have the meaning of Cycles 3.4
// (lamp.h has the formulas). Delta lights (radius or angle 0) cannot be hit; their pdf in `pdf_li` is 0.
#pragma once

#include <optional>

#include "description/scene_description.h"
#include "math/frame.h"
#include "math/types.h"

namespace ajar {

enum class LightType : uint8_t {
  Point,
  Sphere,
  Spot,
  SpotSphere,
  Rectangle,
  Ellipse,
  DistantDelta,
  DistantDisk,
  Triangle,
  Environment
};

inline bool is_delta(LightType type) {
  return type == LightType::Point || type == LightType::Spot || type == LightType::DistantDelta;
}
/// Whether all light leaves within a cone around the axis of the lamp.
inline bool has_cone(LightType type) {
  return type == LightType::Spot || type == LightType::SpotSphere || type == LightType::Rectangle ||
         type == LightType::Ellipse;
}
inline bool is_sphere(LightType type) { return type == LightType::Sphere || type == LightType::SpotSphere; }
inline bool is_distant(LightType type) {
  return type == LightType::DistantDelta || type == LightType::DistantDisk || type == LightType::Environment;
}

/// The distance in metres that a lamp's shader sees as that of its light when the distance is not known yet.
constexpr float kUsualDistance = 1.0f;

/// A point on a light or another surface, seen from p.
struct LightPlace {
  Vec3 wi;                ///< from p
  float distance;         ///< kInfinity for distant light
  Vec3 position, normal;  ///< for distant lights and those without extent the normal is -wi
  /// bound of the rounding error that moves the position off its surface, besides a fraction of the distance
  float position_error = 0.0f;
  uint32_t blockers = kVisibleShadow;  ///< Ray::blockers of the shadow ray to it
};

struct LightSample : LightPlace {
  /// emitted towards p; for delta lights radiance * geometry, so that the contribution is f_cos * radiance / pdf
  Color radiance;
  float pdf_solid_angle;  ///< given this light; 1 for delta lights
  bool delta;
};

/// LightPlace::position_error of a position on a lamp.
inline float lamp_position_error(Vec3 position) { return gamma_bound(8) * max_component(glm::abs(position)); }

struct LightRay {
  Ray ray;
  Color radiance;          ///< intensity for delta positions, irradiance for the delta sun; at kUsualDistance
  Vec3 normal;             ///< of the light; direction of travel for delta positions and distant lights
  Vec2 barycentric{0.0f};  ///< of the origin on a triangle
  float pdf_area;          ///< of the origin (1 for delta positions)
  float pdf_solid_angle;   ///< of the direction (1 for the delta sun)
};

inline constexpr uint64_t kAllReceivers = ~uint64_t(0);
/// The receiver set of what every light lights: the camera, and the volume of the world.
inline constexpr uint32_t kEveryLight = 64;
inline bool lights_set(uint64_t receivers, uint32_t receiver_set) {
  return receiver_set >= kEveryLight || (receivers >> receiver_set & 1) != 0;
}
/// Bits of BuiltInstance::visibility above those of VisibilityBits, and of Ray::blockers: an object that casts shadows
/// has the bit of its blocker set.
constexpr uint32_t blocker_bit(uint32_t set) { return 64u << set; }
/// Ray::blockers of a light with these links.
constexpr uint32_t blockers_of(const LightLinks& links) {
  constexpr uint32_t kAll = (1u << LightLinks::kBlockerSets) - 1;
  return (links.blockers & kAll) == kAll ? uint32_t(kVisibleShadow) : (links.blockers & kAll) << 6;
}

/// The properties of a light that integrators need at every sample.
struct LightFlags {
  LightType type = LightType::Point;
  uint32_t visibility = 63;
  bool cast_shadow = true;
  bool mis = true;  ///< may also be found by BSDF sampling
  bool soft = false;
  uint64_t receivers = kAllReceivers;  ///< LightLinks::receivers
  uint32_t blockers = kVisibleShadow;  ///< Ray::blockers of its shadow rays
  int max_bounces = 1024;              ///< LightDescription::max_bounces
  /// Whether only some kinds of lobes see the light (VisibilityBits of diffuse, glossy and transmission), or only some
  /// objects block it. Light sampling distinguishes the kinds and the blockers. Rays of sharp lobes see the light if it
  /// is visible to their kind, and if nothing is in front of it. Rays of rough lobes count if the walk knows SampledKinds
  /// and the light has no blockers of its own; else, rough lobes are lit by light sampling alone.
  bool partial() const { return (visibility & 14u) != 14u || has_blockers(); }
  bool has_blockers() const { return blockers != kVisibleShadow; }
  bool lights(uint32_t receiver_set) const { return lights_set(receivers, receiver_set); }
  /// Whether paths can start at the light. A ray from a light that some objects do not block cannot tell which of the
  /// surfaces along it the light reaches: all of them.
  bool starts_walks() const { return cast_shadow && blockers == kVisibleShadow; }
};

/// One light as data; only the members for its type are set.
struct Light {
  LightType type = LightType::Point;
  uint32_t visibility = 63;
  bool cast_shadow = true;
  bool mis = true;      ///< may also be found by BSDF sampling
  bool soft = false;    ///< sphere: shines as a disk (lamp.h)
  Vec3 position{0.0f};  ///< centre; first vertex of a triangle
  Frame frame;          ///< n: direction of emission; s, t: local x and y
  /// triangle edges; half axes of rectangle and ellipse; spot in a scaled space: local x and y, multiplied by the scale
  /// of z over theirs
  Vec3 edge1{0.0f}, edge2{0.0f};
  Color radiance{0.0f};                         ///< emitted (intensity for delta positions, irradiance for the suns)
  float radius = 0.0f;                          ///< of the sphere; of the sun's disk at distance 1
  float area = 0.0f;                            ///< one side; of the sun's disk, for an even sun pi sin^2 (lamp.h)
  float cos_outer = -1.0f, spot_smooth = 0.0f;  ///< spot: edge of the cone, width of the blend in cosine
  float cos_widest = -1.0f;                     ///< spot: cone around the axis that contains all its light
  bool even_spot = false;                       ///< see LightDescription
  float sun_one_minus_cos = 0.0f;               ///< even sun: 1 - cos of the half angle; 0 for a disk (lamp.h)
  float spread_tan = 0.0f, spread_norm = 1.0f;  ///< area: slope and scale of the attenuation
  int shader = -1;                              ///< program that multiplies `radiance` at the light point; -1: none
  uint32_t instance = 0, primitive = 0;         ///< of a triangle
  uint64_t receivers = kAllReceivers;           ///< see LightFlags
  uint32_t blockers = kVisibleShadow;           ///< see LightFlags
  int max_bounces = 1024;                       ///< see LightFlags
  float power = 0.0f;                           ///< luminance of the emitted watts, for the choice of a light
};

}  // namespace ajar
