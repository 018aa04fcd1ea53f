#include "transport/hints/followed_hints.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

#include "transport/bidirectional/path_seeds.h"
#include "transport/hints/hint_shares.h"

namespace ajar {

namespace {

/// Walks that start along hints, relative to the part of the light along hints. This light is easy to find once hints
/// are followed; the rest of the light is harder to find.
constexpr double kFollowed = 0.3;
constexpr double kMinShare = 0.01;  // of a hint; hints with less are not followed
/// Number of samples that try hints: one for eight pixels, within these bounds.
constexpr double kMinSamples = 512, kMaxSamples = 2048;
constexpr uint32_t kBatch = 64;
constexpr uint32_t kStream = 0x61696d00u;  // separates the random numbers from those of pilots, seeds and chains
constexpr double kLargestSample = 32.0;    // relative to the mean: rare bright samples say little about shares
constexpr double kUsefulLight = 0.3;  // part of the image's light at which mutations by hints have their usual share
constexpr float kMinUse = 0.05f;

}  // namespace

void FollowedHints::clear() {
  attached_ = std::make_shared<const AttachedHints>();
  guide_ = {};
  light_.clear();
  proposed_.clear();
  useful_.clear();
  mutation_use_ = 1.0f;
  rays_ = emission_rays_ = 0;
  emission_ = {};
  starts_.reset();
}

void FollowedHints::begin(std::shared_ptr<const AttachedHints> attached, PathSpace& space, uint32_t seed,
                          const std::atomic<bool>& stop) {
  clear();
  attached_ = std::move(attached);
  if (!hints().empty()) {
    guide_ = HintGuide(hints());
    PathSpace tried = space;
    tried.guide = &guide_;
    learn(tried, seed, stop);
  }
  // The seed of the settings, so that what is learned does not depend on the integrator that asks first.
  const EmissionTask task{space.scene, space.media, space.scene.settings().seed};
  if (attached_->emission) emission_ = attached_->emission->get(task, stop, emission_rays_);
  if (emission_.map) starts_.emplace(emission_.map, emission_.share, guide_.active() ? &guide_ : nullptr);
  space.guide = guide();
}

/// What a sample measures by one of its paths, which is chosen by energy: the part of each component in the density
/// with which a walk from the light takes this path.
struct FollowedHints::Trial {
  double energy = 0.0, left_out = 0.0;
  // For each hint; whole: 1, divided among the hints that could have proposed the path.
  std::vector<double> starts, whole;
  std::vector<double> bounces;  // -1: the path does not pass this bounce
};

FollowedHints::Trial FollowedHints::try_hints(PathSeeds& seeds, Path& path, Sampler& sampler) const {
  Trial trial;
  const double energy = seeds.sample(sampler);
  trial.left_out = seeds.left_out_light();
  sampler.set_dimension(0);
  if (!(energy > 0.0) || !seeds.take(double(sampler.get_1d()), path)) return trial;
  trial.energy = energy;
  const LightSet& lights = seeds.scene().lights();
  trial.whole.assign(hints().size(), 0.0);
  add_hint_shares(lights, hints(), path, 1.0, trial.whole);
  trial.starts.assign(hints().size(), 0.0);
  const PathVertex& light = path.vertices[0];
  if (!light.distant && path.light.pdf_by_power > 0.0f) {
    // In units of the probability of the position by power.
    const double all = double(path.light.pdf_direction) * double(path.light.pdf_origin) /
                       double(path.light.pdf_by_power);
    const LightType type = lights.flags(uint32_t(light.light)).type;
    for (size_t k = 0; k < hints().size(); ++k)
      trial.starts[k] = guide_.probability_of_place(k, uint32_t(light.light), type, light.point.ng) *
                        double(Hints::pdf_solid_angle(hints()[k], 0, light.position(), path.to_eye(0))) / all;
  }
  trial.bounces.assign(guide_.bounces_.size(), -1.0);
  for (int j = 1; j + 1 < path.count - 1; ++j) {
    if (!path.joinable(j)) continue;
    const Vec3 at = path.vertices[size_t(j)].position();
    double factor;
    guide_.shares_at(at, factor);
    for (size_t b = 0; b < guide_.bounces_.size(); ++b) {
      const HintGuide::Bounce& bounce = guide_.bounces_[b];
      if (length_squared(at - bounce.position) > bounce.radius2) continue;
      const double pdf = bounce.share * factor *
                         double(Hints::pdf_solid_angle(hints()[bounce.hint], bounce.vertex, at, path.to_eye(j)));
      trial.bounces[b] = pdf / double(path.scattering[size_t(j)].pdf_walk_to_eye);
    }
  }
  return trial;
}

void FollowedHints::learn(const PathSpace& space, uint32_t seed, const std::atomic<bool>& stop) {
  const auto samples = uint32_t(std::clamp(space.film_area() / 8.0, kMinSamples, kMaxSamples));
  std::vector<Trial> trials(samples);
  std::atomic<uint64_t> rays{0};
  tbb::parallel_for(
      tbb::blocked_range<uint32_t>(0, samples, kBatch),
      [&](const tbb::blocked_range<uint32_t>& range) {
        PathSeeds seeds(space);
        const auto path = std::make_unique<Path>();
        Sampler sampler(Sampler::Kind::Independent, hash_combine(seed, kStream));
        for (uint32_t i = range.begin(); i != range.end() && !stop.load(std::memory_order_relaxed); ++i) {
          sampler.start(i, 0);
          trials[i] = try_hints(seeds, *path, sampler);
        }
        rays.fetch_add(seeds.rays(), std::memory_order_relaxed);
      },
      tbb::simple_partitioner());
  rays_ = rays;
  light_.assign(hints().size(), 0.0);
  proposed_.assign(hints().size(), 0);
  useful_.assign(hints().size(), 0);
  if (stop.load(std::memory_order_relaxed)) return;

  double all = 0.0, left_out = 0.0, counted = 0.0, whole = 0.0;
  for (const Trial& trial : trials) all += trial.energy, left_out += trial.left_out;
  if (!(all > 0.0)) return;  // nothing was found, so the shares stay as they are
  std::vector<double> starts(hints().size(), 0.0), bounces(guide_.bounces_.size(), 0.0), reached = bounces;
  for (const Trial& trial : trials) {
    if (!(trial.energy > 0.0)) continue;
    const double energy = std::min(trial.energy, kLargestSample * all / samples);
    counted += energy;
    for (size_t k = 0; k < hints().size(); ++k) {
      light_[k] += trial.energy * trial.whole[k] / (all + left_out);
      whole += energy * trial.whole[k];
      useful_[k] += trial.starts[k] > 0.0;
      starts[k] += energy * trial.starts[k];
    }
    for (size_t b = 0; b < bounces.size(); ++b) {
      if (trial.bounces[b] < 0.0) continue;
      bounces[b] += energy * trial.bounces[b];
      reached[b] += energy;
    }
  }
  mutation_use_ = std::clamp(float(whole / (kUsefulLight * counted)), kMinUse, 1.0f);
  guide_.start_share_ = 0.0;
  for (size_t k = 0; k < hints().size(); ++k) {
    proposed_[k] = uint64_t(std::llround(guide_.starts_[k] * samples));
    guide_.starts_[k] = starts[k] < kMinShare * counted ? 0.0 : kFollowed * starts[k] / counted;
    guide_.start_share_ += guide_.starts_[k];
  }
  for (size_t b = 0; b < bounces.size(); ++b)
    guide_.bounces_[b].share = reached[b] > 0.0 ? bounces[b] / reached[b] : 0.0;
  std::erase_if(guide_.bounces_,
                [&](const HintGuide::Bounce& b) { return b.share < kMinShare || !(guide_.starts_[b.hint] > 0.0); });
}

std::vector<HintStatistics> FollowedHints::statistics() const {
  std::vector<HintStatistics> all;
  size_t hint = 0;
  for (const HintReport& report : reports()) {
    all.push_back({report});
    if (!report.attached) continue;
    if (hint < light_.size()) {
      all.back().proposed = proposed_[hint];
      all.back().accepted = useful_[hint];
      all.back().energy_share = light_[hint];
    }
    ++hint;
  }
  return all;
}

}  // namespace ajar
