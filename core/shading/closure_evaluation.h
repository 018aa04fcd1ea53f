// What the closures of a compiled shader are at a point: their inputs from registers, emission and transparency as sums,
// scattering as lobes of a Bsdf.
#pragma once

#include <cmath>

#include "shading/nodes/closure.h"
#include "shading/program/register_program.h"
#include "shading/shader_program.h"

namespace ajar {

using Closures = std::vector<Closure>;

/// The registers and constants of a program at a point.
struct Values {
  const ShadingPoint& point;
  const float *registers, *constants;

  /// The normal of a closure, `fallback` if it has none.
  Vec3 normal(Operand o, Vec3 fallback) const {
    return o == kNoOperand ? fallback : closures::safe_shading_normal(point.ng, point.wo, tilted(o, fallback));
  }
  /// The same without bending it towards the eye.
  Vec3 tilted(Operand o, Vec3 fallback) const {
    const Vec3 n = load3(operand(o, registers, constants));
    const float length2 = length_squared(n);
    return length2 > 1e-20f && length2 < 1e20f ? n / std::sqrt(length2) : fallback;
  }
};

inline closures::Surface surface_at(const ShadingPoint& point) { return {point.wo, point.ng, point.backfacing}; }

/// The colour of a closure of emission or transparency, without a coat.
Color color_of(const Closure& closure, const float* registers, const float* constants);
/// The sum of closures of emission or transparency.
Color sum(const Closures& closures, const Values& values);

/// Whether the input at this offset of PrincipledInputs is computed at each point.
bool patches(const Closure& closure, size_t offset);
/// Whether light can enter the closure and scatter below the surface.
bool has_walk(const Closure& closure);
/// Whether light may pass a Principled closure straight, because it is a smooth thin sheet.
bool is_thin_wall(const Closure& closure);

/// How the lobes that this code and these closures make depend on the direction for which they are made.
ShaderProgram::ViewDependence view_dependence_of(const std::vector<Instruction>& code, const Closures& scattering);

/// Adds the scattering closures of a program to the BSDF at a point.
struct ScatteringBuilder {
  const Values& values;
  closures::Surface surface;
  bool reflective, refractive;  ///< whether caustics of these kinds are rendered
  SurfaceShading& out;

  Vec3 normal_of(Operand o) const {
    if (o == kNoOperand) return out.bsdf.n;
    const Vec3 given = values.tilted(o, out.bsdf.n),
               safe = closures::safe_shading_normal(values.point.ng, values.point.wo, given);
    if (safe != given) [[unlikely]]
      out.bsdf.bind_to_view();
    return safe;
  }
  /// Whether light can enter a closure with subsurface scattering. After a diffuse bounce it leaves where it enters, as
  /// in Cycles before Blender 5.0. The same holds for the second medium of a surface.
  bool may_enter(const closures::PrincipledInputs& inputs) const {
    const ShadingPoint& point = values.point;
    return (!point.after_diffuse || inputs.enters_after_diffuse || point.marks_subsurface) &&
           !out.bsdf.has_subsurface();
  }
  /// The normal of diffuse lobes that is not bent towards the eye.
  void set_diffuse_normal(const Closure& closure, closures::PrincipledInputs& inputs) const {
    const Vec3 base = out.bsdf.bump_base;
    inputs.diffuse_normal = closure.normal == kNoOperand ? base : values.tilted(closure.normal, base);
    inputs.keeps_normal = inputs.diffuse_normal != inputs.normal;
  }
  /// Adds the lobes of one closure.
  void add(const Closure& closure) const;
};

}  // namespace ajar
