// Values of diffuse lobes, also where the eye is below the normal.
//
// Since Blender 4.0, bump and normal maps do not bend the normal of diffuse lobes towards the eye (Lobe::ignores_eye), so that
// the eye can be below it. Only the light has to be above it then. For importance, the light is at wo.
#pragma once

#include "shading/bsdf/lobe.h"
#include "shading/models/diffuse.h"

namespace ajar {

/// Oren-Nayar.
inline Color rough_diffuse(const Lobe& lobe, float cos_o, float cos_i, float cos_between) {
  const OrenNayar model(lobe.roughness);
  return lobe.weight * (model.single(cos_o, cos_i, cos_between) + model.multiple(lobe.f0, cos_o, cos_i));
}

/// A layer of fibres. An eye below the normal sees it as from the horizon.
LobeValue microfiber(const Lobe& lobe, Vec3 wo, Vec3 wi, TransportMode mode);
/// The cone of a toon lobe whose axis is the normal.
LobeValue toon_diffuse(const Lobe& lobe, Vec3 wo, Vec3 wi, TransportMode mode);
/// A reflecting lobe with Lobe::ignores_eye, other than fibres.
LobeValue for_any_eye(const Lobe& lobe, Vec3 wo, Vec3 wi, TransportMode mode);

}  // namespace ajar
