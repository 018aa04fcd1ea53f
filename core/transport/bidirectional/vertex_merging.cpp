#include "transport/bidirectional/vertex_merging.h"

#include <algorithm>
#include <cmath>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "math/statistics.h"
#include "transport/bidirectional/bidirectional.h"
#include "transport/photons/photon_tracer.h"

namespace ajar {

namespace {

constexpr uint32_t kPhotonStream = 0x6d657267u, kProbeStream = 0x6d657268u;
constexpr uint32_t kBlock = 512;  // photon paths in a task
constexpr int kNeighbours = 60;   // maximum in a density estimate
constexpr int kReach = 20;        // photons in a disc of the first pass at the points that the image looks up
constexpr int kProbes = 48;       // per axis of the film, to choose the radius
/// Slightly more than the roughness below which lobes are deltas (microfacet.h).
constexpr float kDeltaRoughness = 0.02f;

/// Whether photons start at a light of the scene. Of light from infinity, starts are tried: bright directions have a
/// high probability.
bool any_sends_photons(const Scene& scene) {
  constexpr uint32_t kTries = 64;
  const LightSet& lights = scene.lights();
  Sampler sampler(Sampler::Kind::Sobol, 0);
  PathVertex start;
  for (uint32_t i = 0; i < lights.size(); ++i) {
    if (!(lights.power_pmf(i) > 0.0f)) continue;
    const uint32_t tries = int(i) == lights.environment_index() ? kTries : 1;
    for (uint32_t k = 0; k < tries; ++k) {
      sampler.start(k, 0);
      const Vec2 u_position = sampler.get_2d(), u_direction = sampler.get_2d();
      const auto ray = lights.sample_le(i, u_position, u_direction, kMidShutter);
      if (!ray) continue;
      make_light_vertex(scene, i, ray->ray.origin, ray->normal, ray->ray.direction, kMidShutter, start);
      if (sends_photons(scene, start)) return true;
    }
  }
  return false;
}

}  // namespace

struct VertexMerging::Workers {
  explicit Workers(const VertexMerging& owner)
      : walks([&owner] {
          BidirectionalWalks walks(*owner.scene_, 1.0);
          walks.guide = owner.guide_;
          walks.media = owner.media_;
          walks.classes = PathClasses::NotEyeOnly;
          return walks;
        }) {}
  tbb::enumerable_thread_specific<BidirectionalWalks> walks;
};

VertexMerging::VertexMerging() = default;
VertexMerging::~VertexMerging() = default;

MergingPlan plan_merging(const Scene& scene) {
  bool rough = false, specular = false;
  for (const ShaderProgram& program : scene.programs()) {
    rough |= program.may_be_rough(kDeltaRoughness);
    specular |= program.may_be_smooth(kDeltaRoughness);
  }
  // The shortest path E S D S L has three bounces, of which the limit counts two.
  if (scene.settings().bounces.total < 2) return {false, "the bounce limits leave nothing to merge"};
  if (!specular) return {false, "no specular material"};
  if (!rough) return {false, "all surfaces are mirrors or clear glass"};
  if (!any_sends_photons(scene))
    return {false, "no light sends photons: an even sky, wide suns and lamps without shadows do not"};
  return {true, "caustics may be seen in mirrors or through glass"};
}

void VertexMerging::prepare(const Scene& scene, const PathMedia* media, bool active, uint32_t seed) {
  scene_ = &scene;
  media_ = media;
  seed_ = seed;
  passes_done_ = 0;
  refused_ = 0;
  workers_.reset();
  guide_ = nullptr;
  map_ = {};
  behind_.clear();
  first_radius_ = radius_ = 0.0f;
  max_vertices_ = max_path_vertices(scene.settings().bounces);
  active_ = active;
  if (active_) workers_ = std::make_unique<Workers>(*this);
}

bool VertexMerging::begin_pass(uint32_t index, const std::atomic<bool>& stop) {
  std::vector<Photon> photons;
  std::vector<Behind> behind;
  time_ = time_of_pass(*scene_, seed_, index);
  if (!trace(index, photons, behind, stop)) return false;
  std::vector<uint32_t> order;
  map_.build(std::move(photons), order);
  behind_.resize(order.size());
  for (size_t i = 0; i < order.size(); ++i) behind_[i] = behind[order[i]];
  if (passes_done_++ == 0) first_radius_ = choose_first_radius();
  radius_ = first_radius_ * float(std::sqrt(radius2_factor(index)));
  map_.look_around(*scene_, {kNeighbours, radius_}, time_, hash_combine(seed_, index));
  return true;
}

bool VertexMerging::trace(uint32_t index, std::vector<Photon>& photons, std::vector<Behind>& behind,
                          const std::atomic<bool>& stop) {
  const RenderSettings& settings = scene_->settings();
  const uint32_t count = settings.photons > 0 ? uint32_t(settings.photons) : photons_of_a_pass(settings) / 2,
                 blocks = (count + kBlock - 1) / kBlock;
  struct Found {
    std::vector<Photon> photons;
    std::vector<Behind> behind;
    uint64_t refused = 0;
  };
  std::vector<Found> parts(blocks);
  tbb::parallel_for(0u, blocks, [&](uint32_t block) {
    if (stop.load(std::memory_order_relaxed)) return;
    BidirectionalWalks& walks = workers_->walks.local();
    walks.pass_time = time_;
    Sampler sampler(Sampler::Kind::Sobol, hash_combine(seed_, kPhotonStream));
    Found& part = parts[block];
    for (uint32_t i = block * kBlock; i < std::min(count, (block + 1) * kBlock); ++i) {
      sampler.start(index, i);
      walks.walk_photon(sampler, [&](int before, const PathVertex& vertex, Color beta, const ShadingPoint& first) {
        const Vec3 to_light = vertex.point.wo, ng = vertex.point.ng;
        const Color power = beta / float(count);
        if (is_black(power)) return;
        if (!is_finite(power)) {
          ++part.refused;
          return;
        }
        part.photons.push_back({surface_point(vertex.point, glm::dot(ng, to_light) < 0.0f ? -ng : ng), power,
                                pack_direction_short(to_light)});
        const auto since_first = [](int depth, int depth_there) {
          return uint8_t(std::clamp(depth - depth_there, 0, 255));
        };
        part.behind.push_back({uint8_t(before), since_first(vertex.point.diffuse_depth, first.diffuse_depth),
                               since_first(vertex.point.glossy_depth, first.glossy_depth),
                               since_first(vertex.point.transmission_depth, first.transmission_depth),
                               walks.light_of_photon()});
      });
    }
  });
  if (stop.load(std::memory_order_relaxed)) return false;
  for (const Found& part : parts) {
    photons.insert(photons.end(), part.photons.begin(), part.photons.end());
    behind.insert(behind.end(), part.behind.begin(), part.behind.end());
    refused_ += part.refused;
  }
  return true;
}

/// The median distance to photon number kReach, over the points at which the image will look up the map.
float VertexMerging::choose_first_radius() const {
  const RenderSettings& settings = scene_->settings();
  if (settings.photon_radius > 0.0f) return settings.photon_radius;
  const float max_radius = kLargestPhotonRadius * scene_->radius();
  std::vector<float> reaches;
  BidirectionalWalks walks(*scene_, 1.0);
  walks.media = media_;
  walks.classes = PathClasses::NotEyeOnly;
  walks.pass_time = time_;
  Sampler sampler(Sampler::Kind::Independent, hash_combine(seed_, kProbeStream));
  for (int i = 0; i < kProbes * kProbes; ++i) {
    sampler.start(uint32_t(i), 0);
    const Vec2 film((float(i % kProbes) + 0.5f) / kProbes * float(settings.width),
                    (float(i / kProbes) + 0.5f) / kProbes * float(settings.height));
    const PathVertex* vertex = walks.find_merging_vertex(film, sampler);
    if (!vertex) continue;
    const float reach = map_.reach(surface_point(vertex->point, vertex->point.ng), kReach, max_radius);
    if (reach < max_radius) reaches.push_back(reach);
  }
  return median(reaches, max_radius);
}

float VertexMerging::counted(const PathVertex& vertex, int place, const Behind& behind, Vec3 to_light) const {
  const int count = behind.vertices + 1 + place;
  if (count > max_vertices_) return 0.0f;
  const BounceLimits& limits = scene_->settings().bounces;
  if (!BounceCount::matters(limits, count - 3, false)) return 1.0f;
  BounceCount bounces(limits, vertex.point.diffuse_depth + behind.diffuse, vertex.point.glossy_depth + behind.glossy,
                      vertex.point.transmission_depth + behind.transmission);
  bounces.add(vertex, vertex.point.wo, to_light, false);
  return bounces.factor();
}

Color VertexMerging::radiance(const PathVertex& vertex, int place) const {
  return map_.radiance(vertex.point, vertex.shading.bsdf, {kNeighbours, radius_},
                       [&](uint32_t i, Vec3 to_light) { return counted(vertex, place, behind_[i], to_light); });
}

Color VertexMerging::radiance_of_group(const PathVertex& vertex, int place, int group) const {
  return map_.radiance(vertex.point, vertex.shading.bsdf, {kNeighbours, radius_}, [&](uint32_t i, Vec3 to_light) {
    const Behind& behind = behind_[i];
    return scene_->light_group(behind.light) == group ? counted(vertex, place, behind, to_light) : 0.0f;
  });
}

uint64_t VertexMerging::rays() const {
  uint64_t rays = 0;
  if (workers_)
    for (const BidirectionalWalks& walks : workers_->walks) rays += walks.rays();
  return rays;
}

}  // namespace ajar
