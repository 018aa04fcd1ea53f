// Images as textures. image_file.cpp reads them, and texture_store.cpp keeps them.
//
// An image is decoded at build time, when a visible material first uses it, and stored in the format of its file (8 or
// 16 bits, half, float). As in Cycles, values are interpolated while they are encoded and multiplied by alpha; sRGB is
// converted to linear afterwards. Images in other colour spaces are converted before (color_spaces.h), and those of
// integers are stored as half floats. A missing or unreadable image is magenta and is reported.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "description/scene_description.h"

namespace ajar {

struct DecodedImage;
struct Diagnostic;
struct TextureCacheOptions;
struct TileStatistics;
struct TiledTexture;
struct UvFootprint;
class TiledImage;
enum class Interpolation : uint8_t { Closest, Linear, Cubic };
enum class Extension : uint8_t { Repeat, Extend, Clip, Mirror };

class Texture;

class TextureStore {
 public:
  using Report = std::function<void(const std::string&)>;
  /// Textures that `previous` has decoded from the same images are moved to this store.
  explicit TextureStore(std::vector<ImageDescription> images, TextureStore* previous = nullptr,
                        const ColorDescription& color = {});
  /// The same, with textures in tiles (tile_cache.h).
  TextureStore(std::vector<ImageDescription> images, TextureStore* previous, const ColorDescription& color,
               const TextureCacheOptions& cache);
  TextureStore(TextureStore&&) noexcept;
  ~TextureStore();

  /// Decodes image `index` once and returns its handle, which is valid as long as the store. An index out of range or a
  /// broken image gives the magenta texture and a diagnostic, in which `shown_by` names the material and an object.
  const Texture* load(int index, const std::string& shown_by, std::vector<Diagnostic>& diagnostics);
  size_t memory_bytes() const;
  int decoded_count() const;  ///< number of images in use that could be read
  int kept_count() const;     ///< number of these that came from the previous store
  int tiled_count() const;    ///< number of these of which only tiles are in memory
  int made_count() const;     ///< number of these whose files of tiles were made
  /// What has been read of the tiles; all is 0 if there are none.
  TileStatistics tile_statistics() const;
  /// Frees the textures of the previous store that are not in use. Call it after all images have been loaded.
  void forget_previous();

 private:
  static const Texture& magenta();
  bool load_whole(Texture& texture, const ImageDescription& image, const Report& report, TiledTexture& facts);
  bool load_from_cache(Texture& texture, const ImageDescription& image, const Report& report);
  const Texture* load_tiles(int index, const std::string& shown_by, std::vector<Diagnostic>& diagnostics);
  /// Returns the number of texels that were not finite and were set to 0.
  int64_t fill(Texture& texture, const ImageDescription& image, const DecodedImage& decoded, const Report& report);

  struct Data;
  std::unique_ptr<Data> data_;
};

/// The memory of the image as a texture, from the header of its file; 0 if the file cannot be read.
uint64_t texture_bytes(const ImageDescription& image);

class Texture {
 public:
  enum class Storage : uint8_t { Byte, Short, Half, Float, Tiles, Cached };

  /// Linear RGBA at `uv` (v points up). The colour is unassociated (straight), as from Blender's Image Texture node if
  /// its alpha output is used.
  Vec4 lookup(Vec2 uv, Interpolation interpolation, Extension extension) const {
    return sample(uv, interpolation, extension, true);
  }
  /// The same, with the colour multiplied by alpha unless `unassociate` is set.
  Vec4 sample(Vec2 uv, Interpolation interpolation, Extension extension, bool unassociate) const;
  /// The mean over a footprint, if the texture is in the cache of tiles. Otherwise the same as `sample`.
  Vec4 sample_over(Vec2 uv, const UvFootprint& footprint, Interpolation interpolation, Extension extension,
                   bool unassociate) const;
  /// Whether it or one of its tiles has levels (tile_cache.h).
  bool has_levels() const;
  int width() const { return width_; }
  int height() const { return height_; }
  size_t memory_bytes() const { return texels_.size(); }

 private:
  friend class TextureStore;
  template <typename Texel>
  Vec4 interpolate(Vec2 uv, Interpolation interpolation, Extension extension) const;
  const Texture& tile(Vec2& uv) const;
  const Texture* tile_at(Vec2& uv) const;
  Vec4 decoded(Vec4 value, bool unassociate) const;
  [[gnu::noinline]] Vec4 sample_finest(Vec2 uv, Interpolation interpolation, Extension extension,
                                       bool unassociate) const;
  [[gnu::noinline]] Vec4 sample_tile(Vec2 uv, Interpolation interpolation, Extension extension, bool unassociate) const;

  int width_ = 0, height_ = 0;
  Storage storage_ = Storage::Byte;
  bool srgb_ = false;            ///< sRGB is decoded after interpolation
  bool has_alpha_ = false;       ///< some alpha is not 1 and applies to the colour (not a data or channel-packed image)
  std::vector<uint8_t> texels_;  ///< RGBA, rows from the bottom up
  std::shared_ptr<const TiledImage> cached_;  ///< with Storage::Cached
  std::vector<const Texture*> tiles_;         ///< by number - 1001; the last one replaces those that are missing
};

/// The parameters of an image instruction.
struct ImageLookup {
  const Texture* texture = nullptr;
  int image = -1;  ///< index in the scene's list
  Interpolation interpolation = Interpolation::Linear;
  Extension extension = Extension::Repeat;
  bool unassociate = false;  ///< the alpha output is used, so the colour is divided by alpha
  float blend = 0.0f;        ///< blending of box projection
};

}  // namespace ajar
