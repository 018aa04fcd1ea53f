#include "transport/photons/photon_gather.h"

#include <algorithm>

namespace ajar {

namespace {

/// Dimensions of the sampler of camera rays: those of the camera, then a fixed number for each vertex.
constexpr uint32_t kCameraDimensions = 6, kVertexDimensions = 12;
/// Offsets at a vertex: direct light of the rough and of the sharp lobes, then the choices of the sharp lobes.
constexpr uint32_t kRoughLight = 0, kSharpLight = 3, kLobe = 6, kRoulette = 9;
/// Dimensions of the direction of a gather ray. A fixed number for each vertex of its chain follows.
constexpr uint32_t kGatherDimensions = 4;
/// In units of the global radius. A shorter gather ray ends near a corner, where the blur of the density estimate would
/// show light from the other side of the corner. Light is gathered once more there.
constexpr float kNear = 1.0f;

}  // namespace

Color PhotonGatherer::direct_light(const ShadingPoint& point, const Bsdf& bsdf, Sampler& sampler, uint32_t dimension) {
  if (log_only_ || scene_.lights().empty() || !bsdf.has_non_delta()) return Color(0.0f);
  DirectVertex unused;
  return direct_.estimate({scene_, point, bsdf}, sampler, dimension, unused, nullptr, rays_);
}

Color PhotonGatherer::trace(Ray ray, SampleAux* aux, float& alpha, Color& seen) {
  Color radiance(0.0f), beta(1.0f);
  EyeWalk walk(scene_, ray, rays_);
  ShadingPoint& point = walk.point;
  const SurfaceShading& shading = walk.shading;
  DirectVertex origin;
  bool at_bounce_limit = false, specular = true;
  alpha = 0.0f;
  seen = Color(0.0f);
  polished_ = false;
  for (uint32_t vertex = 0;; ++vertex) {
    walk.trace();
    const auto weight_of_hit = [&](uint32_t light, Vec3 position, Vec3 normal) {
      return direct_.weight_of_hit(scene_, origin, light, walk.ray.direction, position, normal);
    };
    const auto add_met = [&](const LightMet& met) {
      (specular ? seen : radiance) += beta * met.radiance * weight_of_hit(met.light, met.position, met.normal);
    };
    walk.meet_lamps(add_met);
    if (!walk.found()) {
      walk.meet_distant(add_met);
      alpha += walk.alpha_of_nothing(beta);
      break;
    }
    if (!walk.arrive()) break;
    walk.shade();
    if (!is_black(shading.emission))
      (specular ? seen : radiance) += beta * shading.emission * walk.emission_weight(weight_of_hit);
    if (aux && point.ray_depth == 0) {
      record_first_hit(scene_, point, shading.bsdf, *aux);
      aux = nullptr;
    }
    const Color transparency = shading.bsdf.transparency();
    if (point.ray_depth == 0) alpha += walk.alpha_of_surface(beta, transparency);
    if (at_bounce_limit && is_black(transparency)) break;

    const LobeSplit split(shading.bsdf, point.wo);
    const uint32_t base = kCameraDimensions + kVertexDimensions * vertex;
    if (split.rough() && !at_bounce_limit) {
      // The number of gather rays at a surface that is seen by reflection is in proportion to the throughput.
      const int rays = std::max(1, int(std::ceil(float(settings_.rays) * std::min(1.0f, max_component(beta)))));
      radiance += beta * reflected(point, *split.rough(), beta, rays, 0, sampler_, base + kRoughLight);
    }
    if (!split.sharp()) break;
    if (!at_bounce_limit) radiance += beta * direct_light(point, *split.sharp(), sampler_, base + kSharpLight);

    sampler_.set_dimension(base + kLobe);
    const float u_lobe = sampler_.get_1d();
    const auto sample = split.sharp()->sample(point.wo, u_lobe, sampler_.get_2d());
    if (!sample || !(sample->pdf_solid_angle > 0.0f)) break;
    beta *= sample->f_cos / sample->pdf_solid_angle;
    if (!(max_component(beta) > 0.0f)) break;
    if (sample->flags & kTransparent) {
      if (!walk.pass_through()) break;
      continue;
    }
    if (at_bounce_limit) break;
    count_bounce(*sample, point, point);
    at_bounce_limit = past_limits(point, scene_.settings().bounces);
    if (point.ray_depth > 2 &&
        !survives(std::min(1.0f, std::sqrt(max_component(beta))), sampler_, base + kRoulette, beta))
      break;
    specular = specular && sample->specular;
    polished_ |= specular;
    origin = {point.position, split.sharp()->receiving_normal(), sample->specular ? 0.0f : sample->pdf_solid_angle};
    walk.leave_along(sample->wi);
  }
  return radiance;
}

Color PhotonGatherer::reflected(const ShadingPoint& point, const Bsdf& rough, Color throughput, int rays, int depth,
                                Sampler& sampler, uint32_t dimension) {
  Color sum = direct_light(point, rough, sampler, dimension);
  if (log_ && depth == 0 && (pixel_ + index_) % uint32_t(log_->stride[ArrivalMap::kSeen]) == 0)
    log_arrival(ArrivalMap::kSeen, point, throughput);
  if (maps_.has_caustic) sum += maps_.caustic.radiance(point, rough, {settings_.neighbours, maps_.caustic_radius});
  Color gathered(0.0f);
  GuidedBsdf guided;
  guided.start(depth == 0 ? guide_ : nullptr, rough, point.position, 1.0f);
  for (int i = 0; i < rays; ++i) {
    // The first surface uses its own sequence over all samples and gather rays of the pixel.
    Sampler& own = depth == 0 ? gather_sampler_ : sampler;
    uint32_t base = dimension + 3;
    if (depth == 0) {
      own.start(hash_combine(pixel_, dimension), index_ * uint32_t(rays) + uint32_t(i));
      base = 0;
    }
    own.set_dimension(base);
    const float u_lobe = own.get_1d();
    own.set_dimension(base + 1);
    const Vec2 u = own.get_2d();
    float u_guide = 0.0f, pdf_bsdf;
    if (guided.guided()) {
      own.set_dimension(base + 3);
      u_guide = own.get_1d();
    }
    const auto sample = guided.sample(point.wo, u_guide, u_lobe, u, pdf_bsdf);
    if (!sample || !(sample->pdf_solid_angle > 0.0f) || is_black(sample->f_cos)) continue;
    ++gathered_;
    const Color weight = sample->f_cos / sample->pdf_solid_angle;
    const bool logged = log_ && depth == 0 &&
                        (pixel_ + index_ + uint32_t(i)) % uint32_t(log_->stride[ArrivalMap::kGathered]) == 0;
    const Incoming arriving = incoming(point, *sample, pdf_bsdf,
                                       logged ? throughput * weight / float(rays) : Color(0.0f), depth, own,
                                       base + kGatherDimensions);
    const Color found = weight * arriving.radiance;
    gathered += found;
    if (depth == 0 && guide_samples_ && luminance(found) > 0.0f &&
        hash_combine(pixel_, index_ * uint32_t(rays) + uint32_t(i)) % guide_stride_ == 0)
      guide_samples_->push_back({point.position, rough.n, sample->wi,
                                 arriving.distance > 0.0f ? 1.0f / arriving.distance : 0.0f, luminance(found), pdf_bsdf,
                                 guided.kind()});
  }
  return sum + gathered / float(rays);
}

PhotonGatherer::Incoming PhotonGatherer::incoming(const ShadingPoint& from, const BsdfSample& first, float pdf_bsdf,
                                                  Color throughput, int depth, Sampler& sampler, uint32_t dimension) {
  const BounceLimits& limits = scene_.settings().bounces;
  const DirectVertex origin{from.position, from.ns, pdf_bsdf};
  Incoming result;
  Color& radiance = result.radiance;
  Color beta(1.0f);
  EyeWalk walk(scene_, scene_.spawn_ray(from, first.wi), rays_, from);
  ShadingPoint& point = walk.point;
  const SurfaceShading& shading = walk.shading;
  count_bounce(first, from, point);
  const bool at_bounce_limit = past_limits(point, limits);
  // No sharp bounce yet: a light that is hit is direct light; after a sharp bounce it would be a caustic.
  bool straight = true;
  float length = 0.0f;
  for (uint32_t vertex = 0;; ++vertex) {
    walk.trace();
    const auto weight_of_hit = [&](uint32_t light, Vec3 position, Vec3 normal) {
      return direct_.weight_of_hit(scene_, origin, light, walk.ray.direction, position, normal);
    };
    const auto add_met = [&](const LightMet& met) {
      radiance += beta * met.radiance * weight_of_hit(met.light, met.position, met.normal);
    };
    if (straight) walk.meet_lamps(add_met);
    if (straight && !walk.found()) walk.meet_distant(add_met);
    if (!walk.found()) break;
    if (vertex == 0) result.distance = walk.hit.t;
    walk.arrive();
    length += walk.hit.t;
    walk.shade();
    if (straight && !is_black(shading.emission))
      radiance += beta * shading.emission * walk.emission_weight(weight_of_hit);
    if (at_bounce_limit && !shading.bsdf.empty() && is_black(shading.bsdf.transparency())) break;
    if (!maps_.has_global && !log_ && is_black(shading.bsdf.transparency())) break;
    const LobeSplit split(shading.bsdf, point.wo);
    if (split.rough() && !at_bounce_limit && log_) log_arrival(ArrivalMap::kGathered, point, throughput * beta);
    if (split.rough() && !at_bounce_limit && maps_.has_global) {
      const bool near = straight && depth < 2 && length < kNear * maps_.global_radius;
      radiance += beta * (near ? reflected(point, *split.rough(), Color(0.0f), 1, depth + 1, sampler,
                                           dimension + kVertexDimensions * (vertex + 1))
                               : from_map(point, *split.rough()));
    }
    if (!split.sharp()) break;
    const uint32_t base = dimension + kVertexDimensions * vertex;
    sampler.set_dimension(base + kLobe);
    const float u_lobe = sampler.get_1d();
    const auto sample = split.sharp()->sample(point.wo, u_lobe, sampler.get_2d());
    if (!sample || !(sample->pdf_solid_angle > 0.0f)) break;
    beta *= sample->f_cos / sample->pdf_solid_angle;
    if (sample->flags & kTransparent) {
      if (!(max_component(beta) > 0.0f) || !walk.pass_through()) break;
      continue;
    }
    straight = false;
    if (at_bounce_limit || !maps_.has_global) break;
    count_bounce(*sample, point, point);
    if (past_limits(point, limits)) break;
    if (!survives(std::min(1.0f, max_component(beta)), sampler, base + kRoulette, beta)) break;
    walk.leave_along(sample->wi);
  }
  return result;
}

bool PhotonGatherer::find_rough(Ray ray, ShadingPoint& point, SurfaceShading& shading) {
  EyeWalk walk(scene_, ray, rays_, point);
  for (int vertex = 0; vertex < 16; ++vertex) {
    walk.trace();
    if (!walk.found()) return false;
    walk.arrive();
    walk.shade();
    point = walk.point;
    shading = walk.shading;
    const LobeSplit split(shading.bsdf, point.wo);
    if (split.rough()) return true;
    if (!split.sharp()) return false;
    const float u_lobe = sampler_.get_1d();
    const auto sample = split.sharp()->sample(point.wo, u_lobe, sampler_.get_2d());
    if (!sample) return false;
    if (!(sample->flags & kTransparent)) count_bounce(*sample, point, walk.point);
    walk.leave_along(sample->wi);
  }
  return false;
}

bool PhotonGatherer::probe(const Ray& ray, SurfacePoint& seen, SurfacePoint& gathered) {
  ShadingPoint point;
  SurfaceShading shading;
  sampler_.set_dimension(kCameraDimensions);
  if (!find_rough(ray, point, shading)) return false;
  seen = {point.position, pack_direction(point.ng)};
  const float u_lobe = sampler_.get_1d();
  const auto sample = LobeSplit(shading.bsdf, point.wo).rough()->sample(point.wo, u_lobe, sampler_.get_2d());
  if (!sample) return false;
  count_bounce(*sample, point, point);
  if (!find_rough(scene_.spawn_ray(point, sample->wi), point, shading)) return false;
  gathered = {point.position, pack_direction(point.ng)};
  return true;
}

void PhotonGatherer::log_arrival(int place, const ShadingPoint& point, Color throughput) {
  const float y = luminance(throughput) * float(log_->stride[place]);
  if (y > 0.0f) log_->at[place].push_back({{point.position, pack_direction(point.ng)}, y});
}

Color PhotonGatherer::from_map(const ShadingPoint& point, const Bsdf& rough) {
  Color irradiance;
  if (is_plain_lambert(rough) && maps_.sites.find(point.position, point.ng, 0.5f * maps_.global_radius, irradiance)) {
    ++from_sites_;
    return rough.lobe(0).weight * kInvPi * irradiance;
  }
  return maps_.global.radiance(point, rough, {settings_.gather_neighbours, maps_.global_radius});
}

}  // namespace ajar
