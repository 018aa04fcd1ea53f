#include "choice/mixture.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace ajar {

namespace {

constexpr uint64_t kTurns = 8;           // that double the samples of a technique
constexpr uint64_t kLeastSamples = 4;    // per pixel of each technique, before the trial ends
constexpr double kLeastOfFirst = 0.2;    // share of the first technique, whose film has the passes of surfaces
constexpr double kLeastOfSecond = 0.15;  // below it, a technique gets no share
constexpr double kShareSteps = 16.0;     // shares are multiples of its inverse: rounding of the denoiser changes none

bool is_halves(const std::string& pass) { return pass == "Halves" || pass == "Direct Halves"; }
bool is_averaged(const std::string& pass) { return pass == "Combined" || !light_group_of(pass).empty(); }

/// For each pixel, the channels of all images, which have `channels` each.
std::vector<float> side_by_side(const std::vector<std::vector<float>>& images, size_t channels) {
  std::vector<float> all(images[0].size() * images.size());
  for (size_t i = 0; i < images[0].size() / channels; ++i)
    for (size_t k = 0; k < images.size(); ++k)
      std::copy_n(&images[k][channels * i], channels, &all[channels * (images.size() * i + k)]);
  return all;
}

const char* label_of(const std::string& integrator) { return find_integrator(integrator).label; }

std::string percent(double share) { return std::to_string(int(std::lround(100.0 * share))) + " %"; }

}  // namespace

bool can_mix(const std::vector<std::string>& passes) {
  return std::all_of(passes.begin(), passes.end(), [](const std::string& pass) {
    const bool of_first = is_surface_pass(pass) || matte_pass(pass) || aov_pass(pass) || pass == "Vector" ||
                          pass == "AO" || pass == "Roughness";
    return of_first || is_halves(pass) || is_averaged(pass);
  });
}

std::vector<std::string> Mixture::passes_of_others(const std::vector<std::string>& passes) {
  std::vector<std::string> light;
  std::copy_if(passes.begin(), passes.end(), std::back_inserter(light),
               [](const std::string& pass) { return is_halves(pass) || is_averaged(pass); });
  return light;
}

Mixture::Mixture(Learned::Mixed choice, Part first, std::vector<std::unique_ptr<Integrator>> others,
                 const RenderSettings& s)
    : choice_(std::move(choice)), integrators_(std::move(others)) {
  parts_.push_back(first);
  for (const auto& integrator : integrators_) {
    films_.push_back(make_film(s, passes_of_others(s.passes)));
    parts_.push_back({*integrator, *films_.back()});
  }
}

double Mixture::work(size_t technique) const {
  return double(parts_[technique].integrator.statistics().rays) * choice_.techniques[technique].ray_cost;
}

Mixture::Part& Mixture::due() {
  if (turn_samples_ > 0) return parts_[turn_];
  double least = kInfinity;
  for (size_t k = 0; k < parts_.size(); ++k) {
    const double relative = parts_[k].done == 0 ? -1.0 : work(k) / choice_.techniques[k].share;
    if (relative < least) least = relative, turn_ = k;
  }
  turn_samples_ = std::max<uint64_t>(1, std::bit_floor(parts_[turn_].done) / kTurns);
  return parts_[turn_];
}

void Mixture::add_done(uint64_t samples) {
  parts_[turn_].done += samples;
  turn_samples_ -= std::min(samples, turn_samples_);
}

bool Mixture::trial_ends() const {
  if (!(choice_.trial_work > 0.0) || turn_samples_ > 0) return false;
  double all = 0.0;
  for (size_t k = 0; k < parts_.size(); ++k) {
    if (parts_[k].done < kLeastSamples) return false;
    all += work(k);
  }
  return all >= choice_.trial_work;
}

PlanStep Mixture::share_by(const std::vector<double>& errors) {
  choice_.trial_work = 0.0;
  auto& techniques = choice_.techniques;
  const bool known = errors.size() == parts_.size() &&
                     std::all_of(errors.begin(), errors.end(), [](double e) { return e > 0.0; });
  std::vector<size_t> order(parts_.size());
  std::iota(order.begin(), order.end(), size_t(0));
  if (known) std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return errors[a] < errors[b]; });
  const size_t best = order[0], second = order[1];
  double of_best = 0.5;
  if (known) {
    const double ratio = errors[second] / errors[best], least = best == 0 ? kLeastOfSecond : kLeastOfFirst;
    of_best = std::round(kShareSteps * ratio * ratio / (ratio * ratio + 1.0)) / kShareSteps;
    if (1.0 - of_best < least) of_best = 1.0;
  }
  std::vector<double> shares(parts_.size(), 0.0);
  shares[best] = of_best;
  shares[second] = 1.0 - of_best;
  if (!(shares[0] >= kLeastOfFirst)) {  // instead of the second best
    std::fill(shares.begin(), shares.end(), 0.0);
    shares[0] = kLeastOfFirst;
    shares[best] = 1.0 - kLeastOfFirst;
  }
  std::string reason;
  for (size_t k = 0; k < parts_.size(); ++k) {
    techniques[k].share = shares[k];
    char error[48] = "";
    if (known) std::snprintf(error, sizeof error, ", error after denoising %.2g", errors[k]);
    reason += (k > 0 ? "; " : "") + std::string(label_of(techniques[k].integrator)) + " " + percent(shares[k]) + error;
  }
  for (size_t k = parts_.size(); k-- > 1;)
    if (!(shares[k] > 0.0)) remove(k);
  return {"shares of the work", true, reason, "estimates of the error of each image"};
}

uint64_t Mixture::samples_for(double work) const {
  double samples = 0.0;
  for (size_t k = 0; k < parts_.size(); ++k)
    samples += choice_.techniques[k].share * work * double(parts_[k].done) / std::max(1.0, this->work(k));
  return uint64_t(samples);
}

void Mixture::remove(size_t technique) {
  const auto at = std::ptrdiff_t(technique);
  const IntegratorStatistics statistics = parts_[technique].integrator.statistics();
  removed_rays_ += statistics.rays;
  removed_paths_ += statistics.paths;
  choice_.techniques.erase(choice_.techniques.begin() + at);
  // Part holds references, so that it cannot be assigned.
  std::vector<Part> rest;
  for (size_t k = 0; k < parts_.size(); ++k)
    if (k != technique) rest.push_back(parts_[k]);
  parts_.swap(rest);
  integrators_.erase(integrators_.begin() + at - 1);
  films_.erase(films_.begin() + at - 1);
}

std::vector<double> Mixture::weights() const {
  std::vector<double> weights;
  double sum = 0.0;
  for (size_t k = 0; k < parts_.size(); ++k) {
    const bool has_image = parts_[k].film.sample_counts().min > 0;
    weights.push_back(has_image ? work(k) / choice_.techniques[k].noise : 0.0);
    sum += weights.back();
  }
  for (double& w : weights) w = sum > 0.0 ? w / sum : 0.0;
  if (!(sum > 0.0)) weights[0] = 1.0;
  return weights;
}

std::vector<float> Mixture::of_all(const std::string& pass, std::vector<float> of_first, float exposure) const {
  if (!(is_halves(pass) || is_averaged(pass))) return of_first;
  const std::vector<double> w = weights();
  std::vector<std::vector<float>> halves;
  if (is_halves(pass)) halves.push_back(std::move(of_first));
  for (float& v : of_first) v *= float(w[0]);
  for (size_t k = 1; k < parts_.size(); ++k) {
    if (!(w[k] > 0.0)) continue;
    std::vector<float> image = parts_[k].film.resolve(pass, exposure);
    if (is_halves(pass))
      halves.push_back(std::move(image));
    else
      for (size_t i = 0; i < image.size(); ++i) of_first[i] += float(w[k]) * image[i];
  }
  return is_halves(pass) ? side_by_side(halves, size_t(channels_of_pass(pass))) : of_first;
}

void Mixture::add_to(IntegratorStatistics& statistics) const {
  statistics.rays += removed_rays_;
  statistics.paths += removed_paths_;
  for (const auto& integrator : integrators_) {
    const IntegratorStatistics other = integrator->statistics();
    statistics.rays += other.rays;
    statistics.paths += other.paths;
    statistics.extra.insert(other.extra.begin(), other.extra.end());  // counts that the first does not have
    if (statistics.hints.empty()) statistics.hints = other.hints;
  }
}

void Mixture::add_to(Film::SampleCounts& counts) const {
  for (const auto& film : films_) {
    const Film::SampleCounts other = film->sample_counts();
    counts.mean += other.mean;
    counts.min += other.min;
    counts.max += other.max;
  }
}

uint64_t Mixture::film_bytes() const {
  return std::accumulate(films_.begin(), films_.end(), uint64_t(0),
                         [](uint64_t sum, const auto& film) { return sum + film->memory_bytes(); });
}

uint64_t Mixture::refused() const {
  return std::accumulate(films_.begin(), films_.end(), uint64_t(0),
                         [](uint64_t sum, const auto& film) { return sum + film->refused(); });
}

Film::ErrorEstimate Mixture::estimated_error() const {
  const std::vector<double> w = weights();
  Film::ErrorEstimate sum{0.0, 0.0};
  for (size_t k = 0; k < parts_.size(); ++k) {
    const Film::ErrorEstimate one = parts_[k].film.estimated_error(uint32_t(parts_[k].done));
    if (one.relmse < 0.0) return {-1.0, -1.0};
    sum.relmse += w[k] * w[k] * one.relmse;
    sum.perceptual += w[k] * w[k] * one.perceptual;
  }
  return sum;
}

}  // namespace ajar
