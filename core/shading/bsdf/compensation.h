// Compensation of the energy that single scattering loses between the facets of a rough surface.
#pragma once

#include <algorithm>
#include <cmath>

#include "shading/bsdf/bsdf.h"
#include "shading/models/albedo_table.h"

namespace ajar {

/// The albedo of single scattering by white facets.
inline float single_albedo(const Lobe& lobe, float cosine, float alpha, float eta) {
  if (lobe.kind == LobeKind::MicrofacetGlass)
    return lobe.correlated ? albedo_table::ggx_glass_correlated(cosine, alpha, eta)
                           : albedo_table::ggx_glass(cosine, alpha, eta);
  return lobe.correlated ? albedo_table::ggx_correlated(cosine, alpha) : albedo_table::ggx(cosine, alpha);
}

/// Compensation of the light that is lost between facets, in the shape of single scattering (Turquin 2019), for the
/// eye's direction.
inline Color scaled_compensation(const Lobe& lobe, float cos_eye, float eta_eye) {
  const float alpha = std::sqrt(lobe.alpha_x * lobe.alpha_y);
  const float albedo = single_albedo(lobe, cos_eye, alpha, eta_eye);
  return 1.0f + lobe.multiple_scattering * ((1.0f - albedo) / albedo);
}

/// The same light, divided by roughness between that shape and a nearly diffuse, reciprocal one (Kulla and Conty 2017).
/// Light that bounces between smooth facets stays near the mirror direction; between rough facets it leaves in any
/// direction.
struct MixedCompensation {
  float scale;    ///< factor on single scattering, minus 1
  float diffuse;  ///< value of the diffuse part times the cosine
  /// Fraction of the samples that are drawn from the diffuse part, and the same for samples from wi.
  float diffuse_share, diffuse_share_back;
};
inline MixedCompensation mixed_compensation(const Lobe& lobe, float cos_o, float cos_i, float cos_eye) {
  const float alpha = std::sqrt(lobe.alpha_x * lobe.alpha_y), diffuse = std::sqrt(alpha);
  const float lost_o = 1.0f - albedo_table::ggx_correlated(cos_o, alpha),
              lost_i = 1.0f - albedo_table::ggx_correlated(cos_i, alpha);
  const float lost_mean = std::max(1.0f - albedo_table::ggx_correlated_mean(alpha), 1e-6f);
  const float lost_eye = cos_eye == cos_o ? lost_o : lost_i;
  return {(1.0f - diffuse) * lost_eye / (1.0f - lost_eye), diffuse * kInvPi * cos_i * lost_o * lost_i / lost_mean,
          diffuse * lost_o, diffuse * lost_i};
}

}  // namespace ajar
