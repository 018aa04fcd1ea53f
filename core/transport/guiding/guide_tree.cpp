#include "transport/guiding/guide_tree.h"

#include <algorithm>

#include <tbb/parallel_for.h>

namespace ajar {

namespace {

/// A cell with more than kMaxSamples is divided. A cell is only started with at least kMinSamples.
constexpr size_t kMaxSamples = 400, kMinSamples = 48;
constexpr int kMaxDepth = 40, kFirstIterations = 6, kIterations = 3;
/// Maximum variance of normals, along their axis of largest variance, in a cell that is not divided by normals.
constexpr float kNormalVariance = 0.05f;

float coordinate(const GuideSample& s, int axis) { return axis < 3 ? s.position[axis] : s.normal[axis - 3]; }

}  // namespace

void GuideTree::divide(uint32_t leaf, const GuideSample** begin, const GuideSample** end, int depth) {
  const size_t n = size_t(end - begin);
  const uint32_t cell = nodes_[leaf].child;
  if (n > kMaxSamples && depth < kMaxDepth) {
    double mean[6] = {}, square[6] = {};
    const GuideSample& origin = **begin;
    for (const GuideSample** s = begin; s != end; ++s) {
      for (int a = 0; a < 6; ++a) {
        const double x = double(coordinate(**s, a)) - double(coordinate(origin, a));
        mean[a] += x;
        square[a] += x * x;
      }
    }
    int axis = 0, normal_axis = 3;
    double variance[6];
    for (int a = 0; a < 6; ++a) {
      mean[a] /= double(n);
      variance[a] = square[a] / double(n) - mean[a] * mean[a];
      if (a < 3 && variance[a] > variance[axis]) axis = a;
      if (a >= 3 && variance[a] > variance[normal_axis]) normal_axis = a;
    }
    if (variance[normal_axis] > double(kNormalVariance)) axis = normal_axis;
    const float split = float(mean[axis] + double(coordinate(origin, axis)));
    const GuideSample** const middle = std::stable_partition(
        begin, end, [&](const GuideSample* s) { return coordinate(*s, axis) < split; });
    if (middle != begin && middle != end) {
      const uint32_t child = uint32_t(nodes_.size());
      nodes_.resize(nodes_.size() + 2);
      nodes_[leaf].axis = axis;
      nodes_[leaf].split = split;
      nodes_[leaf].child = child;
      if (cell != 0) {
        // Both halves start with the distribution of the whole cell. The second half gets a new index.
        cells_[cell - 1].past_share *= 0.5f;
        cells_.push_back(cells_[cell - 1]);
        nodes_[child].child = cell;
        nodes_[child + 1].child = uint32_t(cells_.size());
      }
      divide(child, begin, middle, depth + 1);
      divide(child + 1, middle, end, depth + 1);
      return;
    }
  }
  if (n == 0 || (cell == 0 && n < kMinSamples)) return;
  const bool fresh = cell == 0;
  if (fresh) {
    cells_.emplace_back();
    nodes_[leaf].child = uint32_t(cells_.size());
  }
  tasks_.push_back({nodes_[leaf].child - 1, begin, end, fresh});
}

void GuideTree::learn(const std::vector<GuideSample>& samples, float past_share) {
  if (samples.empty()) return;
  // Assign the samples to their leaves, in their order.
  std::vector<uint32_t> leaf_of(samples.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, samples.size(), 4096), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) {
      uint32_t node = root_of(samples[i]);
      while (nodes_[node].axis >= 0)
        node = nodes_[node].child + (coordinate(samples[i], nodes_[node].axis) >= nodes_[node].split ? 1 : 0);
      leaf_of[i] = node;
    }
  });
  std::vector<size_t> end_of(nodes_.size() + 1, 0);
  for (uint32_t leaf : leaf_of) ++end_of[leaf + 1];
  for (size_t i = 1; i < end_of.size(); ++i) end_of[i] += end_of[i - 1];
  std::vector<const GuideSample*> ordered(samples.size());
  std::vector<size_t> next(end_of.begin(), end_of.end() - 1);
  for (size_t i = 0; i < samples.size(); ++i) ordered[next[leaf_of[i]]++] = &samples[i];

  for (Cell& cell : cells_) cell.past_share = past_share;
  tasks_.clear();
  const size_t leaves = nodes_.size();
  for (size_t leaf = 0; leaf < leaves; ++leaf) {
    if (nodes_[leaf].axis < 0)
      divide(uint32_t(leaf), ordered.data() + end_of[leaf], ordered.data() + end_of[leaf + 1], 0);
  }
  tbb::parallel_for(size_t(0), tasks_.size(), [&](size_t i) {
    const Task& task = tasks_[i];
    Cell& cell = cells_[task.cell];
    const std::span<const GuideSample* const> own(task.begin, task.end);
    Vec3 center(0.0f);
    for (const GuideSample* s : own) center += (s->position - own[0]->position) / float(own.size());
    center += own[0]->position;
    if (task.fresh)
      cell.distribution.start(center, own);
    else
      cell.distribution.move_to(center);
    if (task.fresh)
      cell.distribution.fit(own, {0.0f, width_prior_, kFirstIterations});
    else
      cell.distribution.fit(own, {cell.past_share, width_prior_, kIterations});
  });
  tasks_.clear();
}

}  // namespace ajar
