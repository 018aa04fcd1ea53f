// The path tracer's directional kernel where a guide is known: a mixture of the BSDF and the guide, one density over
// directions.
//
//   pdf(wi) = (1 - c) p_bsdf(wi) + c (1 - q) p_guide(wi)
// q is the probability of a delta lobe, which the guide leaves alone; p_bsdf has the mass 1 - q. The share c is the
// cell's, less where lobes are too sharp to be helped, and times the trust that the path has in the guide:
//
// Whole paths are a mixture as well. With the probability e_0 a path would be drawn by the BSDF alone at all its
// vertices, and the probability that this is such a path, given the directions so far, follows by Bayes: e_k+1 = e_k
// p_bsdf / pdf. Drawing every direction with c (1 - e_k) is the same mixture without the choice at the start. So no
// path has less than e_0 times the density that plain path tracing gives it; shares at single vertices alone would
// bound it by their product only, and rare bright paths of many vertices would weigh that much more.
//
// Which kind of bounce a direction is counted as is drawn from the lobes' shares in p_bsdf, as the BSDF's own sampling
// does, so limits of bounces mean the same with and without.
#pragma once

#include <bit>
#include <optional>

#include "math/random.h"
#include "shading/bsdf/bsdf.h"
#include "transport/guiding/guide_tree.h"

namespace ajar {

class GuidedBsdf {
 public:
  /// Nothing is guided while `tree` is null or knows nothing here. `trust` is 1 - e_k.
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

  float pdf_solid_angle(float pdf_bsdf, Vec3 wi) const {
    return share_ > 0.0f
               ? (1.0f - share_) * pdf_bsdf + share_ * (1.0f - delta_probability_) * ajar::pdf_solid_angle(lobes_, wi)
               : pdf_bsdf;
  }

  /// `pdf_bsdf` becomes the BSDF's part of the density, for learning; 0 for delta lobes.
  std::optional<BsdfSample> sample(Vec3 wo, float u_guide, float u_lobe, Vec2 u, float& pdf_bsdf) const {
    std::optional<BsdfSample> sample;
    if (share_ > 0.0f && u_guide < share_ && !chooses_delta(u_lobe)) {
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
  /// Lobes below this roughness find their light themselves; shares below the other are not worth a look.
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
    // What is left of u once a lobe is chosen would do; a hash of it is as good and simpler.
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
