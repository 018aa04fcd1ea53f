#include "shading/bsdf/diffuse_lobes.h"

#include <algorithm>
#include <cmath>

#include "shading/models/sheen.h"
#include "shading/models/toon.h"

namespace ajar {

namespace {

LobeValue diffuse_for_any_eye(const Lobe& lobe, Vec3 wo, Vec3 wi, TransportMode mode) {
  const float cos_o = glm::dot(lobe.frame.n, wo), cos_i = glm::dot(lobe.frame.n, wi);
  if (!((mode == TransportMode::Radiance ? cos_i : cos_o) > 0.0f)) return {};
  const float above_o = std::max(cos_o, 0.0f), above_i = std::max(cos_i, 0.0f);
  const Color f = lobe.roughness > 0.0f ? rough_diffuse(lobe, above_o, above_i, glm::dot(wo, wi))
                                        : lobe.weight * kInvPi;
  return {f * std::abs(cos_i), above_i * kInvPi};
}

}  // namespace

LobeValue microfiber(const Lobe& lobe, Vec3 wo, Vec3 wi, TransportMode mode) {
  const Vec3 n = lobe.frame.n;
  const float cos_o = glm::dot(n, wo), cos_i = glm::dot(n, wi);
  const sheen::Microfiber for_wo(lobe.roughness, cos_o);
  const float pdf = for_wo.density(Frame(n, wo).to_local(wi));
  if (mode == TransportMode::Radiance) return {lobe.weight * (for_wo.albedo * pdf), pdf};
  // The eye is at wi, and the cosine of the light is exchanged for that of wi.
  if (!(cos_o > 0.0f)) return {};
  const sheen::Microfiber for_wi(lobe.roughness, cos_i);
  const float value = for_wi.albedo * for_wi.density(Frame(n, wi).to_local(wo));
  return {lobe.weight * (value * std::abs(cos_i) / cos_o), pdf};
}

LobeValue toon_diffuse(const Lobe& lobe, Vec3 wo, Vec3 wi, TransportMode mode) {
  const float cos_o = glm::dot(lobe.frame.n, wo), cos_i = glm::dot(lobe.frame.n, wi);
  const float cos_light = mode == TransportMode::Radiance ? cos_i : cos_o;
  if (!(cos_light > 0.0f)) return {};
  const float pdf = cos_i > 0.0f ? 0.5f * (toon::pdf_solid_angle(cos_i, lobe.alpha_x, lobe.alpha_y) + cos_i * kInvPi)
                                 : 0.0f;
  // For importance, f is multiplied by the cosine of the other direction.
  return {lobe.weight * (toon::value(cos_light, lobe.alpha_x, lobe.alpha_y) * std::abs(cos_i) / cos_light), pdf};
}

LobeValue for_any_eye(const Lobe& lobe, Vec3 wo, Vec3 wi, TransportMode mode) {
  if (lobe.kind == LobeKind::MicrofiberSheen) return microfiber(lobe, wo, wi, mode);
  if (lobe.kind == LobeKind::ToonDiffuse) return toon_diffuse(lobe, wo, wi, mode);
  return diffuse_for_any_eye(lobe, wo, wi, mode);
}

}  // namespace ajar
