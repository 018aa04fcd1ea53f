#include "scene/catchers.h"

#include <vector>

namespace ajar {

SceneDescription catchers_alone(const SceneDescription& description) {
  SceneDescription alone;
  alone.objects = description.objects;
  alone.motion_keys = description.motion_keys;
  alone.instance_origins = description.instance_origins;
  alone.instance_values = description.instance_values;
  alone.materials = description.materials;
  alone.images = description.images;
  alone.color = description.color;
  alone.lights = description.lights;
  alone.world = description.world;
  alone.camera = description.camera;
  alone.dicing = description.dicing;
  alone.settings = description.settings;
  alone.meshes.resize(description.meshes.size());
  std::vector<bool> taken(description.meshes.size(), false);
  for (const InstanceDescription& instance : description.instances) {
    if (!is_catcher(description, instance)) continue;
    alone.instances.push_back(instance);
    const int mesh = description.objects[size_t(instance.object)].mesh;
    if (mesh < 0 || size_t(mesh) >= taken.size() || taken[size_t(mesh)]) continue;
    alone.meshes[size_t(mesh)] = description.meshes[size_t(mesh)];
    taken[size_t(mesh)] = true;
  }
  return alone;
}

}  // namespace ajar
