#include "math/distribution.h"

#include <cmath>

namespace ajar {

DiscreteDistribution::DiscreteDistribution(const std::vector<double>& weights) {
  size_t positive = 0;
  for (double w : weights) {
    total_ += w;
    positive += w > 0.0;
  }
  cdf_.resize(weights.size(), 0.0f);
  if (!(total_ > 0.0)) return;
  // In units of 2^-24: every positive weight gets one unit, and the others are divided in proportion to the weights.
  // With more than 2^24 positive weights, no unit is reserved, and some entries are never chosen.
  constexpr double kUnits = 0x1p24;
  const bool floor = double(positive) <= kUnits;
  const double shared = floor ? kUnits - double(positive) : kUnits;
  double sum = 0.0;
  size_t seen = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] > 0.0) {
      sum += weights[i];
      ++seen;
    }
    const double units = (floor ? double(seen) : 0.0) + std::round(std::min(sum / total_, 1.0) * shared);
    cdf_[i] = seen == positive ? 1.0f : float(units) * 0x1p-24f;
  }
}

DiscreteDistribution::Choice DiscreteDistribution::sample(float u) const {
  const auto it = std::upper_bound(cdf_.begin(), cdf_.end(), u);
  const uint32_t index = uint32_t(std::min<size_t>(size_t(it - cdf_.begin()), cdf_.size() - 1));
  const float low = index > 0 ? cdf_[index - 1] : 0.0f;
  const float width = cdf_[index] - low;
  const float remapped = width > 0.0f ? std::min((u - low) / width, kOneMinusEpsilon) : 0.5f;
  return {index, width, remapped};
}

Distribution2D::Distribution2D(const std::vector<float>& values, int width, int height)
    : width_(width), height_(height) {
  std::vector<double> rows(height), row(width);
  conditional_.reserve(height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) row[x] = values[size_t(y) * width + x];
    conditional_.emplace_back(row);
    rows[y] = conditional_.back().total();
  }
  marginal_ = DiscreteDistribution(rows);
}

Vec2 Distribution2D::sample(Vec2 u, float& pdf_square) const {
  const auto row = marginal_.sample(u.y);
  const auto column = conditional_[row.index].sample(u.x);
  pdf_square = row.pmf * column.pmf * float(width_) * float(height_);
  return {(float(column.index) + column.u_remapped) / float(width_),
          (float(row.index) + row.u_remapped) / float(height_)};
}

float Distribution2D::pdf_square(Vec2 point) const {
  const int x = std::clamp(int(point.x * float(width_)), 0, width_ - 1);
  const int y = std::clamp(int(point.y * float(height_)), 0, height_ - 1);
  if (conditional_[y].empty()) return 0.0f;
  return marginal_.pmf(uint32_t(y)) * conditional_[y].pmf(uint32_t(x)) * float(width_) * float(height_);
}

}  // namespace ajar
