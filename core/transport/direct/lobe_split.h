// A surface's lobes in two parts: rough ones, on which photons are stored and light is gathered, and sharp ones, which
// are followed ray by ray. Every scattering event is of exactly one part, f = f_rough + f_sharp, so the classes of
// paths that maps, gather and direct light answer for (L S+ D, L (S|D)* D D, ...) neither overlap nor leave gaps, also
// on surfaces that have both parts. Straight-through transparency counts as sharp; its samples say kTransparent.
#pragma once

#include "shading/bsdf/bsdf.h"

namespace ajar {

/// Blender's roughness at which a glossy lobe is gathered rather than followed.
constexpr float kSharpRoughness = 0.25f;

inline bool is_rough(const Lobe& lobe) {
  if (lobe.is_delta() || lobe.kind == LobeKind::Transparent) return false;
  const bool microfacet = lobe.kind == LobeKind::MicrofacetReflection || lobe.kind == LobeKind::MicrofacetRefraction ||
                          lobe.kind == LobeKind::MicrofacetGlass;
  return !microfacet || lobe.alpha_x * lobe.alpha_y >= sqr(sqr(kSharpRoughness));
}

/// Radiance by way of these lobes is their weight over pi times the irradiance at bsdf.n.
inline bool is_plain_lambert(const Bsdf& bsdf) {
  return bsdf.lobe_count() == 1 && bsdf.lobe(0).kind == LobeKind::Diffuse && bsdf.lobe(0).roughness == 0.0f &&
         bsdf.lobe(0).frame.n == bsdf.n;
}

inline bool has_rough_lobe(const Bsdf& bsdf) {
  for (int i = 0; i < bsdf.lobe_count(); ++i)
    if (is_rough(bsdf.lobe(i))) return true;
  return false;
}

/// Transparency, which is followed as sharp lobes are, does not count.
inline bool has_sharp_lobe(const Bsdf& bsdf) {
  for (int i = 0; i < bsdf.lobe_count(); ++i)
    if (!is_rough(bsdf.lobe(i)) && bsdf.lobe(i).kind != LobeKind::Transparent) return true;
  return false;
}

/// Refers to `bsdf` where it has one part only; copies lobes only where it has both.
class LobeSplit {
 public:
  LobeSplit(const Bsdf& bsdf, Vec3 wo) {
    int rough_count = 0;
    for (int i = 0; i < bsdf.lobe_count(); ++i) rough_count += is_rough(bsdf.lobe(i)) ? 1 : 0;
    const bool all = rough_count == bsdf.lobe_count(), none = rough_count == 0;
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

  const Bsdf* rough() const { return rough_; }  ///< null when there is none
  const Bsdf* sharp() const { return sharp_; }

 private:
  const Bsdf* rough_ = nullptr;
  const Bsdf* sharp_ = nullptr;
  Bsdf rough_storage_, sharp_storage_;
};

}  // namespace ajar
