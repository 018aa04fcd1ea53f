// The directions in which photons leave a surface whose shading normal differs from its geometric normal.
//
// The eye sees diffuse lobes from everywhere above the surface, also from below the plane of the shading normal. Lobes
// draw no directions there, so photons would bring no light to what is seen from there (4 % of the indirect light in a
// lathed lamp shade of 48 segments). Here photons are drawn by the cosine at the geometric normal instead, which is the
// density of the light that diffuse lobes scatter. Where there are other rough lobes too, half of the photons are drawn
// by the lobes, and all have the density of both.
#pragma once

#include <optional>

#include "math/frame.h"
#include "math/warps.h"
#include "shading/bsdf/shading_point.h"
#include "transport/paths/walk.h"
#include "transport/photons/photon_map.h"

namespace ajar {

class FlatDirections {
 public:
  /// `rough`: these are the rough lobes of the surface; others draw no such directions.
  FlatDirections(const ShadingPoint& point, const Bsdf& lobes, bool rough) : ng_(point.ng) {
    if (!rough || glm::dot(lobes.n, ng_) > kEqual) return;
    float weights[2] = {0.0f, 0.0f};
    bool all = true;
    for (int i = 0; i < lobes.lobe_count(); ++i) {
      const Lobe& lobe = lobes.lobe(i);
      if (is_diffuse(lobe.kind))
        weights[transmits(lobe.kind)] += luminance(glm::abs(lobe.weight));
      else
        all = false;
    }
    const float sum = weights[0] + weights[1];
    if (!(sum > 0.0f)) return;
    share_ = all ? 1.0f : 0.5f;
    behind_ = weights[1] / sum;
  }
  /// The probability of such a direction.
  float share() const { return share_; }
  Vec3 direction(float u_side, Vec2 u) const {
    return Frame(u_side < behind_ ? -ng_ : ng_).to_world(warp::square_to_cosine_hemisphere(u));
  }
  /// The density of both kinds of directions per solid angle, from that of the lobes.
  float mixed(float pdf_of_lobes, Vec3 direction) const {
    if (!(share_ > 0.0f)) return pdf_of_lobes;
    const float cosine = glm::dot(direction, ng_);
    const float pdf = warp::cosine_hemisphere_pdf_solid_angle(std::abs(cosine)) *
                      (cosine < 0.0f ? behind_ : 1.0f - behind_);
    return glm::mix(pdf_of_lobes, pdf, share_);
  }

 private:
  /// Cosine of 2 degrees, up to which less than 0.04 % of the light is lost.
  static constexpr float kEqual = 0.9994f;

  Vec3 ng_;
  float share_ = 0.0f, behind_ = 0.0f;
};

/// The value f |cos| for light that arrives from point.wo and leaves in the direction `to_eye`, by lobes that were made
/// for that direction or do not depend on it. It contains the cosines of the transport of light [Veach 1997, section 5.3].
inline Color light_towards_eye(const ShadingPoint& point, const Bsdf& lobes, Vec3 to_eye) {
  const float cos_light = std::abs(glm::dot(point.wo, point.ng)), cos_eye = std::abs(glm::dot(to_eye, point.ng));
  return cos_light > 0.0f ? lobes.evaluate(to_eye, point.wo).f_cos * (cos_eye / cos_light) : Color(0.0f);
}

/// The sample that the lobes would return if they had drawn `wi`.
inline std::optional<BsdfSample> sample_of(const Bsdf& lobes, Vec3 wo, Vec3 wi) {
  const Bsdf::Evaluation evaluated = lobes.evaluate(wo, wi, TransportMode::Importance);
  return BsdfSample{wi, evaluated.f_cos, evaluated.pdf_solid_angle, likely_flags(lobes, wo, wi), false};
}

}  // namespace ajar
