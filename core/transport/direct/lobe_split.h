// The lobes of a surface in two parts: rough lobes, on which photons are stored and light is gathered, and sharp lobes,
// which are followed ray by ray. Every scattering event belongs to exactly one part, f = f_rough + f_sharp. So the
// classes of paths of maps, gather and direct light (L S+ D, L (S|D)* D D, ...) neither overlap nor leave gaps, also on
// surfaces that have both parts. Transparency counts as sharp; its samples have the flag kTransparent.
#pragma once

#include "shading/bsdf/bsdf.h"

namespace ajar {

/// Minimum of Blender's roughness for a glossy lobe that is gathered and not followed.
constexpr float kSharpRoughness = 0.25f;

inline bool is_rough(const Lobe& lobe) {
  if (lobe.is_delta() || lobe.kind == LobeKind::Transparent) return false;
  return !is_microfacet(lobe.kind) || lobe.alpha_x * lobe.alpha_y >= sqr(sqr(kSharpRoughness));
}

/// Whether the radiance from these lobes is their weight over pi times the irradiance at bsdf.n.
inline bool is_plain_lambert(const Bsdf& bsdf) {
  return bsdf.lobe_count() == 1 && bsdf.lobe(0).kind == LobeKind::Diffuse && bsdf.lobe(0).roughness == 0.0f &&
         bsdf.lobe(0).frame.n == bsdf.n;
}

/// Whether all lobes are diffuse.
inline bool scatters_diffusely(const Bsdf& bsdf) {
  for (int i = 0; i < bsdf.lobe_count(); ++i)
    if (!is_diffuse(bsdf.lobe(i).kind)) return false;
  return true;
}

/// Whether there is a diffuse lobe on each side to which rough lobes scatter. Then light from one direction is scattered
/// to all directions with values that do not differ by powers of ten.
inline bool scatters_evenly(const Bsdf& bsdf) {
  bool scatters[2] = {false, false}, evenly[2] = {false, false};  // reflection, transmission
  for (int i = 0; i < bsdf.lobe_count(); ++i) {
    const Lobe& lobe = bsdf.lobe(i);
    if (!is_rough(lobe)) continue;
    scatters[0] |= reflects(lobe.kind);
    scatters[1] |= transmits(lobe.kind);
    evenly[0] |= lobe.kind == LobeKind::Diffuse || lobe.kind == LobeKind::PrincipledDiffuse;
    evenly[1] |= lobe.kind == LobeKind::Translucent;
  }
  return evenly[0] == scatters[0] && evenly[1] == scatters[1];
}

inline bool has_rough_lobe(const Bsdf& bsdf) {
  for (int i = 0; i < bsdf.lobe_count(); ++i)
    if (is_rough(bsdf.lobe(i))) return true;
  return false;
}

/// Transparency does not count here, although it is followed like sharp lobes.
inline bool has_sharp_lobe(const Bsdf& bsdf) {
  for (int i = 0; i < bsdf.lobe_count(); ++i)
    if (!is_rough(bsdf.lobe(i)) && bsdf.lobe(i).kind != LobeKind::Transparent) return true;
  return false;
}

/// Refers to `bsdf` if it has one part only. Copies lobes only if it has both.
class LobeSplit {
 public:
  /// `all_sharp`: of a place where no photons are stored, such as hair.
  LobeSplit(const Bsdf& bsdf, Vec3 wo, bool all_sharp = false) {
    int rough_count = 0;
    for (int i = 0; i < bsdf.lobe_count() && !all_sharp; ++i) rough_count += is_rough(bsdf.lobe(i)) ? 1 : 0;
    const bool all = !all_sharp && rough_count == bsdf.lobe_count(), none = rough_count == 0;
    if (bsdf.empty()) return;
    if (all || none) {
      (all ? rough_ : sharp_) = &bsdf;
      return;
    }
    rough_storage_.assign_lobes(bsdf, [](const Lobe& lobe) { return is_rough(lobe); });
    sharp_storage_.assign_lobes(bsdf, [](const Lobe& lobe) { return !is_rough(lobe); });
    rough_storage_.prepare(wo);
    sharp_storage_.prepare(wo);
    rough_ = &rough_storage_;
    sharp_ = &sharp_storage_;
  }
  LobeSplit(const LobeSplit&) = delete;

  const Bsdf* rough() const { return rough_; }  ///< null if there are none
  const Bsdf* sharp() const { return sharp_; }

 private:
  const Bsdf* rough_ = nullptr;
  const Bsdf* sharp_ = nullptr;
  Bsdf rough_storage_, sharp_storage_;
};

}  // namespace ajar
