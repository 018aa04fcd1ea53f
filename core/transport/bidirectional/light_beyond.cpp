#include "transport/bidirectional/light_beyond.h"

#include <bit>

#include "math/random.h"
#include "transport/paths/shadow_terminator.h"

namespace ajar {

namespace {

constexpr uint32_t kStream = 0x62796E64U;  ///< random numbers of the choice
constexpr uint32_t kLens = 2;              ///< dimension of the sampler
/// The walks may take this number of rays for each ray of a direct sample. Chains take several times as many as direct
/// samples.
constexpr double kShare = 0.5;

}  // namespace

void LightBeyond::prepare(const Scene& scene, uint32_t seed) {
  *this = LightBeyond();
  seed_ = hash_combine(seed, kStream);
  active_ = has_soft_terminator(scene);
}

LightBeyond::Walker::Walker(const LightBeyond& owner, const PathSpace& space, const LightPasses& passes)
    : owner_(owner), scene_(space.scene), walks_(space.scene, 1.0), found_(shown_exposure(space.scene.settings())) {
  walks_.sampled = SampledLights::BeyondTerminator;
  walks_.classes = space.has_subsurface ? PathClasses::NotEyeOnly : PathClasses::Diffuse;
  walks_.media = space.media;
  walks_.guide = space.guide;
  walks_.passes = passes;
}

Color LightBeyond::Walker::sample(Vec2 film, std::optional<float> time, Sampler& sampler, uint32_t pixel,
                                  uint32_t index, Color other, LightPasses* passes) {
  found_.note_sample(other);
  const float probability = owner_.probability_;
  if (!(Pcg32(hash_combine(pixel, index), owner_.seed_).next_float() < probability)) return Color(0.0f);
  sampler.set_dimension(kLens);
  walks_.lens_point = scene_.camera().has_lens() ? sampler.get_2d() : Vec2(0.5f);
  walks_.pass_time = time ? *time : sample_time(scene_, sampler);
  const uint64_t before = walks_.rays();
  Color sum(0.0f);
  for (const FoundPath& path : walks_.sample(film, sampler)) {
    const Color found = path.contribution / probability;
    sum += found;
    if (passes) passes->add(walks_.passes_of(path), found);
  }
  found_.note_found(sum, walks_.rays() - before, probability);
  return sum;
}

void LightBeyond::count(const Walker& walker) {
  rays_ += walker.walks_.rays();
  found_.add(walker.found_);
}

void LightBeyond::learn(uint32_t samples, uint64_t other_rays) {
  if (std::has_single_bit(samples)) probability_ = found_.probability(kShare * double(other_rays));
}

}  // namespace ajar
