// The importance of a position on the film. Chains follow luminance times importance, and their splats are divided by
// it [Veach 1997, section 11.3.2].
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "math/types.h"

namespace ajar {

class FilmImportance {
 public:
  /// Importance 1 everywhere.
  FilmImportance() = default;
  /// Values at the centres of cells, interpolated bilinearly.
  FilmImportance(Vec2 film_min, Vec2 film_max, int columns, int rows, std::vector<float> values)
      : columns_(columns),
        rows_(rows),
        origin_(film_min),
        per_cell_(Vec2(float(columns), float(rows)) / (film_max - film_min)),
        values_(std::move(values)) {}

  float at(Vec2 film) const { return values_.empty() ? 1.0f : interpolate(film); }

 private:
  float interpolate(Vec2 film) const {
    const Vec2 place = (film - origin_) * per_cell_ - 0.5f;
    const float x = std::clamp(place.x, 0.0f, float(columns_ - 1)), y = std::clamp(place.y, 0.0f, float(rows_ - 1));
    const int x0 = std::min(int(x), std::max(0, columns_ - 2)), y0 = std::min(int(y), std::max(0, rows_ - 2));
    const int x1 = std::min(x0 + 1, columns_ - 1), y1 = std::min(y0 + 1, rows_ - 1);
    const float s = x - float(x0), t = y - float(y0);
    const auto value = [&](int column, int row) { return values_[size_t(row) * size_t(columns_) + size_t(column)]; };
    return (1.0f - t) * ((1.0f - s) * value(x0, y0) + s * value(x1, y0)) +
           t * ((1.0f - s) * value(x0, y1) + s * value(x1, y1));
  }

  int columns_ = 0, rows_ = 0;
  Vec2 origin_{0.0f}, per_cell_{0.0f};
  std::vector<float> values_;
};

}  // namespace ajar
