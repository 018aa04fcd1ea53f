// Light hints: curves that an artist draws, attached to lights and surfaces, and proposed as paths with small changes
// (user paths [Fan 2006, section 4.4]).
//
// Attaching. The first point of a curve selects the nearest light. From there a ray is traced towards each next point,
// and the surface that it hits is a vertex. Mirrors and clear glass on the way reflect or refract the ray, whether or
// not the curve has a point there. A point of the curve near such a surface belongs to it. The last vertex must scatter
// diffusely or glossily, because the rest of a path is connected to it. A curve that cannot be attached is skipped and
// reported with its name and the reason. It never stops a render.
//
// Proposing. A path is built from the light. It starts at a random position on the light (for an emissive object,
// anywhere on the object; on a sphere, on the half towards the first segment). At each rough vertex j it continues in a
// direction inside a cone around the direction from its *own* vertex j to vertex j + 1 of the hint. At specular
// vertices it follows the hint's kind of bounce. Directions are uniform per solid angle in the cone, with density
//   1 / (2 pi (1 - cos spread)).
// The thesis' 1 / (2 pi spread) lacks the sine. `pdf` gives this density for any path, by whichever method it was
// found.
//
// Hints only propose. Every proposal is weighted by its density, so hints do not change the expectation of an image.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "transport/hints/emission_training.h"

namespace ajar {

enum class HintSegmentState : uint8_t { Attached, Bounced, Failed };

struct HintReport {
  std::string name;
  bool attached = false;
  std::string reason;                      ///< why it is not attached; empty when attached
  std::vector<Vec3> positions;             ///< of the vertices found so far, from the light
  std::vector<HintSegmentState> segments;  ///< between these vertices; the last one may have failed
};

/// A hint with its statistics during a render.
struct HintStatistics {
  HintReport report;
  uint64_t proposed = 0, accepted = 0;
  double energy_share = 0.0;  ///< part of the image's light on paths that the hint could have proposed
};

class Hints {
 public:
  struct Vertex {
    Vec3 position;
    bool specular = false, transmitted = false;  ///< kind of the bounce at this vertex
  };
  struct Hint {
    std::string name;
    uint32_t light;        ///< the nearest light to its first point
    uint32_t first_light;  ///< first light of the lamp or emissive object to which `light` belongs
    /// Cumulative probabilities of the lights from first_light on, as light walks choose them.
    std::vector<double> light_probabilities;
    Vec3 axis{0.0f};               ///< direction of the first segment
    double share;                  ///< probability of being chosen
    std::vector<Vertex> vertices;  ///< 0 on the light; the last one is rough
    /// 1 - cos of the half-angle of the cone, for the segment after each vertex but the last.
    std::vector<float> one_minus_cos;
  };
  /// A vertex of a path as `pdf` needs it, counted from the light.
  struct PathPoint {
    Vec3 position;
    bool specular, transmitted = false;
  };

  /// Attaches all hints of the scene that are enabled and have weight.
  static Hints attach(const Scene& scene, std::vector<HintReport>& reports) {
    return attach(scene, scene.hints(), reports);
  }
  static Hints attach(const Scene& scene, const std::vector<HintDescription>& descriptions,
                      std::vector<HintReport>& reports);

  bool empty() const { return hints_.empty(); }
  size_t size() const { return hints_.size(); }
  const Hint& operator[](size_t i) const { return hints_[i]; }
  uint32_t choose(float u) const;
  /// Chooses a light of the hint's lamp or emissive object, and a point on it, with the densities of walks from lights
  /// under the condition that they start on this lamp or object.
  static uint32_t choose_light(const Hint& hint, float u);
  static void sample_position(const Hint& hint, const Light& light, Vec2 u, Vec3& position, Vec3& normal);
  /// Density of a position with this normal on the light, relative to that of walks from lights.
  static double pdf_position(const Hint& hint, LightType type, Vec3 normal);

  /// Direction in which a path at `position` leaves the hint's rough vertex `j`; uniform in the cone.
  static Vec3 sample_direction(const Hint& hint, size_t j, Vec3 position, Vec2 u);
  static float pdf_solid_angle(const Hint& hint, size_t j, Vec3 position, Vec3 direction);

  /// Density with which one hint proposes these vertices. The first is on `light` with this type and normal. The
  /// density is per solid angle at the light and at every rough vertex. For the first vertex it is relative to the
  /// density of walks from lights (LightEnd::pdf_by_power). The caller converts to area. Specular vertices count as 1.
  /// Returns 0 when the hint cannot propose them.
  static double pdf(const Hint& hint, uint32_t light, LightType type, Vec3 normal, std::span<const PathPoint> path);

 private:
  std::vector<Hint> hints_;
};

/// The attached hints of a scene, and the report of each hint. Valid as long as the lights and surfaces of the scene.
struct AttachedHints {
  Hints hints;
  std::vector<HintReport> reports;
  /// Starts of walks from lights that need no hint. Null: none are learned.
  std::shared_ptr<SharedEmission> emission = std::make_shared<SharedEmission>();
};
inline AttachedHints attach_hints(const Scene& scene) {
  AttachedHints attached;
  attached.hints = Hints::attach(scene, attached.reports);
  return attached;
}

}  // namespace ajar
