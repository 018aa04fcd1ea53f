#include "film/image_io.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "math/srgb.h"

namespace ajar {
namespace {

bool has_alpha(int channels) { return channels == 2 || channels == 4; }

std::string ending_of(const std::string& path) {
  const size_t dot = path.find_last_of("./");
  std::string ending = dot == std::string::npos || path[dot] != '.' ? "" : path.substr(dot + 1);
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending;
}

[[noreturn]] void fail(const std::string& what, const std::string& path, const std::string& why) {
  throw std::runtime_error(what + " \"" + path + "\"" + (why.empty() ? "" : ": " + why));
}

// Film images are associated (premultiplied); 8-bit files are straight.
std::vector<uint8_t> encode_srgb8(const Image& image) {
  std::vector<uint8_t> bytes(image.pixels.size());
  const int n = image.channels;
  const int colors = has_alpha(n) ? n - 1 : n;
  for (size_t i = 0; i < bytes.size(); i += n) {
    const float alpha = colors < n ? std::clamp(image.pixels[i + colors], 0.0f, 1.0f) : 1.0f;
    for (int c = 0; c < colors; ++c) {
      const float x = alpha > 0.0f ? image.pixels[i + c] / alpha : 0.0f;
      // !(x > 0) also maps NaN to black.
      bytes[i + c] = !(x > 0.0f) ? 0 : uint8_t(std::lround(255.0f * srgb_from_linear(std::min(x, 1.0f))));
    }
    if (colors < n) bytes[i + colors] = uint8_t(std::lround(255.0f * alpha));
  }
  return bytes;
}

void decode_srgb8(Image& image) {
  const int n = image.channels;
  const int colors = has_alpha(n) ? n - 1 : n;
  for (size_t i = 0; i < image.pixels.size(); i += n) {
    const float alpha = colors < n ? image.pixels[i + colors] : 1.0f;
    for (int c = 0; c < colors; ++c) image.pixels[i + c] = alpha * linear_from_srgb(image.pixels[i + c]);
  }
}

}  // namespace

Image read_image(const std::string& path) {
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;
  auto input = OIIO::ImageInput::open(path, &config);
  if (!input) fail("cannot open image", path, OIIO::geterror());
  const OIIO::ImageSpec spec = input->spec();
  if (spec.depth > 1) fail("cannot read image", path, "it is a volume");
  Image image{spec.width, spec.height, spec.nchannels, {}, spec.channelnames};
  const size_t row = size_t(spec.width) * spec.nchannels;
  image.pixels.resize(row * spec.height);
  // A negative stride fills the memory from the last row, so that the bottom row is the first.
  float* last_row = image.pixels.data() + row * (spec.height - 1);
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, last_row, OIIO::AutoStride,
                         -OIIO::stride_t(row * sizeof(float))))
    fail("cannot read image", path, input->geterror());
  if (!spec.format.is_floating_point()) decode_srgb8(image);
  return image;
}

void write_image(const std::string& path, const Image& image, const std::map<std::string, std::string>& metadata) {
  if (image.width < 1 || image.height < 1 || image.channels < 1 ||
      image.pixels.size() != size_t(image.width) * image.height * image.channels)
    fail("cannot write image", path, "it has no pixels, or their number does not match its size");
  const std::string ending = ending_of(path);
  if (ending != "exr" && ending != "png") fail("cannot write image", path, "the name must end in .exr or .png");
  if (ending == "png" && image.channels > 4) fail("cannot write image", path, "PNG holds 1 to 4 channels");
  auto output = OIIO::ImageOutput::create(path);
  if (!output) fail("cannot write image", path, OIIO::geterror());

  const bool exr = ending == "exr";
  OIIO::ImageSpec spec(image.width, image.height, image.channels, exr ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
  if (exr)
    spec.attribute("compression", "zip");
  else {
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("oiio:UnassociatedAlpha", 1);
  }
  for (const auto& [name, text] : metadata) spec.attribute(name, text);
  if (!output->open(path, spec)) fail("cannot write image", path, output->geterror());

  const size_t row = size_t(image.width) * image.channels;
  const size_t last = row * (image.height - 1);
  bool written = false;
  if (exr) {
    written = output->write_image(OIIO::TypeDesc::FLOAT, image.pixels.data() + last, OIIO::AutoStride,
                                  -OIIO::stride_t(row * sizeof(float)));
  } else {
    const std::vector<uint8_t> bytes = encode_srgb8(image);
    written = output->write_image(OIIO::TypeDesc::UINT8, bytes.data() + last, OIIO::AutoStride, -OIIO::stride_t(row));
  }
  if (!written || !output->close()) fail("cannot write image", path, output->geterror());
}

std::string openimageio_version() {
  const int version = OIIO::openimageio_version();
  return std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
         std::to_string(version % 100);
}

}  // namespace ajar
