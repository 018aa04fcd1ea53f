// Walks from lights that follow the artist's light paths: every technique that walks from lights finds what was pointed
// at.
//
// A hint is a row of cones (hints.h). A walk sets out inside the first cone of some hint with a learned probability,
// else by power and emission; near a rough vertex of a hint it goes on inside the next cone with a learned probability,
// else by the BSDF. Both are mixtures over one direction, whose densities depend on place and direction alone, so that
// everything that weighs walks from lights (balance heuristics, mutations, photons) sees the density of the mixture,
// and no hint changes the mean of an image.
//
// The shares are learned by FollowedHints (followed_hints.h).
#pragma once

#include "transport/hints/hints.h"
#include "transport/paths/light_walk_guide.h"
#include "transport/paths/path_vertex.h"

namespace ajar {

class HintGuide final : public LightWalkGuide {
 public:
  HintGuide() = default;
  /// Before anything is learned: half of the walks set out along hints, by the hints' shares. The hints must outlive
  /// it.
  explicit HintGuide(const Hints& hints);
  bool active() const { return start_share_ > 0.0 || !bounces_.empty(); }

  bool sets_out(float& u_choice) const override;
  Start start(const LightSet& lights, float u_choice, Vec2 u_position, Vec2 u_direction) const override;
  void mix(const LightSet& lights, uint32_t light, Vec3 position, Vec3 normal, Vec3 direction,
           LightEnd& end) const override;
  float share_at(Vec3 position) const override;
  std::optional<Vec3> direction_at(Vec3 position, float& u, Vec2 u_direction) const override;
  float pdf_at(Vec3 position, Vec3 direction) const override;

 private:
  friend class FollowedHints;
  /// A rough vertex of a hint between its ends, and what is near enough to belong to it.
  struct Bounce {
    uint32_t hint, vertex;
    Vec3 position;
    float radius2;
    double share;
  };
  /// Sum of the shares there, and the factor that keeps some walks free.
  double shares_at(Vec3 position, double& factor) const;
  /// Probability of the place on the light by one hint, over its probability by power.
  double probability_of_place(size_t hint, uint32_t light, LightType type, Vec3 normal) const;

  const Hints* hints_ = nullptr;
  std::vector<double> starts_;  ///< probabilities of setting out along each hint
  double start_share_ = 0.0;    ///< their sum
  std::vector<Bounce> bounces_;
};

}  // namespace ajar
