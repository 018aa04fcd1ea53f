// The names of a scene that passes and messages need: ids of Cryptomatte, light groups, lights with limits.
#pragma once

#include <string>
#include <vector>

#include "description/scene_description.h"

namespace ajar {

/// What `gather_names` fills: the groups of the scene, the lights whose number of bounces is less than the scene's, the
/// first objects that some kinds of rays beyond the camera see and others do not ("..." stands for more), the index of
/// the group of each lamp, of each object and of the world (-1: none), and the ids of each object, of its asset, and of
/// each material, with the default one last.
struct PassNames {
  std::vector<std::string>&groups, &limited_lights, &partly_hidden_objects;
  std::vector<int>&lamp_groups, &object_groups;
  int& world_group;
  std::vector<float>&object_mattes, &asset_mattes, &material_mattes;
};

void gather_names(const SceneDescription& description, const std::vector<ObjectDescription>& objects,
                  const PassNames& names);
/// For each light group of the scene, the index of its pass in Film::light_groups(); -1: no pass shows it.
std::vector<int> shown_light_groups(const std::vector<std::string>& of_scene, const std::vector<std::string>& of_film);

}  // namespace ajar
