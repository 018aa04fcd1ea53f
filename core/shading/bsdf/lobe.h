// A single lobe: value, density, sampling, albedo. bsdf.cpp sums the lobes; no other code should need this file.
// Directions are in world space, with wo on the side of the lobe's normal. `eta` is the index to use: the lobe's own,
// or its inverse if the surface is seen from the other side.
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
  float probability;  ///< delta lobes only: probability of the branch that was chosen inside the lobe
  uint32_t flags;
  float eta = 1.0f, roughness = 1.0f;
};

/// Value and density of a non-delta lobe, without the layers above it. `reflection`: wi is on wo's side of the
/// geometric normal.
LobeValue evaluate_lobe(const Lobe& lobe, Vec3 wo, Vec3 wi, bool reflection, TransportMode mode, bool flipped);
/// Whether evaluate_reflection is for this lobe.
bool shares_evaluation(const Lobe& lobe);
/// evaluate_lobe for reflection and radiance, and the density of evaluate_lobe from wi to wo.
LobeValue evaluate_reflection(const Lobe& lobe, Vec3 wo, Vec3 wi, bool flipped, float& pdf_back);
/// Samples any lobe. Returns false if there is no direction for these random numbers. `u_branch` chooses between the
/// branches of a glass lobe.
bool sample_lobe(const Lobe& lobe, Vec3 wo, float u_branch, Vec2 u, TransportMode mode, bool flipped,
                 LobeSample& sample);
/// The fraction of light that is scattered for this cosine, from the lobe's weight and its Fresnel reflectance. It is
/// accurate enough to choose a lobe.
Color lobe_scattered(const Lobe& lobe, float cos_wo, bool flipped = false);
/// The same without the light that is lost between facets: an estimate of the albedo.
Color lobe_albedo(const Lobe& lobe, float cos_wo, bool flipped = false);

}  // namespace ajar
