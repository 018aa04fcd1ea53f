#include "transport/direct/estimators/pmc_hi.h"

#include <bit>
#include <cmath>

namespace ajar {

namespace {

using M = LightMixture;

constexpr float kFloor = 0.04f;       ///< minimum share of components that alone may cover part of the integrand
constexpr float kPriorCount = 16.0f;  ///< pseudo-samples of the prior of the shares
constexpr float kCellPixels = 16.0f;  ///< edge of a cell in pixels of the camera
constexpr uint32_t kCellsLog2 = 16;
constexpr int kMaxPilotSamples = 4;    ///< maximum number of samples per estimate while it learns
constexpr int kShownBranches = 16;     ///< branches of the light tree, for showing its halves where nothing was learned
constexpr uint32_t kScaleRays = 1024;  ///< camera rays that determine the scale of the recorded values

/// The ids of the branches at which the two halves of the light tree begin, and at which the second half ends. Empty if
/// the tree has only one light.
std::vector<uint32_t> halves_of(const LightSet& lights, Vec3 center) {
  std::vector<LightSet::Branch> branches;
  lights.cut(center, 0.0f, Vec3(0.0f), 1, branches);
  // For this cut, the tree is one branch, before the distant lights.
  const size_t split = branches.size() + 1;
  lights.cut(center, 0.0f, Vec3(0.0f), int(split), branches);
  if (branches.size() != split) return {};
  return {branches[0].id, branches[1].id, split > 2 ? branches[2].id : ~0u};
}

/// The mean luminance of direct light where there is any, from a few camera rays. `reach` becomes the mean distance of
/// their hits.
float typical_luminance(const Scene& scene, float& reach) {
  const Camera& camera = scene.camera();
  double sum = 0.0;
  int counted = 0, hits = 0;
  uint64_t rays = 0;
  for (uint32_t i = 0; i < kScaleRays; ++i) {
    Sampler sampler(Sampler::Kind::Sobol, 0x9107u);
    sampler.start(0, i);
    Ray ray = camera.generate_ray(sampler.get_2d() * Vec2(float(camera.width()), float(camera.height())), Vec2(0.5f),
                                  0.0f);
    const Hit hit = scene.intersect(ray, kRayCamera);
    if (!hit.found()) continue;
    reach += (hit.t - reach) / float(++hits);
    ShadingPoint point;
    SurfaceShading shading;
    scene.shading_point(ray, hit, point);
    scene.material(hit).evaluate_surface(point, shading);
    if (!shading.bsdf.has_non_delta()) continue;
    DirectVertex vertex;
    const float y = luminance_of(
        MisDirectLight().estimate({scene, point, shading.bsdf, 0, 0, 0}, sampler, 6, vertex, nullptr, rays));
    if (!(y > 0.0f) || !std::isfinite(y)) continue;
    sum += double(y);
    ++counted;
  }
  return counted > 0 ? float(sum / counted) : 1.0f;
}

}  // namespace

PmcHi::PmcHi(const Scene& scene, const DirectRequest& request)
    : DirectEstimator(scene, request), lobes_apart_(request.lobes_apart) {
  const LightSet& lights = scene.lights();
  if (!lights.can_choose()) return;
  // With a single light, there is no choice.
  size_t choices = 0;
  for (const LightSet::SourceRange& source : lights.sources()) {
    choices += source.count;
    if (shown_lights_.size() < 2) shown_lights_.push_back(source.first);
  }
  if (choices < 2 && samples_ == 1) return;
  if (choices > 2) {
    shown_lights_.clear();
    shown_branches_ = halves_of(lights, scene.center());
  }
  const Camera& camera = scene.camera();
  const Vec2 middle(0.5f * float(camera.width()), 0.5f * float(camera.height()));
  const Ray a = camera.generate_ray(middle, Vec2(0.5f), 0.0f),
            b = camera.generate_ray(middle + Vec2(1, 0), Vec2(0.5f), 0.0f);
  angle_ = kCellPixels * std::max(glm::length(a.direction - b.direction), 1e-5f);
  const float scale = typical_luminance(scene, reach_);
  cuts_ = std::make_shared<LightCutCache>(lights, camera.position(), angle_, scale);
  mixture_.set_choices(cuts_.get());
  if (samples_ > 1) many_ = ShareCache(kCellsLog2, M::kFirstGroup, kPriorCount, scale);
}

std::shared_ptr<const LearnedLights> PmcHi::past() const {
  if (!cuts_ || cuts_->learning()) return nullptr;
  return std::make_shared<const LearnedLights>(LearnedLights{cuts_, many_.copied(0), scene_.lights().fingerprint()});
}

std::string PmcHi::begin_with(const LearnedLights& past) {
  if (!cuts_) return "there are no lights to choose among";
  if (past.lights != scene_.lights().fingerprint()) return "the lights have changed";
  if (past.many.components() != many_.components()) return "the number of direct samples has changed";
  if (!past.cuts->suits(scene_.camera().position(), angle_, reach_))
    return "the camera has moved far since the learning began";
  cuts_ = std::make_shared<LightCutCache>(*past.cuts, scene_.lights());
  mixture_.set_choices(cuts_.get());
  many_ = past.many.copied(1);
  return {};
}

void PmcHi::learn() {
  if (cuts_) cuts_->publish();
  if (many_.components() > 0) many_.publish();
}

/// The floors of the lobes sum to the floor of a single component for the BSDF. The prior of a lobe is at least half of
/// its selection probability, so each lobe keeps at least half of the coverage that it would have in the single
/// component.
M::Kernel PmcHi::learned_kernel(const LobeComponents& lobes, uint32_t cell) const {
  M::Kernel k{lobes};
  k.count = M::kFirstGroup;
  std::array<float, M::kFirstGroup> prior{}, floors{};
  for (int i = 0; i < lobes.count(); ++i) {
    prior[size_t(i)] = 0.5f * lobes.prior(i);
    floors[size_t(i)] = kFloor * lobes.prior(i);
  }
  prior[M::kAny] = 0.5f;
  floors[M::kAny] = kFloor;
  many_.shares(cell, prior, floors, {k.alpha.data(), M::kFirstGroup});
  return k;
}

/// Positions are jittered by half a cell, which blends neighbouring cells. For points that the camera sees, all samples
/// of a pixel have the same jitter. Samples that choose by different shares are not stratified together, which can cost
/// more than learning gains.
uint64_t PmcHi::cell_key(const DirectLightContext& c) const {
  const Vec3 p = c.point.position;
  const uint32_t jitter = c.point.ray_depth == 0
                              ? hash_combine(uint32_t(c.pixel_x), uint32_t(c.pixel_y))
                              : hash32(std::bit_cast<uint32_t>(p.x) ^
                                       hash32(std::bit_cast<uint32_t>(p.y) ^ hash32(std::bit_cast<uint32_t>(p.z))));
  return cuts_->key(p, c.bsdf.receiving_normal(), c.material, jitter);
}

Color PmcHi::one_sample(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex& vertex,
                        SampleAux* aux, uint64_t& rays) const {
  if (!cuts_) return DirectEstimator::one_sample(c, sampler, first, vertex, aux, rays);
  vertex.cell = cuts_->cell(cell_key(c));
  LightCutCache::Choice chosen;
  const Color estimate = sample_light(c, sampler, first, vertex.cell, chosen, rays, [](LightFlags) { return true; });
  if (chosen.choice.pmf > 0.0f) cuts_->record(vertex.cell, chosen, luminance_of(estimate));
  record_light_shares(c, vertex.cell, 1.0f, aux);
  return estimate;
}

Color PmcHi::many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                          uint64_t& rays) const {
  vertex.complete = true;
  const LobeComponents lobes(c.bsdf, c.point.wo, lobes_apart_);
  if (!cuts_) return mean_of_draws(c, mixture_.kernel(lobes, 0.5f, M::Lights::Any), sampler, false, rays);

  const uint64_t key = cell_key(c);
  const uint32_t cell = many_.cell(hash64(key + lobes.signature()));
  M::Kernel k = learned_kernel(lobes, cell);
  vertex.cell = k.cell = cuts_->cell(key);
  const bool learning = wants_pilot();
  const int n = learning ? std::min(samples_, kMaxPilotSamples) : samples_;
  Color sum(0.0f);
  mixture_.for_each_draw({c, k, rays}, n, 0, sampler, [&](int component, const M::Draw& draw) {
    sum += draw.y;
    if (!learning) return;
    const float y = luminance_of(draw.y);
    if (component == M::kAny && draw.choice.share > 0.0f) cuts_->record(k.cell, draw.choice, y);
    many_.count(cell);
    many_.add_square(cell, y * y);
    // alpha_k rho_k y^2 [Fan 2006, eq. 5.8 with second moments].
    for (int i = 0; y > 0.0f && i < k.count; ++i)
      many_.add_moment(cell, i, k.alpha[size_t(i)] * draw.responsible[size_t(i)] * y);
  });
  mixture_.record_shares(k, aux);
  record_light_shares(c, k.cell, k.alpha[M::kAny], aux);
  return sum / float(n);
}

/// `share`, divided between the two lights or between the two halves of the light tree.
void PmcHi::record_light_shares(const DirectLightContext& c, uint32_t cell, float share, SampleAux* aux) const {
  if (!aux) return;
  const Vec3 p = c.point.position, n = c.bsdf.receiving_normal();
  for (size_t i = 0; i < shown_lights_.size(); ++i)
    aux->shares[1 + i] = share * mixture_.choice_pmf(cell, p, n, shown_lights_[i]);
  if (shown_branches_.empty()) return;
  if (cell != LightCutCache::kNone) {
    for (size_t i = 0; i < 2; ++i)
      aux->shares[1 + i] = share * cuts_->share_between(cell, shown_branches_[i], shown_branches_[i + 1]);
    return;
  }
  std::vector<LightSet::Branch> branches;
  scene_.lights().cut(p, 0.0f, n, kShownBranches, branches);
  for (const LightSet::Branch& branch : branches) {
    for (size_t i = 0; i < 2; ++i)
      if (branch.id >= shown_branches_[i] && branch.id < shown_branches_[i + 1])
        aux->shares[1 + i] += share * branch.share;
  }
}

}  // namespace ajar
