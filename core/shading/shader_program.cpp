#include "shading/shader_program.h"

#include <algorithm>
#include <cstring>
#include <sstream>

#include "shading/aov_outputs.h"
#include "shading/closure_evaluation.h"
#include "shading/functions/point_functions.h"
#include "shading/nodes/closure_nodes.h"
#include "shading/nodes/displacement_nodes.h"
#include "shading/nodes/node_registry.h"
#include "shading/nodes/volume_closures.h"
#include "shading/program/register_allocation.h"

namespace ajar {

// Emission (for light sampling) and transparency (for shadow rays) have their own closures and code on the same registers.
struct ShaderProgram::Data {
  std::vector<Closure> scattering, emission, transparency, holdout;
  // Those of `scattering` through which light may pass straight, and ray portals, which shadow rays do not pass.
  std::vector<Closure> thin_walls, portals;
  std::vector<VolumeClosure> volumes;
  std::vector<Instruction> code, emission_code, transparency_code, volume_code;
  std::vector<Instruction> displacement_code, undisplaced_code, aov_code;
  std::vector<AovOutput> aovs;
  ProgramTables tables;
  bool reflective_caustics = true, refractive_caustics = true;
  BumpTerminator bump_terminator = BumpTerminator::Cubic;
  Operand displacement = kNoOperand;        // vector by which vertices move, from displacement_code
  Operand undisplaced_normal = kNoOperand;  // normal from undisplaced_code, which runs on the surface before it moved
  Operand displaced_normal = kNoOperand;    // normal of the displaced surface; kNoOperand: the smooth normal is used
  bool plain_diffuse = false;  // the only scattering closure is a Lambert closure with the surface's own normal
  bool may_be_transparent = false, subsurface_has_normal = false;
  ViewDependence view_dependence = ViewDependence::None;
  bool has_surface = false, has_volume = false, medium_varies = false;
  bool keeps_normal = false;  // the surface's own normal is not bent towards the eye for diffuse closures
  int register_count = 0;

  Color through_thin_walls(const Values& values) const;
  bool has_coated_emission() const {
    return std::any_of(emission.begin(), emission.end(),
                       [](const Closure& closure) { return closure.kind == ClosureKind::CoatedEmission; });
  }
  std::vector<SkyDisc> sky_discs;

  /// Selects the code of each kind of evaluation from the whole program, and assigns the registers.
  void divide_code(const std::vector<Instruction>& all, int value_count);
  void shade(const ShadingPoint& point, float* registers, SurfaceShading& out) const;
  /// Calls `evaluate` with the point, whose smooth normal is bent first if the material moves and bends the surface.
  template <class Evaluate>
  [[gnu::always_inline]] auto with_bent_normal(const ShadingPoint& point, const Evaluate& evaluate) const {
    if (undisplaced_normal == kNoOperand) [[likely]]
      return evaluate(point);
    const ShadingPoint bent = bend_normal(point);
    return evaluate(bent);
  }
  [[gnu::noinline]] ShadingPoint bend_normal(const ShadingPoint& point) const;
};

namespace {

/// The instructions on which these operands depend, in the order of the program.
std::vector<Instruction> needed_code(const std::vector<Instruction>& code, int value_count,
                                     const std::vector<Operand>& operands) {
  std::vector<bool> live(size_t(value_count), false);
  const auto mark = [&](Operand o) {
    if (o >= 0 && o != kNoOperand) live[o] = true;
  };
  for (const Operand o : operands) mark(o);
  // An operand always lies within the output of one instruction. So the instruction that writes a live value is kept.
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

void assign_registers(const RegisterAllocation& register_of, Closures& closures) {
  for (Closure& closure : closures) {
    for (Operand* o : {&closure.weight, &closure.normal, &closure.coat_normal, &closure.tangent}) *o = register_of(*o);
    for (InputPatch& patch : closure.patches) patch.from = register_of(patch.from);
  }
}

/// The discs of the skies that `code` evaluates in their own coordinates.
std::vector<SkyDisc> find_sky_discs(const std::vector<Instruction>& code, const ProgramTables& tables) {
  std::vector<SkyDisc> discs;
  for (const Instruction& sky : code) {
    if (sky.op != Op::Sky) continue;
    const auto sun = tables.skies[sky.data].sun();
    // The node knows the direction of the sun only if the coordinates of the sky are not rotated.
    const bool as_it_is = std::any_of(
        code.begin(), code.end(), [&](const Instruction& i) { return i.op == Op::Generated && i.out == sky.in[0]; });
    if (sun && as_it_is) discs.push_back({sun->direction, sun->angular_radius});
  }
  return discs;
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

}  // namespace

/// The weight of the transparent lobes of thin walls. Light that is hindered by other lobes is not transmitted.
Color ShaderProgram::Data::through_thin_walls(const Values& values) const {
  const ShadingPoint& point = values.point;
  SurfaceShading shading;
  shading.bsdf.start(point.ng, closures::safe_shading_normal(point.ng, point.wo, point.ns));
  const ScatteringBuilder builder{values, surface_at(point), true, true, shading};
  for (const Closure& closure : thin_walls) builder.add(closure);
  return shading.bsdf.transparency();
}

ShaderProgram::ShaderProgram() : data_(std::make_unique<Data>()) {}
ShaderProgram::ShaderProgram(ShaderProgram&&) noexcept = default;
ShaderProgram& ShaderProgram::operator=(ShaderProgram&&) noexcept = default;
ShaderProgram::~ShaderProgram() = default;

void ShaderProgram::Data::divide_code(const std::vector<Instruction>& all, int value_count) {
  const auto operands_of = [](std::initializer_list<const Closures*> lists) {
    std::vector<Operand> operands;
    for (const Closures* list : lists) append_operands(*list, operands);
    return operands;
  };
  std::vector<Operand> of_volumes, of_surface = operands_of({&scattering, &emission, &transparency, &holdout});
  of_surface.push_back(displaced_normal);
  for (VolumeClosure& closure : volumes)
    for (const Operand* o : closure.operands()) of_volumes.push_back(*o);
  code = needed_code(all, value_count, of_surface);
  emission_code = needed_code(all, value_count, operands_of({&emission}));
  transparency_code = needed_code(all, value_count, operands_of({&transparency, &thin_walls, &portals}));
  volume_code = needed_code(all, value_count, of_volumes);
  displacement_code = needed_code(all, value_count, {displacement});
  undisplaced_code = needed_code(all, value_count, {undisplaced_normal});
  sky_discs = find_sky_discs(emission_code, tables);

  // A point is shaded either as a surface or as a volume.
  const auto assign = [&](const std::vector<Instruction>& whole, const std::vector<Operand>& kept) {
    RegisterAllocation allocation(whole, value_count, kept);
    register_count = std::max(register_count, allocation.register_count());
    return allocation;
  };
  const RegisterAllocation on_surface = assign(code, of_surface), inside = assign(volume_code, of_volumes);
  for (std::vector<Instruction>* part : {&code, &emission_code, &transparency_code}) on_surface.apply(*part);
  inside.apply(volume_code);
  for (const auto& [part, result] :
       {std::pair(&displacement_code, &displacement), std::pair(&undisplaced_code, &undisplaced_normal)}) {
    const RegisterAllocation alone = assign(*part, {*result});
    alone.apply(*part);
    *result = alone(*result);
  }
  std::vector<Operand> of_aovs;
  for (const AovOutput& aov : aovs) of_aovs.insert(of_aovs.end(), {aov.color, aov.value});
  aov_code = ajar::aov_code(needed_code(all, value_count, of_aovs), value_count, aovs, register_count);
  for (Closures* list : {&scattering, &emission, &transparency, &holdout, &thin_walls, &portals})
    assign_registers(on_surface, *list);
  displaced_normal = on_surface(displaced_normal);
  for (VolumeClosure& closure : volumes)
    for (Operand* o : closure.operands()) *o = inside(*o);
}

ShaderProgram ShaderProgram::compile(const NodeGraph& graph, const std::string& owner, TextureStore& textures,
                                     Diagnostics& diagnostics, const ShaderContext& context) {
  ShaderProgram program;
  Data& data = *program.data_;
  data.reflective_caustics = context.reflective_caustics;
  data.refractive_caustics = context.refractive_caustics;
  data.bump_terminator = context.bump_terminator;
  ProgramBuilder builder(node_catalog(), graph, owner, textures, diagnostics, context);
  if (context.displacement_method != DisplacementMethod::Bump)
    data.displacement = builder.with_exact_images([&] { return nodes::displacement_vector(builder); }).at;
  if (context.displacement_method != DisplacementMethod::Displacement) {
    const Value smooth = builder.surface_normal(), bent = nodes::displaced_normal(builder);
    if (bent.at != smooth.at && context.displacement_method == DisplacementMethod::Bump)
      builder.set_displaced_normal(bent);
    else if (bent.at != smooth.at)
      data.undisplaced_normal = bent.at;
  }
  for (Closure& closure : nodes::flatten_closures(builder)) {
    const bool emits = closure.kind == ClosureKind::Emission || closure.kind == ClosureKind::CoatedEmission;
    Closures& list = emits                                      ? data.emission
                     : closure.kind == ClosureKind::Transparent ? data.transparency
                     : closure.kind == ClosureKind::Holdout     ? data.holdout
                                                                : data.scattering;
    list.push_back(std::move(closure));
  }
  data.has_surface = graph.surface.node >= 0;
  data.has_volume = graph.volume.node >= 0;
  data.volumes = flatten_volumes(builder);
  data.aovs = compile_aovs(builder);
  if (!data.scattering.empty()) data.displaced_normal = builder.displaced_normal();
  const bool bends_normal = data.displaced_normal != kNoOperand || data.undisplaced_normal != kNoOperand;
  data.keeps_normal = bends_normal ? builder.number(graph.displacement.node, "keeps_normal") != 0.0f
                                   : std::any_of(data.scattering.begin(), data.scattering.end(),
                                                 [](const Closure& c) { return c.inputs.keeps_normal; });
  std::copy_if(data.scattering.begin(), data.scattering.end(), std::back_inserter(data.thin_walls), is_thin_wall);
  std::copy_if(data.scattering.begin(), data.scattering.end(), std::back_inserter(data.portals),
               [](const Closure& closure) { return closure.kind == ClosureKind::RayPortal; });
  data.tables = std::move(builder.tables);
  data.divide_code(builder.code, builder.register_count());
  for (const Instruction& i : data.volume_code)
    data.medium_varies |= i.op == Op::NamedAttribute ? context.has_grid(data.tables.names[i.data])
                                                     : varies_inside(i.op);
  data.may_be_transparent = !data.transparency.empty() || !data.thin_walls.empty();
  data.plain_diffuse = data.scattering.size() == 1 && data.transparency.empty() &&
                       is_plain_diffuse(data.scattering.front());
  data.view_dependence = view_dependence_of(data.code, data.scattering);
  if (!data.undisplaced_code.empty()) data.view_dependence = ViewDependence::Direction;
  for (const Closure& closure : data.scattering)
    data.subsurface_has_normal |= has_walk(closure) && (closure.normal != kNoOperand || bends_normal);
  return program;
}

void ShaderProgram::evaluate_surface(const ShadingPoint& point, SurfaceShading& out) const {
  data_->with_bent_normal(point, [&](const ShadingPoint& bent) {
    with_registers(data_->register_count, [&](float* registers) { data_->shade(bent, registers, out); });
  });
}

ShadingPoint ShaderProgram::Data::bend_normal(const ShadingPoint& point) const {
  ShadingPoint bent = point;
  with_registers(register_count, [&](float* registers) {
    run(undisplaced_code.data(), undisplaced_code.size(), tables, nodes::undisplaced(point), registers);
    bent.ns = load3(operand(undisplaced_normal, registers, tables.constants.data()));
  });
  return bent;
}

bool ShaderProgram::displaces() const { return data_->displacement != kNoOperand; }
bool ShaderProgram::bends_undisplaced_normal() const { return data_->undisplaced_normal != kNoOperand; }

Vec3 ShaderProgram::displacement(const ShadingPoint& point) const {
  const Data& d = *data_;
  Vec3 moved(0.0f);
  if (d.displacement == kNoOperand) return moved;
  with_registers(d.register_count, [&](float* registers) {
    run(d.displacement_code.data(), d.displacement_code.size(), d.tables, point, registers);
    moved = load3(operand(d.displacement, registers, d.tables.constants.data()));
  });
  return moved;
}

void ShaderProgram::Data::shade(const ShadingPoint& point, float* registers, SurfaceShading& out) const {
  const Data& d = *this;
  const float* constants = d.tables.constants.data();
  run(d.code.data(), d.code.size(), d.tables, point, registers);

  const Vec3 normal = d.displaced_normal == kNoOperand ? point.ns : load3(registers + d.displaced_normal);
  out.bsdf.start(point.ng, closures::safe_shading_normal(point.ng, point.wo, normal));
  if (out.bsdf.n != normal) [[unlikely]]
    out.bsdf.bind_to_view();
  if (d.keeps_normal) out.bsdf.bump_base = normal;
  const Values values{point, registers, constants};
  out.emission = d.emission.empty() ? Color(0.0f) : sum(d.emission, values);
  out.holdout = 0.0f;
  for (const Closure& closure : d.holdout) out.holdout += *operand(closure.weight, registers, constants);

  if (d.plain_diffuse && out.bsdf.bump_base == out.bsdf.n) {
    const Closure& diffuse = d.scattering.front();
    Color color = diffuse.inputs.base_color;
    if (!diffuse.patches.empty()) color = glm::max(load3(registers + diffuse.patches.front().from), Color(0.0f));
    color *= *operand(diffuse.weight, registers, constants);
    if (is_finite(color)) out.bsdf.set_lambert(color, point.wo);
    return;
  }

  out.bsdf.bump_terminator = d.bump_terminator;
  out.bsdf.channel_weights = point.channel_weights;
  const bool after_diffuse = point.ray_kind & kRayDiffuse;
  const ScatteringBuilder builder{values, surface_at(point), d.reflective_caustics || !after_diffuse,
                                  d.refractive_caustics || !after_diffuse, out};
  for (const Closure& closure : d.scattering) builder.add(closure);
  for (const Closure& closure : d.transparency)
    closures::add_transparent(out.bsdf, color_of(closure, registers, constants));
  out.bsdf.prepare(point.wo);
}

Color ShaderProgram::evaluate_emission(const ShadingPoint& point) const {
  const Data& d = *data_;
  if (d.emission.empty()) return Color(0.0f);
  return with_registers(
      d.register_count, [&](float* registers) __attribute__((always_inline)) {
        return d.with_bent_normal(point, [&](const ShadingPoint& bent) {
          run(d.emission_code.data(), d.emission_code.size(), d.tables, bent, registers);
          return sum(d.emission, {bent, registers, d.tables.constants.data()});
        });
      });
}

Color ShaderProgram::evaluate_transparency(const ShadingPoint& point) const {
  const Data& d = *data_;
  if (!d.may_be_transparent) return Color(0.0f);
  return with_registers(
      d.register_count, [&](float* registers) __attribute__((always_inline)) {
        return d.with_bent_normal(point, [&](const ShadingPoint& bent) {
          run(d.transparency_code.data(), d.transparency_code.size(), d.tables, bent, registers);
          const Values values{bent, registers, d.tables.constants.data()};
          if (!d.portals.empty() && !is_black(sum(d.portals, values))) return Color(0.0f);
          const Color total = sum(d.transparency, values);
          return d.thin_walls.empty() ? total : total + d.through_thin_walls(values);
        });
      });
}

void ShaderProgram::add_medium(const ShadingPoint& point, MediumPoint& medium) const {
  const Data& d = *data_;
  if (d.volumes.empty()) return;
  with_registers(d.register_count, [&](float* registers) {
    run_inside(d.volume_code.data(), d.volume_code.size(), d.tables, point, registers);
    add_volumes(d.volumes, registers, d.tables.constants.data(), medium);
  });
}

bool ShaderProgram::has_aovs() const { return !data_->aovs.empty(); }

void ShaderProgram::evaluate_aovs(const ShadingPoint& point, const std::function<void(const Aov&)>& show) const {
  const Data& d = *data_;
  if (d.aovs.empty()) return;
  d.with_bent_normal(point, [&](const ShadingPoint& bent) {
    with_registers(d.register_count, [&](float* registers) {
      const float* constants = d.tables.constants.data();
      run(d.aov_code.data(), d.aov_code.size(), d.tables, bent, registers);
      for (const AovOutput& aov : d.aovs)
        show({aov.name, load3(operand(aov.color, registers, constants)), *operand(aov.value, registers, constants)});
    });
  });
}

bool ShaderProgram::is_constant() const { return data_->code.empty() && data_->undisplaced_code.empty(); }
bool ShaderProgram::emits() const { return !data_->emission.empty(); }
bool ShaderProgram::emission_is_constant() const {
  return data_->emission_code.empty() && !data_->has_coated_emission();
}
bool ShaderProgram::emission_is_slow() const {
  const auto has = [&](std::initializer_list<Op> ops) {
    return std::any_of(data_->emission_code.begin(), data_->emission_code.end(),
                       [&](const Instruction& i) { return std::find(ops.begin(), ops.end(), i.op) != ops.end(); });
  };
  return has({Op::Noise, Op::NoiseColor, Op::Voronoi, Op::Wave}) &&
         !has({Op::Image, Op::ImageBox, Op::ImageOver, Op::ImageBoxOver, Op::Environment});
}
bool ShaderProgram::emission_depends_on_mesh_alone() const {
  return std::all_of(data_->emission_code.begin(), data_->emission_code.end(), [](const Instruction& i) {
    return !info(i.op).needs_point || i.op == Op::Generated || i.op == Op::ActiveUv || i.op == Op::NamedUv ||
           i.op == Op::NamedAttribute;
  });
}
bool ShaderProgram::emission_depends_on_side() const {
  return data_->has_coated_emission() ||
         std::any_of(data_->emission_code.begin(), data_->emission_code.end(), [](const Instruction& i) {
           switch (i.op) {
             case Op::ShadingNormal:
             case Op::TrueNormal:
             case Op::ObjectNormal:
             case Op::Incoming:
             case Op::ObjectIncoming:
             case Op::Backfacing:
             case Op::Reflection:
             case Op::Fresnel:
             case Op::LayerWeight:
             case Op::NormalMap:
             case Op::AmbientOcclusion:
             case Op::Raycast:
             case Op::RaycastAttribute:
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
bool ShaderProgram::has_portal() const { return !data_->portals.empty(); }
bool ShaderProgram::scatters() const { return !data_->scattering.empty(); }

bool ShaderProgram::has_subsurface() const {
  return std::any_of(data_->scattering.begin(), data_->scattering.end(), has_walk);
}

static bool is_one_of(ClosureKind kind, std::initializer_list<ClosureKind> kinds) {
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

bool ShaderProgram::enters_after_diffuse() const {
  return std::any_of(data_->scattering.begin(), data_->scattering.end(),
                     [](const Closure& closure) { return has_walk(closure) && closure.inputs.enters_after_diffuse; });
}

bool ShaderProgram::subsurface_has_normal() const { return data_->subsurface_has_normal; }

bool ShaderProgram::may_be_rough(float roughness) const {
  using enum ClosureKind;
  return may_be_rough_glossy(roughness) ||
         std::any_of(data_->scattering.begin(), data_->scattering.end(), [](const Closure& c) {
           return is_one_of(c.kind, {Diffuse, Translucent, Velvet, ToonDiffuse, Subsurface, Sheen, Principled,
                                     PrincipledHair, HairReflection, HairTransmission});
         });
}

bool ShaderProgram::may_be_rough_glossy(float roughness) const {
  using enum ClosureKind;
  return std::any_of(data_->scattering.begin(), data_->scattering.end(), [=](const Closure& c) {
    if (c.kind == ToonGlossy) return true;
    const bool rough = !c.patches.empty() ||
                       (c.inputs.roughness >= roughness && c.inputs.distribution != closures::Distribution::Sharp);
    return rough && is_one_of(c.kind, {Principled, Metallic, Glossy, Glass, Refraction});
  });
}

bool ShaderProgram::may_be_smooth(float roughness) const {
  const bool reflective = data_->reflective_caustics, refractive = data_->refractive_caustics;
  return std::any_of(data_->scattering.begin(), data_->scattering.end(), [=](const Closure& c) {
    // A colour that varies is a patch as well. Checking which inputs are patched would gain little.
    const bool smooth = !c.patches.empty() || c.inputs.roughness < roughness ||
                        c.inputs.distribution == closures::Distribution::Sharp;
    switch (c.kind) {
      case ClosureKind::Metallic:
      case ClosureKind::Glossy: return reflective && smooth;
      case ClosureKind::Refraction: return refractive && smooth;
      case ClosureKind::Glass: return (reflective || refractive) && smooth;
      case ClosureKind::Principled:
        return (reflective || refractive) && (smooth || c.inputs.clearcoat > 0.0f || c.inputs.transmission > 0.0f);
      default: return false;
    }
  });
}

ShaderProgram::ViewDependence ShaderProgram::view_dependence() const { return data_->view_dependence; }
std::vector<std::pair<int, const Texture*>> ShaderProgram::images() const {
  std::vector<std::pair<int, const Texture*>> all;
  for (const ImageLookup& lookup : data_->tables.images) all.push_back({lookup.image, lookup.texture});
  return all;
}
std::vector<SkyDisc> ShaderProgram::sky_discs() const { return data_->sky_discs; }

int ShaderProgram::register_count() const { return data_->register_count; }
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
