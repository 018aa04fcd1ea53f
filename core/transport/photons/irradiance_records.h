// Irradiance records: irradiance at a few points of diffuse surfaces, and its interpolation between them [Ward,
// Rubinstein and Clear 1988].
//
// The irradiance around a record follows its gradients over rotation and translation [Ward and Heckbert 1992]. A record
// is valid for the points within its radius. The radius is a share of the harmonic mean distance of the surfaces that
// the record sees. The caller keeps it between two limits. Where a neighbour has seen a close surface, the radius is
// kept near that of the neighbour [Krivanek et al. 2006, "Making radiance and irradiance caching practical"]. The
// weight falls to zero at the radius [Tabellion and Lamorlette 2004], so that no edge is visible there.
//
// Radii and weights depend on distances alone and never on radiance. A record with large irradiance is therefore valid
// for the same area as one with small irradiance, and noise in records causes no bias. The error of the interpolation
// is the only bias.
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
  float radius = 0.0f;  ///< of the area for which the record is valid
  Color irradiance{0.0f};
  Mat3 by_rotation{0.0f}, by_translation{0.0f};  ///< gradients, one column for each channel

  /// In [0, 1]; 0 where the record is not valid for a point with this normal.
  float weight(Vec3 p, Vec3 n) const;
  /// Irradiance at `p` by the gradients. The change is at most the record's own irradiance.
  Color at(Vec3 p, Vec3 n) const;
};

/// Strata of equal projected solid angle over a hemisphere: rows for the polar angle, columns for the azimuth.
class HemisphereGrid {
 public:
  /// About this many strata. The ratio of columns to rows makes them nearly square.
  explicit HemisphereGrid(int strata);
  int strata() const { return rows_ * columns_; }
  /// Direction in the local frame for stratum i, with a density in proportion to the cosine.
  Vec3 direction(int i, Vec2 u) const;
  /// Irradiance and gradients. `radiance`: along one direction in each stratum. `inverse_distance`: to the surface that
  /// was hit there. The radius is the harmonic mean distance; it is infinite when nothing was hit.
  IrradianceRecord record(Vec3 position, const Frame& frame, std::span<const Color> radiance,
                          std::span<const float> inverse_distance) const;

 private:
  int rows_, columns_;
};

class IrradianceRecords {
 public:
  /// Part of the harmonic mean distance that becomes the radius of a record. Also the maximum difference between the
  /// radii of neighbours, relative to the distance between them.
  static constexpr float kRadiusShare = 0.4f;

  void clear();
  /// Records without a radius are ignored.
  void add(std::span<const IrradianceRecord> records);
  /// Called after `add`. The order of the records affects the result by rounding only.
  void limit_by_neighbours();
  size_t size() const { return records_.size(); }
  size_t memory_bytes() const;
  /// Approximate size of a record with its entries in the cells.
  static constexpr size_t kBytesPerRecord = 400;
  const IrradianceRecord& operator[](size_t i) const { return records_[i]; }

  /// Sum of the weights at a point.
  float coverage(Vec3 p, Vec3 n) const;
  /// The weighted mean of the records that are valid for a point. Returns false where the sum of their weights is too
  /// small.
  bool find(Vec3 p, Vec3 n, Color& irradiance) const;

 private:
  /// A grid with cells that are two to four times as large as the radii of the records in it.
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
