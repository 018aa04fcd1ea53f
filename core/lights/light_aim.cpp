#include "lights/light_aim.h"

#include <algorithm>
#include <array>
#include <bit>

namespace ajar {

LightAim aim_of(const LightBounds& bounds) {
  LightAim aim;
  const Vec3 half = 0.5f * bounds.upper - 0.5f * bounds.lower;
  aim.center = Triple(0.5f * bounds.lower + 0.5f * bounds.upper);
  aim.half = Triple(half);
  aim.radius_squared = glm::dot(half, half);
  aim.axis = Triple(bounds.axis);
  aim.cos_normals = bounds.cos_normals;
  aim.sin_normals = std::sqrt(std::max(0.0f, 1.0f - sqr(bounds.cos_normals)));
  aim.cos_beyond = bounds.cos_beyond;
  aim.intensity = std::max(bounds.intensity - bounds.grown, 0.0f);
  aim.growing = bounds.growing.x;
  aim.growing_squared = bounds.growing.y;
  constexpr float kRounding = 1e-6f;
  aim.angle_squared = (bounds.flat ? kRounding : 1.0f) * aim.radius_squared;
  return aim;
}

LightLanes::LightLanes(const std::vector<Lane>& lanes) {
  if (lanes.empty()) return;
  const size_t stride = lanes.size() + kAtOnce;
  values_.assign(kComponents * stride, 0.0f);
  for (size_t i = 0; i < lanes.size(); ++i) {
    const auto components = std::bit_cast<std::array<float, kComponents>>(lanes[i].aim);
    for (size_t c = 0; c < kComponents; ++c) values_[c * stride + i] = components[c];
    nodes_.push_back(lanes[i].node);
  }
}

template <class Estimate>
void LightLanes::fill(size_t first, size_t count, float* __restrict values, const Estimate& estimate) const {
  const size_t stride = nodes_.size() + kAtOnce;
  for (size_t begin = 0; begin < count; begin += kAtOnce) {
    const float* component = values_.data() + first + begin;
    for (size_t i = 0; i < kAtOnce; ++i) {
      const auto at = [component, stride, i](size_t c) { return component[c * stride + i]; };
      values[begin + i] = estimate(LightAim{{at(0), at(1), at(2)},
                                            {at(3), at(4), at(5)},
                                            at(6),
                                            {at(7), at(8), at(9)},
                                            at(10),
                                            at(11),
                                            at(12),
                                            at(13),
                                            at(14),
                                            at(15),
                                            at(16)});
    }
  }
}

void LightLanes::estimate(size_t first, size_t count, const Vec3& p, const Vec3& n, float* values) const {
  fill(first, count, values,
       [p = Triple(p), n = Triple(n)](const LightAim& aim) { return irradiance_estimate<false>(aim, false, p, n); });
}

void LightLanes::estimate(size_t first, size_t count, const PlainStretch& stretch, float* values) const {
  fill(first, count, values, [stretch](const LightAim& aim) { return fluence_estimate<false>(aim, false, stretch); });
}

}  // namespace ajar
