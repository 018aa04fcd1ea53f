#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>

#include <unistd.h>

#include "description/diagnostics.h"
#include "shading/functions/texture.h"

namespace ajar {

namespace {

constexpr int64_t kMaxTexels = int64_t(1) << 28;  ///< 16384 squared; larger images are treated as errors
constexpr int kMaxSide = 65536;

enum class ColorSpace : uint8_t { Data, Linear, Srgb };

/// How a colour space of Blender's configuration is decoded. `approximate` is set if it is a different one.
ColorSpace color_space_of(const std::string& name, bool is_float, bool& approximate) {
  approximate = false;
  for (const char* data : {"Non-Color", "Non-Colour Data", "Raw", "Generic Data"})
    if (name == data) return ColorSpace::Data;
  for (const char* linear : {"Linear", "Linear Rec.709", "scene_linear", "Linear BT.709"})
    if (name == linear) return ColorSpace::Linear;
  if (name == "sRGB") return ColorSpace::Srgb;
  if (name.empty()) return is_float ? ColorSpace::Linear : ColorSpace::Srgb;
  approximate = true;
  return name.find("Linear") != std::string::npos || name == "XYZ" ? ColorSpace::Linear : ColorSpace::Srgb;
}

struct Decoded {
  int width = 0, height = 0, channels = 0;
  Texture::Storage storage = Texture::Storage::Byte;
  bool straight_alpha = false;  ///< the colour is not yet multiplied by alpha
  std::vector<uint8_t> values;  ///< `channels` per texel; rows go up from the bottom
  std::string error;
};

size_t value_size(Texture::Storage storage) {
  return storage == Texture::Storage::Byte ? 1 : storage == Texture::Storage::Float ? 4 : 2;
}

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

Decoded read(OIIO::ImageInput& input, const OIIO::ImageSpec& spec) {
  Decoded image;
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1) {
    image.error = "has no pixels";
    return image;
  }
  if (spec.width > kMaxSide || spec.height > kMaxSide || int64_t(spec.width) * spec.height > kMaxTexels) {
    image.error = "is too large (" + std::to_string(spec.width) + " x " + std::to_string(spec.height) + ")";
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

/// A file with the given bytes, which is deleted at the end of the scope, for readers that need a file.
class TemporaryFile {
 public:
  TemporaryFile(const std::vector<uint8_t>& bytes, const std::string& ending) {
    path_ = (std::filesystem::temp_directory_path() / ("ajar-XXXXXX" + ending)).string();
    const int descriptor = mkstemps(path_.data(), int(ending.size()));
    if (descriptor < 0) return;
    size_t written = 0;
    while (written < bytes.size()) {
      const ssize_t n = ::write(descriptor, bytes.data() + written, bytes.size() - written);
      if (n <= 0) break;
      written += size_t(n);
    }
    ::close(descriptor);
  }
  ~TemporaryFile() { ::unlink(path_.c_str()); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Returns the result of `use(reader)` for the image's file or bytes, or an error.
template <class Use>
Decoded with_reader(const ImageDescription& image, Use&& use) {
  Decoded decoded;
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  if (image.packed.empty()) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(image.path, ignored)) {
      decoded.error = "is missing: " + image.path;
      return decoded;
    }
    const auto input = OIIO::ImageInput::open(image.path, &config);
    if (input) return use(*input);
  } else {
    const char* name = name_for(image.packed);
    OIIO::Filesystem::IOMemReader memory(image.packed.data(), image.packed.size());
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

Decoded decode(const ImageDescription& image) {
  return with_reader(image, [](OIIO::ImageInput& input) { return read(input, input.spec()); });
}

/// Values that were given directly as floats. They are stored as bytes if all of them are bytes.
Decoded from_pixels(const ImageDescription& image) {
  Decoded decoded;
  const int64_t count = int64_t(image.width) * image.height;
  if (image.width < 1 || image.height < 1 || image.width > kMaxSide || image.height > kMaxSide || count > kMaxTexels ||
      int64_t(image.pixels.size()) != count * 4) {
    decoded.error = "has " + std::to_string(image.pixels.size()) + " values for " + std::to_string(image.width) +
                    " x " + std::to_string(image.height) + " pixels";
    return decoded;
  }
  decoded.width = image.width;
  decoded.height = image.height;
  decoded.channels = 4;
  decoded.straight_alpha = image.alpha_mode != AlphaMode::Premultiplied;
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

/// Converts grey, grey with alpha, RGB or RGBA to RGBA. Returns whether any alpha differs from 1.
template <typename T>
bool to_rgba(const Decoded& image, AlphaMode alpha_mode, T one, std::vector<uint8_t>& texels) {
  const int64_t count = int64_t(image.width) * image.height;
  texels.resize(size_t(count) * 4 * sizeof(T));
  const T* in = reinterpret_cast<const T*>(image.values.data());
  T* out = reinterpret_cast<T*>(texels.data());
  bool has_alpha = false;
  const int n = image.channels;
  for (int64_t i = 0; i < count; ++i, in += n, out += 4) {
    out[0] = in[0];
    out[1] = n > 2 ? in[1] : in[0];
    out[2] = n > 2 ? in[2] : in[0];
    out[3] = alpha_mode == AlphaMode::None || n == 1 || n == 3 ? one : in[n - 1];
    has_alpha = has_alpha || out[3] != one;
  }
  return has_alpha;
}

/// Sets texels with NaN or infinity to 0. Returns their number.
template <typename T>
int64_t repair(std::vector<uint8_t>& texels) {
  T* values = reinterpret_cast<T*>(texels.data());
  int64_t repaired = 0;
  for (size_t i = 0; i < texels.size() / sizeof(T); i += 4) {
    const bool finite = std::isfinite(float(values[i])) && std::isfinite(float(values[i + 1])) &&
                        std::isfinite(float(values[i + 2])) && std::isfinite(float(values[i + 3]));
    if (finite) continue;
    values[i] = values[i + 1] = values[i + 2] = values[i + 3] = T(0.0f);
    ++repaired;
  }
  return repaired;
}

}  // namespace

namespace {

/// The size of an image, if it is within the limits.
Decoded header_of(OIIO::ImageInput& input) {
  Decoded header;
  const OIIO::ImageSpec& spec = input.spec();
  if (spec.width < 1 || spec.height < 1 || spec.width > kMaxSide || spec.height > kMaxSide ||
      int64_t(spec.width) * spec.height > kMaxTexels)
    return header;
  header.width = spec.width;
  header.height = spec.height;
  header.storage = storage_of(spec);
  return header;
}

/// The time when the file was last written; the default value if it cannot be read.
std::filesystem::file_time_type file_time(const ImageDescription& image) {
  std::error_code error;
  if (image.path.empty()) return {};
  const auto time = std::filesystem::last_write_time(image.path, error);
  return error ? std::filesystem::file_time_type{} : time;
}

bool same_source(const ImageDescription& a, const ImageDescription& b) {
  return a.path == b.path && a.color_space == b.color_space && a.alpha_mode == b.alpha_mode && a.width == b.width &&
         a.height == b.height && a.packed == b.packed && a.pixels == b.pixels;
}

}  // namespace

uint64_t texture_bytes(const ImageDescription& image) {
  if (!image.pixels.empty()) return image.pixels.size() * sizeof(float);
  if (image.packed.empty() && image.path.empty()) return 0;
  const Decoded header = with_reader(image, header_of);
  return uint64_t(header.width) * uint64_t(header.height) * 4 * value_size(header.storage);
}

struct TextureStore::Data {
  struct Entry {
    std::unique_ptr<Texture> texture;
    std::filesystem::file_time_type time;
    bool readable = false;
  };
  std::vector<ImageDescription> images;
  std::map<std::pair<int, std::string>, Entry> textures;
  std::unique_ptr<Data> previous;
  Texture magenta;
  int decoded = 0, kept = 0;

  /// The texture that `previous` made of this image, or null.
  std::unique_ptr<Texture> take(const ImageDescription& image, const std::string& color_space_override,
                                std::filesystem::file_time_type time) {
    if (!previous) return nullptr;
    for (auto& [key, entry] : previous->textures) {
      if (entry.texture && entry.readable && key.second == color_space_override && entry.time == time &&
          same_source(previous->images[size_t(key.first)], image))
        return std::move(entry.texture);
    }
    return nullptr;
  }
};

TextureStore::TextureStore(std::vector<ImageDescription> images, TextureStore* previous)
    : data_(std::make_unique<Data>()) {
  data_->images = std::move(images);
  if (previous) {
    data_->previous = std::move(previous->data_);
    data_->previous->previous.reset();
  }
  data_->magenta.width_ = data_->magenta.height_ = 1;
  data_->magenta.texels_ = {255, 0, 255, 255};
}
TextureStore::TextureStore(TextureStore&&) noexcept = default;
TextureStore::~TextureStore() = default;

const Texture* TextureStore::load(int index, const std::string& color_space_override,
                                  std::vector<Diagnostic>& diagnostics) {
  if (index < 0) return &data_->magenta;  // the node that has no image reports it
  if (index >= int(data_->images.size())) {
    report_once(diagnostics,
                {Diagnostic::Severity::Warning, "image " + std::to_string(index), "does not exist; magenta is used"});
    return &data_->magenta;
  }
  Data::Entry& entry = data_->textures[{index, color_space_override}];
  std::unique_ptr<Texture>& texture = entry.texture;
  if (texture) return texture.get();

  const ImageDescription& image = data_->images[index];
  entry.time = file_time(image);
  texture = data_->take(image, color_space_override, entry.time);
  if (texture) {
    entry.readable = true;
    ++data_->decoded;
    ++data_->kept;
    return texture.get();
  }
  const auto report = [&](const std::string& message) {
    report_once(diagnostics, {Diagnostic::Severity::Warning, image.name.empty() ? image.path : image.name, message});
  };
  texture = std::make_unique<Texture>(data_->magenta);
  if (image.packed.empty() && image.path.empty() && image.pixels.empty()) {
    report("has no source; magenta is used");
    return texture.get();
  }
  const Decoded decoded = !image.pixels.empty() ? from_pixels(image) : decode(image);
  if (!decoded.error.empty()) {
    report(decoded.error + "; magenta is used");
    return texture.get();
  }

  const bool is_float = decoded.storage == Texture::Storage::Half || decoded.storage == Texture::Storage::Float;
  const std::string& name = color_space_override.empty() ? image.color_space : color_space_override;
  bool approximate;
  const ColorSpace color_space = color_space_of(name, is_float, approximate);
  if (approximate)
    report("colour space '" + name + "' is approximated by " +
           (color_space == ColorSpace::Srgb ? "sRGB" : "linear Rec. 709"));

  texture->width_ = decoded.width;
  texture->height_ = decoded.height;
  texture->storage_ = decoded.storage;
  texture->srgb_ = color_space == ColorSpace::Srgb;
  bool has_alpha = false;
  int64_t repaired = 0;
  switch (decoded.storage) {
    case Texture::Storage::Byte: has_alpha = to_rgba<uint8_t>(decoded, image.alpha_mode, 255, texture->texels_); break;
    case Texture::Storage::Short:
      has_alpha = to_rgba<uint16_t>(decoded, image.alpha_mode, 65535, texture->texels_);
      break;
    case Texture::Storage::Half:
      has_alpha = to_rgba<_Float16>(decoded, image.alpha_mode, _Float16(1.0f), texture->texels_);
      repaired = repair<_Float16>(texture->texels_);
      break;
    case Texture::Storage::Float:
      has_alpha = to_rgba<float>(decoded, image.alpha_mode, 1.0f, texture->texels_);
      repaired = repair<float>(texture->texels_);
      break;
  }
  const bool color_belongs_to_alpha = color_space != ColorSpace::Data && image.alpha_mode != AlphaMode::ChannelPacked &&
                                      image.alpha_mode != AlphaMode::None;
  texture->has_alpha_ = has_alpha && color_belongs_to_alpha;
  texture->associate_ = texture->has_alpha_ && decoded.straight_alpha;
  if (repaired > 0) report(std::to_string(repaired) + " pixels are not finite and were set to 0");
  entry.readable = true;
  ++data_->decoded;
  return texture.get();
}

size_t TextureStore::memory_bytes() const {
  size_t bytes = 0;
  for (const auto& entry : data_->textures) bytes += entry.second.texture->memory_bytes();
  return bytes;
}

int TextureStore::decoded_count() const { return data_->decoded; }
int TextureStore::kept_count() const { return data_->kept; }

void TextureStore::forget_previous() { data_->previous.reset(); }

}  // namespace ajar
