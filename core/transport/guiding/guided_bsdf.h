// The directional sampling of the path tracer with a guide: a mixture of BSDF and guide, with one density over
// directions:
//
//   pdf(wi) = (1 - c) p_bsdf(wi) + c (1 - q) p_guide(wi)
//
// q is the probability of a delta lobe, which the guide does not change; the integral of p_bsdf is 1 - q. The share c
// is that of the cell, reduced where lobes are too sharp for the guide, and multiplied by the trust 1 - e_k of the
// path.
//
// Whole paths are a mixture as well. With the probability e_0, all vertices of a path are sampled by the BSDF alone.
// The probability that the present path is such a path, given its directions so far, follows from Bayes' rule: e_k+1 =
// e_k p_bsdf / pdf. Sampling every direction with the share c (1 - e_k) gives the same mixture without a choice at the
// start. So the density of every path is at least e_0 times its density in plain path tracing. Shares at single
// vertices would bound it only by their product, and rare bright paths with many vertices would have accordingly larger
// weights.
//
// The type of bounce of a direction is sampled from the shares of the lobes in p_bsdf, as in the BSDF's own sampling.
// So limits of bounces have the same meaning with and without the guide.
#pragma once

#include <bit>
#include <optional>

#include "math/random.h"
#include "shading/bsdf/bsdf.h"
#include "transport/guiding/guide_tree.h"

namespace ajar {

/// Probability e_0 of paths without a guide. It bounds the density of all paths from below.
constexpr float kPlainShareOfPaths = 0.25f;

class GuidedBsdf {
 public:
  /// Prepares the mixture. There is no guide if `tree` is null or knows nothing here. `trust` is 1 - e_k.
  void start(const GuideTree* tree, const Bsdf& bsdf, Vec3 position, float trust) {
    bsdf_ = &bsdf;
    share_ = 0.0f;
    look(bsdf);
    if (!tree) return;
    const GuideDistribution* const found = tree->find(position, bsdf.n);
    if (!found || !(found->share(kind_) > 0.0f)) return;
    share_ = trust * found->share(kind_) * (1.0f - sharp_probability_ / std::max(1.0f - delta_probability_, 1e-6f));
    if (!(share_ > kMinShare)) {
      share_ = 0.0f;
      return;
    }
    found->aim(position, lobes_);
    distribution_ = found;
  }

  GuideKind kind() const { return kind_; }
  float delta_probability() const { return delta_probability_; }
  bool guided() const { return share_ > 0.0f; }
  float share() const { return share_; }
  /// Whether `sample` draws from the guide with these numbers.
  bool draws_from_guide(float u_guide, float u_lobe) const {
    return share_ > 0.0f && u_guide < share_ && !chooses_delta(u_lobe);
  }

  /// The density of the mixture: a defensive mixture [Fan 2006, eq. 2.15 and 2.16].
  float pdf_solid_angle(float pdf_bsdf, Vec3 wi) const {
    return share_ > 0.0f
               ? (1.0f - share_) * pdf_bsdf + share_ * (1.0f - delta_probability_) * ajar::pdf_solid_angle(lobes_, wi)
               : pdf_bsdf;
  }

  /// Samples a direction. `pdf_bsdf` is set to the density of the BSDF alone, for training; 0 for delta lobes.
  std::optional<BsdfSample> sample(Vec3 wo, float u_guide, float u_lobe, Vec2 u, float& pdf_bsdf) const {
    std::optional<BsdfSample> sample;
    if (draws_from_guide(u_guide, u_lobe)) {
      const Vec3 wi = distribution_->sample(lobes_, u_guide / share_, u);
      const Bsdf::Evaluation scattered = bsdf_->evaluate(wo, wi);
      if (!(scattered.pdf_solid_angle > 0.0f)) return std::nullopt;
      pdf_bsdf = scattered.pdf_solid_angle;
      return BsdfSample{wi, scattered.f_cos, pdf_solid_angle(pdf_bsdf, wi), flags(wo, wi, u_lobe), false};
    }
    sample = bsdf_->sample(wo, u_lobe, u);
    pdf_bsdf = 0.0f;
    if (sample && !sample->specular) {
      pdf_bsdf = sample->pdf_solid_angle;
      sample->pdf_solid_angle = pdf_solid_angle(pdf_bsdf, sample->wi);
    }
    return sample;
  }

 private:
  /// Lobes with a smaller alpha sample their light well by themselves. Guides with a smaller share are not used.
  static constexpr float kSharpAlpha = 0.04f, kMinShare = 0.02f;

  void look(const Bsdf& bsdf) {
    delta_probability_ = sharp_probability_ = 0.0f;
    kind_ = GuideKind::Diffuse;
    all_diffuse_ = true;
    for (int i = 0; i < bsdf.lobe_count(); ++i) {
      const Lobe& lobe = bsdf.lobe(i);
      if (lobe.delta) {
        delta_probability_ += lobe.selection;
        continue;
      }
      const bool diffuse = lobe.kind == LobeKind::Diffuse || lobe.kind == LobeKind::PrincipledDiffuse ||
                           lobe.kind == LobeKind::Sheen || lobe.kind == LobeKind::MicrofiberSheen;
      if (diffuse) continue;
      all_diffuse_ = false;
      if (lobe.kind != LobeKind::Translucent && std::max(lobe.alpha_x, lobe.alpha_y) < kSharpAlpha) {
        sharp_probability_ += lobe.selection;
        continue;
      }
      if (lobe.kind == LobeKind::Translucent || lobe.selection < 0.1f) continue;
      kind_ = std::max(kind_, std::max(lobe.alpha_x, lobe.alpha_y) > 0.2f ? GuideKind::Rough : GuideKind::Glossy);
    }
    delta_probability_ = std::min(delta_probability_, 1.0f);
  }
  bool chooses_delta(float u_lobe) const {
    if (!(delta_probability_ > 0.0f)) return false;
    int i = 0;
    for (; i + 1 < bsdf_->lobe_count() && u_lobe >= bsdf_->lobe(i).selection; ++i) u_lobe -= bsdf_->lobe(i).selection;
    return bsdf_->lobe(i).delta;
  }
  uint32_t flags(Vec3 wo, Vec3 wi, float u) const {
    const uint32_t side = glm::dot(bsdf_->ng, wo) * glm::dot(bsdf_->ng, wi) > 0.0f ? kReflection : kTransmission;
    if (all_diffuse_) return side | kDiffuse;
    const Bsdf::KindShares shares = bsdf_->kind_shares(wo, wi, false);
    // The rest of u after the choice of the lobe would be valid. A hash of u is equally good and simpler.
    const float v = to_unit_float(hash32(std::bit_cast<uint32_t>(u)));
    return side | (v < shares.diffuse + shares.diffuse_transmission ? kDiffuse : kGlossy);
  }

  const Bsdf* bsdf_ = nullptr;
  const GuideDistribution* distribution_ = nullptr;
  float share_ = 0.0f, delta_probability_ = 0.0f, sharp_probability_ = 0.0f;
  GuideKind kind_ = GuideKind::Diffuse;
  bool all_diffuse_ = true;
  GuideLobes lobes_;
};

}  // namespace ajar
