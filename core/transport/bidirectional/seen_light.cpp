#include "transport/bidirectional/seen_light.h"

#include <algorithm>

#include "transport/paths/eye_walk.h"
#include "transport/paths/specular_branches.h"

namespace ajar {

namespace {

constexpr uint32_t kFirstDimension = 4, kVertexDimensions = 4, kLobe = 0, kRoulette = 3;

bool goes_on(const Lobe& lobe) { return lobe.is_delta() || lobe.kind == LobeKind::Transparent; }

/// The specular and transparent lobes of `bsdf`; null when there are none. `storage` holds them if `bsdf` has other
/// lobes too.
const Bsdf* specular_part(const Bsdf& bsdf, Vec3 wo, Bsdf& storage) {
  int count = 0;
  for (int i = 0; i < bsdf.lobe_count(); ++i) count += goes_on(bsdf.lobe(i)) ? 1 : 0;
  if (count == 0) return nullptr;
  if (count == bsdf.lobe_count()) return &bsdf;
  storage.assign_lobes(bsdf, goes_on);
  storage.prepare(wo);
  return &storage;
}

/// A walk whose ray will find surface number `vertex` of its path. `point` holds the bounces before.
struct Walk {
  Ray ray;
  ShadingPoint point;
  Color beta;
  uint32_t vertex;
};

/// Light that the walk finds until it ends. Other walks are stored in `branches`.
Color follow(const Scene& scene, const Walk& walk, SpecularBranches<Walk>& branches, Sampler& sampler, uint64_t& rays) {
  Color radiance(0.0f), beta = walk.beta;
  EyeWalk eye(scene, walk.ray, rays, walk.point);
  ShadingPoint& point = eye.point;
  const SurfaceShading& shading = eye.shading;
  Bsdf storage;
  for (uint32_t vertex = walk.vertex;; ++vertex) {
    eye.trace();
    const auto meet = [&](const LightMet& met) { radiance += beta * met.radiance; };
    eye.meet_lamps(meet);
    if (!eye.found()) {
      eye.meet_distant(meet);
      return radiance;
    }
    if (!eye.arrive()) return radiance;
    eye.shade();
    radiance += beta * shading.emission;
    const bool at_bounce_limit = past_limits(point, scene.settings().bounces);
    if (at_bounce_limit && is_black(shading.bsdf.transparency())) return radiance;
    const Bsdf* specular = specular_part(shading.bsdf, point.wo, storage);
    if (!specular) return radiance;

    if (!at_bounce_limit) {
      branches.split(*specular, point.wo, beta, [&](const BsdfSample& event) {
        Walk next{scene.spawn_ray(point, event.wi), {}, beta * event.f_cos, vertex + 1};
        count_bounce(event, point, next.point);
        return next;
      });
      if (branches.follows_all()) return radiance;
    }
    const uint32_t base = kFirstDimension + kVertexDimensions * vertex;
    sampler.set_dimension(base + kLobe);
    const Vec3 u = sampler.get_3d();
    const auto sample = specular->sample(point.wo, u.z, Vec2(u));
    if (!sample || !(sample->pdf_solid_angle > 0.0f)) return radiance;
    if (sample->flags & kTransparent) {
      beta *= sample->f_cos / sample->pdf_solid_angle;
      if (!(max_component(beta) > 0.0f) || !eye.pass_through()) return radiance;
      continue;
    }
    if (at_bounce_limit || branches.follows(*sample)) return radiance;
    beta *= sample->f_cos / sample->pdf_solid_angle;
    count_bounce(*sample, point, point);
    if (!survives(std::min(1.0f, max_component(beta) / SpecularBranches<Walk>::kMin), sampler, base + kRoulette, beta))
      return radiance;
    eye.leave_along(sample->wi);
  }
}

}  // namespace

Color trace_seen_light(const Scene& scene, Ray ray, Sampler& sampler, uint64_t& rays) {
  Color radiance(0.0f);
  SpecularBranches<Walk> branches({ray, {}, Color(1.0f), 0});
  Walk walk;
  while (branches.next(walk)) radiance += follow(scene, walk, branches, sampler, rays);
  return radiance;
}

}  // namespace ajar
