#include "transport/guiding/path_guide.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <tbb/parallel_for.h>

#include "math/random.h"
#include "math/relative_error.h"

namespace ajar {

namespace {

/// Training ends after an iteration with at least this number of paths.
constexpr uint64_t kEnoughPaths = 1'500'000;
constexpr double kMaxVertices = 2.5e6;
/// Minimum sample count of each pixel when training ends.
constexpr uint32_t kLearnedSamples = 16;
/// Samples before the first training step of a frame that starts with a guide.
constexpr uint32_t kFirstWarmTraining = 16;
/// Samples without the guide that tell the cost of a sample.
constexpr uint32_t kUnguided = 4;
/// Cost of guiding per ray, measured; between `rooms` and `box` (docs/benchmarks/guiding.md).
constexpr double kCostOfGuide = 1.25;

}  // namespace

const PathGuide::Measurement PathGuide::kMeasurements[2] = {{4, 8, 0.85}, {12, 16, 1.25}};

PathGuide::PathGuide(Mode mode, int width, int height, int tile, const Past* past)
    : measures_(mode == Mode::Auto && !(past && past->age < kMaxAge)),
      width_(width),
      pixels_(width * height),
      tile_(tile),
      columns_((width + tile - 1) / tile),
      tile_samples_(size_t(columns_) * size_t((height + tile - 1) / tile)) {
  if (!past) return;
  starts_warm_ = past->tree.cell_count() > 0;
  tree_ = past->tree;
  vertices_per_path_ = past->vertices_per_path;
  if (measures_) return;
  age_ = past->age + 1;
  learning_ = mode == Mode::On || past->pays;
  if (starts_warm_) first_training_ = kFirstWarmTraining;
}

std::shared_ptr<const PathGuide::Past> PathGuide::past() {
  const bool pays = active();
  if (learning_) learn(GuideTree::kPastShareAtEnd);
  if ((measures_ && !measured_) || (pays && tree_.cell_count() == 0)) return nullptr;
  return std::make_shared<const Past>(Past{pays ? tree_ : GuideTree(), vertices_per_path_, pays, age_});
}

int PathGuide::begin(uint32_t done, int wanted, uint64_t rays) {
  if (!active()) return wanted;
  if (learning_ && done >= first_training_ && std::has_single_bit(done)) {
    learn(GuideTree::kPastShare);
    learning_ = paths_ < kEnoughPaths || done < kLearnedSamples;
    if (!learning_) tile_samples_.clear();
  }
  if (!measures_) {
    follows_ = done > 0 || starts_warm_;
  } else if (!measured_ && !measure_before(done, rays)) {
    return wanted;
  }
  // Up to the next training step or measurement.
  int samples = learning_ ? std::min(wanted, int(std::max(std::bit_ceil(done + 1), first_training_) - done)) : wanted;
  if (measures_ && !measured_) samples = std::min(samples, int((done / kUnguided + 1) * kUnguided - done));
  if (learning_) {
    const uint64_t iteration = uint64_t(pixels_) * (done < first_training_ ? first_training_ : std::bit_floor(done));
    const double share = std::min(double(kEnoughPaths), kMaxVertices / vertices_per_path_) / double(iteration);
    keep_ = share < 1.0 ? uint32_t(double(~0u) * share) : ~0u;
    paths_ = iteration;
  }
  return samples;
}

bool PathGuide::measure_before(uint32_t done, uint64_t rays) {
  if (done == kUnguided) {
    rays_without_ = double(rays) / kUnguided;
    follows_ = true;
  }
  measuring_ = false;
  for (const Measurement& m : kMeasurements) {
    if (done == m.begin) {
      moments_.assign(size_t(pixels_), {});
      rays_at_start_ = rays;
    }
    measuring_ |= done >= m.begin && done < m.end;
    if (done != m.end) continue;
    gain_ = gain(m.end - m.begin, rays - rays_at_start_);
    follows_ = gain_ >= m.least;
  }
  measured_ = done >= kEqualSamples || (done > kUnguided && !follows_);
  if (measured_) moments_ = {};
  if (!measured_ || follows_) return true;
  learning_ = false;
  tile_samples_.clear();
  return false;
}

uint64_t PathGuide::estimated_bytes(uint64_t pixels, uint64_t samples) {
  // Twelve vertices per path is a high estimate. The last iteration that is used for training has half of the samples
  // so far.
  const double paths = double(pixels) * double(std::clamp<uint64_t>(samples / 2, 1, kLearnedSamples / 2)),
               vertices = std::min(kMaxVertices, 12.0 * paths);
  const double cells = vertices / 100.0;
  return uint64_t(vertices * double(3 * sizeof(GuideSample) + GuideTree::kBytesPerSample) +
                  2.0 * cells * double(GuideTree::kBytesPerCell) + double(pixels) * double(sizeof(Moments)));
}

bool PathGuide::records(uint32_t pixel, uint32_t index) const {
  return keep_ == ~0u || hash_combine(pixel, index) <= keep_;
}

void PathGuide::learn(float past_share) {
  // Order tiles and paths, so that the result does not depend on the threads or on how the time limit divides an
  // iteration.
  tbb::parallel_for(size_t(0), tile_samples_.size(), [&](size_t tile) {
    std::stable_sort(tile_samples_[tile].begin(), tile_samples_[tile].end(),
                     [](const GuideSample& a, const GuideSample& b) {
                       return a.pixel != b.pixel ? a.pixel < b.pixel : a.index < b.index;
                     });
  });
  size_t count = 0;
  for (const std::vector<GuideSample>& tile : tile_samples_) count += tile.size();
  std::vector<GuideSample> samples;
  samples.reserve(count);
  for (std::vector<GuideSample>& tile : tile_samples_) {
    samples.insert(samples.end(), tile.begin(), tile.end());
    tile.clear();
  }
  tree_.learn(samples, past_share);
  size_t written = 0;
  for (const std::vector<GuideSample>& tile : tile_samples_) written += tile.capacity();
  max_bytes_ = std::max(max_bytes_, (written + count) * sizeof(GuideSample) + count * GuideTree::kBytesPerSample +
                                        tree_.memory_bytes() + moments_.size() * sizeof(Moments));
  const double recorded = double(paths_) * (keep_ == ~0u ? 1.0 : double(keep_) / double(~0u));
  vertices_per_path_ = std::clamp(double(count) / std::max(1.0, recorded), 0.5, 24.0);
}

/// The mean over blocks of the logarithm of the ratio of their variances. The weight of a block is its relative standard
/// deviation, from both variances: by variances, few blocks with rare bright paths would decide. The square of the mean,
/// which both variances contain, is estimated without bias.
double PathGuide::gain(uint32_t samples, uint64_t rays_guided) const {
  constexpr int kBlock = 16;
  const double n = double(samples);
  struct Block {
    double variance[2] = {0.0, 0.0}, mean = 0.0, pixels = 0.0;
  };
  const int columns = (width_ + kBlock - 1) / kBlock, rows = (pixels_ / width_ + kBlock - 1) / kBlock;
  std::vector<Block> blocks(size_t(columns) * size_t(rows));
  for (int i = 0; i < pixels_; ++i) {
    Block& block = blocks[size_t(i / width_ / kBlock) * size_t(columns) + size_t(i % width_ / kBlock)];
    const Moments& m = moments_[size_t(i)];
    block.pixels += 1.0;
    const double mean_square = (double(m.sum) * double(m.sum) - double(m.square)) / (n * (n - 1.0));
    if (!std::isfinite(mean_square) || !std::isfinite(m.unguided_square)) continue;
    block.variance[0] += double(m.unguided_square) / n - mean_square;
    block.variance[1] += double(m.square) / n - mean_square;
    block.mean += double(m.sum) / n;
  }
  double sum = 0.0, weights = 0.0;
  for (const Block& b : blocks) {
    if (!(b.variance[0] > 0.0 && b.variance[1] > 0.0)) continue;
    const double relative = std::sqrt(b.variance[0] * b.variance[1]) /
                            (b.mean * b.mean / b.pixels + kDarkSquared * b.pixels);
    const double weight = std::sqrt(relative) * b.pixels;
    sum += weight * std::log(b.variance[0] / b.variance[1]);
    weights += weight;
  }
  if (!(weights > 0.0) || rays_guided == 0) return 0.0;
  return std::exp(sum / weights) * rays_without_ * n / (double(rays_guided) * kCostOfGuide);
}

}  // namespace ajar
