#include "transport/seen_light.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "transport/ray_events.h"

namespace ajar {

namespace {

constexpr uint32_t kFirstDimension = 4, kVertexDimensions = 4, kLobe = 0, kDirection = 1, kRoulette = 3;
constexpr uint32_t kStream = 0x7365656eU;      // its numbers are not those of the samples
constexpr int kAround = 2;                     // pixels to each side
/// Chance that a mirror shows a lamp too small to have been met yet where nothing around has met one.
constexpr double kUnseen = 1.0 / 32.0;
/// Further rays may be so many of a sample's own.
constexpr double kMostShare = 0.25;

bool goes_on(const Lobe& lobe) { return lobe.is_delta() || lobe.kind == LobeKind::Transparent; }

/// The lobes of `bsdf` that light is followed through; null when there are none. `storage`: where it has others, too.
const Bsdf* specular_part(const Bsdf& bsdf, Vec3 wo, Bsdf& storage) {
  int count = 0;
  for (int i = 0; i < bsdf.lobe_count(); ++i) count += goes_on(bsdf.lobe(i)) ? 1 : 0;
  if (count == 0) return nullptr;
  if (count == bsdf.lobe_count()) return &bsdf;
  storage.assign_lobes(bsdf, goes_on);
  storage.prepare(wo);
  return &storage;
}

double variance(float sum, float sum_squared, uint32_t count) {
  return count > 1 ? std::max(0.0, (double(sum_squared) - double(sum) * double(sum) / count) / (count - 1)) : 0.0;
}

}  // namespace

Color trace_seen_light(const Scene& scene, Ray ray, Sampler& sampler, uint64_t& rays) {
  const RenderSettings& settings = scene.settings();
  Color radiance(0.0f), beta(1.0f);
  ShadingPoint point;
  SurfaceShading shading;
  Bsdf storage;
  bool last_chance = false;
  for (uint32_t vertex = 0;; ++vertex) {
    const Hit hit = scene.intersect(ray, point.ray_kind);
    ++rays;
    const auto meet = [&](const LightMet& met) { radiance += beta * met.radiance; };
    if (scene.has_lamp_shapes()) for_each_lamp_crossed(scene, ray, hit.t, point.ray_kind, meet);
    if (!hit.found()) {
      for_each_distant_light(scene, ray, point.ray_kind, !(point.ray_depth == 0 && settings.transparent_film), meet);
      return radiance;
    }
    scene.shading_point(ray, hit, point);
    if (point.object->holdout && point.ray_depth == 0) return radiance;
    scene.material(hit).evaluate_surface(point, shading);
    radiance += beta * shading.emission;
    if (last_chance && is_black(shading.bsdf.transparency())) return radiance;
    const Bsdf* specular = specular_part(shading.bsdf, point.wo, storage);
    if (!specular) return radiance;

    const uint32_t base = kFirstDimension + kVertexDimensions * vertex;
    sampler.set_dimension(base + kLobe);
    const float u_lobe = sampler.get_1d();
    sampler.set_dimension(base + kDirection);
    const auto sample = specular->sample(point.wo, u_lobe, sampler.get_2d());
    if (!sample || !(sample->pdf_solid_angle > 0.0f)) return radiance;
    beta *= sample->f_cos / sample->pdf_solid_angle;
    if (!(max_component(beta) > 0.0f)) return radiance;
    if (sample->flags & kTransparent) {
      if (++point.transparent_depth > settings.bounces.transparent) return radiance;
      const float left = ray.t_max - hit.t;
      ray = scene.spawn_ray(point, ray.direction);
      ray.t_max = left;
      continue;
    }
    if (last_chance) return radiance;
    count_bounce(*sample, point, point);
    last_chance = past_limits(point, settings.bounces);
    const float survival = std::min(1.0f, max_component(beta));
    if (survival < 1.0f) {
      sampler.set_dimension(base + kRoulette);
      if (sampler.get_1d() >= survival) return radiance;
      beta /= survival;
    }
    ray = scene.spawn_ray(point, sample->wi);
  }
}

void SeenLight::prepare(const Scene& scene, const Film& film, const PixelFilter& filter, uint32_t seed) {
  *this = SeenLight();
  scene_ = &scene;
  filter_ = filter;
  seed_ = hash_combine(seed, kStream);
  x0_ = film.x0(), y0_ = film.y0(), width_ = film.width(), height_ = film.height();
  if (!scene.has_media() && !scene.lights().empty()) pixels_.resize(size_t(width_) * size_t(height_));
}

Color SeenLight::mean_with(Color found, float rest, int x, int y, uint64_t& rays) {
  Pixel& pixel = pixels_[index_of(x, y)];
  const auto note = [&pixel](Color light) {
    const float value = luminance(light);
    if (std::isfinite(value)) pixel.seen += value, pixel.seen_squared += value * value;
    ++pixel.looked;
  };
  note(found);
  if (std::isfinite(rest)) pixel.rest += rest, pixel.rest_squared += rest * rest;
  ++pixel.samples;
  if (pixel.rays <= 1) return found;
  Sampler sampler(Sampler::Kind::Sobol, seed_);
  const auto unit = uint32_t(y) * uint32_t(scene_->settings().width) + uint32_t(x);
  Color sum = found;
  for (uint32_t i = 1; i < pixel.rays; ++i) {
    sampler.start(unit, pixel.looked - pixel.samples);
    const Vec2 at = Vec2(float(x) + 0.5f, float(y) + 0.5f) + filter_.sample(sampler.get_2d());
    const Ray ray = scene_->camera().generate_ray(at, scene_->camera().has_lens() ? sampler.get_2d() : Vec2(0.5f), 0.0f);
    const uint64_t before = rays;
    const Color light = sees_nothing(ray) ? Color(0.0f) : trace_seen_light(*scene_, ray, sampler, rays);
    if (rays > before + 1) pixel.mirrors = true;
    note(light);
    sum += light;
  }
  return sum / float(pixel.rays);
}

void SeenLight::relative_variances(int x, int y, double in_mirrors, double& seen, double& rest) const {
  double seen_sum = 0.0, rest_sum = 0.0, mean = 0.0;
  int count = 0;
  for (int v = std::max(0, y - kAround); v <= std::min(height_ - 1, y + kAround); ++v)
    for (int u = std::max(0, x - kAround); u <= std::min(width_ - 1, x + kAround); ++u, ++count) {
      const Pixel& pixel = pixels_[size_t(v) * size_t(width_) + size_t(u)];
      seen_sum += variance(pixel.seen, pixel.seen_squared, pixel.looked);
      rest_sum += variance(pixel.rest, pixel.rest_squared, pixel.samples);
      mean += double(pixel.seen) / std::max(1u, pixel.looked) + double(pixel.rest) / std::max(1u, pixel.samples);
    }
  seen = seen_sum / count;
  rest = rest_sum / count;
  mean /= count;
  if (pixels_[size_t(y) * size_t(width_) + size_t(x)].mirrors) seen += kUnseen * (in_mirrors - seen);
  seen /= mean * mean + 0.01;
  rest /= mean * mean + 0.01;
}

void SeenLight::learn(uint32_t samples, uint64_t rays_of_rest, uint64_t rays_of_seen) {
  if (!active() || samples < 2 || !std::has_single_bit(samples)) return;
  double in_mirrors = 0.0;
  uint64_t mirrors = 0, further = 0;
  for (const Pixel& pixel : pixels_) {
    further += pixel.looked - pixel.samples;
    if (pixel.mirrors) in_mirrors += variance(pixel.seen, pixel.seen_squared, pixel.looked), ++mirrors;
  }
  in_mirrors /= double(std::max<uint64_t>(1, mirrors));
  std::vector<double> wanted(pixels_.size());
  double deviation = 0.0;   // mean over pixels: outliers in a few samples count less than in variances
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      double seen, rest;
      relative_variances(x, y, in_mirrors, seen, rest);
      wanted[size_t(y) * size_t(width_) + size_t(x)] = std::sqrt(seen);
      deviation += std::sqrt(rest);
    }
  deviation /= double(pixels_.size());
  const double rest_rays = double(rays_of_rest) / (double(pixels_.size()) * samples), seen_rays = double(rays_of_seen) / double(std::max<uint64_t>(1, further));
  const double unit = std::sqrt(rest_rays / std::max(seen_rays, 1.0)) / std::max(deviation, 1e-9);
  double sum = 0.0;
  for (double& k : wanted) {
    k = std::clamp(unit * k, 1.0, double(kMostRays));
    sum += k - 1.0;
  }
  const double most = kMostShare * rest_rays / std::max(seen_rays, 1.0) * double(pixels_.size());
  const double scale = std::min(1.0, most / std::max(sum, 1e-9));
  for (size_t i = 0; i < pixels_.size(); ++i) pixels_[i].rays = uint16_t(std::lround(1.0 + scale * (wanted[i] - 1.0)));
}

}  // namespace ajar
