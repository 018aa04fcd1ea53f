// Walks from lights that start where earlier ones brought light to the places that the image looks at.
//
// A start is drawn from the mixture
//   (1 - s) p(start without this guide) + s q(start),
// where q is learned: the source (a lamp, an emissive instance, or the world) in proportion to the light that it has
// brought, and its direction or place in proportion to theirs, by quadtrees [after Vorba et al. 2014, section 5, and
// Grittmann et al. 2018].
//   Lights with a place: the direction is learned, on the sphere; the place is sampled as without a guide, on spheres
//   among those that the direction leaves.
//   Suns: the place of the ray is learned, on a plane across the mean direction of the sun.
//   The world: the direction by a grid of cells, half of it as without a guide, and the place for each cell. Each start
//   gives a part of its value to other cells, with the surface that it met: light of any direction passes a window.
// The planes contain the focus, so that the places of slightly different directions agree there. The densities depend
// on position and direction alone, and everything that weights walks uses them. A guide therefore changes no mean.
// Lights that move are not learned. Another guide (light hints) can be inside this one; it is then a part of p.
#pragma once

#include <memory>
#include <vector>

#include "lights/light_set.h"
#include "math/adaptive_square.h"
#include "math/frame.h"
#include "transport/paths/light_walk_guide.h"

namespace ajar {

/// The start of a walk that brought light.
struct LightStart {
  uint32_t light;
  /// On the light. For distant lights the first surface on the ray, which rays of other directions may pass too.
  Vec3 origin;
  Vec3 direction;
  /// Estimate of what it brought. The sum over the starts in a set estimates the integral over this set.
  float value;
};

/// What was learned about the starts.
class EmissionMap {
 public:
  /// Where the learned planes are, and what is inside the scene.
  struct Extent {
    Vec3 focus, center;
    float radius;  ///< of the scene, around `center`
  };
  EmissionMap() = default;
  EmissionMap(const LightSet& lights, const Extent& extent, const std::vector<LightStart>& starts);
  bool empty() const { return sources_.empty(); }
  size_t memory_bytes() const;

  /// Draws a start from q. The map must not be empty.
  LightWalkGuide::Start sample(const LightSet& lights, float u_choice, Vec2 u_position, Vec2 u_direction) const;
  /// Densities of q, with the measures of LightEnd. `origin_without`: the density of the origin without a guide.
  struct Densities {
    double origin = 0.0, joint = 0.0;  ///< joint: origin times direction
  };
  Densities densities(const LightSet& lights, uint32_t light, Vec3 position, Vec3 direction,
                      float origin_without) const;

 private:
  /// A cell of directions of a distant source.
  struct Cell {
    Frame plane;               ///< its normal is the axis of the cell
    double probability = 0.0;  ///< in the source
    AdaptiveSquare places;
  };
  struct Source {
    uint32_t first, count;
    bool distant, world;
    double probability;             ///< of a learned start
    double power;                   ///< sum of the probabilities of its lights without a guide
    std::vector<float> power_sums;  ///< of its lights, cumulative
    AdaptiveSquare directions;      ///< of a light with a place
    std::vector<Cell> cells;        ///< of a distant one: one of a sun; a grid over the sphere for the world
  };
  /// Null if nothing was learned about the light.
  const Source* source_of(uint32_t light) const;
  void learn(Source& source, const LightSet& lights, const std::vector<const LightStart*>& starts);
  static size_t cell_of(const Source& source, Vec3 direction);
  Vec2 on_plane(const Cell& cell, Vec3 position, Vec3 direction) const;
  /// Density of the direction and of the ray's place, per solid angle and per area across the ray.
  float direction_pdf(const Source& source, Vec3 direction, float pdf_without) const;
  float place_pdf(const Source& source, Vec3 position, Vec3 direction) const;
  LightWalkGuide::Start sample_distant(const LightSet& lights, const Source& source, float u_choice, Vec2 u_position,
                                       Vec2 u_direction) const;
  Extent extent_{};
  float half_width_;             ///< of the planes
  std::vector<Source> sources_;  ///< in ascending order of their lights
};

class EmissionGuide final : public LightWalkGuide {
 public:
  /// The largest part of the walks that starts as learned.
  static constexpr float kMaxShare = 0.75f;

  /// `map`: not empty. `share`: s, above 0. `inner`: another guide, or null. It must outlive this object.
  EmissionGuide(std::shared_ptr<const EmissionMap> map, float share, const LightWalkGuide* inner)
      : map_(std::move(map)), share_(share), inner_(inner) {}

  bool sets_out(float& u_choice) const override;
  Start start(const LightSet& lights, float u_choice, Vec2 u_position, Vec2 u_direction) const override;
  void mix(const LightSet& lights, uint32_t light, Vec3 position, Vec3 normal, Vec3 direction,
           LightEnd& end) const override;
  float share_at(Vec3 position) const override { return inner_ ? inner_->share_at(position) : 0.0f; }
  std::optional<Vec3> direction_at(Vec3 position, float& u, Vec2 u_direction) const override {
    return inner_ ? inner_->direction_at(position, u, u_direction) : std::nullopt;
  }
  float pdf_at(Vec3 position, Vec3 direction) const override {
    return inner_ ? inner_->pdf_at(position, direction) : 0.0f;
  }

 private:
  std::shared_ptr<const EmissionMap> map_;
  float share_;
  const LightWalkGuide* inner_;
};

}  // namespace ajar
