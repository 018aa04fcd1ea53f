// The random numbers of gather rays (photon_gather.h).
#pragma once

#include "math/types.h"
#include "sampling/sampler.h"

namespace ajar {

/// Dimensions of the direction of a gather ray. A fixed number for each vertex of its chain follows.
constexpr uint32_t kGatherDimensions = 4;
/// First dimension of media, with EyeMedia::kDimensions for each ray.
constexpr uint32_t kMediaDimensions = 12288;

/// The numbers that choose the direction of a gather ray, from four dimensions.
struct GatherNumbers {
  float lobe, guide = 0.0f;
  Vec2 direction;
  GatherNumbers(Sampler& sampler, uint32_t first, bool guided) {
    sampler.set_dimension(first);
    const Vec3 u = sampler.get_3d();
    lobe = u.z;
    direction = Vec2(u);
    if (!guided) return;
    sampler.set_dimension(first + 3);
    guide = sampler.get_1d();
  }
};

}  // namespace ajar
