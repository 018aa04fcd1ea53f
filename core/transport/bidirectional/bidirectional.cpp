#include "transport/bidirectional/bidirectional.h"

#include <algorithm>
#include <cmath>

#include "film/filter.h"
#include "transport/paths/eye_walk.h"
#include "transport/paths/light_walk_guide.h"

namespace ajar {

namespace {

/// Dimensions of the sampler for each walk. They are fixed, so that both walks and the connections stay aligned from
/// path to path.
constexpr uint32_t kEyeDimensions = 4, kLightDimensions = 1024, kPerVertex = 16;
constexpr uint32_t kThrough = 4096, kLobe = 4, kRoulette = 7;
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
      light_walks_(light_walks),
      margin_(0.5f * PixelFilter::full_width(scene.settings().filter, scene.settings().filter_width)),
      max_vertices_(max_path_vertices(scene.settings().bounces)) {
  eye_.resize(size_t(max_vertices_));
  light_.resize(size_t(max_vertices_));
  sampled_lights_.resize(size_t(max_vertices_) + 1);
}

const std::vector<FoundPath>& BidirectionalWalks::sample(Vec2 film, Sampler& sampler, SampleAux* aux) {
  film_ = film;
  found_.clear();
  connections_.clear();
  walk_from_eye(film, sampler, aux);
  walk_from_light(sampler);
  for (int i = 0; i < hit_count_; ++i) find_by_hit(i);
  for (int t = 2; t <= eye_count_; ++t)
    if (t + 1 <= max_vertices_) find_by_light_sample(t, sampler);
  for (int t = 2; t <= eye_count_; ++t)
    for (int s = 2; s <= light_count_ && s + t <= max_vertices_; ++s) find_by_connection(s, t);
  if (light_count_ >= 2) {
    sampler.set_dimension(kConnectionDimensions);
    make_lens_vertex(scene_, scene_.camera().has_lens() ? sampler.get_2d() : Vec2(0.5f), lens_);
    for (int s = 2; s <= light_count_ && s + 1 <= max_vertices_; ++s) find_by_lens(s);
  }
  return found_;
}

void BidirectionalWalks::walk_from_eye(Vec2 film, Sampler& sampler, SampleAux* aux) {
  const bool lamp_shapes = scene_.has_lamp_shapes(), transparent_film = scene_.settings().transparent_film;
  float pdf_direction;
  Ray ray = start_at_lens(scene_, film, scene_.camera().has_lens() ? sampler.get_2d() : Vec2(0.5f), eye_[0].vertex,
                          pdf_direction);
  eye_[0].beta = Color(1.0f);
  eye_count_ = 1;
  hit_count_ = 0;
  merged_ = Color(0.0f);
  bool only_specular = true;
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
    const auto watch = [&](const Ray& stretch, float t_end, bool found, const Through& passed) {
      const auto meet_light = [&](const LightMet& met) {
        PathVertex light;
        make_light_vertex(scene_, met, -ray.direction, light);
        PathEdge edge = join(light, previous.vertex);
        edge.transmittance = passed.transmittance;
        edge.pass = passed.pass;
        meet(i, light, edge, beta * passed.transmittance / passed.pass, pdf_direction);
      };
      if (lamp_shapes) for_each_lamp_crossed(scene_, stretch, t_end, next.vertex.point.ray_kind, meet_light);
      if (!found) {
        for_each_distant_light(scene_, stretch, next.vertex.point.ray_kind, !(transparent_film && i == 1), meet_light);
        if (i == 1) alpha_ = transparent_film ? 1.0f - luminance(passed.transmittance) / passed.pass : 1.0f;
      }
    };
    if (!find_vertex(scene_, ray, sampler, next.vertex, through, rays_, watch)) break;
    const PathVertex& vertex = next.vertex;
    next.edge = join(vertex, previous.vertex);
    next.edge.transmittance = through.transmittance;
    next.edge.pass = through.pass;
    next.beta = beta * through.transmittance / (through.pass * (1.0f - vertex.pass));
    next.fwd = pdf_direction * next.edge.to_light_area() * through.pass * (1.0f - vertex.pass);
    if (i == 1) {
      if (aux) record_first_hit(scene_, vertex.point, vertex.shading.bsdf, *aux);
      alpha_ = 1.0f - vertex.shading.holdout;
    }
    if (vertex.emits()) {
      PathVertex light;
      make_light_vertex(vertex, light);
      meet(i, light, next.edge, next.beta, pdf_direction);
    }
    if (vertex.shading.bsdf.empty() || i + 1 >= max_vertices_) break;
    eye_count_ = i + 1;
    if (merging && only_specular && i >= 2 && vertex.connectable()) merged_ += next.beta * merging->radiance(vertex, i);

    sampler.set_dimension(base + kLobe);
    const float u_lobe = sampler.get_1d();
    const auto sample = vertex.shading.bsdf.sample(vertex.point.wo, u_lobe, sampler.get_2d());
    if (!sample) break;
    next.vertex.specular = sample->specular;
    only_specular &= sample->specular;
    next.scattering = scatter(vertex, vertex.point.wo, sample->wi, sample->specular, guide);
    if (!(next.scattering.pdf_to_light > 0.0f)) break;
    beta = next.beta * next.scattering.f / next.scattering.pdf_to_light;
    if (!(max_component(beta) > 0.0f)) break;
    if (i >= 2)
      eye_[size_t(i - 1)].rev = next.scattering.pdf_walk_to_eye * next.edge.to_eye_area() * next.edge.pass *
                                (1.0f - previous.vertex.pass);
    if (i >= kRouletteAfter &&
        !survives(std::min(1.0f, std::sqrt(max_component(beta))), sampler, base + kRoulette, beta))
      break;
    start = ShadingPoint();
    count_bounce(*sample, vertex.point, start);
    ray = scene_.spawn_ray(vertex.point, sample->wi);
    pdf_direction = next.scattering.pdf_to_light;
  }
}

const PathVertex* BidirectionalWalks::find_merging_vertex(Vec2 film, Sampler& sampler) {
  walk_from_eye(film, sampler, nullptr);
  for (int i = 1; i < eye_count_; ++i) {
    const PathVertex& vertex = eye_[size_t(i)].vertex;
    if (i >= 2 && vertex.connectable()) return &vertex;
    if (!vertex.specular) return nullptr;
  }
  return nullptr;
}

void BidirectionalWalks::meet(int t, const PathVertex& light, const PathEdge& edge, Color beta, float pdf_direction) {
  if (t + 1 > max_vertices_) return;
  if (hit_count_ == int(hits_.size())) hits_.emplace_back();
  LightHit& hit = hits_[size_t(hit_count_++)];
  hit.t = t;
  hit.light = light;
  hit.edge = edge;
  hit.contribution = beta * light.shading.emission;
  hit.pdf = pdf_direction * edge.to_light_area() * edge.pass * (1.0f - light.pass);
}

void BidirectionalWalks::walk_from_light(Sampler& sampler) {
  light_count_ = 0;
  if (scene_.lights().empty() || max_vertices_ < 3) return;
  sampler.set_dimension(kLightDimensions);
  const Vec2 u_position = sampler.get_2d(), u_direction = sampler.get_2d();
  const float u_choice = sampler.get_1d();
  Ray ray;
  if (!start_at_light(scene_, guide, u_choice, u_position, u_direction, light_[0].vertex, ray)) return;
  if (for_photons_ && !sends_photons(scene_, light_[0].vertex)) return;
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
    if (!find_vertex(scene_, ray, sampler, next.vertex, through, rays_)) break;
    const PathVertex& vertex = next.vertex;
    next.edge = join(previous.vertex, vertex);
    next.edge.transmittance = through.transmittance;
    next.edge.pass = through.pass;
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
                (next.edge.cos_light_end / (next.edge.cos_eye_end * through.pass * (1.0f - vertex.pass)));
    next.fwd = pdf_direction * next.edge.to_eye_area() * through.pass * (1.0f - vertex.pass);
    if (vertex.shading.bsdf.empty() || !(max_component(next.beta) > 0.0f)) break;
    light_count_ = i + 1;

    sampler.set_dimension(base + kLobe);
    float u_lobe = sampler.get_1d();
    const Vec2 u_bounce = sampler.get_2d();
    std::optional<BsdfSample> sample;
    if (guide && vertex.connectable())
      if (const auto along = guide->direction_at(vertex.position(), u_lobe, u_bounce))
        sample = drawn_by_hint(vertex, *along);
    if (!sample) sample = vertex.shading.bsdf.sample(vertex.point.wo, u_lobe, u_bounce, TransportMode::Importance);
    if (!sample) break;
    next.vertex.specular = sample->specular;
    if (for_photons_ && !sample->specular && i > 1 && !previous.vertex.specular) break;
    next.scattering = scatter(vertex, sample->wi, vertex.point.wo, sample->specular, guide);
    if (!(next.scattering.pdf_walk_to_eye > 0.0f)) break;
    const Color bounce = next.scattering.f / next.scattering.pdf_walk_to_eye;
    factor = next.beta * bounce;
    gained *= bounce * (abs_dot(vertex.point.ng, sample->wi) / std::max(next.edge.cos_eye_end, 1e-6f));
    if (!(max_component(factor) > 0.0f)) break;
    previous.rev = next.scattering.pdf_to_light * next.edge.to_light_area() * next.edge.pass *
                   (1.0f - previous.vertex.pass);
    if (i == 1 && !light_end_.can_be_hit) previous.rev = 0.0f;
    if (i >= kRouletteAfter && !survives(std::min(1.0f, std::sqrt(std::max(max_component(gained), 1e-4f))), sampler,
                                         base + kRoulette, factor, gained))
      break;
    start = ShadingPoint();
    count_bounce(*sample, vertex.point, start);
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
