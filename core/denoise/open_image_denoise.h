// The library Open Image Denoise 2, which is loaded at run time: the one that the process has already, or a file.
//
// The core does not link to it. Blender has a copy of its own in the same process, and a second copy could conflict
// with it. The library is a neural network: its image is smooth and biased (denoise/denoise.h makes it consistent).
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace ajar {

class OpenImageDenoise {
 public:
  /// Loads the library from this file. Throws std::runtime_error with the reason. A second call has no effect.
  static void load(const std::string& file);
  /// Its version, such as "2.5.1"; empty if no library is loaded.
  static std::string version();

  /// For images of this size, with guides of the same size: RGB of the albedo in [0, 1] and the normal in [-1, 1]. The
  /// guides are denoised first. Empty guides are not used. Throws std::runtime_error if no library is loaded.
  OpenImageDenoise(int width, int height, std::vector<float> albedo, std::vector<float> normal, int threads);
  ~OpenImageDenoise();
  OpenImageDenoise(const OpenImageDenoise&) = delete;

  /// The image without noise. `image`: linear RGB, non-negative.
  std::vector<float> operator()(std::vector<float> image) const;

 private:
  struct Device;
  void run(const char* name, std::vector<float>& image, bool with_guides) const;

  int width_, height_;
  std::unique_ptr<Device> device_;
  std::vector<float> albedo_, normal_;
};

}  // namespace ajar
