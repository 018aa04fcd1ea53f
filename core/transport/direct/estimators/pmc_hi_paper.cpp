#include "transport/direct/estimators/pmc_hi_paper.h"

#include <cmath>

#include "math/warps.h"

namespace ajar {

namespace {

using M = LightMixture;

constexpr float kFloor = 0.04f;     ///< minimum share of components that alone may cover part of the integrand
constexpr float kConeShare = 0.2f;  ///< [Fan 2006, section 5.4.2]

}  // namespace

PmcHiPaper::PmcHiPaper(const Scene& scene, const DirectRequest& request)
    : DirectEstimator(scene, with_enough_samples(request), groups_to_choose(scene)),
      lobes_apart_(request.lobes_apart) {}

Color PmcHiPaper::many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux,
                               uint64_t& rays) const {
  vertex.complete = true;
  const LobeComponents lobes(c.bsdf, c.point.wo, lobes_apart_);
  const LightGroups& groups = mixture_.groups();
  M::Kernel k = mixture_.kernel(lobes, 0.5f, groups.size() > 0 ? M::Lights::GroupsAlike : M::Lights::Any);
  // If the lights have no groups, any light is a component.
  const auto used = [&](int i) {
    return i < lobes.count() || (groups.size() > 0 ? i >= M::kFirstGroup : i == M::kAny);
  };
  // Step 1: equal shares without the cone.
  const int m = lobes.count() + std::max(1, groups.size());
  for (int i = 0; i < k.count; ++i) k.alpha[size_t(i)] = used(i) ? 1.0f / float(m) : 0.0f;
  const int iterations = std::clamp(samples_ / (2 * m), 2, 4);
  Color sum(0.0f);
  int done = 0;
  struct Past {
    Vec3 wi;
    float w;
  };
  std::vector<Past> past;
  past.reserve(size_t(samples_));
  std::array<double, M::kMaxComponents> sums{};
  for (int t = 0; t < iterations; ++t) {
    // Step 2: samples with the weights w = f / K [Fan 2006, eq. 5.7].
    const int n = (samples_ * (t + 1)) / iterations - done;
    mixture_.for_each_draw({c, k, rays}, n, t, sampler, [&](int, const M::Draw& draw) {
      sum += draw.y;
      const float w = luminance_of(draw.y);
      if (w > 0.0f && draw.wi != Vec3(0.0f)) past.push_back({draw.wi, w});
      for (int i = 0; i < k.count; ++i) sums[size_t(i)] += double(draw.responsible[size_t(i)]);
    });
    done += n;
    if (t + 1 == iterations) break;

    // Step 3, the cone: the weighted mean direction, and the weighted angular deviation from it.
    Vec3 axis(0.0f);
    float total = 0.0f, spread = 0.0f;
    for (const Past& p : past) axis += p.w * p.wi, total += p.w;
    const float length = glm::length(axis);
    const bool cone = past.size() >= 2 && length > 1e-6f * total;
    if (cone) {
      axis /= length;
      for (const Past& p : past) spread += p.w * sqr(std::acos(glm::clamp(glm::dot(axis, p.wi), -1.0f, 1.0f)));
      k.cone = Frame(axis);
      k.one_minus_cos = warp::one_minus_cos(glm::clamp(std::sqrt(spread / total), 0.02f, 0.5f * kPi));
    }
    // Step 4, the shares [Fan 2006, eq. 5.8]: those of the other components by their weights, shrunk towards equal
    // shares. The cone starts with 1/5.
    double others = 0.0;
    for (int i = 0; i < k.count; ++i) others += i == M::kCone ? 0.0 : sums[size_t(i)];
    const float kept = others > 0.0 ? float(done) / (float(done) + float(m)) : 0.0f;
    const double with_cone = sums[M::kCone] + others;
    float cone_share = !cone
                           ? 0.0f
                           : (sums[M::kCone] > 0.0 ? std::max(kFloor, float(sums[M::kCone] / with_cone)) : kConeShare);
    cone_share = std::min(cone_share, 0.5f);
    float sum_alpha = 0.0f;
    for (int i = 0; i < k.count; ++i) {
      float& alpha = k.alpha[size_t(i)];
      alpha = used(i)
                  ? kFloor + (others > 0.0 ? kept * float(sums[size_t(i)] / others) : 0.0f) + (1.0f - kept) / float(m)
                  : 0.0f;
      sum_alpha += alpha;
    }
    for (int i = 0; i < k.count; ++i) k.alpha[size_t(i)] *= (1.0f - cone_share) / sum_alpha;
    k.alpha[M::kCone] = cone_share;
  }
  mixture_.record_shares(k, aux);
  // The population Monte Carlo estimator [Fan 2006, eq. 2.32].
  return sum / float(samples_);
}

}  // namespace ajar
