// The part of photon_tracer.h that plans passes: their number of photons, their time, and the maps that a scene needs.
#include <algorithm>

#include "math/random.h"
#include "sampling/sampler.h"
#include "transport/direct/lobe_split.h"
#include "transport/photons/photon_tracer.h"

namespace ajar {

float time_of_pass(const Scene& scene, uint32_t seed, uint32_t pass) {
  if (!scene.moves()) return 0.0f;
  const double u = double(sobol::reverse_bits(pass) ^ hash_combine(seed, 0x74696d65U)) * 0x1p-32;
  return scene.camera().time_of(std::min(float(u), kOneMinusEpsilon));
}

uint32_t photons_of_a_pass(double pixels) { return uint32_t(std::clamp(pixels / 2, 20000.0, 500000.0)); }

uint32_t photons_of_a_pass(const RenderSettings& s) {
  return s.photons > 0 ? uint32_t(s.photons) : photons_of_a_pass(double(s.width) * s.height);
}

PhotonPlan plan_photons(const Scene& scene) {
  PhotonPlan plan;
  bool rough = false, smooth = false;
  for (const ShaderProgram& program : scene.programs()) {
    rough |= program.may_be_rough(kSharpRoughness);
    smooth |= program.may_be_smooth(kSharpRoughness);
    plan.rough_glossy |= program.may_be_rough_glossy(kSharpRoughness);
  }
  const BounceLimits& limits = scene.settings().bounces;
  if (scene.lights().empty()) {
    plan.global_reason = plan.caustic_reason = "nothing emits light";
  } else if (scene.instances().empty() || !rough) {
    plan.global_reason = plan.caustic_reason = "no surface is rough enough to hold photons";
  } else {
    plan.global = limits.total > 0 && (limits.diffuse > 0 || plan.rough_glossy);
    plan.global_reason = plan.global ? "light may arrive from rough surfaces"
                                     : "the bounce limits allow direct light only";
    plan.caustic = smooth && limits.total > 0;
    plan.caustic_reason = plan.caustic ? "a surface may be smooth enough to focus light"
                                       : "no surface is smooth enough to focus light";
  }
  return plan;
}

}  // namespace ajar
