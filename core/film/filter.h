// Pixel reconstruction filters by importance sampling: every sample belongs to one pixel and is displaced
// by a draw from the filter, so that the plain mean is the filtered image (Ernst et al. 2006).
// All filters here are non-negative and separable. Their width is Blender's number, which Cycles stretches for
// filters that fall off smoothly, so that equal numbers look equally sharp: see full_width.
#pragma once

#include <cmath>
#include <vector>

#include "math/distribution.h"
#include "scene/scene_description.h"

namespace ajar {

class PixelFilter {
 public:
  PixelFilter() : PixelFilter(FilterKind::Box, 1.0f) {}
  PixelFilter(FilterKind kind, float width) : width_(full_width(kind, width)), box_(kind == FilterKind::Box) {
    if (box_) return;
    // Inverse of the cumulative filter, tabulated; piecewise linear between entries.
    constexpr int kFine = 32768;
    std::vector<double> cumulative(kFine + 1, 0.0);
    for (int i = 0; i < kFine; ++i) {
      const double x = ((double(i) + 0.5) / kFine - 0.5) * double(width_);
      cumulative[size_t(i) + 1] = cumulative[size_t(i)] + value(kind, x);
    }
    inverse_.resize(kEntries + 1);
    int cell = 0;
    for (int k = 0; k <= kEntries; ++k) {
      const double target = cumulative[kFine] * double(k) / kEntries;
      while (cell < kFine - 1 && cumulative[size_t(cell) + 1] < target) ++cell;
      const double mass = cumulative[size_t(cell) + 1] - cumulative[size_t(cell)];
      const double inside = mass > 0.0 ? (target - cumulative[size_t(cell)]) / mass : 0.5;
      inverse_[size_t(k)] = float(((double(cell) + inside) / kFine - 0.5) * double(width_));
    }
  }

  /// Pixels from end to end of a filter whose width in Blender is `width`.
  static float full_width(FilterKind kind, float width) {
    switch (kind) {
      case FilterKind::Box: return 1.0f;
      case FilterKind::Gaussian: return 3.0f * width;
      case FilterKind::BlackmanHarris: return 2.0f * width;
    }
    return width;
  }

  /// Displacement from the pixel's centre, in pixels.
  Vec2 sample(Vec2 u) const { return {sample_1d(u.x), sample_1d(u.y)}; }

  /// The unnormalised one-dimensional filter.
  double value(FilterKind kind, double x) const {
    if (std::abs(x) > 0.5 * double(width_)) return 0.0;
    switch (kind) {
      case FilterKind::Box: return 1.0;
      case FilterKind::Gaussian: {
        const double v = 6.0 * x / double(width_);
        return std::exp(-2.0 * v * v);
      }
      case FilterKind::BlackmanHarris: {
        const double v = 2.0 * 3.141592653589793 * (x / double(width_) + 0.5);
        return 0.35875 - 0.48829 * std::cos(v) + 0.14128 * std::cos(2.0 * v) - 0.01168 * std::cos(3.0 * v);
      }
    }
    return 0.0;
  }

 private:
  static constexpr int kEntries = 4096;   ///< tails of the Gaussian need them
  float sample_1d(float u) const {
    if (box_) return u - 0.5f;
    const float x = u * float(kEntries);
    const int i = std::min(int(x), kEntries - 1);
    const float f = x - float(i);
    return inverse_[size_t(i)] * (1.0f - f) + inverse_[size_t(i) + 1] * f;
  }

  float width_;
  bool box_;
  std::vector<float> inverse_;
};

}  // namespace ajar
