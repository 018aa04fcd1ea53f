// Pictures to and from files, for tools, tests and the command-line program.
//
// In memory: linear floats, rows from the bottom up, as the film gives them. `.exr` files hold the same
// numbers; `.png` files hold 8 bits per channel, sRGB-encoded (alpha straight and not encoded).
#pragma once

#include <map>
#include <string>
#include <vector>

namespace ajar {

struct Image {
  int width = 0, height = 0, channels = 0;
  std::vector<float> pixels;
  std::vector<std::string> channel_names = {};  ///< as the file has them; not needed to write
};

/// Throws std::runtime_error naming the file.
Image read_image(const std::string& path);
/// The ending chooses the format. `metadata` is stored as text under each name.
void write_image(const std::string& path, const Image& image, const std::map<std::string, std::string>& metadata = {});

/// Of the library found at run time.
std::string openimageio_version();

}  // namespace ajar
