// A guide for walks from lights, in addition to power, emission and BSDFs: a mixture over starts and over directions at
// surfaces. Its densities depend only on position and direction. All code that weights walks from lights uses these
// densities, so a guide does not change the mean of an image. Light hints are such a guide
// (transport/hints/hint_guide.h), and so are learned starts (transport/guiding/emission_guide.h).
#pragma once

#include <optional>

#include "lights/light_set.h"
#include "math/types.h"

namespace ajar {

struct LightEnd;

class LightWalkGuide {
 public:
  virtual ~LightWalkGuide() = default;

  /// Whether a walk with this random number starts along the guide. If so, `u_choice` is rescaled for `start`;
  /// otherwise it is rescaled for the choice of a light by power.
  virtual bool sets_out(float& u_choice) const = 0;
  struct Start {
    uint32_t light;
    Vec3 position, normal, direction;
  };
  virtual Start start(const LightSet& lights, float u_choice, Vec2 u_position, Vec2 u_direction) const = 0;
  /// Sets the densities of a walk with this start. They replace the densities without a guide in `end`. `position`: on
  /// the light; for distant lights any point of the ray.
  virtual void mix(const LightSet& lights, uint32_t light, Vec3 position, Vec3 normal, Vec3 direction,
                   LightEnd& end) const = 0;

  /// The probability that a walk from a light follows the guide at this position on a surface.
  virtual float share_at(Vec3 position) const = 0;
  /// The direction, if the walk follows the guide. Otherwise `u` is rescaled so that it can be used again.
  virtual std::optional<Vec3> direction_at(Vec3 position, float& u, Vec2 u_direction) const = 0;
  /// The density of the guide's directions per solid angle, times the probability of following the guide.
  virtual float pdf_at(Vec3 position, Vec3 direction) const = 0;
};

}  // namespace ajar
