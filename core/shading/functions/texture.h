// Images as textures. texture_store.cpp reads them, and alone includes OpenImageIO.
//
// Texels are decoded when first asked for by a visible material at build time and stored as the file has them (8 or 16
// bits, half, float). As in Cycles, interpolation happens on the encoded, alpha-associated values;
// sRGB becomes linear after it. A missing or unreadable image is magenta, and reported.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "description/scene_description.h"

namespace ajar {

struct Diagnostic;
enum class Interpolation : uint8_t { Closest, Linear, Cubic };
enum class Extension : uint8_t { Repeat, Extend, Clip, Mirror };

class Texture;

class TextureStore {
 public:
  /// What `previous` decoded of the same images is taken over from it.
  explicit TextureStore(std::vector<ImageDescription> images, TextureStore* previous = nullptr);
  TextureStore(TextureStore&&) noexcept;
  ~TextureStore();

  /// Decode image `index` (once) and return its handle; the handle lives as long as the store.
  /// Out-of-range or broken images give the magenta texture and a diagnostic.
  const Texture* load(int index, const std::string& color_space_override, std::vector<Diagnostic>& diagnostics);
  size_t memory_bytes() const;
  int decoded_count() const;  ///< images in use that could be read
  int kept_count() const;     ///< of these, taken over
  /// All images have been asked for: free what was not taken over.
  void forget_previous();

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// What the image takes as a texture, from its file's header; 0 for one that cannot be read.
uint64_t texture_bytes(const ImageDescription& image);

class Texture {
 public:
  enum class Storage : uint8_t { Byte, Short, Half, Float };

  /// Linear RGBA at `uv` (v up). Colour is unassociated (straight), what Blender's Image Texture node gives when its
  /// alpha output is used.
  Vec4 lookup(Vec2 uv, Interpolation interpolation, Extension extension) const {
    return sample(uv, interpolation, extension, true);
  }
  /// The same with colour left multiplied by alpha unless `unassociate`.
  Vec4 sample(Vec2 uv, Interpolation interpolation, Extension extension, bool unassociate) const;
  int width() const { return width_; }
  int height() const { return height_; }
  size_t memory_bytes() const { return texels_.size(); }

 private:
  friend class TextureStore;
  template <typename Texel>
  Vec4 interpolate(Vec2 uv, Interpolation interpolation, Extension extension) const;

  int width_ = 0, height_ = 0;
  Storage storage_ = Storage::Byte;
  bool srgb_ = false;            ///< decoded after interpolation
  bool has_alpha_ = false;       ///< some alpha is not 1, and colour belongs to it (not a data or channel-packed image)
  bool associate_ = false;       ///< texels are straight and multiplied by alpha when fetched
  std::vector<uint8_t> texels_;  ///< RGBA, rows from the bottom up
};

/// What an image instruction looks up.
struct ImageLookup {
  const Texture* texture = nullptr;
  int image = -1;  ///< in the scene's list
  Interpolation interpolation = Interpolation::Linear;
  Extension extension = Extension::Repeat;
  bool unassociate = false;  ///< the alpha output is used, so colour is divided by it
  float blend = 0.0f;        ///< box projection
};

}  // namespace ajar
