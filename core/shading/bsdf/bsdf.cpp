#include "shading/bsdf/bsdf.h"

#include <algorithm>
#include <cmath>

#include "math/warps.h"
#include "shading/bsdf/hair.h"
#include "shading/bsdf/lobe.h"
#include "shading/models/diffuse.h"
#include "shading/models/fresnel.h"

namespace ajar {

Bsdf& Bsdf::operator=(const Bsdf& other) {
  ng = other.ng;
  n = other.n;
  bump_base = other.bump_base;
  channel_weights = other.channel_weights;
  bump_terminator = other.bump_terminator;
  count_ = other.count_;
  layer_count_ = other.layer_count_;
  dropped_ = other.dropped_;
  has_non_delta_ = other.has_non_delta_;
  receiving_normal_ = other.receiving_normal_;
  single_lambert_ = other.single_lambert_;
  has_subsurface_ = other.has_subsurface_;
  bound_to_view_ = other.bound_to_view_;
  transmits_ = other.transmits_;
  prepared_wo_ = other.prepared_wo_;
  std::memmove(lobe_bytes_, other.lobe_bytes_, size_t(count_) * sizeof(Lobe));
  std::memmove(layer_bytes_, other.layer_bytes_, size_t(layer_count_) * sizeof(Layer));
  return *this;
}

void Bsdf::add(const Lobe& lobe) {
  if (!is_finite(lobe.weight)) return;
  const Color weight = glm::max(lobe.weight, Color(0.0f));
  if (is_black(weight)) return;
  int slot = count_;
  if (count_ == kMaxLobes) {
    slot = 0;
    for (int i = 1; i < kMaxLobes; ++i)
      if (luminance(lobes()[i].weight) < luminance(lobes()[slot].weight)) slot = i;
    ++dropped_;
    if (!(luminance(weight) > luminance(lobes()[slot].weight))) return;
  } else {
    ++count_;
  }
  Lobe* stored = new (lobes() + slot) Lobe(lobe);
  stored->weight = weight;
  stored->delta = lobe.is_delta();
  has_subsurface_ |= lobe.subsurface;
}

void Bsdf::prepare(Vec3 wo) {
  prepared_wo_ = wo;
  has_non_delta_ = transmits_ = false;
  receiving_normal_ = n;
  bool other_normals = false;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes()[i];
    if (lobe.delta) continue;
    transmits_ |= transmits(lobe.kind);
    if (!has_non_delta_) receiving_normal_ = lobe.frame.n;
    other_normals |= lobe.frame.n != receiving_normal_;
    has_non_delta_ = true;
  }
  if (transmits_ || other_normals) receiving_normal_ = Vec3(0.0f);
  single_lambert_ = count_ == 1 && lobes()[0].kind == LobeKind::Diffuse && lobes()[0].roughness == 0.0f &&
                    lobes()[0].frame.n == n;
  if (count_ == 1) {
    lobes()[0].selection = 1.0f;
    return;
  }
  float selection[kMaxLobes];
  select(wo, selection);
  for (int i = 0; i < count_; ++i) lobes()[i].selection = selection[i];
}

/// Converts f |cos(wi, n_lobe)| to the value that importance transport needs before shading_normal_correction.
float Bsdf::importance_factor(const Lobe& lobe, Vec3 wo, Vec3 wi) const {
  if (lobe.frame.n == n) return 1.0f;
  const float denominator = glm::dot(wi, lobe.frame.n) * glm::dot(wo, n);
  return denominator != 0.0f ? std::abs(glm::dot(wo, lobe.frame.n) * glm::dot(wi, n) / denominator) : 0.0f;
}

bool Bsdf::is_bumped(const Lobe& lobe) const {
  // Cycles counts velvet as glossy here, and transmitted light does not fade.
  const bool fades = is_diffuse(lobe.kind) && lobe.kind != LobeKind::Velvet && lobe.kind != LobeKind::Translucent;
  return fades && lobe.frame.n != n && lobe.frame.n != bump_base;
}

/// The weights contain the dimming by the layers for the wo of the makers. Importance needs it for the eye at wi.
Color Bsdf::layer_factor(const Lobe& lobe, Vec3 wo, Vec3 wi) const {
  Color factor(1.0f);
  for (int i = 0; i < layer_count_; ++i) {
    if ((lobe.layers >> i & 1) == 0) continue;
    const Color had = layers()[i].transmittance(ng, wo);
    factor *= layers()[i].transmittance(ng, wi) / glm::max(had, 1e-6f);
  }
  return factor;
}

template <bool kWithCosine>
Bsdf::Evaluation Bsdf::sum_lobes(Vec3 wo, Vec3 wi, TransportMode mode) const {
  // If the surface is seen from behind, the lobes are mirrored to the other side.
  const bool flipped = glm::dot(ng, wo) < 0.0f;
  float recomputed_storage[kMaxLobes];
  const float* recomputed = nullptr;
  if (count_ > 1 && wo != prepared_wo_) {
    select(wo, recomputed_storage);
    recomputed = recomputed_storage;
  }
  if (flipped) {
    wo = -wo;
    wi = -wi;
  }
  const float side = glm::dot(ng, wi);
  if (side == 0.0f) return {Color(0.0f), 0.0f};
  Evaluation sum{Color(0.0f), 0.0f};
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes()[i];
    if (lobe.delta) continue;
    LobeValue value = evaluate_lobe(lobe, wo, wi, side > 0.0f, mode, flipped);
    if (!(value.pdf_solid_angle > 0.0f) && !lobe.ignores_eye) continue;
    if (mode == TransportMode::Importance) {
      value.f_cos *= importance_factor(lobe, wo, wi);
      if (lobe.layers != 0) value.f_cos *= layer_factor(lobe, wo, wi);
    }
    if (is_bumped(lobe))
      value.f_cos *= bump_shadowing(bump_terminator, bump_base, lobe.frame.n,
                                    mode == TransportMode::Radiance ? wi : wo);
    if (!kWithCosine) value.f_cos /= std::abs(glm::dot(lobe.frame.n, wi));
    sum.f_cos += value.f_cos;
    sum.pdf_solid_angle += selection_for(i, recomputed) * value.pdf_solid_angle;
  }
  return sum;
}

template Bsdf::Evaluation Bsdf::sum_lobes<true>(Vec3 wo, Vec3 wi, TransportMode mode) const;

Color Bsdf::evaluate_beyond_horizon(Vec3 wo, Vec3 wi) const {
  const bool flipped = glm::dot(ng, wo) < 0.0f;
  if (flipped) {
    wo = -wo;
    wi = -wi;
  }
  Color sum(0.0f);
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes()[i];
    if (lobe.delta || is_fiber(lobe.kind)) continue;
    const float side = glm::dot(lobe.ignores_eye ? bump_base : n, wi);
    if (!(glm::dot(ng, wi) * side < 0.0f)) continue;
    const LobeValue value = evaluate_lobe(lobe, wo, wi, side > 0.0f, TransportMode::Radiance, flipped);
    if (!(value.pdf_solid_angle > 0.0f)) continue;
    sum += is_bumped(lobe) ? value.f_cos * bump_shadowing(bump_terminator, bump_base, lobe.frame.n, wi) : value.f_cos;
  }
  return sum;
}

Color Bsdf::f(Vec3 wo, Vec3 wi, TransportMode mode) const { return sum_lobes<false>(wo, wi, mode).f_cos; }

std::optional<BsdfSample> Bsdf::sample_lambert(Vec3 wo, Vec2 u) const {
  const Vec3 local = warp::square_to_cosine_hemisphere(u);
  const Vec3 front = lobes()[0].frame.to_world(local);
  const Vec3 wi = glm::dot(ng, wo) < 0.0f ? -front : front;
  const Evaluation value = evaluate_lambert(wo, wi);
  if (!(value.pdf_solid_angle > 0.0f)) return std::nullopt;
  return BsdfSample{wi, value.f_cos, value.pdf_solid_angle, kReflection | kDiffuse, false, 1.0f, 1.0f};
}

std::optional<BsdfSample> Bsdf::sample_lobes(Vec3 wo, float u_lobe, Vec2 u, TransportMode mode) const {
  if (count_ == 0) return std::nullopt;
  const bool flipped = glm::dot(ng, wo) < 0.0f;
  float recomputed_storage[kMaxLobes];
  const float* recomputed = nullptr;
  if (count_ > 1 && wo != prepared_wo_) {
    select(wo, recomputed_storage);
    recomputed = recomputed_storage;
  }

  // Choose a lobe, and stretch u_lobe to [0, 1) for the choices inside the lobe.
  int chosen = 0;
  float probability = selection_for(0, recomputed);
  while (u_lobe >= probability && chosen + 1 < count_) {
    u_lobe -= probability;
    probability = selection_for(++chosen, recomputed);
  }
  if (!(probability > 0.0f)) return std::nullopt;
  u_lobe = std::min(u_lobe / probability, kOneMinusEpsilon);

  const Lobe& lobe = lobes()[chosen];
  const Vec3 wo_front = flipped ? -wo : wo;
  LobeSample drawn;
  if (!sample_lobe(lobe, wo_front, u_lobe, u, mode, flipped, drawn)) return std::nullopt;
  const Vec3 wi = flipped ? -drawn.wi : drawn.wi;

  BsdfSample result{wi, Color(0.0f), 0.0f, drawn.flags, (drawn.flags & kSpecular) != 0, drawn.eta, drawn.roughness};
  if (result.specular) {
    const bool transparent = (drawn.flags & kTransparent) != 0;
    const float side = glm::dot(ng, drawn.wi);
    if (!transparent && ((drawn.flags & kReflection) != 0 ? !(side > 0.0f) : !(side < 0.0f))) return std::nullopt;
    result.f_cos = drawn.weight;
    if (mode == TransportMode::Importance && !transparent) {
      result.f_cos *= importance_factor(lobe, wo_front, drawn.wi);
      if (lobe.layers != 0) result.f_cos *= layer_factor(lobe, wo_front, drawn.wi);
    }
    if (transparent && lobe.portal) result.flags |= kPortal * uint32_t(chosen + 1);
    result.pdf_solid_angle = probability * drawn.probability;
    return result.pdf_solid_angle > 0.0f ? std::optional(result) : std::nullopt;
  }

  const Evaluation value = evaluate(wo, wi, mode);
  if (!(value.pdf_solid_angle > 0.0f) || !std::isfinite(value.pdf_solid_angle)) return std::nullopt;
  result.f_cos = value.f_cos;
  result.pdf_solid_angle = value.pdf_solid_angle;
  return result;
}

Bsdf::SubsurfacePart Bsdf::subsurface_part() const {
  SubsurfacePart part;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes()[i];
    if (!lobe.subsurface) continue;
    if (part.selection == 0.0f) part.normal = lobe.frame.n;
    part.weight += lobe.weight;
    part.selection += lobe.selection;
  }
  return part;
}

void Bsdf::remove_transparency(Vec3 wo) {
  keep_lobes(wo, [](const Lobe& lobe) { return lobe.kind != LobeKind::Transparent; });
}

void Bsdf::remove_subsurface(Vec3 wo) {
  keep_lobes(wo, [](const Lobe& lobe) { return !lobe.subsurface; });
  has_subsurface_ = false;
}

template <class Wanted>
void Bsdf::keep_lobes(Vec3 wo, Wanted&& wanted) {
  int kept = 0;
  for (int i = 0; i < count_; ++i) {
    if (!wanted(lobes()[i])) continue;
    if (kept != i)
      std::memcpy(lobe_bytes_ + size_t(kept) * sizeof(Lobe), lobe_bytes_ + size_t(i) * sizeof(Lobe), sizeof(Lobe));
    ++kept;
  }
  if (kept == count_) return;
  count_ = kept;
  prepare(wo);
}

/// Cosine above which two specular directions are the same. Near the critical angle, rounding moves them far.
static constexpr float kSameDirection = 0.9998f;
/// Relative difference of indices of refraction that are the same: lobes with other indices scatter red, green and blue
/// light into directions that are close together.
static constexpr float kSameEta = 1e-4f;

bool is_same_specular_direction(const BsdfSample& a, const BsdfSample& b) {
  return ((a.flags ^ b.flags) & (kReflection | kTransmission)) == 0 && std::abs(a.eta - b.eta) <= kSameEta * a.eta &&
         glm::dot(a.wi, b.wi) > kSameDirection;
}

/// Calls visit(event, probability) for every delta event except transparency.
template <class F>
void Bsdf::for_each_specular(Vec3 wo, TransportMode mode, F&& visit) const {
  const bool flipped = glm::dot(ng, wo) < 0.0f;
  float recomputed_storage[kMaxLobes];
  const float* recomputed = nullptr;
  if (count_ > 1 && wo != prepared_wo_) {
    select(wo, recomputed_storage);
    recomputed = recomputed_storage;
  }
  const Vec3 wo_front = flipped ? -wo : wo;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes()[i];
    if (!lobe.is_delta() || lobe.kind == LobeKind::Transparent) continue;
    const float selection = selection_for(i, recomputed);
    uint32_t seen = 0;
    // The two ends of u_branch select both branches of a glass lobe.
    for (const float u_branch : {0.0f, kOneMinusEpsilon}) {
      LobeSample drawn;
      if (!sample_lobe(lobe, wo_front, u_branch, Vec2(0.5f), mode, flipped, drawn)) continue;
      const uint32_t side = drawn.flags & (kReflection | kTransmission);
      if (seen & side) continue;
      seen |= side;
      const float cos_ng = glm::dot(ng, drawn.wi);
      if (side == kReflection ? !(cos_ng > 0.0f) : !(cos_ng < 0.0f)) continue;
      BsdfSample event{flipped ? -drawn.wi : drawn.wi,
                       drawn.weight,
                       selection * drawn.probability,
                       drawn.flags,
                       true,
                       drawn.eta,
                       drawn.roughness};
      if (mode == TransportMode::Importance) {
        event.f_cos *= importance_factor(lobe, wo_front, drawn.wi);
        if (lobe.layers != 0) event.f_cos *= layer_factor(lobe, wo_front, drawn.wi);
      }
      if (event.pdf_solid_angle > 0.0f) visit(event);
    }
  }
}

Bsdf::SpecularEvaluation Bsdf::evaluate_specular(Vec3 wo, Vec3 wi, TransportMode mode) const {
  SpecularEvaluation sum;
  float kind = 0.0f, cosine = kSameDirection;
  BsdfSample nearest{};
  const uint32_t side = glm::dot(ng, wo) * glm::dot(ng, wi) > 0.0f ? kReflection : kTransmission;
  for_each_specular(wo, mode, [&](const BsdfSample& event) {
    if (!(event.flags & side)) return;
    kind += event.pdf_solid_angle;
    const float cos_event = glm::dot(event.wi, wi);
    if (!(cos_event > kSameDirection)) return;
    if (sum.probability > 0.0f && !is_same_specular_direction(nearest, event)) {
      if (cos_event <= cosine) return;
      sum = {};
    }
    if (cos_event > cosine) {
      cosine = cos_event;
      nearest = event;
    }
    sum.weight += event.f_cos;
    sum.probability += event.pdf_solid_angle;
    sum.eta = event.eta;
  });
  if (kind > 0.0f) sum.follow_probability = sum.probability / kind;
  return sum;
}

int Bsdf::specular_directions(Vec3 wo, std::array<BsdfSample, kMaxSpecularDirections>& events) const {
  int count = 0;
  for_each_specular(wo, TransportMode::Radiance, [&](const BsdfSample& event) {
    for (int i = 0; i < count; ++i) {
      if (!is_same_specular_direction(events[size_t(i)], event)) continue;
      events[size_t(i)].f_cos += event.f_cos;
      events[size_t(i)].pdf_solid_angle += event.pdf_solid_angle;
      return;
    }
    if (count < kMaxSpecularDirections) events[size_t(count++)] = event;
  });
  return count;
}

std::optional<BsdfSample> Bsdf::follow_specular(Vec3 wo, bool transmitted, float u_lobe, TransportMode mode) const {
  const uint32_t side = transmitted ? kTransmission : kReflection;
  float sum = 0.0f;
  for_each_specular(wo, mode, [&](const BsdfSample& event) {
    if (event.flags & side) sum += event.pdf_solid_angle;
  });
  if (!(sum > 0.0f)) return std::nullopt;
  std::optional<BsdfSample> chosen;
  float left = u_lobe * sum;
  for_each_specular(wo, mode, [&](const BsdfSample& event) {
    if (!(event.flags & side) || (chosen && left < 0.0f)) return;
    chosen = event;
    left -= event.pdf_solid_angle;
  });
  if (chosen) chosen->pdf_solid_angle /= sum;
  return chosen;
}

Bsdf::KindShares Bsdf::kind_shares(Vec3 wo, Vec3 wi, bool specular) const {
  KindShares shares;
  const bool reflection = glm::dot(ng, wo) * glm::dot(ng, wi) > 0.0f;
  if (specular) {
    (reflection ? shares.glossy : shares.transmission) = 1.0f;
    return shares;
  }
  float selection[kMaxLobes];
  select(wo, selection);
  const bool flipped = glm::dot(ng, wo) < 0.0f;
  float sum = 0.0f;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes()[i];
    if (lobe.is_delta()) continue;
    const LobeValue value = evaluate_lobe(lobe, flipped ? -wo : wo, flipped ? -wi : wi, reflection,
                                          TransportMode::Radiance, flipped);
    const float share = selection[i] * value.pdf_solid_angle;
    if (!(share > 0.0f)) continue;
    sum += share;
    if (is_fiber(lobe.kind)) {
      const float part = hair::reflected_share(lobe, flipped ? -wo : wo, flipped ? -wi : wi, flipped);
      shares.glossy += part * share;
      shares.transmission += (1.0f - part) * share;
      continue;
    }
    const bool diffuse = is_diffuse(lobe.kind);
    (reflection ? (diffuse ? shares.diffuse : shares.glossy)
                : (diffuse ? shares.diffuse_transmission : shares.transmission)) += share;
  }
  if (!(sum > 0.0f)) return shares;
  for (float* share : {&shares.diffuse, &shares.glossy, &shares.transmission, &shares.diffuse_transmission})
    *share /= sum;
  return shares;
}

Color Bsdf::transparency() const {
  Color sum(0.0f);
  for (int i = 0; i < count_; ++i)
    if (lobes()[i].kind == LobeKind::Transparent) sum += lobes()[i].weight;
  return sum;
}

bool Bsdf::passes_thin_wall() const {
  float of_walls = 0.0f, of_others = 0.0f;
  for (int i = 0; i < count_; ++i)
    if (lobes()[i].kind == LobeKind::Transparent)
      (lobes()[i].thin_wall ? of_walls : of_others) += luminance(lobes()[i].weight);
  return of_walls > 0.0f && of_walls >= of_others;
}

std::array<Color, 3> Bsdf::f_cos_of_kinds(Vec3 wo, Vec3 wi) const {
  std::array<Color, 3> kinds{Color(0.0f), Color(0.0f), Color(0.0f)};
  const bool flipped = glm::dot(ng, wo) < 0.0f;
  if (flipped) {
    wo = -wo;
    wi = -wi;
  }
  const float side = glm::dot(ng, wi);
  if (side == 0.0f) return kinds;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes()[i];
    if (lobe.delta) continue;
    const LobeValue value = evaluate_lobe(lobe, wo, wi, side > 0.0f, TransportMode::Radiance, flipped);
    if (!(value.pdf_solid_angle > 0.0f)) continue;
    const bool diffuse = is_diffuse(lobe.kind);
    const float shadowing = is_bumped(lobe) ? bump_shadowing(bump_terminator, bump_base, lobe.frame.n, wi) : 1.0f;
    const bool transmitted = is_fiber(lobe.kind) ? lobe.kind == LobeKind::HairTransmission : side < 0.0f;
    kinds[diffuse ? 0 : transmitted ? 2 : 1] += value.f_cos * shadowing;
  }
  return kinds;
}

std::array<Color, 3> Bsdf::albedo_of_kinds() const {
  std::array<Color, 3> kinds{Color(0.0f), Color(0.0f), Color(0.0f)};
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes()[i];
    if (lobe.kind == LobeKind::Transparent) continue;
    const float cosine = glm::dot(lobe.frame.n, prepared_wo_);
    const Color albedo = lobe_albedo(lobe, cosine);
    if (is_diffuse(lobe.kind)) {
      kinds[0] += albedo;
    } else if (lobe.kind == LobeKind::MicrofacetGlass) {
      // Split as by a smooth interface. The transmitted part has the tint too.
      const float reflected = fresnel::dielectric(saturate(cosine), lobe.eta);
      kinds[1] += albedo * reflected;
      kinds[2] += albedo * (1.0f - reflected);
    } else {
      kinds[transmits(lobe.kind) && !hair::is_whole(lobe.kind) ? 2 : 1] += albedo;
    }
  }
  return kinds;
}

Color Bsdf::albedo() const {
  Color sum(0.0f);
  for (int i = 0; i < count_; ++i)
    if (lobes()[i].kind != LobeKind::Transparent)
      sum += lobe_albedo(lobes()[i], glm::dot(lobes()[i].frame.n, prepared_wo_));
  return sum;
}

Color Bsdf::albedo_of_sharp() const {
  constexpr float kSharp = 0.075f;  // microfacet roughness, as for the guides of Cycles' denoiser
  Color sum(0.0f);
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes()[i];
    if (lobe.kind != LobeKind::Transparent && (lobe.delta || std::max(lobe.alpha_x, lobe.alpha_y) <= kSharp))
      sum += lobe_albedo(lobe, glm::dot(lobe.frame.n, prepared_wo_));
  }
  return sum;
}

float shading_normal_correction(const Bsdf& bsdf, Vec3 wo, Vec3 wi) {
  if (bsdf.n == bsdf.ng) return 1.0f;
  const float denominator = glm::dot(wo, bsdf.ng) * glm::dot(wi, bsdf.n);
  if (denominator == 0.0f) return 0.0f;
  return std::abs(glm::dot(wo, bsdf.n) * glm::dot(wi, bsdf.ng) / denominator);
}

}  // namespace ajar
