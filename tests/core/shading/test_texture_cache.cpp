#include "shading/images/tile_cache.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include "math/hash.h"
#include "math/srgb.h"
#include "platform/platform.h"
#include "shading/images/tiled_file.h"

namespace ajar::test_texture_cache {

namespace {

namespace fs = std::filesystem;

struct Directory {
  fs::path path = fs::temp_directory_path() / ("ajar-tiles-" + std::to_string(platform::process_id()));
  Directory() { fs::create_directories(path); }
  ~Directory() {
    fs::permissions(path, fs::perms::owner_all);
    fs::remove_all(path);
  }
  std::string file(const std::string& name) const { return (path / name).string(); }
  std::vector<fs::path> tiled() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(path))
      if (entry.path().string().ends_with(".ajar.tif")) files.push_back(entry.path());
    return files;
  }
};

template <typename T>
void write(const std::string& path, int width, int height, int channels, OIIO::TypeDesc type,
           const std::vector<T>& values) {
  const auto out = OIIO::ImageOutput::create(path);
  ASSERT_TRUE(out) << OIIO::geterror();
  OIIO::ImageSpec spec(width, height, channels, type);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  ASSERT_TRUE(out->open(path, spec)) << out->geterror();
  ASSERT_TRUE(out->write_image(OIIO::BaseTypeFromC<T>::value, values.data()));
  out->close();
}

std::vector<uint8_t> noise(int width, int height, int channels, uint32_t seed = 1) {
  std::vector<uint8_t> values;
  for (uint32_t i = 0; i < uint32_t(width * height * channels); ++i)
    values.push_back(uint8_t(nodes::hash_words<2>({i, seed}) >> 24));
  return values;
}

ImageDescription image_of(const std::string& path) {
  ImageDescription image;
  image.name = "Image";
  image.path = path;
  return image;
}

TextureCacheOptions generating(const std::string& folder, int megabytes = 1024) {
  return {true, true, folder, megabytes};
}

TextureStore store_of(const ImageDescription& image, const TextureCacheOptions& options = {}) {
  return TextureStore({image}, nullptr, {}, options);
}

constexpr Interpolation kInterpolations[] = {Interpolation::Closest, Interpolation::Linear, Interpolation::Cubic};
constexpr Extension kExtensions[] = {Extension::Repeat, Extension::Extend, Extension::Clip, Extension::Mirror};

/// Whether both are equal but for the rounding of the sums of texels, which depends on the compiler.
bool is_close(Vec4 a, Vec4 b) {
  for (int c = 0; c < 4; ++c)
    if (!(std::abs(a[c] - b[c]) <= 2e-6f * (1.0f + std::abs(a[c])))) return false;
  return true;
}

/// Expects that both textures have the same texels bit by bit, at places of which some are outside and some between
/// tiles.
void expect_equal(const Texture& a, const Texture& b) {
  ASSERT_EQ(a.width(), b.width());
  ASSERT_EQ(a.height(), b.height());
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x) {
      const Vec2 uv((float(x) + 0.5f) / float(a.width()), (float(y) + 0.5f) / float(a.height()));
      for (const bool unassociate : {false, true})
        ASSERT_EQ(a.sample(uv, Interpolation::Closest, Extension::Repeat, unassociate),
                  b.sample(uv, Interpolation::Closest, Extension::Repeat, unassociate))
            << x << " " << y;
    }
  for (int i = 0; i < 500; ++i) {
    const Vec2 uv(-0.6f + 2.3f * float(i * 7 % 500) / 500.0f, -0.4f + 1.9f * float(i * 13 % 500) / 500.0f);
    for (const Interpolation interpolation : kInterpolations)
      for (const Extension extension : kExtensions)
        ASSERT_TRUE(
            is_close(a.sample(uv, interpolation, extension, false), b.sample(uv, interpolation, extension, false)))
            << i;
  }
}

/// A footprint of this many texels.
UvFootprint texels(const Texture& t, float width) {
  return {{width / float(t.width()), 0.0f}, {0.0f, width / float(t.height())}};
}

std::string first_message(const Diagnostics& diagnostics) {
  return diagnostics.empty() ? "" : diagnostics[0].object + ": " + diagnostics[0].message;
}

void replace_bytes(const fs::path& path, size_t from, size_t count, char value) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(std::streamoff(from));
  for (size_t i = 0; i < count; ++i) file.put(value);
}

}  // namespace

TEST(TextureCache, level_0_is_the_whole_texture_bit_by_bit) {
  const Directory directory;
  std::vector<ImageDescription> images;
  const auto add = [&](const std::string& name) -> ImageDescription& {
    images.push_back(image_of(directory.file(name)));
    return images.back();
  };
  for (int channels = 1; channels <= 4; ++channels) {
    const std::string name = "bytes" + std::to_string(channels) + ".png";
    write(directory.file(name), 150, 97, channels, OIIO::TypeDesc::UINT8, noise(150, 97, channels));
    add(name);
    add(name).color_space = "Non-Color";
  }
  for (const AlphaMode mode : {AlphaMode::ChannelPacked, AlphaMode::None, AlphaMode::AlwaysStraight})
    add("bytes4.png").alpha_mode = mode;
  add("bytes4.png").size_limit = 80;
  std::vector<float> floats;
  for (const uint8_t byte : noise(70, 131, 4)) floats.push_back(float(byte) / 100.0f - 0.3f);
  write(directory.file("shorts.png"), 70, 131, 4, OIIO::TypeDesc::UINT16, floats);
  write(directory.file("halves.exr"), 70, 131, 4, OIIO::TypeDesc::HALF, floats);
  write(directory.file("floats.exr"), 70, 131, 4, OIIO::TypeDesc::FLOAT, floats);
  for (const char* name : {"shorts.png", "halves.exr", "floats.exr"}) add(name);
  for (const char* name : {"halves.exr", "floats.exr"}) add(name).color_space = "";

  const TextureCacheOptions options = generating(directory.file("tiles"));
  for (const ImageDescription& image : images) {
    TextureStore whole = store_of(image);
    for (const int expected_made : {1, 0}) {  // made, and then read
      TextureStore tiled = store_of(image, options);
      Diagnostics diagnostics;
      const Texture* const t = tiled.load(0, "", diagnostics);
      EXPECT_TRUE(diagnostics.empty()) << first_message(diagnostics);
      ASSERT_TRUE(t->has_levels()) << image.path;
      EXPECT_EQ(tiled.made_count(), expected_made) << image.path;
      EXPECT_EQ(tiled.memory_bytes(), 0u);
      expect_equal(*whole.load(0, "", diagnostics), *t);
    }
  }
}

TEST(TextureCache, packed_and_generated_images_are_tiled_in_an_absolute_folder) {
  const Directory directory;
  write(directory.file("a.png"), 100, 80, 3, OIIO::TypeDesc::UINT8, noise(100, 80, 3));
  ImageDescription packed, generated;
  std::ifstream file(directory.file("a.png"), std::ios::binary);
  packed.packed.assign(std::istreambuf_iterator<char>(file), {});
  packed.name = generated.name = "In/memory";
  generated.width = 70, generated.height = 66;
  for (int i = 0; i < 70 * 66 * 4; ++i) generated.pixels.push_back(float(i % 1234) / 321.0f);
  for (const ImageDescription& image : {packed, generated}) {
    TextureStore whole = store_of(image), tiled = store_of(image, generating(directory.path.string())),
                 relative = store_of(image, generating("tiles"));
    Diagnostics diagnostics;
    expect_equal(*whole.load(0, "", diagnostics), *tiled.load(0, "", diagnostics));
    EXPECT_EQ(tiled.tiled_count(), 1);
    EXPECT_TRUE(diagnostics.empty()) << first_message(diagnostics);
    expect_equal(*whole.load(0, "", diagnostics), *relative.load(0, "", diagnostics));
    EXPECT_EQ(relative.tiled_count(), 0);
    ASSERT_EQ(diagnostics.size(), 1u);
    EXPECT_NE(diagnostics[0].message.find("whole image is loaded"), std::string::npos) << first_message(diagnostics);
  }
}

TEST(TextureCache, levels_have_the_mean_light_of_the_texels_that_they_cover) {
  const Directory directory;
  // Sides that are odd at some levels.
  std::vector<uint8_t> values;
  for (int y = 0; y < 221; ++y)
    for (int x = 0; x < 300; ++x)
      for (int c = 0; c < 4; ++c)
        values.push_back(uint8_t(128.0 + 50.0 * std::sin(0.11 * x + c) * std::cos(0.07 * y + 2 * c)));
  write(directory.file("a.png"), 300, 221, 4, OIIO::TypeDesc::UINT8, values);
  for (const AlphaMode alpha : {AlphaMode::None, AlphaMode::Straight})
    for (const char* space : {"sRGB", "Non-Color"}) {
      ImageDescription image = image_of(directory.file("a.png"));
      image.color_space = space;
      image.alpha_mode = alpha;
      TextureStore whole = store_of(image), tiled = store_of(image, generating("tiles"));
      Diagnostics diagnostics;
      const Texture &all = *whole.load(0, "", diagnostics), &t = *tiled.load(0, "", diagnostics);
      const auto mean = [&](float width, int steps) {
        glm::dvec4 sum(0.0);
        for (int y = 0; y < steps; ++y)
          for (int x = 0; x < steps; ++x) {
            const Vec2 uv((float(x) + 0.5f) / float(steps), (float(y) + 0.5f) / float(steps));
            const Vec4 c = width > 0.0f
                               ? t.sample_over(uv, texels(t, width), Interpolation::Linear, Extension::Repeat, true)
                               : all.sample(uv, Interpolation::Linear, Extension::Repeat, true);
            sum += glm::dvec4(glm::dvec3(c) * (image.color_space == "sRGB" ? double(c.w) : 1.0), c.w);
          }
        return sum / double(steps * steps);
      };
      const glm::dvec4 expected = mean(0.0f, 1500);
      // The interpolation of encoded values is not that of light, so the levels differ a little.
      for (const float width : {2.0f, 4.0f, 100.0f})
        for (int c = 0; c < 4; ++c)
          EXPECT_NEAR(mean(width, 600)[c], expected[c], 0.03 * expected[c]) << width << " " << space << int(alpha);
    }
}

TEST(TextureCache, a_level_of_a_constant_image_is_constant) {
  const Directory directory;
  for (const uint8_t value : {1, 10, 77, 200, 255}) {
    const std::string path = directory.file("c" + std::to_string(value) + ".png");
    write(path, 301, 200, 3, OIIO::TypeDesc::UINT8, std::vector<uint8_t>(301 * 200 * 3, value));
    TextureStore tiled = store_of(image_of(path), generating("tiles"));
    Diagnostics diagnostics;
    const Texture& t = *tiled.load(0, "", diagnostics);
    const float expected = linear_from_srgb(float(value) / 255.0f);
    for (const float width : {1.0f, 2.1f, 3.0f, 4.0f, 5.0f, 1e9f})
      EXPECT_NEAR(t.sample_over({0.3f, 0.7f}, texels(t, width), Interpolation::Linear, Extension::Repeat, true).x,
                  expected, 1e-5f);
  }
}

TEST(TextureCache, the_level_is_never_coarser_than_the_footprint_and_changes_without_a_step) {
  const Directory directory;
  write(directory.file("a.png"), 512, 512, 3, OIIO::TypeDesc::UINT8, noise(512, 512, 3));
  TextureStore tiled = store_of(image_of(directory.file("a.png")), generating("tiles"));
  Diagnostics diagnostics;
  const Texture& t = *tiled.load(0, "", diagnostics);
  const auto at = [&](const UvFootprint& f) {
    return t.sample_over({0.3711f, 0.61f}, f, Interpolation::Linear, Extension::Repeat, true);
  };
  const Vec4 finest = t.lookup({0.3711f, 0.61f}, Interpolation::Linear, Extension::Repeat);
  EXPECT_EQ(at(texels(t, 1.0f)), finest);
  EXPECT_EQ(at(texels(t, 1.999f)), finest);
  EXPECT_NE(at(texels(t, 2.5f)), finest);
  // A footprint that is narrow in one direction needs the texels of that direction, whatever the axes are.
  EXPECT_EQ(at({{40.0f / 512, 0.0f}, {0.0f, 1.0f / 512}}), finest);
  EXPECT_EQ(at({{40.0f / 512, 40.0f / 512}, {1.0f / 512, -1.0f / 512}}), finest);
  EXPECT_EQ(at({{NAN, 0.0f}, {0.0f, INFINITY}}), finest);
  Vec4 last = finest;
  for (float width = 1.9f; width < 20.0f; width *= 1.002f) {
    const Vec4 now = at(texels(t, width));
    EXPECT_LT(std::abs(now.x - last.x), 0.02f) << width;
    last = now;
  }
}

TEST(TextureCache, threads_read_the_same_texels_under_a_tiny_limit) {
  const Directory directory;
  std::vector<ImageDescription> images;
  for (int i = 0; i < 6; ++i) {
    const std::string path = directory.file("i" + std::to_string(i) + ".png");
    write(path, 1500, 1100, 3, OIIO::TypeDesc::UINT8, noise(1500, 1100, 3, uint32_t(i)));
    images.push_back(image_of(path));
  }
  TextureStore whole(images), tiled(images, nullptr, {}, generating("tiles", 16));
  Diagnostics diagnostics;
  std::vector<const Texture*> expected, read;
  for (int i = 0; i < 6; ++i) {
    expected.push_back(whole.load(i, "", diagnostics));
    read.push_back(tiled.load(i, "", diagnostics));
  }
  ASSERT_EQ(tiled.tiled_count(), 6);
  std::atomic<int> different{0};
  std::vector<std::thread> threads;
  for (uint32_t k = 0; k < 8; ++k)
    threads.emplace_back([&, k] {
      for (uint32_t i = 0; i < 8000; ++i) {
        const size_t image = i / 8 % 6;
        const Vec2 uv(float(nodes::hash_words<3>({i, k, 1})) * 0x1p-32f,
                      float(nodes::hash_words<3>({i, k, 2})) * 0x1p-32f);
        if (!is_close(read[image]->lookup(uv, Interpolation::Linear, Extension::Repeat),
                      expected[image]->lookup(uv, Interpolation::Linear, Extension::Repeat)))
          ++different;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(different, 0);
  const TileStatistics s = tiled.tile_statistics();
  EXPECT_EQ(s.limit_bytes, 16u << 20);
  const uint64_t all_tiles = 6 * 24 * 18;  // of level 0
  EXPECT_GT(s.tiles_read, all_tiles);      // some were evicted and read again
  // OpenImageIO lets one thread free tiles and does not stop the others meanwhile. On a busy machine they added up to
  // 4 MiB. All tiles of the images have 52 MiB.
  EXPECT_LE(s.peak_bytes, 24u << 20);
  EXPECT_GT(s.peak_bytes, 8u << 20);
  EXPECT_EQ(s.failed_tiles, 0u);
}

TEST(TextureCache, a_changed_image_has_another_file) {
  const Directory directory;
  const std::string path = directory.file("a.png");
  const ImageDescription image = image_of(path);
  Diagnostics diagnostics;
  std::unique_ptr<TextureStore> previous;
  for (uint32_t seed = 1; seed < 4; ++seed) {
    write(path, 90, 90, 3, OIIO::TypeDesc::UINT8, noise(90, 90, 3, seed));
    fs::last_write_time(path, fs::file_time_type::clock::now() + std::chrono::hours(seed));
    TextureStore whole = store_of(image);
    auto tiled = std::make_unique<TextureStore>(std::vector{image}, previous.get(), ColorDescription(), generating(""));
    expect_equal(*whole.load(0, "", diagnostics), *tiled->load(0, "", diagnostics));
    EXPECT_EQ(tiled->made_count(), 1);
    EXPECT_EQ(tiled->tiled_count(), 1);
    EXPECT_EQ(directory.tiled().size(), seed);
    previous = std::move(tiled);
  }
  // The same image is kept.
  TextureStore again({image}, previous.get(), ColorDescription(), generating(""));
  again.load(0, "", diagnostics);
  EXPECT_EQ(again.kept_count(), 1);
  EXPECT_TRUE(diagnostics.empty()) << first_message(diagnostics);
}

TEST(TextureCache, an_incomplete_file_is_made_again) {
  const Directory directory;
  const std::string path = directory.file("a.png");
  write(path, 500, 300, 3, OIIO::TypeDesc::UINT8, noise(500, 300, 3));
  const ImageDescription image = image_of(path);
  Diagnostics diagnostics;
  TextureStore whole = store_of(image);
  { store_of(image, generating("")).load(0, "", diagnostics); }
  ASSERT_EQ(directory.tiled().size(), 1u);
  const fs::path file = directory.tiled()[0];
  const uintmax_t size = fs::file_size(file);
  const std::vector<std::function<void()>> damages{
      [&] { fs::resize_file(file, size / 2); }, [&] { fs::resize_file(file, size - 1); },
      [&] { fs::resize_file(file, 0); }, [&] { replace_bytes(file, 0, 16, 'x'); },
      [&] { std::ofstream(file, std::ios::app) << "more"; }};
  for (const auto& damage : damages) {
    damage();
    TextureStore tiled = store_of(image, generating(""));
    expect_equal(*whole.load(0, "", diagnostics), *tiled.load(0, "", diagnostics));
    EXPECT_EQ(tiled.made_count(), 1);
    TiledTexture read;
    EXPECT_TRUE(read_tiled(file.string(), read));
    EXPECT_TRUE(diagnostics.empty()) << first_message(diagnostics);
  }
}

TEST(TextureCache, damage_within_a_file_is_counted_and_the_file_is_made_again) {
  const Directory directory;
  const std::string path = directory.file("a.png");
  write(path, 500, 300, 3, OIIO::TypeDesc::UINT8, noise(500, 300, 3));
  const ImageDescription image = image_of(path);
  Diagnostics diagnostics;
  { store_of(image, generating("")).load(0, "", diagnostics); }
  const fs::path file = directory.tiled().at(0);
  replace_bytes(file, fs::file_size(file) / 3, 3000, 'x');
  {  // Who may not write keeps the file.
    TextureStore reader = store_of(image, {true, false, "", 32});
    const Texture& t = *reader.load(0, "", diagnostics);
    for (int y = 0; y < 300; ++y) t.lookup({0.5f, (float(y) + 0.5f) / 300}, Interpolation::Linear, Extension::Repeat);
    for (int x = 0; x < 500; ++x) t.lookup({(float(x) + 0.5f) / 500, 0.5f}, Interpolation::Linear, Extension::Repeat);
    EXPECT_TRUE(fs::exists(file));
    EXPECT_FALSE(reader.tile_statistics().removed);
  }
  TextureStore damaged = store_of(image, generating(""));
  const Texture& t = *damaged.load(0, "", diagnostics);
  int magenta = 0;
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 500; ++x)
      magenta += t.lookup({(float(x) + 0.5f) / 500, (float(y) + 0.5f) / 300}, Interpolation::Closest,
                          Extension::Repeat) == Vec4(1, 0, 1, 1);
  EXPECT_GT(magenta, 0);
  EXPECT_GT(damaged.tile_statistics().failed_tiles, 0u);
  EXPECT_EQ(damaged.tile_statistics().failed_file, file.string());
  EXPECT_TRUE(damaged.tile_statistics().removed);
  EXPECT_FALSE(fs::exists(file));
  // The next scene continues from this store, and makes the file again.
  TextureStore next({image}, &damaged, ColorDescription(), generating("")), whole = store_of(image);
  expect_equal(*whole.load(0, "", diagnostics), *next.load(0, "", diagnostics));
  EXPECT_EQ(next.made_count(), 1);
  EXPECT_TRUE(fs::exists(file));
}

TEST(TextureCache, images_are_whole_where_no_file_can_be_written) {
  const Directory directory;
  const std::string path = directory.file("a.png");
  write(path, 100, 80, 3, OIIO::TypeDesc::UINT8, noise(100, 80, 3));
  std::ofstream(directory.file("file")) << "no folder";
  const ImageDescription image = image_of(path);
  TextureStore whole = store_of(image), tiled = store_of(image, generating(directory.file("file")));
  Diagnostics diagnostics;
  expect_equal(*whole.load(0, "", diagnostics), *tiled.load(0, "", diagnostics));
  EXPECT_EQ(tiled.tiled_count(), 0);
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_EQ(diagnostics[0].object, "Image");
  EXPECT_NE(diagnostics[0].message.find(directory.file("file")), std::string::npos) << first_message(diagnostics);
  EXPECT_NE(diagnostics[0].message.find("whole image is loaded"), std::string::npos) << first_message(diagnostics);
}

TEST(TextureCache, files_are_made_only_if_that_is_allowed) {
  const Directory directory;
  write(directory.file("a.png"), 100, 80, 3, OIIO::TypeDesc::UINT8, noise(100, 80, 3));
  const ImageDescription image = image_of(directory.file("a.png"));
  const TextureCacheOptions reading{true, false, "", 1024};
  Diagnostics diagnostics;
  TextureStore before = store_of(image, reading);
  EXPECT_FALSE(before.load(0, "", diagnostics)->has_levels());
  EXPECT_TRUE(directory.tiled().empty());
  { store_of(image, generating("")).load(0, "", diagnostics); }
  TextureStore after = store_of(image, reading);
  EXPECT_TRUE(after.load(0, "", diagnostics)->has_levels());
  EXPECT_TRUE(diagnostics.empty()) << first_message(diagnostics);
}

TEST(TextureCache, messages_about_an_image_come_with_its_file_too) {
  const Directory directory;
  std::vector<float> values(80 * 80 * 4, 0.5f);
  values[5] = NAN;
  write(directory.file("a.exr"), 80, 80, 4, OIIO::TypeDesc::FLOAT, values);
  ImageDescription image = image_of(directory.file("a.exr"));
  image.color_space = "Unknown";
  Diagnostics whole, made, read;
  store_of(image).load(0, "", whole);
  store_of(image, generating("")).load(0, "", made);
  store_of(image, generating("")).load(0, "", read);
  ASSERT_EQ(whole.size(), 2u);
  for (const Diagnostics* others : {&made, &read}) {
    ASSERT_EQ(others->size(), 2u);
    for (const Diagnostic& diagnostic : *others)
      EXPECT_TRUE(diagnostic.message == whole[0].message || diagnostic.message == whole[1].message);
  }
}

TEST(TextureCache, an_unreadable_image_is_magenta_and_reported) {
  const Directory directory;
  std::ofstream(directory.file("a.png")) << "no image";
  for (const char* name : {"a.png", "missing.png"}) {
    TextureStore store = store_of(image_of(directory.file(name)), generating(""));
    Diagnostics diagnostics;
    EXPECT_EQ(store.load(0, "", diagnostics)->lookup({0.5f, 0.5f}, Interpolation::Linear, Extension::Repeat),
              Vec4(1, 0, 1, 1));
    ASSERT_EQ(diagnostics.size(), 1u);
    EXPECT_NE(diagnostics[0].message.find("magenta"), std::string::npos) << first_message(diagnostics);
  }
}

}  // namespace ajar::test_texture_cache
