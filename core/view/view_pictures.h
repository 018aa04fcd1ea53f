// The denoised pictures of a 3D view: their resolutions, when the next one is made, and the networks that are kept.
//
// After a change of the view, the first picture has a resolution at which one sample and the network take a tenth of a
// second, by what both took before. Finer pictures follow, then pictures of more samples. Where a sample of all pixels
// takes long, light of half the resolution is shown on the surfaces of the full one before. The first ones come from one
// run of the network; from `kConsistentSamples` on, they are combined with the halves (denoise/denoise.h).
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "denoise/open_image_denoise.h"
#include "denoise/shown_error.h"

namespace ajar {

/// A picture for the 3D view.
struct ViewPicture {
  uint64_t render = 0;        ///< number of the render to which it belongs
  uint64_t iteration = 0;     ///< of the render
  double samples = 0.0;       ///< per pixel
  int divider = 1;            ///< pixels of the view for one of the picture, along a side
  bool coarse_light = false;  ///< made of coarser light on the surfaces of this picture (view/surface_detail.h)
  int width = 0, height = 0;
  std::string not_denoised;  ///< why; empty: it is denoised
  std::vector<float> rgba;   ///< rows from the bottom up
};

/// Part of an image that has one pixel for `divider` squared pixels of the view.
struct ViewSize {
  int width, height;
  std::array<int, 4> region;  ///< left, bottom, right, top
};
ViewSize divided(int width, int height, const std::array<int, 4>& region, int divider);

/// A step from coarse to fine.
struct ViewLevel {
  int divider;    ///< of the light
  bool surfaces;  ///< the picture has the size of the view, with its surfaces
};

/// Chooses resolutions by measured times.
class ViewSchedule {
 public:
  static constexpr int kCoarsest = 16;
  static constexpr double kFirstSeconds = 0.09;  ///< for the first picture; Blender draws it in the rest of 0.15 s
  static constexpr double kNextSeconds = 0.4;    ///< for the next one, if it is not the full picture of a sample

  void rendered(double pixels, double samples, double seconds);
  void denoised(double pixels, double seconds);
  /// Seconds until a picture of one sample with this number of pixels.
  double expected_seconds(double pixels) const { return pixels * (seconds_of_sample_ + seconds_of_network_); }
  /// The first picture of a view with this number of pixels, and the one after a picture.
  ViewLevel first(double pixels) const;
  /// `guided`: there are guides, so that a picture can have the surfaces of the view.
  ViewLevel finer(ViewLevel level, double pixels, bool guided) const;

 private:
  double seconds_of_sample_ = 1e-6, seconds_of_network_ = 1e-6;  // for one pixel
};

/// Denoises pictures. One thread uses it.
class ViewDenoiser {
 public:
  /// With 16 samples, one run of the network still had the smaller error (docs/research/viewport.md).
  static constexpr double kConsistentSamples = 32.0;

  /// The picture of `input`, RGBA. `rays`: of the render so far, for the quality. Throws as OpenImageDenoise does.
  std::vector<float> operator()(const DenoiserInput& input, double samples, double rays, int threads,
                                const std::atomic<bool>& stop);
  /// Forgets the networks that are kept.
  void clear() { kept_.clear(); }

 private:
  struct Kept {
    int width, height, threads;
    bool guided;
    DenoiseNetwork kind;
    std::unique_ptr<PreparedDenoiser> network;
  };
  PreparedDenoiser& network_for(const DenoiserInput& input, DenoiseNetwork kind, int threads);
  std::list<Kept> kept_;  // the latest first
};

}  // namespace ajar
