#include "transport/paths/film_luminance.h"

#include <algorithm>

#include "math/relative_error.h"

namespace ajar {

namespace {
int cells(float pixels, int size, int most) { return std::clamp(int(std::ceil(pixels / float(size))), 1, most); }
}  // namespace

FilmLuminance::FilmLuminance(Vec2 film_min, Vec2 film_max, float exposure)
    : min_(film_min),
      max_(film_max),
      exposure_(exposure),
      columns_(cells(film_max.x - film_min.x, kCell, kMaxCells)),
      rows_(cells(film_max.y - film_min.y, kCell, kMaxCells)),
      flux_(size_t(columns_ * rows_)),
      sum_(flux_.size()),
      count_(flux_.size()) {}

FilmImportance FilmLuminance::importance(double times) const {
  const Vec2 size = (max_ - min_) / Vec2(float(columns_), float(rows_));
  std::vector<float> values(flux_.size());
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      double flux = 0.0, sum = 0.0, count = 0.0, area = 0.0;
      for (int j = std::max(0, row - 1); j <= std::min(rows_ - 1, row + 1); ++j) {
        for (int i = std::max(0, column - 1); i <= std::min(columns_ - 1, column + 1); ++i) {
          // Along each axis, the weight is 2 for the cell itself and 1 for its neighbours.
          const double weight = (j == row ? 2.0 : 1.0) * (i == column ? 2.0 : 1.0);
          const size_t k = size_t(j * columns_ + i);
          flux += weight * double(flux_[k].load()) / kUnits;
          sum += weight * double(sum_[k].load()) / kUnits;
          count += weight * double(count_[k].load());
          area += weight * double(size.x) * double(size.y);
        }
      }
      const double luminance = (times > 0.0 ? double(exposure_) * flux / (times * area) : 0.0) +
                               (count > 0.0 ? sum / count : 0.0);
      values[size_t(row * columns_ + column)] = float(1.0 / std::sqrt(luminance * luminance + kDarkSquared));
    }
  }
  return FilmImportance(min_, max_, columns_, rows_, std::move(values));
}

double FilmLuminance::flux(const FilmImportance& importance) const {
  const Vec2 size = (max_ - min_) / Vec2(float(columns_), float(rows_));
  double sum = 0.0;
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column)
      sum += double(flux_[size_t(row * columns_ + column)].load()) / kUnits *
             double(importance.at(min_ + size * Vec2(float(column) + 0.5f, float(row) + 0.5f)));
  return sum;
}

}  // namespace ajar
