#include "transport/guiding/guide_lobes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "math/frame.h"

namespace ajar {

namespace {

/// Pseudo-samples of the priors: kSharePrior with equal shares for guide and BSDF, kWeightPrior for the weight of each
/// lobe.
constexpr float kSharePrior = 8.0f, kWeightPrior = 0.02f;
/// Minimum share of the BSDF for a single direction (for whole paths: kPlainShareOfPaths).
constexpr float kMinBsdfShare = 0.5f;
constexpr float kFirstKappa = 10.0f, kSharpestKappa = 2000.0f;
/// The weight of a sample is limited to this times the square root of the number of samples, in units of the mean
/// weight.
constexpr float kMaxWeight = 4.0f;

}  // namespace

void GuideDistribution::move_to(Vec3 center) {
  const Vec3 d = center_ - center;
  for (int k = 0; k < kCount; ++k) {
    const Vec3 mean = glm::normalize(this->mean(k) + d * inverse_distance_[k] + Vec3(1e-9f));
    if (!is_finite(mean)) continue;
    // The sums rotate with the lobes.
    const float length = glm::length(Vec3(past_.x[k], past_.y[k], past_.z[k]));
    past_.x[k] = length * mean.x;
    past_.y[k] = length * mean.y;
    past_.z[k] = length * mean.z;
    lobes_.x[k] = mean.x;
    lobes_.y[k] = mean.y;
    lobes_.z[k] = mean.z;
  }
  center_ = center;
}

/// The means of the lobes are far from each other and from the directions that the BSDF covers. Each mean is the sample
/// with the maximum of weight times squared chord to the nearest mean so far (as in k-means++, but deterministic).
void GuideDistribution::start(Vec3 center, std::span<const GuideSample* const> samples) {
  center_ = center;
  std::memset(&past_, 0, sizeof past_);
  for (float& share : share_) share = 0.5f;
  // A subset of the samples is enough to find their distribution.
  constexpr size_t kMaxInspected = 256;
  const size_t stride = std::max<size_t>(1, samples.size() / kMaxInspected);
  float nearest[2 * kMaxInspected];
  size_t looked = 0;
  double sum = 0.0;
  for (size_t i = 0; i < samples.size() && looked < 2 * kMaxInspected; i += stride)
    sum += double(samples[i]->weight), nearest[looked++] = 4.0f;
  const float max_weight = 4.0f * float(sum / double(std::max<size_t>(1, looked)));
  for (int k = 0; k < kCount; ++k) {
    size_t best = 0;
    float best_score = -1.0f;
    for (size_t i = 0; i < looked; ++i) {
      const float score = std::min(samples[i * stride]->weight, max_weight) * nearest[i];
      if (score > best_score) best_score = score, best = i;
    }
    const Vec3 mean = looked > 0 ? samples[best * stride]->wi : Vec3(0, 0, 1);
    for (size_t i = 0; i < looked; ++i)
      nearest[i] = std::min(nearest[i], length_squared(samples[i * stride]->wi - mean));
    lobes_.x[k] = mean.x;
    lobes_.y[k] = mean.y;
    lobes_.z[k] = mean.z;
    lobes_.half_kappa[k] = 0.5f * kFirstKappa;
    weight_[k] = 1.0f / float(kCount);
    lobes_.peak[k] = weight_[k] * von_mises_fisher::peak_pdf_solid_angle(kFirstKappa);
    inverse_distance_[k] = 0.0f;
  }
}

/// The E step: the share of each component in each sample, summed with the weights of the samples [Cappé et al. 2008].
void GuideDistribution::accumulate(std::span<const GuideSample* const> samples, float unit, float max_weight,
                                   Sums& sums) const {
  std::memset(&sums, 0, sizeof sums);
  for (const GuideSample* const s : samples) {
    const float w = std::min(s->weight * unit, max_weight);
    // The direction as seen from the centre of the cell.
    const Vec3 wi = glm::normalize(s->wi + (s->position - center_) * s->inverse_distance);
    if (!(w > 0.0f) || !is_finite(wi)) continue;
    const size_t kind = size_t(s->kind);
    float value[kCount], guide = 0.0f;
    for (int k = 0; k < kCount; ++k) {
      const float dx = lobes_.x[k] - wi.x, dy = lobes_.y[k] - wi.y, dz = lobes_.z[k] - wi.z;
      value[k] = lobes_.peak[k] * exp_of_negative(-lobes_.half_kappa[k] * (dx * dx + dy * dy + dz * dz));
    }
    for (int k = 0; k < kCount; ++k) guide += value[k];
    const float bsdf = (1.0f - share_[kind]) * s->pdf_bsdf, all = bsdf + share_[kind] * guide;
    if (!(all > 0.0f)) continue;
    const float scale = w / all, of_guide = share_[kind] * scale;
    sums.bsdf[kind] += bsdf * scale;
    sums.total[kind] += w;
    for (int k = 0; k < kCount; ++k) {
      const float r = value[k] * of_guide;
      sums.weight[k] += r;
      sums.x[k] += r * wi.x;
      sums.y[k] += r * wi.y;
      sums.z[k] += r * wi.z;
      sums.inverse_distance[k] += r * s->inverse_distance;
    }
  }
}

/// The M step: weights, means and widths of the lobes and shares of the guide from these sums and the priors.
void GuideDistribution::maximize(const Sums& sums, float width_prior) {
  float total = 0.0f;
  for (int k = 0; k < kCount; ++k) total += sums.weight[k] + kWeightPrior;
  for (int k = 0; k < kCount; ++k) {
    weight_[k] = (sums.weight[k] + kWeightPrior) / total;
    const Vec3 sum(sums.x[k], sums.y[k], sums.z[k]);
    const float length = glm::length(sum);
    if (length > 1e-6f) {
      lobes_.x[k] = sum.x / length;
      lobes_.y[k] = sum.y / length;
      lobes_.z[k] = sum.z / length;
      const float kappa = std::min(von_mises_fisher::kappa_of_mean_length(length / (sums.weight[k] + width_prior)),
                                   kSharpestKappa);
      lobes_.half_kappa[k] = 0.5f * kappa;
      inverse_distance_[k] = sums.inverse_distance[k] / sums.weight[k];
    }
    lobes_.peak[k] = weight_[k] * von_mises_fisher::peak_pdf_solid_angle(2.0f * lobes_.half_kappa[k]);
  }
  for (int c = 0; c < kGuideKinds; ++c) {
    const float bsdf = (sums.bsdf[c] + 0.5f * kSharePrior) / (sums.total[c] + kSharePrior);
    share_[c] = 1.0f - std::max(bsdf, kMinBsdfShare);
  }
}

void GuideDistribution::fit(std::span<const GuideSample* const> samples, const Fit& how) {
  double sum = 0.0;
  for (const GuideSample* const s : samples) sum += double(s->weight);
  if (!(sum > 0.0) || !std::isfinite(sum)) return;
  // The weights are limited, so that a single sample with a rare large weight does not determine the fit.
  const float n = float(samples.size()), unit = float(double(n) / sum),
              max_weight = std::max(1.0f, kMaxWeight * std::sqrt(n));
  Sums sums;
  for (int i = 0; i < how.iterations; ++i) {
    accumulate(samples, unit, max_weight, sums);
    for (size_t j = 0; j < sizeof(Sums) / sizeof(float); ++j)
      reinterpret_cast<float*>(&sums)[j] += how.past_share * reinterpret_cast<const float*>(&past_)[j];
    maximize(sums, how.width_prior);
  }
  past_ = sums;
}

Vec3 GuideDistribution::sample(const GuideLobes& aimed, float u_lobe, Vec2 u) const {
  int k = 0;
  while (k + 1 < kCount && u_lobe >= weight_[k]) u_lobe -= weight_[k++];
  return Frame(Vec3(aimed.x[k], aimed.y[k], aimed.z[k]))
      .to_world(von_mises_fisher::square_to_lobe(u, 2.0f * aimed.half_kappa[k]));
}

}  // namespace ajar
