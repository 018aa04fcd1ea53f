// Integer hashes and a small generator. They must never change: a seed always gives the same image.
#pragma once

#include <cstdint>

#include "math/types.h"

namespace ajar {

/// Finaliser for 32 bits with good avalanche behaviour (Wellons 2018, "lowbias32").
inline uint32_t hash32(uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352dU;
  x ^= x >> 15;
  x *= 0x846ca68bU;
  x ^= x >> 16;
  return x;
}
/// Both sides are hashed before they are combined, so that small seeds and values do not cancel.
inline uint32_t hash_combine(uint32_t seed, uint32_t value) {
  return hash32(hash32(seed + 0x9e3779b9U) ^ hash32(value + 0x85ebca6bU));
}
/// Finaliser for 64 bits (Stafford 2011, mix 13; the output step of SplitMix64).
inline uint64_t hash64(uint64_t x) {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9ULL;
  x ^= x >> 27;
  x *= 0x94d049bb133111ebULL;
  x ^= x >> 31;
  return x;
}
/// The top 24 bits as a float in [0, 1).
inline float to_unit_float(uint32_t x) { return float(x >> 8) * 0x1p-24f; }

/// PCG32 (O'Neill 2014); each `sequence` is an independent stream.
class Pcg32 {
 public:
  explicit Pcg32(uint64_t seed = 0, uint64_t sequence = 0) : increment_((hash64(sequence) << 1) | 1) {
    next();
    state_ += hash64(seed + 0x9e3779b97f4a7c15ULL);
    next();
  }
  uint32_t next() {
    const uint64_t old = state_;
    state_ = old * 6364136223846793005ULL + increment_;
    const uint32_t xorshifted = uint32_t(((old >> 18) ^ old) >> 27), rotation = uint32_t(old >> 59);
    return (xorshifted >> rotation) | (xorshifted << ((32 - rotation) & 31));
  }
  float next_float() { return to_unit_float(next()); }

 private:
  uint64_t state_ = 0, increment_ = 1;
};

}  // namespace ajar
