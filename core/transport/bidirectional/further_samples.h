// Draws a part of a sample more often than the rest, in the pixels where this is efficient. At the edge of a lamp, or
// of its image in a polished surface, few samples hit the lamp, and they have large values. A sample that only looks
// for lamps is cheap compared with one that also gathers light or mutates paths.
//
// The part of each sample is replaced by its mean with k - 1 further samples of the same distribution. The k of a pixel
// depends only on earlier samples, and all samples have equal weights in the image, so the expectation does not change.
// The k that minimizes the product of the image's relMSE and its cost is
//   k_i = sqrt(w_i V_part,i / <w V_rest> * C_rest / C_part),
// as for splitting [Arvo and Kirk 1990]. V are variances of one sample, from the pixels around and, with a small
// weight, from all pixels that show polished surfaces. w = 1 / (mean^2 + 0.01). C are costs in rays. The number of
// further rays is at most a given share of the rest's rays. The k are updated after 2, 4, 8, ... samples.
#pragma once

#include <cmath>
#include <vector>

#include "film/film.h"
#include "film/filter.h"
#include "sampling/sampler.h"
#include "scene/scene.h"

namespace ajar {

class FurtherSamples {
 public:
  struct Limits {
    uint16_t first;    ///< k before the first update
    double max_share;  ///< maximum number of further rays, relative to the rays of the rest
  };
  /// For the pixels of `film`, whose samples are drawn from `filter`.
  void prepare(const Scene& scene, const Film& film, const PixelFilter& filter, uint32_t seed, Limits limits);
  /// False in scenes with media and in scenes without lights.
  bool active() const { return !pixels_.empty(); }
  /// Returns the mean of `found`, the part of a sample of this pixel of the full frame, and of further samples of the
  /// part. draw(film, sampler) draws one at a position on the film. `polished`: the sample reached delta or sharp
  /// lobes. `rest`: luminance of its other light. Only one thread at a time may call this for the same pixel.
  template <class Draw>
  Color mean_with(Color found, bool polished, float rest, int x, int y, Draw&& draw) {
    Pixel& pixel = pixels_[index_of(x, y)];
    pixel.polished |= polished;
    pixel.note(found, exposure_);
    rest *= exposure_;
    if (std::isfinite(rest)) pixel.rest += rest, pixel.rest_squared += rest * rest;
    ++pixel.samples;
    if (pixel.taken <= 1) return found;
    Sampler sampler(Sampler::Kind::Sobol, seed_);
    Color sum = found;
    for (uint32_t i = 1; i < pixel.taken; ++i) {
      sampler.start(uint32_t(y) * uint32_t(full_width_) + uint32_t(x), pixel.looked - pixel.samples);
      const Vec2 at = Vec2(float(x) + 0.5f, float(y) + 0.5f) + filter_.sample(sampler.get_2d());
      const Color light = draw(at, sampler);
      pixel.note(light, exposure_);
      sum += light;
    }
    return sum / float(pixel.taken);
  }
  /// Called between samples, when every pixel has `samples` of them. `rays_of_rest` and `further_rays`: rays so far of
  /// the samples and of the further samples.
  void learn(uint32_t samples, uint64_t rays_of_rest, uint64_t further_rays);
  /// The k of this pixel of the full frame: how often a sample draws the part, including its own.
  int taken_at(int x, int y) const { return pixels_[index_of(x, y)].taken; }

  static uint64_t bytes_per_pixel() { return sizeof(Pixel); }

 private:
  static constexpr uint16_t kMax = 64;
  /// Sums over draws of the part, and over samples.
  struct Pixel {
    float part = 0.0f, part_squared = 0.0f, rest = 0.0f,
          rest_squared = 0.0f;  ///< sums without non-finite values, which the film refuses and counts
    uint32_t looked = 0, samples = 0;
    uint16_t taken = 1;
    bool polished = false;

    void note(Color light, float exposure) {
      const float value = exposure * luminance(light);
      if (std::isfinite(value)) part += value, part_squared += value * value;
      ++looked;
    }
  };
  size_t index_of(int x, int y) const { return size_t(y - y0_) * size_t(width_) + size_t(x - x0_); }
  /// Variance of one draw of the part and of one sample of the rest, over squared luminance + 0.01. All are means over
  /// the pixels around. `on_polished`: variance of the part, as a mean over all pixels that show polished surfaces.
  void relative_variances(int x, int y, double on_polished, double& part, double& rest) const;

  PixelFilter filter_;
  uint32_t seed_ = 0;
  int x0_ = 0, y0_ = 0, width_ = 0, height_ = 0, full_width_ = 0;
  float exposure_ = 1.0f;  ///< luminances are compared as displayed, so that units do not matter
  double max_share_ = 0.0;
  std::vector<Pixel> pixels_;
};

}  // namespace ajar
