// Direct light at the vertices of a path: the code that all methods share, and the default method.
//
// Every method computes two results for the path tracer. At a vertex, it estimates the light that arrives directly and
// is scattered towards wo. At the next vertex, it computes the weight of emission that the BSDF sample has hit.
// Together, both are an unbiased estimate of direct light (except for methods that are marked as biased).
#pragma once

#include "film/film.h"
#include "sampling/power_heuristic.h"
#include "sampling/sampler.h"
#include "scene/scene.h"
#include "transport/direct/sampled_kinds.h"
#include "transport/guiding/guided_bsdf.h"
#include "transport/paths/ray_events.h"
#include "transport/paths/shadow_terminator.h"

namespace ajar {

/// The part of the light that light sampling adds.
enum class SampledPart : uint8_t {
  All,
  BeyondTerminator,  ///< shadow_terminator.h
  ByRayKind  ///< past surfaces that depend on the kind of the ray (ray_kind_surfaces.h), and not the part before
};

struct SampledLight {
  Vec3 wi{0.0f};  ///< direction towards the light
  uint32_t light = 0;
};

struct DirectLightContext {
  const Scene& scene;
  const ShadingPoint& point;
  const Bsdf& bsdf;
  uint32_t material = 0;              ///< index of the material
  int pixel_x = 0, pixel_y = 0;       ///< in the full frame
  const GuidedBsdf* guide = nullptr;  ///< if not null, it samples the path's direction together with the BSDF
  SampledLight* sampled = nullptr;    ///< if not null, it receives the sampled light
  bool knows_kinds = false;           ///< DirectVertex::kinds is known for the path's own sample

  /// Evaluates the BSDF. The density is that of the path's own sample, against which light samples are weighted. (Light
  /// past surfaces that depend on the kind of the ray is an exception: its weights define what is found of it, and must
  /// not depend on a guide.)
  Bsdf::Evaluation evaluate(Vec3 wi) const {
    Bsdf::Evaluation value = bsdf.evaluate(point.wo, wi);
    if (guide) value.pdf_solid_angle = guide->pdf_solid_angle(value.pdf_solid_angle, wi);
    return value;
  }
  /// Transmittance of a ray to a light. `by_ray_kind`: as for Scene::transmittance.
  Color transmittance(const Ray& ray, bool* by_ray_kind = nullptr) const {
    return scene.transmittance(ray, scene.settings().bounces.transparent, by_ray_kind);
  }
  Color beyond(const LightPlace& light, Color f_cos, bool shadows, uint64_t& rays) const {
    return beyond_terminator(scene, point, bsdf, light, f_cos, shadows, rays);
  }
};

/// The data that a vertex stores for the weight of light that its BSDF sample hits.
struct DirectVertex {
  Vec3 position{0.0f}, normal{0.0f};  ///< Bsdf::receiving_normal
  /// Density of the sampled direction by BSDF and guide. 0 if light sampling cannot find the light.
  float bsdf_pdf = 0.0f;
  bool complete = false;  ///< the estimate at the vertex includes all light, so its BSDF sample contributes none
  uint32_t cell = ~0u;    ///< cell of the learned shares
  uint32_t receiver_set = kEveryLight;
  float time = 0.0f;            ///< of the path
  bool past_ray_kinds = false;  ///< the ray has passed a surface that depends on the kind of the ray
  /// Of the sampled direction. Null: light that only some kinds of rays see is found by light samples alone.
  const SampledKinds* kinds = nullptr;
};

/// Whether only light samples or only BSDF samples find some of the light, so that their weights define how much of it
/// is seen: that of Cycles.
inline bool weights_define_light(const Scene& scene) {
  return scene.depends_on_ray_kind() || scene.lights().any_limited();
}

/// The data of a vertex that weigh the light that its sample hits.
inline DirectVertex vertex_of(DirectVertex here, const ShadingPoint& point, const Bsdf& bsdf,
                              const BsdfSample& sample) {
  here.position = point.position;
  here.normal = bsdf.receiving_normal();
  here.receiver_set = receiver_set(point);
  here.time = point.time;
  here.bsdf_pdf = sample.specular ? 0.0f : sample.pdf_solid_angle;
  return here;
}

/// Number of dimensions of a path's sampler for direct light, starting at `first`: one for the choice, two for the
/// point.
constexpr uint32_t kDirectDimensions = 3;

/// In the estimators with learned shares: with fewer lights, the random number that chooses a light is used again for
/// the point on it. So points that are stratified together stay stratified on each light. With more lights, too few bits
/// would remain.
constexpr size_t kFewLights = 64;

/// One sample of one light, weighted against the BSDF's density of the same direction, with light beyond the shadow
/// terminator. `rays` counts shadow rays. Methods that sample light in other ways add the light beyond the terminator
/// alone.
template <SampledPart kPart = SampledPart::All, class Context>
inline Color estimate_direct(const Context& c, const LightSet::Choice& choice, Vec2 u, uint64_t& rays) {
  const LightSet& lights = c.scene.lights();
  if (!(choice.pmf > 0.0f)) return Color(0.0f);
  const auto sample = lights.sample_li(choice.light, c.point.position, u, c.point.time);
  if (!sample || is_black(sample->radiance)) return Color(0.0f);
  if (c.sampled) *c.sampled = {sample->wi, choice.light};
  const bool asks = kPart == SampledPart::ByRayKind || c.scene.depends_on_ray_kind();
  bool by_ray_kind = false;
  constexpr bool kOnlyBeyond = kPart == SampledPart::BeyondTerminator, kByKind = kPart == SampledPart::ByRayKind;
  if (kOnlyBeyond && !grazes_terminator(c.point, sample->wi)) return Color(0.0f);
  Bsdf::Evaluation scattered = c.evaluate(sample->wi);
  const LightFlags light = lights.flags(choice.light);
  if (!light.lights(receiver_set(c.point)) || c.point.ray_depth > light.max_bounces) return Color(0.0f);
  float found_share = 1.0f;  // of the density of the BSDF sample, with which it finds the light
  if (light.partial()) {
    scattered.f_cos = visible_to(light.visibility, c.bsdf, c.point.wo, sample->wi);
    if (is_black(scattered.f_cos)) return Color(0.0f);
    found_share = c.knows_kinds && !light.has_blockers()
                      ? visible_share(c.bsdf.kind_shares(c.point.wo, sample->wi, false), light.visibility)
                      : 0.0f;
  }
  const Color arriving = sample->radiance / (choice.pmf * sample->pdf_solid_angle);
  if (!is_black(scattered.f_cos)) {
    Color through(1.0f);
    if (light.cast_shadow) {
      ++rays;
      through = c.transmittance(c.scene.spawn_segment(c.point, *sample), asks ? &by_ray_kind : nullptr);
      if (kByKind && !by_ray_kind) return Color(0.0f);
    } else if (kByKind) {
      return Color(0.0f);
    }
    if (!is_black(through)) {
      if (kOnlyBeyond) return Color(0.0f);
      Color contribution = scattered.f_cos * arriving * through;
      // The BSDF sample can find the light too: power heuristic [Veach 1997, eq. 9.13].
      if (c.guide && by_ray_kind) [[unlikely]]
        scattered.pdf_solid_angle = c.bsdf.evaluate(c.point.wo, sample->wi).pdf_solid_angle;
      if (!sample->delta && light.mis && found_share > 0.0f) {
        const float pdf = choice.pmf * sample->pdf_solid_angle;
        contribution *= power_heuristic(counted_light_pdf(pdf, sample->distance, by_ray_kind || lights.any_limited()),
                                        found_share * scattered.pdf_solid_angle);
      }
      return contribution;
    }
  }
  if (kByKind || !has_soft_terminator(c.point)) return Color(0.0f);
  return arriving * c.beyond(*sample, scattered.f_cos, light.cast_shadow, rays);
}

template <SampledPart kPart = SampledPart::All, class Context>
inline Color estimate_direct(const Context& c, float u_choice, Vec2 u, uint64_t& rays) {
  const LightSet& lights = c.scene.lights();
  return estimate_direct<kPart>(
      c, lights.choose(c.point.position, c.bsdf.receiving_normal(), u_choice, receiver_set(c.point)), u, rays);
}
template <SampledPart kPart = SampledPart::All, class Context>
inline Color estimate_direct(const Context& c, Sampler& sampler, uint32_t first, uint64_t& rays) {
  const LightSet& lights = c.scene.lights();
  sampler.set_dimension(first);
  if (lights.size() == 1) return estimate_direct<kPart>(c, 0.0f, sampler.get_2d(), rays);
  const Vec3 u = sampler.get_3d();
  return estimate_direct<kPart>(c, u.z, Vec2(u), rays);
}

/// The default method: one sample of one light and the path's own BSDF sample, weighted by the power heuristic
/// (multiple importance sampling, Veach 1997, section 9.2).
class MisDirectLight {
 public:
  template <class Context = DirectLightContext>
  Color estimate(const Context& c, Sampler& sampler, uint32_t first, DirectVertex&, SampleAux*, uint64_t& rays) const {
    return estimate_direct(c, sampler, first, rays);
  }

  /// `position` is the point of the light that was hit, infinite for distant light. Distances are measured from the
  /// vertex that sampled the direction, regardless of transparent surfaces in between.
  float weight_of_hit(const Scene& scene, const DirectVertex& v, uint32_t light, Vec3 wi, Vec3 position,
                      Vec3 normal) const {
    const LightSet& lights = scene.lights();
    if (lights.any_linked() && !lights.flags(light).lights(v.receiver_set)) return 0.0f;
    if (v.bsdf_pdf == 0.0f) return 1.0f;
    float bsdf_pdf = v.bsdf_pdf;
    if (lights.any_partial()) {
      const LightFlags flags = lights.flags(light);
      if (flags.partial()) bsdf_pdf *= v.kinds && !flags.has_blockers() ? v.kinds->share(flags.visibility) : 0.0f;
      if (!(bsdf_pdf > 0.0f)) return 0.0f;
    }
    const float distance = is_finite(position) ? glm::length(position - v.position) : kInfinity;
    const float light_pdf = lights.choice_pmf(v.position, v.normal, light, v.receiver_set) *
                            lights.pdf_li(light, v.position, wi, distance, normal, v.time);
    return power_heuristic(bsdf_pdf, counted_light_pdf(light_pdf, distance, v.past_ray_kinds || lights.any_limited()));
  }
};

}  // namespace ajar
