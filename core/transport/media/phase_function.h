// Phase functions: mixtures of the shapes of phase_shape.h.
//
// The cosine is between the directions of travel before and after scattering. Densities are per solid angle.
#pragma once

#include <algorithm>
#include <cmath>

#include "math/frame.h"
#include "shading/media/medium.h"

namespace ajar {

/// The phase function of a point that scatters.
class PhaseFunction {
 public:
  explicit PhaseFunction(const MediumPoint& medium) : medium_(medium) {
    for (int i = 0; i < medium.lobe_count; ++i) sum_ += share(i);
  }

  /// The fraction of the scattered light that goes in this direction, per solid angle. Each channel has its own
  /// mixture.
  Color evaluate(float cosine) const {
    Color value(0.0f);
    for (int i = 0; i < medium_.lobe_count; ++i) value += lobe(i).scattering * lobe(i).shape.evaluate(cosine);
    for (int c = 0; c < 3; ++c) value[c] = medium_.scattering[c] > 0.0f ? value[c] / medium_.scattering[c] : 0.0f;
    return value;
  }
  float pdf_solid_angle(float cosine) const {
    float value = 0.0f;
    for (int i = 0; i < medium_.lobe_count; ++i) value += share(i) * lobe(i).shape.evaluate(cosine);
    return value / sum_;
  }
  Vec3 sample(Vec3 direction, float u_lobe, Vec2 u) const {
    int chosen = 0;
    for (float left = u_lobe * sum_ - share(0); left >= 0.0f && chosen + 1 < medium_.lobe_count; left -= share(chosen))
      ++chosen;
    const float cosine = lobe(chosen).shape.sample(u.x), sine = safe_sqrt(1.0f - cosine * cosine);
    const float phi = 2.0f * kPi * u.y;
    return Frame(direction).to_world(Vec3(sine * std::cos(phi), sine * std::sin(phi), cosine));
  }

 private:
  const MediumLobe& lobe(int i) const { return medium_.lobes[size_t(i)]; }
  float share(int i) const { return lobe(i).scattering.x + lobe(i).scattering.y + lobe(i).scattering.z; }

  const MediumPoint& medium_;
  float sum_ = 0.0f;
};

}  // namespace ajar
