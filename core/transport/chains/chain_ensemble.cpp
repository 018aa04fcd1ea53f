#include "transport/chains/chain_ensemble.h"

#include <numeric>

#include <tbb/enumerable_thread_specific.h>

#include "transport/bidirectional/path_seeds.h"

namespace ajar {

namespace {
constexpr uint32_t kSeedBatch = 256;
/// Streams of random numbers: seeds and chains must not share any.
constexpr uint32_t kSeedStream = 0x5eed0000u, kChainStream = 0xc4a10000u;
}  // namespace

/// Returns an estimate of the luminance of the whole film from one bidirectional sample.
template <class Visit>
double ChainEnsemble::visit_seed(BidirectionalWalks& walks, uint32_t index, Visit&& visit) const {
  Sampler sampler(Sampler::Kind::Independent, hash_combine(seed_, kSeedStream));
  sampler.start(index, 0);
  double sum = 0.0;
  for (const FoundPath& path : walks.sample(space_->film_at(sampler.get_2d()), sampler)) {
    if (space_->without_direct && walks.is_direct(path)) continue;
    const double area = path.t > 1 ? space_->film_area() : 1.0;
    const double y = double(luminance(glm::abs(path.contribution))) * double(space_->weight(path.film)) * area;
    if (!(y > 0.0) || !std::isfinite(y)) continue;
    sum += y;
    if (!visit(path, y)) break;
  }
  return sum;
}

std::vector<double> ChainEnsemble::sample_seeds(uint32_t count, const std::atomic<bool>& stop) {
  std::vector<double> values(count, 0.0);
  tbb::enumerable_thread_specific<BidirectionalWalks> walks([&] { return walks_over(*space_); });
  const uint32_t first = seeds_done_;
  tbb::parallel_for(
      tbb::blocked_range<uint32_t>(0, count, kSeedBatch),
      [&](const tbb::blocked_range<uint32_t>& range) {
        if (stop.load(std::memory_order_relaxed)) return;
        BidirectionalWalks& w = walks.local();
        for (uint32_t i = range.begin(); i != range.end(); ++i)
          values[i] = visit_seed(w, first + i, [](const FoundPath&, double) { return true; });
      },
      tbb::simple_partitioner());
  for (const BidirectionalWalks& w : walks) {
    seed_rays_ += w.rays();
    refused_paths_ += w.refused();
  }
  if (stop.load(std::memory_order_relaxed)) return {};
  seeds_done_ += count;
  for (double value : values) brightness_.add(value);
  return values;
}

bool ChainEnsemble::begin(const PathSpace& space, const std::vector<MutationShare>& mutations, uint32_t seed,
                          uint32_t seeds, const std::atomic<bool>& stop) {
  space_ = &space;
  mutations_ = &mutations;
  seed_ = seed;
  first_seeds_ = seeds;
  const std::vector<double> values = sample_seeds(seeds, stop);
  if (values.empty()) return false;
  start_chains(values);
  return true;
}

void ChainEnsemble::start_chains(const std::vector<double>& values) {
  const double total = std::accumulate(values.begin(), values.end(), 0.0);
  if (!(total > 0.0)) return;
  Sampler sampler(Sampler::Kind::Independent, hash_combine(seed_, kSeedStream));
  sampler.start(~0u, 0);
  const double offset = double(sampler.get_1d());
  BidirectionalWalks walks = walks_over(*space_);
  Path path;
  double cumulative = 0.0;
  uint32_t index = 0;
  for (int c = 0; c < kChains; ++c) {
    const double target = (double(c) + offset) / kChains * total;
    while (index + 1 < values.size() && cumulative + values[index] <= target) cumulative += values[index++];
    double left = double(sampler.get_1d()) * values[index];
    const FoundPath* chosen = nullptr;
    visit_seed(walks, index, [&](const FoundPath& found, double y) {
      chosen = &found;
      left -= y;
      return left >= 0.0;
    });
    if (!chosen) continue;
    path.count = walks.copy_path(*chosen, path.vertices.data(), path.edges.data());
    path.film = chosen->film;
    if (!space_->complete(path, 1, path.count - 2)) {
      ++failed_starts_;
      continue;
    }
    chains_.push_back({Chain(*mutations_), Sampler(Sampler::Kind::Independent, hash_combine(seed_, kChainStream))});
    chains_.back().chain.start(path);
    chains_.back().sampler.start(uint32_t(c), 0);
  }
}

void ChainEnsemble::count_steps() {
  steps_done_ = 0;
  for (const Numbered& numbered : chains_) steps_done_ += numbered.steps;
}

uint64_t ChainEnsemble::rays() const {
  uint64_t rays = seed_rays_;
  for (const Numbered& numbered : chains_) rays += numbered.chain.rays();
  return rays;
}

void ChainEnsemble::add_statistics(std::map<std::string, double>& extra) const {
  if (!mutations_) return;
  extra["chains"] = double(chains_.size());
  extra["mutations"] = double(steps());
  extra["brightness"] = brightness_.mean();
  extra["brightness_relative_error"] = brightness_.mean() > 0.0
                                           ? std::sqrt(brightness_.variance_of_mean()) / brightness_.mean()
                                           : 0.0;
  extra["failed_starts"] = double(failed_starts_);
  extra["refused_paths"] = double(refused_paths_);
  for (size_t m = 0; m < mutations_->size(); ++m) {
    Chain::Counts sum;
    for (const Numbered& numbered : chains_) sum.add(numbered.chain.counts()[m]);
    const std::string name = (*mutations_)[m].mutation->name();
    extra["proposed_" + name] = double(sum.proposed);
    extra["accepted_" + name] = double(sum.accepted);
    extra["empty_" + name] = double(sum.empty);
  }
}

void ChainEnsemble::add_accounts(HintAccount& sum) const {
  for (const Numbered& numbered : chains_) {
    sum.add(numbered.account);
    sum.add_proposals(numbered.chain.hint_counts());
  }
}

std::vector<HintStatistics> ChainEnsemble::hint_statistics(const std::vector<HintReport>& reports,
                                                           double other_light) const {
  HintAccount sum;
  if (hints_) add_accounts(sum);
  return sum.statistics(reports, brightness_.mean() / double(std::max<uint64_t>(1, steps())), other_light);
}

}  // namespace ajar
