// The mixture by which direct light is sampled. Its components are the lobes of the BSDF, a cone, any light, and groups
// of lights [Fan 2006, sections 2.4.4 and 5.4]. Estimators with several samples per vertex differ in the choice of its
// shares and in the use of its samples.
//
// A sample is a light together with a direction. So the density K of the mixture at (light l, direction wi) needs only
// that light:
//   K = sum_i a_i p_i(wi) + a_cone p_cone(wi) + (a_any pmf(l) + a_g pmf(l | g)) p_l(wi),
//       where i are the lobes and g is the group of l.
// Lobes and the cone sample directions; such a sample counts for every light along the direction. Delta lights need no
// special case, because their first two terms are zero. The same holds for lights that only sampling can find. The
// numbers of samples of the components are deterministic (sampling/mixture.h).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "sampling/mixture.h"
#include "transport/direct/direct_light.h"
#include "transport/direct/light_cut_cache.h"
#include "transport/direct/light_groups.h"
#include "transport/direct/lobe_components.h"

namespace ajar {

/// First dimension of the sampler for estimates with several samples. Each stream of samples has `kStreamStride`
/// dimensions.
constexpr uint32_t kBranchDimension = 4096, kStreamStride = 64;

/// The value of a sample in everything that is learned from it.
inline float luminance_of(Color c) { return std::max(0.0f, luminance(c)); }

class LightMixture {
 public:
  static constexpr int kMaxGroups = 5, kMaxMixtureLobes = LobeComponents::kMax;
  /// The indices of the components. Lobes come first.
  static constexpr int kCone = kMaxMixtureLobes, kAny = kCone + 1, kFirstGroup = kAny + 1,
                       kMaxComponents = kFirstGroup + kMaxGroups;

  /// The shares of one estimate, and its cone.
  struct Kernel {
    const LobeComponents& lobes;
    int count = 0;
    uint32_t cell = LightCutCache::kNone;  ///< cell whose shares choose any light
    std::array<float, kMaxComponents> alpha;
    Frame cone;
    float one_minus_cos = 0.0f;
    /// The sum of the shares of all lobes.
    float bsdf_share() const {
      float sum = alpha[0];
      for (int i = 1; i < lobes.count(); ++i) sum += alpha[size_t(i)];
      return sum;
    }
  };
  /// One sample of the mixture: its weight y = f / K and the responsibility of each component for it.
  struct Draw {
    Color y{0.0f};
    Vec3 wi{0.0f};  ///< zero: no direction, or a light that only sampling finds
    std::array<float, kMaxMixtureLobes> pdf_lobes{};
    LightCutCache::Choice choice{};                 ///< for samples of any light
    std::array<float, kMaxComponents> responsible;  ///< luminance of y times rho_k
  };
  /// The input that all samples of one estimate share.
  struct Estimate {
    const DirectLightContext& c;
    const Kernel& k;
    uint64_t& rays;
    bool power = false;  ///< weights of the power heuristic between BSDF and lights; otherwise f / K
  };
  explicit LightMixture(const Scene& scene, LightGroups groups = {}) : scene_(scene), groups_(std::move(groups)) {}

  const LightGroups& groups() const { return groups_; }
  /// Sets the learned choices of any light. Null: those of the light tree. They must outlive the mixture.
  void set_choices(const LightCutCache* cuts) { cuts_ = cuts; }

  /// The components that share the rest after the lobes: any light, or the groups, equally or by their priors.
  enum class Lights : uint8_t { Any, GroupsAlike, GroupsByPrior };
  /// A kernel whose lobes have the total share `bsdf_share`, divided in proportion to their priors.
  Kernel kernel(const LobeComponents& lobes, float bsdf_share, Lights lights) const;

  LightCutCache::Choice choose_light(uint32_t cell, const DirectLightContext& c, float u) const;
  /// The probability of a light by the shares of a cell.
  float choice_pmf(uint32_t cell, Vec3 position, Vec3 normal, uint32_t light) const;

  /// Draws n samples with deterministic shares and calls visit(component, draw).
  template <class Visit>
  void for_each_draw(const Estimate& estimate, int n, int stream, Sampler& sampler, Visit&& visit) const;

  /// Writes the shares to the debug passes.
  void record_shares(const Kernel& k, SampleAux* aux) const;

 private:
  struct Densities {
    std::array<float, kMaxMixtureLobes> lobes;  ///< densities are multiplied by the shares
    float bsdf, cone, any, group;               ///< bsdf: all lobes together
    int group_index;
    float total() const { return bsdf + cone + any + group; }
  };

  /// A light together with a direction.
  struct LightDirection {
    uint32_t light;
    Vec3 wi;
    float pdf_light;          ///< with which the light is sampled in this direction, once it is chosen
    bool mis;                 ///< lobes and the cone can find it
    float known_pmf = -1.0f;  ///< of its choice as any light; negative: not known
  };

  Densities densities(const DirectLightContext& c, const Kernel& k, const LightDirection& at,
                      const std::array<float, kMaxMixtureLobes>& pdf_lobes) const;
  void add_found(const Densities& d, Color f, bool power, bool from_bsdf, Draw& draw) const;
  void draw_light(const Estimate& estimate, int component, float u_choice, Vec2 u, Draw& out) const;
  void draw_direction(const Estimate& estimate, int component, float u_choice, Vec2 u, Draw& out) const;

  const Scene& scene_;
  LightGroups groups_;
  const LightCutCache* cuts_ = nullptr;
};

template <class Visit>
void LightMixture::for_each_draw(const Estimate& estimate, int n, int stream, Sampler& sampler, Visit&& visit) const {
  const Kernel& k = estimate.k;
  int counts[kMaxComponents];
  const uint32_t base = kBranchDimension + kStreamStride * uint32_t(stream);
  sampler.set_dimension(base);
  deterministic_counts({k.alpha.data(), size_t(k.count)}, n, sampler.get_1d(), {counts, size_t(k.count)});
  Draw out;
  const bool few = scene_.lights().size() < kFewLights;
  for (int component = 0; component < k.count; ++component) {
    sampler.set_dimension(base + 1 + uint32_t(component));
    // Successive estimates of a pixel continue the sequence of each component.
    const uint32_t block = uint32_t(std::ceil(float(n) * k.alpha[size_t(component)] - 1e-4f));
    for (int i = 0; i < counts[component]; ++i) {
      Sampler numbers = sampler.branch(uint32_t(i), block);
      const Vec2 u = numbers.get_2d();
      const float u_choice = few && component == kAny ? u.x : numbers.get_1d();
      out.y = Color(0.0f);
      out.wi = Vec3(0.0f);
      out.pdf_lobes.fill(0.0f);
      out.choice.share = 0.0f;
      std::fill_n(out.responsible.begin(), k.count, 0.0f);
      if (component <= kCone) {
        draw_direction(estimate, component, u_choice, u, out);
      } else {
        draw_light(estimate, component, u_choice, u, out);
      }
      visit(component, out);
    }
  }
}

}  // namespace ajar
