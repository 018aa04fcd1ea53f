// Pixel reconstruction filters by importance sampling. Every sample belongs to one pixel and is displaced by a draw
// from the filter, so that the plain mean is the filtered image (Ernst et al. 2006).
// A path from a light that arrives at a point of the film belongs to every pixel whose filter covers the point. `place`
// picks one of them in proportion to the filters. It returns the sum of these filters at the point, so that splats have
// the same mean as samples.
// All filters are non-negative and separable. Their width is Blender's value. Cycles stretches filters that fall off
// smoothly, so that equal values look equally sharp: see full_width.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "description/scene_description.h"
#include "math/distribution.h"

namespace ajar {

class PixelFilter {
 public:
  PixelFilter() : PixelFilter(FilterKind::Box, 1.0f) {}
  PixelFilter(FilterKind kind, float width) : width_(full_width(kind, width)), box_(kind == FilterKind::Box) {
    if (box_) return;
    double integral = 0.0;
    for (int i = 0; i < kDensityEntries; ++i) {
      const double x = (double(i) / (kDensityEntries - 1) - 0.5) * double(width_);
      density_[size_t(i)] = float(value(kind, x * (1.0 - 1e-9)));
      integral += double(density_[size_t(i)]) * (i == 0 || i == kDensityEntries - 1 ? 0.5 : 1.0) * double(width_) /
                  (kDensityEntries - 1);
    }
    for (float& d : density_) d = float(double(d) / integral);
    // The inverse of the cumulative filter as a table, piecewise linear between entries.
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

  /// Full width in pixels of a filter whose width in Blender is `width`.
  static float full_width(FilterKind kind, float width) {
    switch (kind) {
      case FilterKind::Box: return 1.0f;
      case FilterKind::Gaussian: return 3.0f * width;
      case FilterKind::BlackmanHarris: return 2.0f * width;
    }
    return width;
  }

  /// Displacement from the centre of the pixel, in pixels.
  Vec2 sample(Vec2 u) const { return {sample_1d(u.x), sample_1d(u.y)}; }

  float half_width() const { return 0.5f * width_; }
  /// The normalised filter along one axis, per pixel.
  float density(float x) const {
    const float place = (x / width_ + 0.5f) * float(kDensityEntries - 1);
    if (box_) return place >= 0.0f && place < float(kDensityEntries - 1) ? 1.0f : 0.0f;
    if (!(place >= 0.0f && place < float(kDensityEntries - 1))) return 0.0f;
    const int i = int(place);
    return density_[size_t(i)] + (place - float(i)) * (density_[size_t(i) + 1] - density_[size_t(i)]);
  }
  /// The pixel (lower <= pixel < upper) to which a point of the film is splatted, and the sum of the filters of all
  /// pixels there (0: no filter covers the point).
  struct Place {
    int pixel;
    float weight;
  };
  Place place(float film, int lower, int upper, float u) const {
    const int first = std::max(lower, int(std::ceil(film - 0.5f - half_width()))),
              last = std::min(upper - 1, int(std::floor(film - 0.5f + half_width())));
    float sum = 0.0f;
    for (int i = first; i <= last; ++i) sum += density(film - 0.5f - float(i));
    if (!(sum > 0.0f)) return {0, 0.0f};
    float left = u * sum;
    int chosen = first;
    for (; chosen < last; ++chosen) {
      const float d = density(film - 0.5f - float(chosen));
      if (left < d) break;
      left -= d;
    }
    return {chosen, sum};
  }

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
  static constexpr int kDensityEntries = 2049;
  static constexpr int kEntries = 4096;  ///< needed by the tails of the Gaussian
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
  std::array<float, kDensityEntries> density_{};
};

}  // namespace ajar
