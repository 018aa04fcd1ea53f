// Images as textures. texture.cpp alone includes OpenImageIO.
//
// Texels are decoded when first asked for by a visible material at build time, converted to
// the scene's linear space (8-bit sRGB stays bytes with a table), and looked up with
// Blender's interpolation and extension. A missing or unreadable image is magenta, and reported.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scene/scene_description.h"

namespace ajar {

struct Diagnostic;
enum class Interpolation : uint8_t { Closest, Linear, Cubic };
enum class Extension : uint8_t { Repeat, Extend, Clip, Mirror };

class Texture;

class TextureStore {
 public:
  explicit TextureStore(std::vector<ImageDescription> images);
  TextureStore(TextureStore&&) noexcept;
  ~TextureStore();

  /// Decode image `index` (once) and return its handle; the handle lives as long as the store.
  /// Out-of-range or broken images give the magenta texture and a diagnostic.
  const Texture* load(int index, const std::string& color_space_override, std::vector<Diagnostic>& diagnostics);
  size_t memory_bytes() const;
  int decoded_count() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

class Texture {
 public:
  /// Linear RGBA at `uv` (v up). Colour is unassociated (straight) as Blender's Image Texture node outputs it.
  Vec4 lookup(Vec2 uv, Interpolation interpolation, Extension extension) const;
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  friend class TextureStore;
  int width_ = 0, height_ = 0;
  bool bytes_ = false, opaque_ = false, srgb_ = false;
  std::vector<uint8_t> texels8_;
  std::vector<float> texels32_;
};

}  // namespace ajar
