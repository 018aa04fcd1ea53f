// Files of textures in tiles and levels (TIFF), which a render reads tile by tile (tile_cache.h).
//
// A file is made of the texels that a whole texture would have, so level 0 equals that texture bit by bit. Its name has a
// hash of all that the texels depend on: the place, the time and the size of the image file, or the bytes of a packed
// image, the colour spaces and the limits of its size. An image that has changed thus has another file. A file appears
// when it is complete; its last bytes tell its length, so a file that was cut is not used.
#pragma once

#include <string>
#include <vector>

#include "description/scene_description.h"
#include "shading/images/mip_levels.h"

namespace ajar {

/// A texture in a file. Its levels end with the first that is one tile.
struct TiledTexture {
  static constexpr int kTile = 64;  ///< texels along the sides of a tile
  int width = 0, height = 0;
  TexelKind kind;
  bool float_source = false;  ///< the image had floats: for the choice of the default colour space
  int64_t repaired = 0;       ///< texels that were not finite
};

int level_count(int width, int height);

struct TiledFileName {
  std::string path;      ///< empty: the image cannot have such a file
  std::string why_none;  ///< then
};
/// The file of an image. `folder` is absolute or relative to the file of the image; empty: the folder of that file.
TiledFileName tiled_file_of(const ImageDescription& image, const ColorDescription& color, const std::string& folder);

/// Writes the file from RGBA texels, which are level 0. Returns why it could not be written; empty: it is there.
std::string write_tiled(const std::string& path, const TiledTexture& texture, const std::vector<uint8_t>& texels);
/// Reads what a file says about its texture. Returns false if it is missing, incomplete or not one of these files.
bool read_tiled(const std::string& path, TiledTexture& texture);

}  // namespace ajar
