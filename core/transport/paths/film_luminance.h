// The luminance of the whole film at low resolution, and the importance that is derived from it.
//
// Chains that follow luminance give a pixel samples in proportion to its luminance L_c, so relative errors are large
// where the image is dark. The sum of the relMSE terms L_c^2 / (n (L^2 + 0.01)) is minimal for n proportional to L_c /
// sqrt(L^2 + 0.01), where L is the luminance of all light and L_c that of the light that chains find. So the target is
// luminance times 1 / sqrt(L^2 + 0.01) (compare Hoberock and Hart 2010).
#pragma once

#include <atomic>
#include <cstdint>

#include "transport/paths/film_importance.h"

namespace ajar {

/// The luminance of the film in cells of 8 x 8 pixels or more. Any number of threads can add to it, with the same
/// result.
class FilmLuminance {
 public:
  /// `exposure`: light times this is displayed.
  FilmLuminance(Vec2 film_min, Vec2 film_max, float exposure);
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  float exposure() const { return exposure_; }
  /// add_flux: flux of chains (luminance times pixels^2), in a unit in which it is not far from 1. add_sample: a sample
  /// of the luminance that chains leave out.
  void add_flux(Vec2 film, double flux) { add(flux_[cell(film)], flux); }
  void add_sample(Vec2 film, double luminance) {
    add(sum_[cell(film)], double(exposure_) * luminance);
    count_[cell(film)].fetch_add(1, std::memory_order_relaxed);
  }
  /// The importance 1 / sqrt(L^2 + 0.01) with the displayed luminance L, smoothed over neighbouring cells. The sum of
  /// the added flux is `times` the flux of the film.
  FilmImportance importance(double times) const;
  /// The sum of all added flux, each multiplied by `importance` at the centre of its cell.
  double flux(const FilmImportance& importance) const;

 private:
  static constexpr double kUnits = 0x1p20;
  static constexpr int kCell = 8, kMaxCells = 64;  ///< pixels per cell; maximum number of cells per row
  static void add(std::atomic<int64_t>& to, double value) {
    // Lamps with negative light can be as strong as others. NaN counts as 0 here; it is refused elsewhere.
    const double bounded = value == value ? std::clamp(value, -0x1p30, 0x1p30) : 0.0;
    to.fetch_add(int64_t(std::floor(bounded * kUnits + 0.5)), std::memory_order_relaxed);
  }
  size_t cell(Vec2 film) const {
    const Vec2 p = (film - min_) / (max_ - min_) * Vec2(float(columns_), float(rows_));
    return size_t(std::min(std::max(int(p.y), 0), rows_ - 1) * columns_ +
                  std::min(std::max(int(p.x), 0), columns_ - 1));
  }

  Vec2 min_, max_;
  float exposure_;
  int columns_, rows_;
  std::vector<std::atomic<int64_t>> flux_, sum_;
  std::vector<std::atomic<uint32_t>> count_;
};

}  // namespace ajar
