#include "transport/paths/light_passes.h"

#include <utility>

#include "scene/pass_names.h"
#include "transport/paths/eye_history.h"

namespace ajar {

namespace {

using Part = PathPasses::Part;

/// The part of the light after `bounces` > 0 scattering events. `first` says whether a volume has scattered it.
Part after_bounces(Part first, int bounces) {
  if (first == Part::None) return first;
  const bool in_volume = first == Part::VolumeDirect || first == Part::VolumeIndirect;
  if (bounces > 1) return in_volume ? Part::VolumeIndirect : Part::Indirect;
  return in_volume ? Part::VolumeDirect : Part::Direct;
}

}  // namespace

PathShares shares_of(const Bsdf& bsdf, const PathShares& scattered) {
  PathShares shares;
  const PathShares albedo = bsdf.albedo_of_kinds();
  for (int c = 0; c < 3; ++c) {
    const PathShares& of = scattered[0][c] + scattered[1][c] + scattered[2][c] > 0.0f ? scattered : albedo;
    const float sum = of[0][c] + of[1][c] + of[2][c];
    for (size_t k = 0; k < 3; ++k) shares[k][c] = sum > 0.0f ? of[k][c] / sum : k == 0 ? 1.0f : 0.0f;
  }
  return shares;
}

LightPasses::LightPasses(const Scene& scene, const Film& film, bool finds_direct) {
  parts_wanted_ = film.wants_light_parts();
  direct_wanted_ = finds_direct && film.wants_direct();
  if (film.light_groups().empty()) return;
  shown_ = shown_light_groups(scene.light_groups(), film.light_groups());
  count_ = film.light_groups().size();
}

PathPasses LightPasses::scattered_at(const PathVertex& first, Vec3 to_eye, Vec3 to_light, bool specular) const {
  PathPasses passes;
  if (!parts_wanted_) return passes;
  if (first.kind == VertexKind::Medium) {
    passes.part = Part::VolumeDirect;
    return passes;
  }
  if (specular)
    return LightPasses::specular(glm::dot(first.point.ng, to_eye) * glm::dot(first.point.ng, to_light) < 0.0f);
  Bsdf bsdf = lobes_towards(first, to_eye);
  // Light that goes below the surface leaves it elsewhere, at a vertex of its own.
  if (can_enter(first)) bsdf.remove_subsurface(to_eye);
  return scattered_by(bsdf, to_eye, to_light);
}

PathPasses LightPasses::scattered_by(const Bsdf& bsdf, Vec3 to_eye, Vec3 to_light) {
  return scattered(bsdf, bsdf.f_cos_of_kinds(to_eye, to_light));
}

PathPasses LightPasses::specular(bool transmits) {
  PathPasses passes;
  passes.part = Part::Direct;
  passes.shares[transmits ? 2 : 1] = Color(1.0f);
  return passes;
}

PathPasses LightPasses::scattered(const Bsdf& bsdf, const PathShares& light_of_kinds) {
  PathPasses passes;
  passes.part = Part::Direct;
  passes.shares = shares_of(bsdf, light_of_kinds);
  return passes;
}

PathPasses LightPasses::of(const Scene& scene, const PathVertex& light, int bounces, const PathPasses& first) const {
  PathPasses passes = part_of(bounces, first);
  if (!shown_.empty()) passes.group = shown(light_group_of(scene, light));
  if (passes.part == Part::Emission && light.light >= 0 && light.light == scene.lights().environment_index())
    passes.part = Part::Environment;
  return passes;
}

PathPasses LightPasses::of(const Scene& scene, const Path& path) const {
  if (!any()) [[likely]]
    return {};
  const int first = path.count - 2;
  if (first < 1) return of(scene, path.vertices[0], 0, {});
  const PathVertex& vertex = path.vertices[size_t(first)];
  return of(scene, path.vertices[0], first,
            scattered_at(vertex, path.to_eye(first), path.to_light(first), vertex.specular));
}

PathPasses LightPasses::part_of(int bounces, const PathPasses& first) const {
  PathPasses passes;
  if (!parts_wanted_) return passes;
  passes = first;
  if (bounces > 0)
    passes.part = after_bounces(first.part, bounces);
  else if (first.part != Part::Environment)
    passes.part = Part::Emission;
  return passes;
}

PathPasses LightPasses::of_group(int group) const {
  PathPasses passes;
  passes.group = shown(group);
  return passes;
}

void LightPasses::begin() {
  std::vector<Color> groups = std::move(parts_.groups);  // keeps its memory
  groups.assign(count_, Color(0.0f));
  parts_ = {};
  parts_.groups = std::move(groups);
}

void LightPasses::add(const SampleParts& other) {
  for (size_t g = 0; g < parts_.groups.size(); ++g) parts_.groups[g] += other.groups[g];
  parts_.emission += other.emission;
  parts_.environment += other.environment;
  for (size_t k = 0; k < 2; ++k) parts_.volume[k] += other.volume[k];
  for (size_t k = 0; k < 3; ++k) {
    parts_.direct[k] += other.direct[k];
    parts_.indirect[k] += other.indirect[k];
  }
}

void LightPasses::add_color(const Bsdf& bsdf, Color throughput) {
  if (!parts_wanted_) return;
  const auto color = bsdf.albedo_of_kinds();
  for (size_t k = 0; k < 3; ++k) parts_.color[k] += throughput * color[k];
}

}  // namespace ajar
