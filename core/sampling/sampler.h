// Random numbers of one path: Owen-scrambled Sobol points padded in pairs and triples, or independent numbers, behind
// one interface.
//
// Each pair of dimensions is the two-dimensional Sobol sequence. Its index is shuffled, and its points are scrambled by
// a nested uniform (Owen) scramble. Both depend on the pixel and the dimension, so pixels and pairs are decorrelated,
// and every pair stays a (0,2)-sequence over the samples of a pixel. Triples are for a choice (of a lobe or a light) and
// the point that is then sampled: with a pair and a single number instead, each of the choices would get a random subset
// of the points, which is not stratified.
// Source: Burley 2020, "Practical Hash-based Owen Scrambling". The hash of the scramble is that of Laine and Karras
// 2011 with Vegdahl's constants.
#pragma once

#include "math/random.h"
#include "math/types.h"

namespace ajar {

namespace sobol {

inline uint32_t reverse_bits(uint32_t x) {
  x = __builtin_bswap32(x);
  x = ((x & 0x0f0f0f0fU) << 4) | ((x >> 4) & 0x0f0f0f0fU);
  x = ((x & 0x33333333U) << 2) | ((x >> 2) & 0x33333333U);
  return ((x & 0x55555555U) << 1) | ((x >> 1) & 0x55555555U);
}

/// Reverses the bits of both 32-bit halves and swaps the halves. It costs half as much as two calls of `reverse_bits`.
inline uint64_t reverse_bits_64(uint64_t x) {
  x = __builtin_bswap64(x);
  x = ((x & 0x0f0f0f0f0f0f0f0fU) << 4) | ((x >> 4) & 0x0f0f0f0f0f0f0f0fU);
  x = ((x & 0x3333333333333333U) << 2) | ((x >> 2) & 0x3333333333333333U);
  x = ((x & 0x5555555555555555U) << 1) | ((x >> 1) & 0x5555555555555555U);
  return x;
}

/// Scramble of a bit-reversed number: each bit is flipped by a hash of the bits below it.
inline uint32_t laine_karras_permutation(uint32_t x, uint32_t seed) {
  x ^= x * 0x3d20adeaU;
  x += seed;
  x *= (seed >> 16) | 1U;
  x ^= x * 0x05526c56U;
  x ^= x * 0x53a22864U;
  return x;
}

/// Second Sobol dimension of `index`, bit-reversed: multiplication by Pascal's triangle modulo 2, which factors into
/// five butterfly steps.
inline uint32_t second_dimension_reversed(uint32_t x) {
  x ^= (x >> 16) & 0x0000ffffU;
  x ^= (x >> 8) & 0x00ff00ffU;
  x ^= (x >> 4) & 0x0f0f0f0fU;
  x ^= (x >> 2) & 0x33333333U;
  x ^= (x >> 1) & 0x55555555U;
  return x;
}

/// Third Sobol dimension of `index`, bit-reversed. Its columns are those of Joe and Kuo 2008: the primitive polynomial
/// x^2 + x + 1 and the initial numbers 1 and 3.
class ThirdDimension {
 public:
  constexpr ThirdDimension() {
    uint32_t numbers[32] = {1, 3};
    for (int k = 2; k < 32; ++k) numbers[k] = numbers[k - 1] << 1 ^ numbers[k - 2] << 2 ^ numbers[k - 2];
    uint32_t columns[32] = {};  // bit-reversed: number k has k + 1 bits, of which the highest comes first
    for (int k = 0; k < 32; ++k)
      for (int bit = 0; bit <= k; ++bit) columns[k] |= (numbers[k] >> (k - bit) & 1U) << bit;
    for (int byte = 0; byte < 4; ++byte)
      for (int value = 0; value < 256; ++value)
        for (int bit = 0; bit < 8; ++bit)
          if (value >> bit & 1) table_[byte][value] ^= columns[8 * byte + bit];
  }
  uint32_t operator()(uint32_t index) const {
    return table_[0][index & 255U] ^ table_[1][index >> 8 & 255U] ^ table_[2][index >> 16 & 255U] ^
           table_[3][index >> 24];
  }

 private:
  uint32_t table_[4][256] = {};
};
inline constexpr ThirdDimension third_dimension_reversed;

}  // namespace sobol

class Sampler {
 public:
  enum class Kind : uint8_t { Sobol, Independent };

  Sampler(Kind kind, uint32_t seed) : kind_(kind), seed_(seed) {}

  /// Starts sample `index` of the unit (pixel or chain) `unit` at dimension 0.
  void start(uint32_t unit, uint32_t index) {
    unit_seed_ = hash_combine(seed_, unit);
    index_ = index;
    index_reversed_ = sobol::reverse_bits(index);
    dimension_ = 0;
    if (kind_ == Kind::Independent) rng_ = Pcg32((uint64_t(unit_seed_) << 32) | index, unit);
  }
  /// Continues at a fixed dimension, so that paths that branched use the same dimensions again.
  void set_dimension(uint32_t dimension) { dimension_ = dimension; }
  uint32_t dimension() const { return dimension_; }
  /// The sampler of branch `i` of the `count` branches of the current sample. It is stratified with the branches of the
  /// other samples (best if `count` is a power of two).
  Sampler branch(uint32_t i, uint32_t count) const {
    Sampler child = *this;
    child.start(hash_combine(unit_seed_, dimension_ ^ 0x5bd1e995U), index_ * count + i);
    return child;
  }

  float get_1d() {
    if (kind_ == Kind::Independent) return rng_.next_float();
    const uint32_t seed = hash32(unit_seed_ ^ (dimension_++ * 0x9e3779b9U));
    const uint32_t shuffled = sobol::reverse_bits(sobol::laine_karras_permutation(index_reversed_, seed));
    return to_unit_float(sobol::reverse_bits(sobol::laine_karras_permutation(shuffled, hash32(seed))));
  }

  Vec2 get_2d() {
    if (kind_ == Kind::Independent) {
      const float x = rng_.next_float();
      return {x, rng_.next_float()};
    }
    uint32_t shuffled, seed_y;
    return pair_of(2, shuffled, seed_y);
  }

  /// Three numbers that are stratified together: the first two as those of get_2d, and a third one, for a choice that
  /// decides what the others mean.
  Vec3 get_3d() {
    if (kind_ == Kind::Independent) {
      const float z = rng_.next_float(), x = rng_.next_float();
      return {x, rng_.next_float(), z};
    }
    uint32_t shuffled, seed_y;
    const Vec2 pair = pair_of(3, shuffled, seed_y);
    const uint32_t z = sobol::laine_karras_permutation(sobol::third_dimension_reversed(shuffled), hash32(seed_y));
    return {pair.x, pair.y, to_unit_float(sobol::reverse_bits(z))};
  }

 private:
  /// The first two dimensions of a scrambled Sobol point that uses up `count` dimensions of the sample. `shuffled` is the
  /// point's shuffled index, bits reversed, and `seed_y` the seed of the second dimension.
  [[gnu::always_inline]] Vec2 pair_of(uint32_t count, uint32_t& shuffled, uint32_t& seed_y) {
    const uint32_t seed = hash32(unit_seed_ ^ (dimension_ * 0x9e3779b9U));
    dimension_ += count;
    shuffled = sobol::reverse_bits(sobol::laine_karras_permutation(index_reversed_, seed));
    const uint32_t seed_x = hash32(seed);
    seed_y = hash32(seed_x);
    const uint32_t x = sobol::laine_karras_permutation(shuffled, seed_x);
    const uint32_t y = sobol::laine_karras_permutation(sobol::second_dimension_reversed(shuffled), seed_y);
    const uint64_t both = sobol::reverse_bits_64(uint64_t(y) << 32 | x);
    return {to_unit_float(uint32_t(both >> 32)), to_unit_float(uint32_t(both))};
  }

  Kind kind_;
  uint32_t seed_, unit_seed_ = 0, index_ = 0, index_reversed_ = 0, dimension_ = 0;
  Pcg32 rng_;
};

}  // namespace ajar
