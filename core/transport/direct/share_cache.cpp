#include "transport/direct/share_cache.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

#include "math/random.h"

namespace ajar {

namespace {

/// Unit of the integer sums, relative to the typical second moment, and maximum that one sample adds.
constexpr float kQuantum = 0x1p-34f, kMax = 0x1p20f;

}  // namespace

ShareCache::ShareCache(uint32_t cell_count_log2, int components, float prior_count, float scale)
    : m_(components),
      mask_((1u << cell_count_log2) - 1),
      prior_count_(prior_count),
      inverse_scale_squared_(scale > 0.0f ? 1.0f / (scale * scale) : 1.0f),
      past_((size_t(mask_) + 1) * size_t(m_ + 1), 0.0f),
      sums_(new std::atomic<uint64_t>[(size_t(mask_) + 1) * size_t(m_ + 2)]()) {}

ShareCache ShareCache::copied(int halvings) const {
  const size_t sums = (size_t(mask_) + 1) * size_t(m_ + 2);
  ShareCache other;
  other.m_ = m_;
  other.mask_ = mask_;
  other.prior_count_ = prior_count_;
  other.inverse_scale_squared_ = inverse_scale_squared_;
  other.past_ = past_;
  if (m_ == 0) return other;
  other.sums_.reset(new std::atomic<uint64_t>[sums]);
  for (size_t i = 0; i < sums; ++i)
    other.sums_[i].store(sums_[i].load(std::memory_order_relaxed) >> halvings, std::memory_order_relaxed);
  return other;
}

void ShareCache::shares(uint32_t cell, std::span<const float> prior, std::span<const float> floors,
                        std::span<float> shares) const {
  const float* const past = past_.data() + size_t(cell) * size_t(m_ + 1);
  const float prior_weight = past[m_];
  if (!(prior_weight > 0.0f)) {
    std::copy(prior.begin(), prior.end(), shares.begin());
    return;
  }
  // alpha_k: square roots of the second moments [Fan 2006, eq. 5.8 with second moments], with floors. The prior has the
  // effect of samples whose second moment is the mean one, divided by the shares of the prior.
  float sum = 0.0f, floor_sum = 0.0f;
  for (size_t k = 0; k < shares.size(); ++k) {
    shares[k] = prior[k] > 0.0f ? std::sqrt(past[k] + prior_weight * prior[k] * prior[k]) : 0.0f;
    sum += shares[k];
    floor_sum += floors[k];
  }
  for (size_t k = 0; k < shares.size(); ++k) shares[k] = floors[k] + (1.0f - floor_sum) * shares[k] / sum;
}

uint64_t ShareCache::fixed_point(float squared) const {
  const float relative = std::min(squared * inverse_scale_squared_, kMax);
  return relative > 0.0f ? uint64_t(relative / kQuantum) : 0;
}

void ShareCache::add_square(uint32_t cell, float y_squared) const {
  sums_[size_t(cell) * size_t(m_ + 2) + 1].fetch_add(fixed_point(y_squared), std::memory_order_relaxed);
}

void ShareCache::add_moment(uint32_t cell, int component, float moment) const {
  if (!(moment > 0.0f)) return;
  sums_[size_t(cell) * size_t(m_ + 2) + 2 + size_t(component)].fetch_add(fixed_point(moment),
                                                                         std::memory_order_relaxed);
}

void ShareCache::publish() {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, size_t(mask_) + 1, 1024),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t cell = range.begin(); cell != range.end(); ++cell) {
                        const std::atomic<uint64_t>* const sums = sums_.get() + cell * size_t(m_ + 2);
                        const double samples = double(sums[0].load(std::memory_order_relaxed)),
                                     squares = double(sums[1].load(std::memory_order_relaxed));
                        if (!(squares > 0.0)) continue;
                        float* const past = past_.data() + cell * size_t(m_ + 1);
                        for (int k = 0; k < m_; ++k)
                          past[k] = float(double(sums[2 + k].load(std::memory_order_relaxed)) / squares);
                        past[m_] = float(double(prior_count_) / samples);
                      }
                    });
}

uint64_t cell_key(Vec3 position, float size, Vec3 normal, uint32_t material) {
  const auto rounded = [](float x) { return uint64_t(int64_t(std::floor(x))) & 0xffffff; };
  const Vec3 p = position / size;
  uint64_t key = hash64(rounded(p.x) | (rounded(p.y) << 24) | (uint64_t(material) << 48));
  // The size is part of the key, so cells of different sizes are different.
  key = hash64(key ^ rounded(p.z) ^ (uint64_t(std::lround(std::log2(size)) + 128) << 24) ^
               (uint64_t(material >> 16) << 32));
  const Vec3 n = glm::round(1.5f * normal) + 2.0f;
  return hash64(key ^ (uint64_t(n.x) | (uint64_t(n.y) << 3) | (uint64_t(n.z) << 6)));
}

}  // namespace ajar
