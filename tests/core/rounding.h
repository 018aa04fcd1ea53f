// How much of a picture's error is the rounding of floats, against its noise.
//
// The same samples are rendered with every operation of the renderer, Embree's included, rounded to nearest, up and
// towards zero [Vignes 1993, "A stochastic arithmetic for reliable scientific computation"; Parker 1997, "Monte Carlo
// Arithmetic"]. Where pictures differ, floats made the difference: nearest rounding errs by half a unit at most and
// either way, the directed ones by up to a whole one and always the same way, so what they change is an upper estimate
// of what doubles would. Two things are told apart over independent seeds: samples that go another way (a ray passes an
// edge on the other side), whose difference is noise and falls with their number as all noise does, and what remains of
// the mean. The scene is built once, rounding to nearest. Not seen: what no operation rounds, as margins that rays keep
// from surfaces.
#pragma once

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "integrators/integrator.h"
#include "math/statistics.h"

namespace ajar::rounding {

struct Mode {
  const char* name;
  int mode;
};
/// Together they round positive and negative numbers both ways. Rounding down is left out: then x - x is -0, and a
/// frame around a normal with z = -0 is another one than with 0, as good but with other samples; that is no rounding
/// error.
inline constexpr Mode kDirected[] = {{"up", FE_UPWARD}, {"towards zero", FE_TOWARDZERO}};
constexpr double kSamples = 4096.0;  ///< that noise is compared at

/// In standard deviations of the noise: square root of the mean square over pixels and channels, over that of the noise
/// of as many samples.
struct Share {
  const char* mode;
  double straying;                        ///< samples that go another way; the same for any number of samples
  double shift;                           ///< of the mean, at 4096 samples a pixel
  double resolution;                      ///< shifts below this cannot be told from what straying samples leave
  double mean_change, mean_change_error;  ///< of the mean of the whole picture, relative, and its standard error
  double total() const { return std::sqrt(straying * straying + shift * shift); }
};

/// Pictures of `seeds` seeds, a row each. `obeyed`: whether all threads rounded so.
inline std::vector<std::vector<float>> pictures(const std::shared_ptr<const Scene>& scene,
                                                const std::string& integrator, int samples, int seeds, int mode,
                                                int threads, bool& obeyed) {
  const RenderSettings& s = scene->settings();
  const std::atomic<bool> go_on{false};
  std::vector<std::unique_ptr<Film>> films;
  std::atomic<int> wrong{0};
  std::fesetround(mode);
  {
    tbb::task_arena arena(threads);  // takes over how the thread that makes it rounds, and its workers do
    arena.execute([&] {
      const auto technique = make_integrator(integrator);
      for (int seed = 0; seed < seeds; ++seed) {
        films.push_back(std::make_unique<Film>(0, 0, s.width, s.height, std::vector<std::string>{"Combined"}));
        technique->prepare(scene, uint32_t(seed));
        technique->run_iteration(*films.back(), samples, go_on);
        tbb::parallel_for(0, 16 * threads, [&](int) { wrong += std::fegetround() != mode; });
      }
    });
  }
  std::fesetround(FE_TONEAREST);
  obeyed = wrong == 0;
  std::vector<std::vector<float>> rows;
  for (const auto& film : films) rows.push_back(film->resolve("Combined", 1.0f));
  return rows;
}

/// One share for each directed rounding; none where threads would not round so.
inline std::vector<Share> measure(const std::shared_ptr<const Scene>& scene, const std::string& integrator, int samples,
                                  int seeds, int threads = 1) {
  bool obeyed;
  const auto nearest = pictures(scene, integrator, samples, seeds, FE_TONEAREST, threads, obeyed);
  std::vector<Share> shares;
  for (const Mode& mode : kDirected) {
    const auto other = pictures(scene, integrator, samples, seeds, mode.mode, threads, obeyed);
    if (!obeyed) return {};
    double noise = 0.0, straying = 0.0, shift = 0.0, sum = 0.0;
    std::vector<double> changes(nearest.size(), 0.0);
    for (size_t i = 0; i < nearest[0].size(); ++i) {
      if (i % 4 == 3) continue;
      RunningMoments value, difference;
      for (size_t seed = 0; seed < nearest.size(); ++seed) {
        value.add(double(nearest[seed][i]));
        difference.add(double(other[seed][i]) - double(nearest[seed][i]));
        changes[seed] += double(other[seed][i]) - double(nearest[seed][i]);
      }
      noise += value.variance();
      straying += difference.variance();
      // Without what the straying samples leave in a mean.
      shift += difference.mean() * difference.mean() - difference.variance_of_mean();
      sum += value.mean();
    }
    RunningMoments change;
    for (const double of_seed : changes) change.add(sum > 0.0 ? of_seed / sum : 0.0);
    const double of_4096 = noise * samples / kSamples;
    shares.push_back({mode.name, noise > 0.0 ? std::sqrt(straying / noise) : 0.0,
                      of_4096 > 0.0 ? std::sqrt(std::max(0.0, shift) / of_4096) : 0.0,
                      noise > 0.0 ? std::sqrt(straying / noise * kSamples / double(samples * seeds)) : 0.0,
                      change.mean(), std::sqrt(change.variance_of_mean())});
  }
  return shares;
}

}  // namespace ajar::rounding
