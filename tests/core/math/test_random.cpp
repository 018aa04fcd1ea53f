#include "statistical.h"

#include <set>

#include "math/random.h"

namespace ajar::test_random {

namespace {

using namespace statistical;

double chi_square_of(const std::vector<int>& counts, double expected) {
  double statistic = 0.0;
  for (int c : counts) statistic += (c - expected) * (c - expected) / expected;
  return chi_square_p_value(statistic, double(counts.size()) - 1.0);
}

TEST(Hash, one_flipped_bit_flips_half_of_the_result) {
  // Strict avalanche: every output bit changes with probability 1/2 for every input bit.
  Pcg32 rng(1);
  const int trials = 4096;
  for (int in = 0; in < 32; ++in) {
    std::vector<int> flips(32, 0);
    for (int t = 0; t < trials; ++t) {
      const uint32_t x = rng.next(), difference = hash32(x) ^ hash32(x ^ (1u << in));
      for (int out = 0; out < 32; ++out) flips[out] += int(difference >> out & 1);
    }
    for (int out = 0; out < 32; ++out)
      EXPECT_NEAR(flips[out], trials / 2, 6.0 * std::sqrt(trials / 4.0)) << in << " " << out;
  }
}

TEST(Hash, hashes_are_permutations_on_small_numbers) {
  std::set<uint32_t> seen;
  std::set<uint64_t> seen64;
  for (uint32_t i = 0; i < 100000; ++i) {
    seen.insert(hash32(i));
    seen64.insert(hash64(i));
  }
  EXPECT_EQ(seen.size(), 100000u);
  EXPECT_EQ(seen64.size(), 100000u);
}

TEST(Hash, combining_is_not_symmetric_and_rarely_collides) {
  EXPECT_NE(hash_combine(1, 2), hash_combine(2, 1));
  std::set<uint32_t> seen;
  for (uint32_t a = 0; a < 256; ++a)
    for (uint32_t b = 0; b < 256; ++b) seen.insert(hash_combine(a, b));
  EXPECT_GE(seen.size(), 65536u - 4u);  // a random function has about half a collision here
}

TEST(UnitFloat, stays_below_one) {
  EXPECT_EQ(to_unit_float(0), 0.0f);
  EXPECT_LT(to_unit_float(~0u), 1.0f);
  EXPECT_EQ(to_unit_float(0x80000000u), 0.5f);
}

TEST(Pcg32, numbers_and_consecutive_pairs_are_uniform) {
  Pcg32 rng(42, 7);
  std::vector<int> singles(1024, 0), pairs(4096, 0);
  float previous = rng.next_float();
  for (int i = 0; i < 1 << 18; ++i) {
    const float x = rng.next_float();
    ++singles[int(x * 1024.0f)];
    ++pairs[int(x * 64.0f) * 64 + int(previous * 64.0f)];
    previous = x;
  }
  EXPECT_GT(chi_square_of(singles, double(1 << 18) / 1024.0), 1e-3);
  EXPECT_GT(chi_square_of(pairs, double(1 << 18) / 4096.0), 1e-3);
}

TEST(Pcg32, streams_are_repeatable_and_independent) {
  Pcg32 a(1, 2), same(1, 2);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(a.next(), same.next());
  // The first numbers of neighbouring seeds and sequences are also uniform.
  std::vector<int> seeds(64, 0), sequences(64, 0);
  for (uint64_t i = 0; i < 65536; ++i) {
    ++seeds[int(Pcg32(i, 0).next_float() * 64.0f)];
    ++sequences[int(Pcg32(0, i).next_float() * 64.0f)];
  }
  EXPECT_GT(chi_square_of(seeds, 1024.0), 1e-3);
  EXPECT_GT(chi_square_of(sequences, 1024.0), 1e-3);
}

}  // namespace

}  // namespace ajar::test_random
