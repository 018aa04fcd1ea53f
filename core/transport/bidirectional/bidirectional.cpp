#include "transport/bidirectional/bidirectional.h"

#include <algorithm>
#include <cmath>

#include "film/filter.h"
#include "transport/media/subsurface_walk.h"
#include "transport/paths/eye_history.h"
#include "transport/paths/eye_walk.h"
#include "transport/paths/light_walk_guide.h"
#include "transport/paths/record.h"
#include "transport/paths/shadow_terminator.h"

namespace ajar {

namespace {

/// Dimensions of the sampler for each walk. They are fixed, so that both walks and the connections stay aligned from
/// path to path.
constexpr uint32_t kEyeDimensions = 4, kLightDimensions = 1024, kPerVertex = 16;
constexpr uint32_t kThrough = 4096, kLobe = 4, kRoulette = 7, kBelow = 8;
constexpr int kRouletteAfter = 3;

/// A sample for a direction that was drawn by a hint and not by a lobe.
BsdfSample drawn_by_hint(const PathVertex& vertex, Vec3 wi) {
  BsdfSample sample{};
  sample.wi = wi;
  sample.flags = likely_flags(vertex.shading.bsdf, wi, vertex.point.wo);
  return sample;
}

}  // namespace

BidirectionalWalks::BidirectionalWalks(const Scene& scene, double light_walks)
    : scene_(scene),
      light_walks_(joins_lens(scene) ? light_walks : 0.0),
      margin_(0.5f * PixelFilter::full_width(scene.settings().filter, scene.settings().filter_width)),
      max_vertices_(max_path_vertices(scene.settings().bounces)),
      has_subsurface_(scene.has_subsurface()),
      any_by_ray_kind_(scene.depends_on_ray_kind()),
      any_limited_(scene.lights().any_limited()) {
  if (has_subsurface_) {
    staying_.resize(size_t(max_vertices_));
    for (const ShaderProgram& program : scene.programs()) enters_after_diffuse_ |= program.enters_after_diffuse();
  }
  eye_.resize(size_t(max_vertices_));
  light_.resize(size_t(max_vertices_));
  sampled_lights_.resize(size_t(max_vertices_) + 1);
}

const std::vector<FoundPath>& BidirectionalWalks::sample(Vec2 film, Sampler& sampler, SampleAux* aux) {
  film_ = film;
  found_.clear();
  connections_.clear();
  walk_from_eye(film, sampler, aux);
  if (sampled == SampledLights::BeyondTerminator) {
    find_beyond_terminator(sampler);
    return found_;
  }
  if (classes == PathClasses::EyeOnly && eye_[size_t(eye_count_ - 1)].exit < 0 && !any_by_ray_kind_) return found_;
  walk_from_light(sampler);
  for (int i = 0; i < hit_count_; ++i) find_by_hit(i);
  for (int t = 2; t <= eye_count_; ++t)
    if (t + 1 <= max_vertices_) find_by_light_sample(t, sampler);
  for (int t = 2; t <= eye_count_; ++t)
    for (int s = 2; s <= light_count_ && s + t <= max_vertices_; ++s) find_by_connection(s, t);
  if (light_count_ >= 2 && light_walks_ > 0.0 && classes != PathClasses::EyeOnly) {
    sampler.set_dimension(kConnectionDimensions);
    make_lens_vertex(scene_, scene_.camera().has_lens() ? sampler.get_2d() : Vec2(0.5f), time_, lens_);
    for (int s = 2; s <= light_count_ && s + 1 <= max_vertices_; ++s) find_by_lens(s);
  }
  return found_;
}

/// Samples lights beyond the terminator at the vertices of the walk from the eye after a bounce.
void BidirectionalWalks::find_beyond_terminator(Sampler& sampler) {
  for (int t = 2; t <= eye_count_ && t + 1 <= max_vertices_; ++t)
    if (has_soft_terminator(eye_[size_t(t - 1)].vertex.point) && !is_direct({.s = 1, .t = t}))
      find_by_light_sample(t, sampler);
}

void BidirectionalWalks::walk_from_eye(Vec2 film, Sampler& sampler, SampleAux* aux) {
  const bool lamp_shapes = scene_.has_lamp_shapes(), transparent_film = scene_.settings().transparent_film;
  float pdf_direction;
  const Vec2 u_lens = lens_point ? *lens_point : scene_.camera().has_lens() ? sampler.get_2d() : Vec2(0.5f);
  time_ = pass_time ? *pass_time : sample_time(scene_, sampler);
  Ray ray = start_at_lens(scene_, film, u_lens, time_, eye_[0].vertex, pdf_direction);
  begin_at_lens();
  bool past_limit = false, only_specular = true;
  alpha_ = pdf_direction > 0.0f ? 0.0f : 1.0f;
  if (!(pdf_direction > 0.0f)) return;
  ShadingPoint start;
  Color beta(1.0f);
  while (eye_count_ + 1 <= max_vertices_) {
    const int i = eye_count_;
    // The last possible vertex of a path can only be a light.
    WalkVertex& next = eye_[size_t(i)];
    const WalkVertex& previous = eye_[size_t(i - 1)];
    next.vertex.point = start;
    const uint32_t base = kEyeDimensions + kPerVertex * uint32_t(i);
    sampler.set_dimension(base + kThrough);
    Through through;
    through.by_kind = follows_ray_kinds() ? RayKindSurfaces::Follow : RayKindSurfaces::End;
    const auto watch = [&](const Ray& stretch, float t_end, bool found, const Through& passed) {
      if (media && !past_limit) [[unlikely]]
        add_glow(beta * passed.transmittance / passed.pass *
                     emitted_in_media(stretch, found ? t_end : kInfinity, next.vertex, sampler),
                 i - 1);
      const auto meet_light = [&](const LightMet& met) {
        const Through before = media ? through_to(*media, next.vertex.media.stack, stretch, distance_to(stretch, met),
                                                  next.vertex.point, sampler, passed)
                                     : passed;
        meet_lamp(i, met, ray.direction, before, beta * before.transmittance / passed.pass, pdf_direction);
      };
      if (lamp_shapes) for_each_lamp_crossed(scene_, stretch, t_end, next.vertex.point.ray_kind, meet_light);
      if (found) return;
      record_background(scene_, ray.direction, i == 1, beta * passed.transmittance / passed.pass, aux);
      for_each_distant_light(scene_, stretch, next.vertex.point.ray_kind, !(transparent_film && i == 1), meet_light);
      if (i == 1) alpha_ = transparent_film ? 1.0f - luminance(passed.transmittance) / passed.pass : 1.0f;
    };
    enter_media({scene_, media}, previous.vertex, ray.direction, next.vertex);
    if (!find_vertex(PathScene{scene_, media}, ray, sampler, next.vertex, through, rays_, watch)) break;
    past_limit |= media && past_limits(start, scene_.settings().bounces);
    const PathVertex& vertex = next.vertex;
    arrive_at(next, previous.vertex, through, beta, pdf_direction);
    if (vertex.kind == VertexKind::Surface) record_seen(next, i, aux);
    if (i == 1) alpha_ = 1.0f - vertex.shading.holdout;
    if (vertex.emits()) meet_emitter(i, next, pdf_direction);
    if (!vertex.scatters() || i + 1 >= max_vertices_ || (knows_history() && !scatters_at(i, base, sampler))) break;
    eye_count_ = i + 1;
    only_specular &= !vertex.excludes_photons() && next.exit < 0;
    if (merging && only_specular && i >= 2 && vertex.stores_photons()) merge(next, i);

    sampler.set_dimension(base + kLobe);
    const auto sample = sample_bounce(scattering_end(i + 1), TransportMode::Radiance, sampler);
    if (!sample) break;
    next.vertex.specular = sample->specular;
    only_specular &= sample->specular;
    next.scattering = scatter(vertex, vertex.point.wo, sample->wi, sample->specular, guide);
    if (!(next.scattering.pdf_to_light > 0.0f)) break;
    beta = next.beta *
           (next.stays ? sample->f_cos / sample->pdf_solid_angle : next.scattering.f / next.scattering.pdf_to_light);
    if (!(max_component(beta) > 0.0f)) break;
    if (i == 1 && passes.any()) [[unlikely]]
      first_ = passes.scattered_at(scattering_end(2), vertex.point.wo, sample->wi, sample->specular);
    if (i >= 2)
      eye_[size_t(i - 1)].rev = next.scattering.pdf_walk_to_eye * next.edge.to_eye_area() * next.edge.pass *
                                next.edge.stop_eye_end;
    if (i >= kRouletteAfter &&
        !survives(std::min(1.0f, std::sqrt(max_component(beta))), sampler, base + kRoulette, beta))
      break;
    start = ShadingPoint();
    count_bounce_at(vertex, *sample, start);
    if (classes == PathClasses::EyeOnly && next.exit < 0 && start.after_diffuse && !enters_after_diffuse_ &&
        !any_by_ray_kind_)
      break;
    ray = scene_.spawn_ray(vertex.point, sample->wi);
    pdf_direction = next.scattering.pdf_to_light;
  }
}

/// Starts a walk from the eye at the vertex of the lens.
void BidirectionalWalks::begin_at_lens() {
  eye_[0].beta = Color(1.0f);
  eye_[0].exit = -1;
  eye_count_ = 1;
  hit_count_ = 0;
  merged_ = glow_ = Color(0.0f);
  if (passes.any()) [[unlikely]]
    passes.begin();
  enters_first_ = false;
}

/// Records the surface at vertex i of the walk from the eye.
void BidirectionalWalks::record_seen(const WalkVertex& at, int i, SampleAux*& aux) {
  const Bsdf& bsdf = at.vertex.shading.bsdf;
  record_vertex(scene_, at.vertex.point, bsdf, at.beta, aux, BehindFirst::NotFound);
  if (i == 1 && passes.any()) [[unlikely]]
    passes.add_color(bsdf, at.beta);
}

/// Adds the light that photons bring to vertex i of the walk from the eye.
void BidirectionalWalks::merge(const WalkVertex& at, int i) {
  const Color light = at.beta * merging->radiance(at.vertex, i);
  merged_ += light;
  if (!passes.any()) [[likely]]
    return;
  passes.add(passes.part_of(i + 1, first_), light);
  for (int g = 0; g < passes.group_count(); ++g)
    passes.add(passes.of_group(g), at.beta * merging->radiance_of_group(at.vertex, i, g));
}

/// Adds light that media emit along the walk from the eye, after `bounces` scattering events.
void BidirectionalWalks::add_glow(Color light, int bounces) {
  glow_ += light;
  if (passes.any()) [[unlikely]]
    passes.add(passes.part_of(bounces, first_), light);
}

PathPasses BidirectionalWalks::passes_of(const FoundPath& path) const {
  const PathEdge& edge = connections_[size_t(&path - found_.data())];
  const int bounces = path.s + path.t - (path.s == 0 ? 1 : 2);
  PathPasses first = first_;
  if (path.t == 1 && path.s > 0) {
    const PathVertex& vertex = light_[size_t(path.s - 1)].vertex;
    first = passes.scattered_at(vertex, edge.to_eye, vertex.point.wo, false);
  } else if (path.t == 2 && path.s > 0) {
    const PathVertex& vertex = scattering_end(2);
    first = passes.scattered_at(vertex, vertex.point.wo, -edge.to_eye, false);
  }
  PathPasses found = passes.of(scene_, light_of(path), bounces, first);
  found.is_direct = is_direct(path);
  return found;
}

/// The walk from the eye has found the vertex of `next` behind `through`.
void BidirectionalWalks::arrive_at(WalkVertex& next, const PathVertex& previous, const Through& through, Color beta,
                                   float pdf_direction) {
  next.edge = join(next.vertex, previous);
  set_edge(next.edge, through, previous, next.vertex, true);
  next.beta = beta * through.transmittance / (through.pass * next.edge.stop_light_end);
  next.fwd = pdf_direction * next.edge.to_light_area() * through.pass * next.edge.stop_light_end;
}

/// If the walk from the eye knows its history: whether its vertex i scatters within the limits. If light enters, the
/// vertex becomes the exit, or the walk stays with the other lobes.
bool BidirectionalWalks::scatters_at(int i, uint32_t base, Sampler& sampler) {
  WalkVertex& at = eye_[size_t(i)];
  const WalkVertex& before = eye_[size_t(i - 1)];
  const BounceLimits& limits = scene_.settings().bounces;
  at.exit = at.edge.eye_only || at.vertex.eye_only ? i : before.exit;
  at.below = i > 1 && before.below;
  at.stays = false;
  enters_first_ |= i == 1 && at.exit == 1;
  at.collisions = i > 1 ? before.collisions + (before.vertex.kind == VertexKind::Medium) : 0;
  if (past_limits(at.vertex.point, limits) || at.collisions > limits.volume) return false;
  if (!enters(at.vertex, at.vertex.point.after_diffuse)) return true;
  enters_first_ |= i == 1;
  return enters_surface(i, base, sampler);
}

/// Light can enter at vertex i. False if the walk is lost.
bool BidirectionalWalks::enters_surface(int i, uint32_t base, Sampler& sampler) {
  WalkVertex& at = eye_[size_t(i)];
  PathVertex& vertex = at.vertex;
  const float selection = vertex.shading.bsdf.subsurface_part().selection;
  sampler.set_dimension(base + kBelow);
  const float u = sampler.get_1d(), u_stream = sampler.get_1d();
  at.stays = classes == PathClasses::NotEyeOnly || u >= selection;
  if (at.stays) {
    if (classes != PathClasses::NotEyeOnly) at.beta /= 1.0f - selection;
    staying_[size_t(i)] = vertex;
    staying_[size_t(i)].shading.bsdf.remove_subsurface(vertex.point.wo);
    return staying_[size_t(i)].scatters();
  }
  const uint32_t instance = uint32_t(vertex.point.instance - scene_.instances().data());
  const SubsurfaceNumbers numbers{u, hash_combine(uint32_t(u_stream * 0x1p32f), base)};
  if (!walk_below_or_stay(scene_, instance, numbers, vertex.point, vertex.shading, at.beta, rays_)) return false;
  vertex.exit = true;
  vertex.light = -1;
  vertex.pass = 0.0f;
  vertex.shading.emission = Color(0.0f);
  at.exit = i;
  at.below = true;
  return true;
}

/// Whether a path with this many vertices from the eye, and this edge next to the light, does not belong to the paths
/// that are looked for.
bool BidirectionalWalks::leaves_class(int t, const PathEdge& light_edge) const {
  if (classes == PathClasses::All) return false;
  const bool eye_only = eye_[size_t(t - 1)].exit >= 0 || light_edge.by_ray_kind;
  return eye_only != (classes == PathClasses::EyeOnly);
}

Color BidirectionalWalks::sample_glow(Vec2 film, Sampler& sampler) {
  walk_from_eye(film, sampler, nullptr);
  return glow_;
}

const PathVertex* BidirectionalWalks::find_merging_vertex(Vec2 film, Sampler& sampler) {
  walk_from_eye(film, sampler, nullptr);
  for (int i = 1; i < eye_count_; ++i) {
    const PathVertex& vertex = eye_[size_t(i)].vertex;
    if (eye_[size_t(i)].exit >= 0) return nullptr;
    if (i >= 2 && vertex.stores_photons()) return &vertex;
    if (!vertex.specular) return nullptr;
  }
  return nullptr;
}

Color BidirectionalWalks::emitted_in_media(const Ray& ray, float t_end, const PathVertex& vertex,
                                           Sampler& sampler) const {
  if (!media->any_emission() || vertex.media.stack.empty()) return Color(0.0f);
  Pcg32 rng = media_numbers(sampler);
  return media->emitted({vertex.media.stack, ray, t_end, vertex.point, vertex.point.ray_kind}, rng);
}

/// The direction in which a walk goes on. Walks from lights may follow hints.
std::optional<BsdfSample> BidirectionalWalks::sample_bounce(const PathVertex& vertex, TransportMode mode,
                                                            Sampler& sampler) const {
  const Vec3 numbers = sampler.get_3d();
  float u_lobe = numbers.z;
  const Vec2 u(numbers);
  if (vertex.kind == VertexKind::Medium) return sample_direction(vertex, vertex.point.wo, u_lobe, u);
  if (mode == TransportMode::Importance && guide && vertex.connectable())
    if (const auto along = guide->direction_at(vertex.position(), u_lobe, u)) return drawn_by_hint(vertex, *along);
  return vertex.shading.bsdf.sample(vertex.point.wo, u_lobe, u, mode);
}

/// The ray of the walk from the eye meets a light that is not a surface, behind `before`.
void BidirectionalWalks::meet_lamp(int t, const LightMet& met, Vec3 direction, const Through& before, Color beta,
                                   float pdf_direction) {
  const PathVertex& previous = eye_[size_t(t - 1)].vertex;
  PathVertex light;
  make_light_vertex(scene_, met, -direction, time_, light);
  PathEdge edge = join(light, previous);
  set_edge(edge, before, previous, light, true);
  meet(t, light, edge, beta, pdf_direction);
}

/// The walk from the eye has hit a surface that emits.
void BidirectionalWalks::meet_emitter(int t, const WalkVertex& at, float pdf_direction) {
  PathVertex light;
  make_light_vertex(at.vertex, light);
  meet(t, light, at.edge, at.beta, pdf_direction);
}

void BidirectionalWalks::meet(int t, const PathVertex& light, const PathEdge& edge, Color beta, float pdf_direction) {
  if (t + 1 > max_vertices_) return;
  if (hit_count_ == int(hits_.size())) hits_.emplace_back();
  LightHit& hit = hits_[size_t(hit_count_++)];
  hit.t = t;
  hit.light = light;
  hit.edge = edge;
  hit.contribution = beta * light.shading.emission;
  hit.pdf = pdf_direction * edge.to_light_area() * edge.surface_pass * (1.0f - light.pass);
}

void BidirectionalWalks::walk_from_light(Sampler& sampler) {
  light_count_ = 0;
  if (scene_.lights().empty() || max_vertices_ < 3) return;
  sampler.set_dimension(kLightDimensions);
  const Vec2 u_position = sampler.get_2d(), u_direction = sampler.get_2d();
  const float u_choice = sampler.get_1d();
  Ray ray;
  if (!start_at_light(scene_, guide, {u_choice, u_position, u_direction}, time_, light_[0].vertex, ray)) return;
  if (for_photons_ && !sends_photons(scene_, light_[0].vertex)) return;
  // The volume of the world has no end: light from infinity is lost in it.
  if (media && light_[0].vertex.distant && media->fills_world()) return;
  ShadingPoint start;
  start.ray_kind = kLightWalkKind;
  Color factor(1.0f);  // the throughput of the next vertex without the cosines of its edge
  Color gained(1.0f);  // throughput relative to the first vertex, for Russian roulette
  float pdf_direction = 0.0f;
  while (light_count_ + 1 < max_vertices_) {
    const int i = light_count_ == 0 ? 1 : light_count_;
    WalkVertex& next = light_[size_t(i)];
    WalkVertex& previous = light_[size_t(i - 1)];
    next.vertex.point = start;
    const uint32_t base = kLightDimensions + kPerVertex * uint32_t(i);
    sampler.set_dimension(base + kThrough);
    Through through;
    if (i == 1) through.by_kind = first_from_light();
    enter_media({scene_, media}, previous.vertex, ray.direction, next.vertex);
    if (!find_vertex(PathScene{scene_, media}, ray, sampler, next.vertex, through, rays_)) break;
    const PathVertex& vertex = next.vertex;
    next.edge = join(previous.vertex, vertex);
    set_edge(next.edge, through, previous.vertex, vertex, false);
    if (for_photons_ && vertex.excludes_photons()) break;
    if (i == 1) {
      light_end_ = light_end(scene_, previous.vertex, vertex, next.edge, guide);
      if (!(light_end_.pdf_origin * light_end_.pdf_direction > 0.0f)) break;
      previous.fwd = light_end_.pdf_origin;
      previous.beta = Color(1.0f / light_end_.pdf_origin);
      factor = light_end_.radiance / (light_end_.pdf_origin * light_end_.pdf_direction);
      pdf_direction = light_end_.pdf_direction;
    }
    if (!(next.edge.cos_eye_end > 0.0f)) break;
    next.beta = factor * through.transmittance *
                (next.edge.cos_light_end /
                 (next.edge.cos_eye_end * through.pass * through.chance * next.edge.stop_eye_end));
    next.fwd = pdf_direction * next.edge.to_eye_area() * through.pass * next.edge.stop_eye_end;
    if (!vertex.scatters() || !(max_component(glm::abs(next.beta)) > 0.0f)) break;
    light_count_ = i + 1;

    sampler.set_dimension(base + kLobe);
    const auto sample = sample_bounce(vertex, TransportMode::Importance, sampler);
    if (!sample) break;
    next.vertex.specular = sample->specular;
    if (next.edge.by_ray_kind && sample->specular) break;  // shadow rays end at other lobes only
    if (for_photons_ && !sample->specular &&
        (vertex.kind == VertexKind::Medium || (i > 1 && !previous.vertex.specular)))
      break;
    next.scattering = scatter(vertex, sample->wi, vertex.point.wo, sample->specular, guide);
    if (i == 1)
      next.scattering.f = visible_part(scene_, previous.vertex, vertex, sample->wi, vertex.point.wo, sample->specular,
                                       next.scattering.f);
    if (!(next.scattering.pdf_walk_to_eye > 0.0f)) break;
    const Color bounce = next.scattering.f / next.scattering.pdf_walk_to_eye;
    factor = next.beta * bounce;
    const float cosines = vertex.kind == VertexKind::Medium
                              ? 1.0f
                              : abs_dot(vertex.point.ng, sample->wi) / std::max(next.edge.cos_eye_end, 1e-6f);
    gained *= bounce * cosines;
    if (!(max_component(glm::abs(factor)) > 0.0f)) break;
    previous.rev = next.scattering.pdf_to_light * next.edge.to_light_area() *
                   (i == 1 ? next.edge.surface_pass : next.edge.pass) * next.edge.stop_light_end;
    if (i == 1 && (next.edge.by_ray_kind || !light_end_.can_be_hit_from(vertex))) previous.rev = 0.0f;
    if (i >= kRouletteAfter && !survives(std::min(1.0f, std::sqrt(std::max(max_component(gained), 1e-4f))), sampler,
                                         base + kRoulette, factor, gained))
      break;
    start = ShadingPoint();
    count_bounce_at(vertex, *sample, start);
    start.ray_kind = kLightWalkKind;
    ray = scene_.spawn_ray(vertex.point, sample->wi);
    pdf_direction = next.scattering.pdf_walk_to_eye;
  }
}

bool BidirectionalWalks::is_direct(const FoundPath& path) const {
  if (path.t == 1 && path.s > 0) return path.s == 2;
  if (path.s >= 2) return false;
  // The last vertex of the eye walk is next to the light, so it can scatter in any way.
  for (int k = 1; k <= path.t - 2; ++k)
    if (!eye_[size_t(k)].vertex.specular) return false;
  return true;
}

int BidirectionalWalks::copy_path(const FoundPath& path, PathVertex* out, PathEdge* edges) const {
  const PathEdge& joint = connections_[size_t(&path - found_.data())];
  int count = 0;
  if (path.s == 0) out[count++] = hits_[size_t(path.hit)].light;
  if (path.s == 1) out[count++] = sampled_lights_[size_t(path.t)];
  for (int j = 0; path.s >= 2 && j < path.s; ++j) {
    out[count] = light_[size_t(j)].vertex;
    if (j == path.s - 1) out[count].specular = false;
    if (j > 0) edges[count - 1] = light_[size_t(j)].edge;
    ++count;
  }
  edges[count - 1] = joint;
  if (path.t == 1) {
    out[count++] = lens_;
    return count;
  }
  for (int k = path.t - 1; k >= 0; --k) {
    out[count] = eye_[size_t(k)].vertex;
    if (k == path.t - 1 && path.s > 0) out[count].specular = false;
    if (k > 0) edges[count] = eye_[size_t(k)].edge;
    ++count;
  }
  return count;
}

}  // namespace ajar
