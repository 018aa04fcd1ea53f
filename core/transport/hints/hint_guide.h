// Walks from lights that follow the artist's light hints. All techniques with walks from lights then find the light
// that the hints mark.
//
// A hint is a sequence of cones (hints.h). A walk starts inside the first cone of a hint with a learned probability,
// and otherwise by power and emission. Near a rough vertex of a hint it continues inside the next cone with a learned
// probability, and otherwise by the BSDF. Both are mixtures over one direction whose densities depend on position and
// direction alone. Balance heuristics, mutations and photons use the density of the mixture, so hints do not change the
// expectation of an image.
//
// FollowedHints learns the shares (followed_hints.h).
#pragma once

#include "transport/hints/hints.h"
#include "transport/paths/light_walk_guide.h"
#include "transport/paths/path_vertex.h"

namespace ajar {

class HintGuide final : public LightWalkGuide {
 public:
  HintGuide() = default;
  /// The shares before learning: half of the walks start along hints, in proportion to the hints' shares. The hints
  /// must outlive this object.
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
  /// A rough vertex of a hint between its ends, and the sphere of positions that belong to it.
  struct Bounce {
    uint32_t hint, vertex;
    Vec3 position;
    float radius2;
    double share;
  };
  /// Sum of the shares at a position. `factor` scales them so that some walks do not follow hints.
  double shares_at(Vec3 position, double& factor) const;
  /// Probability of the position on the light by one hint, relative to its probability by power.
  double probability_of_place(size_t hint, uint32_t light, LightType type, Vec3 normal) const;

  const Hints* hints_ = nullptr;
  std::vector<double> starts_;  ///< probability of starting along each hint
  double start_share_ = 0.0;    ///< their sum
  std::vector<Bounce> bounces_;
};

}  // namespace ajar
