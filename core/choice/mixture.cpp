#include "choice/mixture.h"

#include <algorithm>
#include <cmath>

namespace ajar {

namespace {

bool is_halves(const std::string& pass) { return pass == "Halves" || pass == "Direct Halves"; }
bool is_averaged(const std::string& pass) { return pass == "Combined" || !light_group_of(pass).empty(); }

/// For each pixel, all channels of one and then all of two.
std::vector<float> side_by_side(const std::vector<float>& one, const std::vector<float>& two, size_t channels) {
  std::vector<float> both(one.size() + two.size());
  for (size_t i = 0; i < one.size() / channels; ++i) {
    std::copy_n(&one[channels * i], channels, &both[2 * channels * i]);
    std::copy_n(&two[channels * i], channels, &both[2 * channels * i + channels]);
  }
  return both;
}

double work(const Integrator& integrator, double ray_cost) { return double(integrator.statistics().rays) * ray_cost; }

}  // namespace

bool can_mix(const std::vector<std::string>& passes) {
  return std::all_of(passes.begin(), passes.end(), [](const std::string& pass) {
    const bool of_first = is_surface_pass(pass) || matte_pass(pass) || aov_pass(pass) || pass == "Vector" ||
                          pass == "AO" || pass == "Roughness";
    return of_first || is_halves(pass) || is_averaged(pass);
  });
}

std::vector<std::string> Mixture::passes_of_second(const std::vector<std::string>& passes) {
  std::vector<std::string> light;
  std::copy_if(passes.begin(), passes.end(), std::back_inserter(light),
               [](const std::string& pass) { return is_halves(pass) || is_averaged(pass); });
  return light;
}

Mixture::Mixture(Learned::Second choice, std::unique_ptr<Integrator> second, const RenderSettings& s)
    : choice_(std::move(choice)),
      second_(std::move(second)),
      film_(std::make_unique<Film>(s.region[0], s.region[1], s.region[2], s.region[3], passes_of_second(s.passes))) {}

bool Mixture::is_due(const Integrator& first) const {
  return work(*second_, choice_.ray_cost[1]) * (1.0 - choice_.share) < work(first, choice_.ray_cost[0]) * choice_.share;
}

double Mixture::weight_of_first(const Integrator& first) const {
  const double one = work(first, choice_.ray_cost[0]) / choice_.noise[0],
               two = work(*second_, choice_.ray_cost[1]) / choice_.noise[1];
  return one + two > 0.0 ? one / (one + two) : 1.0;
}

std::vector<float> Mixture::of_both(const std::string& pass, std::vector<float> of_first, const Integrator& first,
                                    float exposure) const {
  if (film_->sample_counts().min == 0 || !(is_halves(pass) || is_averaged(pass))) return of_first;
  const std::vector<float> of_second = film_->resolve(pass, exposure);
  if (is_halves(pass)) return side_by_side(of_first, of_second, size_t(channels_of_pass(pass)));
  const auto w = float(weight_of_first(first));
  for (size_t i = 0; i < of_first.size(); ++i) of_first[i] = w * of_first[i] + (1.0f - w) * of_second[i];
  return of_first;
}

void Mixture::add_to(IntegratorStatistics& statistics) const {
  const IntegratorStatistics of_second = second_->statistics();
  statistics.rays += of_second.rays;
  statistics.paths += of_second.paths;
  statistics.extra.insert(of_second.extra.begin(), of_second.extra.end());  // counts that the first does not have
  if (statistics.hints.empty()) statistics.hints = of_second.hints;
}

void Mixture::add_to(Film::SampleCounts& counts) const {
  const Film::SampleCounts of_second = film_->sample_counts();
  counts.mean += of_second.mean;
  counts.min += of_second.min;
  counts.max += of_second.max;
}

Film::ErrorEstimate Mixture::error_of_both(Film::ErrorEstimate of_first, const Integrator& first) const {
  const Film::ErrorEstimate of_second = film_->estimated_error(uint32_t(done_));
  if (of_first.relmse < 0.0 || of_second.relmse < 0.0) return {-1.0, -1.0};
  const double w = weight_of_first(first);
  const auto mean = [w](double one, double two) { return w * w * one + (1.0 - w) * (1.0 - w) * two; };
  return {mean(of_first.relmse, of_second.relmse), mean(of_first.perceptual, of_second.perceptual)};
}

}  // namespace ajar
