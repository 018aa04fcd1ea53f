#include "transport/direct/light_cut_cache.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <tbb/parallel_for.h>

#include "math/random.h"

namespace ajar {

namespace {

constexpr uint32_t kSlotsLog2 = 16, kSlots = 1u << kSlotsLog2;
constexpr uint64_t kFree = ~uint64_t(0);
constexpr float kPriorFloor = 0.15f, kEqualFloor = 0.05f;  ///< minimum of a share: over the tree's; over an equal one
constexpr float kPriorCount = 16.0f;                       ///< weight of the prior in samples
/// Unit of the integer sums, relative to the typical second moment, and maximum that one sample adds.
constexpr float kQuantum = 0x1p-34f, kMax = 0x1p14f;
constexpr float kMinAngle = 1.0f / 900.0f;  ///< positions have 12 bits per axis
constexpr size_t kFewLights = 8;            ///< number of lights up to which one iteration learns enough
constexpr int kPlaceBits = 12, kLevelBits = 8, kNormalBits = 3;

/// A copy with `size` sums. The existing ones are divided by a power of two.
std::vector<std::atomic<uint64_t>> copy(const std::vector<std::atomic<uint64_t>>& sums, size_t size, int shift) {
  std::vector<std::atomic<uint64_t>> result(size);
  for (size_t i = 0; i < sums.size(); ++i)
    result[i].store(sums[i].load(std::memory_order_relaxed) >> shift, std::memory_order_relaxed);
  return result;
}

}  // namespace

LightCutCache::LightCutCache(const LightSet& lights, Vec3 eye, float angle, float scale)
    : lights_(&lights),
      eye_(eye),
      angle_(std::max(angle, kMinAngle)),
      inverse_scale_squared_(scale > 0.0f ? 1.0f / (scale * scale) : 1.0f),
      iterations_left_(iterations(lights)),
      claims_(new std::atomic<uint64_t>[kSlots]),
      cell_of_slot_(kSlots, kNone) {
  for (uint32_t i = 0; i < kSlots; ++i) claims_[i].store(kFree, std::memory_order_relaxed);
}

LightCutCache::LightCutCache(const LightCutCache& before, const LightSet& lights)
    : lights_(&lights),
      eye_(before.eye_),
      angle_(before.angle_),
      inverse_scale_squared_(before.inverse_scale_squared_),
      iterations_left_(1),
      claims_(new std::atomic<uint64_t>[kSlots]),
      cell_of_slot_(before.cell_of_slot_),
      ids_(before.ids_),
      priors_(before.priors_),
      cumulative_(before.cumulative_),
      counts_(before.counts_),
      samples_(copy(before.samples_, before.samples_.size(), 1)),
      squares_(copy(before.squares_, before.squares_.size(), 1)),
      moments_(copy(before.moments_, before.moments_.size(), 1)) {
  for (uint32_t i = 0; i < kSlots; ++i) {
    // Claims of a last iteration have not become cells.
    const bool known = cell_of_slot_[i] != kNone;
    claims_[i].store(known ? before.claims_[i].load(std::memory_order_relaxed) : kFree, std::memory_order_relaxed);
  }
}

bool LightCutCache::suits(Vec3 eye, float angle, float reach) const {
  return glm::length(eye - eye_) < 0.25f * reach && angle > 0.5f * angle_ && angle < 2.0f * angle_;
}

int LightCutCache::iterations(const LightSet& lights) {
  return 1 + (lights.size() <= kFewLights ? 1 : kLearningIterations);
}

uint64_t LightCutCache::key(Vec3 p, Vec3 n, uint32_t material, uint32_t jitter) const {
  const Vec3 from_eye = p - eye_;
  // The exponent gives the largest power of two below.
  const int level = int(std::bit_cast<uint32_t>(glm::clamp(angle_ * glm::length(from_eye), 1e-30f, 1e30f)) >> 23) - 127;
  const uint32_t j2 = hash32(jitter + 1);
  const Vec3 at = glm::floor(from_eye * std::bit_cast<float>(uint32_t(127 - level) << 23) +
                             Vec3(to_unit_float(jitter << 8), to_unit_float(j2), to_unit_float(j2 << 12)) - 0.5f);
  const Vec3 normal = glm::round(1.5f * n) + 2.0f;
  uint64_t key = material & 0x7ffu;
  for (int axis = 0; axis < 3; ++axis)
    key = (key << kPlaceBits) | uint64_t(glm::clamp(at[axis], -2048.0f, 2047.0f) + 2048.0f);
  key = (key << kLevelBits) | uint64_t(level + 128);
  for (int axis = 0; axis < 3; ++axis) key = (key << kNormalBits) | uint64_t(glm::clamp(normal[axis], 0.0f, 4.0f));
  return key;
}

void LightCutCache::place_of_key(uint64_t key, Vec3& center, float& size, Vec3& normal) const {
  const auto take = [&](int bits) {
    const uint64_t field = key & ((uint64_t(1) << bits) - 1);
    key >>= bits;
    return float(field);
  };
  for (int axis = 2; axis >= 0; --axis) normal[axis] = take(kNormalBits) - 2.0f;
  if (normal != Vec3(0.0f)) normal = glm::normalize(normal);
  size = std::exp2(take(kLevelBits) - 128.0f);
  // The jitter is half a cell on average, so the centre of the cell needs no offset for it.
  for (int axis = 2; axis >= 0; --axis) center[axis] = take(kPlaceBits) - 2048.0f + 0.5f;
  center = eye_ + size * center;
}

uint32_t LightCutCache::cell(uint64_t key) const {
  const uint32_t slot = uint32_t(hash64(key)) & (kSlots - 1);
  std::atomic<uint64_t>& claim = claims_[slot];
  uint64_t held = claim.load(std::memory_order_relaxed);
  if (claiming_ && cell_of_slot_[slot] == kNone) {
    while (key < held && !claim.compare_exchange_weak(held, key, std::memory_order_relaxed)) {
    }
    return kNone;
  }
  return held == key ? cell_of_slot_[slot] : kNone;
}

void LightCutCache::make_cuts() {
  const uint32_t known = uint32_t(samples_.size());
  uint32_t cells = known;
  for (uint32_t i = 0; i < kSlots; ++i)
    if (cell_of_slot_[i] == kNone && claims_[i].load(std::memory_order_relaxed) != kFree) cell_of_slot_[i] = cells++;
  ids_.resize(size_t(cells) * kBranches);
  priors_.resize(ids_.size());
  cumulative_.resize(ids_.size());
  counts_.resize(cells);
  samples_ = copy(samples_, cells, 0);
  squares_ = copy(squares_, cells, 0);
  moments_ = copy(moments_, ids_.size(), 0);
  tbb::parallel_for(tbb::blocked_range<uint32_t>(0, kSlots, 1024), [&](const tbb::blocked_range<uint32_t>& range) {
    std::vector<LightSet::Branch> branches;
    for (uint32_t slot = range.begin(); slot != range.end(); ++slot) {
      const uint32_t cell = cell_of_slot_[slot];
      if (cell == kNone || cell < known) continue;
      Vec3 center, normal;
      float size;
      place_of_key(claims_[slot].load(std::memory_order_relaxed), center, size, normal);
      lights_->cut(center, size, normal, kBranches, branches);
      counts_[cell] = uint8_t(branches.size());
      float sum = 0.0f;
      for (size_t k = 0; k < branches.size(); ++k) {
        const size_t i = size_t(cell) * kBranches + k;
        ids_[i] = branches[k].id;
        priors_[i] = 0.9f * branches[k].share + 0.1f / float(branches.size());
        cumulative_[i] = sum += priors_[i];
      }
      if (!branches.empty()) cumulative_[size_t(cell) * kBranches + branches.size() - 1] = 1.0f;
    }
  });
}

void LightCutCache::publish() {
  if (iterations_left_ == 0) return;
  --iterations_left_;
  if (claiming_) make_cuts();
  claiming_ = false;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, cells(), 1024), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t cell = range.begin(); cell != range.end(); ++cell) {
      const double samples = double(samples_[cell].load(std::memory_order_relaxed)),
                   squares = double(squares_[cell].load(std::memory_order_relaxed));
      if (!(squares > 0.0)) continue;
      double roots[kBranches], sum = 0.0;
      const size_t first = cell * kBranches;
      // alpha_k proportional to sqrt(E[(f / p_k)^2]), with floors. The prior has the effect of samples whose
      // second moment is the mean one, divided by the shares of the prior.
      for (int k = 0; k < counts_[cell]; ++k) {
        const double prior = double(priors_[first + size_t(k)]);
        roots[k] = std::sqrt(double(moments_[first + size_t(k)].load(std::memory_order_relaxed)) +
                             double(kPriorCount) * prior * prior * squares / samples);
        sum += roots[k];
      }
      float before = 0.0f;
      for (int k = 0; k < counts_[cell]; ++k)
        cumulative_[first + size_t(k)] = before += floor(uint32_t(cell), k) +
                                                   (1.0f - kPriorFloor - kEqualFloor) * float(roots[k] / sum);
      cumulative_[first + counts_[cell] - 1] = 1.0f;
    }
  });
}

float LightCutCache::floor(uint32_t cell, int branch) const {
  return kPriorFloor * priors_[size_t(cell) * kBranches + size_t(branch)] + kEqualFloor / float(counts_[cell]);
}

float LightCutCache::share(uint32_t cell, int branch) const {
  const size_t i = size_t(cell) * kBranches + size_t(branch);
  return cumulative_[i] - (branch > 0 ? cumulative_[i - 1] : 0.0f);
}

float LightCutCache::share_between(uint32_t cell, uint32_t first, uint32_t end) const {
  float sum = 0.0f;
  for (int k = 0; k < counts_[cell]; ++k) {
    const uint32_t id = ids_[size_t(cell) * kBranches + size_t(k)];
    if (id >= first && id < end) sum += share(cell, k);
  }
  return sum;
}

LightCutCache::Choice LightCutCache::choose(uint32_t cell, Vec3 p, Vec3 n, float u) const {
  if (cell == kNone) return {lights_->choose(p, n, u), 0, 0.0f};
  const float* const cumulative = cumulative_.data() + size_t(cell) * kBranches;
  const int count = counts_[cell],
            k = std::min(int(std::upper_bound(cumulative, cumulative + count, u) - cumulative), count - 1);
  const float below = k > 0 ? cumulative[k - 1] : 0.0f, share = cumulative[k] - below;
  LightSet::Choice choice = lights_->choose_in(ids_[size_t(cell) * kBranches + size_t(k)], p, n,
                                               glm::clamp((u - below) / share, 0.0f, kOneMinusEpsilon));
  choice.pmf *= share;
  return {choice, uint32_t(k), share};
}

float LightCutCache::pmf(uint32_t cell, Vec3 p, Vec3 n, uint32_t light) const {
  if (cell == kNone) return lights_->choice_pmf(p, n, light);
  const uint32_t* const ids = ids_.data() + size_t(cell) * kBranches;
  const int k = int(std::upper_bound(ids, ids + counts_[cell], lights_->place_of(light)) - ids) - 1;
  return share(cell, k) * lights_->pmf_in(ids[k], p, n, light);
}

void LightCutCache::record(uint32_t cell, const Choice& choice, float y) const {
  if (cell == kNone || !learning()) return;
  samples_[cell].fetch_add(1, std::memory_order_relaxed);
  if (!(y > 0.0f)) return;
  // Alone, the branch would have contributed share * y. It was chosen with the probability share.
  const float relative = y * y * inverse_scale_squared_;
  const auto fixed_point = [](float x) { return uint64_t(std::min(x, kMax) / kQuantum); };
  squares_[cell].fetch_add(fixed_point(relative), std::memory_order_relaxed);
  moments_[size_t(cell) * kBranches + choice.branch].fetch_add(fixed_point(relative * choice.share),
                                                               std::memory_order_relaxed);
}

}  // namespace ajar
