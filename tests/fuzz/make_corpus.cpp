// Writes valid scenes as the initial corpus of fuzz_scene, for all integrators and all methods of direct light. Some
// are written in older versions of the format. Writes valid images as that of fuzz_image. Usage: make_corpus SCENES IMAGES.
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "description/archive.h"
#include "transport_scenes.h"

using namespace ajar;
using namespace ajar::fixtures;

namespace {

SceneDescription lit_room() {
  SceneDescription d = grey_room(8);
  d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.5f, 8.0f));
  return d;
}

/// Scenes with importance of pixels, objects and lights, which adaptive sample counts follow. They also have lamps that
/// only some lobes see, holdouts and shadow catchers.
std::vector<SceneDescription> matters_more() {
  SceneDescription d = lit_room();
  d.settings.image = ImageSampling::PmcIp;
  d.settings.importance_region = {0.0f, 0.0f, 0.5f, 0.7f};
  d.settings.importance_factor = 3.0f;
  d.settings.mist = {0.5f, 1.0f, 2.0f};
  d.settings.filter = FilterKind::Gaussian;
  add_object(d, sphere(4), add_diffuse(d, Color(0.5f), Color(2.0f)), moved(Vec3(0.4f, 0.3f, 0.2f), 0.2f));
  d.objects[1].importance = 2.0f;
  d.objects[1].light_importance = 0.5f;
  d.lights[0].light_importance = 4.0f;
  SceneDescription partial = d;
  partial.settings.image_error = ErrorMeasure::Perceptual;
  partial.world.light_importance = 0.1f;
  set_checker_world(partial, Color(1.0f), Color(0.1f), 3.0f);
  partial.lights.push_back(point_light(Vec3(-0.3f, 0.2f, 0.5f), 3.0f, 0.1f));
  partial.lights[1].visibility = kVisibleAll & ~kVisibleDiffuse;
  partial.objects[1].shadow_catcher = true;
  add_object(partial, sphere(4), add_glossy(partial, 0.2f), moved(Vec3(-0.4f, 0.3f, -0.4f), 0.3f));
  partial.objects[2].holdout = true;
  partial.objects[2].shadow_terminator_offset = 0.3f;
  return {d, partial};
}

/// A surface with four types of lobes, which are sampled separately, and a lamp with a shader graph.
SceneDescription many_lobes() {
  SceneDescription d = lit_room();
  add_object(
      d, sphere(4),
      add_closure(d, "ShaderNodeBsdfPrincipled",
                  {value_input("Base Color", Vec4(0.8f)), value_input("Roughness", 0.3f), value_input("Metallic", 0.3f),
                   value_input("Clearcoat", 1.0f), value_input("Sheen", 0.5f), value_input("Transmission", 0.3f),
                   value_input("IOR", 1.4f), value_input("Anisotropic", 0.5f)}),
      moved(Vec3(0.2f, 0.3f, -0.4f), 0.4f));
  d.settings.direct_samples = 4;
  GraphBuilder b;
  const int falloff = b.node("ShaderNodeLightFalloff", {value_input("Strength", 2.0f), value_input("Smooth", 0.3f)});
  b.graph.surface = {
      b.node("ShaderNodeEmission", {value_input("Color", Vec4(1.0f)), linked_input("Strength", falloff, "Quadratic")}),
      "Emission"};
  d.lights[0].graph = b.graph;
  d.lights[0].spread = 2.0f;
  return d;
}

/// A ball that sends rays to another place, whose colour is an attribute that a ray of its own finds there.
SceneDescription portal() {
  SceneDescription d = lit_room();
  GraphBuilder b;
  const int geometry = b.node("ShaderNodeNewGeometry");
  const int ray = b.node("ShaderNodeRaycast",
                         {value_input("Length", 3.0f), linked_input("Direction", geometry, "Normal")},
                         {text_property("Value_1", "heat"), text_property("attribute_type_1", "RGBA")});
  const int far = b.node("ShaderNodeBsdfRayPortal", {linked_input("Color", ray, "Attribute_1"),
                                                     value_input("Position", Vec4(0.0f, 0.0f, 0.5f, 0.0f)),
                                                     linked_input("Direction", geometry, "Normal")});
  const int here = b.node("ShaderNodeBsdfRayPortal", {value_input("Color", Vec4(0.8f))});
  b.graph.surface = {b.node("ShaderNodeMixShader", {value_input("Fac", 0.5f), linked_input("Shader", far, "BSDF"),
                                                    linked_input("Shader_001", here, "BSDF")}),
                     "Shader"};
  add_object(d, sphere(6), add_material(d, b), moved(Vec3(0.2f, 0.3f, -0.4f), 0.4f));
  MeshDescription warm = cube();
  warm.attributes.push_back({"heat", Domain::Vertex, 4, std::vector<float>(32, 0.5f)});
  add_object(d, warm, add_diffuse(d, Color(0.5f)), moved(Vec3(-0.4f, 0.3f, -0.4f), 0.2f));
  return d;
}

/// Scenes with volumes, subsurface scattering, motion, attributes, images and hints.
std::vector<TransportScene> further_scenes() {
  std::vector<TransportScene> scenes;
  const Mat4 ball = moved(Vec3(0.2f, 0.3f, -0.4f), 0.4f);
  for (const char* density : {"constant", "varying"}) {
    SceneDescription d = lit_room();
    GraphBuilder b;
    const int coordinates = b.node("ShaderNodeTexCoord");
    const NodeInput amount = density[0] == 'c' ? value_input("Density", 2.0f)
                                               : linked_input("Density", coordinates, "Generated");
    b.graph.volume = {
        b.node("ShaderNodeVolumePrincipled", {value_input("Color", Vec4(0.8f)), amount, value_input("Anisotropy", 0.3f),
                                              value_input("Emission Strength", 0.1f)}),
        "Volume"};
    add_object(d, sphere(6), add_material(d, b), ball);
    if (density[0] == 'c') d.world.graph = b.graph;
    d.settings.bounces.volume = 4;
    scenes.push_back({std::string("volume_") + density, d});
  }
  SceneDescription below = lit_room();
  add_object(
      below, sphere(6),
      add_closure(below, "ShaderNodeSubsurfaceScattering",
                  {value_input("Color", Vec4(0.8f)), value_input("Scale", 0.1f), value_input("Radius", Vec4(1.0f))}),
      ball);
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
  b.graph.surface = {b.node("ShaderNodeBsdfPrincipled", {linked_input("Base Color", texture, "Color"),
                                                         value_input("Anisotropic", 0.5f), value_input("Alpha", 0.8f)}),
                     "BSDF"};
  MeshDescription mesh = sphere(6);
  mesh.attributes.push_back({"UVMap", Domain::Corner, 2, std::vector<float>(mesh.triangles.size() * 6, 0.5f)});
  mesh.active_uv = "UVMap";
  add_object(textured, mesh, add_material(textured, b), ball);
  HintDescription hint;
  hint.name = "Path";
  hint.points = {Vec3(0.1f, 0.1f, 0.95f), Vec3(0.2f, 0.3f, 0.0f), Vec3(0.0f, 0.0f, -1.0f)};
  hint.spreads = {0.2f, 0.4f};
  textured.hints.push_back(hint);
  scenes.push_back({"textured", textured});
  for (SceneDescription& important : matters_more())
    scenes.push_back({"important_" + std::to_string(scenes.size()), important});
  for (PanoramaKind kind : {PanoramaKind::Equirectangular, PanoramaKind::FisheyeEquisolid,
                            PanoramaKind::FisheyePolynomial, PanoramaKind::MirrorBall, PanoramaKind::CubemapFace}) {
    SceneDescription d = lit_room();
    d.camera.kind = CameraKind::Panorama;
    d.camera.panorama.kind = kind;
    d.camera.panorama.polynomial = {-1e-4f, -0.17f, -6e-3f, 5e-5f, 1e-6f};
    d.camera.screen_window = Vec4(0, 1, 0, 1);
    d.camera.aperture_radius = kind == PanoramaKind::Equirectangular ? 0.05f : 0.0f;
    scenes.push_back({"panorama_" + std::to_string(int(kind)), d});
  }
  for (StrandShape shape : {StrandShape::Ribbon, StrandShape::Round, StrandShape::Linear}) {
    SceneDescription d = lit_room();
    MeshDescription strands = hair({{{0, 0, 0}, {0.2f, 0, 0.3f}, {0, 0.1f, 0.6f}}, {{0.2f, 0, 0}, {0.2f, 0.1f, 0.5f}}},
                                   0.05f, 0.01f, shape);
    strands.material_slots = {0, 1};
    strands.attributes.push_back({"UVMap", Domain::Face, 2, {0.0f, 0.25f, 0.5f, 0.75f}});
    strands.attributes.push_back({"heat", Domain::Vertex, 1, {0, 1, 2, 3, 4}});
    strands.active_uv = "UVMap";
    GraphBuilder b;
    const int info = b.node("ShaderNodeHairInfo");
    b.graph.surface = {b.node("ShaderNodeBsdfDiffuse", {linked_input("Color", info, "Intercept")}), "BSDF"};
    add_object(d, strands, add_material(d, b), ball);
    scenes.push_back({"hair_" + std::to_string(int(shape)), d});
  }
  SceneDescription d = lit_room();
  MeshDescription points = random_cloud(20, 0.05f);
  points.attributes.push_back({"heat", Domain::Vertex, 1, std::vector<float>(20, 0.5f)});
  GraphBuilder of_points;
  const int info = of_points.node("ShaderNodePointInfo");
  of_points.graph.surface = {of_points.node("ShaderNodeBsdfDiffuse", {linked_input("Color", info, "Random")}), "BSDF"};
  add_object(d, points, add_material(d, of_points), ball);
  scenes.push_back({"points", d});
  scenes.push_back({"lobes", many_lobes()});
  scenes.push_back({"portal", portal()});
  return scenes;
}

/// One image of each format, with 1, 3 and 4 channels where it has them, behind the two bytes of the limits.
void write_images(const std::string& folder) {
  constexpr int kSide = 8;
  for (const char* ending : {"png", "jpg", "tif", "exr", "hdr", "bmp", "tga", "dds", "webp", "psd"})
    for (const int channels : {1, 3, 4})
      for (const bool floats : {false, true}) {
        const std::string path = folder + "/" + std::to_string(channels) + (floats ? "f." : "b.") + ending;
        const auto out = OIIO::ImageOutput::create(path);
        if (!out) continue;
        const OIIO::ImageSpec spec(kSide, kSide, channels, floats ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
        std::vector<float> pixels(size_t(kSide) * kSide * channels);
        for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = float(i % 7) / 7.0f;
        if (!out->open(path, spec) || !out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()) || !out->close()) {
          std::remove(path.c_str());
          continue;
        }
        std::ifstream written(path, std::ios::binary);
        std::vector<char> bytes = {0, 0};
        bytes.insert(bytes.end(), std::istreambuf_iterator<char>(written), {});
        std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
        if (ending != std::string("exr") || !floats) continue;
        // The same with its rows before the file. The table of their only block is the number of the byte behind it.
        for (size_t at = 2; at + sizeof(uint64_t) <= bytes.size(); ++at) {
          uint64_t place;
          std::memcpy(&place, &bytes[at], sizeof place);
          if (place + 2 != at + sizeof place) continue;
          std::fill_n(&bytes[at], sizeof place, char(-1));
          std::ofstream(path + "_before", std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
          break;
        }
      }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: make_corpus SCENES IMAGES\n");
    return 2;
  }
  write_images(argv[2]);
  std::vector<TransportScene> scenes = transport_scenes();
  for (TransportScene& scene : further_scenes()) scenes.push_back(std::move(scene));
  constexpr uint32_t kIntegrators = 9,
                     kTechniques = kIntegrators * 11 * 4 *
                                   27;  // approximately the number of techniques that fuzz_scene reads from the seed
  uint32_t number = 0;
  for (TransportScene& scene : scenes)
    for (uint32_t i = 0; i < kIntegrators; ++i, ++number) {
      SceneDescription& d = scene.description;
      // With few vertices, most bytes of the file are other data.
      for (MeshDescription& mesh : d.meshes)
        if (mesh.positions.size() > 200) mesh = sphere(4);
      d.settings.seed = (number * 37 / kIntegrators * kIntegrators + i) % kTechniques;
      const char version = char(number % 4 == 0 ? '2' + number / 4 % 8 : 'B');
      const std::vector<char> bytes = to_bytes(d, version);
      std::ofstream(std::string(argv[1]) + "/" + scene.name + "_" + std::to_string(i) + ".ajar", std::ios::binary)
          .write(bytes.data(), std::streamsize(bytes.size()));
    }
}
