// The coarser levels of a texture (mip maps).
//
// Level n + 1 has half the sides of level n, rounded down, and covers the same square of coordinates: each of its texels
// is the mean of the texels below it, weighted by the area that they share. The mean is taken of linear colours times
// alpha, so that a surface far away has the mean light of the same surface close by.
#pragma once

#include <cstdint>
#include <vector>

#include "shading/images/texture.h"

namespace ajar {

/// What the texels of a texture are.
struct TexelKind {
  Texture::Storage storage = Texture::Storage::Byte;
  bool srgb = false;       ///< they have the curve of sRGB
  bool has_alpha = false;  ///< colours are multiplied by an alpha that varies
};

/// The sides of a level.
inline int side_of_level(int side, int level) { return side >> level > 1 ? side >> level : 1; }

/// The RGBA texels of the next level, from those of this one.
std::vector<uint8_t> next_level(const std::vector<uint8_t>& texels, int width, int height, TexelKind kind);

}  // namespace ajar
