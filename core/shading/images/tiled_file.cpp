#include "shading/images/tiled_file.h"

#include <OpenImageIO/imageio.h>

#include <cstdio>
#include <cstring>
#include <filesystem>

#include "platform/atomic_file.h"
#include "platform/platform.h"
#include "shading/images/image_file.h"

namespace ajar {

namespace {

constexpr char kFormat[] = "Ajar texture 1";

/// The last bytes of a file.
struct Ending {
  char mark[8] = {'A', 'J', 'A', 'R', 'T', 'E', 'X', '1'};
  uint64_t length = 0;  ///< of the file without these bytes
};

OIIO::TypeDesc type_of(Texture::Storage storage) {
  switch (storage) {
    case Texture::Storage::Byte: return OIIO::TypeDesc::UINT8;
    case Texture::Storage::Short: return OIIO::TypeDesc::UINT16;
    case Texture::Storage::Half: return OIIO::TypeDesc::HALF;
    default: return OIIO::TypeDesc::FLOAT;
  }
}

std::string text_of(const TiledTexture& t) {
  char text[160];
  std::snprintf(text, sizeof text, "%s: %d x %d, storage %d, srgb %d, alpha %d, floats %d, repaired %lld", kFormat,
                t.width, t.height, int(t.kind.storage), int(t.kind.srgb), int(t.kind.has_alpha), int(t.float_source),
                static_cast<long long>(t.repaired));
  return text;
}

bool from_text(const std::string& text, TiledTexture& t) {
  int storage = 0, srgb = 0, alpha = 0, floats = 0;
  long long repaired = 0;
  const std::string form = std::string(kFormat) + ": %d x %d, storage %d, srgb %d, alpha %d, floats %d, repaired %lld";
  if (std::sscanf(text.c_str(), form.c_str(), &t.width, &t.height, &storage, &srgb, &alpha, &floats, &repaired) != 7 ||
      storage < 0 || storage > int(Texture::Storage::Float))
    return false;
  t.kind = {Texture::Storage(storage), srgb != 0, alpha != 0};
  t.float_source = floats != 0;
  t.repaired = repaired;
  return true;
}

/// The header of a level. No channel is called alpha, so that no library multiplies by it.
OIIO::ImageSpec spec_of(const TiledTexture& t, int level) {
  OIIO::ImageSpec spec(side_of_level(t.width, level), side_of_level(t.height, level), 4, type_of(t.kind.storage));
  spec.channelnames = {"c0", "c1", "c2", "c3"};
  spec.alpha_channel = -1;
  spec.tile_width = spec.tile_height = TiledTexture::kTile;
  spec.tile_depth = 1;
  spec.attribute("ImageDescription", text_of(t));
  spec.attribute("compression", "zip");
  spec.attribute("tiff:zipquality",
                 1);  // photographs are hardly larger than with 6, and written in a third of the time
  spec.attribute("tiff:half", 1);
  spec.attribute("textureformat", "Plain Texture");  // further images in the file are levels
  return spec;
}

bool add_ending(const std::string& path) {
  std::error_code error;
  Ending ending;
  ending.length = uint64_t(std::filesystem::file_size(platform::file_path(path), error));
  std::FILE* const file = error ? nullptr : platform::open_file(path, "ab");
  if (!file) return false;
  const bool written = std::fwrite(&ending, 1, sizeof ending, file) == sizeof ending;
  return std::fclose(file) == 0 && written;
}

bool has_ending(const std::string& path) {
  std::error_code error;
  const uint64_t size = uint64_t(std::filesystem::file_size(platform::file_path(path), error));
  std::FILE* const file = error ? nullptr : platform::open_file(path, "rb");
  if (!file) return false;
  Ending ending;
  const Ending expected;
  const bool complete = std::fseek(file, -long(sizeof ending), SEEK_END) == 0 &&
                        std::fread(&ending, 1, sizeof ending, file) == sizeof ending &&
                        std::memcmp(ending.mark, expected.mark, sizeof ending.mark) == 0 &&
                        ending.length + sizeof ending == size;
  std::fclose(file);
  return complete;
}

std::string write_levels(const std::string& path, const TiledTexture& texture, const std::vector<uint8_t>& texels) {
  const auto out = OIIO::ImageOutput::create("tiff");
  if (!out) return OIIO::geterror();
  int width = texture.width, height = texture.height;
  std::vector<uint8_t> coarse;
  for (int level = 0; level < level_count(texture.width, texture.height); ++level) {
    if (level > 0) {
      coarse = next_level(level == 1 ? texels : coarse, width, height, texture.kind);
      width = side_of_level(texture.width, level);
      height = side_of_level(texture.height, level);
    }
    const OIIO::ImageSpec spec = spec_of(texture, level);
    if (!out->open(path, spec, level == 0 ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage) ||
        !out->write_image(spec.format, (level == 0 ? texels : coarse).data()))
      return out->geterror();
  }
  return out->close() ? std::string() : out->geterror();
}

std::string utf8(const std::filesystem::path& path) {
  const std::u8string text = path.u8string();
  return {text.begin(), text.end()};
}

void add(Checksum& sum, const std::string& text) {
  const uint64_t size = text.size();
  sum.add(&size, sizeof size);
  sum.add(text.data(), text.size());
}

}  // namespace

int level_count(int width, int height) {
  int count = 1;
  while (std::max(side_of_level(width, count - 1), side_of_level(height, count - 1)) > TiledTexture::kTile) ++count;
  return count;
}

TiledFileName tiled_file_of(const ImageDescription& image, const ColorDescription& color, const std::string& folder) {
  namespace fs = std::filesystem;
  const bool has_file = image.packed.empty() && image.pixels.empty();
  fs::path place = platform::file_path(folder);
  if (!place.is_absolute()) {
    if (!has_file || image.path.empty())
      return {"", "it has no file of its own, and the folder of the texture cache is relative to such files"};
    place = platform::file_path(image.path).parent_path() / place;
  }
  Checksum sum;
  add(sum, kFormat);
  if (has_file) {
    std::error_code error;
    const fs::path source = platform::file_path(image.path);
    const int64_t time = int64_t(fs::last_write_time(source, error).time_since_epoch().count());
    const uint64_t size = error ? 0 : uint64_t(fs::file_size(source, error));
    if (error) return {"", "its file cannot be read"};
    add(sum, image.path);
    sum.add(&time, sizeof time);
    sum.add(&size, sizeof size);
  }
  const uint64_t sizes[2] = {image.packed.size(), image.pixels.size()};
  sum.add(sizes, sizeof sizes);
  sum.add(image.packed.data(), image.packed.size());
  sum.add(image.pixels.data(), image.pixels.size() * sizeof(float));
  const int32_t numbers[4] = {image.width, image.height, int32_t(image.alpha_mode), image.size_limit};
  sum.add(numbers, sizeof numbers);
  sum.add(&image.resolution, sizeof image.resolution);
  for (const std::string& text : {image.color_space, color.config, color.working_space}) add(sum, text);

  std::string stem = has_file ? utf8(platform::file_path(image.path).stem()) : image.name;
  for (char& c : stem)
    if (std::strchr("/\\:*?\"<>|", c)) c = '_';
  char hash[32];
  std::snprintf(hash, sizeof hash, "_%016llx.ajar.tif", static_cast<unsigned long long>(sum.value()));
  return {utf8(place / platform::file_path(stem.substr(0, 80) + hash)), ""};
}

std::string write_tiled(const std::string& path, const TiledTexture& texture, const std::vector<uint8_t>& texels) {
  std::error_code error;
  const auto folder = platform::file_path(path).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) return error.message();
  AtomicPath file(path);
  if (const std::string problem = file.start(); !problem.empty()) return problem;
  if (const std::string problem = write_levels(file.unfinished(), texture, texels); !problem.empty()) return problem;
  if (!add_ending(file.unfinished())) return "it cannot be written";
  return file.commit();
}

bool read_tiled(const std::string& path, TiledTexture& texture) {
  if (!has_ending(path)) return false;
  const auto in = OIIO::ImageInput::open(path);
  if (!in) {
    (void)OIIO::geterror();
    return false;
  }
  TiledTexture found;
  if (!from_text(in->spec().get_string_attribute("ImageDescription"), found)) return false;
  for (int level = 0; level < level_count(found.width, found.height); ++level) {
    if (!in->seek_subimage(0, level)) return false;
    const OIIO::ImageSpec& spec = in->spec();
    if (spec.width != side_of_level(found.width, level) || spec.height != side_of_level(found.height, level) ||
        spec.nchannels != 4 || spec.format != type_of(found.kind.storage) || spec.tile_width != TiledTexture::kTile ||
        spec.tile_height != TiledTexture::kTile)
      return false;
  }
  texture = found;
  return true;
}

}  // namespace ajar
