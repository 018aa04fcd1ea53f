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

/// The networks of the library. For an image of 1920 x 1080 pixels with guides: 14, 3.2 or 1.7 seconds of a core (AMD
/// EPYC).
enum class DenoiseNetwork {
  Large,   ///< for guides without noise, which are denoised before
  Medium,  ///< for guides with noise
  Small    ///< likewise
};

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
  OpenImageDenoise(int width, int height, std::vector<float> albedo, std::vector<float> normal, DenoiseNetwork network,
                   int threads, const std::atomic<bool>& cancelled);
  ~OpenImageDenoise();
  OpenImageDenoise(const OpenImageDenoise&) = delete;

  /// The image without noise. `image`: linear RGB, non-negative.
  std::vector<float> operator()(std::vector<float> image) const;

 private:
  void run(const char* name, std::vector<float>& image, int quality) const;

  int width_, height_;
  DenoiseNetwork network_;
  const std::atomic<bool>& cancelled_;
  std::unique_ptr<Device> device_;
  std::vector<float> albedo_, normal_;
};

/// A network of the library for many images of one size. The library prepares it once, which takes longer than a small
/// image. Guides are not denoised before.
class PreparedDenoiser {
 public:
  /// `network`: not Large. Throws std::runtime_error if no library is loaded or if it fails.
  PreparedDenoiser(int width, int height, bool guided, DenoiseNetwork network, int threads);
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
