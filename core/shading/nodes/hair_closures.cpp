#include "shading/nodes/hair_closures.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "math/random.h"
#include "shading/bsdf/hair.h"
#include "shading/bsdf/huang.h"
#include "shading/nodes/closure_writer.h"

namespace ajar::nodes {
namespace {

using Inputs = closures::PrincipledInputs;

/// The input `Color Parametrization`, in the order of its names below. It is stored in PrincipledInputs::version.
enum class Coloring : int { Absorption, Melanin, Color };

/// The attribute with the normals of hair curves, which the exporter sends if a material asks for it.
constexpr const char* kCurveNormal = ".curve_normal";

// The other inputs of hair have places in PrincipledInputs whose limits suit them.
#define AJAR_HAIR_INPUT(name, place)                  \
  constexpr size_t k##name = offsetof(Inputs, place); \
  [[maybe_unused]] auto& get_##name(const Inputs& inputs) { return inputs.place; }
AJAR_HAIR_INPUT(Color, base_color)
AJAR_HAIR_INPUT(Tint, coat_tint)
AJAR_HAIR_INPUT(Absorption, subsurface_radius)
AJAR_HAIR_INPUT(Roughness, roughness)
AJAR_HAIR_INPUT(RadialRoughness, clearcoat_roughness)
AJAR_HAIR_INPUT(Coat, metallic)
AJAR_HAIR_INPUT(Ior, ior)
AJAR_HAIR_INPUT(Offset, anisotropic_rotation)
AJAR_HAIR_INPUT(Melanin, subsurface)
AJAR_HAIR_INPUT(Redness, specular_tint)
AJAR_HAIR_INPUT(RandomColor, sheen_tint)
AJAR_HAIR_INPUT(RandomRoughness, sheen_roughness)
AJAR_HAIR_INPUT(Random, transmission)
AJAR_HAIR_INPUT(TurnsLight, is_conductor)
AJAR_HAIR_INPUT(IsHuang, correlated)
AJAR_HAIR_INPUT(Aspect, film.ior)
AJAR_HAIR_INPUT(Reflected, sheen)
AJAR_HAIR_INPUT(Transmitted, clearcoat)
AJAR_HAIR_INPUT(ReflectedInside, specular)
#undef AJAR_HAIR_INPUT

/// A factor for a random number of 0 to 1: 1 - amount to 1 + amount.
float randomized(float random, float amount) { return 1.0f + 2.0f * (random - 0.5f) * amount; }

Color absorption(const Inputs& inputs, float radial_roughness) {
  switch (Coloring(inputs.version)) {
    case Coloring::Absorption: return get_Absorption(inputs);
    case Coloring::Color: return hair::absorption_of_color(get_Color(inputs), radial_roughness);
    case Coloring::Melanin: break;
  }
  const float amount = get_Melanin(inputs) * randomized(get_Random(inputs), get_RandomColor(inputs));
  const float concentration = -std::log(std::max(1.0f - amount, 1e-4f)), redness = get_Redness(inputs);
  return hair::absorption_of_melanin(concentration * (1.0f - redness), concentration * redness) +
         hair::absorption_of_color(get_Tint(inputs), radial_roughness);
}

/// The inputs of the model of Huang. Where its cross-section is not round, a strand is transparent beside the ellipse.
void huang(ClosureWriter& w, ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  w.closure.inputs.correlated = true;
  w.number(kReflected, "R lobe", 1.0f);
  w.number(kTransmitted, "TT lobe", 1.0f);
  w.number(kReflectedInside, "TRT lobe", 1.0f);
  const Value aspect = w.number(kAspect, "Aspect Ratio", 0.85f);
  if (aspect.is_constant() && b.constant_value(aspect) == 1.0f) return;
  const Value normal = b.emit(Op::NamedAttribute, SocketType::Color, {}, 1, b.add_name(kCurveNormal));
  w.closure.tangent = normal.at;
  const Value missed = b.emit(Op::HairInfo, SocketType::Float, {{SocketType::Vector, normal.at}, aspect},
                              int(HairOutput::Misses));
  ClosureWriter beside(b, node, ClosureKind::Transparent, b.emit(Op::Product, SocketType::Float, {weight, missed}));
  beside.set(kColor, b.constant(Vec3(1.0f), SocketType::Color), 3);
  out.push_back(std::move(beside.closure));
}

uint32_t hash_of(Vec3 p) {
  return hash_combine(hash_combine(std::bit_cast<uint32_t>(p.x), std::bit_cast<uint32_t>(p.y)),
                      std::bit_cast<uint32_t>(p.z));
}

}  // namespace

void hair(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  const bool transmission = b.choice(node, "component", {"Reflection", "Transmission"}) == 1;
  ClosureWriter w(b, node, transmission ? ClosureKind::HairTransmission : ClosureKind::HairReflection, weight);
  w.color(kColor, "Color", ::ajar::Color(0.8f));
  w.number(kRoughness, "RoughnessU", 0.1f);
  w.number(kRadialRoughness, "RoughnessV", 1.0f);
  w.number(kOffset, "Offset", 0.0f);
  w.normal("Tangent", w.closure.tangent);
  out.push_back(std::move(w.closure));
}

void principled_hair(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  ClosureWriter w(b, node, ClosureKind::PrincipledHair, weight);
  const int coloring = b.choice(node, "parametrization", {"ABSORPTION", "MELANIN", "COLOR"}, int(Coloring::Color));
  const bool is_huang = b.choice(node, "model", {"CHIANG", "HUANG"}) == 1;
  w.closure.inputs.version = coloring;
  w.color(kColor, "Color", ::ajar::Color(0.0175f, 0.00576f, 0.00206f));
  w.number(kMelanin, "Melanin", 0.8f);
  w.number(kRedness, "Melanin Redness", 1.0f);
  w.color(kTint, "Tint", ::ajar::Color(1.0f));
  w.set(kAbsorption, b.input(node, "Absorption Coefficient", SocketType::Vector, Vec4(0.2455f, 0.52f, 1.365f, 0.0f)),
        3);
  const Value roughness = w.number(kRoughness, "Roughness", 0.3f);
  if (is_huang) {
    w.set(kRadialRoughness, roughness, 1);
    huang(w, b, node, weight, out);
  } else {
    w.number(kRadialRoughness, "Radial Roughness", 0.3f);
    w.number(kCoat, "Coat", 0.0f);
  }
  w.number(kIor, "IOR", 1.55f);
  w.number(kOffset, "Offset", 0.0349f);
  w.closure.inputs.is_conductor = b.choice(node, "tilt", {"EYE", "LIGHT"}) == 1;
  const Value random_color = w.number(kRandomColor, "Random Color", 0.0f);
  const Value random_roughness = w.number(kRandomRoughness, "Random Roughness", 0.0f);
  if (b.is_linked(node, "Random"))
    w.number(kRandom, "Random", 0.0f);
  else if (may_be_positive(b, random_roughness) ||
           (coloring == int(Coloring::Melanin) && may_be_positive(b, random_color)))
    w.set(kRandom, b.emit(Op::HairInfo, SocketType::Float, {}, int(HairOutput::Random)), 1);
  out.push_back(std::move(w.closure));
}

void add_hair(Bsdf& bsdf, const ShadingPoint& point, bool transmission, Color weight,
              const closures::PrincipledInputs& inputs, bool has_tangent) {
  const bool on_strand = is_strand(point);
  const Vec3 tangent = has_tangent ? inputs.tangent : on_strand ? point.dpdu : point.dpdv;
  // As in Cycles, Offset has no effect on a mesh unless a tangent is linked.
  const float offset = has_tangent || on_strand ? -get_Offset(inputs) : 0.0f;
  bsdf.add(hair::part_lobe(transmission, weight, inputs.normal, tangent, get_Roughness(inputs),
                           get_RadialRoughness(inputs), offset));
}

void add_principled_hair(Bsdf& bsdf, const ShadingPoint& point, Color weight,
                         const closures::PrincipledInputs& inputs) {
  constexpr float kLeast = 0.001f;
  const float factor = randomized(get_Random(inputs), get_RandomRoughness(inputs));
  const float roughness = glm::clamp(get_Roughness(inputs) * factor, kLeast, 1.0f);
  const float radial = get_RadialRoughness(inputs) * factor;
  if (get_IsHuang(inputs)) {
    hair::RoughFiber fiber{.absorption = absorption(inputs, radial), .eta = get_Ior(inputs), .alpha = roughness};
    fiber.aspect = hair_aspect(get_Aspect(inputs));
    fiber.tilt = get_Offset(inputs);
    fiber.factors = {get_Reflected(inputs), get_Transmitted(inputs), get_ReflectedInside(inputs)};
    if (!(max_component(fiber.factors) > 0.0f)) return;
    if (fiber.aspect < 1.0f) fiber.major = hair_major_axis(point, inputs.tangent);
    fiber.seed = hash_of(point.position);
    bsdf.add(hair::huang_lobe(weight, point.ng, point.dpdu, fiber));
    return;
  }
  hair::Fiber fiber;
  fiber.absorption = absorption(inputs, radial);
  fiber.eta = get_Ior(inputs);
  fiber.longitudinal = hair::longitudinal_variance(roughness);
  fiber.longitudinal_first = hair::longitudinal_variance(
      glm::clamp((1.0f - get_Coat(inputs)) * roughness, kLeast, 1.0f));
  fiber.azimuthal = hair::azimuthal_scale(glm::clamp(radial, kLeast, 1.0f));
  fiber.tilt = get_Offset(inputs);
  fiber.turns_light = get_TurnsLight(inputs);
  bsdf.add(hair::chiang_lobe(weight, point.ng, point.dpdu, fiber));
}

}  // namespace ajar::nodes
