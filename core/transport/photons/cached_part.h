// The lobes of a surface whose indirect light the irradiance cache interpolates.
#pragma once

#include "math/warps.h"
#include "shading/bsdf/bsdf.h"

namespace ajar {

/// The lobes whose indirect light is cached: diffuse reflection about the surface's normal.
class CachedPart {
 public:
  CachedPart(const Bsdf& bsdf, Vec3 wo) {
    const auto cached = [&](const Lobe& lobe) {
      return (lobe.kind == LobeKind::Diffuse || lobe.kind == LobeKind::PrincipledDiffuse ||
              lobe.kind == LobeKind::PrincipledRetro) &&
             lobe.frame.n == bsdf.n;
    };
    int count = 0;
    for (int i = 0; i < bsdf.lobe_count(); ++i) count += cached(bsdf.lobe(i)) ? 1 : 0;
    if (count == 0) return;
    all_ = count == bsdf.lobe_count();
    bsdf_ = &bsdf;
    if (all_) return;
    storage_.assign_lobes(bsdf, cached);
    storage_.prepare(wo);
    bsdf_ = &storage_;
  }
  CachedPart(const CachedPart&) = delete;

  explicit operator bool() const { return bsdf_; }
  /// The part of the surface's scattering that comes from other lobes.
  Color others(Vec3 wo, const BsdfSample& sample) const {
    if (sample.specular) return sample.f_cos;
    return all_ ? Color(0.0f) : glm::max(sample.f_cos - bsdf_->evaluate(wo, sample.wi).f_cos, Color(0.0f));
  }
  /// Factor of irradiance over pi. For lobes that are not exactly Lambertian, it is estimated along a direction drawn
  /// by the cosine.
  Color albedo(Vec3 wo, Vec2 u) const {
    const Vec3 wi = Frame(bsdf_->n).to_world(warp::square_to_cosine_hemisphere(u));
    const Bsdf::Evaluation scattered = bsdf_->evaluate(wo, wi);
    return scattered.pdf_solid_angle > 0.0f ? scattered.f_cos / scattered.pdf_solid_angle : bsdf_->albedo();
  }

 private:
  const Bsdf* bsdf_ = nullptr;
  bool all_ = false;
  Bsdf storage_;
};

}  // namespace ajar
