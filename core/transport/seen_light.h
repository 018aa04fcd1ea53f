// Light that the eye sees directly or by way of specular surfaces alone, the paths L S* E, sampled more often than the rest of a
// pixel's samples where that pays: beside the edge of a lamp, or of its image in a mirror, one sample of many meets it and outshines all
// others, while a ray that only looks for lamps costs little of a sample that goes on to light the surface.
//
// Each sample's own finding is replaced by its mean with those of k - 1 further camera rays, drawn alike. The k of a pixel follows from
// the samples before it alone, and every sample keeps the same weight in the picture, so its mean is unchanged. What makes the product of
// the picture's relMSE and its cost least is k_i = sqrt(w_i V_seen,i / <w V_rest> * C_rest / C_seen), as for splitting [Arvo and Kirk 1990]:
// variances V of one ray, from pixels around and a little from all that show mirrors; w = 1 / (mean^2 + 0.01); costs C in rays. Further rays stay
// below a share of all. Decided after 2, 4, 8, ... samples.
#pragma once

#include <vector>

#include "film/filter.h"
#include "film/film.h"
#include "sampling/sampler.h"
#include "scene/scene.h"

namespace ajar {

/// Light found by one camera ray that goes on at delta lobes only; W / (sr m^2). Nothing in a scene with media. Draws from dimension 4 of `sampler`.
Color trace_seen_light(const Scene& scene, Ray ray, Sampler& sampler, uint64_t& rays);

class SeenLight {
 public:
  /// For the pixels of `film`, whose samples are drawn from `filter`.
  void prepare(const Scene& scene, const Film& film, const PixelFilter& filter, uint32_t seed);
  /// Not in scenes with media, nor where nothing shines.
  bool active() const { return !pixels_.empty(); }
  /// Mean of `found`, what a sample of this pixel of the full frame has found of such light, and of further rays. `rest`: luminance of the
  /// same sample's other light, in the picture; `rays` counts. From any thread that has the pixel to itself.
  Color mean_with(Color found, float rest, int x, int y, uint64_t& rays);
  /// Between samples, when every pixel has had `samples`, which took so many rays altogether: their own, and those counted by mean_with.
  void learn(uint32_t samples, uint64_t rays_of_rest, uint64_t rays_of_seen);
  /// Rays that a sample of this pixel of the full frame has for it, its own among them.
  int rays_of(int x, int y) const { return pixels_[index_of(x, y)].rays; }

  static uint64_t bytes_per_pixel() { return sizeof(Pixel); }

 private:
  /// Sums over rays, and over samples.
  struct Pixel {
    float seen = 0.0f, seen_squared = 0.0f, rest = 0.0f, rest_squared = 0.0f;   ///< non-finite ones left out: the film refuses and counts them
    uint32_t looked = 0, samples = 0;
    uint16_t rays = kFirstRays;
    bool mirrors = false;         ///< a ray has gone on
  };
  static constexpr uint16_t kFirstRays = 4, kMostRays = 64;
  size_t index_of(int x, int y) const { return size_t(y - y0_) * size_t(width_) + size_t(x - x0_); }
  /// Variances of one ray's light and of one sample's rest, over squared luminance + 0.01: all means over the pixels around. `mirrors`: over all of them.
  void relative_variances(int x, int y, double in_mirrors, double& seen, double& rest) const;

  const Scene* scene_ = nullptr;
  PixelFilter filter_;
  uint32_t seed_ = 0;
  int x0_ = 0, y0_ = 0, width_ = 0, height_ = 0;
  std::vector<Pixel> pixels_;
};

}  // namespace ajar
