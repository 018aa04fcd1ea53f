#include "scene/path_tracing_only.h"

#include <algorithm>

namespace ajar {

namespace {

/// Whether a visible material has a ray portal. The scene is not built yet.
bool has_portals(const SceneDescription& d) {
  const auto is_portal = [](const Node& node) { return node.type == "ShaderNodeBsdfRayPortal"; };
  std::vector<bool> portals;
  for (const MaterialDescription& material : d.materials)
    portals.push_back(std::any_of(material.graph.nodes.begin(), material.graph.nodes.end(), is_portal));
  if (std::find(portals.begin(), portals.end(), true) == portals.end()) return false;
  return std::any_of(d.instances.begin(), d.instances.end(), [&](const InstanceDescription& instance) {
    if (instance.object < 0 || size_t(instance.object) >= d.objects.size()) return false;
    const std::vector<int>& materials = d.objects[size_t(instance.object)].materials;
    return std::any_of(materials.begin(), materials.end(),
                       [&](int i) { return i >= 0 && size_t(i) < portals.size() && portals[size_t(i)]; });
  });
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
  return reason(has_catchers(d), has_portals(d), d.camera, d.settings);
}

std::string path_tracing_only(const Scene* scene, const CameraDescription& camera, const RenderSettings& settings) {
  return reason(scene && scene->catchers(), scene && scene->has_portals(), camera, settings);
}

}  // namespace ajar
