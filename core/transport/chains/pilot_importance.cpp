#include "transport/chains/pilot_importance.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <tbb/parallel_for.h>

#include "transport/bidirectional/path_seeds.h"

namespace ajar {

namespace {
constexpr uint32_t kPilotStream = 0x91107000u;  // separates the random numbers from those of seeds and chains
constexpr uint32_t kBlocks = 16;
constexpr uint32_t kSamplesPerCell = 32;
constexpr int kMaxCells = 1024;
constexpr double kLargestSample = 20.0;  // relative to the mean: rare bright samples say little about a cell
constexpr double kFloor = 0.3;           // relative to the mean: bounds the importance of dark cells
}  // namespace

Pilot look_ahead(const PathSpace& space, uint32_t seed, uint32_t samples, const std::atomic<bool>& stop) {
  Pilot pilot;
  const Vec2 extent = space.film_max - space.film_min;
  const double cells = std::clamp(double(samples) / kSamplesPerCell, 1.0, double(kMaxCells));
  const int columns = std::max(1, int(std::sqrt(cells * double(extent.x / extent.y))));
  const int rows = std::max(1, int(cells / columns));
  const Vec2 per_cell = Vec2(float(columns), float(rows)) / extent;

  struct Arrival {
    size_t cell;
    double light;
    bool direct;
  };
  std::vector<std::vector<Arrival>> arrivals(kBlocks);
  std::vector<uint64_t> rays(kBlocks, 0);
  tbb::parallel_for(uint32_t(0), kBlocks, [&](uint32_t block) {
    BidirectionalWalks walks = walks_over(space);
    Sampler sampler(Sampler::Kind::Independent, hash_combine(seed, kPilotStream));
    for (uint32_t i = block; i < samples && !stop.load(std::memory_order_relaxed); i += kBlocks) {
      sampler.start(i, 0);
      for (const FoundPath& path : walks.sample(space.film_at(sampler.get_2d()), sampler)) {
        const double light = double(luminance(glm::abs(path.contribution))) * (path.t > 1 ? space.film_area() : 1.0);
        if (!(light > 0.0) || !std::isfinite(light) || !space.on_film(path.film)) continue;
        const Vec2 place = (path.film - space.film_min) * per_cell;
        arrivals[block].push_back(
            {size_t(std::min(int(place.y), rows - 1)) * size_t(columns) + size_t(std::min(int(place.x), columns - 1)),
             light, walks.is_direct(path)});
      }
    }
    rays[block] = walks.rays();
  });
  pilot.rays = std::accumulate(rays.begin(), rays.end(), uint64_t(0));
  double total = 0.0;
  for (const auto& block : arrivals)
    for (const Arrival& a : block) {
      total += a.light;
      pilot.direct_light += a.direct ? a.light / double(samples) : 0.0;
    }
  if (stop.load(std::memory_order_relaxed) || !(total > 0.0)) return pilot;

  const size_t count = size_t(columns) * size_t(rows);
  std::vector<double> light(count, 0.0);
  for (const auto& block : arrivals)
    for (const Arrival& a : block) light[a.cell] += std::min(a.light, kLargestSample * total / double(samples));
  // In units of the mean over the film. Each cell is averaged with its neighbours, which have half the weight per axis.
  std::vector<float> values(count);
  const double mean = std::accumulate(light.begin(), light.end(), 0.0) / double(count);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      double sum = 0.0, weights = 0.0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (x + dx < 0 || y + dy < 0 || x + dx >= columns || y + dy >= rows) continue;
          const double weight = (dx ? 0.5 : 1.0) * (dy ? 0.5 : 1.0);
          sum += weight * light[size_t(y + dy) * size_t(columns) + size_t(x + dx)];
          weights += weight;
        }
      }
      values[size_t(y) * size_t(columns) + size_t(x)] = float(1.0 / (sum / (weights * mean) + kFloor));
    }
  }
  pilot.importance = FilmImportance(space.film_min, space.film_max, columns, rows, std::move(values));
  return pilot;
}

}  // namespace ajar
