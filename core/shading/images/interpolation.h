// Interpolation of texels, wherever they are stored.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>

#include "math/half.h"
#include "math/types.h"
#include "shading/images/texture.h"

namespace ajar::texels {

template <typename T>
inline constexpr float kScale = 1.0f;
template <>
inline constexpr float kScale<uint8_t> = 1.0f / 255.0f;
template <>
inline constexpr float kScale<uint16_t> = 1.0f / 65535.0f;

/// Four floats in one register. The sums of texels are the main cost of a lookup.
using Float4 = float __attribute__((vector_size(16)));

template <typename T>
Float4 fetch(const uint8_t* texels, int64_t index) {
  T t[4];
  std::memcpy(t, texels + index * int64_t(sizeof t), sizeof t);
  return Float4{float(t[0]), float(t[1]), float(t[2]), float(t[3])} * kScale<T>;
}
template <>
inline Float4 fetch<uint8_t>(const uint8_t* texels, int64_t index) {
  uint8_t t __attribute__((vector_size(4)));
  std::memcpy(&t, texels + index * 4, 4);
  return __builtin_convertvector(t, Float4) * kScale<uint8_t>;
}

inline Vec4 to_vec4(Float4 f) { return {f[0], f[1], f[2], f[3]}; }

/// Integer and fractional part of a texel position. Large coordinates and NaN are set to 0, so that the result fits an
/// int.
inline int split(float x, float& fraction) {
  if (!(std::abs(x) < 1e9f)) x = 0.0f;
  const float floor = std::floor(x);
  fraction = x - floor;
  return int(floor);
}

/// The index of texel `i` in an image of width `n`, or -1 where the image is clipped.
inline int extend(int i, int n, Extension extension) {
  if (uint32_t(i) < uint32_t(n)) return i;
  switch (extension) {
    case Extension::Repeat: {
      const int m = i % n;
      return m < 0 ? m + n : m;
    }
    case Extension::Extend: return i < 0 ? 0 : n - 1;
    case Extension::Clip: return -1;
    case Extension::Mirror: {
      const int64_t period = 2 * int64_t(n);
      int64_t m = i % period;
      if (m < 0) m += period;
      return int(m < n ? m : period - 1 - m);
    }
  }
  return -1;
}

/// Weights of a uniform cubic B-spline at fraction t.
inline void cubic_weights(float t, float w[4]) {
  const float t2 = t * t, t3 = t2 * t;
  w[0] = (1.0f - 3.0f * t + 3.0f * t2 - t3) / 6.0f;
  w[1] = (4.0f - 6.0f * t2 + 3.0f * t3) / 6.0f;
  w[2] = (1.0f + 3.0f * t + 3.0f * t2 - 3.0f * t3) / 6.0f;
  w[3] = t3 / 6.0f;
}

/// The value of an image of this size at `uv`. `stored(x, y)` returns a texel of it as Float4.
template <class Stored>
Vec4 interpolate(int width, int height, Vec2 uv, Interpolation interpolation, Extension extension, Stored&& stored) {
  const auto texel = [&](int x, int y) {
    if ((x | y) < 0) return Float4{};
    return stored(x, y);
  };
  if (extension == Extension::Repeat) uv -= glm::floor(uv);  // keeps the precision far from the origin
  float tx, ty;
  const float offset = interpolation == Interpolation::Closest ? 0.0f : 0.5f;
  const int x = split(uv.x * width - offset, tx), y = split(uv.y * height - offset, ty);
  if (interpolation == Interpolation::Closest)
    return to_vec4(texel(extend(x, width, extension), extend(y, height, extension)));
  if (interpolation == Interpolation::Linear) {
    const int x0 = extend(x, width, extension), x1 = extend(x + 1, width, extension);
    const int y0 = extend(y, height, extension), y1 = extend(y + 1, height, extension);
    return to_vec4((1.0f - ty) * ((1.0f - tx) * texel(x0, y0) + tx * texel(x1, y0)) +
                   ty * ((1.0f - tx) * texel(x0, y1) + tx * texel(x1, y1)));
  }
  float wx[4], wy[4];
  cubic_weights(tx, wx);
  cubic_weights(ty, wy);
  Float4 sum{};
  for (int j = 0; j < 4; ++j) {
    const int row = extend(y + j - 1, height, extension);
    for (int i = 0; i < 4; ++i) sum += wx[i] * wy[j] * texel(extend(x + i - 1, width, extension), row);
  }
  return to_vec4(sum);
}

}  // namespace ajar::texels
