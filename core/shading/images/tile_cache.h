// Textures of which memory holds only the tiles that a render reads: OpenImageIO's ImageCache, with a limit.
//
// The level of a lookup is the finest one whose texels are at most as wide as the footprint of a pixel on the surface.
// The footprint depends on the place of the point alone (BumpFootprint), not on the path: all techniques estimate the
// same picture, and a reflection in a flat mirror, which is farther away, is never coarser than it would be along the
// path. Between two levels there is a band in which both are mixed, so that no border is visible.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "shading/images/tiled_file.h"

namespace ajar {

/// What the settings say about textures in tiles.
struct TextureCacheOptions {
  bool used = false;       ///< files of tiles are read, where there are some
  bool generates = false;  ///< missing ones are made
  std::string folder;      ///< see tiled_file_of
  int megabytes = 1024;    ///< limit of the tiles in memory
  bool operator==(const TextureCacheOptions&) const = default;
};

TextureCacheOptions texture_cache_of(const RenderSettings& settings);

/// What a render that begins now does with an image.
enum class TiledUse : uint8_t { Whole, Read, Made };
TiledUse tiled_use(const ImageDescription& image, const ColorDescription& color, const TextureCacheOptions& options);

struct TileStatistics {
  uint64_t limit_bytes = 0, peak_bytes = 0;
  uint64_t tiles_read = 0, bytes_read = 0;  ///< a tile that was evicted and read again counts twice
  uint64_t failed_tiles = 0;                ///< they could not be read and are magenta
  std::string failed_file;                  ///< the first file of such a tile
  bool removed = false;                     ///< whether it was removed, so that the next render makes it again
};

/// The tiles in memory. All scenes of a process with the same limit share them.
class TileCache {
 public:
  static std::shared_ptr<TileCache> with_limit(int megabytes);
  ~TileCache();
  TileStatistics statistics() const;

 private:
  friend class TiledImage;
  explicit TileCache(int megabytes);
  struct Data;
  class OfThread;
  std::shared_ptr<Data> data_;  ///< threads refer to it as long as it is there
};

/// Derivatives of texture coordinates, for a step of one pixel in two directions on the surface.
struct UvFootprint {
  Vec2 x{0.0f}, y{0.0f};
};

/// The texels of one file. Any number of threads may read them.
class TiledImage {
 public:
  enum class File : uint8_t { Kept, RemovedIfDamaged, New };
  /// New: what the cache knows about an older file of this name is forgotten, and as RemovedIfDamaged.
  TiledImage(std::shared_ptr<TileCache> cache, const std::string& path, const TiledTexture& texture, File file);
  ~TiledImage();
  bool is_open() const;
  /// Whether a tile could not be read.
  bool is_damaged() const { return failed_.load(std::memory_order_relaxed); }
  int levels() const { return int(levels_.size()); }
  /// A continuous level: 0 and less is the finest.
  float level_of(const UvFootprint& footprint) const;
  /// The encoded value at a level.
  Vec4 interpolate(int level, Vec2 uv, Interpolation interpolation, Extension extension) const;

 private:
  template <typename Texel>
  Vec4 interpolate_as(int level, Vec2 uv, Interpolation interpolation, Extension extension) const;
  template <typename Texel>
  class Reader;
  struct Level {
    int width, height;
  };
  std::shared_ptr<TileCache> cache_;
  std::string path_;
  TexelKind kind_;
  File file_ = File::Kept;
  std::vector<Level> levels_;
  void* handle_ = nullptr;  ///< of OpenImageIO
  mutable std::atomic<bool> failed_{false};
};

}  // namespace ajar
