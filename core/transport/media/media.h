// Participating media along paths: the volumes in which a ray travels, the points where it scatters, and transmittance.
//
// A path stores a stack of the volumes in which it is. They are entered and left by the geometric normal of surfaces
// whose material has a volume, as in Cycles. Overlapping volumes are added. A ray does not see volumes of objects that
// are hidden from its kind; shadow rays too, wherever they start. The volume of the world is always there and has no
// end. A volume that was never left (a mesh with a hole) ends at the last surface that a ray meets, and is counted.
//
// Homogeneous media: distances are sampled in closed form for one channel and weighted by the balance heuristic over
// all three channels.
//
// Media that vary: weighted delta tracking (spectral, with absorption by weights); shadow rays use ratio tracking
// [Kutz, Habel, Li and Novák 2017, "Spectral and Decomposition Tracking"; Novák, Selle and Jarosz 2014]. The majorants
// are constant in the cells of a grid over the volume's bounds, whose cells are small along axes of strong variation.
// Cells in which a ray would have many null collisions are divided (fine_majorants.h). Majorants are found by sampling
// the shader, because the extinction of a node graph cannot be bounded in general. Where the extinction exceeds its
// majorant, null collisions have negative weights and the estimate stays unbiased [Galtier et al. 2013]; such points
// are counted. Extinction that exceeds the optical depth kMaxOpticalDepthPerCell in a cell is reduced to it and
// counted. The volume of the world may vary too: its cells grow with the distance from the scene (majorant_grid.h).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "math/random.h"
#include "scene/scene.h"
#include "transport/media/fine_majorants.h"
#include "transport/media/majorant_grid.h"

namespace ajar {

struct MediaCounters {
  uint64_t lookups = 0;    ///< evaluations of media that vary
  uint64_t exceeded = 0;   ///< points with extinction above the majorant
  uint64_t capped = 0;     ///< points with reduced extinction
  uint64_t refused = 0;    ///< values that were not numbers
  uint64_t open_ends = 0;  ///< volumes in which a ray to infinity still was
  uint64_t too_deep = 0;   ///< volumes that were not entered because too many overlap
  void add(const MediaCounters& other);
};

/// Maximum number of surfaces along one ray that only enclose volumes, as in Cycles.
inline constexpr int kMaxVolumeBounds = 1024;

/// The volumes in which a ray is, as indices into Media.
class MediaStack {
 public:
  static constexpr int kMax = 12;
  bool empty() const { return count_ == 0; }
  int size() const { return count_; }
  uint32_t operator[](int i) const { return media_[size_t(i)]; }
  /// Returns false if the stack is full.
  bool enter(uint32_t medium);
  void leave(uint32_t medium);
  bool contains(uint32_t medium) const;

 private:
  std::array<uint32_t, kMax> media_;
  int count_ = 0;
};

/// A part of a ray between two surfaces, with the media around it.
struct MediaRay {
  const MediaStack& stack;
  const Ray& ray;
  float t_end;
  const ShadingPoint& path;  ///< type and depths of the ray
  uint32_t ray_kind;
  /// Kind of the ray for transmittance, if it differs: the edge from a light to the next vertex can collide as a walk
  /// from the light does, but it is attenuated as the shadow ray that finds the same path.
  uint32_t attenuated_as = 0;
};

/// Emission and scattering on a segment of a ray.
struct MediaEvent {
  Color emitted{0.0f};  ///< before the event, weighted by the throughput
  float t = 0.0f;       ///< distance at which light scatters
  MediumPoint at;       ///< the medium there
};

/// The shading point of a medium on the stretch, without a position.
ShadingPoint inside_of(const MediaRay& along);

/// exp(-extinction * distance), also for infinite distances.
Color transmittance_of(Color extinction, float distance);

class Media {
 public:
  /// The scene must outlive this object.
  explicit Media(const Scene& scene);

  /// The volumes around a camera position: those that an upward ray leaves without having entered them.
  MediaStack around(Vec3 position, float time, MediaCounters& counters) const;
  /// Crosses the surface at `hit`. `inwards` is by its geometric normal.
  void cross(const Hit& hit, bool inwards, MediaStack& stack, MediaCounters& counters) const;
  size_t memory_bytes() const;
  /// The maximum memory for a number of volumes and instances. A volume is a material of an instance, or the world.
  static uint64_t max_bytes(uint64_t volumes, uint64_t instances);
  /// Leaves all volumes except that of the world.
  void leave_all(MediaStack& stack, MediaCounters& counters) const;

  /// Finds the medium of a part of a ray on which no medium varies. Returns false if one varies.
  bool is_uniform(const MediaRay& along, MediumPoint& at, MediaCounters& counters) const;
  /// Returns true if light scatters before the end of the ray. `beta` is multiplied by the contribution of the event
  /// over its probability. If light may not scatter, `beta` is only multiplied by the transmittance. In a uniform
  /// medium, `event.at` is input.
  bool scatter_uniform(const MediaRay& along, bool may_scatter, Vec2 u, Color& beta, MediaEvent& event) const;
  bool scatter_varying(const MediaRay& along, bool may_scatter, Pcg32& rng, Color& beta, MediaEvent& event,
                       MediaCounters& counters) const;
  /// Splits the light: `beta` becomes the contribution of scattering over its probability, at `event`, and what passes to
  /// the end of the ray is returned. Light always scatters if the medium does, so both are parts of each sample.
  Color split_uniform(const MediaRay& along, Vec2 u, Color& beta, MediaEvent& event) const;
  Color split_varying(const MediaRay& along, Pcg32& rng, Color& beta, MediaEvent& event, MediaCounters& counters) const;
  /// The transmittance to the end of the ray. It is an unbiased estimate for media that vary.
  Color transmittance(const MediaRay& along, Pcg32& rng, MediaCounters& counters) const;
  /// The transmittance to the end of a shadow ray, including that of transparent surfaces. `by_ray_kind`: as for
  /// Scene::transmittance.
  Color transmittance_to_light(Ray ray, MediaStack stack, const ShadingPoint& path, Pcg32& rng, MediaCounters& counters,
                               bool* by_ray_kind = nullptr) const;

  /// The receiver set of the object that contains the innermost volume of the stack.
  uint32_t receiver_set(const MediaStack& stack) const;
  /// Whether some medium of the stack varies, or emits.
  bool varies(const MediaStack& stack) const;
  bool emits(const MediaStack& stack) const;
  bool any_emission() const;
  /// Whether a volume is hidden from some kind of rays.
  bool hides_volumes() const { return any_hidden_; }
  bool fills_world() const { return world_ != kNone; }
  /// Collisions per metre of path_media.h, constant along a stretch: the extinction of uniform media and the mean
  /// extinction of media that vary. Media that do not scatter have none.
  Color collision_rate(const MediaRay& along, MediaCounters& counters) const;
  /// The medium at distance t.
  MediumPoint at(const MediaRay& along, float t, MediaCounters& counters) const;

 private:
  static constexpr uint32_t kNone = ~0u;
  static constexpr float kMaxOpticalDepthPerCell = 500.0f;

  struct Medium {
    uint32_t instance, material;  // kNone: the volume of the world
    const ShaderProgram* program;
    bool varies;
    MajorantGrid grid;  // only for media that vary
    size_t first_majorant;
    float most;                   // maximum extinction per metre; 0: no limit
    Color mean_extinction{0.0f};  // where light is, of media that vary; 0 if nothing scatters
    bool emits = false;
    uint32_t visibility = ~0u;  // of the object
    float least = 0.0f;         // minimum majorant
    FineMajorants fine;
    float scale = 1.0f;  // of all coefficients, for media that keep their optical depth when they are scaled
  };

  uint32_t medium_of(const Hit& hit) const;
  void add(const Medium& medium, ShadingPoint& inside, MediumPoint& point, MediaCounters& counters) const;
  const MediaStack& seen_by(const MediaRay& along, MediaStack& scratch) const;
  void evaluate(const MediaStack& stack, ShadingPoint& inside, MediumPoint& point, MediaCounters& counters) const;
  struct Samples;
  Samples sample_cells(const Medium& medium) const;
  Vec3 sample_voxels(const Medium& medium, Samples& all) const;
  void find_majorants(Medium& medium, int cells_along, size_t max_divided);
  void divide_cells(Medium& medium, const Samples& all, size_t max_divided);
  float least_majorant(const Medium& medium, const std::array<int, 3>& cell) const;
  void find_fine_majorants(const Medium& medium, size_t cell, FineMajorants::Cells& found) const;
  void find_emission();
  template <bool kEndless>
  float majorant(const Medium& medium, Vec3 position, Vec3 direction, float& reach) const;
  float fine_majorant(const Medium& medium, const std::array<int, 3>& cell, Vec3 position, Vec3 direction,
                      float& reach) const;
  template <bool kEndless>
  bool reaches(const Medium& medium, Vec3 position) const;
  template <class Collide>
  void track(const MediaRay& along, Pcg32& rng, MediaCounters& counters, Collide&& collide) const;

  const Scene& scene_;
  std::vector<Medium> media_;
  std::vector<uint32_t> first_of_instance_;  // index into media_; kNone: the instance has no medium
  std::vector<float> majorants_;
  uint32_t world_ = kNone;
  bool any_hidden_ = false;                    // from some kinds of rays
  Vec3 lower_{kInfinity}, upper_{-kInfinity};  // bounds of all volumes except that of the world
};

}  // namespace ajar
