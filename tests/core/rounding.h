// Measures the error of an image by rounding of floats, relative to its noise. The same samples are rendered three
// times: every operation of the renderer and of Embree is rounded to nearest, up, or towards zero [Vignes 1993, "A
// stochastic arithmetic for reliable scientific computation"; Parker 1997, "Monte Carlo Arithmetic"]. Rounding is the
// only cause of differences between these images. Rounding to nearest has an error of at most half a unit in both
// directions. Directed rounding has an error of up to one unit, always in the same direction. The change by directed
// rounding is therefore an upper estimate of the change by doubles. Independent seeds separate two parts. The first
// part are samples whose path changes, for example where a ray passes an edge on the other side; this difference is
// noise and falls with the number of samples. The second part is the remaining change of the mean. The scene is built
// once, with rounding to nearest. The measurement does not include what no operation rounds, such as the margins that
// rays keep from surfaces.
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
/// Together, these modes round positive and negative numbers in both directions. Rounding down is not used: x - x would
/// then be -0, and the frame around a normal with z = -0 differs from that with 0. Both frames are correct but give
/// different samples, which is not a rounding error.
inline constexpr Mode kDirected[] = {{"up", FE_UPWARD}, {"towards zero", FE_TOWARDZERO}};
constexpr double kSamples = 4096.0;  ///< number of samples whose noise is the unit

/// The effect of a rounding mode in standard deviations of the noise: the root mean square over pixels and channels,
/// divided by that of the noise of as many samples.
struct Share {
  const char* mode;
  double straying;                        ///< samples whose path changes; independent of the sample count
  double shift;                           ///< change of the mean, at 4096 samples per pixel
  double resolution;                      ///< smaller shifts cannot be separated from the noise of straying samples
  double mean_change, mean_change_error;  ///< relative change of the mean of the image; its standard error
  double total() const { return std::sqrt(straying * straying + shift * shift); }
};

/// One image for each seed. `obeyed` is set to true if all threads used the rounding mode.
inline std::vector<std::vector<float>> pictures(const std::shared_ptr<const Scene>& scene,
                                                const std::string& integrator, int samples, int seeds, int mode,
                                                int threads, bool& obeyed) {
  const RenderSettings& s = scene->settings();
  const std::atomic<bool> go_on{false};
  std::vector<std::unique_ptr<Film>> films;
  std::atomic<int> wrong{0};
  std::fesetround(mode);
  {
    tbb::task_arena arena(threads);  // its workers inherit the rounding mode of the thread that creates it
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

/// Returns one share for each directed mode, or none if a thread did not use the mode.
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
      // The variance of the straying samples in the mean is subtracted.
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
