// The film: what every sample leaves behind, pixel by pixel.
//
// Samples are drawn from the pixel filter (importance sampling), so each belongs to one pixel with
// weight 1 and the mean over a pixel's samples is the filtered image. Paths that arrive
// from lights are splatted instead: from any thread, in any order. Sums are double; non-finite samples are refused and
// counted.
//
// Splats are summed in 64-bit integers, so that their sum does not depend on the order of threads, after which
// `end_splats` moves it to doubles. Their unit is 2^-60 for those below 2^-20, 1 for those above 2^20, 2^-32 for
// others; what exceeds 2^52 is refused. Any number of them may arrive: what would not fit is carried. The image is the
// mean of the samples plus the sum of splats times the splat scale. Pixels are rows from the bottom up over the render
// region.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "film/early_samples.h"
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
  float mist = 1.0f;  ///< 0 near, 1 far
  float object_index = 0.0f, material_index = 0.0f;
  /// Of a learned mixture: BSDF, first and second light or half of the light tree, cone, and the BSDF's lobes from the
  /// widest to the sharpest.
  std::array<float, 7> shares{};
};

/// A sample's radiance taken apart, as Blender's passes have it: what is seen directly, and what the first surface
/// scatters by each kind of lobe (diffuse, glossy, transmission), or a volume before it, of light that arrives there
/// directly or indirectly. All parts together are its radiance.
struct SampleParts {
  Color emission{0.0f}, environment{0.0f};
  std::array<Color, 3> direct{Color(0.0f), Color(0.0f), Color(0.0f)}, indirect{Color(0.0f), Color(0.0f), Color(0.0f)};
  std::array<Color, 3> color{Color(0.0f), Color(0.0f), Color(0.0f)};  ///< albedo, by which Blender divides the others
  std::array<Color, 2> volume{Color(0.0f), Color(0.0f)};  ///< direct and indirect light that a volume scatters first
};
/// Whether a pass is made of SampleParts, which not all integrators can tell.
bool is_part_pass(const std::string& pass);

class Film {
 public:
  Film() = default;
  /// x0..y1 is the region of the full frame that is rendered.
  Film(int x0, int y0, int x1, int y1, const std::vector<std::string>& passes);

  /// What a film with these passes takes, at most; `splats`: with light that arrives from anywhere.
  static uint64_t bytes_per_pixel(const std::vector<std::string>& passes, bool splats);
  uint64_t memory_bytes() const;
  int width() const { return x1_ - x0_; }
  int height() const { return y1_ - y0_; }
  int x0() const { return x0_; }
  int y0() const { return y0_; }
  bool wants_aux() const { return wants_aux_; }
  bool wants_parts() const { return !parts_.empty(); }

  /// One sample of pixel (x, y) of the full frame. Different pixels may be written by different threads.
  /// Returns false (and counts) when the sample is not finite.
  bool add_sample(int x, int y, Color radiance, float alpha, const SampleAux* aux);
  /// The parts of the sample just added to this pixel.
  void add_parts(int x, int y, const SampleParts& parts);
  /// Samples of this pixel of the full frame so far: the index of its next one.
  uint32_t samples_of(int x, int y) const { return pixels_[index_of(x, y)].count; }
  /// How many samples each pixel shall have, in the film's order; none: the same for all. Luminances of samples
  /// up to there are remembered as `early_samples`.
  void set_goals(std::vector<uint32_t> goals);
  const std::vector<uint32_t>& goals() const { return goals_; }
  /// What this pixel shall have, where all others shall have `uniform` if nobody set goals.
  uint32_t goal_of(int x, int y, uint32_t uniform) const { return goals_.empty() ? uniform : goals_[index_of(x, y)]; }
  EarlySamples& early_samples() { return early_; }
  /// Make room for splats; once, before the first.
  void enable_splats();
  /// What arrives at pixel (x, y) of the full frame from a light, from any thread; outside the region it is ignored.
  /// `odd` tells apart two independent halves of all splats, for the estimate of the error.
  void add_splat(int x, int y, Color value, bool odd);
  /// Between iterations: everything splatted so far, times `scale`, is the splatted part of the image
  /// (scale: one over the number of light paths a pixel, say).
  void end_splats(double scale);
  /// Samples so far: mean over the film, least and most of any pixel.
  struct SampleCounts {
    double mean;
    uint32_t least, most;
  };
  SampleCounts sample_counts() const;
  uint64_t refused() const { return refused_.load(); }

  /// Channels of a pass, resolved: width*height*channels floats.
  std::vector<float> resolve(const std::string& pass, float exposure) const;
  /// Keep the image as it is with `samples` for the average pixel: from how it changes, errors are estimated.
  void remember(uint32_t samples);
  /// Of the present image of `samples` for the average pixel: relative mean squared error, and mean of e^2 / tvi(M) in
  /// cd/m^2 (film/tvi.h). Negative when there are too few samples. Good to some 15 % where samples are many enough to
  /// have seen what there is to see; rare bright paths that nobody has found yet are in no estimate.
  struct ErrorEstimate {
    double relmse, perceptual;
  };
  ErrorEstimate estimated_error(uint32_t samples) const;
  /// For few samples: relative mean squared error of the present image, estimated: mean of variance / (M^2 + 0.01) over
  /// pixels and channels, the variance from two half buffers, (A-B)^2 / 4, scaled as a whole to the scatter of
  /// luminances where there are no splats: halves of a stratified sequence differ more than independent ones would.
  /// Negative when there are too few samples.
  double estimated_relmse() const { return estimated_error_of_few().relmse; }
  /// The same of luminance against what an eye can see.
  double estimated_perceptual_error() const { return estimated_error_of_few().perceptual; }

 private:
  struct Pixel {
    double sum[3] = {0, 0, 0};
    double half[3] = {0, 0, 0};  ///< of the odd samples
    double sum_alpha = 0.0;
    double sum_luminance_squared = 0.0;
    uint32_t count = 0, half_count = 0;
  };
  struct AuxPixel {
    double depth = 0.0, normal[3] = {0, 0, 0}, position[3] = {0, 0, 0}, uv[3] = {0, 0, 0}, albedo[3] = {0, 0, 0},
           shares[7] = {}, mist = 0.0;
    float object_index = 0.0f, material_index = 0.0f;
    bool has_first = false;
  };
  struct PartsPixel {
    double emission[3] = {0, 0, 0}, environment[3] = {0, 0, 0}, direct[3][3] = {}, indirect[3][3] = {},
           color[3][3] = {}, volume[2][3] = {};
  };
  struct SplatPixel {
    double sum[2][3] = {};  ///< even, odd
  };
  struct PendingPixel {
    std::atomic<int64_t> sum[2][3]{};  ///< even, odd; in units of their range
  };
  /// Splats of one range of sizes, made when there is the first.
  struct PendingSplats {
    std::once_flag made;
    std::unique_ptr<PendingPixel[]> pixels;
    std::mutex carrying;
    std::map<size_t, int64_t> carried;  ///< by number of the sum: how often 2^62 was taken out of it
  };
  PendingSplats& pending_of(float largest, double& units);
  static void carry(PendingSplats& splats, size_t index, bool odd, int channel);
  size_t index_of(int x, int y) const { return size_t(y - y0_) * size_t(width()) + size_t(x - x0_); }
  struct Remembered {
    uint32_t samples;
    std::array<std::vector<float>, 3> image;
  };
  std::array<std::vector<float>, 3> means() const;
  void make_likely(size_t index, const double around[3], double value[3]) const;
  void sums_around(const std::vector<float>& image, int y, std::vector<double>& columns,
                   std::vector<double>& sums) const;
  ErrorEstimate estimated_error_of_few() const;
  ErrorEstimate error_from_pictures(const Remembered& one, const Remembered& two, uint32_t samples) const;
  static double scatter_variance(const Pixel& pixel);
  bool has_halves(const Pixel& pixel) const;
  bool halves_of(size_t index, double mean[3], double difference[3]) const;
  std::vector<float> variance_of_mean() const;
  double splatted(size_t index, int channel) const {
    return splats_ ? (splats_[index].sum[0][channel] + splats_[index].sum[1][channel]) * splat_scale_ : 0.0;
  }
  std::unique_ptr<SplatPixel[]> splats_;
  std::array<PendingSplats, 3> pending_;
  double splat_scale_ = 0.0;
  int x0_ = 0, y0_ = 0, x1_ = 0, y1_ = 0;
  bool wants_aux_ = false;
  std::vector<Pixel> pixels_;
  std::vector<AuxPixel> aux_;
  std::vector<PartsPixel> parts_;
  static constexpr size_t kMaxRemembered = 3;
  std::vector<Remembered> remembered_;  // the latest last
  std::vector<uint32_t> goals_;
  EarlySamples early_;
  std::atomic<uint64_t> refused_{0};
};

}  // namespace ajar
