// A part of every sample taken more often than the rest of it, in the pixels where that pays. Beside the edge of a
// lamp, or of its image in polished metal, one sample of many meets it and outshines all others, while what only looks
// for lamps costs little of a sample that goes on to gather or to mutate paths.
//
// Each sample's own finding is replaced by its mean with those of k - 1 further ones, drawn alike. The k of a pixel
// follows from the samples before it alone, and every sample keeps the same weight in the picture, so its mean is
// unchanged. What makes the product of the picture's relMSE and its cost least is k_i = sqrt(w_i V_part,i / <w V_rest>
// * C_rest / C_part), as for splitting [Arvo and Kirk 1990]: variances V of one sample, from pixels around and a little
// from all that show polished things; w = 1 / (mean^2 + 0.01); costs C in rays. Further rays stay below a share of the
// rest's. Decided after 2, 4, 8, ... samples.
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
    uint16_t first;    ///< how often a sample takes the part before anything is known
    double max_share;  ///< further rays over those of the rest
  };
  /// For the pixels of `film`, whose samples are drawn from `filter`.
  void prepare(const Scene& scene, const Film& film, const PixelFilter& filter, uint32_t seed, Limits limits);
  /// Not in scenes with media, nor where nothing shines.
  bool active() const { return !pixels_.empty(); }
  /// Mean of `found`, what a sample of this pixel of the full frame has found of the part, and of further ones:
  /// draw(film, sampler) is one at a place on the film. `polished`: the sample came to delta or sharp lobes; `rest`:
  /// luminance of its other light. From any thread that has the pixel to itself.
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
  /// Between samples, when every pixel has had `samples`, which took so many rays altogether: their own, and those of
  /// further ones.
  void learn(uint32_t samples, uint64_t rays_of_rest, uint64_t further_rays);
  /// How often a sample of this pixel of the full frame takes the part, once for itself.
  int taken_at(int x, int y) const { return pixels_[index_of(x, y)].taken; }

  static uint64_t bytes_per_pixel() { return sizeof(Pixel); }

 private:
  static constexpr uint16_t kMax = 64;
  /// Sums over takings of the part, and over samples.
  struct Pixel {
    float part = 0.0f, part_squared = 0.0f, rest = 0.0f,
          rest_squared = 0.0f;  ///< non-finite ones left out: the film refuses and counts them
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
  /// Variances of one taking of the part and of one sample's rest, over squared luminance + 0.01: all means over the
  /// pixels around. `on_polished`: the part's, over all pixels that show polished things.
  void relative_variances(int x, int y, double on_polished, double& part, double& rest) const;

  PixelFilter filter_;
  uint32_t seed_ = 0;
  int x0_ = 0, y0_ = 0, width_ = 0, height_ = 0, full_width_ = 0;
  float exposure_ = 1.0f;  ///< what is dim in the picture shown is no matter of units
  double max_share_ = 0.0;
  std::vector<Pixel> pixels_;
};

}  // namespace ajar
