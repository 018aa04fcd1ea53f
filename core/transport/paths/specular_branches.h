// Splitting at delta lobes. At surfaces with delta lobes, walks from the eye continue in all their directions with
// enough throughput, instead of in one sampled direction: a tree of rays [Whitted 1980], heaviest branches first. For
// example, the reflection of a lamp in a pane of glass, 1/25 of the light, is then in every sample, instead of in one
// of 25 with its full weight.
//
// The estimate is unbiased. Before any random number is used at the surface, it is decided whether a direction is
// followed. A followed direction has the weight of its lobes. A sampled direction counts unless it is one of the
// followed ones. Branches can share random numbers, because their contributions are summed and never multiplied.
#pragma once

#include <algorithm>
#include <array>

#include "shading/bsdf/bsdf.h"

namespace ajar {

/// The walks that remain for one sample. `Walk` stores its start, and its throughput as `beta`.
template <class Walk>
class SpecularBranches {
 public:
  explicit SpecularBranches(const Walk& first) : waiting_{first}, count_(1) {}

  /// Takes the heaviest of the remaining walks. Returns false if there is none.
  bool next(Walk& walk) {
    if (count_ == 0) return false;
    int heaviest = 0;
    for (int i = 1; i < count_; ++i)
      if (max_component(waiting_[size_t(i)].beta) > max_component(waiting_[size_t(heaviest)].beta)) heaviest = i;
    walk = waiting_[size_t(heaviest)];
    waiting_[size_t(heaviest)] = waiting_[size_t(--count_)];
    return true;
  }

  /// Splits a walk with throughput `beta` that arrives at this surface from `wo`. Calls make(event) for each direction
  /// that is followed; it returns the walk that continues by the delta event. The f_cos and pdf_solid_angle of an event
  /// are those of all lobes of its direction.
  template <class Make>
  void split(const Bsdf& bsdf, Vec3 wo, Color beta, Make&& make) {
    followed_ = 0;
    probability_ = 0.0f;
    const int found = bsdf.specular_directions(wo, events_);
    for (int i = 0; i < found; ++i) {
      const BsdfSample& event = events_[size_t(i)];
      // A direction that is sampled nearly always needs no branch.
      if (event.pdf_solid_angle > kNearlyCertain || !(max_component(beta * event.f_cos) >= kMin) || made_ == kMax)
        continue;
      probability_ += event.pdf_solid_angle;
      waiting_[size_t(count_++)] = make(event);
      events_[size_t(followed_++)] = event;
      ++made_;
    }
  }
  /// Whether the last split follows this event, which was sampled at the same surface.
  bool follows(const BsdfSample& drawn) const {
    return drawn.specular && !(drawn.flags & kTransparent) &&
           std::any_of(events_.begin(), events_.begin() + followed_,
                       [&](const BsdfSample& event) { return is_same_specular_direction(event, drawn); });
  }
  /// Whether the last split follows all events that can be sampled.
  bool follows_all() const { return probability_ > kNearlyCertain; }

  /// Throughput below which directions are only sampled. Roulette may end walks with less.
  static constexpr float kMin = 1.0f / 256.0f;

 private:
  static constexpr int kMax = 8;  ///< maximum number of branches per sample
  static constexpr float kNearlyCertain = 0.999f;
  std::array<Walk, kMax + 1> waiting_;
  int count_, made_ = 0, followed_ = 0;
  float probability_ = 0.0f;
  std::array<BsdfSample, Bsdf::kMaxSpecularDirections> events_;
};

}  // namespace ajar
