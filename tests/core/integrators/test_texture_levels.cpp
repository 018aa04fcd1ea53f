// Textures in tiles and levels: which levels a render reads.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "graph_fixtures.h"
#include "math/hash.h"
#include "platform/platform.h"
#include "renders.h"
#include "shading/images/tile_cache.h"
#include "transport_scenes.h"

namespace ajar::test_texture_levels {

using namespace fixtures;

namespace {

struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() /
                               ("ajar-levels-" + std::to_string(platform::process_id()));
  ~Folder() { std::filesystem::remove_all(path); }
};

/// Dark and bright texels, in squares of 1 to 32 texels. Half of the texels are transparent if `alpha` is set.
ImageDescription rough_image(int side, uint32_t seed, bool alpha = false) {
  ImageDescription image;
  image.name = "Rough " + std::to_string(seed);
  image.width = image.height = side;
  if (alpha) image.alpha_mode = AlphaMode::Straight;
  for (uint32_t y = 0; y < uint32_t(side); ++y)
    for (uint32_t x = 0; x < uint32_t(side); ++x) {
      const uint32_t coarse = nodes::hash_words<3>({x / 32, y / 32, seed}) >> 25,
                     fine = nodes::hash_words<3>({x, y, seed + 1}) >> 25;
      const float red = float(coarse + fine) / 255.0f, green = float(2 * fine) / 255.0f;
      const bool opaque = !alpha || (nodes::hash_words<3>({x / 3, y / 3, seed + 2}) >> 31) != 0;
      image.pixels.insert(image.pixels.end(), {red, green, float(coarse) / 255.0f, opaque ? 1.0f : 0.0f});
    }
  return image;
}

MeshDescription with_uv(MeshDescription mesh) {
  Attribute uv{"UV", Domain::Corner, 2, {}};
  for (const UVec3& t : mesh.triangles)
    for (const uint32_t v : {t.x, t.y, t.z}) {
      const Vec3 p = mesh.positions[v];
      uv.values.insert(uv.values.end(), {0.5f + 0.1f * p.x, 0.3f + 0.1f * p.y});
    }
  mesh.attributes.push_back(uv);
  mesh.active_uv = "UV";
  return mesh;
}

int image_node(GraphBuilder& g, int image) {
  const int uv = g.node("ShaderNodeUVMap");
  return g.node("ShaderNodeTexImage", {linked_input("Vector", uv, "UV")}, {number_property("image", {float(image)})});
}

int textured(SceneDescription& d, int image, const std::string& closure, const std::string& output) {
  GraphBuilder g;
  const int texture = image_node(g, image);
  const int surface = g.node(closure, {linked_input("Color", texture, "Color"), value_input("Strength", 6.0f)});
  g.graph.surface = {surface, output};
  return add_material(d, g);
}

/// A floor to the horizon, a textured light above it, a mirror, and a leaf with holes before the camera.
SceneDescription hall() {
  SceneDescription d;
  d.images = {rough_image(1024, 1), rough_image(512, 2), rough_image(512, 3, true)};
  add_object(d, with_uv(plane(40.0f)), textured(d, 0, "ShaderNodeBsdfDiffuse", "BSDF"));
  const Mat4 turned = moved({1.0f, 9.0f, 4.0f}, 0.4f) * glm::rotate(Mat4(1.0f), kPi, Vec3(1, 0, 0));
  add_object(d, with_uv(plane(4.0f)), textured(d, 1, "ShaderNodeEmission", "Emission"), turned);
  const Mat4 upright = glm::rotate(Mat4(1.0f), 0.5f * kPi, Vec3(1, 0, 0));
  add_object(d, plane(1.5f), add_glossy(d, 0.0f), moved({-4.0f, 9.0f, 2.0f}) * upright);
  GraphBuilder g;
  const int texture = image_node(g, 2);
  const int leaf = g.node("ShaderNodeBsdfDiffuse", {linked_input("Color", texture, "Color")});
  const int gap = g.node("ShaderNodeBsdfTransparent", {value_input("Color", Vec4(1.0f))});
  const int mix = g.node("ShaderNodeMixShader",
                         {linked_input("Fac", texture, "Alpha"), linked_input("Shader", gap, "BSDF"),
                          linked_input("Shader_001", leaf, "BSDF")});
  g.graph.surface = {mix, "Shader"};
  add_object(d, with_uv(plane(1.0f)), add_material(d, g), moved({1.5f, 4.0f, 1.0f}) * upright);
  set_world(d, Color(0.2f, 0.3f, 0.4f));
  set_camera(d, {0, 0, 1.5f}, {0, 6, 1.0f}, 24, 0.6f);
  return d;
}

SceneDescription cached(SceneDescription d, const Folder& folder) {
  d.settings.texture_cache = d.settings.texture_cache_generate = true;
  d.settings.texture_cache_folder = folder.path.string();
  d.settings.texture_cache_size = 16;
  return d;
}

}  // namespace

TEST(TextureLevels, are_read_instead_of_the_finest_texels_and_reported) {
  const Folder folder;
  Session session;
  session.start(with(cached(hall(), folder), "path", 16));
  ASSERT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.take_error(), "");
  const auto statistics = nlohmann::json::parse(session.statistics_json());
  EXPECT_EQ(statistics["scene"]["tiled_textures"], 3);
  EXPECT_EQ(statistics["scene"]["made_textures"], 3);
  EXPECT_EQ(statistics["scene"]["texture_bytes"], 0);
  // Most of the floor is far away: of the 256 + 64 + 64 tiles of the finest levels, few are read.
  EXPECT_GT(statistics["texture_cache"]["tiles_read"], 5);
  EXPECT_LT(statistics["texture_cache"]["tiles_read"], 200);
  EXPECT_EQ(statistics["texture_cache"]["limit_bytes"], 16 << 20);
}

TEST(TextureLevels, of_heights_displacements_lamps_and_worlds_are_the_finest) {
  const Folder folder;
  std::vector<ImageDescription> images{rough_image(256, 1)};
  TextureStore whole(images), tiled(images, nullptr, {}, {true, true, folder.path.string(), 16});
  const CameraDescription camera{.present = true};
  GraphBuilder g;
  const int texture = image_node(g, 0);
  const int bump = g.node("ShaderNodeBump", {linked_input("Height", texture, "Color")});
  const int diffuse = g.node("ShaderNodeBsdfDiffuse",
                             {linked_input("Color", texture, "Color"), linked_input("Normal", bump, "Normal")});
  g.graph.surface = {diffuse, "BSDF"};
  const auto count = [&](TextureStore& store, bool takes_means) {
    ShaderContext context;
    context.camera = &camera;
    context.image_width = 100;
    context.takes_means = takes_means;
    const std::string listing = compile(g.graph, nullptr, &store, context).listing();
    int means = 0, exact = 0;
    for (size_t at = 0; (at = listing.find("Image", at)) != std::string::npos; ++at)
      ++(listing.compare(at, 9, "ImageOver") == 0 ? means : exact);
    return std::pair(means, exact);
  };
  EXPECT_EQ(count(whole, true), std::pair(0, 3));   // at the point and beside it
  EXPECT_EQ(count(tiled, false), std::pair(0, 3));  // a lamp, a world or a bake
  EXPECT_EQ(count(tiled, true), std::pair(1, 3));   // the colour
  GraphBuilder displaced;
  const int height = image_node(displaced, 0);
  const int move = displaced.node("ShaderNodeDisplacement", {linked_input("Height", height, "Color")});
  displaced.graph.displacement = {move, "Displacement"};
  g = displaced;
  ShaderContext context;
  context.camera = &camera;
  context.takes_means = true;
  context.displacement_method = DisplacementMethod::Displacement;
  EXPECT_EQ(compile(g.graph, nullptr, &tiled, context).listing().find("ImageOver"), std::string::npos);
}

}  // namespace ajar::test_texture_levels
