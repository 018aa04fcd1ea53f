#include "transport/photons/photon_gather.h"

#include <algorithm>
#include <utility>

#include "transport/media/subsurface_walk.h"
#include "transport/paths/record.h"

namespace ajar {

namespace {

/// Dimensions of the sampler of camera rays: those of the camera, then a fixed number for each vertex.
constexpr uint32_t kCameraDimensions = 6, kVertexDimensions = 12;
/// Offsets at a vertex: direct light of the rough and of the sharp lobes, then the choices of the sharp lobes.
constexpr uint32_t kRoughLight = 0, kSharpLight = 3, kLobe = 6, kRoulette = 9, kSubsurface = 10;

/// The walk goes straight on. False at the limit of transparent surfaces.
bool pass_through(const Scene& scene, EyeMedia& media, EyeWalk& walk, DirectVertex& origin) {
  origin.past_ray_kinds |= scene.depends_on_ray_kind(walk.hit);
  media.leave(walk, walk.ray.direction);
  return walk.pass_through();
}

/// The walk leaves a surface in a sampled direction.
void leave_along(EyeMedia& media, EyeWalk& walk, Vec3 wi) {
  media.leave(walk, wi);
  media.scattered_at_surface();
  walk.leave_along(wi);
}

/// The bounces of a walk that has reached `point`.
BounceCounts bounces_of(const ShadingPoint& point, const EyeMedia& media) {
  return {point.ray_depth, point.diffuse_depth, point.glossy_depth, point.transmission_depth, media.bounces()};
}

/// Whether the sharp lobes of a place can be ones from which walks find light that photons do not bring.
bool may_find_light(const ShadingPoint& point) { return on_strand_or_point(point) || bends_normal(point, point.wo); }

}  // namespace

Color PhotonGatherer::direct_light(const ShadingPoint& point, const Bsdf& bsdf, const Place& place, Sampler& sampler,
                                   uint32_t dimension, SampledLight* sampled) {
  if (log_only_ || scene_.lights().empty() || !bsdf.has_non_delta()) return Color(0.0f);
  DirectVertex unused;
  return estimate_direct_through(place.media, place.hit, direct_, {scene_, point, bsdf, 0, 0, 0, nullptr, sampled},
                                 {sampler, dimension, unused, nullptr, rays_});
}

Color PhotonGatherer::partial_light(const ShadingPoint& point, const Bsdf& bsdf, const Place& place, Sampler& sampler,
                                    uint32_t dimension) {
  sampler.set_dimension(dimension);
  const Vec3 numbers = sampler.get_3d();
  const Vec2 u(numbers);
  const LightSet::Choice choice = scene_.lights().choose(point.position, bsdf.receiving_normal(), numbers.z,
                                                         receiver_set(point));
  if (!(choice.pmf > 0.0f) || !scene_.lights().flags(choice.light).partial()) return Color(0.0f);
  return estimate_direct_through(place.media, place.hit, {scene_, point, bsdf}, choice, u, rays_);
}

bool PhotonGatherer::below_surface(EyeWalk& walk, Numbers numbers, Color& beta) {
  if (!walk.shading.bsdf.has_subsurface() || on_strand_or_point(walk.point)) [[likely]]
    return true;
  logs_ = false;
  numbers.sampler.set_dimension(numbers.dimension);
  return walk_below_or_stay(scene_, walk.hit.instance,
                            {numbers.sampler.get_1d(), hash_combine(pixel_, numbers.dimension)}, walk.point,
                            walk.shading, beta, rays_);
}

std::optional<BsdfSample> PhotonGatherer::sample_sharp(const Bsdf& sharp, Vec3 wo, Numbers numbers) {
  numbers.sampler.set_dimension(numbers.dimension);
  const Vec3 u = numbers.sampler.get_3d();
  return sharp.sample(wo, u.z, Vec2(u));
}

Color PhotonGatherer::trace(Ray ray, SampleAux* aux, float& alpha, Color& seen) {
  Color radiance(0.0f), beta(1.0f);
  EyeWalk walk(scene_, ray, rays_);
  ShadingPoint& point = walk.point;
  const SurfaceShading& shading = walk.shading;
  DirectVertex origin;
  EyeMedia media(scene_, media_, EyeMedia::around_camera(media_, ray), hash_combine(pixel_, index_), rays_);
  media.guide(guide_);
  // In a scene with media, all light counts as radiance.
  bool at_bounce_limit = false, specular = !media.active();
  const WalkHitWeight weight_of_hit{scene_, direct_, media, walk, origin};
  const auto add = [&](Color light, bool of_environment) {
    (specular ? seen : radiance) += light;
    if (!specular && !in_media_) direct_paths_ += light;
    if (passes_) [[unlikely]]
      add_to_passes(light, point.ray_depth, of_environment);
  };
  alpha = 0.0f;
  seen = Color(0.0f);
  polished_ = in_media_ = false;
  for (uint32_t vertex = 0;; ++vertex) {
    walk.trace();
    const auto add_met = [&](const LightMet& met) {
      add(beta * met.radiance * media.to_lamp(walk, met) * weight_of_hit(met.light, met.position, met.normal),
          walk.seen_directly() && int(met.light) == scene_.lights().environment_index());
    };
    walk.meet_lamps(add_met);
    if (media.active()) [[unlikely]] {
      const auto step = pass_media(media, walk, vertex, !at_bounce_limit, beta, radiance, alpha);
      if (step == EyeMedia::Step::End) break;
      at_bounce_limit = at_bounce_limit || past_limits(point, scene_.settings().bounces) || media.at_limit();
      if (step == EyeMedia::Step::Traced) continue;
    }
    if (!walk.found()) {
      walk.meet_distant(add_met);
      alpha += record_nothing(scene_, walk, beta, aux);
      break;
    }
    if (!walk.arrive()) break;
    point.channel_weights = glm::abs(beta);
    walk.shade();
    if (!is_black(shading.emission)) add(beta * shading.emission * walk.emission_weight(weight_of_hit), false);
    record_vertex(scene_, point, shading.bsdf, beta, aux);
    if (passes_ && point.ray_depth == 0) [[unlikely]]
      passes_->add_color(shading.bsdf, beta);
    const Color transparency = shading.bsdf.transparency();
    if (point.ray_depth == 0) alpha += walk.alpha_of_surface(beta, transparency);
    if (at_bounce_limit && is_black(transparency)) break;
    const uint32_t base = kCameraDimensions + kVertexDimensions * vertex;
    const bool all_sharp = stores_nothing(walk);
    if (!at_bounce_limit && !below_surface(walk, {sampler_, base + kSubsurface}, beta)) break;
    const LobeSplit split(shading.bsdf, point.wo, all_sharp);
    if (!at_bounce_limit) radiance += at_seen(point, split, {media, walk.hit}, beta, base);
    if (!split.sharp()) break;

    const auto sample = sample_sharp(*split.sharp(), point.wo, {sampler_, base + kLobe});
    if (!sample || !(sample->pdf_solid_angle > 0.0f)) break;
    beta *= sample->f_cos / sample->pdf_solid_angle;
    if (!(max_component(beta) > 0.0f)) break;
    if (sample->flags & kTransparent) {
      if (!pass_through(scene_, media, walk, origin)) break;
      continue;
    }
    if (at_bounce_limit) break;
    if (passes_ && point.ray_depth == 0) [[unlikely]]
      first_ = sample->specular ? LightPasses::specular(sample->flags & kTransmission)
                                : LightPasses::scattered_by(*split.sharp(), point.wo, sample->wi);
    count_bounce(*sample, point, point);
    at_bounce_limit = past_limits(point, scene_.settings().bounces);
    if (point.ray_depth > 2 &&
        !survives(std::min(1.0f, std::sqrt(max_component(beta))), sampler_, base + kRoulette, beta))
      break;
    specular = specular && sample->specular;
    polished_ |= specular;
    origin = vertex_of({}, point, *split.sharp(), *sample);
    leave_along(media, walk, sample->wi);
  }
  return radiance;
}

Color PhotonGatherer::at_seen(const ShadingPoint& point, const LobeSplit& split, const Place& place, Color beta,
                              uint32_t base) {
  Color sum(0.0f);
  if (split.rough()) {
    // The number of gather rays at a surface that is seen by reflection is in proportion to the throughput.
    const int rays = std::max(1, int(std::ceil(float(settings_.rays) * std::min(1.0f, max_component(beta)))));
    sum = beta * reflected(point, *split.rough(), place, beta, rays, 0, {sampler_, base + kRoughLight});
    if (passes_ && point.ray_depth > 0) [[unlikely]]
      add_to_passes(sum, point.ray_depth + 1);
  }
  if (split.sharp()) {
    SampledLight sampled;
    const Color light = beta * direct_light(point, *split.sharp(), place, sampler_, base + kSharpLight, &sampled);
    sum += light;
    if (!in_media_) direct_paths_ += light;
    if (passes_) [[unlikely]]
      add_to_passes(light, point.ray_depth + 1, *split.sharp(), point, sampled.wi);
  }
  return sum;
}

Color PhotonGatherer::reflected(const ShadingPoint& point, const Bsdf& rough, const Place& place, Color throughput,
                                int rays, int depth, Numbers numbers) {
  const auto [sampler, dimension] = numbers;
  const bool separates = passes_ && depth == 0 && point.ray_depth == 0;
  SampledLight sampled;
  Color sum = direct_light(point, rough, place, sampler, dimension, &sampled), direct_gathered(0.0f);
  const Color direct_sampled = sum;
  if (separates) [[unlikely]]
    add_to_passes(throughput * sum, 1, rough, point, sampled.wi);
  if (log_ && depth == 0 && (pixel_ + index_) % uint32_t(log_->stride[ArrivalMap::kSeen]) == 0)
    log_arrival(ArrivalMap::kSeen, point, throughput);
  if (maps_.has_caustic) {
    const auto lookup = settings_.caustic_lookup(maps_.caustic_radius, bounces_of(point, place.media));
    const Color caustic = maps_.caustic.radiance(point, rough, lookup);
    sum += caustic;
    if (separates) [[unlikely]]
      passes_->add(
          passes_->part_of(2, LightPasses::scattered(rough, maps_.caustic.radiance_of_kinds(point, rough, lookup))),
          throughput * caustic);
  }
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
    const GatherNumbers u(own, base, guided.guided());
    float pdf_bsdf;
    const auto sample = guided.sample(point.wo, u.guide, u.lobe, u.direction, pdf_bsdf);
    if (!sample || !(sample->pdf_solid_angle > 0.0f) || is_black(sample->f_cos)) continue;
    ++gathered_;
    const Color weight = sample->f_cos / sample->pdf_solid_angle;
    const bool logged = depth == 0 && logs_gather_ray(uint32_t(i));
    const bool logs = logs_;
    DirectVertex origin = vertex_of({}, point, rough, *sample);
    origin.bsdf_pdf = pdf_bsdf;
    const Incoming arriving = incoming(point, place, *sample, origin,
                                       logged ? throughput * weight / float(rays) : Color(0.0f), depth,
                                       {own, base + kGatherDimensions});
    logs_ = logs;
    const Color direct = weight * arriving.direct, indirect = weight * arriving.scattered, found = direct + indirect;
    gathered += found;
    direct_gathered += direct;
    if (separates) [[unlikely]] {
      const Color share = throughput / float(rays);
      add_to_passes(share * direct, 1, rough, point, sample->wi);
      add_to_passes(share * indirect, 2, rough, point, sample->wi);
    }
    if (depth == 0)
      learn_from({point.position, rough.n, sample->wi, 0.0f, luminance(found), pdf_bsdf, guided.kind()},
                 arriving.distance, index_ * uint32_t(rays) + uint32_t(i));
  }
  if (depth == 0 && !in_media_) direct_paths_ += throughput * (direct_sampled + direct_gathered / float(rays));
  return sum + gathered / float(rays);
}

void PhotonGatherer::learn_from(GuideSample sample, float distance, uint32_t number) {
  if (!guide_samples_ || !(sample.weight > 0.0f) || hash_combine(pixel_, number) % guide_stride_ != 0) return;
  if (distance > 0.0f) sample.inverse_distance = 1.0f / distance;
  guide_samples_->push_back(sample);
}

MediaStack PhotonGatherer::stack_towards(const ShadingPoint& from, const Place& place, Vec3 direction) const {
  if (!place.media.active()) return {};
  MediaStack stack = place.media.state().stack;
  if (glm::dot(direction, from.ng) < 0.0f) media_->cross(place.hit, !from.backfacing, stack);
  return stack;
}

Color PhotonGatherer::at_rough(const ShadingPoint& point, const Bsdf& rough, const Place& place, int depth,
                               Numbers numbers) {
  const auto [sampler, dimension] = numbers;
  if (depth > 0) return reflected(point, rough, place, Color(0.0f), 1, depth, {sampler, dimension + kVertexDimensions});
  Color radiance = maps_.has_global ? from_map(point, rough, bounces_of(point, place.media)) : Color(0.0f);
  if (scene_.depends_on_ray_kind()) [[unlikely]]
    radiance += light_past_ray_kinds(point, rough, place, dimension);
  if ((settings_.light_without_photons || settings_.beyond_terminator > 0.0f) && !log_only_)
    radiance += light_without_photons(point, rough, place, dimension);
  if (scene_.lights().any_partial()) radiance += partial_light(point, rough, place, sampler, dimension + kRoughLight);
  return radiance;
}

Color PhotonGatherer::sharp_light(const ShadingPoint& point, const LobeSplit& split, const Place& place, bool all,
                                  Numbers numbers) {
  return all ? direct_light(point, *split.sharp(), place, numbers.sampler, numbers.dimension)
             : light_beyond(point, *split.sharp(), place, numbers.dimension);
}

bool PhotonGatherer::stores_nothing(const EyeWalk& walk) {
  if (!scene_.is_eye_only(walk.hit)) return on_strand_or_point(walk.point);
  logs_ = false;
  return true;
}

PhotonGatherer::Incoming PhotonGatherer::incoming(const ShadingPoint& from, const Place& place, const BsdfSample& first,
                                                  const DirectVertex& origin, Color throughput, int depth,
                                                  Numbers numbers) {
  EyeWalk walk(scene_, scene_.spawn_ray(from, first.wi), rays_, from);
  EyeMedia media(scene_, media_, stack_towards(from, place, first.wi),
                 hash_combine(hash_combine(pixel_, index_), numbers.dimension + uint32_t(gathered_)), rays_,
                 place.media.bounces());
  media.guide(guide_);
  count_bounce(first, from, walk.point);
  const Incoming found = follow(walk, media, origin, throughput, depth, numbers);
  if (settings_.beyond_terminator > 0.0f) beyond_.note_sample(found.direct + found.scattered);
  return found;
}

PhotonGatherer::Incoming PhotonGatherer::follow(EyeWalk& walk, EyeMedia& media, DirectVertex origin, Color throughput,
                                                int depth, Numbers numbers) {
  const auto [sampler, dimension] = numbers;
  const BounceLimits& limits = scene_.settings().bounces;
  Incoming result;
  Color beta(1.0f), &radiance = result.scattered;
  ShadingPoint& point = walk.point;
  const SurfaceShading& shading = walk.shading;
  bool at_bounce_limit = past_limits(point, limits) || media.at_limit();
  const bool look_up = looks_up();
  const int first_depth = point.ray_depth;
  const Vec3 start = walk.ray.origin;
  const auto emitted = [&]() -> Color& { return point.ray_depth == first_depth ? result.direct : radiance; };
  const WalkHitWeight weight_of_hit{scene_, direct_, media, walk, origin};
  // Straight: no sharp bounce, after which light is a caustic of the map, unless media, hair or points scatter it.
  bool straight = true, finds_all = false;
  float length = -media.way();
  for (uint32_t vertex = 0;; ++vertex) {
    const uint32_t base = dimension + kVertexDimensions * vertex;
    walk.trace();
    const auto add_met = [&](const LightMet& met) {
      emitted() += beta * met.radiance * media.to_lamp(walk, met) * weight_of_hit(met.light, met.position, met.normal);
    };
    if (straight) walk.meet_lamps(add_met);
    if (media.active()) [[unlikely]] {
      EyeMedia::Light light;
      Color& emitted_here = emitted();
      const EyeMedia::Step step = media.pass(
          walk, {sampler, kMediaDimensions + EyeMedia::kDimensions * base, !at_bounce_limit, true}, beta, light);
      emitted_here += light.emitted;
      radiance += light.scattered;
      if (step == EyeMedia::Step::End) break;
      at_bounce_limit = at_bounce_limit || media.at_limit();
      if (media.chose_direction()) straight = finds_all = true;
      if (step == EyeMedia::Step::Traced && !(result.distance > 0.0f) && point.ray_depth > first_depth)
        result.distance = glm::length(media.place() - start);
      if (step == EyeMedia::Step::Traced) continue;
    }
    if (straight && !walk.found()) walk.meet_distant(add_met);
    if (!walk.found()) break;
    walk.arrive();
    length += walk.hit.t;
    walk.shade();
    if (!(result.distance > 0.0f) && !shading.bsdf.is_clear())
      result.distance = vertex == 0 ? walk.hit.t : glm::length(point.position - start);
    if (!is_black(shading.emission) && (straight || scene_.light_of(walk.hit) < 0))
      emitted() += beta * shading.emission * walk.emission_weight(weight_of_hit);
    if (at_bounce_limit && !shading.bsdf.empty() && is_black(shading.bsdf.transparency())) break;
    const bool all_sharp = stores_nothing(walk);
    if (!look_up && !log_ && is_black(shading.bsdf.transparency()) && !finds_all && !may_find_light(point)) break;
    if (!at_bounce_limit && !below_surface(walk, {sampler, base + kSubsurface}, beta)) break;
    const LobeSplit split(shading.bsdf, point.wo, all_sharp);
    if (split.rough() && !at_bounce_limit && log_) log_gathered(start, point, throughput * beta);
    if (split.rough() && !at_bounce_limit && look_up) {
      const bool near = straight && depth < 2 && length + media.way() < kNear * maps_.global_radius;
      radiance += beta * at_rough(point, *split.rough(), {media, walk.hit}, near ? depth + 1 : 0, {sampler, base});
    }
    if (!split.sharp()) break;
    finds_all = finds_all || all_sharp || seen_by_bent_lobes(point, *split.sharp(), point.wo);
    if (!at_bounce_limit)
      radiance += beta * sharp_light(point, split, {media, walk.hit}, finds_all, {sampler, base + kSharpLight});
    const auto sample = sample_sharp(*split.sharp(), point.wo, {sampler, base + kLobe});
    if (!sample || !(sample->pdf_solid_angle > 0.0f)) break;
    beta *= sample->f_cos / sample->pdf_solid_angle;
    if (sample->flags & kTransparent) {
      if (!(max_component(beta) > 0.0f) || !pass_through(scene_, media, walk, origin)) break;
      straight = straight || origin.past_ray_kinds;
      continue;
    }
    straight = finds_all;
    origin = vertex_of({}, point, *split.sharp(), *sample);
    if (at_bounce_limit || !(look_up || finds_all)) break;
    count_bounce(*sample, point, point);
    at_bounce_limit = past_limits(point, limits);
    if (at_bounce_limit && !straight) break;
    if (!survives(std::min(1.0f, max_component(beta)), sampler, base + kRoulette, beta)) break;
    leave_along(media, walk, sample->wi);
  }
  return result;
}

void PhotonGatherer::add_to_passes(Color light, int bounces, bool of_environment) {
  PathPasses passes = passes_->part_of(bounces, first_);
  if (of_environment) passes.part = PathPasses::Part::Environment;
  passes_->add(passes, light);
}

void PhotonGatherer::add_to_passes(const EyeMedia::Light& light, int bounces) {
  add_to_passes(light.emitted, bounces);
  PathPasses volume = first_;
  if (bounces == 0) volume.part = PathPasses::Part::VolumeDirect;
  passes_->add(passes_->part_of(bounces + 1, volume), light.scattered);
}

void PhotonGatherer::add_to_passes(Color light, int bounces, const Bsdf& bsdf, const ShadingPoint& point, Vec3 wi) {
  if (is_black(light)) return;
  const bool is_first = point.ray_depth == 0;
  passes_->add(passes_->part_of(bounces, is_first ? LightPasses::scattered_by(bsdf, point.wo, wi) : first_), light);
}

bool PhotonGatherer::find_rough(Ray ray, ShadingPoint& point, SurfaceShading& shading) {
  EyeWalk walk(scene_, ray, rays_, point);
  for (int vertex = 0; vertex < 16; ++vertex) {
    walk.trace();
    if (!walk.found()) return false;
    walk.arrive();
    const ShaderProgram& program = scene_.material(walk.hit);
    if (program.only_encloses()) {
      walk.pass_uncounted();
      continue;
    }
    walk.shade();
    point = walk.point;
    shading = walk.shading;
    const LobeSplit split(shading.bsdf, point.wo, on_strand_or_point(point));
    if (split.rough()) return true;
    if (!split.sharp()) return false;
    const Vec3 u = sampler_.get_3d();
    const auto sample = split.sharp()->sample(point.wo, u.z, Vec2(u));
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
  seen = surface_point(point, point.ng);
  const Vec3 u = sampler_.get_3d();
  const auto sample = LobeSplit(shading.bsdf, point.wo).rough()->sample(point.wo, u.z, Vec2(u));
  if (!sample) return false;
  count_bounce(*sample, point, point);
  if (!find_rough(scene_.spawn_ray(point, sample->wi), point, shading)) return false;
  gathered = surface_point(point, point.ng);
  return true;
}

void PhotonGatherer::log_gathered(Vec3 start, const ShadingPoint& point, Color throughput) {
  if (length_squared(point.position - start) >= sqr(settings_.shortest_logged))
    log_arrival(ArrivalMap::kGathered, point, throughput);
}

void PhotonGatherer::log_arrival(int place, const ShadingPoint& point, Color throughput) {
  const float y = luminance(throughput) * float(log_->stride[place]);
  if (logs_ && y > 0.0f)
    log_->at[place].push_back({surface_point(point, point.ng), y, hash_combine(pixel_, index_) & 1u});
}

Color PhotonGatherer::from_map(const ShadingPoint& point, const Bsdf& rough, const BounceCounts& bounces) {
  Color irradiance;
  if (is_plain_lambert(rough) &&
      maps_.sites.find(point.position, point.ng, 0.5f * maps_.global_radius, bounces, irradiance)) {
    ++from_sites_;
    return rough.lobe(0).weight * kInvPi * irradiance;
  }
  return maps_.global.radiance(point, rough, {settings_.gather_neighbours, maps_.global_radius, 0, {}, bounces});
}

}  // namespace ajar
