#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <type_traits>

#include "description/diagnostics.h"
#include "math/half.h"
#include "platform/platform.h"
#include "shading/images/color_spaces.h"
#include "shading/images/image_file.h"
#include "shading/images/texture.h"
#include "shading/images/tile_cache.h"

namespace ajar {

namespace {

/// Converts grey, grey with alpha, RGB or RGBA to RGBA. Returns whether any alpha differs from 1.
template <typename T>
bool to_rgba(const DecodedImage& image, AlphaMode alpha_mode, T one, std::vector<uint8_t>& texels) {
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

/// Calls `use` with a value of the type of the texels.
template <class Use>
auto with_type_of(Texture::Storage storage, Use&& use) {
  switch (storage) {
    case Texture::Storage::Byte: return use(uint8_t(255));
    case Texture::Storage::Short: return use(uint16_t(65535));
    case Texture::Storage::Half: return use(Half(1.0f));
    default: return use(1.0f);
  }
}

/// A result of a computation as a texel. Cycles rounds half floats towards zero, and since 5.1 to the nearest.
template <typename T>
T texel_of(float value, bool to_nearest) {
  if constexpr (std::is_same_v<T, Half>) {
    value = glm::clamp(value, -65504.0f, 65504.0f);
    constexpr uint32_t kKept = ~uint32_t(0) << 13;  // bits of the mantissa that a half float has
    if (!to_nearest && std::abs(value) >= 0x1p-14f)
      value = std::bit_cast<float>(std::bit_cast<uint32_t>(value) & kKept);
  }
  return T(value);
}

/// Multiplies colours by alpha. Integers are rounded down, as in Cycles.
template <typename T>
void associate(std::vector<uint8_t>& texels, [[maybe_unused]] T one, [[maybe_unused]] bool to_nearest) {
  T* values = reinterpret_cast<T*>(texels.data());
  for (size_t i = 0; i < texels.size() / sizeof(T); i += 4)
    for (size_t k = 0; k < 3; ++k) {
      if constexpr (std::is_integral_v<T>)
        values[i + k] = T(uint32_t(values[i + k]) * uint32_t(values[i + 3]) / uint32_t(one));
      else
        values[i + k] = texel_of<T>(float(values[i + k]) * float(values[i + 3]), to_nearest);
    }
}

template <typename T>
std::vector<uint8_t> halves_of(const std::vector<uint8_t>& texels, T one) {
  const T* in = reinterpret_cast<const T*>(texels.data());
  std::vector<uint8_t> results(texels.size() / sizeof(T) * sizeof(Half));
  Half* out = reinterpret_cast<Half*>(results.data());
  for (size_t i = 0; i < texels.size() / sizeof(T); ++i) out[i] = Half(float(in[i]) / float(one));
  return results;
}

struct Conversion {
  ColorSpaces& spaces;
  const std::string& from;
  bool associated;  ///< the colour is multiplied by alpha
  bool is_grey;     ///< of one channel: the result is the average of the channels
  bool to_nearest;  ///< see texel_of
};

/// Converts texels to the working space.
template <typename T>
void convert(std::vector<uint8_t>& texels, const Conversion& c) {
  constexpr size_t kAtOnce = size_t(1) << 18;
  T* const all = reinterpret_cast<T*>(texels.data());
  const size_t count = texels.size() / sizeof(T);
  std::vector<float> values(std::min(count, kAtOnce));
  const auto is_colored = [&](size_t i) { return c.associated && i % 4 != 3 && values[i | 3] > 0.0f; };
  for (size_t done = 0; done < count; done += values.size()) {
    const size_t n = std::min(values.size(), count - done);
    for (size_t i = 0; i < n; ++i) values[i] = float(all[done + i]);
    for (size_t i = 0; i < n; ++i)
      if (is_colored(i)) values[i] /= values[i | 3];
    c.spaces.convert(c.from, values.data(), int64_t(n / 4));
    for (size_t i = 0; c.is_grey && i < n; i += 4)
      values[i] = values[i + 1] = values[i + 2] = (values[i] + values[i + 1] + values[i + 2]) / 3.0f;
    for (size_t i = 0; i < n; ++i) {
      all[done + i] = texel_of<T>(is_colored(i) ? values[i] * values[i | 3] : values[i], c.to_nearest);
    }
  }
}

/// Halves the sides of an image this many times: the mean of squares of texels. Texels at the end of rows and columns
/// that fill no square are left out, as in Cycles.
template <typename T>
void halve(std::vector<uint8_t>& texels, int& width, int& height, int times) {
  const int side = 1 << times, reduced_width = std::max(1, width / side), reduced_height = std::max(1, height / side);
  std::vector<uint8_t> reduced(size_t(reduced_width) * size_t(reduced_height) * 4 * sizeof(T));
  const T* const in = reinterpret_cast<const T*>(texels.data());
  T* out = reinterpret_cast<T*>(reduced.data());
  for (int y = 0; y < reduced_height; ++y)
    for (int x = 0; x < reduced_width; ++x, out += 4) {
      double sum[4] = {0, 0, 0, 0};
      const int x1 = std::min((x + 1) * side, width), y1 = std::min((y + 1) * side, height);
      for (int v = y * side; v < y1; ++v)
        for (int u = x * side; u < x1; ++u)
          for (size_t c = 0; c < 4; ++c) sum[c] += double(float(in[(size_t(v) * size_t(width) + size_t(u)) * 4 + c]));
      const double count = double(x1 - x * side) * double(y1 - y * side);
      for (size_t c = 0; c < 4; ++c) {
        if constexpr (std::is_integral_v<T>)
          out[c] = T(std::lround(sum[c] / count));
        else
          out[c] = T(float(sum[c] / count));
      }
    }
  texels = std::move(reduced);
  width = reduced_width;
  height = reduced_height;
}

/// The time when the file was last written; the default value if it cannot be read.
std::filesystem::file_time_type file_time(const ImageDescription& image) {
  std::error_code error;
  if (image.path.empty()) return {};
  const auto time = std::filesystem::last_write_time(platform::file_path(image.path), error);
  return error ? std::filesystem::file_time_type{} : time;
}

bool is_of_floats(Texture::Storage storage) {
  return storage == Texture::Storage::Half || storage == Texture::Storage::Float;
}

void report_repaired(int64_t count, const TextureStore::Report& report) {
  if (count > 0) report(std::to_string(count) + " pixels are not finite and were set to 0");
}

bool same_source(const ImageDescription& a, const ImageDescription& b) {
  return a.path == b.path && a.color_space == b.color_space && a.alpha_mode == b.alpha_mode && a.width == b.width &&
         a.height == b.height && a.size_limit == b.size_limit && a.resolution == b.resolution && a.packed == b.packed &&
         a.pixels == b.pixels;
}

}  // namespace

uint64_t texture_bytes(const ImageDescription& image) {
  if (!image.pixels.empty())
    return (image.pixels.size() * sizeof(float)) >> (2 * halvings(image, image.width, image.height));
  if (image.packed.empty() && image.path.empty()) return 0;
  const DecodedImage header = read_header(image);
  return (uint64_t(header.width) * uint64_t(header.height) * 4 * value_size(header.storage)) >>
         (2 * halvings(image, header.width, header.height));
}

struct TextureStore::Data {
  struct Entry {
    std::unique_ptr<Texture> texture;
    std::filesystem::file_time_type time;
    bool readable = false;
  };
  std::vector<ImageDescription> images;
  ColorSpaces spaces;
  std::map<int, Entry> textures;
  std::unique_ptr<Data> previous;
  TextureCacheOptions cache;
  std::shared_ptr<TileCache> tiles;
  int decoded = 0, kept = 0, made = 0;

  /// Whether tiles of it could not be read, so that its file was removed.
  static bool is_damaged(const Texture& texture) { return texture.cached_ && texture.cached_->is_damaged(); }

  /// The texture that `previous` made of this image, or null.
  std::unique_ptr<Texture> take(const ImageDescription& image, std::filesystem::file_time_type time) {
    if (!previous) return nullptr;
    for (auto& [key, entry] : previous->textures) {
      if (entry.texture && entry.readable && !is_damaged(*entry.texture) && entry.time == time &&
          same_source(previous->images[size_t(key)], image))
        return std::move(entry.texture);
    }
    return nullptr;
  }
};

TextureStore::TextureStore(std::vector<ImageDescription> images, TextureStore* previous, const ColorDescription& color)
    : TextureStore(std::move(images), previous, color, TextureCacheOptions()) {}
TextureStore::TextureStore(std::vector<ImageDescription> images, TextureStore* previous, const ColorDescription& color,
                           const TextureCacheOptions& cache)
    : data_(std::make_unique<Data>()) {
  data_->images = std::move(images);
  data_->spaces = ColorSpaces(color);
  data_->cache = cache;
  if (cache.used) data_->tiles = TileCache::with_limit(cache.megabytes);
  if (previous && previous->data_->spaces.description() == color && previous->data_->cache == cache) {
    data_->previous = std::move(previous->data_);
    data_->previous->previous.reset();
  }
}
TextureStore::TextureStore(TextureStore&&) noexcept = default;
TextureStore::~TextureStore() = default;

const Texture& TextureStore::magenta() {
  static const Texture texture = [] {
    Texture t;
    t.storage_ = Texture::Storage::Tiles;  // without any tile, it is magenta even where images are clipped
    return t;
  }();
  return texture;
}

const Texture* TextureStore::load(int index, const std::string& shown_by, std::vector<Diagnostic>& diagnostics) {
  if (index < 0) return &magenta();  // the node that has no image reports it
  if (index >= int(data_->images.size())) {
    report_once(diagnostics,
                {Diagnostic::Severity::Warning, "image " + std::to_string(index), "does not exist; magenta is used"});
    return &magenta();
  }
  Data::Entry& entry = data_->textures[index];
  std::unique_ptr<Texture>& texture = entry.texture;
  if (texture) return texture.get();

  const ImageDescription& image = data_->images[index];
  if (!image.tiles.empty()) return load_tiles(index, shown_by, diagnostics);
  entry.time = file_time(image);
  texture = data_->take(image, entry.time);
  if (texture) {
    entry.readable = true;
    ++data_->decoded;
    ++data_->kept;
    return texture.get();
  }
  const auto report = [&](const std::string& message) {
    report_once(diagnostics, {Diagnostic::Severity::Warning, image.name.empty() ? image.path : image.name,
                              shown_by.empty() ? message : message + " (" + shown_by + ")"});
  };
  texture = std::make_unique<Texture>(magenta());
  if (image.packed.empty() && image.path.empty() && image.pixels.empty()) {
    report("has no source; magenta is used");
    return texture.get();
  }
  TiledTexture ignored;
  entry.readable = data_->cache.used ? load_from_cache(*texture, image, report)
                                     : load_whole(*texture, image, report, ignored);
  if (entry.readable) ++data_->decoded;
  return texture.get();
}

/// `facts`: what a file of tiles says about the texture.
bool TextureStore::load_whole(Texture& texture, const ImageDescription& image, const Report& report,
                              TiledTexture& facts) {
  const DecodedImage decoded = decode(image);
  if (!decoded.error.empty()) {
    const bool names_file = image.path.empty() || decoded.error.find(image.path) != std::string::npos;
    report(decoded.error + (names_file ? "" : " (" + image.path + ")") + "; magenta is used");
    return false;
  }
  const int64_t repaired = fill(texture, image, decoded, report);
  report_repaired(repaired, report);
  facts = {texture.width_,
           texture.height_,
           {texture.storage_, texture.srgb_, texture.has_alpha_},
           is_of_floats(decoded.storage),
           repaired};
  return true;
}

/// Uses the file of tiles of the image. If there is none, it is made, or the image is loaded whole.
bool TextureStore::load_from_cache(Texture& texture, const ImageDescription& image, const Report& report) {
  const TiledFileName file = tiled_file_of(image, data_->spaces.description(), data_->cache.folder);
  TiledTexture tiled;
  const auto open = [&](TiledImage::File state) {
    auto opened = std::make_shared<TiledImage>(data_->tiles, file.path, tiled, state);
    if (!opened->is_open()) return false;
    texture.width_ = tiled.width;
    texture.height_ = tiled.height;
    texture.storage_ = Texture::Storage::Cached;
    texture.srgb_ = tiled.kind.srgb;
    texture.has_alpha_ = tiled.kind.has_alpha;
    texture.cached_ = std::move(opened);
    return true;
  };
  if (!file.path.empty() && read_tiled(file.path, tiled) &&
      open(data_->cache.generates ? TiledImage::File::RemovedIfDamaged : TiledImage::File::Kept)) {
    std::string problem;
    data_->spaces.encoding(image.color_space, tiled.float_source, problem);
    if (!problem.empty()) report(problem);
    report_repaired(tiled.repaired, report);
    return true;
  }
  if (!load_whole(texture, image, report, tiled)) return false;
  if (!data_->cache.generates) return true;
  std::string problem = file.why_none;
  if (!file.path.empty()) {
    problem = write_tiled(file.path, tiled, texture.texels_);
    if (problem.empty() && !open(TiledImage::File::New)) problem = "the file cannot be read";
    if (!problem.empty()) problem = "'" + file.path + "' cannot be made (" + problem + ")";
  }
  if (!problem.empty()) {
    report("has no texture cache: " + problem + "; the whole image is loaded");
    return true;
  }
  ++data_->made;
  texture.texels_ = std::vector<uint8_t>();  // frees them, which {} would not
  return true;
}

/// Stores the texels of a decoded image.
int64_t TextureStore::fill(Texture& texture, const ImageDescription& image, const DecodedImage& decoded,
                           const Report& report) {
  const bool is_float = is_of_floats(decoded.storage);
  std::string problem;
  const ColorEncoding encoding = data_->spaces.encoding(image.color_space, is_float, problem);
  if (!problem.empty()) report(problem);
  texture.width_ = decoded.width;
  texture.height_ = decoded.height;
  texture.storage_ = decoded.storage;
  texture.srgb_ = encoding == ColorEncoding::Srgb;
  const bool has_alpha = with_type_of(decoded.storage, [&](auto one) {
    return to_rgba<decltype(one)>(decoded, image.alpha_mode, one, texture.texels_);
  });
  const bool color_belongs_to_alpha = encoding != ColorEncoding::Data && image.alpha_mode != AlphaMode::ChannelPacked &&
                                      image.alpha_mode != AlphaMode::None;
  texture.has_alpha_ = has_alpha && color_belongs_to_alpha;
  if (encoding == ColorEncoding::Other && !is_float) {
    with_type_of(decoded.storage, [&](auto one) { texture.texels_ = halves_of(texture.texels_, one); });
    texture.storage_ = Texture::Storage::Half;
  }
  // Images of newer Blenders have these alpha modes.
  const bool to_nearest = image.alpha_mode == AlphaMode::AlwaysStraight ||
                          image.alpha_mode == AlphaMode::AlwaysPremultiplied;
  with_type_of(texture.storage_, [&](auto one) {
    if (texture.has_alpha_ && decoded.straight_alpha) associate<decltype(one)>(texture.texels_, one, to_nearest);
    if constexpr (!std::is_integral_v<decltype(one)>)
      if (encoding == ColorEncoding::Other)
        convert<decltype(one)>(
            texture.texels_, {data_->spaces, image.color_space, texture.has_alpha_, decoded.channels == 1, to_nearest});
  });
  const int64_t repaired = texture.storage_ == Texture::Storage::Half    ? repair<Half>(texture.texels_)
                           : texture.storage_ == Texture::Storage::Float ? repair<float>(texture.texels_)
                                                                         : 0;
  if (const int times = halvings(image, texture.width_, texture.height_); times > 0)
    with_type_of(texture.storage_,
                 [&](auto one) { halve<decltype(one)>(texture.texels_, texture.width_, texture.height_, times); });
  return repaired;
}

/// A texture that refers to the tiles of an image. Missing tiles are magenta.
const Texture* TextureStore::load_tiles(int index, const std::string& shown_by, Diagnostics& diagnostics) {
  constexpr int kMostTiles = 10000;
  const std::vector<ImageTile>& parts = data_->images[size_t(index)].tiles;
  auto tiles = std::make_unique<Texture>(magenta());
  tiles->storage_ = Texture::Storage::Tiles;
  for (const ImageTile& part : parts) {
    const int place = part.number - 1001;
    const bool is_part = part.image >= 0 && part.image < int(data_->images.size()) &&
                         data_->images[size_t(part.image)].tiles.empty();
    if (place < 0 || place >= kMostTiles || !is_part) continue;
    if (place >= int(tiles->tiles_.size())) tiles->tiles_.resize(size_t(place) + 1, &magenta());
    tiles->tiles_[size_t(place)] = load(part.image, shown_by, diagnostics);
  }
  tiles->tiles_.push_back(&magenta());
  Data::Entry& entry = data_->textures[index];
  // The programs of the previous scene know its texture.
  if (data_->previous)
    for (auto& [number, known] : data_->previous->textures)
      if (known.texture && known.texture->tiles_ == tiles->tiles_) tiles = std::move(known.texture);
  entry.texture = std::move(tiles);
  entry.readable = true;
  return entry.texture.get();
}

size_t TextureStore::memory_bytes() const {
  size_t bytes = 0;
  for (const auto& entry : data_->textures) bytes += entry.second.texture->memory_bytes();
  return bytes;
}

int TextureStore::decoded_count() const { return data_->decoded; }
int TextureStore::kept_count() const { return data_->kept; }
int TextureStore::made_count() const { return data_->made; }
int TextureStore::tiled_count() const {
  return int(std::count_if(data_->textures.begin(), data_->textures.end(), [](const auto& entry) {
    return entry.second.texture && entry.second.texture->storage_ == Texture::Storage::Cached;
  }));
}
TileStatistics TextureStore::tile_statistics() const {
  return data_->tiles ? data_->tiles->statistics() : TileStatistics();
}

void TextureStore::forget_previous() { data_->previous.reset(); }

}  // namespace ajar
