// The light groups that a film shows, for integrators that know the whole path of their light.
#pragma once

#include "film/film.h"
#include "scene/pass_names.h"
#include "transport/paths/path_vertex.h"

namespace ajar {

class LightOfGroups {
 public:
  LightOfGroups() = default;
  LightOfGroups(const Scene& scene, const Film& film) {
    if (film.light_groups().empty()) return;
    shown_ = shown_light_groups(scene.light_groups(), film.light_groups());
    count_ = film.light_groups().size();
  }
  /// Whether the film shows any group.
  bool any() const { return count_ > 0; }
  /// Number of the groups of the scene.
  int size() const { return int(shown_.size()); }
  /// Index in Film::light_groups() of the group of a light; -1: no pass shows it.
  int pass_of(const Scene& scene, const PathVertex& light) const {
    const int group = any() ? light_group_of(scene, light) : -1;
    return group >= 0 ? shown_[size_t(group)] : -1;
  }
  /// Starts a sample.
  void begin() { parts_.groups.assign(count_, Color(0.0f)); }
  void add(const Scene& scene, const PathVertex& light, Color found) {
    if (const int pass = pass_of(scene, light); pass >= 0) parts_.groups[size_t(pass)] += found;
  }
  /// `group`: of the scene.
  void add(int group, Color found) {
    if (const int pass = shown_[size_t(group)]; pass >= 0) parts_.groups[size_t(pass)] += found;
  }
  /// For Film::add_parts.
  const SampleParts& parts() const { return parts_; }

 private:
  std::vector<int> shown_;  ///< of each group of the scene: its pass; -1: none
  size_t count_ = 0;
  SampleParts parts_;
};

}  // namespace ajar
