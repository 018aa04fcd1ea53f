// Interprets arbitrary bytes as an image file: the first two limit the size of the texture, the rest is the file. It is
// refused with a message, or its texels are numbers. The readers of OpenImageIO have no sanitizers of their own here, but
// what they write beyond the memory that they are given is found.
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "shading/images/image_file.h"
#include "shading/images/texture.h"

using namespace ajar;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 3) return 0;
  ImageDescription image;
  image.name = "Image";
  image.size_limit = data[0];
  image.resolution = data[1] & 1 ? 0.25f : 1.0f;
  const bool linear = data[1] & 2;  // light of 10^30 in sRGB is infinite
  image.color_space = linear ? "Non-Color" : "sRGB";
  image.packed.assign(data + 2, data + size);
  // The limit of the core is 2^28 texels. Decoding that many is allowed, but too slow here.
  const DecodedImage header = read_header(image);
  if (int64_t(header.width) * header.height > 1 << 20) return 0;

  const DecodedImage decoded = decode(image);
  const size_t expected = size_t(decoded.width) * decoded.height * decoded.channels * value_size(decoded.storage);
  if (decoded.error.empty() && decoded.values.size() != expected) std::abort();

  TextureStore store({image});
  Diagnostics diagnostics;
  const Texture* texture = store.load(0, "", diagnostics);
  if (!decoded.error.empty() && diagnostics.empty()) std::abort();
  for (const Vec2 place : {Vec2(0.0f), Vec2(0.999f), Vec2(0.3f, 0.7f), Vec2(-2.0f, 1e30f)}) {
    const Vec4 texel = texture->sample(place, Interpolation::Closest, Extension::Repeat, false);
    for (int i = 0; i < 4; ++i)
      if (linear ? !std::isfinite(texel[i]) : std::isnan(texel[i])) std::abort();
    texture->lookup(place, Interpolation::Cubic, Extension::Mirror);
  }
  return 0;
}
