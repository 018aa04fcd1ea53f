// What may lead walks from lights besides power, emission and BSDFs: a mixture over starts and over directions at
// surfaces, whose densities depend on place and direction alone. Everything that weighs walks from lights asks for
// these densities, so a guide never changes the mean of an image. The artist's hints are one
// (transport/paths/light_walk_guide.h).
#pragma once

#include <optional>

#include "lights/light_set.h"
#include "math/types.h"

namespace ajar {

struct LightEnd;

class LightWalkGuide {
 public:
  virtual ~LightWalkGuide() = default;

  /// Does a walk with this number set out along the guide? Then `u_choice` is fit for `start`, else for choosing a
  /// light by power.
  virtual bool sets_out(float& u_choice) const = 0;
  struct Start {
    uint32_t light;
    Vec3 position, normal, direction;
  };
  virtual Start start(const LightSet& lights, float u_choice, Vec2 u_position, Vec2 u_direction) const = 0;
  /// Densities of a walk that starts so, in place of those that `end` has of walks without a guide.
  virtual void mix(const LightSet& lights, uint32_t light, Vec3 position, Vec3 normal, Vec3 direction,
                   LightEnd& end) const = 0;

  /// The probability that a walk from a light which has come to this place on a surface goes on along the guide.
  virtual float share_at(Vec3 position) const = 0;
  /// Does it? Then its direction, else `u` is fit for use again.
  virtual std::optional<Vec3> direction_at(Vec3 position, float& u, Vec2 u_direction) const = 0;
  /// Of the guide's directions, per solid angle, their probability included.
  virtual float pdf_at(Vec3 position, Vec3 direction) const = 0;
};

}  // namespace ajar
