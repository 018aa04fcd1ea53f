#include "transport/direct/estimators/control_columns.h"

#include <algorithm>

#include "lights/sources/lamp.h"

namespace ajar {

namespace {

constexpr size_t kMaxControlledLights = 32;

/// Whether every light that LightSet can choose belongs to a group.
bool groups_cover(const LightSet& lights, const LightGroups& groups, Vec3 center) {
  for (const LightSet::SourceRange& source : lights.sources()) {
    for (uint32_t light = source.first; light < source.first + source.count; ++light) {
      if (groups.group_of(light) < 0 && lights.choice_pmf(center, Vec3(0.0f), light) > 0.0f) return false;
    }
  }
  return true;
}

}  // namespace

ControlColumns::ControlColumns(const Scene& scene, const LightGroups& groups, bool lump)
    : scene_(scene), groups_(groups), lump_(lump), light_columns_(lump ? 1 : groups.size()) {
  const LightSet& lights = scene.lights();
  size_t total = 0;
  for (int g = 0; g < groups.size(); ++g) total += groups.lights(g).size();
  possible_ = total > 0 && total <= kMaxControlledLights && !lights.any_moves() &&
              groups_cover(lights, groups, scene.center());
  if (!possible_) return;
  for (int g = 0; g < groups.size(); ++g) {
    for (uint32_t light : groups.lights(g)) {
      light_indices_.push_back(light);
      lights_.push_back(lights.light(light));
    }
  }
}

/// The point where a direction crosses a light that rays can hit, visible or occluded.
std::optional<ControlColumns::Crossing> ControlColumns::cross(const Light& light, Vec3 position, Vec3 wi) {
  if (light.type == LightType::Triangle) {
    // Möller and Trumbore 1997.
    const Vec3 p = glm::cross(wi, light.edge2);
    const float determinant = glm::dot(light.edge1, p);
    if (determinant == 0.0f) return {};
    const Vec3 s = position - light.position, q = glm::cross(s, light.edge1);
    const float b1 = glm::dot(s, p) / determinant, b2 = glm::dot(wi, q) / determinant;
    const float distance = glm::dot(light.edge2, q) / determinant;
    if (b1 < 0.0f || b2 < 0.0f || b1 + b2 > 1.0f || !(distance > 0.0f)) return {};
    return Crossing{distance, glm::normalize(glm::cross(light.edge1, light.edge2))};
  }
  if (is_distant(light.type)) return Crossing{kInfinity, -wi};
  Ray ray;
  ray.origin = position;
  ray.direction = wi;
  const auto crossing = intersect_lamp_shape(light, ray);
  if (!crossing) return {};
  const bool flat = light.type == LightType::Rectangle || light.type == LightType::Ellipse;
  if (flat && !(glm::dot(crossing->normal, wi) < 0.0f)) return {};
  return Crossing{crossing->t, crossing->normal};
}

/// Samples without a direction, and those of delta lights, are atoms of their own component.
ControlSample ControlColumns::sample(const DirectLightContext& c, const LightMixture::Kernel& k, int columns,
                                     int component, const LightMixture::Draw& draw) const {
  constexpr int kMaxMixtureLobes = LightMixture::kMaxMixtureLobes, kFirstGroup = LightMixture::kFirstGroup;
  const int lobes = k.lobes.count();
  ControlSample sample;
  std::fill_n(sample.z, kMaxControls, 0.0f);
  std::fill(sample.z + lobes, sample.z + columns, 1.0f);
  sample.y = draw.y;
  if (draw.wi == Vec3(0.0f)) {
    const bool lobe = component < kMaxMixtureLobes;
    sample.z[lobe ? component : columns + (lump_ ? 0 : component - kFirstGroup)] = 1.0f /
                                                                                   (lump_ && !lobe
                                                                                        ? 1.0f - k.bsdf_share()
                                                                                        : k.alpha[size_t(component)]);
    return sample;
  }
  float mixture = 0.0f;
  for (int i = 0; i < lobes; ++i) {
    sample.z[i] = draw.pdf_lobes[size_t(i)];
    mixture += k.alpha[size_t(i)] * draw.pdf_lobes[size_t(i)];
  }
  for (size_t i = 0; i < lights_.size(); ++i) {
    const Light& light = lights_[i];
    if (is_delta(light.type) || !light.mis) continue;
    const auto crossing = cross(light, c.point.position, draw.wi);
    if (!crossing) continue;
    const int g = groups_.group_of(light_indices_[i]);
    const float pdf = groups_.pmf_in_group(light_indices_[i]) *
                      scene_.lights().pdf_li(light_indices_[i], c.point.position, draw.wi, crossing->distance,
                                             crossing->normal, c.point.time);
    if (!(pdf > 0.0f)) continue;
    const float alpha = k.alpha[size_t(kFirstGroup + g)];
    mixture += alpha * pdf;
    // The single column of all lights is the mixture of the groups by their shares.
    sample.z[lump_ ? columns : columns + g] += lump_ ? pdf * alpha / (1.0f - k.bsdf_share()) : pdf;
  }
  if (!(mixture > 0.0f)) return sample;
  // z_j = p_j / K [Fan 2006, eq. 6.7].
  for (int j = 0; j < columns + light_columns_; ++j)
    if (j < lobes || j >= columns) sample.z[j] /= mixture;
  return sample;
}

}  // namespace ajar
