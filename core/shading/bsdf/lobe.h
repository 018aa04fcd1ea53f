// One lobe by itself: value, density, sampling, albedo. bsdf.cpp sums them; nothing else should need this.
// Directions are in world space with wo on the side of the lobe's normal; `eta` is the index to use (the lobe's own, or
// its inverse when the surface is seen from the other side).
#pragma once

#include "shading/bsdf/bsdf.h"

namespace ajar {

struct LobeValue {
  Color f_cos{0.0f};
  float pdf_solid_angle = 0.0f;
};

struct LobeSample {
  Vec3 wi;
  Color weight;       ///< delta lobes only
  float probability;  ///< delta lobes only: of the branch taken inside the lobe
  uint32_t flags;
  float eta = 1.0f, roughness = 1.0f;
};

/// Non-delta lobes. `reflection`: wi is on wo's side of the geometric normal. The layers above are not included.
LobeValue evaluate_lobe(const Lobe& lobe, Vec3 wo, Vec3 wi, bool reflection, TransportMode mode, bool flipped);
/// Any lobe; false when no direction results. u_branch chooses inside glass.
bool sample_lobe(const Lobe& lobe, Vec3 wo, float u_branch, Vec2 u, TransportMode mode, bool flipped,
                 LobeSample& sample);
/// Fraction scattered, weight included, seen under this cosine, as far as weight and Fresnel tell: enough to
/// choose a lobe by.
Color lobe_scattered(const Lobe& lobe, float cos_wo, bool flipped = false);
/// The same less what is lost between facets: an estimate of the albedo.
Color lobe_albedo(const Lobe& lobe, float cos_wo, bool flipped = false);
/// Factor on a diffuse lobe that is bumped away from the surface's normal n; `light` is the direction to the light's
/// side.
float bump_shadowing(BumpTerminator terminator, Vec3 n, Vec3 bumped, Vec3 light);

}  // namespace ajar
