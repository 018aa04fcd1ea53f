// Photon map: positions, directions and flux of photons, and radiance by density estimation [Jensen 2001, chapter 7].
//
// A photon stores its flux divided by the cosine at the geometric normal of its surface. A sum of f_cos (which contains
// the cosine at the shading normal) over photons is then exact also where the two normals differ:
//   L(x, wo) = 1 / (pi r^2) sum_p f_cos(wo, wi_p) flux_p / |cos(wi_p, ng_p)|.
// A photon that has come a distance of less than r counts within that distance only, with r^2 over its square.
// Lookups leave out photons whose path would exceed a bounce limit (bounces_left.h).
// A photon of a map takes 32 bytes, and 16 bytes for the surface around it (photon_discs.h).
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "scene/scene.h"
#include "transport/photons/bounces_left.h"
#include "transport/photons/photon_discs.h"
#include "transport/photons/photon_points.h"
#include "transport/photons/point_tree.h"

namespace ajar {

struct Photon {
  SurfacePoint point;
  Color flux_over_cosine;     ///< watts
  uint32_t packed_direction;  ///< short, towards the previous vertex of the light's path; its kernel, and flags
  PackedBounces left = {};    ///< bounces that the limits leave to the eye's side of the path, this scattering included

  /// Lookups from the other side of the surface see the photon too.
  static constexpr uint32_t kTransmits = 1u << 31;
  /// The photon comes from a Markov chain.
  static constexpr uint32_t kOfChain = 1u << 30;
};
static_assert(sizeof(Photon) == 36);

/// The largest area over which a photon spreads its light. The light of a path that has come from a distance d varies
/// over about d: light below a lamp that hangs close to a ceiling must not reach the ceiling around the lamp. Kernels are
/// discs of radius 4 d, in steps of a factor of sqrt(2) of the radius, of at least 1/181 of `largest`. Smaller ones have
/// less bias and more noise (docs/research/denoising.md).
class PhotonKernels {
 public:
  PhotonKernels() = default;
  explicit PhotonKernels(float largest) : largest2_(largest * largest) {}
  /// Bits of Photon::packed_direction.
  uint32_t packed(float distance) const {
    float radius2 = largest2_;
    uint32_t step = 0;
    for (; step < kMask && 0.5f * radius2 >= kRadii * kRadii * distance * distance; ++step) radius2 *= 0.5f;
    return step << kShift;
  }
  /// Squared radius; infinite if a photon has no kernel of its own.
  float radius2(uint32_t packed) const {
    const uint32_t step = packed >> kShift & kMask;
    return step == 0 ? kInfinity : largest2_ / float(1u << step);
  }

 private:
  static constexpr uint32_t kShift = 26, kMask = 15;
  static constexpr float kRadii = 4.0f;  // in distances that the light has come
  float largest2_ = kInfinity;
};

/// The largest radius at the ends of gather rays, relative to the scene, if about one photon is within it. It limits the
/// bias where there are few photons.
constexpr float kLargestGatherRadius = 0.0125f;
/// The kernels of the photons of a scene.
inline PhotonKernels photon_kernels(const Scene& scene) { return PhotonKernels(kLargestGatherRadius * scene.radius()); }

/// Whether rough lobes of a surface can transmit light from one side to the other.
bool transmits(const Bsdf& bsdf);
/// SurfacePoint::kFront or kBack: the side of the face at `point` that `normal` is on.
inline uint32_t side_of(const ShadingPoint& point, Vec3 normal) {
  return (glm::dot(normal, point.ng) < 0.0f) == point.backfacing ? SurfacePoint::kFront : SurfacePoint::kBack;
}
inline SurfacePoint surface_point(const ShadingPoint& point, Vec3 normal) {
  return {point.position, pack_direction(normal) | side_of(point, normal)};
}

/// From where lookups see a photon on a surface with these lobes.
struct SeenFrom {
  Vec3 normal;     ///< of SurfacePoint
  uint32_t flags;  ///< Photon::kTransmits or 0
};
/// `ng`: on the side of the light.
SeenFrom seen_from(const Bsdf& rough, Vec3 ng);

/// Whether the walk from the eye finds the light that the sharp lobes of a surface scatter to it, so that it is not in
/// the caustic map. A smooth normal is bent towards an eye at a grazing angle, to which a photon can hardly be reflected:
/// without the bend, its lobes point elsewhere. This is for lobes that direct light can be sampled for, and for
/// reflection alone.
bool seen_by_bent_lobes(const ShadingPoint& point, const Bsdf& sharp, Vec3 to_eye);

/// The radius of a pixel of the camera at a place that it sees directly.
struct PixelRadius {
  Vec3 eye{0.0f};
  float at_distance_1 = 0.0f;
  bool same_everywhere = false;  ///< orthographic cameras

  float at(Vec3 p) const { return same_everywhere ? at_distance_1 : at_distance_1 * glm::length(p - eye); }
};

class PhotonMap {
 public:
  /// Which photons an estimate uses: those within the radius of a pixel, but at least the nearest `enough`, at most the
  /// nearest `neighbours`, and all of them within `radius`. Each of these disc radii is a stopping time of the number of
  /// photons around the point, so that the estimate of an even density has no bias if the photon on the edge of the disc
  /// does not count.
  struct Lookup {
    int neighbours = 1;
    float radius = 0.0f;
    int enough = 0;  ///< 0: all photons within `radius`; 1: those within the radius of a pixel only
    PixelRadius pixel = {};
    BounceCounts bounces = {};  ///< of the eye's side of the path, without the scattering at the point of the lookup
  };

  /// `order[i]` becomes the index in `photons` of photon i of the map.
  void build(std::vector<Photon> photons, std::vector<uint32_t>& order);
  void build(std::vector<Photon> photons) {
    std::vector<uint32_t> order;
    build(std::move(photons), order);
  }
  /// From now on and until the next build, distribute the flux of each photon over the surface that exists within the
  /// radius of `lookup` and is not behind walls.
  void look_around(const Scene& scene, const Lookup& lookup, float time, uint32_t seed) {
    around_ = lookup;
    discs_.start(scene, size(), lookup.radius, time, seed);
  }
  /// A photon of the map, and the factor of its light in lookups.
  class Weighable {
   public:
    const SurfacePoint& point() const { return map_.tree_[photon_]; }
    bool has(uint32_t flag) const { return map_.lights_[photon_].packed_direction & flag; }
    /// Whether photons of chains do not bring this light: PhotonBounces::past_ray_kinds, or not scatters_evenly.
    bool is_plain_alone() const { return map_.lights_[photon_].over_cosine.left().is_marked(); }
    /// For a lookup at `position`, at this squared distance, with the squared radius `radius2`. 0 if the lookup does not
    /// find the photon's light, else 1 or more (`inverse_share_of`).
    float in_lookup(Vec3 position, float distance2, float radius2) const {
      return map_.inverse_share(photon_, distance2, radius2, position);
    }

   private:
    friend class PhotonMap;
    Weighable(const PhotonMap& map, uint32_t photon) : map_(map), photon_(photon) {}
    const PhotonMap& map_;
    uint32_t photon_;
  };
  /// Multiplies the flux of each photon by factor(Weighable), in parallel. After look_around and use.
  template <class Factor>
  void weigh(Factor&& factor) {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, size(), 256), [&](const tbb::blocked_range<size_t>& range) {
      for (size_t i = range.begin(); i != range.end(); ++i) {
        FluxWithBounces& light = lights_[i].over_cosine;
        light = {light.flux() * float(factor(Weighable(*this, uint32_t(i)))), light.left()};
      }
    });
  }
  /// From now on, photons have these kernels; by default, they have none.
  void use(PhotonKernels kernels) { kernels_ = kernels; }
  size_t size() const { return tree_.size(); }
  bool empty() const { return tree_.empty(); }
  size_t memory_bytes() const { return size() * sizeof(Photon) + discs_.memory_bytes(); }

  /// Radiance that `bsdf` scatters from the photons around `point` towards point.wo. Lobes that transmit also see the
  /// photons behind the surface.
  Color radiance(const ShadingPoint& point, const Bsdf& bsdf, const Lookup& lookup) const {
    return radiance(point, bsdf, lookup, [](uint32_t, Vec3) { return 1.0f; });
  }
  /// The same, with the factor `weight(i, direction)` for photon `i` from `direction`.
  template <class Weight>
  Color radiance(const ShadingPoint& point, const Bsdf& bsdf, const Lookup& lookup, Weight&& weight) const {
    return scattered(point, bsdf, lookup, [&](uint32_t photon, Vec3 direction) {
      return bsdf.evaluate(point.wo, direction).f_cos * weight(photon, direction);
    });
  }
  /// The radiance by each kind of lobe (Bsdf::f_cos_of_kinds).
  std::array<Color, 3> radiance_of_kinds(const ShadingPoint& point, const Bsdf& bsdf, const Lookup& lookup) const {
    std::array<Color, 3> sums{};
    for (size_t k = 0; k < 3; ++k)
      sums[k] = scattered(point, bsdf, lookup,
                          [&](uint32_t, Vec3 direction) { return bsdf.f_cos_of_kinds(point.wo, direction)[k]; });
    return sums;
  }
  /// Irradiance on the side of `ng`, with the cosine at `ns`, for a surface that scatters diffusely. `limit`: null, or it
  /// receives for which lookups it is.
  struct BouncesOfIrradiance {
    PackedBounces left;  ///< the least that one of the photons leaves
    bool all = true;     ///< no photon was left out because of its bounces
  };
  Color irradiance(Vec3 position, Vec3 ng, Vec3 ns, const Lookup& lookup, BouncesOfIrradiance* limit = nullptr) const;
  /// Distance from `point` to the k-th photon; `max_distance` if there are fewer photons within that distance.
  float reach(const SurfacePoint& point, int k, float max_distance) const;
  /// Adds every `stride`-th photon that has these flags, for display.
  void add_to(PhotonPoints& points, uint64_t stride, uint32_t flags = 0) const;
  size_t count(uint32_t flags) const;

 private:
  struct Light {
    FluxWithBounces over_cosine;
    uint32_t packed_direction;
  };
  static_assert(sizeof(Light) == 16);
  /// The sum over the photons around a point of f_cos(photon, its direction) times the flux, over the area.
  template <class Scattering>
  Color scattered(const ShadingPoint& point, const Bsdf& bsdf, const Lookup& lookup, Scattering&& f_cos) const {
    if (empty()) return Color(0.0f);
    PointTree::Neighbours found;
    Color radiance(0.0f);
    const PackedBounces most = with_all_kinds(lookup.bounces);
    const int sides = transmits(bsdf) ? 2 : 1;
    for (int side = 0; side < sides; ++side) {
      const Vec3 normal = side == 0 ? point.ng : -point.ng;
      find(point.position, normal, lookup, found, sides == 2 ? SurfacePoint::kSides & ~side_of(point, normal) : 0u);
      Color sum(0.0f);
      for (int i = 0; i < found.count; ++i) {
        const Light& light = lights_[found.index[i]];
        const float inverse_share = inverse_share_of(found, i, point.position);
        if (!(inverse_share > 0.0f)) continue;
        const Vec3 direction = unpack_direction_short(light.packed_direction);
        const PackedBounces left = light.over_cosine.left();
        float share = 1.0f;
        if (!most.within(left)) [[unlikely]] {
          share = share_within(left, lookup.bounces, bsdf, point.wo, direction);
          if (!(share > 0.0f)) continue;
        }
        sum += f_cos(found.index[i], direction) * light.over_cosine.flux() * (inverse_share * share);
      }
      if (found.count > 0) radiance += sum / (kPi * found.radius2);
    }
    return radiance;
  }
  /// The counts after a scattering of any kind.
  static PackedBounces with_all_kinds(BounceCounts counts) {
    ++counts.diffuse, ++counts.glossy, ++counts.transmission;
    return PackedBounces(counts);
  }
  /// The probability that path tracing would sample, for this scattering, a lobe of a kind that the limits allow.
  static float share_within(PackedBounces left, const BounceCounts& before, const Bsdf& bsdf, Vec3 to_eye,
                            Vec3 to_light);
  /// Squared radius of an estimate like those of look_around at a photon.
  float radius2_at(const SurfacePoint& point) const;
  void find(Vec3 position, Vec3 normal, const Lookup& lookup, PointTree::Neighbours& found,
            uint32_t not_side = 0) const;
  /// Area of the disc of the lookup over the area that receives the light of the photon number i that it has found; 0 if
  /// `position` is outside that area.
  float inverse_share_of(const PointTree::Neighbours& found, int i, Vec3 position) const {
    return inverse_share(found.index[i], found.distance2[i], found.radius2, position);
  }
  float inverse_share(uint32_t photon, float distance2, float radius2, Vec3 position) const {
    const float kernel2 = kernels_.radius2(lights_[photon].packed_direction);
    float share = 1.0f;
    if (kernel2 < radius2) {
      if (distance2 >= kernel2) return 0.0f;
      share = radius2 / kernel2;
    }
    if (!discs_.started()) return share;
    return share * discs_.inverse_share(photon, tree_[photon], position, std::min(radius2, kernel2),
                                        [&] { return std::sqrt(std::min(radius2_at(tree_[photon]), kernel2)); });
  }

  PointTree tree_;
  PhotonDiscs discs_;
  Lookup around_;  ///< of look_around
  PhotonKernels kernels_;
  std::vector<Light> lights_;
};

/// A point at which irradiance is computed once for many gather rays. Sites are on plain Lambertian surfaces.
struct IrradianceSite {
  SurfacePoint point;
  Vec3 shading_normal;
};

/// Irradiance precomputed at sites [Christensen 1999], for lookups after a diffuse bounce. Sites must not depend on the
/// photons of the map that fills them: an estimate at the position of a photon counts this photon too, and is too high
/// by 1/k. A site takes 36 bytes.
class IrradianceMap {
 public:
  void build(const std::vector<IrradianceSite>& sites, const PhotonMap& photons, const PhotonMap::Lookup& lookup);
  size_t size() const { return tree_.size(); }
  size_t memory_bytes() const { return size() * (sizeof(SurfacePoint) + sizeof(Entry)); }
  /// Irradiance of the nearest site within `radius`, for a path with these bounces on the eye's side; false when there
  /// is none, or when it has light that the bounce limits exclude, or may lack light that they allow.
  bool find(Vec3 position, Vec3 ng, float radius, BounceCounts bounces, Color& irradiance) const {
    const int site = tree_.nearest(position, ng, radius);
    if (site < 0) return false;
    const Entry& entry = entries_[size_t(site)];
    if (!entry.complete && bounces.diffuse < kAfter.diffuse) return false;
    ++bounces.diffuse;
    if (!PackedBounces(bounces).within(entry.left)) return false;
    irradiance = entry.irradiance;
    return true;
  }

 private:
  static constexpr BounceCounts kAfter{.total = 1, .diffuse = 1};
  struct Entry {
    Color irradiance;
    PackedBounces left;
    bool complete;  ///< also for lookups with fewer bounces than kAfter
  };
  PointTree tree_;
  std::vector<Entry> entries_;
};

/// Squared radius of pass i (from 0), relative to that of the first pass: r^2_{i+1} / r^2_i = (i + alpha) / (i + 1) for
/// i from 1, with alpha = 2/3 [Knaus and Zwicker 2011, eq. 16]. The bias then decreases as passes^(-1/3), and the
/// variance of density estimates as passes^(-2/3).
double radius2_factor(uint32_t pass);

}  // namespace ajar
