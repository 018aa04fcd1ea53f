// The error of the image that the artist sees when it is denoised, estimated during the render.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

namespace ajar {

/// When the error of the denoised image is estimated: after fixed numbers of samples, so that the end of the render
/// does not depend on the clock.
class ShownErrorSchedule {
 public:
  bool due(uint64_t samples) const { return samples >= next_; }
  void looked_at(uint64_t samples) { next_ = samples + samples / 4; }

 private:
  uint64_t next_ = 16;
};

/// Passes of the film, as `Film::resolve` gives them. Guides and direct halves that were not asked for are empty.
struct DenoiserInput {
  std::vector<float> combined, halves, direct_halves, albedo, normal;
  int width = 0, height = 0;
  std::vector<bool> biased;  ///< of each technique of the halves; empty: none is
  float exposure = 1.0f;     ///< light times this is displayed
};

/// The relMSE of the denoised image (denoise/denoise.h), from the fastest quality. Negative if no denoiser is loaded,
/// if it fails, if a pixel has one sample, or if `stop` is set meanwhile.
double shown_relmse(const DenoiserInput& input, int threads, const std::atomic<bool>& stop);
/// The same for each technique of the halves, without direct halves; empty instead of negative.
std::vector<double> relmse_of_techniques(const DenoiserInput& input, int threads, const std::atomic<bool>& stop);

}  // namespace ajar
