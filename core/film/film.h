// The film: what every sample leaves behind, pixel by pixel.
//
// Samples are drawn from the pixel filter (importance sampling), so each belongs to one pixel with
// weight 1 and the mean over a pixel's samples is the filtered image. Paths that arrive
// from lights are splatted instead. Sums are double; non-finite samples are refused and counted.
// Pixels are rows from the bottom up over the render region.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "math/types.h"

namespace ajar {

/// Passes as Blender names them, with the channels the film keeps for each.
struct PassInfo {
  std::string name;
  int channels;
};
/// All passes the film knows; asking for another is an error that lists these.
const std::vector<PassInfo>& known_passes();

/// What one sample contributes besides its radiance; filled at the first hit.
struct SampleAux {
  float depth = 1e10f;
  Vec3 normal{0.0f}, position{0.0f}, uv{0.0f};
  Color albedo{0.0f};
};

class Film {
 public:
  Film() = default;
  /// x0..y1 is the region of the full frame that is rendered.
  Film(int x0, int y0, int x1, int y1, const std::vector<std::string>& passes);

  int width() const { return x1_ - x0_; }
  int height() const { return y1_ - y0_; }
  int x0() const { return x0_; }
  int y0() const { return y0_; }
  bool wants_aux() const { return wants_aux_; }

  /// One sample of pixel (x, y) of the full frame. Different pixels may be written by different threads.
  /// Returns false (and counts) when the sample is not finite.
  bool add_sample(int x, int y, Color radiance, float alpha, const SampleAux* aux);
  /// Samples so far: mean over the film, least and most of any pixel.
  struct SampleCounts {
    double mean;
    uint32_t least, most;
  };
  SampleCounts sample_counts() const;
  uint64_t refused() const { return refused_.load(); }

  /// Channels of a pass, resolved: width*height*channels floats.
  std::vector<float> resolve(const std::string& pass, float exposure) const;
  /// Relative mean squared error of the present image estimated from its two half buffers:
  /// mean((A-B)^2/4 / (M^2+0.01)) over pixels and channels. Negative when there are too few samples.
  double estimated_relmse() const;

 private:
  struct Pixel {
    double sum[3] = {0, 0, 0};
    double half[3] = {0, 0, 0};   ///< of the odd samples
    double sum_alpha = 0.0;
    double sum_luminance_squared = 0.0;
    uint32_t count = 0, half_count = 0;
  };
  struct AuxPixel {
    double depth = 0.0, normal[3] = {0, 0, 0}, position[3] = {0, 0, 0}, uv[3] = {0, 0, 0}, albedo[3] = {0, 0, 0};
    bool has_first = false;
  };
  int x0_ = 0, y0_ = 0, x1_ = 0, y1_ = 0;
  bool wants_aux_ = false;
  std::vector<Pixel> pixels_;
  std::vector<AuxPixel> aux_;
  std::atomic<uint64_t> refused_{0};
};

}  // namespace ajar
