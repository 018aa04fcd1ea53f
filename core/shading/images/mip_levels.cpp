#include "shading/images/mip_levels.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "math/half.h"
#include "math/srgb.h"
#include "shading/images/interpolation.h"

namespace ajar {

namespace {

/// The texels of one axis that a texel of the next level covers, and their shares of it.
struct Covered {
  int first = 0, count = 1;
  std::array<float, 4> shares{1.0f, 0.0f, 0.0f, 0.0f};
};

std::vector<Covered> covered_by(int side, int next) {
  std::vector<Covered> all(static_cast<size_t>(next));
  for (int i = 0; i < next; ++i) {
    const double ratio = double(side) / next, from = i * ratio, to = (i + 1) * ratio;
    Covered& covered = all[size_t(i)];
    covered.first = int(from);
    covered.count = 0;
    for (int k = covered.first; k < std::min(side, int(std::ceil(to - 1e-9))) && covered.count < 4; ++k)
      covered.shares[size_t(covered.count++)] = float((std::min(to, k + 1.0) - std::max(from, double(k))) / ratio);
  }
  return all;
}

/// Colours as light, multiplied by alpha.
template <typename T>
struct Light {
  TexelKind kind;
  std::array<float, 256> bytes{};  ///< the curve of sRGB at the values of a byte

  explicit Light(TexelKind k) : kind(k) {
    for (int i = 0; i < 256; ++i) bytes[size_t(i)] = linear_from_srgb(float(i) / 255.0f);
  }
  void decode(const T* in, float* out) const {
    const float alpha = float(in[3]) * texels::kScale<T>;
    out[3] = alpha;
    for (int c = 0; c < 3; ++c) {
      const float value = float(in[c]) * texels::kScale<T>;
      if (!kind.srgb) {
        out[c] = value;
      } else if (kind.has_alpha && alpha != 1.0f) {
        out[c] = alpha > 0.0f ? linear_from_srgb(std::max(value / alpha, 0.0f)) * alpha : 0.0f;
      } else if constexpr (std::is_same_v<T, uint8_t>) {
        out[c] = bytes[in[c]];
      } else {
        out[c] = linear_from_srgb(std::max(value, 0.0f));
      }
    }
  }
  void encode(const float* in, T* out) const {
    const float alpha = in[3];
    out[3] = rounded(alpha);
    for (int c = 0; c < 3; ++c) {
      const float value = in[c];
      if (!kind.srgb)
        out[c] = rounded(value);
      else if (kind.has_alpha && alpha != 1.0f)
        out[c] = rounded(alpha > 0.0f ? srgb_from_linear(value / alpha) * alpha : 0.0f);
      else
        out[c] = rounded(srgb_from_linear(value));
    }
  }
  static T rounded(float value) {
    if constexpr (std::is_integral_v<T>) {
      const float one = float(std::numeric_limits<T>::max());
      return T(std::lround(glm::clamp(value * one, 0.0f, one)));
    } else if constexpr (std::is_same_v<T, Half>) {
      return T(glm::clamp(value, -65504.0f, 65504.0f));
    } else {
      return T(value);
    }
  }
};

template <typename T>
std::vector<uint8_t> halved(const std::vector<uint8_t>& texels, int width, int height, TexelKind kind) {
  const int next_width = side_of_level(width, 1), next_height = side_of_level(height, 1);
  std::vector<uint8_t> next(size_t(next_width) * size_t(next_height) * 4 * sizeof(T));
  const T* const in = reinterpret_cast<const T*>(texels.data());
  T* const out = reinterpret_cast<T*>(next.data());
  const std::vector<Covered> columns = covered_by(width, next_width), rows = covered_by(height, next_height);
  const Light<T> light(kind);
  tbb::parallel_for(tbb::blocked_range<int>(0, next_height, 16), [&](const tbb::blocked_range<int>& range) {
    std::vector<float> sums(size_t(width) * 4);
    for (int y = range.begin(); y < range.end(); ++y) {
      std::fill(sums.begin(), sums.end(), 0.0f);
      const Covered& row = rows[size_t(y)];
      for (int k = 0; k < row.count; ++k) {
        const T* texel = in + size_t(row.first + k) * size_t(width) * 4;
        for (size_t x = 0; x < size_t(width) * 4; x += 4, texel += 4) {
          float value[4];
          light.decode(texel, value);
          for (size_t c = 0; c < 4; ++c) sums[x + c] += row.shares[size_t(k)] * value[c];
        }
      }
      for (int x = 0; x < next_width; ++x) {
        const Covered& column = columns[size_t(x)];
        float mean[4] = {0.0f, 0.0f, 0.0f, 0.0f};
        for (int k = 0; k < column.count; ++k)
          for (size_t c = 0; c < 4; ++c) mean[c] += column.shares[size_t(k)] * sums[size_t(column.first + k) * 4 + c];
        light.encode(mean, out + (size_t(y) * size_t(next_width) + size_t(x)) * 4);
      }
    }
  });
  return next;
}

}  // namespace

std::vector<uint8_t> next_level(const std::vector<uint8_t>& texels, int width, int height, TexelKind kind) {
  switch (kind.storage) {
    case Texture::Storage::Byte: return halved<uint8_t>(texels, width, height, kind);
    case Texture::Storage::Short: return halved<uint16_t>(texels, width, height, kind);
    case Texture::Storage::Half: return halved<Half>(texels, width, height, kind);
    default: return halved<float>(texels, width, height, kind);
  }
}

}  // namespace ajar
