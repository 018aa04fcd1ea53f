#include "scene/pass_names.h"

#include <algorithm>

#include "math/name_hash.h"

namespace ajar {

namespace {
constexpr uint32_t kBounces = kVisibleDiffuse | kVisibleGlossy | kVisibleTransmission;
constexpr size_t kMostNamed = 5;
}  // namespace

void gather_names(const SceneDescription& description, const std::vector<ObjectDescription>& objects,
                  const PassNames& names) {
  const auto group = [&](const std::string& name) {
    if (name.empty()) return -1;
    const auto found = std::find(names.groups.begin(), names.groups.end(), name);
    const auto index = found - names.groups.begin();
    if (found == names.groups.end()) names.groups.push_back(name);
    return int(index);
  };
  const auto is_limited = [&](int bounces) { return bounces < description.settings.bounces.total; };
  for (const LightDescription& light : description.lights)
    if (is_limited(light.max_bounces)) names.limited_lights.push_back("'" + light.name + "'");
  if (is_limited(description.world.max_bounces)) names.limited_lights.emplace_back("the world");
  for (const LightDescription& light : description.lights) names.lamp_groups.push_back(group(light.light_group));
  names.world_group = group(description.world.light_group);
  for (const ObjectDescription& object : objects) {
    names.object_groups.push_back(group(object.light_group));
    names.object_mattes.push_back(matte_id(object.name));
    const uint32_t seen_by = object.visibility & kBounces;
    if (const size_t named = names.partly_hidden_objects.size();
        seen_by != 0 && seen_by != kBounces && named <= kMostNamed)
      names.partly_hidden_objects.push_back(named < kMostNamed ? "'" + object.name + "'" : "...");
    names.asset_mattes.push_back(object.asset.empty() ? names.object_mattes.back() : matte_id(object.asset));
  }
  for (const MaterialDescription& material : description.materials)
    names.material_mattes.push_back(matte_id(material.name));
  names.material_mattes.push_back(matte_id("default_surface"));
}

std::vector<int> shown_light_groups(const std::vector<std::string>& of_scene, const std::vector<std::string>& of_film) {
  std::vector<int> shown;
  for (const std::string& name : of_scene) {
    const auto found = std::find(of_film.begin(), of_film.end(), name);
    shown.push_back(found == of_film.end() ? -1 : int(found - of_film.begin()));
  }
  return shown;
}

}  // namespace ajar
