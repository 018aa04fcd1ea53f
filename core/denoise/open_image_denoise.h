// The library Open Image Denoise 2, which is loaded at run time: the one that the process has already, or a file.
//
// The core does not link to it. Blender has a copy of its own in the same process, and a second copy could conflict
// with it. The library is a neural network: its image is smooth and biased (denoise/denoise.h makes it consistent).
#pragma once

#include <atomic>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace ajar {

/// Time against error. For an image of 1920 x 1080 pixels with guides: 11, 1.6 or 0.8 seconds on two cores (AMD EPYC).
enum class DenoiseQuality {
  High,      ///< the guides are denoised first; a network for guides without noise
  Balanced,  ///< a network for guides with noise
  Fast,      ///< the same, smaller
  Fastest    ///< as Fast; direct light is not denoised apart
};

/// The best quality that takes at most a tenth of a render with this number of rays, or `free_seconds` of a core. It
/// follows from fixed costs, not from the clock: frames of different machines agree. `separates`: direct light is
/// denoised apart, which takes twice the time, except by Fastest.
DenoiseQuality denoise_quality_for(double rays, double pixels, double free_seconds, bool separates);
/// Seconds of a core that this quality is expected to take. As `denoise_quality_for` assumes.
double denoise_seconds(DenoiseQuality quality, double pixels, bool separates);
constexpr double kDenoiseSecondsPerRay = 0.5e-6;  ///< of a core, as `denoise_quality_for` assumes

/// Thrown when `cancelled` is set while the library runs.
class DenoisingCancelled : public std::runtime_error {
 public:
  DenoisingCancelled() : std::runtime_error("Denoising was cancelled.") {}
};

class OpenImageDenoise {
 public:
  struct Device;

  /// Loads the library from this file. Throws std::runtime_error with the reason. A second call has no effect.
  static void load(const std::string& file);
  /// Its version, such as "2.5.1"; empty if no library is loaded.
  static std::string version();

  /// For images of this size, with guides of the same size: RGB of the albedo in [0, 1] and the normal in [-1, 1]. Empty
  /// guides are not used. `cancelled` may be set by another thread. Throws std::runtime_error if no library is loaded.
  OpenImageDenoise(int width, int height, std::vector<float> albedo, std::vector<float> normal, DenoiseQuality quality,
                   int threads, const std::atomic<bool>& cancelled);
  ~OpenImageDenoise();
  OpenImageDenoise(const OpenImageDenoise&) = delete;

  /// The image without noise. `image`: linear RGB, non-negative.
  std::vector<float> operator()(std::vector<float> image) const;

 private:
  void run(const char* name, std::vector<float>& image, int quality) const;

  int width_, height_;
  DenoiseQuality quality_;
  const std::atomic<bool>& cancelled_;
  std::unique_ptr<Device> device_;
  std::vector<float> albedo_, normal_;
};

/// A network of the library for many images of one size. The library prepares it once, which takes longer than a small
/// image. Guides are not denoised before.
class PreparedDenoiser {
 public:
  /// `quality`: Balanced or Fast. Throws std::runtime_error if no library is loaded or if it fails.
  PreparedDenoiser(int width, int height, bool guided, DenoiseQuality quality, int threads);
  ~PreparedDenoiser();
  PreparedDenoiser(const PreparedDenoiser&) = delete;

  /// Takes the guides of the next images. They are empty if there are none.
  void set_guides(const std::vector<float>& albedo, const std::vector<float>& normal);
  /// The image without noise, as OpenImageDenoise gives it.
  std::vector<float> operator()(std::vector<float> image, const std::atomic<bool>& cancelled);

 private:
  std::unique_ptr<OpenImageDenoise::Device> device_;
  std::vector<float> image_, albedo_, normal_;  ///< of the filter, which keeps their addresses
  void* filter_;
};

}  // namespace ajar
