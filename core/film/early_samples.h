// Moments of the first 2^k samples of every pixel, for every k that can still be needed, and the rays of its first samples.
//
// Adaptive sampling must know which samples of a pixel it uses. "The first b" is a set that does not depend on how many
// samples the pixel gets later. Samples are summed by octave of their index (0; 1; 2-3; 4-7; ...), so that b can grow
// after pixels have passed it. Different pixels may be written by different threads.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ajar {

class EarlySamples {
 public:
  struct Moments {
    float sum = 0.0f, sum_squared = 0.0f;
  };
  /// Rays are counted for this number of samples, which all pixels soon have: they vary less than the light.
  static constexpr uint32_t kRaySamples = 4;
  /// Maximum memory. Octaves are kept from the `end` of the last join up to the highest goal, which is far above it for
  /// few pixels only.
  static constexpr size_t kMaxBytesPerPixel = 8 * sizeof(Moments) + 2 * sizeof(float);

  bool enabled() const { return !octaves_.empty(); }
  uint64_t memory_bytes() const {
    uint64_t bytes = (rays_.size() + first_halves_.size()) * sizeof(float);
    for (const std::vector<Moments>& octave : octaves_) bytes += octave.size() * sizeof(Moments);
    return bytes;
  }
  /// Allocates memory for samples with indices below `end`. No other thread may write at the same time.
  void reserve(size_t pixels, uint32_t end) {
    const size_t wanted = size_t(std::bit_width(std::max(1u, end) - 1)) + 1;
    while (octaves_.size() < wanted) octaves_.emplace_back(pixels);
    rays_.resize(pixels);
  }
  void add(size_t pixel, uint32_t number, float y) {
    const size_t octave = size_t(std::bit_width(number));
    if (octave >= octaves_.size() || octaves_[octave].empty()) return;
    y = std::clamp(y, -1e15f, 1e15f);  // so that its square is finite
    Moments& m = octaves_[octave][pixel];
    m.sum += y;
    m.sum_squared += y * y;
  }
  void add_rays(size_t pixel, uint32_t number, uint64_t rays) {
    if (number < kRaySamples) rays_[pixel] += float(rays);
  }
  /// Joins the octaves below `end`, a power of two that all pixels have reached. `first` then returns their sum, and
  /// memory is freed.
  void join(uint32_t end) {
    const size_t last = size_t(std::bit_width(end - 1));
    for (; joined_ < last; ++joined_) {
      std::vector<Moments>&from = octaves_[joined_], &to = octaves_[joined_ + 1];
      if (joined_ + 1 == last) {
        first_halves_.resize(from.size());
        std::transform(from.begin(), from.end(), first_halves_.begin(), [](const Moments& m) { return m.sum; });
      }
      for (size_t i = 0; i < to.size(); ++i) {
        to[i].sum += from[i].sum;
        to[i].sum_squared += from[i].sum_squared;
      }
      std::vector<Moments>().swap(from);
    }
  }
  /// Moments of the samples below the `end` of the last join.
  const Moments& first(size_t pixel) const { return octaves_[joined_][pixel]; }
  /// Sum of the first half of these samples; `end` was at least 2.
  float first_half(size_t pixel) const { return first_halves_[pixel]; }

  /// Mean number of rays of the first samples. All pixels must have `end` samples; while that is below kRaySamples, none
  /// may have more.
  float mean_rays(size_t pixel, uint32_t end) const { return rays_[pixel] / float(std::min(end, kRaySamples)); }

 private:
  std::vector<std::vector<Moments>> octaves_;
  std::vector<float> rays_, first_halves_;
  size_t joined_ = 0;
};

}  // namespace ajar
