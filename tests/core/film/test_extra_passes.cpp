#include "film/extra_passes.h"

#include <bit>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "film/film.h"
#include "math/random.h"

namespace ajar::test_extra_passes {

namespace {

SampleExtras sample_of(std::vector<MatteSample> mattes) {
  SampleExtras extras;
  extras.mattes = std::move(mattes);
  return extras;
}

}  // namespace

TEST(NameHash, has_the_published_values_of_murmur_hash_3) {
  EXPECT_EQ(murmur_hash3(""), 0u);
  EXPECT_EQ(murmur_hash3("test"), 0xba6bd213u);
  EXPECT_EQ(murmur_hash3("Hello, world!"), 0xc0363e43u);
  EXPECT_EQ(murmur_hash3("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
}

TEST(NameHash, ids_are_finite_and_not_zero) {
  int flipped = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::string name = "Object." + std::to_string(i);
    const float id = matte_id(name);
    ASSERT_TRUE(std::isnormal(id)) << name;
    const uint32_t bits = std::bit_cast<uint32_t>(id), hash = murmur_hash3(name);
    ASSERT_EQ(bits & ~(1u << 23), hash & ~(1u << 23));
    flipped += bits != hash;
  }
  EXPECT_NEAR(flipped, 20000 / 128, 50);  // two of 256 exponents
}

TEST(ExtraPasses, names_of_passes) {
  EXPECT_EQ(channels_of_pass("CryptoObject00"), 4);
  EXPECT_EQ(channels_of_pass("CryptoAsset07"), 4);
  for (const char* wrong : {"CryptoObject08", "CryptoObject", "CryptoObject0", "CryptoObject000", "Crypto00",
                            "AOV Color ", "AOV Value ", "Combined_", "Cryptomatte"})
    EXPECT_EQ(channels_of_pass(wrong), 0) << wrong;
  EXPECT_EQ(channels_of_pass("AOV Color heat"), 4);
  EXPECT_EQ(channels_of_pass("AOV Value heat"), 1);
  EXPECT_EQ(channels_of_pass("Combined_key light"), 3);
  EXPECT_THROW(Film(0, 0, 4, 4, {"Combined", "CryptoObject9"}), std::invalid_argument);
}

TEST(ExtraPasses, mattes_are_ranked_by_coverage) {
  ExtraPasses passes({"CryptoObject00", "CryptoObject01"}, 2);
  for (int i = 0; i < 8; ++i) {
    passes.add(1, sample_of({{{1.0f, 0.0f, 0.0f}, 0.25f}, {{2.0f, 0.0f, 0.0f}, 0.5f}}));
    if (i < 2) passes.add(1, sample_of({{{3.0f, 0.0f, 0.0f}, 0.25f}}));
  }
  float first[4] = {}, second[4] = {}, other[4] = {1, 1, 1, 1};
  passes.resolve("CryptoObject00", 1, 8, 1.0f, first);
  passes.resolve("CryptoObject01", 1, 8, 1.0f, second);
  passes.resolve("CryptoObject00", 0, 8, 1.0f, other);
  EXPECT_EQ(std::vector<float>(first, first + 4), (std::vector<float>{2.0f, 0.5f, 1.0f, 0.25f}));
  EXPECT_EQ(std::vector<float>(second, second + 4), (std::vector<float>{3.0f, 0.0625f, 0.0f, 0.0f}));
  EXPECT_EQ(std::vector<float>(other, other + 4), std::vector<float>(4, 0.0f));
  EXPECT_EQ(passes.dropped(), 0.0);
}

TEST(ExtraPasses, a_full_table_keeps_the_largest_and_counts_the_rest) {
  ExtraPasses passes({"CryptoObject00"}, 1);
  Pcg32 rng(1);
  std::map<float, double> exact;
  double all = 0.0;
  for (int i = 0; i < 10000; ++i) {
    const float u = rng.next_float();
    // two large mattes and a hundred small ones
    const float id = u < 0.5f ? 1.0f : u < 0.8f ? 2.0f : 3.0f + std::floor(100.0f * rng.next_float());
    passes.add(0, sample_of({{{id, 0.0f, 0.0f}, 1.0f}}));
    exact[id] += 1.0;
    all += 1.0;
  }
  float shown[4];
  passes.resolve("CryptoObject00", 0, all, 1.0f, shown);
  EXPECT_EQ(shown[0], 1.0f);
  EXPECT_NEAR(shown[1], float(exact[1.0f] / all), 1e-5f);
  EXPECT_EQ(shown[2], 2.0f);
  EXPECT_NEAR(shown[3], float(exact[2.0f] / all), 1e-5f);
  EXPECT_GT(passes.dropped(), 0.1 * all);
  EXPECT_LT(passes.dropped(), 0.2 * all);
}

TEST(ExtraPasses, mattes_of_two_renders_are_merged_by_their_ids) {
  const std::vector<float> a{1.0f, 0.6f, 2.0f, 0.4f}, b{2.0f, 0.9f, 3.0f, 0.1f};
  const auto merged = merge_mattes({&a}, 0.5, {&b}, 0.5);
  ASSERT_EQ(merged.size(), 1u);
  EXPECT_EQ(merged[0][0], 2.0f);
  EXPECT_NEAR(merged[0][1], 0.65f, 1e-6f);
  EXPECT_EQ(merged[0][2], 1.0f);
  EXPECT_NEAR(merged[0][3], 0.3f, 1e-6f);
}

TEST(ExtraPasses, a_film_without_them_holds_nothing_for_them) {
  const Film plain(0, 0, 8, 8, {"Combined"}), mattes(0, 0, 8, 8, {"Combined", "CryptoMaterial00"});
  EXPECT_FALSE(plain.wants_aux());
  EXPECT_FALSE(plain.wants_parts());
  EXPECT_TRUE(mattes.wants_aux());
  EXPECT_GT(mattes.memory_bytes(), plain.memory_bytes());
  EXPECT_GE(Film::bytes_per_pixel({"Combined", "CryptoMaterial00"}, false) * 64, mattes.memory_bytes());
}

}  // namespace ajar::test_extra_passes
