#include "integrators/gather_passes.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <tbb/blocked_range2d.h>
#include <tbb/combinable.h>
#include <tbb/parallel_for.h>

#include "integrators/learned.h"
#include "math/statistics.h"
#include "transport/bidirectional/seen_light.h"
#include "transport/paths/walk.h"

namespace ajar {

namespace {

constexpr int kTile = 16;
constexpr uint32_t kLearnedPasses = 8;      // the guide of gather rays learns after 1, 2, 4 and 8 passes
constexpr uint32_t kFirstWarmTraining = 8;  // first training step if it starts with the guide of an earlier frame
constexpr double kLearnedRays = 2e5;        // gather rays recorded between two training steps, at most
constexpr int kProbes = 24;                 // per axis of the film, to choose radii
/// Photons in a disc of the first pass at the points that the image looks up. Noise that is independent in each pass and
/// nearly independent in each pixel is the cheaper error: it falls with the passes, and a denoiser removes it. Wide discs
/// blur caustics and the shadows in them (docs/research/denoising.md).
constexpr int kReach = 6;
/// The weights of photons of chains contain the number of lookups in the same disc, so they need wider discs.
constexpr int kChainReach = 10, kChainCausticReach = 60;
/// Radius in pixels below which a caustic is not blurred visibly: about that of the pixel filter.
constexpr float kPixels = 0.75f;
/// An estimate of a caustic that is wider than a pixel fills narrow shadows and blurs edges, in all passes alike. Later
/// passes therefore have none, so that this error falls as 1 / passes.
constexpr uint32_t kWidePasses = 32;
/// Photons of a caustic where the picture is a texture, whose texels have no radius.
constexpr int kEnoughForTexels = 10;
/// Light that is seen without gathering is sampled four times before the first update. It gets at most a quarter of the
/// rays.
constexpr FurtherSamples::Limits kFurtherSeen{4, 0.25};
constexpr double kBeyondShare = 0.25;      // rays that look for light beyond the terminator, of all rays, at most
constexpr double kLookupPilotShare = 4.0;  // lookups logged before the first pass, per photon

struct Counters {
  uint64_t rays = 0, gathered = 0, from_sites = 0;
  RareLight beyond;
};

}  // namespace

void GatherPasses::prepare(const Scene& scene, const PathMedia* media, uint32_t seed, ArrivalMap* arrivals) {
  *this = GatherPasses();
  arrivals_ = arrivals;
  scene_ = &scene;
  media_ = media;
  seed_ = seed;
  filter_ = PixelFilter(scene.settings().filter, scene.settings().filter_width);
  gather_.rays = std::max(1, scene.settings().gather_rays);
  const Camera& camera = scene.camera();
  const Vec3 forward = camera.forward(time());
  gather_.pixel = {camera.position(), kPixels / std::sqrt(camera.film_density(forward, time())),
                   camera.is_orthographic()};
  if (has_soft_terminator(scene)) gather_.beyond_terminator = RareLight::kFirst;
  gather_.light_without_photons = scene.emission_without_lights() || scene.depends_on_ray_kind() ||
                                  (media && media->any_emission());
  // Photons of chains lie in clusters. The disc up to the k-th photon ends at such a cluster too often, so that narrower
  // lookups would overestimate (rooms: by 15 % with 10 neighbours).
  if (arrivals) gather_.neighbours = gather_.gather_neighbours = PointTree::kMaxNeighbours;
  if (arrivals || scene.settings().photon_radius > 0.0f)
    gather_.enough = 0;
  else if (camera.sees_texels())
    gather_.enough = kEnoughForTexels;
}

std::vector<LearnedPart> GatherPasses::begin_with(const Learned& learned) {
  if (learned.gather_guide) guide_ = *learned.gather_guide, first_training_ = kFirstWarmTraining;
  return {{"guide of gather rays", learned.gather_guide ? "" : "the frame before has not learned enough"}};
}

void GatherPasses::hand_on(Learned& learned) {
  learn(GuideTree::kPastShareAtEnd);
  if (guide_.cell_count() > 0 && guide_.cell_count() <= Learned::kMaxCells)
    learned.gather_guide = std::make_shared<const GuideTree>(guide_);
}

uint32_t GatherPasses::photon_count() const { return photons_of_a_pass(scene_->settings()); }

uint32_t GatherPasses::site_stride(uint32_t photons) const {
  const RenderSettings& s = scene_->settings();
  const double lookups = double(s.width) * s.height * gather_.rays / 8.0;
  return uint32_t(std::clamp(4.0 * double(photons) / lookups, 4.0, 1e9));
}

void GatherPasses::choose_radii(const std::vector<Photon>& global, const std::vector<Photon>& caustic) {
  if (pass_ == 0) {
    maps_.global.build(global);
    maps_.caustic.build(caustic);
    choose_first_radii();
    gather_.shortest_logged = PhotonGatherer::kNear * first_global_radius_;
  }
  const float shrink = float(std::sqrt(radius2_factor(pass_)));
  maps_.global_radius = first_global_radius_ * shrink;
  maps_.caustic_radius = first_caustic_radius_ * shrink;
  if (pass_ >= kWidePasses && gather_.enough == GatherSettings::kEnough) gather_.enough = 1;
}

void GatherPasses::build_maps(std::vector<Photon> global, std::vector<Photon> caustic, const Weigh& weigh) {
  maps_.global.build(std::move(global));
  maps_.caustic.build(std::move(caustic));
  maps_.global.use(photon_kernels(*scene_));
  maps_.caustic.use(photon_kernels(*scene_));
  maps_.global.look_around(*scene_, {gather_.gather_neighbours, maps_.global_radius}, time(),
                           hash_combine(seed_, pass_));
  maps_.caustic.look_around(*scene_, gather_.caustic_lookup(maps_.caustic_radius), time(), hash_combine(seed_, ~pass_));
  if (weigh) {
    weigh(ArrivalMap::kGathered, maps_.global, maps_.global_radius);
    weigh(ArrivalMap::kSeen, maps_.caustic, maps_.caustic_radius);
  }
  maps_.has_global = !maps_.global.empty();
  maps_.has_caustic = !maps_.caustic.empty();
  maps_.sites.build(sites_, maps_.global, {gather_.gather_neighbours, maps_.global_radius});
}

/// Sets the radii of the first pass: the weighted median distance to the kReach-th photon, over the points at which the
/// image will look up the maps. Photons are dense where there is much light, and the image may look elsewhere. The
/// weights 1 / distance favour points with many photons, which have most of the light. Photons of chains: the plain
/// median.
void GatherPasses::choose_first_radii() {
  const RenderSettings& settings = scene_->settings();
  const float max_radius = kLargestPhotonRadius * scene_->radius();
  first_global_radius_ = first_caustic_radius_ = settings.photon_radius;
  if (settings.photon_radius > 0.0f) return;
  std::vector<float> global, caustic;
  const int reach_of_gathered = arrivals_ ? kChainReach : kReach,
            reach_of_caustic = arrivals_ ? kChainCausticReach : kReach;
  PhotonGatherer gatherer(*scene_, media_, maps_, gather_, hash_combine(seed_, 0x70726f62U));
  for (int i = 0; i < kProbes * kProbes; ++i) {
    gatherer.start(uint32_t(i), 0);
    const Vec2 on_film((float(i % kProbes) + 0.5f) / kProbes * float(settings.width),
                       (float(i / kProbes) + 0.5f) / kProbes * float(settings.height));
    SurfacePoint seen, gathered;
    const Ray ray = scene_->camera().generate_ray(on_film, Vec2(0.5f), time());
    if (sees_nothing(ray) || !gatherer.probe(ray, seen, gathered)) continue;
    global.push_back(maps_.global.reach(gathered, reach_of_gathered, max_radius));
    const float reach = maps_.caustic.reach(seen, reach_of_caustic, max_radius);
    if (reach < max_radius) caustic.push_back(reach);
  }
  if (arrivals_) {
    first_global_radius_ = median(global, max_radius);
    first_caustic_radius_ = std::min(first_global_radius_, median(caustic, max_radius));
    return;
  }
  const float reach = median_by_inverse(global, max_radius), of_one_photon = reach / std::sqrt(float(kReach));
  first_global_radius_ = std::max(of_one_photon, std::min(reach, kLargestGatherRadius * scene_->radius()));
  first_caustic_radius_ = std::min(reach, median(caustic, max_radius));
}

/// Calls visit(gatherer, x, y, ray), in parallel tiles, for the samples that each pixel needs to reach its goal of this
/// pass. With `only_arrivals`, for sample number `sample` of each pixel.
template <class Visit>
void GatherPasses::for_each_pixel(const Film& film, uint32_t seed, uint32_t sample, bool only_arrivals,
                                  const std::atomic<bool>& stop, Visit&& visit) {
  const int width = film.width(), height = film.height(), columns = (width + kTile - 1) / kTile,
            rows = (height + kTile - 1) / kTile;
  const int full_width = scene_->settings().width;
  const double gather_rays = double(width) * height * gather_.rays;
  ArrivalLog log;
  const auto stride = [&](double lookups) { return std::max(1, int(std::ceil(lookups / ArrivalMap::kMaxLookups))); };
  log.stride[ArrivalMap::kSeen] = stride(double(width) * height);
  log.stride[ArrivalMap::kGathered] = stride(gather_rays);
  const uint32_t guide_stride = uint32_t(
      std::max(1.0, gather_rays * std::max(first_training_, std::bit_floor(pass_)) / kLearnedRays));
  const float time = time_of_pass(*scene_, seed_, only_arrivals ? sample : pass_);
  std::vector<ArrivalLog> logs(arrivals_ ? size_t(columns) * size_t(rows) : 0, log);
  tbb::combinable<Counters> counters;
  tbb::parallel_for(
      tbb::blocked_range2d<int>(0, rows, 1, 0, columns, 1),
      [&](const tbb::blocked_range2d<int>& tile) {
        if (stop.load(std::memory_order_relaxed)) return;
        const int row = tile.rows().begin(), column = tile.cols().begin();
        PhotonGatherer gatherer(*scene_, media_, maps_, gather_, seed);
        const size_t number = size_t(row) * size_t(columns) + size_t(column);
        if (!only_arrivals)
          gatherer.guide(&guide_, guide_samples_.empty() ? nullptr : &guide_samples_[number], guide_stride);
        if (arrivals_) gatherer.log_arrivals(&logs[number], only_arrivals);
        LightPasses passes(*scene_, film);
        if (film.wants_light_parts() && !only_arrivals) gatherer.separate(&passes);
        for (int y = row * kTile; y < std::min((row + 1) * kTile, height); ++y) {
          for (int x = column * kTile; x < std::min((column + 1) * kTile, width); ++x) {
            const int px = film.x0() + x, py = film.y0() + y;
            const uint32_t first = only_arrivals ? sample : film.samples_of(px, py);
            const uint32_t end = only_arrivals ? sample + 1 : film.goal_of(px, py, pass_ + 1);
            for (uint32_t index = first; index < end; ++index) {
              if (stop.load(std::memory_order_relaxed)) return;
              Sampler& sampler = gatherer.start(uint32_t(py) * uint32_t(full_width) + uint32_t(px), index);
              const Vec2 offset = filter_.sample(sampler.get_2d());
              const Vec2 on_film(float(px) + 0.5f + offset.x, float(py) + 0.5f + offset.y);
              const Vec2 u_lens = scene_->camera().has_lens() ? sampler.get_2d() : Vec2(0.5f);
              visit(gatherer, px, py, scene_->camera().generate_ray(on_film, u_lens, time));
            }
          }
        }
        Counters& c = counters.local();
        c.rays += gatherer.rays();
        c.gathered += gatherer.gathered();
        c.from_sites += gatherer.from_sites();
        c.beyond.add(gatherer.beyond());
      },
      tbb::simple_partitioner());
  counters.combine_each([&](const Counters& c) {
    rays_ += c.rays, gathered_ += c.gathered, from_sites_ += c.from_sites;
    beyond_.add(c.beyond);
  });
  if (arrivals_ && !stop.load(std::memory_order_relaxed)) arrivals_->add(logs);
}

void GatherPasses::log_lookups(const Film& film, const std::atomic<bool>& stop) {
  // Several samples per pixel if there are few pixels compared with photons.
  const double lookups = double(film.width()) * film.height() * gather_.rays;
  const auto samples = uint32_t(
      std::ceil(std::min(double(ArrivalMap::kMaxLookups), kLookupPilotShare * double(photon_count())) / lookups));
  for (uint32_t sample = 0; sample < samples; ++sample)
    for_each_pixel(film, hash_combine(seed_, 0x73636f75U), sample, true, stop,
                   [](PhotonGatherer& gatherer, int, int, const Ray& ray) {
                     float alpha = 1.0f;
                     Color seen;
                     if (!sees_nothing(ray)) gatherer.trace(ray, nullptr, alpha, seen);
                   });
  lookup_pilot_rays_ = rays_;
}

/// Training step with the results of gather rays since the last one.
void GatherPasses::learn(float past_share) {
  std::vector<GuideSample> samples;
  for (std::vector<GuideSample>& tile : guide_samples_) {
    samples.insert(samples.end(), tile.begin(), tile.end());
    tile.clear();
  }
  guide_.learn(samples, past_share);
}

void GatherPasses::render(Film& film, const std::atomic<bool>& stop) {
  if (pass_ == 0) {
    guide_samples_.resize(size_t((film.width() + kTile - 1) / kTile) * size_t((film.height() + kTile - 1) / kTile));
    further_.prepare(*scene_, film, filter_, seed_, kFurtherSeen);
  }
  tbb::combinable<uint64_t> seen_rays([] { return uint64_t(0); });
  for_each_pixel(film, seed_, pass_, false, stop, [&](PhotonGatherer& gatherer, int px, int py, const Ray& ray) {
    SampleRecord record;
    SampleAux* const aux = record.begin(film, px, py);
    float alpha = 1.0f;
    Color seen(0.0f);
    const uint64_t rays_before = gatherer.rays();
    const Color rest = sees_nothing(ray) ? Color(0.0f) : gatherer.trace(ray, aux, alpha, seen);
    // Light that is seen directly is separate only where there are no media.
    if (further_.active() && !media_ && !gatherer.passes())
      seen = further_.mean_with(
          seen, gatherer.polished(), luminance(rest), px, py, [&](Vec2 on_film, Sampler& sampler) {
            const Vec2 u_lens = scene_->camera().has_lens() ? sampler.get_2d() : Vec2(0.5f);
            const Ray further = scene_->camera().generate_ray(on_film, u_lens, sample_time(*scene_, sampler));
            return sees_nothing(further) ? Color(0.0f) : trace_seen_light(*scene_, further, sampler, seen_rays.local());
          });
    if (film.add_sample(px, py, rest + seen, alpha, aux)) {
      if (gatherer.passes()) film.add_parts(px, py, gatherer.passes()->parts());
      if (film.wants_direct()) film.add_direct(px, py, seen + gatherer.direct_paths());
    }
    film.add_rays(px, py, gatherer.rays() - rays_before);
  });
  seen_rays.combine_each([&](uint64_t rays) { seen_rays_ += rays; });
  paths_ += uint64_t(film.width()) * uint64_t(film.height());
  ++pass_;
  if (beyond_.samples() > 0 && std::has_single_bit(pass_))
    gather_.beyond_terminator = beyond_.probability(kBeyondShare * double(rays_));
  if (!stop.load(std::memory_order_relaxed)) further_.learn(pass_, rays_ - lookup_pilot_rays_, seen_rays_);
  if (stop.load(std::memory_order_relaxed) || guide_samples_.empty() || pass_ < first_training_ ||
      !std::has_single_bit(pass_))
    return;
  learn(GuideTree::kPastShare);
  if (pass_ >= kLearnedPasses) guide_samples_.clear();
}

PhotonPoints GatherPasses::photons(uint64_t max_count) const {
  PhotonPoints points;
  const uint32_t flags = arrivals_ ? Photon::kOfChain : 0;  // plain photons do not depend on the camera
  // The selection rounds up in each of the two maps, so the sum can exceed the limit by one.
  const uint64_t stride = PhotonPoints::stride(maps_.global.count(flags) + maps_.caustic.count(flags),
                                               max_count > 1 ? max_count - 1 : max_count);
  maps_.global.add_to(points, stride, flags);
  maps_.caustic.add_to(points, stride, flags);
  return points;
}

void GatherPasses::add_statistics(IntegratorStatistics& s) const {
  s.rays += rays_ + seen_rays_;
  s.extra["seen_light_rays"] = double(seen_rays_);
  s.paths += paths_;
  s.extra["passes"] = double(pass_);
  s.extra["photons"] = double(maps_.global.size());
  s.extra["caustic_photons"] = double(maps_.caustic.size());
  if (arrivals_)
    s.extra["chain_photons"] = double(maps_.global.count(Photon::kOfChain) + maps_.caustic.count(Photon::kOfChain));
  s.extra["irradiance_sites"] = double(maps_.sites.size());
  s.extra["photon_bytes"] = double(maps_.global.memory_bytes() + maps_.caustic.memory_bytes() +
                                   maps_.sites.memory_bytes());
  s.extra["photon_radius"] = double(maps_.global_radius);
  s.extra["caustic_radius"] = double(maps_.caustic_radius);
  s.extra["gather_rays_from_sites"] = gathered_ > 0 ? double(from_sites_) / double(gathered_) : 0.0;
}

}  // namespace ajar
