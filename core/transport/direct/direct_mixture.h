// Direct light as one integral sampled by a mixture: of the lobes of the BSDF, a cone, any light, and groups of lights. All methods but the
// default are estimators over this mixture (thesis, sections 5.4 and 6; algorithms.md, 3).
//
// A sample is a light together with a direction, so that the density K of the mixture at (light l, direction wi) needs
// nothing but that light:
//   K = sum_i a_i p_i(wi) + a_cone p_cone(wi) + (a_any pmf(l) + a_g pmf(l | g)) p_l(wi),    i the lobes, g the group of l
// Lobes and the cone draw directions and count for every light seen along them. Delta lights fit in without exception (the
// first two terms are zero for them); so do lights that only sampling can find.
//
// Which components there are. Lobes: up to three for `pmc_hi`, `pmc_hi_paper` and the `ocv` methods, where a surface has lobes that differ
// (lobe_components.h); else the BSDF is one. Any light, by the branches of the light tree that `pmc_hi` has learned to choose here.
// Groups of lights, for methods that adapt or correct within an estimate; the environment is a light, and in a group of its own where
// groups suffice. The cone around what was found, for `pmc_hi_paper` alone; lobes of von Mises and Fisher guide paths (path_guide.h), not this.
//
// One sample a vertex (`direct_samples` 1, and always after the first surface): a light sample now, and the
// path's own BSDF sample later, weighted by the power heuristic. PMC-HI learns which lights to choose, per place (light_cut_cache.h).
// More samples: N of the mixture with deterministic shares, lobes included; the path's BSDF sample then finds no more light.
// `pmc_hi` learns these shares per place, too (share_cache.h).
// Unbiased but for `ocv_paper`. Prefer `pmc_hi` where lights differ in use from place to place (occlusion, many lights).
#pragma once

#include <array>
#include <memory>
#include <string>

#include "sampling/control_variates.h"
#include "transport/direct/direct_light.h"
#include "transport/direct/light_cut_cache.h"
#include "transport/direct/light_groups.h"
#include "transport/direct/lobe_components.h"
#include "transport/direct/share_cache.h"

namespace ajar {

class DirectMixture {
 public:
  enum class Lobes : uint8_t { Apart, Together };
  /// `samples` of an estimate at what the eye sees, and after up to `deepest` bounces; one elsewhere. Lobes together, as one component, are for comparison.
  DirectMixture(const Scene& scene, DirectMethod method, int samples, int deepest = 0, Lobes lobes = Lobes::Apart);
  ~DirectMixture();

  Color estimate(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex& vertex, SampleAux* aux, uint64_t& rays) const;
  float weight_of_hit(const Scene& scene, const DirectVertex& v, uint32_t light, Vec3 wi, Vec3 position, Vec3 normal) const;
  /// Everything rendered so far becomes the past.
  void learn();
  /// What another frame may go on from; null where nothing is learned that belongs to places of the scene. Not to be used while it lasts.
  struct Past {
    std::shared_ptr<const LightCutCache> cuts;
    ShareCache many;
    uint64_t lights;                                  ///< their fingerprint
  };
  std::shared_ptr<const Past> past() const;
  /// Before the first sample. Returns why not, as a clause; empty when it is used.
  std::string begin_with(const Past& past);
  /// During the render, whenever `learn` is called.
  bool learns() const { return method_ == DirectMethod::OcvProgressive; }
  /// Before it, from samples of its own; `learn` ends each iteration of them.
  bool wants_pilot() const { return cuts_ && cuts_->learning(); }

 private:
  static constexpr int kMostGroups = 5, kMostLobes = LobeComponents::kMost;
  /// Lobes come first.
  static constexpr int kCone = kMostLobes, kAny = kCone + 1, kFirstGroup = kAny + 1, kMostComponents = kFirstGroup + kMostGroups;

  /// Shares of one estimate and its cone.
  struct Kernel {
    const LobeComponents& lobes;
    int count = 0;
    uint32_t cell = LightCutCache::kNone;             ///< by which any light is chosen
    std::array<float, kMostComponents> alpha;
    Frame cone;
    float one_minus_cos = 0.0f;
    /// Of all lobes together.
    float bsdf_share() const {
      float sum = alpha[0];
      for (int i = 1; i < lobes.count(); ++i) sum += alpha[size_t(i)];
      return sum;
    }
  };
  /// One sample of the mixture: its weight y = f / K and, where asked for, how much each component is responsible for.
  struct Draw {
    Color y{0.0f};
    Vec3 wi{0.0f};                                    ///< zero: no direction, or a light that only sampling finds
    std::array<float, kMostLobes> pdf_lobes{};
    LightCutCache::Choice choice{};                   ///< of any light
    std::array<float, kMostComponents> responsible;   ///< luminance of y times rho_k
  };
  struct Densities {
    std::array<float, kMostLobes> lobes;   ///< these and the others times their shares
    float bsdf, cone, any, group;          ///< bsdf: all lobes
    int group_index;
    float total() const { return bsdf + cone + any + group; }
  };

  Densities densities(const DirectLightContext& c, const Kernel& k, uint32_t light, Vec3 wi, const std::array<float, kMostLobes>& pdf_lobes, float pdf_light,
                      bool mis, float known_pmf = -1.0f) const;
  void add_found(const Densities& d, Color f, bool power, bool from_bsdf, Draw& draw) const;
  void draw_light(const DirectLightContext& c, const Kernel& k, int component, float u_choice, Vec2 u, bool power, Draw& out, uint64_t& rays) const;
  void draw_direction(const DirectLightContext& c, const Kernel& k, int component, float u_choice, Vec2 u, bool power, Draw& out, uint64_t& rays) const;
  template <class Visit>
  void for_each_draw(const DirectLightContext& c, const Kernel& k, int n, int stream, Sampler& sampler, bool power, uint64_t& rays, Visit&& visit) const;

  Color one_sample(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex& vertex, uint64_t& rays) const;
  Color one_sample_ris(const DirectLightContext& c, Sampler& sampler, uint32_t first, uint64_t& rays) const;
  Color many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux, uint64_t& rays) const;
  Color adapt_here(const DirectLightContext& c, const LobeComponents& lobes, Sampler& sampler, SampleAux* aux, uint64_t& rays) const;
  Color control_variates(const DirectLightContext& c, const LobeComponents& lobes, Sampler& sampler, SampleAux* aux, uint64_t& rays) const;
  Color unreachable_lights(const DirectLightContext& c, Sampler& sampler, uint64_t& rays) const;
  int lobe_columns(const Kernel& k) const;
  void control_sample(const DirectLightContext& c, const Kernel& k, int component, const Draw& draw, ControlSample& sample) const;

  Kernel fixed_kernel(const LobeComponents& lobes) const;
  Kernel learned_kernel(const LobeComponents& lobes, uint32_t cell) const;
  uint64_t cell_key(const DirectLightContext& c) const;
  LightCutCache::Choice choose_light(uint32_t cell, const DirectLightContext& c, float u) const;
  Color weigh_sample(const DirectLightContext& c, const LightSet::Choice& chosen, LightFlags light, const LightSample& sample, uint64_t& rays) const;
  float choice_pmf(uint32_t cell, Vec3 position, Vec3 normal, uint32_t light) const;
  void record_light_shares(const DirectLightContext& c, uint32_t cell, float share, SampleAux* aux) const;
  void record_shares(const Kernel& k, SampleAux* aux) const;

  const Scene& scene_;
  DirectMethod method_;
  int samples_, deepest_;
  bool lobes_apart_;                ///< an estimate has a component for each of a surface's lobes
  LightGroups groups_;
  bool controls_possible_ = false;  ///< few enough lights to intersect them all
  std::shared_ptr<LightCutCache> cuts_;   ///< which lights to choose
  float angle_ = 0.0f, reach_ = 0.0f;     ///< of its cells, and how far what the camera sees is, on average
  /// What debug passes show the shares of: the only two lights, else ids of branches where each half of the light tree begins and where it ends.
  std::vector<uint32_t> shown_lights_, shown_branches_;
  ShareCache many_;                 ///< shares of lobes and lights among many samples of an estimate
  struct Regressions;
  std::unique_ptr<Regressions> regressions_;
};

}  // namespace ajar
