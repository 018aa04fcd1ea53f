// A picture of the whole film at low resolution, and the importance that follows from it.
//
// Chains that follow luminance give a pixel samples in proportion to its brightness L_c, and relative errors that grow
// where it is dark. What minimises the sum of relMSE terms, L_c^2 / (n (L^2 + 0.01)), is n in proportion to L_c /
// sqrt(L^2 + 0.01), L being all light and L_c what the chains carry: luminance times 1 / sqrt(L^2 + 0.01) (compare
// Hoberock and Hart 2010).
#pragma once

#include <atomic>
#include <cstdint>

#include "transport/paths/film_importance.h"

namespace ajar {

/// Luminance of the film in cells of some pixels, summed by any number of threads with the same result.
class FilmLuminance {
 public:
  FilmLuminance(Vec2 film_min, Vec2 film_max);
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  /// Flux of chains (luminance times pixels^2), and samples of the luminance they leave out.
  void add_flux(Vec2 film, double flux) { add(flux_[cell(film)], flux); }
  void add_sample(Vec2 film, double luminance) {
    add(sum_[cell(film)], luminance);
    count_[cell(film)].fetch_add(1, std::memory_order_relaxed);
  }
  /// 1 / sqrt(L^2 + 0.01), L being `exposure` times the luminance smoothed over neighbours; the flux added stands for
  /// `times` the film's.
  FilmImportance importance(double times, float exposure) const;
  /// All flux added, times `importance` at the centres of the cells it was added to.
  double flux(const FilmImportance& importance) const;

 private:
  static constexpr double kUnits = 0x1p20;
  static constexpr int kCell = 8, kMaxCells = 64;  ///< pixels a cell; cells in a row
  static void add(std::atomic<int64_t>& to, double value) {
    // Lamps that take light away may be as strong as others; what is no number is refused elsewhere.
    const double bounded = value == value ? std::clamp(value, -0x1p30, 0x1p30) : 0.0;
    to.fetch_add(int64_t(std::floor(bounded * kUnits + 0.5)), std::memory_order_relaxed);
  }
  size_t cell(Vec2 film) const {
    const Vec2 p = (film - min_) / (max_ - min_) * Vec2(float(columns_), float(rows_));
    return size_t(std::min(std::max(int(p.y), 0), rows_ - 1) * columns_ +
                  std::min(std::max(int(p.x), 0), columns_ - 1));
  }

  Vec2 min_, max_;
  int columns_, rows_;
  std::vector<std::atomic<int64_t>> flux_, sum_;
  std::vector<std::atomic<uint32_t>> count_;
};

}  // namespace ajar
