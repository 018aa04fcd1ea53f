#include "shading/closure_evaluation.h"

#include <algorithm>
#include <cstring>

#include "shading/functions/point_functions.h"
#include "shading/nodes/hair_closures.h"

namespace ajar {

Color color_of(const Closure& closure, const float* registers, const float* constants) {
  Color color = closure.inputs.base_color;
  for (const InputPatch& patch : closure.patches)
    if (patch.offset == offsetof(closures::PrincipledInputs, base_color))
      color = load3(operand(patch.from, registers, constants));
  return glm::max(color, 0.0f) * *operand(closure.weight, registers, constants);
}

namespace {

void apply_patches(const Closure& closure, const float* registers, closures::PrincipledInputs& inputs) {
  for (const InputPatch& patch : closure.patches) {
    char* at = reinterpret_cast<char*>(&inputs) + patch.offset;
    for (int i = 0; i < patch.count; ++i, at += sizeof(float)) {
      const float x = valid_input(registers[patch.from + i], patch.low, patch.high);
      std::memcpy(at, &x, sizeof(float));
    }
  }
}

/// The fraction of a closure's emission that passes the layers above it.
Color through_coat(const Closure& closure, const Values& values) {
  closures::PrincipledInputs inputs = closure.inputs;
  apply_patches(closure, values.registers, inputs);
  const ShadingPoint& point = values.point;
  const Vec3 smooth = closures::safe_shading_normal(point.ng, point.wo, point.ns);
  inputs.normal = values.normal(closure.normal, smooth);
  inputs.clearcoat_normal = values.normal(closure.coat_normal, smooth);
  return closures::emission_through_coat(surface_at(point), inputs);
}

closures::RoughBoundary boundary_of(const closures::PrincipledInputs& inputs) {
  return {inputs.distribution, inputs.roughness, inputs.ior, inputs.correlated, inputs.film};
}

}  // namespace

Color sum(const Closures& closures, const Values& values) {
  Color total(0.0f);
  for (const Closure& closure : closures) {
    Color color = color_of(closure, values.registers, values.constants);
    if (closure.kind == ClosureKind::CoatedEmission) color *= through_coat(closure, values);
    if (is_finite(color)) total += color;
  }
  return total;
}

bool patches(const Closure& closure, size_t offset) {
  return std::any_of(closure.patches.begin(), closure.patches.end(),
                     [=](const InputPatch& patch) { return patch.offset == offset; });
}

bool has_walk(const Closure& closure) {
  return closure.kind == ClosureKind::Subsurface ||
         (closure.kind == ClosureKind::Principled &&
          (closure.inputs.subsurface > 0.0f || patches(closure, offsetof(closures::PrincipledInputs, subsurface))));
}

bool is_thin_wall(const Closure& closure) {
  using Inputs = closures::PrincipledInputs;
  return closure.kind == ClosureKind::Principled &&
         (closure.inputs.thin_wall != 0.0f || patches(closure, offsetof(Inputs, thin_wall))) &&
         (closure.inputs.transmission > 0.0f || patches(closure, offsetof(Inputs, transmission)));
}

ShaderProgram::ViewDependence view_dependence_of(const std::vector<Instruction>& code, const Closures& scattering) {
  using ViewDependence = ShaderProgram::ViewDependence;
  ViewDependence most = ViewDependence::None;
  const auto at_least = [&](ViewDependence found) { most = std::max(most, found); };
  for (const Instruction& i : code) {
    switch (i.op) {
      case Op::Backfacing:
      case Op::ShadingNormal:
      case Op::TrueNormal:
      case Op::Bevel: at_least(ViewDependence::Side); break;
      case Op::Bump:  // without the variant, the node itself bends its normal
        at_least(i.variant != 0 ? ViewDependence::Side : ViewDependence::Direction);
        break;
      case Op::HairInfo:
        if (i.variant == int(nodes::HairOutput::Misses)) at_least(ViewDependence::Direction);
        break;
      case Op::Incoming:
      case Op::ObjectIncoming:
      case Op::Fresnel:
      case Op::LayerWeight:
      case Op::Reflection:
      case Op::Raycast:
      case Op::RaycastAttribute: at_least(ViewDependence::Direction); break;
      default: break;
    }
  }
  for (const Closure& closure : scattering)
    if (closure.normal != kNoOperand || closure.coat_normal != kNoOperand ||
        (closure.kind == ClosureKind::Principled && closure.inputs.version >= 2))
      at_least(ViewDependence::Side);
  return most;
}

void ScatteringBuilder::add(const Closure& closure) const {
  const float weight = *operand(closure.weight, values.registers, values.constants);
  if (!(weight > 0.0f)) return;
  closures::PrincipledInputs inputs = closure.inputs;
  apply_patches(closure, values.registers, inputs);
  inputs.normal = inputs.diffuse_normal = normal_of(closure.normal);
  if (inputs.keeps_normal) set_diffuse_normal(closure, inputs);
  const Vec3 kept = inputs.diffuse_normal;
  if (closure.tangent != kNoOperand)
    inputs.tangent = load3(operand(closure.tangent, values.registers, values.constants));
  const Color color = inputs.base_color * weight;
  const closures::Facets facets{inputs.distribution, inputs.roughness, inputs.correlated};
  switch (closure.kind) {
    case ClosureKind::Diffuse:
      closures::add_diffuse(out.bsdf, surface, color, kept, inputs.roughness,
                            inputs.multiple_scattering ? inputs.base_color : Color(0.0f), inputs.keeps_normal);
      break;
    case ClosureKind::Translucent: closures::add_translucent(out.bsdf, surface, color, inputs.normal); break;
    case ClosureKind::Glossy:
      if (reflective) closures::add_glossy(out.bsdf, surface, color, inputs.normal, facets, inputs.anisotropy());
      break;
    case ClosureKind::Metallic:
      if (reflective)
        closures::add_metallic(out.bsdf, Color(weight), inputs.normal, facets, inputs.anisotropy(),
                               {inputs.is_conductor, inputs.base_color, inputs.specular_tint_color, inputs.film});
      break;
    case ClosureKind::Sheen: closures::add_sheen(out.bsdf, color, kept, inputs.roughness, inputs.keeps_normal); break;
    case ClosureKind::Refraction:
      if (refractive) closures::add_refraction(out.bsdf, surface, color, inputs.normal, boundary_of(inputs));
      break;
    case ClosureKind::Glass:
      closures::add_glass(out.bsdf, surface, color, inputs.normal, boundary_of(inputs), reflective, refractive);
      break;
    case ClosureKind::Principled:
      inputs.clearcoat_normal = normal_of(closure.coat_normal);
      inputs.reflective_caustics = reflective;
      inputs.refractive_caustics = refractive;
      inputs.enters = inputs.subsurface > 0.0f && may_enter(inputs);
      if (inputs.enters) {
        out.medium = closures::principled_medium(inputs);
        out.medium.after_diffuse = inputs.enters_after_diffuse;
      }
      closures::add_principled(out.bsdf, surface, Color(weight), inputs);
      break;
    case ClosureKind::Velvet: closures::add_velvet(out.bsdf, surface, color, kept, inputs.roughness); break;
    case ClosureKind::ToonGlossy:
      if (!reflective) break;
      [[fallthrough]];
    case ClosureKind::ToonDiffuse:
      closures::add_toon(out.bsdf, color, kept, closure.kind == ClosureKind::ToonGlossy, inputs.roughness,
                         inputs.transmission_roughness, inputs.keeps_normal);
      break;
    case ClosureKind::Subsurface:
      if (may_enter(inputs)) {
        out.medium = closures::make_medium({inputs.subsurface_method, inputs.base_color,
                                            inputs.subsurface_radius * inputs.subsurface_scale,
                                            inputs.subsurface_anisotropy, inputs.subsurface_ior, inputs.roughness});
        out.medium.after_diffuse = inputs.enters_after_diffuse;
        closures::add_subsurface(out.bsdf, surface, color, inputs.normal, out.medium);
      } else {
        closures::add_diffuse(out.bsdf, surface, color, inputs.normal, 0.0f);
      }
      break;
    case ClosureKind::PrincipledHair: nodes::add_principled_hair(out.bsdf, values.point, Color(weight), inputs); break;
    case ClosureKind::HairReflection:
    case ClosureKind::HairTransmission:
      nodes::add_hair(out.bsdf, values.point, closure.kind == ClosureKind::HairTransmission, color, inputs,
                      closure.tangent != kNoOperand);
      break;
    case ClosureKind::RayPortal:
      closures::add_portal(out.bsdf, surface, color, inputs.clearcoat_normal, inputs.tangent);
      break;
    case ClosureKind::Emission:
    case ClosureKind::CoatedEmission:
    case ClosureKind::Transparent:
    case ClosureKind::Holdout: break;  // these are in lists of their own
  }
}

}  // namespace ajar
