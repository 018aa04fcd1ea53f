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
enum class Interpolation : uint8_t { Closest, Linear, Cubic };
enum class Extension : uint8_t { Repeat, Extend, Clip, Mirror };

class Texture;

class TextureStore {
 public:
  /// Textures that `previous` has decoded from the same images are moved to this store.
  explicit TextureStore(std::vector<ImageDescription> images, TextureStore* previous = nullptr,
                        const ColorDescription& color = {});
  TextureStore(TextureStore&&) noexcept;
  ~TextureStore();

  /// Decodes image `index` once and returns its handle, which is valid as long as the store. An index out of range or a
  /// broken image gives the magenta texture and a diagnostic, in which `shown_by` names the material and an object.
  const Texture* load(int index, const std::string& shown_by, std::vector<Diagnostic>& diagnostics);
  size_t memory_bytes() const;
  int decoded_count() const;  ///< number of images in use that could be read
  int kept_count() const;     ///< number of these that came from the previous store
  /// Frees the textures of the previous store that are not in use. Call it after all images have been loaded.
  void forget_previous();

 private:
  static const Texture& magenta();
  const Texture* load_tiles(int index, const std::string& shown_by, std::vector<Diagnostic>& diagnostics);
  void fill(Texture& texture, const ImageDescription& image, const DecodedImage& decoded,
            const std::function<void(const std::string&)>& report);

  struct Data;
  std::unique_ptr<Data> data_;
};

/// The memory of the image as a texture, from the header of its file; 0 if the file cannot be read.
uint64_t texture_bytes(const ImageDescription& image);

class Texture {
 public:
  enum class Storage : uint8_t { Byte, Short, Half, Float, Tiles };

  /// Linear RGBA at `uv` (v points up). The colour is unassociated (straight), as from Blender's Image Texture node if
  /// its alpha output is used.
  Vec4 lookup(Vec2 uv, Interpolation interpolation, Extension extension) const {
    return sample(uv, interpolation, extension, true);
  }
  /// The same, with the colour multiplied by alpha unless `unassociate` is set.
  Vec4 sample(Vec2 uv, Interpolation interpolation, Extension extension, bool unassociate) const;
  int width() const { return width_; }
  int height() const { return height_; }
  size_t memory_bytes() const { return texels_.size(); }

 private:
  friend class TextureStore;
  template <typename Texel>
  Vec4 interpolate(Vec2 uv, Interpolation interpolation, Extension extension) const;
  const Texture& tile(Vec2& uv) const;
  [[gnu::noinline]] Vec4 sample_tile(Vec2 uv, Interpolation interpolation, Extension extension, bool unassociate) const;

  int width_ = 0, height_ = 0;
  Storage storage_ = Storage::Byte;
  bool srgb_ = false;            ///< sRGB is decoded after interpolation
  bool has_alpha_ = false;       ///< some alpha is not 1 and applies to the colour (not a data or channel-packed image)
  std::vector<uint8_t> texels_;  ///< RGBA, rows from the bottom up
  std::vector<const Texture*> tiles_;  ///< by number - 1001; the last one replaces those that are missing
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
