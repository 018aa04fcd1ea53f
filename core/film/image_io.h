// Reads and writes image files, for tools, tests and the command-line program.
//
// In memory, images are linear floats, rows from the bottom up, as in the film. `.exr` files hold the same numbers.
// `.png` files hold 8 bits per channel, sRGB-encoded (alpha straight and not encoded).
#pragma once

#include <map>
#include <string>
#include <vector>

namespace ajar {

struct Image {
  int width = 0, height = 0, channels = 0;
  std::vector<float> pixels;
  std::vector<std::string> channel_names = {};  ///< as in the file; not needed for writing
};

/// Throws std::runtime_error with the name of the file.
Image read_image(const std::string& path);
/// The file extension selects the format. `metadata` is stored as text under each name.
void write_image(const std::string& path, const Image& image, const std::map<std::string, std::string>& metadata = {});

/// Version of the library that is loaded at run time.
std::string openimageio_version();

}  // namespace ajar
