// The parts of Bsdf that know how lobes depend on the direction for which they are made: the choice of a lobe, layers,
// lobes for another direction, and pairs of directions.
#include <algorithm>
#include <cmath>

#include "shading/bsdf/bsdf.h"
#include "shading/bsdf/closures.h"
#include "shading/bsdf/lobe.h"
#include "shading/models/diffuse.h"

namespace ajar {

Color Layer::transmittance(Vec3 ng, Vec3 eye) const {
  const float cosine = saturate(glm::dot(ng, eye) < 0.0f ? -glm::dot(lobe.frame.n, eye) : glm::dot(lobe.frame.n, eye));
  Color factor(saturate(1.0f - max_component(lobe_albedo(lobe, cosine))));
  if (tint_share > 0.0f) {
    const float cos_inside = std::sqrt(std::max(1.0f - (1.0f - cosine * cosine) / sqr(lobe.eta), 1e-4f));
    factor *= glm::mix(Color(1.0f), glm::pow(tint, Color(1.0f / cos_inside)), tint_share);
  }
  return factor;
}

uint8_t Bsdf::add_layer(const Layer& layer) {
  if (layer_count_ == kMaxLayers) {
    bind_to_view();
    return 0;
  }
  new (layers() + layer_count_) Layer(layer);
  return uint8_t(1u << layer_count_++);
}

/// Selection probabilities are proportional to the light that a lobe scatters for this wo, summed over the channels by
/// their importance, with a minimum of one hundredth of the lobe's weight. `factor`: of the weight of a lobe.
template <class Factor>
void Bsdf::select(Vec3 wo, float (&selection)[kMaxLobes], const Factor& factor) const {
  const bool flipped = glm::dot(ng, wo) < 0.0f;
  float sum = 0.0f;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes()[i];
    const float cosine = flipped ? -glm::dot(lobe.frame.n, wo) : glm::dot(lobe.frame.n, wo);
    const float floor = 0.01f * glm::dot(channel_weights, factor(i) * lobe.weight);
    selection[i] = std::max(glm::dot(channel_weights, factor(i) * lobe_scattered(lobe, cosine, flipped)), floor);
    if (!(cosine > 0.0f) && lobe.kind != LobeKind::Transparent && !lobe.ignores_eye) selection[i] = floor;
    sum += selection[i];
  }
  const float scale = sum > 0.0f ? 1.0f / sum : 0.0f;
  for (int i = 0; i < count_; ++i) selection[i] *= scale;
}
void Bsdf::select(Vec3 wo, float (&selection)[kMaxLobes]) const {
  select(wo, selection, [](int) { return 1.0f; });
}

bool Bsdf::can_turn_to(Vec3 wo) const {
  if (bound_to_view_ || dropped_ > 0 || !(glm::dot(ng, wo) > 0.0f)) return false;
  const auto stays = [&](Vec3 normal) { return closures::safe_shading_normal(ng, wo, normal) == normal; };
  if (!stays(n)) return false;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes()[i];
    if (lobe.frame.n != n && !lobe.ignores_eye && !stays(lobe.frame.n)) return false;
  }
  return true;
}

void Bsdf::layers_for(Vec3 wo, Color (&factors)[kMaxLobes]) const {
  std::fill_n(factors, count_, Color(1.0f));
  for (int k = 0; k < layer_count_; ++k) {
    const Color factor = layers()[k].transmittance(ng, wo) / glm::max(layers()[k].in_weights, 1e-6f);
    for (int i = 0; i < count_; ++i)
      if (lobes()[i].layers >> k & 1) factors[i] *= factor;
  }
}

void Bsdf::turn(Vec3 wo, bool with_layers, Turned& turned) const {
  if (wo == prepared_wo_) return;
  turned.other_weights = with_layers && layer_count_ > 0;
  turned.other_selection = count_ > 1;
  if (turned.other_weights) layers_for(wo, turned.factors);
  if (!turned.other_selection) return;
  if (turned.other_weights)
    select(wo, turned.selection, [&](int i) { return turned.factors[i]; });
  else
    select(wo, turned.selection);
}

void Bsdf::turn_to(Vec3 wo) {
  if (layer_count_ > 0) {
    Color factors[kMaxLobes];
    layers_for(wo, factors);
    for (int i = 0; i < count_; ++i) lobes()[i].weight *= factors[i];
    for (int k = 0; k < layer_count_; ++k) layers()[k].in_weights = layers()[k].transmittance(ng, wo);
  }
  prepare(wo);
}

Bsdf::PairEvaluation Bsdf::evaluate_pair(Vec3 to_eye, Vec3 to_light, bool turns) const {
  if (single_lambert_) {
    const Evaluation value = evaluate_lambert(to_eye, to_light);
    const float pdf_to_eye = value.pdf_solid_angle > 0.0f ? std::abs(glm::dot(n, to_eye)) * kInvPi : 0.0f;
    return {value.f_cos, value.pdf_solid_angle, pdf_to_eye};
  }
  const float side_of_eye = glm::dot(ng, to_eye), side_of_light = glm::dot(ng, to_light);
  const bool seen_from_behind = side_of_eye < 0.0f, lit_from_behind = side_of_light < 0.0f;
  PairEvaluation sum;
  if (side_of_light == 0.0f) return sum;
  Turned eye, light;
  turn(to_eye, turns, eye);
  turn(to_light, turns, light);
  const bool reflection = seen_from_behind == lit_from_behind;
  const Vec3 eye_front = seen_from_behind ? -to_eye : to_eye, light_front = seen_from_behind ? -to_light : to_light;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes()[i];
    if (lobe.delta) continue;
    LobeValue value;
    float pdf_to_eye = 0.0f;
    if (reflection && shares_evaluation(lobe)) {
      value = evaluate_reflection(lobe, eye_front, light_front, seen_from_behind, pdf_to_eye);
    } else {
      value = evaluate_lobe(lobe, eye_front, light_front, reflection, TransportMode::Radiance, seen_from_behind);
      const Vec3 from = lit_from_behind ? -to_light : to_light, to = lit_from_behind ? -to_eye : to_eye;
      pdf_to_eye = evaluate_lobe(lobe, from, to, reflection, TransportMode::Radiance, lit_from_behind).pdf_solid_angle;
    }
    if (side_of_eye != 0.0f)
      sum.pdf_to_eye += selection_for(i, light.other_selection ? light.selection : nullptr) * pdf_to_eye;
    if (!(value.pdf_solid_angle > 0.0f) && !lobe.ignores_eye) continue;
    if (eye.other_weights) value.f_cos *= eye.factors[i];
    if (is_bumped(lobe)) value.f_cos *= bump_shadowing(bump_terminator, bump_base, lobe.frame.n, light_front);
    sum.f_cos += value.f_cos;
    sum.pdf_to_light += selection_for(i, eye.other_selection ? eye.selection : nullptr) * value.pdf_solid_angle;
  }
  return sum;
}

}  // namespace ajar
