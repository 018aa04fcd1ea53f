#include "scene/path_tracing_only.h"

#include <algorithm>
#include <functional>

namespace ajar {

namespace {

/// Whether an object shows a material of which `holds` is true. The scene is not built yet.
bool any_shown(const SceneDescription& d, const std::function<bool(const MaterialDescription&)>& holds) {
  std::vector<bool> found;
  for (const MaterialDescription& material : d.materials) found.push_back(holds(material));
  if (std::find(found.begin(), found.end(), true) == found.end()) return false;
  return std::any_of(d.instances.begin(), d.instances.end(), [&](const InstanceDescription& instance) {
    if (instance.object < 0 || size_t(instance.object) >= d.objects.size()) return false;
    const std::vector<int>& materials = d.objects[size_t(instance.object)].materials;
    return std::any_of(materials.begin(), materials.end(),
                       [&](int i) { return i >= 0 && size_t(i) < found.size() && found[size_t(i)]; });
  });
}

bool has_portal(const MaterialDescription& material) {
  return std::any_of(material.graph.nodes.begin(), material.graph.nodes.end(),
                     [](const Node& node) { return node.type == "ShaderNodeBsdfRayPortal"; });
}

/// Whether a node can have other values at other places inside a volume, if its inputs do not.
bool depends_on_place(const Node& node) {
  return node.type.starts_with("ShaderNodeTex") || node.type == "ShaderNodeNewGeometry" ||
         node.type == "ShaderNodeCameraData" || node.type == "ShaderNodeFresnel" ||
         node.type == "ShaderNodeLayerWeight" || node.type == "ShaderNodeTangent";
}

bool reaches_varying_node(const NodeGraph& graph, int first) {
  std::vector<bool> seen(graph.nodes.size(), false);
  std::vector<int> open{first};
  while (!open.empty()) {
    const int at = open.back();
    open.pop_back();
    if (at < 0 || size_t(at) >= seen.size() || seen[size_t(at)]) continue;
    seen[size_t(at)] = true;
    const Node& node = graph.nodes[size_t(at)];
    if (depends_on_place(node)) return true;
    for (const NodeInput& input : node.inputs) open.push_back(input.link.node);
  }
  return false;
}

/// Whether the world is surely black.
bool is_black_world(const WorldDescription& world) {
  if (world.graph.empty()) return is_black(world.color);
  const int surface = world.graph.surface.node;
  if (surface < 0 || size_t(surface) >= world.graph.nodes.size()) return true;
  const Node& node = world.graph.nodes[size_t(surface)];
  return node.type == "ShaderNodeBackground" &&
         std::any_of(node.inputs.begin(), node.inputs.end(), [](const NodeInput& input) {
           return input.link.node < 0 && (input.socket == "Color" || input.socket == "Strength") &&
                  is_black(Color(input.value.x, input.socket == "Color" ? input.value.y : 0.0f,
                                 input.socket == "Color" ? input.value.z : 0.0f));
         });
}

/// Light from infinity through a volume of the world that varies. Walks from such lights would have to begin at infinity,
/// in the volume. The scene is not built yet.
bool has_light_through_world(const SceneDescription& d) {
  return reaches_varying_node(d.world.graph, d.world.graph.volume.node) &&
         (!is_black_world(d.world) || std::any_of(d.lights.begin(), d.lights.end(), [](const LightDescription& light) {
           return light.kind == LightKind::Sun;
         }));
}

bool has_light_through_world(const Scene& scene) {
  if (!scene.world_program().has_volume() || !scene.world_program().medium_varies()) return false;
  const LightSet& lights = scene.lights();
  for (uint32_t i = 0; i < lights.size(); ++i)
    if (is_distant(lights.flags(i).type)) return true;
  return false;
}

const char* reason(bool catchers, bool portals, bool world, const CameraDescription& camera,
                   const RenderSettings& settings) {
  if (catchers) return "shadow catchers";
  if (portals) return "ray portals";
  if (world) return "light from infinity through a world volume that varies";
  if (camera.row_exposure < 1.0f) return "a rolling shutter";
  if (camera.stereo.offset != 0.0f) return "spherical stereoscopy";
  return settings.transparent_film && settings.transparent_glass ? "transparent glass" : "";
}

}  // namespace

std::string path_tracing_only(const SceneDescription& d) {
  return reason(has_catchers(d), any_shown(d, has_portal), has_light_through_world(d), d.camera, d.settings);
}

std::string path_tracing_only(const Scene* scene, const CameraDescription& camera, const RenderSettings& settings) {
  return reason(scene && scene->catchers(), scene && scene->has_portals(), scene && has_light_through_world(*scene),
                camera, settings);
}

}  // namespace ajar
