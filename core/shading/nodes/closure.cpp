#include "shading/nodes/closure.h"

#include <cstddef>
#include <cstring>

namespace ajar {

std::string_view name_of(ClosureKind kind) {
  static constexpr std::string_view kNames[] = {
      "Diffuse",           "Glossy",     "Glass",    "Refraction",      "Translucent",
      "Principled",        "Velvet",     "Toon",     "Glossy Toon",     "Subsurface",
      "Transparent",       "Metallic",   "Sheen",    "Principled Hair", "Hair Reflection",
      "Hair Transmission", "Ray Portal", "Emission", "Coated Emission", "Holdout"};
  return kNames[size_t(kind)];
}

namespace {

/// The valid range of one input, or of each channel of a colour.
struct InputLimits {
  size_t offset;
  float low, high;
  size_t count = 1;
};

#define AJAR_INPUT(name) offsetof(closures::PrincipledInputs, name)
constexpr InputLimits kInputLimits[] = {{AJAR_INPUT(metallic), 0.0f, 1.0f},
                                        {AJAR_INPUT(roughness), 0.0f, 1.0f},
                                        {AJAR_INPUT(transmission), 0.0f, 1.0f},
                                        {AJAR_INPUT(transmission_roughness), 0.0f, 1.0f},
                                        {AJAR_INPUT(sheen_roughness), 0.0f, 1.0f},
                                        {AJAR_INPUT(clearcoat_roughness), 0.0f, 1.0f},
                                        {AJAR_INPUT(diffuse_roughness), 0.0f, 1.0f},
                                        {AJAR_INPUT(subsurface), 0.0f, 1.0f},
                                        {AJAR_INPUT(subsurface_anisotropy), -1.0f, 1.0f},
                                        {AJAR_INPUT(specular), 0.0f, 12.0f},
                                        {AJAR_INPUT(specular_ior_level), 0.0f, 12.0f},
                                        {AJAR_INPUT(sheen), 0.0f, 12.0f},
                                        {AJAR_INPUT(clearcoat), 0.0f, 12.0f},
                                        {AJAR_INPUT(specular_tint), 0.0f, 1.0f},
                                        {AJAR_INPUT(sheen_tint), 0.0f, 1.0f},
                                        {AJAR_INPUT(anisotropic), -1.0f, 1.0f},
                                        {AJAR_INPUT(anisotropic_rotation), -1e4f, 1e4f},
                                        {AJAR_INPUT(ior), 1e-5f, 1e4f},
                                        {AJAR_INPUT(coat_ior), 1.0f, 1e4f},
                                        {AJAR_INPUT(subsurface_ior), 1.01f, 3.8f},
                                        {AJAR_INPUT(subsurface_scale), 0.0f, 1e12f},
                                        {AJAR_INPUT(film.thickness), 0.0f, 1e6f},
                                        {AJAR_INPUT(film.ior), 1e-5f, 1e4f},
                                        {AJAR_INPUT(base_color), 0.0f, 1e12f, 3},
                                        {AJAR_INPUT(specular_tint_color), 0.0f, 1e12f, 3},
                                        {AJAR_INPUT(sheen_tint_color), 0.0f, 1e12f, 3},
                                        {AJAR_INPUT(coat_tint), 0.0f, 1e12f, 3},
                                        {AJAR_INPUT(subsurface_color), 0.0f, 1e12f, 3},
                                        {AJAR_INPUT(subsurface_radius), 0.0f, 1e12f, 3}};
#undef AJAR_INPUT

}  // namespace

void make_valid(closures::PrincipledInputs& inputs) {
  for (const InputLimits& limits : kInputLimits)
    for (size_t i = 0; i < limits.count; ++i) {
      float x;
      char* const at = reinterpret_cast<char*>(&inputs) + limits.offset + i * sizeof(float);
      std::memcpy(&x, at, sizeof(float));
      x = valid_input(x, limits.low, limits.high);
      std::memcpy(at, &x, sizeof(float));
    }
}

InputPatch::InputPatch(size_t offset, uint8_t count, Operand from)
    : offset(uint16_t(offset)), count(count), from(from) {
  for (const InputLimits& limits : kInputLimits)
    if (limits.offset == offset) low = limits.low, high = limits.high;
}

}  // namespace ajar
