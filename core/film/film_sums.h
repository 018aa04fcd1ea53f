// The sums of a film, such that those of other samples of the same pixels can be added without a rounding error.
//
// A sum is a pair of doubles: the sum rounded to a double, and the rest (Dekker, "A floating-point technique for
// extending the available precision", 1971). A sample is a float of 24 bits. The pair is exact as long as the sum is
// below 2^80 times the smallest sample of its pixel. The rounded part then depends on the set of samples and neither on
// their order nor on the sums of parts that were added. So samples may be divided among machines, and the image is the
// same bit for bit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ajar {

/// Adds a double to the pair.
inline void add_exactly(double& high, double& low, double value) {
  const double sum = high + value, part = sum - high, error = (high - (sum - part)) + (value - part);
  const double rest = low + error;
  high = sum + rest;
  low = rest - (high - sum);
}

struct FilmSums {
  static constexpr size_t kFirsts = 7;
  static constexpr std::array<size_t, 6> kWidths{8, 21, 6, 39, 6, 6};
  /// Sums by pixel, `width` of each. Empty: the film has none.
  struct Table {
    size_t width = 0;
    std::vector<double> high, low;
    bool operator==(const Table&) const = default;
  };
  size_t pixels = 0;
  std::vector<uint32_t> counts;  ///< for each pixel: samples, and those of them with an odd number
  /// Values that are not averaged, from the first sample of each pixel that has one: depth, position, the indices of
  /// object and material, and 1 if there is such a sample. Empty: the film has none.
  std::vector<float> firsts;
  /// Samples, surfaces, guides of a denoiser, parts of the light, splats, direct paths.
  std::array<Table, kWidths.size()> tables;

  bool has_same_form(const FilmSums& other) const;
  /// Adds the sums of other samples. `firsts` keeps its values. Both must have the same form.
  void add(const FilmSums& other);
  bool operator==(const FilmSums&) const = default;
};

}  // namespace ajar
