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
  Fast       ///< the same, smaller
};

/// Thrown when `cancelled` is set while the library runs.
class DenoisingCancelled : public std::runtime_error {
 public:
  DenoisingCancelled() : std::runtime_error("Denoising was cancelled.") {}
};

class OpenImageDenoise {
 public:
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
  struct Device;
  void run(const char* name, std::vector<float>& image, int quality) const;

  int width_, height_;
  DenoiseQuality quality_;
  const std::atomic<bool>& cancelled_;
  std::unique_ptr<Device> device_;
  std::vector<float> albedo_, normal_;
};

}  // namespace ajar
