#include "transport/hints/emission_training.h"

#include <algorithm>

#include "math/warps.h"
#include "transport/paths/walk.h"

namespace ajar {

namespace {

constexpr uint32_t kRounds = 8;
constexpr uint32_t kStream = 0x6c656d69U;  // separates the random numbers from those of rendering
constexpr int kMaxCrossed = 16;            // surfaces on a straight way to a light
constexpr float kOffSurface = 1e-6f;       // of the scene's radius
constexpr double kProposalShare = 0.1;     // of all values, once photons have found light
constexpr double kLargestValue = 64.0;     // relative to the mean of a round
// Learned starts make walks longer, because fewer of them miss what the image looks at. Where light sampling finds most
// of the light, or where most starts are useful anyway, this costs more than it gains (docs/research/emission.md).
constexpr double kSmallestSharpShare = 0.1, kSmallestGain = 2.0;
constexpr double kLargeGain = 10.0;  // more rounds are worth their time

/// Whether only surfaces that transmit light are between the start and the end of the ray. `entry` becomes the last of
/// them.
bool reaches(const Scene& scene, Ray ray, Vec3& entry, uint64_t& rays) {
  ShadingPoint point;
  SurfaceShading shading;
  for (int crossed = 0; crossed <= kMaxCrossed; ++crossed) {
    const Hit hit = scene.intersect(ray, kLightWalkKind);
    ++rays;
    if (!hit.found()) return true;
    scene.shading_point(ray, hit, point);
    const ShaderProgram& material = scene.material(hit);
    if (material.has_surface()) {
      material.evaluate_surface(point, shading);
      if (is_black(shading.bsdf.transparency()) && !transmits(shading.bsdf)) return false;
    }
    entry = point.position;
    ray = scene.straight_on(point, ray, hit.t);
  }
  return false;
}

/// From places where the image looks up the maps: one way to a light that is sampled there, and one to the world in the
/// direction of a diffuse bounce.
std::vector<LightStart> straight_ways(const EmissionTask& task, const PhotonLookups& lookups, uint64_t& rays) {
  const Scene& scene = task.scene;
  const LightSet& lights = scene.lights();
  const int world = lights.environment_index();
  std::vector<LightStart> starts;
  if (!lights.can_choose()) return starts;
  Sampler sampler(Sampler::Kind::Independent, hash_combine(task.seed, 0x73747261U));
  const auto add = [&](uint32_t light, Vec3 p, Vec3 n, Vec3 wi, float distance, float value, Vec3 origin) {
    Ray ray;
    ray.origin = p + kOffSurface * scene.radius() * n;
    ray.direction = wi;
    ray.time = kMidShutter;
    ray.t_max = distance;
    Vec3 entry = p;
    if (!reaches(scene, ray, entry, rays)) return;
    starts.push_back({light, is_distant(lights.flags(light).type) ? entry : origin, -wi, value});
  };
  for (const auto place : {ArrivalMap::kSeen, ArrivalMap::kGathered}) {
    const std::vector<SurfacePoint>& points = lookups.points(place);
    for (size_t i = 0; i < points.size(); ++i) {
      sampler.start(uint32_t(i), uint32_t(place));
      const Vec3 p = points[i].position, n = unpack_direction(points[i].packed_normal);
      const LightSet::Choice choice = lights.choose(p, n, sampler.get_1d());
      const auto sample = choice.pmf > 0.0f ? lights.sample_li(choice.light, p, sampler.get_2d(), kMidShutter)
                                            : std::nullopt;
      const float part = int(choice.light) == world ? 0.5f : 1.0f;  // the rest follows
      if (const float cosine = sample ? glm::dot(sample->wi, n) : 0.0f; cosine > 0.0f)
        add(choice.light, p, n, sample->wi, sample->distance * (1.0f - 1e-3f),
            part * luminance(sample->radiance) * cosine / (choice.pmf * sample->pdf_solid_angle), sample->position);
      if (world < 0) continue;
      const Vec3 wi = Frame(n).to_world(warp::square_to_cosine_hemisphere(sampler.get_2d()));
      const float radiance = luminance(lights.environment_radiance(wi, 0));
      if (radiance > 0.0f) add(uint32_t(world), p, n, wi, kInfinity, 0.5f * kPi * radiance, p);
    }
  }
  return starts;
}

/// Rare values say little about the starts: values count up to this one.
double largest_value(const std::vector<PhotonValue>& values) {
  double sum = 0.0;
  for (const PhotonValue& v : values) sum += double(v.start.value);
  return values.empty() ? 0.0 : kLargestValue * sum / double(values.size());
}

double sum_of(const std::vector<LightStart>& starts) {
  double sum = 0.0;
  for (const LightStart& start : starts) sum += double(start.value);
  return sum;
}

void scale_to(std::vector<LightStart>& starts, double sum) {
  const double all = sum_of(starts);
  for (LightStart& start : starts) start.value = all > 0.0 ? float(double(start.value) * sum / all) : 0.0f;
}

/// Adds the values of a round to `found`.
void add_round(const PhotonBatch& batch, std::vector<LightStart>& found) {
  const double largest = largest_value(batch.values);
  for (PhotonValue v : batch.values) {
    // Later rounds find more, and count more.
    v.start.value = float(std::min(double(v.start.value), largest) * double(batch.values.size()));
    found.push_back(v.start);
  }
}

/// Chooses the share of walks that start as learned, from a round in which the share `tried` did. The ratio r of the
/// densities of a start with the map and without gives that of q, (r - 1 + tried) / tried, and so the second moment for
/// every share.
void choose_share(const PhotonBatch& batch, float tried, LearnedEmission& learned) {
  constexpr float kShares[] = {0.0f, 0.25f, 0.5f, EmissionGuide::kMaxShare};
  const double largest = largest_value(batch.values);
  double moments[std::size(kShares)] = {};
  for (const PhotonValue& v : batch.values) {
    const double ratio = double(v.density_ratio), square = sqr(std::min(double(v.start.value), largest)) * ratio;
    const double of_map = std::max(0.0, (ratio - 1.0 + double(tried)) / double(tried));
    for (size_t i = 0; i < std::size(kShares); ++i)
      moments[i] += square / (1.0 - double(kShares[i]) + double(kShares[i]) * of_map);
  }
  const size_t best = size_t(std::min_element(std::begin(moments), std::end(moments)) - std::begin(moments));
  learned.share = kShares[best];
  learned.gain = moments[best] > 0.0 ? moments[0] / moments[best] : 1.0;
}

}  // namespace

double sharp_share(const std::vector<PhotonValue>& values) {
  const double largest = largest_value(values);
  double all = 0.0, sharp = 0.0;
  for (const PhotonValue& v : values) {
    const double value = std::min(double(v.start.value), largest);
    all += value;
    if (v.sharp_first) sharp += value;
  }
  return all > 0.0 ? sharp / all : 0.0;
}

LearnedEmission learn_emission(const EmissionTask& task, const std::atomic<bool>& stop) {
  LearnedEmission learned;
  const Scene& scene = task.scene;
  const PhotonPlan plan = plan_photons(scene);
  if (!plan.caustic || scene.lights().empty()) return learned;
  const PhotonLookups lookups(scene, task.media, task.seed);
  if (lookups.empty()) return learned;
  const EmissionMap::Extent extent{lookups.middle(), scene.center(), scene.radius()};
  std::vector<LightStart> proposals = straight_ways(task, lookups, learned.rays), found;
  auto map = std::make_shared<const EmissionMap>(scene.lights(), extent, proposals);
  for (uint32_t round = 0; round < kRounds; ++round) {
    std::optional<EmissionGuide> guide;
    if (!map->empty()) guide.emplace(map, EmissionGuide::kMaxShare, nullptr);
    PhotonEmission emission;
    emission.plan = plan;
    emission.seed = hash_combine(task.seed, kStream);
    emission.pass = round;
    emission.count = kPhotonsOfEmissionRound;
    emission.time = scene.moves() ? kMidShutter : 0.0f;
    emission.guide = guide ? &*guide : nullptr;
    emission.values = &lookups;
    const PhotonBatch batch = trace_photons(scene, task.media, emission, stop);
    if (stop.load(std::memory_order_relaxed)) return {};
    learned.rays += batch.rays;
    add_round(batch, found);
    if (guide) choose_share(batch, EmissionGuide::kMaxShare, learned);
    const bool needed = sharp_share(batch.values) >= kSmallestSharpShare &&
                        (round == 0 || learned.gain >= kSmallestGain);
    if (!needed) return learned;
    std::vector<LightStart> all = proposals;
    if (const double light = sum_of(found); light > 0.0) scale_to(all, kProposalShare * light);
    all.insert(all.end(), found.begin(), found.end());
    map = std::make_shared<const EmissionMap>(scene.lights(), extent, all);
    if (round > 1 && learned.gain < kLargeGain) break;
  }
  if (!map->empty() && learned.share > 0.0f) learned.map = std::move(map);
  return learned;
}

LearnedEmission SharedEmission::get(const EmissionTask& task, const std::atomic<bool>& stop, uint64_t& rays) {
  const std::lock_guard lock(mutex_);
  const Camera& camera = task.scene.camera();
  const Vec3 position = camera.position(), direction = camera.forward(kMidShutter);
  if (!learned_ || position != camera_position_ || direction != camera_direction_) {
    LearnedEmission learned = learn_emission(task, stop);
    rays += learned.rays;
    if (stop.load(std::memory_order_relaxed)) return {};
    learned_ = std::move(learned);
    camera_position_ = position;
    camera_direction_ = direction;
  }
  return *learned_;
}

}  // namespace ajar
