#include "transport/hints/hint_suggestions.h"

#include <algorithm>

#include <tbb/parallel_for.h>

#include "transport/bidirectional/path_seeds.h"

namespace ajar {

namespace {

constexpr int kBlock = 256;       // samples in a task
constexpr size_t kMaxPoints = 5;  // a light and four surfaces; later bounces spread anyway
constexpr size_t kChosen = 600;   // number of paths that are compared with each other
constexpr double kBound = 0.98;   // quantile of f/p that bounds it
constexpr double kHard = 4.0;     // second moment of path tracing over the squared mean, from which hints help
constexpr float kNear = 0.12f;    // relative to the scene's radius: distance within which vertices count as equal
constexpr double kMinShare = 0.02;

struct Candidate {
  std::vector<Vec3> points;
  uint32_t bounces = 0;                   // one bit for each vertex: set if specular
  double energy = 0.0, difficulty = 0.0;  // difficulty: f / p
};

/// Density with which the path tracer finds the path, per pixel^2 of the film.
double path_tracing_density(const Path& path, float pdf_lens_area) {
  double density = path.joinable(1) ? double(path.light.pdf_sampled) : 0.0;
  if (path.light.can_be_hit) density += path.pdf_from_eye(0, pdf_lens_area);
  for (int i = 1; i <= path.count - 2; ++i) density *= path.pdf_from_eye(i, pdf_lens_area);
  return density;
}

/// A curve from the light over at most kMaxPoints - 1 surfaces, of which the last is rough. Empty for paths that need
/// no curve.
Candidate candidate_of(const Path& path, double energy, float pdf_lens_area) {
  Candidate candidate;
  if (path.vertices[0].distant) return candidate;
  int end = std::min(path.count - 1, int(kMaxPoints));
  while (end > 1 && path.vertices[size_t(end - 1)].specular) --end;
  if (end < 2) return candidate;
  for (int i = 0; i < end; ++i) {
    candidate.points.push_back(path.vertices[size_t(i)].position());
    if (i > 0 && path.vertices[size_t(i)].specular) candidate.bounces |= 1u << i;
  }
  const double density = path_tracing_density(path, pdf_lens_area);
  candidate.energy = energy;
  candidate.difficulty = density > 0.0 ? path.energy() / density : double(kInfinity);
  return candidate;
}

bool near(const Candidate& a, const Candidate& b, float distance) {
  if (a.points.size() != b.points.size() || a.bounces != b.bounces) return false;
  for (size_t i = 0; i < a.points.size(); ++i)
    if (length_squared(a.points[i] - b.points[i]) > sqr(distance)) return false;
  return true;
}

/// Chooses `count` of them with probabilities in proportion to energy times difficulty. A candidate can be chosen
/// several times.
std::vector<const Candidate*> choose(const std::vector<Candidate>& candidates, size_t count, double offset) {
  double total = 0.0;
  for (const Candidate& c : candidates) total += c.energy * c.difficulty;
  std::vector<const Candidate*> chosen;
  double sum = 0.0;
  for (const Candidate& c : candidates) {
    sum += c.energy * c.difficulty;
    while (chosen.size() < count && (double(chosen.size()) + offset) * total < sum * double(count))
      chosen.push_back(&c);
  }
  return chosen;
}

bool attaches(const Scene& scene, const HintSuggestion& suggestion) {
  HintDescription description;
  description.points = suggestion.points;
  std::vector<HintReport> reports;
  return !Hints::attach(scene, {description}, reports).empty();
}

}  // namespace

std::vector<HintSuggestion> suggest_hints(const Scene& scene, int count, int samples, uint32_t seed,
                                          const std::atomic<bool>* stop) {
  const auto& region = scene.settings().region;
  const PathSpace space(scene, region[0], region[1], region[2], region[3], true);
  struct Block {
    std::vector<Candidate> candidates;
    double energy = 0.0;
  };
  std::vector<Block> blocks(size_t((samples + kBlock - 1) / kBlock));
  tbb::parallel_for(size_t(0), blocks.size(), [&](size_t b) {
    PathSeeds seeds(space);
    Sampler sampler(Sampler::Kind::Independent, seed);
    Path path;
    for (int i = 0; i < kBlock; ++i) {
      if (stop && stop->load(std::memory_order_relaxed)) return;
      sampler.start(uint32_t(b) * kBlock + uint32_t(i), 0);
      const double energy = seeds.sample(sampler);
      blocks[b].energy += energy + seeds.left_out_light();
      sampler.start(uint32_t(b) * kBlock + uint32_t(i), 1);
      if (!(energy > 0.0) || !seeds.take(double(sampler.get_1d()), path)) continue;
      Candidate candidate = candidate_of(path, energy, space.pdf_lens_area());
      if (!candidate.points.empty()) blocks[b].candidates.push_back(std::move(candidate));
    }
  });
  if (stop && stop->load()) throw Cancelled();

  std::vector<Candidate> candidates;
  double energy = 0.0;
  for (Block& block : blocks) {
    std::move(block.candidates.begin(), block.candidates.end(), std::back_inserter(candidates));
    energy += block.energy;
  }
  if (candidates.empty()) return {};

  std::vector<double> difficulties;
  for (const Candidate& c : candidates)
    if (c.difficulty < double(kInfinity)) difficulties.push_back(c.difficulty);
  std::sort(difficulties.begin(), difficulties.end());
  const double drawn = double(blocks.size() * kBlock), mean = energy / drawn / space.film_area();
  // A path that path tracing cannot find has ten times the difficulty of the most difficult path that it can find.
  const double bound = difficulties.empty() ? 1.0 : difficulties[size_t(kBound * double(difficulties.size() - 1))];
  double second_moment = 0.0;
  bool some_never_found = false;
  for (Candidate& c : candidates) {
    const bool never_found = !(c.difficulty < double(kInfinity));
    some_never_found |= never_found;
    c.difficulty = never_found ? 10.0 * std::max(bound, mean) : std::min(c.difficulty, bound);
    second_moment += c.energy * c.difficulty / drawn / space.film_area();
  }
  if (!some_never_found && second_moment < kHard * sqr(mean)) return {};

  std::vector<const Candidate*> chosen = choose(candidates, kChosen, 0.5);
  const size_t all = chosen.size();
  const float distance = kNear * scene.radius();
  std::vector<HintSuggestion> suggestions;
  while (int(suggestions.size()) < count && !chosen.empty()) {
    const Candidate* best = nullptr;
    size_t max_neighbours = 0;
    for (const Candidate* c : chosen) {
      const size_t neighbours = size_t(
          std::count_if(chosen.begin(), chosen.end(), [&](auto* other) { return near(*c, *other, distance); }));
      if (neighbours > max_neighbours) max_neighbours = neighbours, best = c;
    }
    const HintSuggestion suggestion{best->points, double(max_neighbours) / double(all)};
    if (suggestion.share < kMinShare) break;
    std::erase_if(chosen, [&](auto* other) { return near(*best, *other, distance); });
    if (attaches(scene, suggestion)) suggestions.push_back(suggestion);
  }
  return suggestions;
}

}  // namespace ajar
