// Hints: light paths that an artist drew as curves, attached to lights and surfaces, and proposed again with small
// changes (user paths [Fan 2006, section 4.4]).
//
// Attaching. A curve's first point names the nearest light. From there, each next point is shot at: the surface hit is
// a vertex. Mirrors and clear glass on the way bounce the ray, whether the curve has a point there or not, and take a
// point of the curve that lies near. The last vertex must scatter diffusely or glossily, because the rest of a path is
// joined to it. A curve that cannot be attached is reported by name with the reason, and skipped; it never stops a
// render.
//
// Proposing. A path is rebuilt from the light: it starts anywhere on that light (for an emissive object, anywhere on
// the object; on a sphere, on the half that faces the hint's way), leaves every rough vertex j in a direction inside a
// cone around the one from *where it now is* to the hint's own vertex j + 1, and follows specular bounces of the hint's
// kind. Directions are uniform per solid angle in the cone, 1 / (2 pi (1 - cos spread)); the thesis' 1 / (2 pi spread)
// lacks the sine. `pdf` is the sum over all hints of that density, so any path can be asked about, whoever made it.
//
// A hint only proposes: what is proposed is weighed by its density, so no hint changes the mean of an image.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace ajar {

enum class HintSegmentState : uint8_t { Attached, Bounced, Failed };

struct HintReport {
  std::string name;
  bool attached = false;
  std::string reason;                      ///< why not; empty when attached
  std::vector<Vec3> positions;             ///< of the vertices found so far, the light's first
  std::vector<HintSegmentState> segments;  ///< of the ways between them; the last one may have failed
};

/// A hint after some rendering.
struct HintStatistics {
  HintReport report;
  uint64_t proposed = 0, accepted = 0;
  double energy_share = 0.0;  ///< of the light in the image: what came on paths that the hint could have proposed
};

class Hints {
 public:
  struct Vertex {
    Vec3 position;
    bool specular = false, transmitted = false;  ///< what the bounce there is, and of which kind
  };
  struct Hint {
    std::string name;
    uint32_t light;        ///< the nearest to its first point
    uint32_t first_light;  ///< of the lamp or emissive object that light is part of
    /// summed up, of the lights from first_light on, as light walks choose them
    std::vector<double> light_probabilities;
    Vec3 axis{0.0f};               ///< of its first segment
    double share;                  ///< probability of being chosen
    std::vector<Vertex> vertices;  ///< 0 on the light; the last one is rough
    /// of the cone's half-angle, for the segment that leaves each vertex but the last
    std::vector<float> one_minus_cos;
  };
  /// What pdf must know of a path: its vertices from the light on.
  struct PathPoint {
    Vec3 position;
    bool specular, transmitted = false;
  };

  /// Attach all hints of the scene that are enabled and have weight.
  static Hints attach(const Scene& scene, std::vector<HintReport>& reports) {
    return attach(scene, scene.hints(), reports);
  }
  static Hints attach(const Scene& scene, const std::vector<HintDescription>& descriptions,
                      std::vector<HintReport>& reports);

  bool empty() const { return hints_.empty(); }
  size_t size() const { return hints_.size(); }
  const Hint& operator[](size_t i) const { return hints_[i]; }
  uint32_t choose(float u) const;
  /// A light of the hint's lamp or emissive object, and a point on it; densities as for walks from lights, relative to
  /// the whole hint's.
  static uint32_t choose_light(const Hint& hint, float u);
  static void sample_position(const Hint& hint, const Light& light, Vec2 u, Vec3& position, Vec3& normal);
  /// Of a place on the light with this normal, over that by which walks from lights start.
  static double pdf_position(const Hint& hint, LightType type, Vec3 normal);

  /// Direction that leaves rough vertex `j` of the hint when its path has come to `position`; uniform in the cone.
  static Vec3 sample_direction(const Hint& hint, size_t j, Vec3 position, Vec2 u);
  static float pdf_solid_angle(const Hint& hint, size_t j, Vec3 position, Vec3 direction);

  /// Density of proposing these vertices by one hint, the first on `light` with this type and normal: per solid angle
  /// at every rough vertex and at the light, and for the first vertex relative to that of walks from lights
  /// (LightEnd::pdf_by_power). Conversions to area are the caller's. Specular vertices count 1. 0 when the hint could
  /// not have made it.
  static double pdf(const Hint& hint, uint32_t light, LightType type, Vec3 normal, std::span<const PathPoint> path);

 private:
  std::vector<Hint> hints_;
};

/// The hints of a scene, and what became of each. They hold as long as the scene's lights and surfaces do.
struct AttachedHints {
  Hints hints;
  std::vector<HintReport> reports;
};
inline AttachedHints attach_hints(const Scene& scene) {
  AttachedHints attached;
  attached.hints = Hints::attach(scene, attached.reports);
  return attached;
}

}  // namespace ajar
