// Sums of films: exact whatever the order and the division of the samples.
#include <random>

#include <gtest/gtest.h>

#include "film/film.h"

namespace ajar::test_film_sums {

namespace {

/// Floats whose magnitudes differ by up to 2^50.
std::vector<float> wild_numbers(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> exponent(-40, 10);
  std::uniform_real_distribution<float> mantissa(1.0f, 2.0f);
  std::vector<float> numbers(count);
  for (float& x : numbers) x = std::ldexp(mantissa(random), exponent(random)) * (random() % 8 == 0 ? -1.0f : 1.0f);
  return numbers;
}

TEST(FilmSums, a_pair_is_the_exact_sum_rounded_in_any_order) {
  for (uint32_t seed = 0; seed < 20; ++seed) {
    std::vector<float> numbers = wild_numbers(3000, seed);
    __int128 exact = 0;  // in units of 2^-63: the last bit of the smallest number
    for (const float x : numbers) exact += __int128(std::ldexp(double(x), 63));
    std::mt19937 random(seed);
    for (int order = 0; order < 3; ++order) {
      double high = 0.0, low = 0.0, plain = 0.0;
      for (const float x : numbers) add_exactly(high, low, double(x)), plain += double(x);
      EXPECT_EQ(high, std::ldexp(double(exact), -63));
      EXPECT_EQ(low, std::ldexp(double(exact - __int128(std::ldexp(high, 63))), -63));
      std::shuffle(numbers.begin(), numbers.end(), random);
    }
  }
}

const std::vector<std::string> kPasses{
    "Combined", "Halves",  "Variance",         "Depth",        "Normal",   "Mist",     "Albedo",       "DiffDir",
    "DiffCol",  "IndexOB", "Denoising Albedo", "Sample Count", "GlossInd", "GlossCol", "Direct Halves"};

/// A film with the samples [first, end). `narrow`: all radiances have the same magnitude.
std::unique_ptr<Film> film_of(uint32_t first, uint32_t end, bool narrow = false) {
  auto made = std::make_unique<Film>(1, 2, 4, 4, kPasses);
  Film& film = *made;
  film.begin_at(first);
  EXPECT_TRUE(film.keep_exact_sums());
  film.enable_splats();
  for (int y = 2; y < 4; ++y)
    for (int x = 1; x < 4; ++x)
      for (uint32_t i = first; i < end; ++i) {
        EXPECT_EQ(film.samples_of(x, y), i);
        std::vector<float> v = wild_numbers(16, uint32_t(x) + 10 * uint32_t(y) + 100 * i);
        int exponent;
        for (size_t k = 12; narrow && k < 15; ++k) v[k] = std::frexp(v[k], &exponent);
        SampleAux aux;
        aux.depth = v[0];
        aux.normal = Vec3(v[1], v[2], v[3]);
        aux.mist = v[4];
        aux.albedo = Color(v[5], v[6], v[7]);
        aux.object_index = float(i);
        aux.guide_albedo = Color(v[8]);
        SampleParts parts;
        parts.direct[0] = Color(v[9], v[10], v[11]);
        parts.color[0] = parts.color[1] = Color(0.1f, 0.2f, 0.3f);
        // The first sample of one pixel is refused.
        const bool refused = i == 0 && x == 1 && y == 2;
        const bool added = film.add_sample(x, y, refused ? Color(kInfinity) : Color(v[12], v[13], v[14]), 0.3f, &aux);
        EXPECT_NE(added, refused);
        if (added) {
          film.add_parts(x, y, parts);
          film.add_direct(x, y, Color(v[12], v[9], v[10]));
        }
        PathPasses passes;
        passes.part = PathPasses::Part::Indirect;
        passes.shares = {Color(0.5f), Color(0.5f), Color(0.0f)};
        passes.is_direct = i % 3 == 0;
        film.add_splat(1 + int(i % 3), 2, Color(std::abs(v[15]), 1e-9f, 1e7f), i & 1, passes);
      }
  const double mean = film.sample_counts().mean;
  film.end_splats(mean > 0.0 ? 1.0 / mean : 0.0);
  return made;
}

TEST(FilmSums, parts_of_the_samples_add_up_to_all_of_them_bit_for_bit) {
  const auto made = film_of(0, 60);
  const Film& whole = *made;
  for (const std::vector<uint32_t>& ends : {std::vector<uint32_t>{0, 60}, {0, 1, 60}, {0, 7, 20, 21, 60}}) {
    FilmSums sums;
    for (size_t k = 0; k + 1 < ends.size(); ++k) {
      const FilmSums more = film_of(ends[k], ends[k + 1])->sums();
      if (k == 0)
        sums = more;
      else
        sums.add(more);
    }
    const FilmSums expected = whole.sums();
    EXPECT_EQ(sums.counts, expected.counts);
    EXPECT_EQ(sums.firsts, expected.firsts);
    for (size_t k = 0; k < sums.tables.size(); ++k) {
      FilmSums::Table added = sums.tables[k], once = expected.tables[k];
      EXPECT_EQ(added.high, once.high) << "table " << k;
      // A pair of doubles has 106 bits. The squares of the luminances of these numbers span more.
      for (size_t i = 7; k == 0 && i < once.low.size(); i += once.width) added.low[i] = once.low[i] = 0.0;
      EXPECT_EQ(added.low, once.low) << "table " << k;
    }
    Film read(1, 2, 4, 4, kPasses);
    read.set_sums(sums);
    for (const std::string& pass : kPasses) EXPECT_EQ(read.resolve(pass, 1.5f), whole.resolve(pass, 1.5f)) << pass;
    EXPECT_EQ(read.estimated_relmse(), whole.estimated_relmse());
  }
}

TEST(FilmSums, parts_add_up_in_all_words_also_of_the_squares_of_luminances) {
  const FilmSums whole = film_of(0, 60, true)->sums();
  FilmSums sums = film_of(0, 7, true)->sums();
  sums.add(film_of(7, 21, true)->sums());
  sums.add(film_of(21, 60, true)->sums());
  EXPECT_TRUE(sums == whole);
}

TEST(FilmSums, a_film_keeps_them_only_if_it_is_asked) {
  Film plain(1, 2, 4, 4, kPasses);
  EXPECT_EQ(plain.sums().pixels, 0u);
  EXPECT_GT(film_of(0, 1)->memory_bytes(), plain.memory_bytes());
}

TEST(FilmSums, sums_of_other_passes_or_sizes_are_refused) {
  const FilmSums sums = film_of(0, 2)->sums();
  Film other(1, 2, 4, 4, {"Combined"}), larger(1, 2, 5, 4, kPasses);
  EXPECT_THROW(other.set_sums(sums), std::invalid_argument);
  EXPECT_THROW(larger.set_sums(sums), std::invalid_argument);
  EXPECT_TRUE(other.keep_exact_sums());
  EXPECT_FALSE(sums.has_same_form(other.sums()));
}

TEST(FilmSums, passes_in_tables_of_their_own_have_no_exact_sums) {
  EXPECT_FALSE(Film(0, 0, 2, 2, {"Combined", "CryptoObject00"}).keep_exact_sums());
  EXPECT_FALSE(Film(0, 0, 2, 2, {"Combined", "AO"}).keep_exact_sums());
  EXPECT_TRUE(Film(0, 0, 2, 2, {"Combined"}).keep_exact_sums());
}

}  // namespace

}  // namespace ajar::test_film_sums
