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

/// Which nodes of a graph need a Light Path node, and which of its shaders scatter light. Each node is visited once;
/// an exporter of broken files may write a cycle.
class LightPathSearch {
 public:
  explicit LightPathSearch(const NodeGraph& graph)
      : graph_(graph), shaders_(graph.nodes.size()), values_(graph.nodes.size()) {}

  struct Found {
    bool visited = false, scatters = false, follows_path = false;
  };

  /// A shader. Emission may follow the path: paths from the eye find all of it.
  Found shader(const NodeLink& link, int depth = 0) {
    if (link.node < 0 || size_t(link.node) >= graph_.nodes.size()) return {};
    if (depth > kMaxDepth) return {true, true, true};
    Found& found = shaders_[size_t(link.node)];
    if (found.visited) return found;
    found.visited = true;
    const Node& node = graph_.nodes[size_t(link.node)];
    if (node.type == "ShaderNodeEmission" || node.type == "ShaderNodeBackground") return found;
    const bool joins = node.type == "ShaderNodeMixShader" || node.type == "ShaderNodeAddShader";
    Found result{true, !joins, false};
    bool by_number = false;
    for (const NodeInput& input : node.inputs) {
      if (joins && input.socket.starts_with("Shader")) {
        const Found part = shader(input.link, depth + 1);
        result.scatters |= part.scatters;
        result.follows_path |= part.follows_path;
      } else if (!input.socket.starts_with("Emission")) {  // of Principled BSDF
        by_number |= value(input.link, depth + 1);
      }
    }
    result.follows_path |= result.scatters && by_number;
    return shaders_[size_t(link.node)] = result;
  }

 private:
  static constexpr int kMaxDepth = 4096;  ///< of nodes one behind the other; behind that, a Light Path is assumed
  /// Whether a number or colour follows the path.
  bool value(const NodeLink& link, int depth) {
    if (link.node < 0 || size_t(link.node) >= graph_.nodes.size()) return false;
    if (depth > kMaxDepth) return true;
    Found& found = values_[size_t(link.node)];
    if (found.visited) return found.follows_path;
    found.visited = true;
    const Node& node = graph_.nodes[size_t(link.node)];
    const bool follows = node.type == "ShaderNodeLightPath" ||
                         std::any_of(node.inputs.begin(), node.inputs.end(),
                                     [&](const NodeInput& input) { return value(input.link, depth + 1); });
    values_[size_t(link.node)].follows_path = follows;
    return follows;
  }

  const NodeGraph& graph_;
  std::vector<Found> shaders_, values_;
};

const char* reason(bool catchers, bool portals, bool light_path, const CameraDescription& camera,
                   const RenderSettings& settings) {
  if (catchers) return "shadow catchers";
  if (portals) return "ray portals";
  if (light_path) return "surfaces that follow the Light Path node or have no transparent shadows";
  if (camera.row_exposure < 1.0f) return "a rolling shutter";
  if (camera.stereo.offset != 0.0f) return "spherical stereoscopy";
  return settings.transparent_film && settings.transparent_glass ? "transparent glass" : "";
}

}  // namespace

bool depends_on_ray_kind(const MaterialDescription& material) {
  const std::vector<Node>& nodes = material.graph.nodes;
  const auto is_transparent = [](const Node& node) {
    if (node.type == "ShaderNodeBsdfTransparent") return true;
    return node.type == "ShaderNodeBsdfPrincipled" &&
           std::any_of(node.inputs.begin(), node.inputs.end(), [](const NodeInput& input) {
             return input.socket == "Alpha" && (input.link.node >= 0 || input.value.x < 1.0f);
           });
  };
  if (!material.transparent_shadow && std::any_of(nodes.begin(), nodes.end(), is_transparent)) return true;
  return LightPathSearch(material.graph).shader(material.graph.surface).follows_path;
}

std::string path_tracing_only(const SceneDescription& d) {
  return reason(has_catchers(d), any_shown(d, has_portal), any_shown(d, depends_on_ray_kind), d.camera, d.settings);
}

std::string path_tracing_only(const Scene* scene, const CameraDescription& camera, const RenderSettings& settings) {
  return reason(scene && scene->catchers(), scene && scene->has_portals(), scene && scene->depends_on_ray_kind(),
                camera, settings);
}

}  // namespace ajar
