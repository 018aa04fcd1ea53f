// Moments and rays of the first 2^k samples of every pixel, for every k that can still be needed.
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
    float sum = 0.0f, sum_squared = 0.0f, rays = 0.0f;
  };

  bool enabled() const { return !octaves_.empty(); }
  /// Allocates memory for samples with indices below `end`. No other thread may write at the same time.
  void reserve(size_t pixels, uint32_t end) {
    const size_t wanted = size_t(std::bit_width(std::max(1u, end) - 1)) + 1;
    while (octaves_.size() < wanted) octaves_.emplace_back(pixels);
  }
  void add(size_t pixel, uint32_t number, float y) {
    Moments* const m = of(pixel, number);
    if (!m) return;
    y = std::clamp(y, -1e15f, 1e15f);  // so that its square is finite
    m->sum += y;
    m->sum_squared += y * y;
  }
  void add_rays(size_t pixel, uint32_t number, uint64_t rays) {
    if (Moments* const m = of(pixel, number)) m->rays += float(rays);
  }
  /// Joins the octaves below `end`, a power of two that all pixels have reached. `first` then returns their sum, and
  /// memory is freed.
  void join(uint32_t end) {
    const size_t last = size_t(std::bit_width(end - 1));
    for (; joined_ < last; ++joined_) {
      std::vector<Moments>&from = octaves_[joined_], &to = octaves_[joined_ + 1];
      for (size_t i = 0; i < to.size(); ++i) {
        to[i].sum += from[i].sum;
        to[i].sum_squared += from[i].sum_squared;
        to[i].rays += from[i].rays;
      }
      std::vector<Moments>().swap(from);
    }
  }
  /// Moments of the samples below the `end` of the last join.
  const Moments& first(size_t pixel) const { return octaves_[joined_][pixel]; }

 private:
  /// Null if the sample with this number is not needed any more.
  Moments* of(size_t pixel, uint32_t number) {
    const size_t octave = size_t(std::bit_width(number));
    return octave < octaves_.size() && !octaves_[octave].empty() ? &octaves_[octave][pixel] : nullptr;
  }

  std::vector<std::vector<Moments>> octaves_;
  size_t joined_ = 0;
};

}  // namespace ajar
