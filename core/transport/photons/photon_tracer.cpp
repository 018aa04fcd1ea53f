#include "transport/photons/photon_tracer.h"

#include <algorithm>
#include <optional>

#include <tbb/parallel_for.h>

#include "lights/sources/lamp.h"
#include "sampling/sampler.h"
#include "transport/direct/lobe_split.h"
#include "transport/media/path_media.h"
#include "transport/paths/walk.h"
#include "transport/photons/photon_directions.h"
#include "transport/photons/photon_lookups.h"

namespace ajar {

namespace {

constexpr uint32_t kBlock = 512;                                      // photon paths in a task
constexpr uint32_t kEmissionDimensions = 5, kBounceDimensions = 5;    // of a bounce: event, lobe, direction, roulette
constexpr uint32_t kMediaDimension = 4096, kMediaDimensions = 8;      // for each ray
constexpr uint32_t kChanceDimension = 16384, kSideDimension = 20480;  // plus the vertex

/// Rounding can place the start of a ray from a triangle below the triangle.
Ray leave_light(const LightSet& lights, uint32_t index, const LightRay& start) {
  Ray ray = start.ray;
  const LightFlags flags = lights.flags(index);
  if (flags.soft) ray.origin = soft_lamp_start(lights.light(index), ray.origin, ray.direction);
  if (flags.type != LightType::Triangle) return ray;
  const Light light = lights.light(index, ray.time);
  const Vec3 extent = glm::abs(light.position) + glm::abs(light.edge1) + glm::abs(light.edge2);
  const float error = 16.0f * 0x1p-24f * max_component(extent);
  ray.origin += start.normal * (glm::dot(start.normal, ray.direction) < 0.0f ? -error : error);
  return ray;
}

class BlockTracer {
 public:
  BlockTracer(const Scene& scene, const PathMedia* media, const PhotonEmission& emission)
      : scene_(scene),
        media_(media),
        emission_(emission),
        sampler_(Sampler::Kind::Sobol, hash_combine(emission.seed, 0x70686f74U)) {}

  void trace(uint32_t index, PhotonBatch& out) {
    const LightSet& lights = scene_.lights();
    sampler_.start(emission_.pass, index);
    float u_choice = sampler_.get_1d();
    const Vec2 u_position = sampler_.get_2d(), u_direction = sampler_.get_2d();
    const LightWalkGuide* guide = emission_.guide;
    uint32_t light;
    float pmf;
    std::optional<LightRay> start;
    if (guide && guide->sets_out(u_choice)) {
      start = start_along(guide->start(lights, u_choice, u_position, u_direction), light);
      pmf = lights.power_pmf(light);
    } else {
      const auto choice = lights.choose_by_power(u_choice);
      light = choice.light;
      pmf = choice.pmf;
      if (pmf > 0.0f) start = lights.sample_le(light, u_position, u_direction, emission_.time);
    }
    if (!start) return;
    flags_ = lights.flags(light);
    soft_lamp_.reset();
    if (flags_.soft) soft_lamp_ = lights.light(light);
    fading_.reset();
    if (lights.depends_on_distance(light)) fading_ = {light, *start};
    LightEnd end;
    const bool distant = is_distant(flags_.type);
    end.pdf_origin = pmf * (distant ? start->pdf_solid_angle : start->pdf_area);
    end.pdf_direction = distant ? start->pdf_area : start->pdf_solid_angle;
    const double without = double(end.pdf_origin) * double(end.pdf_direction);
    if (guide) guide->mix(lights, light, start->ray.origin, start->normal, start->ray.direction, end);
    Color flux = start->radiance * (abs_dot(start->normal, start->ray.direction) /
                                    (end.pdf_origin * end.pdf_direction * float(emission_.count)));
    if (is_black(flux) || !is_finite(flux)) return;
    for (int c = 0; c < 3; ++c) out.emitted[c] += double(flux[c]);
    const Ray ray = leave_light(lights, light, *start);
    if (media_) {
      stack_ = media_->around(ray.origin, ray.time);
      // The volume of the world has no end: light from infinity is lost in it.
      if (distant && media_->fills_world()) return;
    }
    start_ = *start;
    light_index_ = light;
    past_ray_kinds_ = false;
    value_ = 0.0;
    sharp_first_ = false;
    entry_ = start->ray.origin;
    walk(ray, flux, out);
    if (value_ > 0.0)
      out.values.push_back({{light, distant ? entry_ : start->ray.origin, start->ray.direction, float(value_)},
                            float(double(end.pdf_origin) * double(end.pdf_direction) / without),
                            sharp_first_});
  }

 private:
  /// The ray that sample_le would return for this start.
  std::optional<LightRay> start_along(const LightWalkGuide::Start& start, uint32_t& light) {
    const LightSet& lights = scene_.lights();
    light = start.light;
    make_light_vertex(scene_, light, start.position, start.normal, start.direction, emission_.time, light_);
    LightRay r;
    r.ray.origin = light_.position();
    r.ray.direction = start.direction;
    r.ray.time = emission_.time;
    r.normal = light_.delta ? start.direction : light_.point.ng;
    if (light_.program)
      r.radiance = light_.shading.emission;
    else if (int(light) == lights.environment_index())
      r.radiance = lights.environment_radiance(-start.direction, 0);
    else
      r.radiance = lights.lamp_radiance(light, start.position, start.direction, emission_.time, kUsualDistance);
    r.barycentric = light_.point.barycentric;
    if (light_.program && light_.program->emission_depends_on_distance()) {
      light_.point.ray_length = kUsualDistance;
      r.radiance = light_.program->evaluate_emission(light_.point);
    }
    const LightSet::LePdf pdf = lights.pdf_le(light, light_.point.ng, start.direction, emission_.time);
    r.pdf_area = pdf.pdf_area;
    r.pdf_solid_angle = light_.delta && light_.distant ? 1.0f : pdf.pdf_solid_angle;
    if (is_sphere(lights.flags(light).type) && !(glm::dot(r.normal, start.direction) > 0.0f)) return {};
    return r;
  }

  void walk(Ray ray, Color flux, PhotonBatch& out) {
    const BounceLimits& limits = scene_.settings().bounces;
    PhotonBounces bounces;
    ShadingPoint point;
    uint32_t kind = scene_.shadow_kind(ray);
    crossed_ = 0;
    beyond_other_ = false;
    for (uint32_t vertex = 0;; ++vertex) {
      const Hit hit = scene_.intersect(ray, kind);
      ++out.rays;
      if (media_) [[unlikely]] {
        sampler_.set_dimension(kMediaDimension + kMediaDimensions * vertex);
        const InMedia outcome = pass_media(ray, hit, point, bounces.counts.total == 0, flux);
        if (outcome == InMedia::End) return;
        if (outcome == InMedia::Scattered) {
          bounces.add_volume();
          if (past_ray_kinds_ || !may_be_global(bounces, limits)) return;
          kind = kRayVolumeScatter;
          continue;
        }
      }
      if (!hit.found()) return;
      scene_.shading_point(ray, hit, point);
      if (vertex == 0) entry_ = point.position;
      if (media_ && scene_.material(hit).only_encloses()) {
        media_->cross(hit, !point.backfacing, stack_);
        ray = scene_.straight_on(point, ray, hit.t);
        continue;
      }
      const bool first = bounces.counts.total == 0, blocks = !first || blocks_light(hit);
      const AtSurface outcome = pass_unscattered(hit, vertex, point, {first, blocks}, ray, flux);
      if (outcome == AtSurface::End) return;
      if (outcome == AtSurface::Passed) continue;
      point.ray_kind = kRayDiffuse | kRayReflection;
      point.ray_depth = point.diffuse_depth = 1;
      point.after_diffuse = true;
      point.channel_weights = glm::abs(flux);
      scene_.material(hit).evaluate_surface(point, shading_);
      const Side side = side_of_sphere(ray, hit, vertex, point, flux);
      const LobeSplit split(shading_.bsdf, point.wo, on_strand_or_point(point));
      // Lookups would not separate the kinds of lobes that see the light: they sample such a light themselves, and light
      // past surfaces that depend on the kind of the ray.
      const bool separated = flags_.partial() && first;
      const bool lit = is_lit(point.position, ray.direction) && (!first || flags_.lights(receiver_set(point)));
      const Color faded = first ? faded_at(point.ray_length) : Color(1.0f);
      flux *= faded;
      if (split.rough() && !separated && lit && !past_ray_kinds_)
        store(point, *split.rough(), flux, bounces, limits, out);

      sampler_.set_dimension(kEmissionDimensions + kBounceDimensions * vertex);
      const auto sample = scatter(scene_.material(hit), point, split, flux);
      if (!sample) return;
      if (sample->flags & kTransparent) {
        // Counted above, on the near side, or by hits of lights.
        if (!blocks || side == Side::Far || (first && scene_.depends_on_ray_kind(hit))) return;
        for (int c = 0; c < 3; ++c) flux[c] = faded[c] != 0.0f ? flux[c] / faded[c] : 0.0f;
        if (++crossed_ > limits.transparent) return;
        if (media_) media_->cross(hit, !point.backfacing, stack_);
        ray = scene_.straight_on(point, ray, hit.t);
        continue;
      }
      if (!lit || goes_inwards(point, side, sample->wi) || (beyond_other_ && !was_rough_))
        return;  // sharp lobes see lights past nothing (LightFlags::partial)
      beyond_other_ = false;
      if (past_ray_kinds_) [[unlikely]] {
        if (sample->specular) return;  // shadow rays end at other lobes only
        flux *= weight_past_kinds(scene_.material(hit), point, sample->wi);
        past_ray_kinds_ = false;
        bounces.past_ray_kinds = true;
      }
      if (first) sharp_first_ = !was_rough_;
      soft_lamp_.reset();
      if (separated && !keep_visible(point, *(was_rough_ ? split.rough() : split.sharp()), *sample, flux)) return;
      bounces.add(*sample);
      bounces.only_sharp &= is_caustic(point, split, sample->wi);
      if (!may_be_global(bounces, limits) && !bounces.caustic(limits)) return;
      kind = ray_kind_after(*sample);
      ray = leave(point, hit, side, sample->wi);
    }
  }

  /// Whether the surface blocks the light of the photon. Those that are hidden from shadow rays count as transparent.
  bool blocks_light(const Hit& hit) const {
    if (!flags_.cast_shadow) return false;
    return (scene_.instances()[hit.instance].visibility & flags_.blockers) ||
           (flags_.blockers == kVisibleShadow && scene_.hidden_from_shadow_rays(hit));
  }

  /// Of a ray at a surface: nothing has scattered the photon before; the surface blocks its light.
  struct Arrival {
    bool first, blocks;
  };
  enum class AtSurface : uint8_t { Scatters, Passed, End };
  /// Whether the photon passes the surface, straight on, without regard to how the surface scatters. `ray` goes on then.
  AtSurface pass_unscattered(const Hit& hit, uint32_t vertex, const ShadingPoint& point, Arrival arrival, Ray& ray,
                             Color& flux) {
    if (arrival.blocks && !scene_.depends_on_ray_kind(hit)) [[likely]]
      return AtSurface::Scatters;
    sampler_.set_dimension(kChanceDimension + vertex);
    if (arrival.blocks) {
      Through through;
      through.surfaces = crossed_;
      const bool past = arrival.first && passes_as_shadow(scene_, hit, point, sampler_, through);
      crossed_ = through.surfaces;
      flux *= through.transmittance / (through.pass * through.chance);
      if (!past) return scene_.is_eye_only(hit) ? AtSurface::End : AtSurface::Scatters;
      past_ray_kinds_ = true;
    } else {
      // What does not block the light is lit by it, and so is what is behind. Lookups sample it on eye-only surfaces.
      if (!scene_.is_eye_only(hit)) {
        flux *= 2.0f;
        if (!(sampler_.get_1d() < 0.5f)) return AtSurface::Scatters;
      }
      beyond_other_ = true;
    }
    if (media_) media_->cross(hit, !point.backfacing, stack_);
    ray = scene_.straight_on(point, ray, hit.t);
    return AtSurface::Passed;
  }
  /// weight_past_ray_kinds of the first ray, which ends at `point`, of light that goes on along `to_eye`.
  float weight_past_kinds(const ShaderProgram& program, const ShadingPoint& point, Vec3 to_eye) {
    make_light_vertex(scene_, light_index_, start_.ray.origin, start_.normal, start_.ray.direction, point.time, light_);
    PathVertex place;
    place.point = turned_towards(point, to_eye);
    place.program = &program;
    program.evaluate_surface(place.point, place.shading);
    const PathEdge edge = join(light_, place);
    return weight_past_ray_kinds(light_end(scene_, light_, place, edge, nullptr), edge,
                                 place.shading.bsdf.evaluate(to_eye, point.wo).pdf_solid_angle);
  }

  bool may_be_global(const PhotonBounces& bounces, const BounceLimits& limits) const {
    return emission_.plan.global && bounces.global(limits, emission_.plan.rough_glossy);
  }
  /// Whether the caustic map has the light that was scattered last, if it had all light before.
  bool is_caustic(const ShadingPoint& point, const LobeSplit& split, Vec3 to_eye) const {
    return !was_rough_ && !on_strand_or_point(point) && !seen_by_bent_lobes(point, *split.sharp(), to_eye);
  }

  enum class Side : uint8_t { Any, Near, Far };
  /// On a point of a cloud that transmits light: paths from the eye leave it inwards unhindered (points.h), so that light
  /// is scattered outwards both where it arrives and where it would leave on the far side. Half of the photons, with
  /// twice their flux, take either side. `point` and `shading_` become those of the side.
  Side side_of_sphere(const Ray& ray, const Hit& hit, uint32_t vertex, ShadingPoint& point, Color& flux) {
    if (!point.mesh->points || !transmits(shading_.bsdf)) return Side::Any;
    flux *= 2.0f;
    sampler_.set_dimension(kSideDimension + vertex);
    const float way = way_out(point, ray.direction);
    if (sampler_.get_1d() < 0.5f || !(way > 0.0f)) return Side::Near;
    Ray back = ray;
    back.origin = point.position + 2.0f * way * ray.direction;
    back.direction = -ray.direction;
    back.travelled += hit.t + way;
    Hit far = hit;
    far.t = 0.0f;
    scene_.shading_point(back, far, point);
    point.wo = -ray.direction;
    point.ng = -point.ng;
    point.ns = -point.ns;
    point.backfacing = true;
    scene_.material(hit).evaluate_surface(point, shading_);
    return Side::Far;
  }

  /// Of a place on a sphere that side_of_sphere has chosen: the photon would go into the sphere.
  static bool goes_inwards(const ShadingPoint& point, Side side, Vec3 direction) {
    return side != Side::Any && (glm::dot(direction, point.ng) > 0.0f) != (side == Side::Near);
  }
  Ray leave(const ShadingPoint& point, const Hit& hit, Side side, Vec3 direction) {
    if (media_ && side == Side::Any && glm::dot(direction, point.ng) < 0.0f)
      media_->cross(hit, !point.backfacing, stack_);
    return scene_.spawn_ray(point, direction);
  }

  /// Whether the light that a photon brings on its first ray illuminates p.
  bool is_lit(Vec3 p, Vec3 direction) const { return !soft_lamp_ || soft_lamp_distance(*soft_lamp_, p, -direction); }

  /// The factor of the shader of the photon's light for a point at this distance.
  Color faded_at(float distance) const {
    return fading_ ? scene_.lights().falloff(fading_->first, fading_->second, distance) : Color(1.0f);
  }

  enum class InMedia : uint8_t { Passed, Scattered, End };
  /// The media up to the hit. `from_light`: nothing has scattered the photon before. If it scatters, `ray` is the new one.
  InMedia pass_media(Ray& ray, const Hit& hit, const ShadingPoint& point, bool from_light, Color& flux) {
    if (!hit.found() || stack_.empty()) return hit.found() ? InMedia::Passed : InMedia::End;  // nothing stores it
    MediaStretch stretch;
    MediumPoint at;
    float t;
    const MediaRay along{stack_, ray, hit.t, point, kRayDiffuse, from_light ? kRayShadow : 0u};
    const bool scatters = media_->sample(along, sampler_, stretch, t, at);
    Color after = flux * stretch.transmittance / stretch.pass;
    Vec3 direction = ray.direction;
    if (scatters) {
      if (!at.scatters()) return InMedia::End;
      const PhaseFunction phase(at);
      const Vec3 u = sampler_.get_3d();
      direction = phase.sample(ray.direction, u.z, Vec2(u));
      const float cosine = glm::dot(ray.direction, direction);
      if (from_light) after *= faded_at(ray.travelled + t);
      after *= at.scattering * phase.evaluate(cosine) / (stretch.rate * phase.pdf_solid_angle(cosine));
    }
    const float survival = std::min(1.0f, max_component(glm::abs(after)) / max_component(glm::abs(flux)));
    if (!(survival > 0.0f) || !is_finite(after) || sampler_.get_1d() >= survival) return InMedia::End;
    flux = after / survival;
    if (!scatters) return InMedia::Passed;
    ray.origin += t * ray.direction;
    if (!is_lit(ray.origin, ray.direction) || (from_light && !flags_.lights(media_->media().receiver_set(stack_))))
      return InMedia::End;
    soft_lamp_.reset();
    ray.travelled = 0.0f;
    ray.direction = direction;
    ray.t_min = 0.0f;
    ray.t_max = kInfinity;
    return InMedia::Scattered;
  }

  void store(const ShadingPoint& point, const Bsdf& rough, Color flux, const PhotonBounces& bounces,
             const BounceLimits& limits, PhotonBatch& out) {
    const float cosine = glm::dot(point.wo, point.ng);
    if (!(cosine > 1e-6f)) return;
    const bool global = emission_.plan.global &&
                        bounces.global(limits, emission_.plan.rough_glossy, scatters_diffusely(rough)),
               caustic = emission_.plan.caustic && bounces.caustic(limits);
    const SeenFrom side = seen_from(rough, point.ng);
    if (emission_.values) {
      const double y = double(luminance(glm::abs(flux))) / double(cosine);
      if (caustic) value_ += y * std::sqrt(emission_.values->density(ArrivalMap::kSeen, point.position, side.normal));
      if (global)
        value_ += y * std::sqrt(emission_.values->density(ArrivalMap::kGathered, point.position, side.normal));
      return;
    }
    const Photon photon{surface_point(point, side.normal), flux / cosine,
                        pack_direction_short(point.wo) | kernels_.packed(point.ray_length) | side.flags,
                        bounces.left(limits)};
    if (caustic) out.caustic.push_back(photon);
    if (global) {
      out.global.push_back(photon);
      if (!scatters_evenly(rough)) out.global.back().left = photon.left.marked();
      if (emission_.site_stride > 0 && out.global.size() % emission_.site_stride == 0 && is_plain_lambert(rough))
        out.sites.push_back({photon.point, rough.n});
    }
  }

  /// Chooses the rough or the sharp lobes, draws a direction and updates `flux`. Russian roulette keeps the maximum
  /// component of `flux` constant, so that photons have about equal flux.
  std::optional<BsdfSample> scatter(const ShaderProgram& program, const ShadingPoint& point, const LobeSplit& split,
                                    Color& flux) {
    const Bsdf* bsdf = split.rough() ? split.rough() : split.sharp();
    if (!bsdf) return std::nullopt;
    float probability = 1.0f;
    bool rough = split.rough() != nullptr;
    float u_event = sampler_.get_1d();
    const Vec3 numbers = sampler_.get_3d();
    const float u_lobe = numbers.z;
    const Vec2 u_direction(numbers);
    const LightWalkGuide* guide = rough ? emission_.guide : nullptr;
    const float along_hints = guide ? guide->share_at(point.position) : 0.0f;
    const std::optional<Vec3> along = guide ? guide->direction_at(point.position, u_event, u_direction) : std::nullopt;
    if (split.rough() && split.sharp()) {
      const float a = luminance(split.rough()->albedo()),
                  b = luminance(split.sharp()->albedo() + split.sharp()->transparency());
      probability = a + b > 0.0f ? std::clamp(a / (a + b), 0.05f, 0.95f) : 0.5f;
      rough = along || u_event < probability;
      if (!rough) bsdf = split.sharp(), probability = 1.0f - probability;
    }
    const FlatDirections flat(point, *bsdf, rough);
    auto sample = along ? sample_of(*bsdf, point.wo, *along)
                  : flat.share() > 0.0f && (flat.share() == 1.0f || sampler_.get_1d() < flat.share())
                      ? sample_of(*bsdf, point.wo, flat.direction(u_lobe, u_direction))
                      : bsdf->sample(point.wo, u_lobe, u_direction, TransportMode::Importance);
    if (sample) sample->pdf_solid_angle = flat.mixed(sample->pdf_solid_angle, sample->wi);
    if (sample && along_hints > 0.0f) {
      sample->pdf_solid_angle *= 1.0f - along_hints;
      if (rough) sample->pdf_solid_angle += guide->pdf_at(point.position, sample->wi) / probability;
    }
    if (!sample || !(sample->pdf_solid_angle > 0.0f)) return std::nullopt;
    const Color scattered = flux * towards_eye(program, point, *bsdf, rough, *sample) /
                            (sample->pdf_solid_angle * probability);
    const float survival = std::min(1.0f, max_component(glm::abs(scattered)) / max_component(glm::abs(flux)));
    if (!(survival > 0.0f) || !is_finite(scattered) || sampler_.get_1d() >= survival) return std::nullopt;
    flux = scattered / survival;
    was_rough_ = rough;
    return sample;
  }

  /// f |cos| of the sample for light, by the lobes for the eye, which it approaches; `bsdf` was made for the light.
  Color towards_eye(const ShaderProgram& program, const ShadingPoint& point, const Bsdf& bsdf, bool rough,
                    const BsdfSample& sample) const {
    if (sample.flags & kTransparent) return sample.f_cos;
    if (sample.specular || !depends_on_view(program, point, bsdf, sample.wi)) [[likely]] {
      if (rough && glm::dot(sample.wi, bsdf.n) * glm::dot(sample.wi, point.ng) < 0.0f) [[unlikely]]
        return light_towards_eye(point, bsdf, sample.wi);
      return sample.f_cos * shading_normal_correction(bsdf, point.wo, sample.wi);
    }
    if (turns_to(program, point, bsdf, sample.wi))
      return light_towards_eye(point, turned_to(bsdf, sample.wi), sample.wi);
    SurfaceShading seen;
    program.evaluate_surface(turned_towards(point, sample.wi), seen);
    const LobeSplit split(seen.bsdf, sample.wi, on_strand_or_point(point));
    const Bsdf* lobes = rough ? split.rough() : split.sharp();
    return lobes ? light_towards_eye(point, *lobes, sample.wi) : Color(0.0f);
  }
  /// Multiplies flux with the part of the scattering by lobes that see the light; false if there is none.
  bool keep_visible(const ShadingPoint& point, const Bsdf& lobes, const BsdfSample& sample, Color& flux) const {
    if (sample.specular)
      return flags_.visibility & (sample.flags & kTransmission ? kVisibleTransmission : kVisibleGlossy);
    const Color all = visible_to(kVisibleAll, lobes, sample.wi, point.wo),
                visible = visible_to(flags_.visibility, lobes, sample.wi, point.wo);
    for (int c = 0; c < 3; ++c) flux[c] *= all[c] > 0.0f ? visible[c] / all[c] : 0.0f;
    return !is_black(flux);
  }

  const Scene& scene_;
  const PathMedia* media_;
  const PhotonEmission& emission_;
  const PhotonKernels kernels_ = photon_kernels(scene_);
  Sampler sampler_;
  PathVertex light_;
  LightRay start_;  ///< of the photon, at light `light_index_`
  uint32_t light_index_ = 0;
  int crossed_ = 0;              ///< transparent surfaces that it passed
  bool beyond_other_ = false;    ///< its ray has passed what does not block its light
  bool past_ray_kinds_ = false;  ///< its first ray has passed surfaces that depend on the kind of the ray
  SurfaceShading shading_;
  bool was_rough_ = false;
  double value_ = 0.0;  ///< of the photon path
  bool sharp_first_ = false;
  Vec3 entry_{0.0f};                ///< the first surface of the photon path
  MediaStack stack_;                ///< of the present ray
  std::optional<Light> soft_lamp_;  ///< of the present ray, if it comes straight from one
  LightFlags flags_;                ///< of the photon's light
  /// The photon's light and its start, if the shader depends on the distance.
  std::optional<std::pair<uint32_t, LightRay>> fading_;
};

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

PhotonBatch trace_photons(const Scene& scene, const PathMedia* media, const PhotonEmission& emission,
                          const std::atomic<bool>& stop) {
  PhotonBatch all;
  if (!emission.plan.global && !emission.plan.caustic) return all;
  const uint32_t blocks = (emission.count + kBlock - 1) / kBlock;
  std::vector<PhotonBatch> parts(blocks);
  tbb::parallel_for(0u, blocks, [&](uint32_t block) {
    if (stop.load(std::memory_order_relaxed)) return;
    BlockTracer tracer(scene, media, emission);
    const uint32_t end = std::min(emission.count, (block + 1) * kBlock);
    for (uint32_t i = block * kBlock; i < end; ++i) tracer.trace(i, parts[block]);
  });
  size_t global = 0, caustic = 0, sites = 0;
  for (const PhotonBatch& part : parts)
    global += part.global.size(), caustic += part.caustic.size(), sites += part.sites.size();
  all.global.reserve(global);
  all.caustic.reserve(caustic);
  all.sites.reserve(sites);
  for (const PhotonBatch& part : parts) {
    append(all.global, part.global);
    append(all.caustic, part.caustic);
    append(all.sites, part.sites);
    append(all.values, part.values);
    for (int c = 0; c < 3; ++c) all.emitted[c] += part.emitted[c];
    all.rays += part.rays;
  }
  return all;
}

}  // namespace ajar
