// Participating media along paths: in which volumes a ray travels, where it scatters, how much light gets through.
//
// A path carries the stack of volumes it is in. They are entered and left by the geometric normal of surfaces whose
// material has a volume, as in Cycles; overlapping ones add up; the world's is always there and has no end. What was
// never left (a mesh with a hole) ends with the last surface a ray meets, and is counted.
//
// Homogeneous media: distances in closed form, drawn for one channel and weighed by the balance heuristic over all
// three. Media that vary from place to place: weighted delta tracking (spectral, absorption by weight), shadow rays by
// ratio tracking [Kutz, Habel, Li and Novák 2017, "Spectral and Decomposition Tracking"; Novák, Selle and Jarosz 2014].
// Its majorants are constant in the cells of a grid over the volume's bounds, found by sampling the shader: nothing can
// bound any graph. Where the extinction exceeds its majorant the estimate stays unbiased, null collisions then have
// negative weights [Galtier et al. 2013]; such places are counted. Extinction of more than kMaxOpticalDepthPerCell
// optical depths in a cell is cut to that, and counted.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "math/random.h"
#include "scene/scene.h"

namespace ajar {

struct MediaCounters {
  uint64_t lookups = 0;    ///< of media that vary
  uint64_t exceeded = 0;   ///< extinction above its majorant
  uint64_t capped = 0;     ///< extinction cut
  uint64_t refused = 0;    ///< values that were no numbers
  uint64_t open_ends = 0;  ///< volumes that a ray to infinity was still in
  uint64_t too_deep = 0;   ///< volumes beyond the most that may overlap, not entered
  void add(const MediaCounters& other);
};

/// The volumes a ray is in: indices into Media.
class MediaStack {
 public:
  static constexpr int kMax = 12;
  bool empty() const { return count_ == 0; }
  int size() const { return count_; }
  uint32_t operator[](int i) const { return media_[size_t(i)]; }
  /// False when there are too many.
  bool enter(uint32_t medium);
  void leave(uint32_t medium);
  bool contains(uint32_t medium) const;

 private:
  std::array<uint32_t, kMax> media_;
  int count_ = 0;
};

/// A stretch of a ray within its media.
struct MediaRay {
  const MediaStack& stack;
  const Ray& ray;
  float t_end;
  const ShadingPoint& path;  ///< of kind and depths of the ray
  uint32_t ray_kind;
};

/// exp(-extinction * distance), also of infinite distances.
Color transmittance_of(Color extinction, float distance);

class Media {
 public:
  /// The scene must outlive it.
  explicit Media(const Scene& scene);

  /// The volumes around a point of the camera: those that a ray upwards leaves without having entered them.
  MediaStack around(Vec3 position, float time, MediaCounters& counters) const;
  /// Through the surface at `hit`; `inwards` by its geometric normal.
  void cross(const Hit& hit, bool inwards, MediaStack& stack, MediaCounters& counters) const;
  size_t memory_bytes() const {
    return media_.capacity() * sizeof(Medium) + first_of_instance_.capacity() * sizeof(uint32_t) +
           majorants_.capacity() * sizeof(float);
  }
  /// What so many volumes among so many instances take at most; a volume is a material of an instance, or the world.
  static uint64_t max_bytes(uint64_t volumes, uint64_t instances);
  /// Out of all volumes that have an end.
  void leave_all(MediaStack& stack, MediaCounters& counters) const;

  /// The medium of a stretch on which nothing varies; false when something does.
  bool is_uniform(const MediaRay& along, MediumPoint& at, MediaCounters& counters) const;
  /// Does light scatter before the end of the ray? Then it does at `t`, where the medium is `at`. `beta` is weighed by
  /// what happened over its probability; `emitted` is what is emitted on the way, weighed by beta. When light may not
  /// scatter, `beta` is only dimmed.
  bool scatter_uniform(const MediaRay& along, const MediumPoint& at, bool may_scatter, Vec2 u, Color& beta,
                       Color& emitted, float& t) const;
  bool scatter_varying(const MediaRay& along, bool may_scatter, Pcg32& rng, Color& beta, Color& emitted, float& t,
                       MediumPoint& at, MediaCounters& counters) const;
  /// How much gets to the end of the ray; an unbiased estimate where media vary.
  Color transmittance(const MediaRay& along, Pcg32& rng, MediaCounters& counters) const;
  /// The same to the end of a shadow ray, through surfaces that let light through.
  Color transmittance_to_light(Ray ray, MediaStack stack, const ShadingPoint& path, Pcg32& rng,
                               MediaCounters& counters) const;

 private:
  static constexpr uint32_t kNone = ~0u;
  static constexpr float kMaxOpticalDepthPerCell = 500.0f;

  struct Medium {
    uint32_t instance, material;  // kNone: the world
    const ShaderProgram* program;
    bool varies;
    Vec3 lower, size, inverse_size;  // of the grid and its cells, where it varies
    std::array<int, 3> cells;
    size_t first_majorant;
    float most;  // extinction per metre
  };

  uint32_t medium_of(const Hit& hit) const;
  void add(const Medium& medium, ShadingPoint& inside, MediumPoint& point, MediaCounters& counters) const;
  void evaluate(const MediaStack& stack, ShadingPoint& inside, MediumPoint& point, MediaCounters& counters) const;
  void find_majorants(Medium& medium, int cells_along);
  bool varies(const MediaStack& stack) const;
  float majorant(const Medium& medium, Vec3 position, Vec3 direction, float& reach) const;
  bool reaches(const Medium& medium, Vec3 position) const;
  template <class Collide>
  void track(const MediaRay& along, Pcg32& rng, MediaCounters& counters, Collide&& collide) const;

  const Scene& scene_;
  std::vector<Medium> media_;
  std::vector<uint32_t> first_of_instance_;  // into media_; kNone: the instance has none
  std::vector<float> majorants_;
  uint32_t world_ = kNone;
  Vec3 lower_{kInfinity}, upper_{-kInfinity};  // of all that have an end
};

}  // namespace ajar
