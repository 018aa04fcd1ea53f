#include "shading/images/image_file.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "platform/platform.h"

namespace ajar {

namespace {

constexpr int64_t kMaxTexels = int64_t(1) << 28;  ///< 16384 squared; larger images are treated as errors
constexpr int kMaxSide = 65536;

bool is_too_large(int64_t width, int64_t height) {
  return width > kMaxSide || height > kMaxSide || width * height > kMaxTexels;
}

}  // namespace

int halvings(const ImageDescription& image, int width, int height) {
  constexpr int kMost = 16;
  int count = 0;
  if (image.resolution < 1.0f && image.resolution > 0.0f)
    count = std::min(kMost, int(std::ceil(-std::log2(image.resolution) - 1e-6f)));
  while (image.size_limit > 0 && count < kMost && int64_t(std::max(width, height)) > int64_t(image.size_limit) << count)
    ++count;
  return count;
}

size_t value_size(Texture::Storage storage) {
  return storage == Texture::Storage::Byte ? 1 : storage == Texture::Storage::Float ? 4 : 2;
}

namespace {

OIIO::TypeDesc type_of(Texture::Storage storage) {
  switch (storage) {
    case Texture::Storage::Byte: return OIIO::TypeDesc::UINT8;
    case Texture::Storage::Short: return OIIO::TypeDesc::UINT16;
    case Texture::Storage::Half: return OIIO::TypeDesc::HALF;
    default: return OIIO::TypeDesc::FLOAT;
  }
}

Texture::Storage storage_of(const OIIO::ImageSpec& spec) {
  OIIO::TypeDesc type = spec.format;
  for (const OIIO::TypeDesc& channel : spec.channelformats)
    if (channel.basesize() > type.basesize()) type = channel;
  if (type == OIIO::TypeDesc::HALF) return Texture::Storage::Half;
  if (type.is_floating_point() || type.basesize() > 2) return Texture::Storage::Float;
  return type.basesize() == 2 ? Texture::Storage::Short : Texture::Storage::Byte;
}

DecodedImage read(OIIO::ImageInput& input, const OIIO::ImageSpec& spec) {
  DecodedImage image;
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1) {
    image.error = "has no pixels";
    return image;
  }
  if (is_too_large(spec.width, spec.height)) {
    image.error = "is too large (" + std::to_string(spec.width) + " x " + std::to_string(spec.height) + ")";
    return image;
  }
  if (spec.depth > 1) {  // the layers would be written one after the other
    image.error = "is a volume of " + std::to_string(spec.depth) + " layers, not an image";
    return image;
  }
  image.width = spec.width;
  image.height = spec.height;
  image.channels = std::min(spec.nchannels, 4);
  image.storage = storage_of(spec);
  const std::string_view format = input.format_name();
  image.straight_alpha = spec.get_int_attribute("oiio:UnassociatedAlpha", 0) != 0;
  if (!image.straight_alpha && spec.alpha_channel >= 0 && format == "targa")
    image.straight_alpha = spec.get_int_attribute("targa:alpha_type", -1) != 4;
  if (format == "dds") image.straight_alpha = true;

  // The file's rows go from top to bottom; a negative stride reverses them.
  const size_t row = size_t(image.width) * image.channels * value_size(image.storage);
  image.values.resize(row * image.height);
  if (!input.read_image(0, 0, 0, image.channels, type_of(image.storage), image.values.data() + row * (image.height - 1),
                        OIIO::AutoStride, -OIIO::stride_t(row), OIIO::AutoStride))
    image.error = "cannot be read: " + input.geterror();
  return image;
}

/// A file name whose extension matches the bytes, so that the right reader is tried first.
const char* name_for(const std::vector<uint8_t>& bytes) {
  const auto starts = [&](std::initializer_list<uint8_t> magic) {
    return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
  };
  if (starts({0x89, 'P', 'N', 'G'})) return "packed.png";
  if (starts({0xff, 0xd8})) return "packed.jpg";
  if (starts({0x76, 0x2f, 0x31, 0x01})) return "packed.exr";
  if (starts({'#', '?'})) return "packed.hdr";
  if (starts({'I', 'I', '*', 0}) || starts({'M', 'M', 0, '*'})) return "packed.tif";
  if (starts({'B', 'M'})) return "packed.bmp";
  if (starts({'R', 'I', 'F', 'F'})) return "packed.webp";
  if (starts({'D', 'D', 'S', ' '})) return "packed.dds";
  if (starts({'8', 'B', 'P', 'S'})) return "packed.psd";
  return "packed.tga";
}

/// The bytes of a packed file. Reads from outside return less or nothing, as those of a file do. IOMemReader of
/// OpenImageIO 2.4 reads the memory before them if an OpenEXR file says that its rows are at a negative place.
class PackedBytes final : public OIIO::Filesystem::IOMemReader {
 public:
  using IOMemReader::IOMemReader;
  size_t read(void* to, size_t count) override {
    count = pread(to, count, m_pos);
    m_pos += int64_t(count);
    return count;
  }
  size_t pread(void* to, size_t count, int64_t from) override {
    if (from < 0 || size_t(from) >= size()) return 0;
    return IOMemReader::pread(to, std::min(count, size() - size_t(from)), from);
  }
};

/// A file with the given bytes, which is deleted at the end of the scope, for readers that need a file.
class TemporaryFile {
 public:
  TemporaryFile(const std::vector<uint8_t>& bytes, const std::string& ending)
      : path_(platform::write_temporary(bytes.data(), bytes.size(), ending)) {}
  ~TemporaryFile() {
    if (!path_.empty()) platform::remove_file(path_);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  const std::string path_;
};

/// Returns the result of `use(reader)` for the image's file or bytes, or an error.
template <class Use>
DecodedImage with_reader(const ImageDescription& image, Use&& use) {
  DecodedImage decoded;
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  if (image.packed.empty()) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(platform::file_path(image.path), ignored)) {
      decoded.error = "is missing: " + image.path;
      return decoded;
    }
    const auto input = OIIO::ImageInput::open(image.path, &config);
    if (input) return use(*input);
  } else {
    const char* name = name_for(image.packed);
    PackedBytes memory(image.packed.data(), image.packed.size());
    const auto reader = OIIO::ImageInput::create(name, false, &config, &memory);
    if (reader && reader->supports("ioproxy")) {
      // Set on the reader itself, because the function open() first looks for a file of that name.
      OIIO::ImageSpec spec;
      if (reader->set_ioproxy(&memory) && reader->open(name, spec, config)) return use(*reader);
    } else if (reader) {
      const TemporaryFile file(image.packed, name);
      if (const auto input = OIIO::ImageInput::open(file.path(), &config)) return use(*input);
    }
  }
  decoded.error = "cannot be read: " + OIIO::geterror();
  return decoded;
}

/// Values that were given directly as floats. They are stored as bytes if all of them are bytes.
DecodedImage from_pixels(const ImageDescription& image) {
  DecodedImage decoded;
  const int64_t count = int64_t(image.width) * image.height;
  if (image.width < 1 || image.height < 1 || is_too_large(image.width, image.height) ||
      int64_t(image.pixels.size()) != count * 4) {
    decoded.error = "has " + std::to_string(image.pixels.size()) + " values for " + std::to_string(image.width) +
                    " x " + std::to_string(image.height) + " pixels";
    return decoded;
  }
  decoded.width = image.width;
  decoded.height = image.height;
  decoded.channels = 4;
  decoded.straight_alpha = image.alpha_mode != AlphaMode::Premultiplied &&
                           image.alpha_mode != AlphaMode::AlwaysPremultiplied;
  const bool bytes = std::all_of(image.pixels.begin(), image.pixels.end(), [](float x) {
    return x >= 0.0f && x <= 1.0f && std::abs(x * 255.0f - std::round(x * 255.0f)) < 1e-4f;
  });
  if (bytes) {
    decoded.values.resize(image.pixels.size());
    std::transform(image.pixels.begin(), image.pixels.end(), decoded.values.begin(),
                   [](float x) { return uint8_t(std::lround(x * 255.0f)); });
  } else {
    decoded.storage = Texture::Storage::Float;
    decoded.values.resize(image.pixels.size() * sizeof(float));
    std::memcpy(decoded.values.data(), image.pixels.data(), decoded.values.size());
  }
  return decoded;
}

/// The size of an image, if it is within the limits.
DecodedImage header_of(OIIO::ImageInput& input) {
  DecodedImage header;
  const OIIO::ImageSpec& spec = input.spec();
  if (spec.width < 1 || spec.height < 1 || is_too_large(spec.width, spec.height)) return header;
  header.width = spec.width;
  header.height = spec.height;
  header.storage = storage_of(spec);
  return header;
}

}  // namespace

DecodedImage decode(const ImageDescription& image) {
  if (!image.pixels.empty()) return from_pixels(image);
  DecodedImage decoded = with_reader(image, [](OIIO::ImageInput& input) { return read(input, input.spec()); });
  if (image.alpha_mode == AlphaMode::AlwaysStraight) decoded.straight_alpha = true;
  if (image.alpha_mode == AlphaMode::AlwaysPremultiplied) decoded.straight_alpha = false;
  return decoded;
}

DecodedImage read_header(const ImageDescription& image) { return with_reader(image, header_of); }

}  // namespace ajar
