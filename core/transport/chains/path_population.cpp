#include "transport/chains/path_population.h"

#include <algorithm>
#include <numeric>

#include <tbb/parallel_for.h>

#include "sampling/mixture.h"
#include "sampling/population.h"
#include "transport/chains/mutations/caustic_perturbation.h"
#include "transport/chains/mutations/lens_perturbation.h"
#include "transport/chains/mutations/standard_mutations.h"

namespace ajar {

namespace {

constexpr uint32_t kSeedStream = 0x5eed0002u, kDrawStream = 0xd4a30002u, kMoveStream = 0xc4a10002u;
constexpr uint32_t kBatch = 32;
/// Minimum part of the energy for the new samples of a generation: members live some hundred steps.
constexpr double kMinNewShare = 0.16;
constexpr float kBidirectional = 0.05f;  ///< share of bidirectional mutations; new samples have the same purpose
constexpr float kMinShare = 0.05f;       ///< minimum share of a mutation
constexpr double kGainUnits = 0x1p24;
/// A move by this many pixels on the film is as useful as a new path elsewhere.
constexpr float kUsefulDistance = 4.0f;

}  // namespace

PathPopulation::PathPopulation(const PathSpace& space, Size size, uint32_t seed, uint32_t number,
                               const FollowedHints& followed)
    : scene_(space.scene),
      hints_(followed.hints()),
      space_(space),
      size_(size),
      seed_(seed),
      number_(number),
      luminance_(space.film_min, space.film_max, shown_exposure(space.scene.settings())) {
  const auto add = [this](std::unique_ptr<Mutation> mutation, float share, bool renews) {
    mutations_.push_back({std::move(mutation), share});
    renews_.push_back(renews);
  };
  add(std::make_unique<LensPerturbation>(space_, "lens_5", LogarithmicStep{0.25f, 5.0f}), 0.15f, false);
  add(std::make_unique<LensPerturbation>(space_, "lens_10", LogarithmicStep{1.0f, 10.0f}), 0.1f, false);
  add(std::make_unique<LensPerturbation>(space_, "lens_50", LogarithmicStep{5.0f, 50.0f}), 0.1f, false);
  add(std::make_unique<CausticPerturbation>(space_), 0.25f, false);
  mutations_.push_back(renewing_mutation(space_, hints_, followed.mutation_use(), kBidirectional));
  renews_.push_back(true);
  mutation_gains_ = std::vector<MutationGain>(mutations_.size());
  for (const MutationShare& mutation : mutations_) first_shares_.push_back(mutation.share);
  workers_ = std::make_unique<Workers>([this] { return Worker{PathSeeds(space_), Chain(mutations_), {}, {}, 0.0}; });
}

/// Random numbers of a new sample. Each population has its own scramble: shared points would correlate the populations.
Sampler PathPopulation::seed_sampler(uint64_t sample) const {
  Sampler sampler(Sampler::Kind::Sobol, hash_combine(seed_, kSeedStream));
  sampler.start(number_, uint32_t(sample));
  return sampler;
}

bool PathPopulation::sample_seeds(uint32_t count, const std::atomic<bool>& stop) {
  first_new_ = samples_done_;
  new_samples_.resize(count);
  tbb::parallel_for(
      tbb::blocked_range<uint32_t>(0, count, kBatch),
      [&](const tbb::blocked_range<uint32_t>& range) {
        Worker& worker = workers_->local();
        PathSeeds& seeds = worker.seeds;
        for (uint32_t i = range.begin(); i != range.end(); ++i) {
          if (stop.load(std::memory_order_relaxed)) return;
          Sampler sampler = seed_sampler(first_new_ + i);
          const double energy = seeds.sample(sampler);
          new_samples_[i] = {energy, seeds.film()};
          worker.left_out += seeds.left_out_light();
          if (learning_) luminance_.add_sample(seeds.film(), seeds.left_out());
        }
      },
      tbb::simple_partitioner());
  return !stop.load(std::memory_order_relaxed);
}

void PathPopulation::draw() {
  const uint32_t count = uint32_t(new_samples_.size()), old = uint32_t(members_.size());
  const double share = new_share(double(count), double(samples_done_), kMinNewShare);
  samples_done_ += count;
  struct Candidate {
    uint32_t place, index;
  };
  std::vector<Candidate> order(old + count);
  const Vec2 size = space_.film_max - space_.film_min;
  for (uint32_t i = 0; i < old + count; ++i) {
    const Vec2 at = ((i < old ? members_[i].path.film() : new_samples_[i - old].film) - space_.film_min) / size;
    order[i] = {hilbert_index(at.x, at.y), i};
  }
  std::sort(order.begin(), order.end(), [](const Candidate& a, const Candidate& b) {
    return a.place != b.place ? a.place < b.place : a.index < b.index;
  });
  std::vector<double> weights(order.size());
  for (size_t k = 0; k < order.size(); ++k) {
    const uint32_t i = order[k].index;
    weights[k] = i < old ? (1.0 - share) * members_[i].weight : share * new_samples_[i - old].energy / double(count);
  }
  Sampler sampler(Sampler::Kind::Independent, hash_combine(seed_, kDrawStream));
  sampler.start(number_, uint32_t(generation_));
  parents_.assign(size_.members, 0);
  weight_ = systematic_resample(weights, double(sampler.get_1d()), parents_) / double(size_.members);
  for (uint32_t& parent : parents_) parent = order[parent].index;
}

bool PathPopulation::fetch(Worker& worker, uint32_t slot) {
  const uint32_t parent = parents_[slot], old = uint32_t(members_.size());
  if (parent < old) {
    members_[parent].path.unpack(worker.path);
    return true;
  }
  // Copies of one sample are adjacent. They take its paths at equal distances along the cumulative energy.
  uint32_t copies = 1, copy = 0;
  for (uint32_t i = slot; i > 0 && parents_[i - 1] == parent; --i) ++copy, ++copies;
  for (uint32_t i = slot; i + 1 < parents_.size() && parents_[i + 1] == parent; ++i) ++copies;
  Sampler sampler = seed_sampler(first_new_ + (parent - old));
  worker.seeds.sample(sampler);
  Sampler offset(Sampler::Kind::Independent, hash_combine(seed_, kDrawStream ^ 1u));
  offset.start(number_, uint32_t(first_new_ + (parent - old)));
  return worker.seeds.take((double(copy) + double(offset.get_1d())) / double(copies), worker.path);
}

void PathPopulation::move_slot(Film& film, Worker& worker, uint32_t slot, double emphasis) {
  Member& to = moved_[slot];
  if (!fetch(worker, slot)) {
    to.path.clear();
    to.weight = 0.0;
    return;
  }
  to.weight = weight_;
  worker.chain.start(worker.path);
  Sampler sampler(Sampler::Kind::Independent,
                  hash_combine(hash_combine(seed_, kMoveStream + number_), uint32_t(generation_)));
  sampler.start(slot, 0);
  const double scale = emphasis / splat_unit();
  for (uint32_t step = 0; step < size_.steps; ++step) {
    const Chain::Step done = worker.chain.step(sampler, [&](const Path& path, double share) {
      const PathSpace::Place place = space_.place(path.film, sampler.get_2d());
      film.add_splat(place.x, place.y, path.splat(share * weight_ * scale * double(place.weight)), number_ & 1,
                     passes_.of(scene_, path));
      if (!hints_.empty() && (slot + step + generation_) % HintAccount::kStride == 0)
        worker.account.add_state(scene_.lights(), hints_, path,
                                 HintAccount::kStride * share * weight_ / double(space_.importance.at(path.film)));
      if (learning_)
        luminance_.add_flux(path.film, double(luminance_.exposure()) * share * weight_ * path.energy() / path.target);
    });
    if (!learning_) continue;
    const double useful = renews_[done.mutation] ? 1.0 : std::min(1.0, double(done.film_distance / kUsefulDistance));
    mutation_gains_[done.mutation].gain.fetch_add(int64_t(done.acceptance * useful * kGainUnits),
                                                  std::memory_order_relaxed);
    mutation_gains_[done.mutation].rays.fetch_add(1 + int64_t(done.rays), std::memory_order_relaxed);
  }
  to.path.pack(worker.chain.path());
}

double PathPopulation::run_generation(Film& film, double emphasis, const std::atomic<bool>& stop) {
  passes_ = LightPasses(scene_, film);
  if (!sample_seeds(samples_done_ == 0 ? size_.first_samples : size_.samples, stop)) return 0.0;
  draw();
  uint32_t done = size_.members;
  if (weight_ > 0.0) {
    moved_.resize(size_.members);
    std::atomic<uint32_t> moved{0};
    tbb::parallel_for(
        tbb::blocked_range<uint32_t>(0, size_.members, kBatch),
        [&](const tbb::blocked_range<uint32_t>& range) {
          Worker& worker = workers_->local();
          for (uint32_t slot = range.begin(); slot != range.end(); ++slot) {
            if (stop.load(std::memory_order_relaxed)) return;
            move_slot(film, worker, slot, emphasis);
            moved.fetch_add(1, std::memory_order_relaxed);
          }
        },
        tbb::simple_partitioner());
    done = moved;
    members_.swap(moved_);
  }
  ++generation_;
  steps_done_ += uint64_t(done) * size_.steps;
  return double(done) / double(size_.members);
}

PathPopulation::Learned PathPopulation::learned() const {
  Learned learned;
  // The share is the prior share times the relative gain per ray.
  double best = 0.0;
  for (const MutationGain& f : mutation_gains_)
    best = std::max(best, double(f.gain.load()) / std::max<double>(1.0, double(f.rays.load())));
  for (size_t m = 0; m < mutations_.size(); ++m) {
    const double gain = double(mutation_gains_[m].gain.load()) /
                        std::max<double>(1.0, double(mutation_gains_[m].rays.load()));
    learned.shares.push_back(first_shares_[m] * float(best > 0.0 ? gain / best : 1.0));
  }
  apply_floor(learned.shares, kMinShare);
  learned.importance = luminance_.importance(double(luminance_.exposure()) * double(generation_) * size_.steps);
  return learned;
}

void PathPopulation::begin_with(const Learned& learned) {
  for (size_t m = 0; m < mutations_.size(); ++m) mutations_[m].share = learned.shares[m];
  space_.importance = learned.importance;
}

void PathPopulation::set_learned(const Learned& learned) {
  learning_ = false;
  for (size_t m = 0; m < mutations_.size(); ++m) mutations_[m].share = learned.shares[m];
  // The energies w f / target stay the same: weights are scaled by the same factor as the target.
  const auto importance = [this](Vec2 film) { return space_.importance.at(film); };
  std::vector<float> before(members_.size());
  for (size_t i = 0; i < members_.size(); ++i) before[i] = importance(members_[i].path.film());
  space_.importance = learned.importance;
  for (size_t i = 0; i < members_.size(); ++i) {
    const float factor = importance(members_[i].path.film()) / before[i];
    members_[i].path.scale_target(double(factor));
    members_[i].weight *= double(factor);
  }
}

uint64_t PathPopulation::rays() const {
  uint64_t rays = 0;
  for (const Worker& worker : *workers_) rays += worker.seeds.rays() + worker.chain.rays();
  return rays;
}

void PathPopulation::add_hint_account(HintAccount& sum) const {
  for (const Worker& worker : *workers_) {
    sum.add(worker.account);
    sum.add_proposals(worker.chain.hint_counts());
  }
}

double PathPopulation::left_out() const {
  double sum = 0.0;
  for (const Worker& worker : *workers_) sum += worker.left_out;
  return samples_done_ > 0 ? sum / double(samples_done_) : 0.0;
}

void PathPopulation::add_statistics(std::map<std::string, double>& extra) const {
  extra["mutations"] += double(steps_done_);
  extra["samples"] += double(samples_done_);
  extra["members"] += double(members_.size());
  extra["generations"] += double(generation_) / 2.0;
  for (const std::vector<Member>* members : {&members_, &moved_})
    for (const Member& member : *members) extra["population_bytes"] += double(member.path.bytes());
  for (const Worker& worker : *workers_) {
    extra["failed_starts"] += double(worker.seeds.failed());
    extra["refused_paths"] += double(worker.seeds.refused());
  }
  for (size_t m = 0; m < mutations_.size(); ++m) {
    const std::string name = mutations_[m].mutation->name();
    extra["share_" + name + (number_ == 0 ? "_a" : "_b")] = double(mutations_[m].share);
    for (const Worker& worker : *workers_) {
      extra["proposed_" + name] += double(worker.chain.counts()[m].proposed);
      extra["accepted_" + name] += double(worker.chain.counts()[m].accepted);
    }
  }
}

}  // namespace ajar
