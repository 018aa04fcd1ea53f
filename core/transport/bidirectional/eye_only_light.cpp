#include "transport/bidirectional/eye_only_light.h"

#include <algorithm>
#include <bit>

namespace ajar {

namespace {

constexpr uint32_t kStream = 0x62656c6fU;  ///< random numbers of further walks
constexpr uint32_t kLens = 2;              ///< dimension of the sampler
constexpr uint32_t kMaxWalks = 32;
/// The walks may take this number of rays for each ray of a direct sample. Chains take several times as many as direct
/// samples.
constexpr double kShare = 2.0;

}  // namespace

void EyeOnlyLight::prepare(const Scene& scene, uint32_t seed) {
  *this = EyeOnlyLight();
  seed_ = hash_combine(seed, kStream);
  active_ = scene.has_subsurface() || scene.depends_on_ray_kind();
  if (active_) seen_.resize(size_t(scene.settings().width) * size_t(scene.settings().height));
}

EyeOnlyLight::Walker::Walker(EyeOnlyLight& owner, const PathSpace& space, const LightPasses& passes)
    : owner_(owner), scene_(space.scene), walks_(space.scene, 1.0), further_(Sampler::Kind::Sobol, owner.seed_) {
  walks_.classes = PathClasses::EyeOnly;
  walks_.sampled = SampledLights::Both;
  walks_.media = space.media;
  walks_.guide = space.guide;
  walks_.passes = passes;
}

Color EyeOnlyLight::Walker::found(Vec2 film, Sampler& sampler, LightPasses* passes) {
  Color sum(0.0f);
  for (const FoundPath& path : walks_.sample(film, sampler)) {
    if (walks_.is_direct(path) && !walks_.is_below(path)) continue;  // a direct path (direct_paths.h)
    sum += path.contribution;
    if (passes) passes->add(walks_.passes_of(path), path.contribution);
  }
  return sum;
}

Color EyeOnlyLight::Walker::sample(Vec2 film, std::optional<float> time, Sampler& sampler, uint32_t pixel,
                                   uint32_t index, LightPasses* passes) {
  sampler.set_dimension(kLens);
  walks_.lens_point = scene_.camera().has_lens() ? sampler.get_2d() : Vec2(0.5f);
  walks_.pass_time = time ? *time : sample_time(scene_, sampler);
  const uint64_t before = walks_.rays();
  Color sum = found(film, sampler, passes);
  uint8_t& seen = owner_.seen_[pixel];
  const bool seen_before = seen;
  seen |= uint8_t(walks_.enters_first());
  if (!seen_before) return sum;
  const uint32_t count = passes ? 1 : owner_.walks_, first = owner_.further_ + (index - owner_.samples_) * (count - 1);
  for (uint32_t i = 0; i + 1 < count; ++i) {
    further_.start(pixel, first + i);
    sum += found(film, further_, nullptr);
  }
  ++work_.samples;
  work_.walks += count;
  work_.rays_of_walks += walks_.rays() - before;
  return sum / float(count);
}

void EyeOnlyLight::count(const Walker& walker) {
  work_.rays += walker.rays();
  work_.samples += walker.work_.samples;
  work_.walks += walker.work_.walks;
  work_.rays_of_walks += walker.work_.rays_of_walks;
}

void EyeOnlyLight::learn(uint32_t samples, double pixels, uint64_t other_rays) {
  further_ += (samples - samples_) * (walks_ - 1);
  samples_ = samples;
  if (work_.walks == 0 || !std::has_single_bit(samples)) return;
  const double rays_of_walk = double(work_.rays_of_walks) / double(work_.walks),
               seen = double(work_.samples) / (pixels * samples);
  const double wanted = kShare * double(other_rays) / (pixels * samples) / (seen * rays_of_walk);
  walks_ = uint32_t(std::clamp(wanted, 1.0, double(kMaxWalks)));
}

}  // namespace ajar
