// Reads image files with OpenImageIO, without any conversion of their values.
#pragma once

#include <string>
#include <vector>

#include "description/scene_description.h"
#include "shading/images/texture.h"

namespace ajar {

/// The values of an image. `error` states why there are none.
struct DecodedImage {
  int width = 0, height = 0, channels = 0;
  Texture::Storage storage = Texture::Storage::Byte;
  bool straight_alpha = false;  ///< the colour is not yet multiplied by alpha
  std::vector<uint8_t> values;  ///< `channels` per texel; rows go up from the bottom
  std::string error;
};

/// How many times the sides of an image of this size are halved (ImageDescription::size_limit, resolution).
int halvings(const ImageDescription& image, int width, int height);
/// The bytes of one value.
size_t value_size(Texture::Storage storage);

/// Reads the pixels, the packed file or the file of an image.
DecodedImage decode(const ImageDescription& image);
/// The size and the storage of an image, from the header of its file. The width is 0 if it cannot be read.
DecodedImage read_header(const ImageDescription& image);

}  // namespace ajar
