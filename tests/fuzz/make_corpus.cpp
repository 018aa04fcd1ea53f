// Valid scenes for fuzz_scene to start from, in turn by every integrator and every method of direct light: make_corpus FOLDER.
#include <cstdio>

#include "scene/archive.h"
#include "transport_scenes.h"

using namespace ajar;
using namespace ajar::fixtures;

namespace {

SceneDescription lit_room() {
  SceneDescription d = grey_room(8);
  d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.5f, 8.0f));
  return d;
}

/// What light does between and below surfaces, and what moves, has attributes, images and hints.
std::vector<TransportScene> further_scenes() {
  std::vector<TransportScene> scenes;
  const Mat4 ball = moved(Vec3(0.2f, 0.3f, -0.4f), 0.4f);
  for (const char* density : {"constant", "varying"}) {
    SceneDescription d = lit_room();
    GraphBuilder b;
    const int coordinates = b.node("ShaderNodeTexCoord");
    const NodeInput amount = density[0] == 'c' ? value_input("Density", 2.0f) : linked_input("Density", coordinates, "Generated");
    b.graph.volume = {b.node("ShaderNodeVolumePrincipled", {value_input("Color", Vec4(0.8f)), amount, value_input("Anisotropy", 0.3f), value_input("Emission Strength", 0.1f)}),
                      "Volume"};
    add_object(d, sphere(6), add_material(d, b), ball);
    if (density[0] == 'c') d.world.graph = b.graph;
    d.settings.bounces.volume = 4;
    scenes.push_back({std::string("volume_") + density, d});
  }
  SceneDescription below = lit_room();
  add_object(below, sphere(6), add_closure(below, "ShaderNodeSubsurfaceScattering", {value_input("Color", Vec4(0.8f)), value_input("Scale", 0.1f), value_input("Radius", Vec4(1.0f))}), ball);
  below.materials.back().graph.surface.socket = "BSSRDF";
  scenes.push_back({"subsurface", below});
  SceneDescription moving = lit_room();
  add_object(moving, sphere(6), add_diffuse(moving, Color(0.5f)), ball);
  moving.motion_keys = {rows(ball), rows(moved(Vec3(-0.2f, 0.3f, -0.4f), 0.3f))};
  moving.instances.back().motion_key_count = 2;
  moving.camera.motion = {moving.camera.world_from_camera, moving.camera.world_from_camera};
  moving.camera.shutter = {0.0f, 0.4f, 1.0f};
  scenes.push_back({"motion", moving});
  SceneDescription textured = lit_room();
  ImageDescription image;
  image.name = "Card";
  image.width = image.height = 2;
  image.pixels.assign(16, 0.5f);
  textured.images.push_back(image);
  GraphBuilder b;
  const int texture = b.node("ShaderNodeTexImage", {}, {number_property("image", {0.0f})});
  b.graph.surface = {b.node("ShaderNodeBsdfPrincipled", {linked_input("Base Color", texture, "Color"), value_input("Anisotropic", 0.5f), value_input("Alpha", 0.8f)}), "BSDF"};
  MeshDescription mesh = sphere(6);
  mesh.attributes.push_back({"UVMap", Domain::Corner, 2, std::vector<float>(mesh.triangles.size() * 6, 0.5f)});
  mesh.active_uv = "UVMap";
  add_object(textured, mesh, add_material(textured, b), ball);
  HintDescription hint;
  hint.name = "Path";
  hint.points = {Vec3(0.1f, 0.1f, 0.95f), Vec3(0.2f, 0.3f, 0.0f), Vec3(0.0f, 0.0f, -1.0f)};
  textured.hints.push_back(hint);
  scenes.push_back({"textured", textured});
  return scenes;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_corpus FOLDER\n");
    return 2;
  }
  std::vector<TransportScene> scenes = transport_scenes();
  for (TransportScene& scene : further_scenes()) scenes.push_back(std::move(scene));
  constexpr uint32_t kIntegrators = 9, kTechniques = kIntegrators * 11 * 4;   // as fuzz_scene reads the seed, or near enough
  uint32_t number = 0;
  for (TransportScene& scene : scenes)
    for (uint32_t i = 0; i < kIntegrators; ++i, ++number) {
      scene.description.settings.seed = (number * 37 / kIntegrators * kIntegrators + i) % kTechniques;
      save_description(scene.description, std::string(argv[1]) + "/" + scene.name + "_" + std::to_string(i) + ".ajar");
    }
}
