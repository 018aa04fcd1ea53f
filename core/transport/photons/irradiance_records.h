// Irradiance records: what arrives at a few points of diffuse surfaces, and what it is likely to be between them
// [Ward, Rubinstein and Clear 1988].
//
// A record's value changes around it by its gradients over rotation and translation [Ward and Heckbert 1992]. It speaks
// for the points within its radius, a share of the harmonic mean distance of the surfaces it sees, kept between two
// limits by the caller and, where a neighbour has seen something close, near the neighbour's [Krivanek et al. 2006,
// "Making radiance and irradiance caching practical"]. The weight falls to zero at the radius [Tabellion and Lamorlette
// 2004], so that no edge shows there. Radii and weights come from distances alone, never from radiance: a record of
// great value speaks for no other area than one of small value, and noise in records is no bias. What remains is the
// error of the interpolation.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "math/frame.h"
#include "math/types.h"

namespace ajar {

struct IrradianceRecord {
  Vec3 position{0.0f}, normal{0, 0, 1};
  float radius = 0.0f;  ///< of the area it speaks for
  Color irradiance{0.0f};
  Mat3 by_rotation{0.0f}, by_translation{0.0f};  ///< gradients, a column for each channel

  /// In [0, 1]; 0 where it does not speak for a point with this normal.
  float weight(Vec3 p, Vec3 n) const;
  /// Carried over to there by the gradients, which change it by its own value at most.
  Color at(Vec3 p, Vec3 n) const;
};

/// Strata of equal projected solid angle over a hemisphere: rows of the polar angle, columns of the azimuth.
class HemisphereGrid {
 public:
  /// About this many strata, as many times more columns than rows as makes them square.
  explicit HemisphereGrid(int strata);
  int strata() const { return rows_ * columns_; }
  /// Direction in the local frame for stratum i, by the cosine.
  Vec3 direction(int i, Vec2 u) const;
  /// Irradiance and gradients from the radiance along one direction in each stratum, and one over the distance of what
  /// was seen there. The radius is the harmonic mean distance, infinite when nothing was seen.
  IrradianceRecord record(Vec3 position, const Frame& frame, std::span<const Color> radiance,
                          std::span<const float> inverse_distance) const;

 private:
  int rows_, columns_;
};

class IrradianceRecords {
 public:
  /// Of the harmonic mean distance, for which a record speaks; and how much more than a neighbour's its radius may be,
  /// of the way between them.
  static constexpr float kRadiusShare = 0.4f;

  void clear();
  /// Records without a radius are left out.
  void add(std::span<const IrradianceRecord> records);
  /// After adding. The order of records decides nothing but rounding.
  void limit_by_neighbours();
  size_t size() const { return records_.size(); }
  size_t memory_bytes() const;
  /// About what a record takes with its places in the cells.
  static constexpr size_t kBytesPerRecord = 400;
  const IrradianceRecord& operator[](size_t i) const { return records_[i]; }

  /// Sum of the weights at a point: how well it is covered.
  float coverage(Vec3 p, Vec3 n) const;
  /// The weighted mean of the records that speak for a point; false where they hardly do.
  bool find(Vec3 p, Vec3 n, Color& irradiance) const;

 private:
  /// A level of cells twice to four times as large as the radii of the records in it.
  struct Level {
    float cell_size = 0.0f;
    std::unordered_map<uint64_t, std::vector<uint32_t>> cells;
  };
  static uint64_t cell_key(const Level& level, Vec3 p);
  template <class Visit>
  void for_each_near(Vec3 p, Visit&& visit) const;
  void insert(uint32_t index);

  std::vector<IrradianceRecord> records_;
  std::vector<Level> levels_;
};

}  // namespace ajar
