// Walks from lights that follow the artist's light paths: every technique that walks from lights finds what was pointed at.
//
// A hint is a row of cones (hints.h). A walk sets out inside the first cone of some hint with a learned chance, else by power and emission; near a
// rough vertex of a hint it goes on inside the next cone with a learned chance, else by the BSDF. Both are mixtures over one
// direction, whose densities depend on place and direction alone, so that everything that weighs walks from lights (balance heuristics,
// mutations, photons) sees the density of the mixture, and no hint changes the mean of an image.
//
// Shares are learned once, from bidirectional samples that are used for nothing else: one step of population Monte Carlo for mixtures from a
// defensive start [Cappe, Douc, Guillin, Marin and Robert 2008]. Each component gets a share in proportion to the part of all light that went its way,
// however it was found; of the walks that set out, less than that (docs/benchmarks/thesis.md). What brings nothing is followed no further, and costs
// nothing.
#pragma once

#include <atomic>

#include "transport/hints.h"
#include "transport/path_vertex.h"

namespace ajar {

class PathSeeds;
class PathSpace;
struct Path;

class HintGuide {
 public:
  HintGuide() = default;
  /// Before anything is learned: half of the walks set out along hints, by the hints' shares. The hints must outlive it.
  explicit HintGuide(const Hints& hints);
  bool active() const { return start_share_ > 0.0 || !bounces_.empty(); }

  /// Does a walk with this number set out along a hint? Then `u_choice` is fit for `start`, else for choosing a light by power.
  bool sets_out(float& u_choice) const;
  struct Start {
    uint32_t light;
    Vec3 position, normal, direction;
  };
  Start start(const LightSet& lights, float u_choice, Vec2 u_position, Vec2 u_direction) const;
  /// Densities of a walk that starts so, in place of those that `end` has of walks without hints.
  void mix(const LightSet& lights, uint32_t light, Vec3 position, Vec3 normal, Vec3 direction, LightEnd& end) const;

  /// The chance that a walk from a light which has come to this place on a surface goes on along a hint.
  float share_at(Vec3 position) const;
  /// Does it? Then its direction, else `u` is fit for use again.
  std::optional<Vec3> direction_at(Vec3 position, float& u, Vec2 u_direction) const;
  /// Of the directions along hints, per solid angle, their chance included.
  float pdf_at(Vec3 position, Vec3 direction) const;

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
  /// Chance of the place on the light by one hint, over its chance by power.
  double chance_of_place(size_t hint, uint32_t light, LightType type, Vec3 normal) const;

  const Hints* hints_ = nullptr;
  std::vector<double> starts_;          ///< chances of setting out along each hint
  double start_share_ = 0.0;            ///< their sum
  std::vector<Bounce> bounces_;
};

/// The artist's light paths in one render: attached, tried, followed as far as they pay.
class FollowedHints {
 public:
  /// Attach those of the scene, learn what they bring, and let the walks of `space` follow them. Costs nothing where there are none.
  /// This must outlive the space, and stay where it is.
  void begin(PathSpace& space, uint32_t seed, const std::atomic<bool>& stop);
  void clear();

  const Hints& hints() const { return hints_; }
  const std::vector<HintReport>& reports() const { return reports_; }
  /// Null where no hint is worth following.
  const HintGuide* guide() const { return guide_.active() ? &guide_ : nullptr; }
  /// How much of their usual share mutations by hints deserve, at most 1: by the light of paths that hints could have proposed whole.
  float mutation_use() const { return mutation_use_; }
  /// For integrators without chains: light as learned; proposed are the samples that learned it.
  std::vector<HintStatistics> statistics() const;
  uint64_t rays() const { return rays_; }

 private:
  struct Trial;
  Trial try_hints(PathSeeds& seeds, Path& path, Sampler& sampler) const;
  void learn(const PathSpace& space, uint32_t seed, const std::atomic<bool>& stop);

  Hints hints_;
  std::vector<HintReport> reports_;
  HintGuide guide_;
  std::vector<double> light_;           ///< of each hint: part of the image's
  std::vector<uint64_t> proposed_, useful_;
  float mutation_use_ = 1.0f;
  uint64_t rays_ = 0;
};

}  // namespace ajar
