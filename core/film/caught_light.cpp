#include "film/caught_light.h"

#include <algorithm>

namespace ajar {

void CaughtLight::enable(size_t pixel_count, bool transparent_film) {
  sums_.resize(2 * pixel_count);
  transparent_film_ = transparent_film;
}

void CaughtLight::Sums::add(const Sums& other) {
  caught |= other.caught;
  alpha += other.alpha;
  for (int c = 0; c < 3; ++c) {
    lit[c] += other.lit[c];
    alone[c] += other.alone[c];
    matte[c] += other.matte[c];
    background[c] += other.background[c];
  }
}

double CaughtLight::Sums::ratio(int channel) const {
  return caught && alone[channel] != 0.0 ? lit[channel] / alone[channel] : 1.0;
}

void CaughtLight::add(size_t pixel, const CaughtSample& sample, bool odd) {
  Sums one;
  one.caught = sample.caught;
  one.alpha = double(sample.alpha);
  for (int c = 0; c < 3; ++c) {
    one.lit[c] = double(sample.lit[c]);
    one.alone[c] = double(sample.alone[c]);
    one.matte[c] = double(sample.matte[c]);
    one.background[c] = double(sample.background[c]);
  }
  sums_[2 * pixel + odd].add(one);
}

void CaughtLight::shadow(size_t pixel, float out[3]) const {
  Sums all = sums_[2 * pixel];
  all.add(sums_[2 * pixel + 1]);
  for (int c = 0; c < 3; ++c) out[c] = float(all.ratio(c));
}

void CaughtLight::composite(size_t pixel, uint32_t even, uint32_t odd, double exposure, float out[4]) const {
  Sums sums;
  if (even > 0) sums.add(sums_[2 * pixel]);
  if (odd > 0) sums.add(sums_[2 * pixel + 1]);
  const double scale = even + odd > 0 ? 1.0 / (double(even) + double(odd)) : 0.0;
  const double alpha = std::clamp(sums.alpha * scale, 0.0, 1.0);
  // Light that other objects throw on the catcher is not shown, as in Cycles.
  const double shadow = std::clamp((sums.ratio(0) + sums.ratio(1) + sums.ratio(2)) / 3.0, 0.0, 1.0);
  const double behind = (1.0 - alpha) * shadow;  // how much of the background is seen
  for (int c = 0; c < 3; ++c)
    out[c] = float((sums.matte[c] + (transparent_film_ ? 0.0 : sums.background[c] * behind)) * scale * exposure);
  out[3] = transparent_film_ ? float(1.0 - behind) : 1.0f;
}

}  // namespace ajar
