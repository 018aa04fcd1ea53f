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

const char* reason(bool catchers, bool portals, const CameraDescription& camera, const RenderSettings& settings) {
  if (catchers) return "shadow catchers";
  if (portals) return "ray portals";
  if (camera.row_exposure < 1.0f) return "a rolling shutter";
  if (camera.stereo.offset != 0.0f) return "spherical stereoscopy";
  return settings.transparent_film && settings.transparent_glass ? "transparent glass" : "";
}

}  // namespace

std::string path_tracing_only(const SceneDescription& d) {
  return reason(has_catchers(d), any_shown(d, has_portal), d.camera, d.settings);
}

std::string path_tracing_only(const Scene* scene, const CameraDescription& camera, const RenderSettings& settings) {
  return reason(scene && scene->catchers(), scene && scene->has_portals(), camera, settings);
}

}  // namespace ajar
