#include "shading/images/texture.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "platform/platform.h"
#include "shading/images/color_spaces.h"
#include "shading/shader_program.h"

namespace ajar::test_texture {

namespace {

double srgb_to_linear(double x) { return x < 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4); }

/// A directory that is deleted at the end of the test.
struct Directory {
  std::filesystem::path path = std::filesystem::temp_directory_path() /
                               ("ajar-test-" + std::to_string(platform::process_id()));
  Directory() { std::filesystem::create_directories(path); }
  ~Directory() { std::filesystem::remove_all(path); }
  std::string file(const std::string& name) const { return (path / name).string(); }
};

/// Writes an image whose rows are ordered from top to bottom.
template <typename T>
void write(const std::string& path, int width, int height, int channels, OIIO::TypeDesc type,
           const std::vector<T>& values) {
  const auto out = OIIO::ImageOutput::create(path);
  ASSERT_TRUE(out) << OIIO::geterror();
  OIIO::ImageSpec spec(width, height, channels, type);
  spec.attribute("oiio:UnassociatedAlpha", 1);  // as PNG and TGA store it
  ASSERT_TRUE(out->open(path, spec)) << out->geterror();
  ASSERT_TRUE(out->write_image(OIIO::BaseTypeFromC<T>::value, values.data()));
  out->close();
}

std::vector<uint8_t> bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

ImageDescription linear_pixels(int width, int height, std::vector<float> pixels) {
  ImageDescription image;
  image.name = "Pixels";
  image.width = width;
  image.height = height;
  image.pixels = std::move(pixels);
  image.color_space = "Non-Color";
  return image;
}

const Texture* load(TextureStore& store, Diagnostics* diagnostics = nullptr, int index = 0) {
  Diagnostics ignored;
  return store.load(index, "", diagnostics ? *diagnostics : ignored);
}

TextureStore store_of(ImageDescription image) {
  std::vector<ImageDescription> images;
  images.push_back(std::move(image));
  return TextureStore(std::move(images));
}

/// 2 x 2 pixels: the red channel is 0 and 1 in the lower row, 2 and 3 in the upper one.
ImageDescription quad() { return linear_pixels(2, 2, {0, 0, 0, 1, 1, 0, 0, 1, 2, 0, 0, 1, 3, 0, 0, 1}); }

}  // namespace

TEST(Texture, texel_centres_are_at_one_half_and_rows_are_ordered_upwards) {
  TextureStore store = store_of(quad());
  const Texture* t = load(store);
  for (const Interpolation i : {Interpolation::Linear, Interpolation::Closest}) {
    EXPECT_FLOAT_EQ(t->lookup({0.25f, 0.25f}, i, Extension::Repeat).x, 0.0f);
    EXPECT_FLOAT_EQ(t->lookup({0.75f, 0.25f}, i, Extension::Repeat).x, 1.0f);
    EXPECT_FLOAT_EQ(t->lookup({0.25f, 0.75f}, i, Extension::Repeat).x, 2.0f);
  }
  EXPECT_FLOAT_EQ(t->lookup({0.5f, 0.25f}, Interpolation::Linear, Extension::Repeat).x, 0.5f);
}

TEST(Texture, extension_modes_differ_outside_the_image_only) {
  TextureStore store = store_of(quad());
  const Texture* t = load(store);
  const auto at = [&](float u, float v, Extension e) { return t->lookup({u, v}, Interpolation::Closest, e); };
  EXPECT_FLOAT_EQ(at(1.25f, 0.25f, Extension::Repeat).x, 0.0f);
  EXPECT_FLOAT_EQ(at(-0.25f, 0.25f, Extension::Repeat).x, 1.0f);
  EXPECT_FLOAT_EQ(at(1.25f, 0.25f, Extension::Extend).x, 1.0f);
  EXPECT_FLOAT_EQ(at(-9.0f, 0.25f, Extension::Extend).x, 0.0f);
  EXPECT_EQ(at(1.25f, 0.25f, Extension::Clip), Vec4(0.0f));
  EXPECT_FLOAT_EQ(at(1.25f, 0.25f, Extension::Mirror).x, 1.0f);
  EXPECT_FLOAT_EQ(at(-0.25f, 0.25f, Extension::Mirror).x, 0.0f);
  // At the border, linear interpolation has blended half of the way to the clipped outside.
  EXPECT_FLOAT_EQ(t->lookup({1.0f, 0.25f}, Interpolation::Linear, Extension::Clip).w, 0.5f);
}

TEST(Texture, cubic_lookup_is_the_b_spline) {
  std::vector<float> row;
  for (int i = 0; i < 8; ++i) row.insert(row.end(), {i == 3 ? 6.0f : 0.0f, float(i), 0, 1});
  TextureStore store = store_of(linear_pixels(8, 1, row));
  const Texture* t = load(store);
  EXPECT_NEAR(t->lookup({3.5f / 8, 0.5f}, Interpolation::Cubic, Extension::Extend).x, 4.0f, 1e-5f);
  EXPECT_NEAR(t->lookup({4.5f / 8, 0.5f}, Interpolation::Cubic, Extension::Extend).x, 1.0f, 1e-5f);
  EXPECT_NEAR(t->lookup({4.7f / 8, 0.5f}, Interpolation::Cubic, Extension::Extend).y, 4.2f,
              1e-5f);  // reproduces linear functions
}

TEST(Texture, lookups_accept_any_coordinate) {
  TextureStore store = store_of(quad());
  const Texture* t = load(store);
  for (const float bad : {NAN, INFINITY, -INFINITY, 1e30f, -1e30f, 3e9f})
    for (const Interpolation i : {Interpolation::Closest, Interpolation::Linear, Interpolation::Cubic})
      for (const Extension e : {Extension::Repeat, Extension::Extend, Extension::Clip, Extension::Mirror}) {
        const Vec4 c = t->lookup({bad, 0.3f}, i, e);
        EXPECT_TRUE(c.x >= 0.0f && c.x <= 3.0f);
      }
}

TEST(Texture, eight_bit_srgb_is_interpolated_in_encoded_form_and_decoded_to_six_digits) {
  std::vector<float> ramp;
  for (int i = 0; i < 256; ++i) ramp.insert(ramp.end(), {i / 255.0f, 0, 0, 1});
  ImageDescription image = linear_pixels(256, 1, ramp);
  image.color_space = "sRGB";
  TextureStore store = store_of(image);
  const Texture* t = load(store);
  EXPECT_EQ(t->memory_bytes(), 256u * 4u);  // stored as bytes
  for (int i = 0; i < 255; ++i) {
    EXPECT_NEAR(t->lookup({(i + 0.5f) / 256, 0.5f}, Interpolation::Linear, Extension::Extend).x,
                srgb_to_linear(i / 255.0), 1e-6);
    EXPECT_NEAR(t->lookup({(i + 1.0f) / 256, 0.5f}, Interpolation::Linear, Extension::Extend).x,
                srgb_to_linear((i + 0.5) / 255.0), 1e-6);
  }
}

TEST(Texture, files_and_packed_files_of_every_format_give_the_same_image) {
  const Directory directory;
  // Three by two squares of 16 pixels, from top to bottom. Each block of a JPEG has a single colour.
  const uint8_t colors[6][3] = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {128, 128, 128}, {64, 64, 64}, {255, 255, 255}};
  std::vector<uint8_t> pixels;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 48; ++x)
      pixels.insert(pixels.end(), colors[y / 16 * 3 + x / 16], colors[y / 16 * 3 + x / 16] + 3);
  for (const char* name : {"a.png", "a.tga", "a.tif", "a.bmp", "a.jpg"}) {
    const std::string path = directory.file(name);
    write(path, 48, 32, 3, OIIO::TypeDesc::UINT8, pixels);
    for (const bool packed : {false, true}) {
      ImageDescription image;
      image.name = name;
      image.color_space = "Non-Color";
      if (packed)
        image.packed = bytes_of(path);
      else
        image.path = path;
      Diagnostics diagnostics;
      TextureStore store = store_of(image);
      const Texture* t = load(store, &diagnostics);
      EXPECT_TRUE(diagnostics.empty()) << name << ": " << diagnostics[0].message;
      ASSERT_EQ(t->width(), 48) << name << packed;
      const float tolerance = std::string(name) == "a.jpg" ? 0.02f : 1e-5f;
      const Vec4 lower_left = t->lookup({1.0f / 6, 0.25f}, Interpolation::Closest, Extension::Extend);
      EXPECT_NEAR(lower_left.x, 128 / 255.0f, tolerance) << name << packed;
      const Vec4 upper_right = t->lookup({5.0f / 6, 0.75f}, Interpolation::Closest, Extension::Extend);
      EXPECT_NEAR(upper_right.z, 1.0f, tolerance) << name << packed;
      EXPECT_NEAR(upper_right.y, 0.0f, tolerance) << name << packed;
    }
  }
}

TEST(Texture, high_dynamic_range_images_keep_their_values) {
  const Directory directory;
  const std::vector<float> pixels = {1000.0f, 0.5f, 0.001f, 0.25f, 2.0f, 8.0f};
  for (const char* name : {"a.exr", "a.hdr"}) {
    const std::string path = directory.file(name);
    write(path, 2, 1, 3, std::string(name) == "a.exr" ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT, pixels);
    for (const bool packed : {false, true}) {
      ImageDescription image;
      image.name = name;
      image.color_space = "Linear";
      if (packed)
        image.packed = bytes_of(path);
      else
        image.path = path;
      TextureStore store = store_of(image);
      const Vec4 c = load(store)->lookup({0.25f, 0.5f}, Interpolation::Linear, Extension::Extend);
      EXPECT_NEAR(c.x, 1000.0f, 8.0f) << name << packed;
      EXPECT_EQ(c.w, 1.0f);
    }
  }
}

TEST(Texture, alpha_modes_define_the_association_of_color) {
  const Directory directory;
  const std::string path = directory.file("alpha.png");
  write(path, 1, 1, 4, OIIO::TypeDesc::UINT8, std::vector<uint8_t>{204, 102, 51, 51});
  struct Case {
    AlphaMode mode;
    const char* space;
    Vec4 straight, associated;
  };
  const float k = 1.0f / 255.0f;
  const Vec4 file(204 * k, 102 * k, 51 * k, 0.2f);
  // Bytes are multiplied by alpha and rounded down, as in Cycles: 40.8, 20.4, 10.2.
  const Vec4 times_alpha(40 * k, 20 * k, 10 * k, 0.2f), divided(Vec3(times_alpha) / 0.2f, 0.2f);
  for (const Case& c : {Case{AlphaMode::Straight, "Linear", divided, times_alpha},
                        Case{AlphaMode::Straight, "Non-Color", file, file},  // data are not multiplied by alpha
                        Case{AlphaMode::ChannelPacked, "Linear", file, file},
                        Case{AlphaMode::None, "Linear", Vec4(Vec3(file), 1.0f), Vec4(Vec3(file), 1.0f)}}) {
    ImageDescription image;
    image.name = "Alpha";
    image.path = path;
    image.alpha_mode = c.mode;
    image.color_space = c.space;
    TextureStore store = store_of(image);
    const Texture* t = load(store);
    const Vec4 straight = t->lookup({0.5f, 0.5f}, Interpolation::Linear, Extension::Extend);
    const Vec4 associated = t->sample({0.5f, 0.5f}, Interpolation::Linear, Extension::Extend, false);
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(straight[i], c.straight[i], 1e-6f) << int(c.mode) << c.space;
      EXPECT_NEAR(associated[i], c.associated[i], 1e-6f) << int(c.mode) << c.space;
    }
  }
}

TEST(Texture, broken_images_are_magenta_and_reported_once) {
  const Directory directory;
  const std::string garbage = directory.file("garbage.png");
  std::ofstream(garbage, std::ios::binary) << "this is no picture";
  std::vector<ImageDescription> images(6);
  for (int i = 0; i < 6; ++i) images[size_t(i)].name = "Image " + std::to_string(i);
  images[1].path = directory.file("missing.png");
  images[2].path = garbage;
  images[3].packed = {0x89, 'P', 'N', 'G', 1, 2, 3};
  images[4].pixels = {1, 2, 3};
  images[4].width = images[4].height = 100;
  images[5].path = directory.path.string();  // a directory
  TextureStore store(std::move(images));
  Diagnostics diagnostics;
  for (int round = 0; round < 2; ++round)
    for (int i = 0; i < 6; ++i) {
      const Vec4 c = store.load(i, "", diagnostics)->lookup({0.1f, 0.9f}, Interpolation::Cubic, Extension::Repeat);
      EXPECT_NEAR(c.x, 1.0f, 1e-6f);
      EXPECT_NEAR(c.y, 0.0f, 1e-6f);
      EXPECT_NEAR(c.z, 1.0f, 1e-6f);
    }
  EXPECT_EQ(diagnostics.size(), 6u);
  EXPECT_EQ(store.decoded_count(), 0);
  store.load(99, "", diagnostics);
  EXPECT_EQ(diagnostics.size(), 7u);
}

TEST(Texture, too_large_sizes_are_refused_before_memory_is_allocated) {
  const Directory directory;
  const std::string path = directory.file("bomb.tga");
  std::vector<uint8_t> header(18 + 64, 0);  // run-length encoded, 65535 x 65535
  header[2] = 10, header[12] = header[13] = header[14] = header[15] = 255, header[16] = 24;
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(header.data()), std::streamsize(header.size()));
  ImageDescription image;
  image.name = "Bomb";
  image.path = path;
  Diagnostics diagnostics;
  TextureStore store = store_of(image);
  load(store, &diagnostics);
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_NE(diagnostics[0].message.find("too large"), std::string::npos) << diagnostics[0].message;
}

/// A DDS file of the layers of a volume, 24 bits a texel.
void write_dds_volume(const std::string& path, uint32_t side, uint32_t layers) {
  constexpr uint32_t kCaps = 0x1, kHeight = 0x2, kWidth = 0x4, kPitch = 0x8, kFormat = 0x1000, kDepth = 0x800000;
  constexpr uint32_t kRgb = 0x40, kComplex = 0x8, kTexture = 0x1000, kVolume = 0x200000;
  std::vector<uint32_t> header(32, 0);
  header[0] = 'D' | 'D' << 8 | 'S' << 16 | ' ' << 24;
  header[1] = 124, header[2] = kCaps | kHeight | kWidth | kPitch | kFormat | kDepth;
  header[3] = header[4] = side, header[5] = side * 3, header[6] = layers, header[7] = 1;
  header[19] = 32, header[20] = kRgb, header[22] = 24, header[23] = 0xff0000, header[24] = 0xff00, header[25] = 0xff;
  header[27] = kComplex | kTexture, header[28] = kVolume;
  const std::vector<char> texels(size_t(side) * side * layers * 3, char(128));
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(header.data()), std::streamsize(header.size() * sizeof(uint32_t)));
  file.write(texels.data(), std::streamsize(texels.size()));
}

TEST(Texture, volumes_in_image_files_are_refused) {
  const Directory directory;
  ImageDescription image;
  image.name = "Layers";
  image.path = directory.file("layers.dds");
  write_dds_volume(image.path, 4, 1000);
  Diagnostics diagnostics;
  TextureStore store = store_of(image);
  load(store, &diagnostics);
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_NE(diagnostics[0].message.find("is a volume of 1000 layers"), std::string::npos) << diagnostics[0].message;
}

TEST(Texture, pixels_that_are_not_finite_become_zero_and_are_counted) {
  TextureStore store = store_of(linear_pixels(2, 1, {NAN, 1, 1, 1, 0.5f, INFINITY, 0, 1}));
  Diagnostics diagnostics;
  const Texture* t = load(store, &diagnostics);
  EXPECT_EQ(t->lookup({0.25f, 0.5f}, Interpolation::Closest, Extension::Extend), Vec4(0.0f));
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_NE(diagnostics[0].message.find("2 pixels"), std::string::npos);
}

TEST(Texture, each_image_is_decoded_once_and_only_when_needed) {
  std::vector<ImageDescription> images = {quad(), quad()};
  TextureStore store(std::move(images));
  EXPECT_EQ(store.decoded_count(), 0);
  Diagnostics diagnostics;
  const Texture* first = store.load(0, "", diagnostics);
  EXPECT_EQ(store.load(0, "", diagnostics), first);
  EXPECT_EQ(store.decoded_count(), 1);
}

TEST(Texture, tiles_are_found_by_the_whole_part_of_the_coordinates) {
  const auto constant = [](float red) { return linear_pixels(1, 1, {red, 0, 0, 1}); };
  std::vector<ImageDescription> images = {constant(0.25f), constant(0.5f), constant(0.75f)};
  ImageDescription tiled;
  tiled.name = "Tiled";
  tiled.tiles = {{1001, 0}, {1002, 1}, {1011, 2}, {1012, 9}, {7, 0}, {1003, 3}};  // the last three have no image
  images.push_back(tiled);
  TextureStore store(std::move(images));
  Diagnostics diagnostics;
  const Texture* t = store.load(3, "", diagnostics);
  EXPECT_TRUE(diagnostics.empty());
  const auto at = [&](float u, float v) { return Vec3(t->lookup({u, v}, Interpolation::Linear, Extension::Repeat)); };
  const Vec3 magenta(1.0f, 0.0f, 1.0f);
  EXPECT_NEAR(at(0.5f, 0.5f).x, 0.25f, 1e-6f);
  EXPECT_NEAR(at(1.5f, 0.9f).x, 0.5f, 1e-6f);
  EXPECT_NEAR(at(0.1f, 1.1f).x, 0.75f, 1e-6f);
  EXPECT_NEAR(at(-0.5f, 0.5f).x, 0.25f, 1e-6f);  // as in Cycles
  for (const Vec2 p : {Vec2(1.5f, 1.5f), Vec2(2.5f, 0.5f), Vec2(-1.5f, 0.5f), Vec2(10.5f, 0.5f), Vec2(0.5f, 9.5f),
                       Vec2(NAN, 0.0f), Vec2(0.0f, 1e30f)})
    EXPECT_EQ(at(p.x, p.y), magenta) << p.x << ' ' << p.y;
  EXPECT_EQ(store.decoded_count(), 3);
}

TEST(Texture, messages_about_images_name_who_shows_them) {
  ImageDescription image;
  image.name = "Poster";
  image.path = "/no/such/file.png";
  Diagnostics diagnostics;
  store_of(image).load(0, "material 'Wall' of object 'House'", diagnostics);
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_EQ(diagnostics[0].object, "Poster");
  EXPECT_EQ(diagnostics[0].message,
            "is missing: /no/such/file.png; magenta is used (material 'Wall' of object 'House')");
}

TEST(Texture, color_spaces_are_converted_by_the_configuration) {
  const Directory directory;
  const std::string config = directory.file("config.ocio");
  std::ofstream(config) << R"(ocio_profile_version: 2
strictparsing: true
roles: {default: Linear, scene_linear: Linear, aces_interchange: ACES}
file_rules: [!<Rule> {name: Default, colorspace: default}]
displays: {sRGB: [!<View> {name: Standard, colorspace: Linear}]}
active_displays: []
active_views: []
colorspaces:
  - !<ColorSpace> {name: Linear, family: "", bitdepth: 32f, isdata: false}
  - !<ColorSpace>
    name: Swapped
    family: ""
    bitdepth: 32f
    isdata: false
    to_scene_reference: !<MatrixTransform> {matrix: [0, 2, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: ACES
    family: ""
    bitdepth: 32f
    isdata: false
    to_scene_reference: !<MatrixTransform> {matrix: [2.5216494, -1.1368885, -0.3849175, 0, -0.2752135, 1.3697051, -0.0943924, 0, -0.0159250, -0.1478063, 1.1638058, 0, 0, 0, 0, 1]}
)";
  ColorDescription color{config, "Linear"};
  for (const AlphaMode mode : {AlphaMode::Straight, AlphaMode::ChannelPacked}) {
    ImageDescription image = linear_pixels(1, 1, {0.2f, 0.4f, 0.6f, 0.5f});
    image.color_space = "Swapped";
    image.alpha_mode = mode;
    std::vector<ImageDescription> images;
    images.push_back(std::move(image));
    TextureStore store(std::move(images), nullptr, color);
    Diagnostics diagnostics;
    const Texture* t = load(store, &diagnostics);
    EXPECT_TRUE(diagnostics.empty()) << diagnostics[0].message;
    const float k = mode == AlphaMode::Straight ? 0.5f : 1.0f;
    const Vec4 c = t->sample({0.5f, 0.5f}, Interpolation::Linear, Extension::Extend, false);
    EXPECT_NEAR(c.x, 0.8f * k, 1e-3f);
    EXPECT_NEAR(c.y, 0.2f * k, 1e-3f);
    EXPECT_NEAR(c.z, 0.6f * k, 1e-3f);
    EXPECT_NEAR(c.w, 0.5f, 1e-3f);
  }
  EXPECT_EQ(working_from_rec709(color), Mat3(1.0f));
  const Vec3 white = working_from_rec709({config, "ACES"}) * Vec3(1.0f);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(white[i], 1.0f, 2e-3f);
  EXPECT_GT(std::abs(working_from_rec709({config, "ACES"})[0][0] - 1.0f), 0.1f);
}

TEST(Texture, unknown_color_spaces_are_approximated_and_reported) {
  ImageDescription image = quad();
  image.color_space = "Filmic sRGB";
  Diagnostics diagnostics;
  TextureStore store = store_of(image);
  load(store, &diagnostics);
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_NE(diagnostics[0].message.find("Filmic sRGB"), std::string::npos);
}

TEST(Texture, larger_images_are_halved_until_they_fit_the_limit) {
  // 5 x 2 pixels: the last column fills no square.
  std::vector<float> pixels;
  for (int i = 0; i < 10; ++i) pixels.insert(pixels.end(), {float(i), 0.0f, 1.0f, 1.0f});
  ImageDescription image = linear_pixels(5, 2, pixels);
  image.size_limit = 4;
  TextureStore store = store_of(image);
  const Texture* halved = load(store);
  EXPECT_EQ(halved->width(), 2);
  EXPECT_EQ(halved->height(), 1);
  EXPECT_EQ(halved->lookup(Vec2(0.25f, 0.5f), Interpolation::Closest, Extension::Extend),
            Vec4(0.25f * (0 + 1 + 5 + 6), 0, 1, 1));
  EXPECT_EQ(halved->lookup(Vec2(0.75f, 0.5f), Interpolation::Closest, Extension::Extend),
            Vec4(0.25f * (2 + 3 + 7 + 8), 0, 1, 1));
  EXPECT_EQ(texture_bytes(image), 10u * 4u * sizeof(float) / 4u);
  image.size_limit = 5;
  TextureStore whole = store_of(image);
  EXPECT_EQ(load(whole)->width(), 5);
}

TEST(Texture, a_resolution_is_rounded_down_to_a_power_of_two) {
  std::vector<float> pixels(size_t(8) * 8 * 4, 0.5f);
  for (const auto& [resolution, width] :
       {std::pair(1.0f, 8), {0.9f, 4}, {0.5f, 4}, {0.3f, 2}, {0.25f, 2}, {1e-5f, 1}}) {
    ImageDescription image = linear_pixels(8, 8, pixels);
    image.resolution = resolution;
    TextureStore store = store_of(image);
    EXPECT_EQ(load(store)->width(), width) << resolution;
  }
  ImageDescription both = linear_pixels(8, 8, pixels);
  both.resolution = 0.5f;
  both.size_limit = 2;
  TextureStore store = store_of(both);
  EXPECT_EQ(load(store)->width(), 2);
}

TEST(Texture, bytes_are_averaged_as_they_are_stored) {
  const Directory directory;
  const std::string path = directory.file("grey.png");
  write<uint8_t>(path, 2, 2, 1, OIIO::TypeDesc::UINT8, {0, 255, 255, 255});
  ImageDescription image;
  image.path = path;
  image.size_limit = 1;
  TextureStore store = store_of(image);
  const Vec4 seen = load(store)->lookup(Vec2(0.5f), Interpolation::Closest, Extension::Extend);
  EXPECT_NEAR(seen.x, float(srgb_to_linear(191.0 / 255.0)), 1e-5f);
}

}  // namespace ajar::test_texture
