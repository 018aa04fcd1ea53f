// The data of a LightSet, and the choice of a light by estimated irradiance. Only light_set*.cpp include it:
// light_set_build.cpp builds the data, light_set.cpp chooses lights, light_set_sampling.cpp samples the chosen light.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "lights/light_clusters.h"
#include "lights/light_set.h"
#include "lights/light_tree.h"
#include "lights/sources/environment.h"
#include "lights/sources/lamp.h"
#include "lights/sources/triangle_light.h"
#include "math/distribution.h"
#include "math/warps.h"

namespace ajar {

/// The distances at which emission that depends on the distance of the lit point is compared, as fractions of the radius
/// of the scene.
inline constexpr float kFar = 0.5f, kNear = kFar / 8.0f;
/// The power of the distance, 0 to 2, with which an emission grows from kNear to kFar.
inline int growth_between(double near, double far) {
  if (!(near > 0.0)) return far > 0.0 ? 2 : 0;
  return std::clamp(int(std::lround(std::log2(std::max(far / near, 1.0)) / 3.0)), 0, 2);
}
inline double luminous(Color c) { return luminance(glm::abs(c)); }

/// A lamp, an emissive instance or the environment, for the tables of choice.
struct LightSource {
  uint32_t light;         // the first of its lights
  uint32_t first, count;  // of its entries (light_clusters.h)
  double power;           // 0: may emit although the estimate found nothing
  double chosen = 1.0;    // fraction of the power that counts for the choice
  int growth = 0;         // power of the distance with which it grows; `power` is that at kFar
  int shared = -1;        // of a cluster: what it shares with other instances
};

/// The choice among some lights by estimated irradiance.
struct LightChooser {
  using Choice = LightSet::Choice;
  /// Minimum and maximum probability of all distant lights together if there are other lights: occlusion is not known.
  static constexpr float kMinDistant = 0.1f, kMaxDistant = 0.8f;
  /// The maximum if the estimate found no emission of any local light.
  static constexpr float kMaxBesideDark = 0.99f;
  /// Share of uniform choices in scenes with media that have few lights.
  static constexpr float kEvenShare = 0.5f;
  /// Minimum cosine at the receiver of a sun: shading normals differ from geometric ones.
  static constexpr float kMinSunCosine = 0.02f;

  /// A sun or the environment, for the choice.
  struct DistantLight {
    uint32_t light;
    float irradiance;          // on a surface that faces it; for the environment, of the radiance above its mean
    Vec3 direction;            // towards it; 0: all directions
    float cos_size, sin_size;  // of its disk
    float importance(Vec3 n) const {
      if (n == Vec3(0.0f) || direction == Vec3(0.0f)) return irradiance;
      const float cosine = glm::dot(n, direction), sine = safe_sqrt(1.0f - cosine * cosine);
      return irradiance * (cosine >= cos_size ? 1.0f : std::max(cosine * cos_size + sine * sin_size, kMinSunCosine));
    }
  };

  LightTree tree;                           // of the entries of local lights
  const LightClusters* clusters = nullptr;  // null: each light is an entry
  float max_distant = kMaxDistant;
  std::vector<DistantLight> distant;
  // lights with an additional uniform probability; empty without media or with many lights
  std::vector<uint32_t> even;

  bool can_choose(uint32_t index) const {
    return contains(index) ||
           std::any_of(distant.begin(), distant.end(), [&](const DistantLight& l) { return l.light == index; });
  }
  bool contains(uint32_t light) const { return tree.contains(clusters ? clusters->entry_of(light) : light); }
  uint32_t leaf_of(uint32_t light) const { return tree.leaf_of(clusters ? clusters->entry_of(light) : light); }
  // The receiver of light is a point p with its normal n, or a stretch, whose points receive light from all sides.
  static Vec3 normal_of(const Vec3&, const Vec3& n) { return n; }
  static Vec3 normal_of(const LightStretch&) { return Vec3(0.0f); }

  /// The choice of a light below a node of the tree.
  [[gnu::always_inline]] Choice choose_below(uint32_t node, Vec3 p, Vec3 n, float u) const {
    return inside(tree.choose_below(node, p, n, u), p, n);
  }
  float pmf_below(uint32_t node, Vec3 p, Vec3 n, uint32_t light) const {
    if (!clusters) [[likely]]
      return tree.pmf_below(node, p, n, light);
    const float entry = tree.pmf_below(node, p, n, clusters->entry_of(light));
    return entry > 0.0f ? entry * clusters->pmf(light, p, n) : 0.0f;
  }
  /// The same for the whole tree.
  [[gnu::always_inline]] Choice choose_local(float u, const Vec3& p, const Vec3& n) const {
    return choose_below(0, p, n, u);
  }
  Choice choose_local(float u, const LightStretch& stretch) const { return inside(tree.choose(stretch, u), stretch); }
  float pmf_local(uint32_t light, const Vec3& p, const Vec3& n) const { return pmf_below(0, p, n, light); }
  float pmf_local(uint32_t light, const LightStretch& stretch) const {
    if (!clusters) return tree.pmf(stretch, light);
    const float entry = tree.pmf(stretch, clusters->entry_of(light));
    return entry > 0.0f ? entry * clusters->pmf(light, stretch) : 0.0f;
  }
  /// Sum of the importances of distant lights.
  float distant_importance(Vec3 n) const {
    float sum = 0.0f;
    for (const DistantLight& l : distant) sum += l.importance(n);
    return sum;
  }
  /// Share of the distant lights in the choice for a receiver.
  template <class... Receiver>
  float distant_share(float importance_of_distant, const Receiver&... receiver) const {
    if (distant.empty()) return 0.0f;
    const float near = tree.importance(receiver...);
    if (!(near > 0.0f)) return 1.0f;
    return std::clamp(importance_of_distant / (importance_of_distant + near), kMinDistant, max_distant);
  }
  Choice choose_distant(Vec3 n, float u) const {
    const float sum = distant_importance(n);
    const DistantLight* chosen = &distant.back();
    float pmf = 1.0f;
    for (const DistantLight& l : distant) {
      pmf = l.importance(n) / sum;
      if (u < pmf || &l == chosen) {
        chosen = &l;
        break;
      }
      u -= pmf;
    }
    return {chosen->light, pmf, std::min(u / pmf, kOneMinusEpsilon)};
  }
  template <class... Receiver>
  [[gnu::always_inline]] Choice choose_by_estimate(float u, const Receiver&... receiver) const {
    float share = 0.0f;
    if (!distant.empty()) {
      const Vec3 n = normal_of(receiver...);
      const float sum = distant_importance(n);
      share = distant_share(sum, receiver...);
      if (u < share) {
        Choice choice = choose_distant(n, std::min(u / share, kOneMinusEpsilon));
        choice.pmf *= share;
        return choice;
      }
      u = std::min((u - share) / (1.0f - share), kOneMinusEpsilon);
    }
    if (tree.empty()) return {0, 0.0f, u};
    Choice choice = choose_local(u, receiver...);
    choice.pmf *= 1.0f - share;
    return choice;
  }
  template <class... Receiver>
  float pmf_by_estimate(uint32_t light, const Receiver&... receiver) const {
    if (distant.empty()) return pmf_local(light, receiver...);
    const Vec3 n = normal_of(receiver...);
    const float sum = distant_importance(n), share = distant_share(sum, receiver...);
    for (const DistantLight& l : distant)
      if (l.light == light) return share * (l.importance(n) / sum);
    return (1.0f - share) * pmf_local(light, receiver...);
  }
  /// The same with the uniform probability of `even`.
  template <class... Receiver>
  [[gnu::always_inline]] Choice choose(float u, const Receiver&... receiver) const {
    if (even.empty()) return choose_by_estimate(u, receiver...);
    if (u < kEvenShare) {
      const float place = u / kEvenShare * float(even.size());
      const size_t i = std::min(size_t(place), even.size() - 1);
      return {even[i], pmf(even[i], receiver...), std::min(place - float(i), kOneMinusEpsilon)};
    }
    Choice choice = choose_by_estimate(std::min((u - kEvenShare) / (1.0f - kEvenShare), kOneMinusEpsilon), receiver...);
    if (choice.pmf > 0.0f) choice.pmf = kEvenShare / float(even.size()) + (1.0f - kEvenShare) * choice.pmf;
    return choice;
  }
  template <class... Receiver>
  float pmf(uint32_t light, const Receiver&... receiver) const {
    const float estimated = pmf_by_estimate(light, receiver...);
    if (even.empty()) return estimated;
    const bool is_even = std::find(even.begin(), even.end(), light) != even.end();
    return (is_even ? kEvenShare / float(even.size()) : 0.0f) + (1.0f - kEvenShare) * estimated;
  }

 private:
  /// The light of a chosen entry of the tree.
  template <class... Receiver>
  [[gnu::always_inline]] Choice inside(const LightTree::Choice& entry, const Receiver&... receiver) const {
    if (clusters && entry.pmf > 0.0f) [[unlikely]] {
      const LightClusters::Choice chosen = clusters->choose(entry.light, receiver..., entry.u_remapped);
      return {chosen.light, entry.pmf * chosen.pmf, chosen.u_remapped};
    }
    return {entry.light, entry.pmf, entry.u_remapped};
  }
};

struct LightSet::Data {
  struct SlotEmission {
    const ShaderProgram* program = nullptr;  // null: no emission
    bool constant = true;
    Color radiance{0.0f};  // if constant
  };

  /// All triangles of one emissive instance: lights first .. first + count - 1.
  struct TriangleBlock {
    uint32_t instance = 0, first = 0, count = 0;
    std::vector<SlotEmission> slots;
    uint64_t receivers = kAllReceivers;  // see LightFlags
    uint32_t blockers = kVisibleShadow;
  };

  using Source = LightSource;
  struct Pending;

  const ObjectDescription* objects = nullptr;
  const BuiltMesh* meshes = nullptr;
  const BuiltInstance* instances = nullptr;
  const ShaderProgram* lamp_programs = nullptr;
  std::vector<Light> lamps;
  std::vector<TriangleBlock> blocks;  // by `first`
  Environment environment;
  uint32_t environment_visibility = 0;
  int environment_bounces = 1024;
  bool any_partial = false, any_without_walks = false, took_environment_over = false;
  int environment_index = -1;
  std::vector<uint32_t> distant_disks;
  Vec3 scene_center{0.0f};
  float scene_radius = 1.0f;
  LightClusters clusters;
  DiscreteDistribution by_power;     // of the entries
  LightChooser all;                  // of all lights
  std::vector<LightChooser> linked;  // of the lights of some receiver sets
  std::vector<uint8_t> linked_of;  // for each receiver set, index into `linked`; empty if all lights light all objects
  bool any_linked = false, any_limited = false;
  uint32_t size = 0;

  const TriangleBlock& block_of(uint32_t index) const {
    return *(std::upper_bound(blocks.begin(), blocks.end(), index,
                              [](uint32_t i, const TriangleBlock& b) { return i < b.first; }) -
             1);
  }
  const SlotEmission& emission_of(const TriangleBlock& block, uint32_t primitive) const {
    const BuiltMesh& mesh = meshes[instances[block.instance].mesh];
    const size_t slot = mesh.material_slots.empty() ? 0 : mesh.material_slots[primitive];
    return block.slots[std::min(slot, block.slots.size() - 1)];  // removed slots use the last one
  }
  const LightChooser& chooser(uint32_t receiver_set) const {
    return receiver_set < linked_of.size() ? linked[linked_of[receiver_set]] : all;
  }
  bool is_lamp(uint32_t index) const { return index < lamps.size(); }
  bool is_environment(uint32_t index) const { return int(index) == environment_index; }

  double mean_factor(const Light& lamp, float distance) const;
  static void find_clusters(const LightBuildInput& in, std::vector<Pending>& blocks);
  std::vector<Pending> gather_blocks(const LightBuildInput& in, Diagnostics& diagnostics) const;
  void find_luminances(const LightBuildInput& in, std::vector<Pending>& blocks) const;
  void rate(const LightBuildInput& in, std::vector<Pending>& blocks);
  void rate_triangles(const LightBuildInput& in, const BuiltInstance& instance, Pending& pending) const;
  int growth_of(const TriangleBlock& block, const LightBuildInput& in) const;
  void add_lamps(const LightBuildInput& in, Diagnostics& diagnostics, std::vector<Source>& sources);
  void add_triangles(const LightBuildInput& in, Diagnostics& diagnostics, std::vector<Source>& sources,
                     std::vector<double>& weights);
  void add_environment(const LightBuildInput& in, Diagnostics& diagnostics, std::vector<Source>& sources,
                       std::vector<double>& weights);
  void make_tables(const std::vector<Source>& sources, const std::vector<double>& inside, bool has_media);
  LightChooser make_chooser(const std::vector<Source>& sources, const std::vector<double>& watts, bool has_media) const;
  uint64_t receivers_of(uint32_t index) const {
    if (is_environment(index)) return kAllReceivers;
    return is_lamp(index) ? lamps[index].receivers : block_of(index).receivers;
  }

  Color lamp_radiance(const Light& light, Vec3 position, Vec3 wo, float time, float distance, uint32_t ray_kind) const {
    // Of a point lamp or a soft one, the profile is the same inside and outside.
    const bool all_of_it = light.even_spot && light.type == LightType::SpotSphere && !light.soft &&
                           length_squared(position + distance * wo - light.position) < sqr(light.radius);
    const Color radiance = all_of_it ? light.radiance : light.radiance * lamp_profile(light, wo);
    return light.shader < 0 || is_black(radiance)
               ? radiance
               : radiance * shader_factor(light, position, wo, time, distance, ray_kind);
  }
  std::optional<LightSample> sample_lamp(const Light& lamp, Vec3 p, Vec2 u, float time, uint32_t ray_kind) const {
    std::optional<LightSample> sample = sample_lamp_li(lamp, p, u);
    if (sample) {
      sample->position_error = lamp_position_error(sample->position);
      sample->blockers = lamp.blockers;
    }
    if (sample && lamp.shader >= 0)
      sample->radiance *= shader_factor(lamp, sample->position, -sample->wi, time, sample->distance, ray_kind);
    return sample;
  }
  Color shader_factor(const Light& light, Vec3 position, Vec3 wo, float time, float distance, uint32_t ray_kind) const {
    ShadingPoint point;
    // The inputs that nodes of lamps have in Cycles: the position of a sun is the direction of its light, and the
    // normal of all lamps but area lamps is that direction.
    point.position = is_distant(light.type) ? wo : position;
    point.wo = wo;
    point.ng = point.ns = light.type == LightType::Rectangle || light.type == LightType::Ellipse ? light.frame.n : wo;
    point.time = time;
    point.ray_kind = ray_kind;
    point.ray_length = is_distant(light.type) ? kInfinity : distance;
    return lamp_programs[light.shader].evaluate_emission(point);
  }
};

}  // namespace ajar
