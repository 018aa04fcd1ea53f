// At surfaces with delta lobes, walks from the eye go on in all directions of these that carry enough, instead of one
// that is drawn: a tree of rays [Whitted 1980], heaviest branches first. The image of a lamp in a pane of glass, a
// twenty-fifth of the light, is then in every sample, instead of in every twenty-fifth with its whole weight.
//
// Unbiased: a direction is followed with the weight of its lobes for certain, or not at all here, by what is known
// before anything is drawn at the surface; what is drawn there counts unless it is one of those followed. Branches may
// share their random numbers: their contributions are summed, never multiplied.
#pragma once

#include <algorithm>
#include <array>

#include "shading/bsdf/bsdf.h"

namespace ajar {

/// Walks still to be made for one sample. `Walk` holds where it begins, and its throughput as `beta`.
template <class Walk>
class SpecularBranches {
 public:
  explicit SpecularBranches(const Walk& first) : waiting_{first}, count_(1) {}

  /// The heaviest of those that wait; false when there is none.
  bool next(Walk& walk) {
    if (count_ == 0) return false;
    int heaviest = 0;
    for (int i = 1; i < count_; ++i)
      if (max_component(waiting_[size_t(i)].beta) > max_component(waiting_[size_t(heaviest)].beta)) heaviest = i;
    walk = waiting_[size_t(heaviest)];
    waiting_[size_t(heaviest)] = waiting_[size_t(--count_)];
    return true;
  }

  /// A walk with throughput `beta` to `wo` comes to this surface: make(event) is the walk that goes on by the delta
  /// event, in whose f_cos and pdf_solid_angle are those of all lobes of its direction. Called for each direction that
  /// shall be followed.
  template <class Make>
  void split(const Bsdf& bsdf, Vec3 wo, Color beta, Make&& make) {
    followed_ = 0;
    probability_ = 0.0f;
    const int found = bsdf.specular_directions(wo, events_);
    for (int i = 0; i < found; ++i) {
      const BsdfSample& event = events_[size_t(i)];
      // What is drawn nearly always needs no branch.
      if (event.pdf_solid_angle > kNearlyCertain || !(max_component(beta * event.f_cos) >= kMin) || made_ == kMax)
        continue;
      probability_ += event.pdf_solid_angle;
      waiting_[size_t(count_++)] = make(event);
      events_[size_t(followed_++)] = event;
      ++made_;
    }
  }
  /// Whether the last split follows this event, drawn at the same surface.
  bool follows(const BsdfSample& drawn) const {
    return drawn.specular && !(drawn.flags & kTransparent) &&
           std::any_of(events_.begin(), events_.begin() + followed_,
                       [&](const BsdfSample& event) { return is_same_specular_direction(event, drawn); });
  }
  /// Whether it follows all that could be drawn.
  bool follows_all() const { return probability_ > kNearlyCertain; }

  /// Throughput below which directions are left to chance; walks with less may be ended by roulette.
  static constexpr float kMin = 1.0f / 256.0f;

 private:
  static constexpr int kMax = 8;  ///< branches of one sample
  static constexpr float kNearlyCertain = 0.999f;
  std::array<Walk, kMax + 1> waiting_;
  int count_, made_ = 0, followed_ = 0;
  float probability_ = 0.0f;
  std::array<BsdfSample, Bsdf::kMaxSpecularDirections> events_;
};

}  // namespace ajar
