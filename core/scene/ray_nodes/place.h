// The seed of what is computed at random at a place: all paths that visit it find the same, and every place has its own.
#pragma once

#include <bit>

#include "math/random.h"
#include "shading/bsdf/shading_point.h"

namespace ajar {

inline uint32_t seed_of_place(const ShadingPoint& point) {
  uint32_t seed = std::bit_cast<uint32_t>(point.time);
  for (int k = 0; k < 3; ++k) seed = hash_combine(seed, std::bit_cast<uint32_t>(point.position[k]));
  return seed;
}

}  // namespace ajar
