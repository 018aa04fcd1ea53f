#include "transport/hints/hint_guide.h"

#include <algorithm>
#include <cmath>

namespace ajar {

namespace {

constexpr double kFirstShare = 0.5;  // of walks that follow hints before learning
constexpr double kMaxShare = 0.75;   // upper bound where cones overlap, so that some walks do not follow hints
constexpr float kSteepest = 1.7f;    // upper bound of the slope of a cone's side, for the radius of a bounce

float slope_of(float one_minus_cos) {
  const float cosine = 1.0f - one_minus_cos, sine = safe_sqrt(one_minus_cos * (2.0f - one_minus_cos));
  return sine < kSteepest * cosine ? sine / cosine : kSteepest;
}

}  // namespace

HintGuide::HintGuide(const Hints& hints) : hints_(&hints) {
  for (uint32_t k = 0; k < hints.size(); ++k) {
    const Hints::Hint& hint = hints[k];
    starts_.push_back(kFirstShare * hint.share);
    float way = 0.0f, slope = 0.0f;  // since the last rough vertex
    for (uint32_t j = 1; j + 1 < hint.vertices.size(); ++j) {
      if (!hint.vertices[j - 1].specular) way = 0.0f, slope = slope_of(hint.one_minus_cos[j - 1]);
      way += glm::length(hint.vertices[j].position - hint.vertices[j - 1].position);
      if (!hint.vertices[j].specular)
        bounces_.push_back({k, j, hint.vertices[j].position, sqr(way * slope), kFirstShare});
    }
  }
  start_share_ = starts_.empty() ? 0.0 : kFirstShare;
}

bool HintGuide::sets_out(float& u_choice) const {
  const auto share = float(start_share_);
  const bool follows = u_choice < share;
  u_choice = std::min(follows ? u_choice / share : (u_choice - share) / (1.0f - share), kOneMinusEpsilon);
  return follows;
}

HintGuide::Start HintGuide::start(const LightSet& lights, float u_choice, Vec2 u_position, Vec2 u_direction) const {
  double left = double(u_choice) * start_share_;
  size_t k = 0;
  while (k + 1 < starts_.size() && (left >= starts_[k] || !(starts_[k] > 0.0))) left -= starts_[k++];
  while (k > 0 && !(starts_[k] > 0.0)) --k;
  const Hints::Hint& hint = (*hints_)[k];
  Start start;
  start.light = Hints::choose_light(hint, std::clamp(float(left / starts_[k]), 0.0f, kOneMinusEpsilon));
  Hints::sample_position(hint, lights.light(start.light), u_position, start.position, start.normal);
  start.direction = Hints::sample_direction(hint, 0, start.position, u_direction);
  return start;
}

double HintGuide::probability_of_place(size_t k, uint32_t light, LightType type, Vec3 normal) const {
  const Hints::Hint& hint = (*hints_)[k];
  if (light < hint.first_light || light - hint.first_light >= hint.light_probabilities.size()) return 0.0;
  return starts_[k] / hint.light_probabilities.back() * Hints::pdf_position(hint, type, normal);
}

void HintGuide::mix(const LightSet& lights, uint32_t light, Vec3 position, Vec3 normal, Vec3 direction,
                    LightEnd& end) const {
  if (!(lights.power_pmf(light) > 0.0f)) return;
  const LightType type = lights.flags(light).type;
  const double free = 1.0 - start_share_;
  double probabilities = free, joint = free * double(end.pdf_direction);
  for (size_t k = 0; k < starts_.size(); ++k) {
    const double probability = probability_of_place(k, light, type, normal);
    if (!(probability > 0.0)) continue;
    probabilities += probability;
    joint += probability * double(Hints::pdf_solid_angle((*hints_)[k], 0, position, direction));
  }
  end.pdf_origin = float(double(end.pdf_origin) * probabilities);
  end.pdf_direction = float(joint / probabilities);
}

double HintGuide::shares_at(Vec3 position, double& factor) const {
  double sum = 0.0;
  for (const Bounce& b : bounces_)
    if (length_squared(position - b.position) <= b.radius2) sum += b.share;
  factor = sum > kMaxShare ? kMaxShare / sum : 1.0;
  return sum * factor;
}

float HintGuide::share_at(Vec3 position) const {
  double factor;
  return float(shares_at(position, factor));
}

std::optional<Vec3> HintGuide::direction_at(Vec3 position, float& u, Vec2 u_direction) const {
  double factor;
  const auto share = float(shares_at(position, factor));
  if (!(u < share)) {
    if (share > 0.0f) u = std::min((u - share) / (1.0f - share), kOneMinusEpsilon);
    return {};
  }
  double left = double(u) / factor;
  const Bounce* chosen = nullptr;
  for (const Bounce& b : bounces_) {
    if (length_squared(position - b.position) > b.radius2) continue;
    chosen = &b;
    left -= b.share;
    if (left < 0.0) break;
  }
  return Hints::sample_direction((*hints_)[chosen->hint], chosen->vertex, position, u_direction);
}

float HintGuide::pdf_at(Vec3 position, Vec3 direction) const {
  double factor, sum = 0.0;
  if (!(shares_at(position, factor) > 0.0)) return 0.0f;
  for (const Bounce& b : bounces_)
    if (length_squared(position - b.position) <= b.radius2)
      sum += b.share * double(Hints::pdf_solid_angle((*hints_)[b.hint], b.vertex, position, direction));
  return float(sum * factor);
}

}  // namespace ajar
