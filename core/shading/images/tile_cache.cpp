#include "shading/images/tile_cache.h"

#include <OpenImageIO/imagecache.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <map>
#include <mutex>
#include <thread>

#include "platform/platform.h"
#include "shading/images/interpolation.h"

namespace ajar {

namespace {

constexpr int kTile = TiledTexture::kTile;

using Handle = OIIO::ImageCache::ImageHandle;
using Images = decltype(OIIO::ImageCache::create(false));  ///< a pointer; since OpenImageIO 3 a shared one

}  // namespace

TextureCacheOptions texture_cache_of(const RenderSettings& s) {
  return {s.texture_cache, s.texture_cache_generate, s.texture_cache_folder, s.texture_cache_size};
}

TiledUse tiled_use(const ImageDescription& image, const ColorDescription& color, const TextureCacheOptions& options) {
  if (!options.used || !image.tiles.empty()) return TiledUse::Whole;
  const TiledFileName file = tiled_file_of(image, color, options.folder);
  TiledTexture ignored;
  if (file.path.empty()) return TiledUse::Whole;
  if (read_tiled(file.path, ignored)) return TiledUse::Read;
  return options.generates ? TiledUse::Made : TiledUse::Whole;
}

namespace {

/// Tiles that one thread holds, so that it finds those that it reads again and again without the locks of the cache.
struct HeldTiles {
  struct Entry {
    const Handle* image = nullptr;
    uint64_t place = 0;  ///< level, row and column
    OIIO::ImageCache::Tile* tile = nullptr;
    const uint8_t* texels = nullptr;
    uint64_t bytes = 0;
  };
  OIIO::ImageCache* images = nullptr;
  OIIO::ImageCache::Perthread* thread = nullptr;
  std::vector<Entry> entries;                  ///< their number is a power of two
  std::atomic<uint64_t>* all_bytes = nullptr;  ///< of what all threads hold
  uint64_t bytes = 0;                          ///< of what this one holds

  Entry& at(const Handle* image, uint64_t place) {
    const uint64_t mixed = (reinterpret_cast<uintptr_t>(image) ^ place * 0x9e3779b97f4a7c15u) * 0xff51afd7ed558ccdu;
    return entries[size_t(mixed >> 40) & (entries.size() - 1)];
  }
  void release(Entry& entry) {
    if (!entry.tile) return;
    images->release_tile(entry.tile);
    bytes -= entry.bytes;
    *all_bytes -= entry.bytes;
    entry = Entry();
  }
  void release() {
    for (Entry& entry : entries) release(entry);
  }
  void hold(Entry& entry, const Entry& found) {
    entry = found;
    bytes += found.bytes;
    *all_bytes += found.bytes;
  }
};

/// As many as half of the limit has tiles of bytes.
size_t held_by_a_thread(int megabytes) {
  const size_t threads = std::max(1u, std::thread::hardware_concurrency());
  return std::bit_floor(
      std::clamp((size_t(megabytes) << 19) / threads / (kTile * kTile * 4), size_t(16), size_t(8192)));
}

}  // namespace

struct TileCache::Data {
  Images images = nullptr;
  std::atomic<uint64_t> number{0};  ///< of this cache in this process; another one after a file was made anew
  int megabytes = 0;
  std::atomic<uint64_t> failed_tiles{0};
  std::atomic<uint64_t> held_bytes{0};
  std::mutex mutex;  ///< of the next
  std::string failed_file;
  bool removed = false;
  std::vector<std::unique_ptr<HeldTiles>> held;
  std::vector<HeldTiles*> unused;  ///< of `held`: their threads have ended

  ~Data() {
    for (const auto& tiles : held) tiles->release();
    OIIO::ImageCache::destroy(images, true);
  }
  HeldTiles* take() {
    const std::lock_guard lock(mutex);
    if (unused.empty()) {
      held.push_back(std::make_unique<HeldTiles>());
      held.back()->images = &*images;
      held.back()->all_bytes = &held_bytes;
      held.back()->entries.resize(held_by_a_thread(megabytes));
      unused.push_back(held.back().get());
    }
    HeldTiles* const tiles = unused.back();
    unused.pop_back();
    tiles->thread = images->get_perthread_info();
    return tiles;
  }
  /// Whether the file is removed. Windows removes none that is open, so it is closed; a thread that reads it at that time
  /// opens it again, hence several tries.
  bool remove(const std::string& file) {
    constexpr int kTries = 20;
    for (int i = 0; i < kTries; ++i) {
      if (platform::remove_file(file)) return true;
      images->close(OIIO::ustring(file));
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  void give_back(HeldTiles* tiles) {
    const std::lock_guard lock(mutex);
    tiles->release();
    unused.push_back(tiles);
  }
};

namespace {

uint64_t new_number() {
  static std::atomic<uint64_t> last{0};
  return ++last;
}

}  // namespace

/// The tiles of this thread. They are given back when it ends or reads from another cache.
class TileCache::OfThread {
 public:
  ~OfThread() { leave(); }
  static HeldTiles& of(const std::shared_ptr<Data>& data) {
    OfThread& here = platform::of_thread<OfThread>();
    if (const uint64_t number = data->number.load(std::memory_order_relaxed); here.number_ != number) [[unlikely]] {
      here.leave();
      here.tiles_ = data->take();
      here.data_ = data;
      here.number_ = number;
    }
    return *here.tiles_;
  }

 private:
  void leave() {
    if (const std::shared_ptr<Data> data = data_.lock()) data->give_back(tiles_);
    number_ = 0;
  }
  std::weak_ptr<Data> data_;
  uint64_t number_ = 0;
  HeldTiles* tiles_ = nullptr;
};

TileCache::TileCache(int megabytes) : data_(std::make_shared<Data>()) {
  data_->number = new_number();
  data_->megabytes = megabytes;
  data_->images = OIIO::ImageCache::create(false);
  data_->images->attribute("max_memory_MB", 0.625f * float(megabytes));  // it can be exceeded by held tiles
  data_->images->attribute("max_open_files", 256);
  data_->images->attribute("automip", 0);
  data_->images->attribute("forcefloat", 0);
  data_->images->attribute("failure_retries", 0);
  data_->images->attribute("deduplicate", 0);
}

TileCache::~TileCache() = default;

std::shared_ptr<TileCache> TileCache::with_limit(int megabytes) {
  static std::mutex mutex;
  static std::map<int, std::weak_ptr<TileCache>> known;
  const std::lock_guard lock(mutex);
  std::shared_ptr<TileCache> cache = known[megabytes].lock();
  if (!cache) {
    cache.reset(new TileCache(megabytes));
    known[megabytes] = cache;
  }
  return cache;
}

TileStatistics TileCache::statistics() const {
  TileStatistics s;
  const auto number = [&](const char* name) {
    int value = 0;
    data_->images->getattribute(name, OIIO::TypeDesc::INT, &value);
    return uint64_t(std::max(value, 0));
  };
  const auto bytes = [&](const char* name) {
    long long value = 0;
    data_->images->getattribute(name, OIIO::TypeDesc::INT64, &value);
    return uint64_t(std::max(value, 0ll));
  };
  s.limit_bytes = uint64_t(data_->megabytes) << 20;
  s.tiles_read = number("stat:tiles_created");
  s.bytes_read = bytes("stat:bytes_read");
  // The library counts the most tiles, and the bytes of those that it has now.
  const uint64_t current = number("stat:tiles_current"), used = bytes("stat:cache_memory_used");
  s.peak_bytes = current > 0 ? uint64_t(double(used) / double(current) * double(number("stat:tiles_peak"))) : 0;
  s.failed_tiles = data_->failed_tiles.load();
  const std::lock_guard lock(data_->mutex);
  s.failed_file = data_->failed_file;
  s.removed = data_->removed;
  return s;
}

TiledImage::TiledImage(std::shared_ptr<TileCache> cache, const std::string& path, const TiledTexture& texture,
                       File file)
    : cache_(std::move(cache)), path_(path), kind_(texture.kind), file_(file) {
  for (int level = 0; level < level_count(texture.width, texture.height); ++level)
    levels_.push_back({side_of_level(texture.width, level), side_of_level(texture.height, level)});
  OIIO::ImageCache& images = *cache_->data_->images;
  const OIIO::ustring name(path);
  if (file == File::New) {
    images.invalidate(name, true);
    cache_->data_->number = new_number();  // threads forget tiles of the older file
  }
  handle_ = images.get_image_handle(name, nullptr);
}

TiledImage::~TiledImage() = default;

bool TiledImage::is_open() const {
  OIIO::ImageCache& images = *cache_->data_->images;
  auto* const handle = static_cast<Handle*>(handle_);
  if (!handle || !images.good(handle)) {
    (void)images.geterror();
    return false;
  }
  return true;
}

float TiledImage::level_of(const UvFootprint& footprint) const {
  const float w = float(levels_[0].width), h = float(levels_[0].height);
  const Vec2 x(footprint.x.x * w, footprint.x.y * h), y(footprint.y.x * w, footprint.y.y * h);
  // The smaller singular value of the derivatives: the footprint in texels where it is narrow. Its square is the smaller
  // root of s^2 - s (|x|^2 + |y|^2) + det^2.
  const float sum = glm::dot(x, x) + glm::dot(y, y), det = x.x * y.y - x.y * y.x;
  const float root = safe_sqrt(sum * sum - 4.0f * det * det);
  const float squared = sum + root > 0.0f ? 2.0f * det * det / (sum + root) : 0.0f;
  return squared > 1.0f && squared < kInfinity ? 0.5f * std::log2(squared) : 0.0f;
}

/// Texels of a level, with the tile of the last one at hand.
template <typename Texel>
class TiledImage::Reader {
 public:
  Reader(const TiledImage& image, int level)
      : image_(image), tiles_(TileCache::OfThread::of(image.cache_->data_)), level_(uint64_t(level) << 48) {}
  Reader(const Reader&) = delete;

  texels::Float4 operator()(int x, int y) {
    constexpr unsigned kMask = kTile - 1;
    const uint64_t place = level_ | uint64_t(unsigned(y) / kTile) << 24 | unsigned(x) / kTile;
    if (place != place_) take(place);
    if (!texels_) [[unlikely]]
      return texels::Float4{1.0f, 0.0f, 1.0f, 1.0f};
    return texels::fetch<Texel>(texels_, int64_t((unsigned(y) & kMask) * kTile + (unsigned(x) & kMask)));
  }

 private:
  void take(uint64_t place) {
    place_ = place;
    auto* const image = static_cast<Handle*>(image_.handle_);
    HeldTiles::Entry& entry = tiles_.at(image, place);
    if (entry.image != image || entry.place != place) [[unlikely]]
      find(entry, image, place);
    texels_ = entry.texels;
  }
  [[gnu::noinline]] void find(HeldTiles::Entry& entry, Handle* image, uint64_t place) {
    constexpr uint64_t kSide = (1 << 24) - 1;
    OIIO::ImageCache& images = *tiles_.images;
    tiles_.release(entry);
    // The library evicts no tile that is held, so all threads hold at most a quarter of the limit.
    if (tiles_.all_bytes->load(std::memory_order_relaxed) > uint64_t(image_.cache_->data_->megabytes) << 18)
      tiles_.release();
    OIIO::ImageCache::Tile* const tile = images.get_tile(
        image, tiles_.thread, 0, int(place >> 48), int(place & kSide) * kTile, int(place >> 24 & kSide) * kTile, 0);
    OIIO::TypeDesc type;
    const void* const texels = tile ? images.tile_pixels(tile, type) : nullptr;
    if (!texels || type.size() != sizeof(Texel)) {
      if (tile) images.release_tile(tile);
      return fail();
    }
    tiles_.hold(entry, {image, place, tile, static_cast<const uint8_t*>(texels), kTile * kTile * 4 * sizeof(Texel)});
  }
  /// The file is damaged.
  void fail() {
    (void)tiles_.images->geterror();
    TileCache::Data& data = *image_.cache_->data_;
    data.failed_tiles.fetch_add(1, std::memory_order_relaxed);
    if (image_.failed_.exchange(true)) return;
    const bool removed = image_.file_ != File::Kept && data.remove(image_.path_);
    const std::lock_guard lock(data.mutex);
    if (data.failed_file.empty()) data.failed_file = image_.path_, data.removed = removed;
  }
  const TiledImage& image_;
  HeldTiles& tiles_;
  const uint64_t level_;
  uint64_t place_ = ~uint64_t(0);
  const uint8_t* texels_ = nullptr;
};

template <typename Texel>
Vec4 TiledImage::interpolate_as(int level, Vec2 uv, Interpolation interpolation, Extension extension) const {
  const Level& size = levels_[size_t(level)];
  Reader<Texel> reader(*this, level);
  return texels::interpolate(size.width, size.height, uv, interpolation, extension, reader);
}

Vec4 TiledImage::interpolate(int level, Vec2 uv, Interpolation interpolation, Extension extension) const {
  switch (kind_.storage) {
    case Texture::Storage::Byte: return interpolate_as<uint8_t>(level, uv, interpolation, extension);
    case Texture::Storage::Short: return interpolate_as<uint16_t>(level, uv, interpolation, extension);
    case Texture::Storage::Half: return interpolate_as<Half>(level, uv, interpolation, extension);
    default: return interpolate_as<float>(level, uv, interpolation, extension);
  }
}

}  // namespace ajar
