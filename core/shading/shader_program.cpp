#include "shading/shader_program.h"
#include "shading/functions/point_functions.h"

#include <algorithm>
#include <cstring>
#include <sstream>

#include "shading/nodes/closure_list.h"
#include "shading/nodes/displacement_nodes.h"
#include "shading/nodes/node_registry.h"
#include "shading/nodes/volume_closures.h"

namespace ajar {

// Emission and transparency have closure lists and code of their own, because light sampling and shadow rays need
// nothing else. All pieces of code use the same register numbers.
struct ShaderProgram::Data {
  std::vector<Closure> scattering, emission, transparency, holdout;
  std::vector<VolumeClosure> volumes;
  std::vector<Instruction> code, emission_code, transparency_code, volume_code;
  ProgramTables tables;
  bool reflective_caustics = true, refractive_caustics = true;
  BumpTerminator bump_terminator = BumpTerminator::Cubic;
  Operand displaced_normal = kNoOperand;  // normal of the displaced surface; kNoOperand: the smooth normal is used

  bool plain_diffuse = false;  // the only scattering closure is a Lambert closure with the surface's own normal
  bool may_be_transparent = false, depends_on_view = false;
  bool has_surface = false, has_volume = false, medium_varies = false;
  int register_count = 0;
};

namespace {

using Closures = std::vector<Closure>;

/// The instructions on which these operands depend, in the order of the program.
std::vector<Instruction> needed_code(const std::vector<Instruction>& code, int register_count,
                                     const std::vector<Operand>& operands) {
  std::vector<bool> live(size_t(register_count), false);
  const auto mark = [&](Operand o) {
    if (o >= 0 && o != kNoOperand) live[o] = true;
  };
  for (const Operand o : operands) mark(o);
  // An operand always lies within the output of one instruction. So the instruction that writes a live register is
  // kept.
  std::vector<Instruction> needed;
  for (auto i = code.rbegin(); i != code.rend(); ++i) {
    bool is_live = false;
    for (int k = 0; k < info(i->op).width; ++k) is_live = is_live || live[i->out + k];
    if (!is_live) continue;
    for (const Operand o : i->in) mark(o);
    needed.push_back(*i);
  }
  std::reverse(needed.begin(), needed.end());
  return needed;
}

void append_operands(const Closures& closures, std::vector<Operand>& operands) {
  for (const Closure& closure : closures) {
    operands.insert(operands.end(), {closure.weight, closure.normal, closure.coat_normal, closure.tangent});
    for (const InputPatch& patch : closure.patches) operands.push_back(patch.from);
  }
}

Color color_of(const Closure& closure, const float* registers, const float* constants) {
  Color color = closure.inputs.base_color;
  for (const InputPatch& patch : closure.patches) color = load3(operand(patch.from, registers, constants));
  return glm::max(color, 0.0f) * *operand(closure.weight, registers, constants);
}

/// The sum of coloured closures (emission, transparency), whose only input is their colour.
Color sum(const Closures& closures, const float* registers, const float* constants) {
  Color total(0.0f);
  for (const Closure& closure : closures) {
    const Color color = color_of(closure, registers, constants);
    if (is_finite(color)) total += color;
  }
  return total;
}

/// A Lambert closure of which at most the colour is computed at the hit.
bool is_plain_diffuse(const Closure& closure) {
  if (closure.kind != ClosureKind::Diffuse || closure.normal != kNoOperand || closure.inputs.roughness != 0.0f)
    return false;
  if (closure.patches.empty()) return true;
  const InputPatch& patch = closure.patches.front();
  return closure.patches.size() == 1 && patch.count == 3 &&
         patch.offset == offsetof(closures::PrincipledInputs, base_color) && patch.from >= 0;
}

bool patches(const Closure& closure, size_t offset) {
  return std::any_of(closure.patches.begin(), closure.patches.end(),
                     [=](const InputPatch& patch) { return patch.offset == offset; });
}

void apply_patches(const Closure& closure, const float* registers, closures::PrincipledInputs& inputs) {
  for (const InputPatch& patch : closure.patches) {
    char* at = reinterpret_cast<char*>(&inputs) + patch.offset;
    for (int i = 0; i < patch.count; ++i, at += sizeof(float)) {
      const float x = valid_input(registers[patch.from + i], patch.low, patch.high);
      std::memcpy(at, &x, sizeof(float));
    }
  }
}

/// Adds the scattering closures of a program to the BSDF at a point.
struct ScatteringBuilder {
  const ShadingPoint& point;
  closures::Surface surface;
  const float *registers, *constants;
  bool reflective, refractive;  ///< whether caustics of these kinds are rendered
  SurfaceShading& out;

  Vec3 normal_of(Operand o) const {
    if (o == kNoOperand) return out.bsdf.n;
    const Vec3 n = load3(operand(o, registers, constants));
    const float length2 = length_squared(n);
    if (!(length2 > 1e-20f && length2 < 1e20f)) return out.bsdf.n;
    return closures::safe_shading_normal(point.ng, point.wo, n / std::sqrt(length2));
  }
  /// After a diffuse bounce, light leaves where it enters, as in Cycles. The same holds for the second medium of a
  /// surface.
  bool may_enter() const { return point.diffuse_depth == 0 && !out.bsdf.has_subsurface(); }
  static closures::RoughBoundary boundary_of(const closures::PrincipledInputs& inputs) {
    return {inputs.distribution, inputs.roughness, inputs.ior};
  }

  void add(const Closure& closure) const {
    const float weight = *operand(closure.weight, registers, constants);
    if (!(weight > 0.0f)) return;
    closures::PrincipledInputs inputs = closure.inputs;
    apply_patches(closure, registers, inputs);
    inputs.normal = normal_of(closure.normal);
    if (closure.tangent != kNoOperand) inputs.tangent = load3(operand(closure.tangent, registers, constants));
    const Color color = inputs.base_color * weight;
    switch (closure.kind) {
      case ClosureKind::Diffuse:
        closures::add_diffuse(out.bsdf, surface, color, inputs.normal, inputs.roughness);
        break;
      case ClosureKind::Translucent: closures::add_translucent(out.bsdf, surface, color, inputs.normal); break;
      case ClosureKind::Glossy:
        if (reflective)
          closures::add_glossy(out.bsdf, surface, color, inputs.normal, inputs.distribution, inputs.roughness,
                               {inputs.tangent, inputs.anisotropic, inputs.anisotropic_rotation});
        break;
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
        inputs.enters = inputs.version == 1 && inputs.subsurface > 0.0f && may_enter();
        if (inputs.enters) out.medium = closures::principled_medium(inputs);
        closures::add_principled(out.bsdf, surface, Color(weight), inputs);
        break;
      case ClosureKind::Velvet: closures::add_velvet(out.bsdf, surface, color, inputs.normal, inputs.roughness); break;
      case ClosureKind::ToonDiffuse:
      case ClosureKind::ToonGlossy: {
        const bool glossy = closure.kind == ClosureKind::ToonGlossy;
        if (reflective || !glossy)
          closures::add_toon(out.bsdf, surface, color, inputs.normal, glossy, inputs.roughness,
                             inputs.transmission_roughness);
        break;
      }
      case ClosureKind::Subsurface:
        if (may_enter()) {
          out.medium = closures::make_medium(inputs.base_color, inputs.subsurface_radius * inputs.subsurface_scale,
                                             inputs.subsurface_anisotropy, inputs.subsurface_ior,
                                             inputs.subsurface_method);
          closures::add_subsurface(out.bsdf, surface, color, inputs.normal, out.medium);
        } else {
          closures::add_diffuse(out.bsdf, surface, color, inputs.normal, 0.0f);
        }
        break;
      case ClosureKind::Emission:
      case ClosureKind::Transparent:
      case ClosureKind::Holdout: break;  // these are in lists of their own
    }
  }
};

}  // namespace

ShaderProgram::ShaderProgram() : data_(std::make_unique<Data>()) {}
ShaderProgram::ShaderProgram(ShaderProgram&&) noexcept = default;
ShaderProgram& ShaderProgram::operator=(ShaderProgram&&) noexcept = default;
ShaderProgram::~ShaderProgram() = default;

ShaderProgram ShaderProgram::compile(const NodeGraph& graph, const std::string& owner, TextureStore& textures,
                                     Diagnostics& diagnostics, const ShaderContext& context) {
  ShaderProgram program;
  Data& data = *program.data_;
  data.reflective_caustics = context.reflective_caustics;
  data.refractive_caustics = context.refractive_caustics;
  data.bump_terminator = context.bump_terminator;
  ProgramBuilder builder(node_catalog(), graph, owner, textures, diagnostics, context);
  nodes::add_displacement(builder);
  for (Closure& closure : flatten_closures(builder)) {
    Closures& list = closure.kind == ClosureKind::Emission      ? data.emission
                     : closure.kind == ClosureKind::Transparent ? data.transparency
                     : closure.kind == ClosureKind::Holdout     ? data.holdout
                                                                : data.scattering;
    list.push_back(std::move(closure));
  }
  data.has_surface = graph.surface.node >= 0;
  data.has_volume = graph.volume.node >= 0;
  data.volumes = flatten_volumes(builder);
  if (builder.overflowed())
    report_once(diagnostics, {Diagnostic::Severity::Warning, owner,
                              "its node graph is too large; values beyond the limit are grey"});

  data.register_count = builder.register_count();
  if (!data.scattering.empty()) data.displaced_normal = builder.displaced_normal();
  const auto code_for = [&](std::initializer_list<const Closures*> lists, Operand also = kNoOperand) {
    std::vector<Operand> operands{also};
    for (const Closures* list : lists) append_operands(*list, operands);
    return needed_code(builder.code, data.register_count, operands);
  };
  data.code = code_for({&data.scattering, &data.emission, &data.transparency, &data.holdout}, data.displaced_normal);
  data.emission_code = code_for({&data.emission});
  data.transparency_code = code_for({&data.transparency});
  std::vector<Operand> of_volumes;
  for (const VolumeClosure& closure : data.volumes)
    for (const Operand o : closure.operands()) of_volumes.push_back(o);
  data.volume_code = needed_code(builder.code, data.register_count, of_volumes);
  for (const Instruction& i : data.volume_code) data.medium_varies |= varies_inside(i.op);
  data.tables = std::move(builder.tables);
  data.may_be_transparent = !data.transparency.empty();
  data.plain_diffuse = data.scattering.size() == 1 && data.transparency.empty() &&
                       is_plain_diffuse(data.scattering.front());
  for (const Instruction& i : data.code)
    for (const Op op : {Op::Incoming, Op::Backfacing, Op::Fresnel, Op::LayerWeight, Op::Reflection, Op::ShadingNormal,
                        Op::TrueNormal, Op::Bump})
      data.depends_on_view |= i.op == op;
  for (const Closure& closure : data.scattering)
    data.depends_on_view |= closure.normal != kNoOperand || closure.coat_normal != kNoOperand ||
                            (closure.kind == ClosureKind::Principled && closure.inputs.version >= 2);
  return program;
}

void ShaderProgram::evaluate_surface(const ShadingPoint& point, SurfaceShading& out) const {
  const Data& d = *data_;
  float registers[kMaxRegisters];
  const float* constants = d.tables.constants.data();
  run(d.code.data(), d.code.size(), d.tables, point, registers);

  const Vec3 normal = d.displaced_normal == kNoOperand ? point.ns : load3(registers + d.displaced_normal);
  out.bsdf.start(point.ng, closures::safe_shading_normal(point.ng, point.wo, normal));
  out.emission = sum(d.emission, registers, constants);
  out.holdout = 0.0f;
  for (const Closure& closure : d.holdout) out.holdout += *operand(closure.weight, registers, constants);

  if (d.plain_diffuse) {
    const Closure& diffuse = d.scattering.front();
    Color color = diffuse.inputs.base_color;
    if (!diffuse.patches.empty()) color = glm::max(load3(registers + diffuse.patches.front().from), Color(0.0f));
    color *= *operand(diffuse.weight, registers, constants);
    if (is_finite(color)) out.bsdf.set_lambert(color, point.wo);
    return;
  }

  out.bsdf.bump_terminator = d.bump_terminator;
  const bool after_diffuse = point.ray_kind & kRayDiffuse;
  const ScatteringBuilder builder{
      point,     {point.wo, point.ng, point.backfacing},  registers,
      constants, d.reflective_caustics || !after_diffuse, d.refractive_caustics || !after_diffuse,
      out};
  for (const Closure& closure : d.scattering) builder.add(closure);
  for (const Closure& closure : d.transparency)
    closures::add_transparent(out.bsdf, color_of(closure, registers, constants));
  out.bsdf.prepare(point.wo);
}

Color ShaderProgram::evaluate_emission(const ShadingPoint& point) const {
  const Data& d = *data_;
  if (d.emission.empty()) return Color(0.0f);
  float registers[kMaxRegisters];
  run(d.emission_code.data(), d.emission_code.size(), d.tables, point, registers);
  return sum(d.emission, registers, d.tables.constants.data());
}

Color ShaderProgram::evaluate_transparency(const ShadingPoint& point) const {
  const Data& d = *data_;
  if (d.transparency.empty()) return Color(0.0f);
  float registers[kMaxRegisters];
  run(d.transparency_code.data(), d.transparency_code.size(), d.tables, point, registers);
  return sum(d.transparency, registers, d.tables.constants.data());
}

void ShaderProgram::add_medium(const ShadingPoint& point, MediumPoint& medium) const {
  const Data& d = *data_;
  if (d.volumes.empty()) return;
  float registers[kMaxRegisters];
  run_inside(d.volume_code.data(), d.volume_code.size(), d.tables, point, registers);
  add_volumes(d.volumes, registers, d.tables.constants.data(), medium);
}

bool ShaderProgram::is_constant() const { return data_->code.empty(); }
bool ShaderProgram::emits() const { return !data_->emission.empty(); }
bool ShaderProgram::emission_is_constant() const { return data_->emission_code.empty(); }
bool ShaderProgram::emission_is_slow() const {
  const auto has = [&](std::initializer_list<Op> ops) {
    return std::any_of(data_->emission_code.begin(), data_->emission_code.end(),
                       [&](const Instruction& i) { return std::find(ops.begin(), ops.end(), i.op) != ops.end(); });
  };
  return has({Op::Noise, Op::NoiseColor, Op::Voronoi, Op::Wave}) && !has({Op::Image, Op::ImageBox, Op::Environment});
}
bool ShaderProgram::emission_depends_on_mesh_alone() const {
  return std::all_of(data_->emission_code.begin(), data_->emission_code.end(), [](const Instruction& i) {
    return !info(i.op).needs_point || i.op == Op::Generated || i.op == Op::ActiveUv || i.op == Op::NamedUv ||
           i.op == Op::NamedAttribute;
  });
}
bool ShaderProgram::emission_depends_on_side() const {
  return std::any_of(data_->emission_code.begin(), data_->emission_code.end(), [](const Instruction& i) {
    switch (i.op) {
      case Op::ShadingNormal:
      case Op::TrueNormal:
      case Op::ObjectNormal:
      case Op::Incoming:
      case Op::Backfacing:
      case Op::Reflection:
      case Op::Fresnel:
      case Op::LayerWeight:
      case Op::NormalMap:
      case Op::AmbientOcclusion:
      case Op::Bump:
      case Op::Displacement:
      case Op::VectorDisplacement: return true;
      default: return false;
    }
  });
}
bool ShaderProgram::emission_depends_on_distance() const {
  return std::any_of(data_->emission_code.begin(), data_->emission_code.end(), [](const Instruction& i) {
    return i.op == Op::LightFalloff ||
           (i.op == Op::LightPath && nodes::LightPathOutput(i.variant) == nodes::LightPathOutput::RayLength);
  });
}
bool ShaderProgram::has_volume() const { return data_->has_volume; }
bool ShaderProgram::has_surface() const { return data_->has_surface; }
bool ShaderProgram::medium_varies() const { return data_->medium_varies; }
bool ShaderProgram::may_be_transparent() const { return data_->may_be_transparent; }
bool ShaderProgram::scatters() const { return !data_->scattering.empty(); }

bool ShaderProgram::has_subsurface() const {
  return std::any_of(data_->scattering.begin(), data_->scattering.end(), [](const Closure& c) {
    return c.kind == ClosureKind::Subsurface ||
           (c.kind == ClosureKind::Principled && c.inputs.version == 1 &&
            (c.inputs.subsurface > 0.0f || patches(c, offsetof(closures::PrincipledInputs, subsurface))));
  });
}

bool ShaderProgram::may_be_rough(float roughness) const {
  return std::any_of(data_->scattering.begin(), data_->scattering.end(), [=](const Closure& c) {
    switch (c.kind) {
      case ClosureKind::Diffuse:
      case ClosureKind::Translucent:
      case ClosureKind::Velvet:
      case ClosureKind::ToonDiffuse:
      case ClosureKind::ToonGlossy:
      case ClosureKind::Subsurface:
      case ClosureKind::Principled: return true;
      case ClosureKind::Glossy:
      case ClosureKind::Glass:
      case ClosureKind::Refraction:
        return !c.patches.empty() ||
               (c.inputs.roughness >= roughness && c.inputs.distribution != closures::Distribution::Sharp);
      default: return false;
    }
  });
}

bool ShaderProgram::may_be_smooth(float roughness) const {
  const bool reflective = data_->reflective_caustics, refractive = data_->refractive_caustics;
  return std::any_of(data_->scattering.begin(), data_->scattering.end(), [=](const Closure& c) {
    // A colour that varies is a patch as well. Checking which inputs are patched would gain little.
    const bool smooth = !c.patches.empty() || c.inputs.roughness < roughness ||
                        c.inputs.distribution == closures::Distribution::Sharp;
    switch (c.kind) {
      case ClosureKind::Glossy: return reflective && smooth;
      case ClosureKind::Refraction: return refractive && smooth;
      case ClosureKind::Glass: return (reflective || refractive) && smooth;
      case ClosureKind::Principled:
        return (reflective || refractive) && (smooth || c.inputs.clearcoat > 0.0f || c.inputs.transmission > 0.0f);
      default: return false;
    }
  });
}

bool ShaderProgram::depends_on_view() const { return data_->depends_on_view; }
std::vector<std::pair<int, const Texture*>> ShaderProgram::images() const {
  std::vector<std::pair<int, const Texture*>> all;
  for (const ImageLookup& lookup : data_->tables.images) all.push_back({lookup.image, lookup.texture});
  return all;
}

std::vector<SkyDisc> ShaderProgram::sky_discs() const {
  std::vector<SkyDisc> discs;
  const Data& d = *data_;
  for (const Instruction& sky : d.emission_code) {
    if (sky.op != Op::Sky) continue;
    const auto sun = d.tables.skies[sky.data].sun();
    // The node knows the direction of the sun only if the coordinates of the sky are not rotated.
    const bool as_it_is = std::any_of(d.emission_code.begin(), d.emission_code.end(), [&](const Instruction& i) {
      return i.op == Op::Generated && i.out == sky.in[0];
    });
    if (sun && as_it_is) discs.push_back({sun->direction, sun->angular_radius});
  }
  return discs;
}

int ShaderProgram::instruction_count() const { return int(data_->code.size()); }

std::string ShaderProgram::listing() const {
  const Data& d = *data_;
  std::ostringstream text;
  const auto write = [&](Operand o) {
    if (o >= 0)
      text << 'r' << o;
    else
      text << d.tables.constants[-1 - o];
  };
  for (const Instruction& i : d.code) {
    text << 'r' << i.out << " = " << info(i.op).name;
    if (i.variant) text << '.' << int(i.variant);
    if (i.data) text << '#' << i.data;
    for (const Operand o : i.in)
      if (o != kNoOperand) text << ' ', write(o);
    text << '\n';
  }
  for (const Closures* list : {&d.scattering, &d.emission, &d.transparency, &d.holdout})
    for (const Closure& closure : *list) {
      text << name_of(closure.kind) << " weight ";
      write(closure.weight);
      for (const InputPatch& patch : closure.patches) text << " [" << patch.offset << "] <- r" << patch.from;
      if (closure.normal != kNoOperand) text << " normal ", write(closure.normal);
      text << '\n';
    }
  return text.str();
}

}  // namespace ajar
