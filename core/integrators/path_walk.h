// One path of the path tracer from the camera to its end. The loop is compiled once for each combination of these
// template parameters:
//   DirectLight: MisDirectLight or DirectEstimator
//   Guide:       Unguided or Guided (transport/guiding/path_guide.h)
//   Medium:      NoMedia or InMedia
//   Parts:       NoParts, LightPasses, DirectPart or ImportantLight
// Code that a combination does not need is not compiled.
#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "transport/bidirectional/lens_light.h"
#include "transport/direct/direct_estimator.h"
#include "transport/direct/media_light.h"
#include "transport/direct/path_start.h"
#include "transport/guiding/path_guide.h"
#include "transport/media/path_in_media.h"
#include "transport/media/subsurface_walk.h"
#include "transport/paths/eye_walk.h"
#include "transport/paths/light_passes.h"
#include "transport/paths/record.h"

namespace ajar {

template <class DirectLight, class Guide, class Medium, class Parts>
class PathWalk {
  static constexpr bool kMedia = Medium::kThere, kGuided = Guide::kGuided;
  static constexpr bool kParts = std::is_same_v<Parts, LightPasses>, kSources = std::is_same_v<Parts, ImportantLight>,
                        kDirect = kParts || std::is_same_v<Parts, DirectPart>;
  using D = PathDimensions;
  enum class Step : uint8_t { End, Traced, GoOn };  ///< Traced: the walk has a new ray

 public:
  [[gnu::always_inline]] PathWalk(const DirectLight& direct_light, const Guide& guide, Medium medium, Parts& parts,
                                  const PathStart& start)
      : direct_light_(direct_light),
        guide_(guide),
        medium_(std::move(medium)),
        parts_(parts),
        scene_(start.scene),
        lights_(start.scene.lights()),
        settings_(start.scene.settings()),
        start_(start),
        sampler_(start.sampler),
        aux_(start.aux),
        walk_(start.scene, start.ray, start.counters.rays) {
    walk_.clear = settings_.transparent_film && settings_.transparent_glass;
  }

  /// Radiance along the path, and alpha of its sample.
  [[gnu::always_inline]] Color trace(float& alpha) {
    ++start_.counters.paths;
    while (step()) {
    }
    if constexpr (kGuided) guided_.end(guide_, radiance_);
    alpha = alpha_;
    return radiance_;
  }

 private:
  /// Continues from one surface to the next. Returns false at the end of the path.
  [[gnu::always_inline]] bool step() {
    walk_.trace();
    const auto meet = [&](const LightMet& met) { add_met(met); };
    walk_.meet_lamps(meet);
    if constexpr (kMedia) {
      const Step step = pass_media();
      if (step != Step::GoOn) return step == Step::Traced;
    }
    if (!walk_.found()) {
      walk_.meet_distant(meet);
      if (start_.caught && walk_.seen_directly()) [[unlikely]]
        if (!start_.caught->caught) start_.caught->sees_background = beta_;
      alpha_ += record_nothing(scene_, walk_, beta_, aux_);
      return false;
    }
    if (!walk_.arrive()) return false;
    material_ = scene_.material_index(walk_.hit);
    const ShaderProgram& program = scene_.programs()[size_t(material_)];
    if constexpr (kMedia) {
      if (program.only_encloses()) return cross_boundary();
    }
    if (start_.caught && (walk_.seen_directly() || walk_.clear)) [[unlikely]]
      meet_catcher();
    walk_.point.channel_weights = kMedia ? glm::abs(beta_) : beta_;
    if (!program.emits() && !survives_due_roulette()) return false;
    program.evaluate_surface(walk_.point, walk_.shading);
    return meet_surface() && survives_due_roulette() && enter_surface() && scatter();
  }

  // ---- Light that is found -------------------------------------------------------------------

  /// `bounces`: number of scattering events before. Clamping distinguishes direct and indirect light by it. Not
  /// inlined, so that no copy of the loop fuses this sum with the product before it: all copies give the same image.
  [[gnu::noinline]] void add(Color contribution, int bounces) {
    const float limit = bounces > 1 ? settings_.clamp_indirect : settings_.clamp_direct;
    if (limit > 0.0f) {
      const float sum = contribution.x + contribution.y + contribution.z;
      if (sum > 3.0f * limit) contribution *= 3.0f * limit / sum;
    }
    radiance_ += contribution;
    if constexpr (kGuided) guided_.note_light(luminance(contribution));
    if constexpr (kSources) parts_.luminance += parts_.of_source * luminance(contribution);
    if constexpr (kDirect) {
      const bool sampled = bounces > walk_.point.ray_depth;  // else the walk has hit the light
      const bool is_direct = !(rough_before_ || (sampled && rough_last_));
      if constexpr (kParts)
        parts_.add(passes_of(bounces, is_direct), contribution);
      else if (is_direct)
        parts_.direct_paths += contribution;
    }
  }

  /// Whose light is added next.
  [[gnu::always_inline]] void note_light(uint32_t light) {
    if constexpr (kSources) parts_.of_source = scene_.light_importance(light);
    if constexpr (kParts) group_ = parts_.shown(scene_.light_group(light));
  }
  [[gnu::always_inline]] void note_emission([[maybe_unused]] const ObjectDescription& object) {
    if constexpr (kSources) parts_.of_source = object.light_importance;
    if constexpr (kParts) group_ = parts_.shown(scene_.light_group_of(object));
  }
  /// No source.
  [[gnu::always_inline]] void note_nothing() {
    if constexpr (kSources) parts_.of_source = 1.0f;
    if constexpr (kParts) group_ = -1;
  }

  [[gnu::always_inline]] void note_rough([[maybe_unused]] bool rough) {
    if constexpr (kDirect) {
      rough_before_ = rough_before_ || rough_last_;
      rough_last_ = rough;
    }
  }

  PathPasses passes_of(int bounces, bool is_direct) const {
    PathPasses passes = parts_.part_of(bounces, first_);
    passes.group = group_;
    passes.is_direct = is_direct;
    return passes;
  }

  /// MIS weight of light that was hit, against sampling this light.
  [[gnu::always_inline]] float weight_of_hit(uint32_t light, Vec3 position, Vec3 normal) {
    const Vec3 wi = walk_.ray.direction;
    if constexpr (kMedia)
      if (medium_.chose)
        return weight_of_hit_in_medium(
            scene_,
            {previous_.position, medium_.chosen_for, previous_.bsdf_pdf, previous_.receiver_set, walk_.ray.time}, light,
            wi, position, normal);
    const float weight = direct_light_.weight_of_hit(scene_, previous_, light, wi, position, normal);
    if constexpr (kGuided) guided_.hit_weight = unguided_pdf_ ? 0.0f : weight;
    return weight;
  }

  /// The throughput of the path where it meets this light: only some kinds of lobes may see it (SampledKinds).
  [[gnu::always_inline]] Color throughput_to(uint32_t light) const {
    return lights_.any_partial() && previous_.kinds ? beta_ * visible_part(light) : beta_;
  }
  [[gnu::noinline]] Color visible_part(uint32_t light) const {
    const LightFlags flags = lights_.flags(light);
    return flags.partial() ? kinds_.throughput(flags.visibility) : Color(1.0f);
  }

  /// The weight of light that the camera sees directly, against light samples.
  [[gnu::always_inline]] float weight_at_lens(const LightMet& met) {
    if (!start_.lens_light) [[likely]]
      return 1.0f;
    return weight_against_light_samples(met);
  }
  [[gnu::noinline]] float weight_against_light_samples(const LightMet& met) {
    const bool passed_something = walk_.ray.travelled > 0.0f || walk_.point.portal_depth > 0;
    if (!walk_.seen_directly() || passed_something) return 1.0f;
    return start_.lens_light->weight_of_hit(start_.film, walk_.ray, met, sampler_, start_.counters.rays);
  }

  [[gnu::always_inline]] void add_met(const LightMet& met) {
    note_light(met.light);
    if constexpr (kParts) {
      if (walk_.seen_directly() && int(met.light) == lights_.environment_index()) {
        first_.part = PathPasses::Part::Environment;
        add(beta_ * met.radiance, 0);
        first_.part = PathPasses::Part::None;
        return;
      }
    }
    Color arriving = throughput_to(met.light) * met.radiance;
    if constexpr (kMedia) {
      const Ray& ray = walk_.ray;
      if (!medium_.stack.empty() && is_finite(met.position))
        arriving *= medium_.media.transmittance(
            {medium_.stack, ray, glm::dot(met.position - ray.origin, ray.direction), walk_.point, walk_.point.ray_kind},
            medium_.rng, medium_.counters);
    }
    add(arriving * (weight_of_hit(met.light, met.position, met.normal) * weight_at_lens(met)), walk_.point.ray_depth);
  }

  // ---- Media: path_walk_media.h --------------------------------------------------------------

  Step pass_media();
  bool is_kept(Color& throughput);
  void follow_scattered(const MediumPoint& at, const PhaseFunction& phase, Vec3 place);
  bool scatter_in_medium(const MediumPoint& at, const PhaseFunction& phase, Vec3 place);
  bool cross_boundary();

  // ---- Surfaces ------------------------------------------------------------------------------

  void meet_catcher() {
    CaughtPath& path = *start_.caught;
    if (path.caught || !walk_.point.object->shadow_catcher) return;
    path = {true, radiance_, beta_, alpha_, Color(0.0f), {}};
    if (!walk_.seen_directly()) path.alpha_before += walk_.alpha_of_nothing(beta_), path.past_glass = walk_.ray;
  }

  /// Adds the emission of the surface and records passes. Returns false where the path ends.
  [[gnu::always_inline]] bool meet_surface() {
    const ShadingPoint& point = walk_.point;
    const Bsdf& bsdf = walk_.shading.bsdf;
    if (!is_black(walk_.shading.emission)) {
      note_emission(*point.object);
      Color throughput = beta_;
      const float weight = walk_.emission_weight([&](uint32_t light, Vec3 position, Vec3 normal) {
        throughput = throughput_to(light);
        return weight_of_hit(light, position, normal) *
               weight_at_lens({light, walk_.shading.emission, position, normal});
      });
      add(throughput * walk_.shading.emission * weight, point.ray_depth);
    }
    vertex_aux_ = record_vertex(scene_, point, bsdf, beta_, aux_);
    if constexpr (kParts)
      if (point.ray_depth == 0) parts_.add_color(bsdf, beta_);
    // The transparency is needed only at surfaces that are seen directly and at the last vertex.
    const Color transparency = point.ray_depth == 0 || at_bounce_limit_ ? bsdf.transparency() : Color(0.0f);
    if (point.ray_depth == 0) alpha_ += walk_.alpha_of_surface(beta_, transparency);
    if (bsdf.empty()) return false;
    return !at_bounce_limit_ || !is_black(transparency);
  }

  /// Enters a surface with subsurface scattering, or continues with its other lobes. Returns false when the path is
  /// lost.
  [[gnu::always_inline]] bool enter_surface() {
    ShadingPoint& point = walk_.point;
    SurfaceShading& shading = walk_.shading;
    if constexpr (kGuided)
      if (!shading.bsdf.is_clear()) guided_.note_arrival(point.position);
    base_ = D::kCamera + D::kVertex * uint32_t(vertex_++);
    if (!shading.bsdf.has_subsurface() || at_bounce_limit_ || !point.mesh->has_triangles())
      return true;  // hair and points have no interior: subsurface scattering is diffuse there
    [[maybe_unused]] const float before = max_component(beta_);
    sampler_.set_dimension(D::kEnter + uint32_t(vertex_));
    const uint32_t stream = hash_combine(
        uint32_t(start_.pixel_y) * uint32_t(settings_.width) + uint32_t(start_.pixel_x), base_);
    if (!walk_below_or_stay(scene_, walk_.hit.instance, {sampler_.get_1d(), stream}, point, shading, beta_,
                            start_.counters.rays))
      return false;
    if constexpr (kGuided) guided_.unguided_beta *= max_component(beta_) / before;
    return true;
  }

  /// Adds direct light at the surface. `here` receives how it was sampled.
  [[gnu::always_inline]] void sample_direct_light(DirectVertex& here) {
    const ShadingPoint& point = walk_.point;
    const Bsdf& bsdf = walk_.shading.bsdf;
    uint64_t& rays = start_.counters.rays;
    SampledLight sampled;
    const DirectLightContext context{scene_,
                                     point,
                                     bsdf,
                                     uint32_t(material_),
                                     start_.pixel_x,
                                     start_.pixel_y,
                                     guided_bsdf(),
                                     kParts || kSources ? &sampled : nullptr,
                                     true};
    Color direct;
    if constexpr (kMedia)
      direct = direct_light_.estimate(MediaDirectContext<Medium>{context, medium_, walk_.hit}, sampler_,
                                      base_ + D::kDirectLight, here, vertex_aux_, rays);
    else
      direct = direct_light_.estimate(context, sampler_, base_ + D::kDirectLight, here, vertex_aux_, rays);
    if constexpr (!std::is_same_v<DirectLight, MisDirectLight>) {
      if (has_soft_terminator(point))
        direct += estimate_direct<SampledPart::BeyondTerminator>(context, sampler_, base_ + D::kDirectLight, rays);
    }
    if constexpr (kParts)
      if (point.ray_depth == 0 && !is_black(direct)) first_ = LightPasses::scattered_by(bsdf, point.wo, sampled.wi);
    if (!is_black(direct)) {
      if constexpr (kParts || kSources) note_light(sampled.light);
      add(beta_ * direct, point.ray_depth + 1);
    }
  }

  /// Adds direct light, then chooses the next direction of the path. Returns false where the path ends.
  [[gnu::always_inline]] bool scatter() {
    ShadingPoint& point = walk_.point;
    const Bsdf& bsdf = walk_.shading.bsdf;
    const bool lit = bsdf.has_non_delta() && !at_bounce_limit_;
    // If light went below the surface, the lobes are those of the exit point.
    if constexpr (kGuided) guided_.bsdf.start(lit ? guide_.tree : nullptr, bsdf, point.position, 1.0f - guided_.plain);
    DirectVertex here;
    if (lit && lights_.can_choose()) sample_direct_light(here);

    const std::optional<BsdfSample> sample = sample_direction();
    if (!sample || !(sample->pdf_solid_angle > 0.0f)) return false;
    beta_ *= sample->f_cos / sample->pdf_solid_angle;
    if (!(largest(beta_) > 0.0f)) return false;
    if constexpr (kMedia)
      if (glm::dot(sample->wi, point.ng) < 0.0f)
        medium_.media.cross(walk_.hit, !point.backfacing, medium_.stack, medium_.counters);
    // Straight on: MIS still uses the light sample of the vertex before.
    if (sample->flags & kTransparent) {
      if (scene_.depends_on_ray_kind(walk_.hit)) pass_ray_kinds();
      if (point.transparent_depth >= kSafeTransparent && !survives_transparency()) [[unlikely]]
        return false;
      return has_portal() ? pass_portal(*sample) : walk_.pass_through();
    }
    if (at_bounce_limit_) return false;

    if constexpr (kParts)
      if (point.ray_depth == 0)
        first_ = sample->specular ? LightPasses::specular(sample->flags & kTransmission)
                                  : LightPasses::scattered_by(bsdf, point.wo, sample->wi);
    note_rough(!sample->specular);
    walk_.note_bounce(*sample);
    count_bounce(*sample, point, point);
    at_bounce_limit_ = past_limits(point, settings_.bounces);
    // At the limit only lights would count, and light sampling has counted them already.
    if (at_bounce_limit_ && here.complete && !sample->specular && start_.ends_early) return false;
    if (point.ray_depth > kSafeBounces) {
      roulette_is_due_ = sample->roughness < kLateRouletteRoughness;
      if (!roulette_is_due_ && !survives_roulette(base_)) return false;
    }
    if constexpr (kMedia) medium_.chose = false;
    previous_ = here;
    previous_.bsdf_pdf = sample->specular ? 0.0f : sample->pdf_solid_angle;
    if constexpr (kGuided) unguided_pdf_ = false;
    previous_.position = point.position;
    previous_.normal = bsdf.receiving_normal();
    previous_.receiver_set = receiver_set(point);
    previous_.time = point.time;
    if (lights_.any_partial() && !sample->specular) [[unlikely]] {
      kinds_ = SampledKinds(bsdf, point.wo, sample->wi);
      previous_.kinds = &kinds_;
    }
    walk_.leave_along(sample->wi);
    return true;
  }

  bool has_portal() const { return scene_.has_portals() && scene_.programs()[size_t(material_)].has_portal(); }
  /// Continues at another place, or straight on. Shadow rays pass neither, so light found from here on counts fully.
  [[gnu::noinline]] bool pass_portal(const BsdfSample& sample) {
    previous_ = {.receiver_set = previous_.receiver_set};
    if constexpr (kMedia) medium_.chose = false;
    return walk_.pass_portal(sample);
  }

  /// The number that chooses a lobe, if it `has_choice`, and those of the direction.
  [[gnu::always_inline]] std::pair<float, Vec2> draw_direction(bool has_choice) {
    if (!has_choice) return {0.5f, sampler_.get_2d()};
    const Vec3 u = sampler_.get_3d();
    return {u.z, Vec2(u)};
  }

  [[gnu::always_inline]] std::optional<BsdfSample> sample_direction() {
    const Bsdf& bsdf = walk_.shading.bsdf;
    sampler_.set_dimension(base_ + D::kLobe);
    const auto [u_lobe, u_direction] = draw_direction(bsdf.lobe_count() > 1 || bsdf.lobe(0).kind != LobeKind::Diffuse);
    if constexpr (kGuided)
      return sample_guided(u_lobe, u_direction);
    else
      return bsdf.sample(walk_.point.wo, u_lobe, u_direction);
  }

  /// Survival probabilities follow from the throughput without the guide. A direction that the guide prefers has a high
  /// density and therefore a low throughput, although much light comes from it.
  [[gnu::always_inline]] float unguided_throughput() const {
    if constexpr (kGuided)
      return guided_.unguided_beta;
    else
      return largest(beta_);
  }
  [[gnu::always_inline]] bool survives_with(float survival, uint32_t base) {
    if constexpr (kGuided)
      return survives(survival, sampler_, base + D::kRoulette, beta_, guided_.unguided_beta);
    else
      return survives(survival, sampler_, base + D::kRoulette, beta_);
  }
  [[gnu::always_inline]] bool survives_roulette(uint32_t base) {
    return survives_with(std::min(1.0f, std::sqrt(unguided_throughput())), base);
  }

  /// Light that sharp lobes scatter is found by such rays alone. If roulette came before the ray, light that is reflected
  /// faintly would be found rarely and with a large weight. So it comes after the light that the ray finds.
  [[gnu::always_inline]] bool survives_due_roulette() {
    if (!roulette_is_due_) return true;
    roulette_is_due_ = false;
    return survives_roulette(base_);
  }

  /// Behind many tinted surfaces little is left of the throughput. What survives has kFaint of it.
  [[gnu::noinline]] bool survives_transparency() { return survives_with(unguided_throughput() / kFaint, base_); }

  /// Weights are negative where majorants are exceeded.
  static float largest(Color c) { return max_component(kMedia ? glm::abs(c) : c); }

  // ---- Guiding -------------------------------------------------------------------------------

  /// The ray passes a surface that depends on the kind of the ray. Light that is found from here on has the weight that
  /// it has without the guide (DirectLightContext::evaluate).
  void pass_ray_kinds() {
    previous_.past_ray_kinds = true;
    if constexpr (kGuided) {
      if (unguided_pdf_) return;
      unguided_pdf_ = true;
      previous_.bsdf_pdf *= guided_.last_ratio;
    }
  }

  const GuidedBsdf* guided_bsdf() const {
    if constexpr (kGuided)
      return &guided_.bsdf;
    else
      return nullptr;
  }

  std::optional<BsdfSample> sample_guided(float u_lobe, Vec2 u_direction) {
    float u_guide = 0.0f, pdf_bsdf = 0.0f;
    if (guided_.bsdf.guided()) {
      sampler_.set_dimension(base_ + D::kGuide);
      u_guide = sampler_.get_1d();
    }
    const auto sample = guided_.bsdf.sample(walk_.point.wo, u_guide, u_lobe, u_direction, pdf_bsdf);
    if (!sample || !(sample->pdf_solid_angle > 0.0f)) {
      guided_.note_failure(u_guide, u_lobe);
      return {};
    }
    if (guide_.samples && !sample->specular && guided_.open_count < kMaxOpenVertices) {
      const float pdf = pdf_bsdf / std::max(1.0f - guided_.bsdf.delta_probability(), 1e-6f);
      guided_.open[guided_.open_count++] = {{walk_.point.position, walk_.shading.bsdf.n, sample->wi, 0.0f, 0.0f, pdf,
                                             guided_.bsdf.kind(), guide_.pixel, guide_.index},
                                            radiance_,
                                            luminance(beta_)};
    }
    guided_.note_direction(sample->specular ? sample->pdf_solid_angle : pdf_bsdf, sample->pdf_solid_angle);
    guided_.unguided_beta *= max_component(sample->f_cos) / (sample->specular ? sample->pdf_solid_angle : pdf_bsdf);
    return sample;
  }

  static constexpr int kSafeBounces = 1;  ///< without Russian roulette
  /// Transparent surfaces without Russian roulette, and the throughput below which it begins behind them.
  static constexpr int kSafeTransparent = 4;
  static constexpr float kFaint = 0.1f;
  /// Roughness of a sampled lobe below which Russian roulette waits for the end of the ray. At rougher lobes, light
  /// samples have most of the weight.
  static constexpr float kLateRouletteRoughness = 0.3f;

  const DirectLight& direct_light_;
  const Guide& guide_;
  Medium medium_;
  Parts& parts_;
  const Scene& scene_;
  const LightSet& lights_;
  const RenderSettings& settings_;
  const PathStart& start_;
  Sampler& sampler_;
  SampleAux* aux_;                   ///< null when nothing more is recorded
  SampleAux* vertex_aux_ = nullptr;  ///< set at the first hit only
  EyeWalk walk_;
  Color radiance_{0.0f}, beta_{1.0f};
  float alpha_ = 0.0f;
  DirectVertex previous_;         ///< the vertex at which the present direction was chosen
  SampledKinds kinds_;            ///< of that direction, in scenes with lights that only some kinds of rays see
  bool at_bounce_limit_ = false;  ///< a bounce limit is reached: only the emission of the next surface still counts
  int vertex_ = 0, material_ = 0;
  /// For the part of direct paths: whether the last bounce, and any one before it, was not at a delta lobe.
  bool rough_last_ = false, rough_before_ = false;
  bool roulette_is_due_ = false;  ///< at the next surface
  uint32_t base_ = 0;             ///< first dimension of the vertex
  /// For light passes: the first scattering event, and the group of the light that is added next.
  [[no_unique_address]] std::conditional_t<kParts, PathPasses, NoParts> first_;
  int group_ = -1;
  [[no_unique_address]] std::conditional_t<kGuided, GuidedPath, NoGuidedPath> guided_;
  bool unguided_pdf_ = false;  ///< previous_.bsdf_pdf is the density without the guide
};

}  // namespace ajar

#include "integrators/path_walk_media.h"
