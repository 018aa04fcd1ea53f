#include "shading/nodes/closure_nodes.h"

#include <cstddef>

#include "shading/nodes/closure_tree.h"
#include "shading/nodes/closure_writer.h"
#include "shading/nodes/hair_closures.h"
#include "shading/nodes/node_type.h"
#include "shading/nodes/volume_closures.h"

namespace ajar::nodes {
namespace {

constexpr SocketType Float = SocketType::Float, Vector = SocketType::Vector, Color = SocketType::Color;
using Inputs = closures::PrincipledInputs;
using closures::Distribution;

Distribution distribution(ProgramBuilder& b, int node, Distribution fallback) {
  const int choice = b.choice(node, "distribution", {"SHARP", "GGX", "BECKMANN", "MULTI_GGX", "ASHIKHMIN_SHIRLEY"},
                              int(fallback));
  return Distribution(choice);
}
static_assert(int(Distribution::Sharp) == 0 && int(Distribution::AshikhminShirley) == 4);

/// Whether the exporter asks for the facets of Blender 4.0 and later.
bool has_correlated_facets(ProgramBuilder& b, int node) {
  return b.choice(node, "facets", {"SEPARABLE", "CORRELATED"}) == 1;
}

void thin_film(ClosureWriter& w) {
  w.number(offsetof(Inputs, film.thickness), "Thin Film Thickness", 0.0f);
  w.number(offsetof(Inputs, film.ior), "Thin Film IOR", 1.33f);
}

/// The normal of a closure that is not bent towards the eye since Blender 4.0.
void kept_normal(ProgramBuilder& b, int node, ClosureWriter& w) {
  w.closure.inputs.keeps_normal = b.number(node, "keeps_normal") != 0.0f;
  w.normal("Normal", w.closure.normal);
}

void diffuse(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  ClosureWriter w(b, node, ClosureKind::Diffuse, weight);
  w.color(offsetof(Inputs, base_color), "Color", ::ajar::Color(0.8f));
  w.number(offsetof(Inputs, roughness), "Roughness", 0.0f);
  w.closure.inputs.multiple_scattering = b.number(node, "multiple_scattering") != 0.0f;
  kept_normal(b, node, w);
  out.push_back(std::move(w.closure));
}

void glossy(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  ClosureWriter w(b, node, ClosureKind::Glossy, weight);
  w.closure.inputs.distribution = distribution(b, node, Distribution::Ggx);
  w.closure.inputs.correlated = has_correlated_facets(b, node);
  w.color(offsetof(Inputs, base_color), "Color", ::ajar::Color(0.8f));
  w.number(offsetof(Inputs, roughness), "Roughness", 0.5f);
  const Value anisotropy = w.number(offsetof(Inputs, anisotropic), "Anisotropy", 0.0f);
  w.number(offsetof(Inputs, anisotropic_rotation), "Rotation", 0.0f);
  w.normal("Normal", w.closure.normal);
  w.tangent(anisotropy);
  out.push_back(std::move(w.closure));
}

template <ClosureKind kKind>
void dielectric(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  ClosureWriter w(b, node, kKind, weight);
  w.closure.inputs.distribution = distribution(b, node, Distribution::Beckmann);
  w.closure.inputs.correlated = has_correlated_facets(b, node);
  w.color(offsetof(Inputs, base_color), "Color", ::ajar::Color(1.0f));
  w.number(offsetof(Inputs, roughness), "Roughness", 0.0f);
  w.number(offsetof(Inputs, ior), "IOR", 1.45f);
  if constexpr (kKind == ClosureKind::Glass) thin_film(w);
  w.normal("Normal", w.closure.normal);
  out.push_back(std::move(w.closure));
}

void translucent(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  ClosureWriter w(b, node, ClosureKind::Translucent, weight);
  w.color(offsetof(Inputs, base_color), "Color", ::ajar::Color(0.8f));
  w.normal("Normal", w.closure.normal);
  out.push_back(std::move(w.closure));
}

/// Cloth as microfacets, `sigma` is the socket of its width.
void velvet_with(ProgramBuilder& b, int node, const char* sigma, Value weight, std::vector<Closure>& out) {
  ClosureWriter w(b, node, ClosureKind::Velvet, weight);
  w.color(offsetof(Inputs, base_color), "Color", ::ajar::Color(0.8f));
  w.number(offsetof(Inputs, roughness), sigma, 1.0f);
  kept_normal(b, node, w);
  out.push_back(std::move(w.closure));
}
void velvet(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  velvet_with(b, node, "Sigma", weight, out);
}

void sheen(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  if (b.choice(node, "distribution", {"MICROFIBER", "ASHIKHMIN"}) == 1) {
    velvet_with(b, node, "Roughness", weight, out);
    return;
  }
  ClosureWriter w(b, node, ClosureKind::Sheen, weight);
  w.color(offsetof(Inputs, base_color), "Color", ::ajar::Color(0.8f));
  w.number(offsetof(Inputs, roughness), "Roughness", 0.5f);
  kept_normal(b, node, w);
  out.push_back(std::move(w.closure));
}

void metallic(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  ClosureWriter w(b, node, ClosureKind::Metallic, weight);
  Inputs& inputs = w.closure.inputs;
  inputs.distribution = distribution(b, node, Distribution::MultiGgx);
  inputs.correlated = true;
  inputs.is_conductor = b.choice(node, "fresnel_type", {"F82", "PHYSICAL_CONDUCTOR"}) == 1;
  if (inputs.is_conductor) {
    w.set(offsetof(Inputs, base_color), b.input(node, "IOR", Vector, Vec4(2.757f, 2.513f, 2.231f, 0.0f)), 3);
    w.set(offsetof(Inputs, specular_tint_color),
          b.input(node, "Extinction", Vector, Vec4(3.867f, 3.404f, 3.009f, 0.0f)), 3);
  } else {
    w.color(offsetof(Inputs, base_color), "Base Color", ::ajar::Color(0.617f, 0.577f, 0.54f));
    w.color(offsetof(Inputs, specular_tint_color), "Edge Tint", ::ajar::Color(0.695f, 0.726f, 0.77f));
  }
  w.number(offsetof(Inputs, roughness), "Roughness", 0.5f);
  const Value anisotropy = w.number(offsetof(Inputs, anisotropic), "Anisotropy", 0.0f);
  w.number(offsetof(Inputs, anisotropic_rotation), "Rotation", 0.0f);
  thin_film(w);
  w.normal("Normal", w.closure.normal);
  w.tangent(anisotropy);
  out.push_back(std::move(w.closure));
}

void toon(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  const bool glossy = b.choice(node, "component", {"DIFFUSE", "GLOSSY"}) == 1;
  ClosureWriter w(b, node, glossy ? ClosureKind::ToonGlossy : ClosureKind::ToonDiffuse, weight);
  w.color(offsetof(Inputs, base_color), "Color", ::ajar::Color(0.8f));
  w.number(offsetof(Inputs, roughness), "Size", 0.5f);
  w.number(offsetof(Inputs, transmission_roughness), "Smooth", 0.0f);
  kept_normal(b, node, w);
  out.push_back(std::move(w.closure));
}

/// Sets the method of subsurface scattering. Random Walk has had three meanings; the exporter names the one of its
/// Blender in the property `random_walk`.
void set_subsurface_method(ProgramBuilder& b, int node, std::string_view property, Inputs& inputs) {
  using Method = closures::SubsurfaceMethod;
  constexpr Method kMethods[] = {Method::RandomWalk, Method::FixedRadius, Method::Burley, Method::Skin,
                                 Method::RefractedFixedRadius};
  const int choice = b.choice(
      node, property, {"RANDOM_WALK", "RANDOM_WALK_FIXED_RADIUS", "BURLEY", "RANDOM_WALK_SKIN", "RANDOM_WALK_LEGACY"});
  inputs.subsurface_method = kMethods[choice];
  if (choice == 0) {
    constexpr Method kGenerations[] = {Method::RandomWalk, Method::RefractedFixedRadius, Method::Refracted};
    inputs
        .subsurface_method = kGenerations[b.choice(node, "random_walk", {"DIPOLE", "FIXED_RADIUS", "MEAN_FREE_PATH"})];
  }
  inputs.enters_after_diffuse = b.number(node, "enters_after_diffuse") != 0.0f && b.text(node, property) != "BURLEY";
}

void subsurface(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  ClosureWriter w(b, node, ClosureKind::Subsurface, weight);
  set_subsurface_method(b, node, "falloff", w.closure.inputs);
  w.color(offsetof(Inputs, base_color), "Color", ::ajar::Color(0.8f));
  w.set(offsetof(Inputs, subsurface_radius), b.input(node, "Radius", Vector, Vec4(1.0f, 0.2f, 0.1f, 0.0f)), 3);
  w.number(offsetof(Inputs, subsurface_scale), "Scale", 1.0f);
  w.number(offsetof(Inputs, subsurface_ior), "IOR", 1.4f);
  w.number(offsetof(Inputs, roughness), "Roughness", 1.0f);
  w.number(offsetof(Inputs, subsurface_anisotropy), "Anisotropy", 0.0f);
  w.normal("Normal", w.closure.normal);
  out.push_back(std::move(w.closure));
}

void add_colored(ProgramBuilder& b, ClosureKind kind, int node, Value color, Value weight, std::vector<Closure>& out) {
  if (color.is_constant() && max_component(b.constant_vector(color)) <= 0.0f) return;
  ClosureWriter w(b, node, kind, weight);
  w.set(offsetof(Inputs, base_color), color, 3);
  out.push_back(std::move(w.closure));
}

void transparent(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  add_colored(b, ClosureKind::Transparent, node, b.input(node, "Color", Color, Vec4(1.0f)), weight, out);
}

void ray_portal(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  const Value color = b.input(node, "Color", Color, Vec4(1.0f));
  if (color.is_constant() && max_component(b.constant_vector(color)) <= 0.0f) return;
  ClosureWriter w(b, node, ClosureKind::RayPortal, weight);
  w.set(offsetof(Inputs, base_color), color, 3);
  const Value position = b.is_linked(node, "Position") ? b.input(node, "Position", Vector)
                                                       : b.emit(Op::Position, Vector, {});
  w.set(offsetof(Inputs, clearcoat_normal), position, 3);
  w.set(offsetof(Inputs, tangent), b.input(node, "Direction", Vector, Vec4(0.0f)), 3);
  out.push_back(std::move(w.closure));
}

void emission(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  const Value strength = b.input(node, "Strength", Float, Vec4(1.0f));
  if (strength.is_constant() && b.constant_value(strength) <= 0.0f) return;
  const Value color = b.input(node, "Color", Color, Vec4(1.0f));
  add_colored(b, ClosureKind::Emission, node, b.emit(Op::Scale, Color, {color, strength}), weight, out);
}

void holdout(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  out.push_back(ClosureWriter(b, node, ClosureKind::Holdout, weight).closure);
}

bool is_second_generation(const Node& node) {
  for (const NodeInput& input : node.inputs)
    if (input.socket == "Coat Weight" || input.socket == "Specular IOR Level" || input.socket == "Emission Color")
      return true;
  return false;
}

/// Emission below the coat of this Principled closure, whose inputs it shares except for the colour.
void add_coated_emission(const Closure& principled, Value emitted, ProgramBuilder& b, std::vector<Closure>& out) {
  if (emitted.is_constant() && max_component(b.constant_vector(emitted)) <= 0.0f) return;
  Closure closure = principled;
  closure.kind = ClosureKind::CoatedEmission;
  std::erase_if(closure.patches, [](const InputPatch& patch) { return patch.offset == offsetof(Inputs, base_color); });
  if (emitted.is_constant())
    closure.inputs.base_color = b.constant_vector(emitted);
  else
    closure.patches.push_back({offsetof(Inputs, base_color), 3, emitted.at});
  out.push_back(std::move(closure));
}

/// Blender 4.0 renamed half of the sockets and changed the meaning of some.
void principled(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  const bool v2 = is_second_generation(b.node(node));

  // Alpha mixes the whole node, including its emission, with transparency.
  const Value alpha = b.clamped(b.input(node, "Alpha", Float, Vec4(1.0f)));
  const Value through = b.emit(Op::ProductInverse, Float, {weight, alpha});
  if (!through.is_constant() || b.constant_value(through) > 0.0f)
    add_colored(b, ClosureKind::Transparent, node, b.constant(Vec3(1.0f), Color), through, out);
  weight = b.emit(Op::Product, Float, {weight, alpha});
  if (weight.is_constant() && b.constant_value(weight) == 0.0f) return;

  ClosureWriter w(b, node, ClosureKind::Principled, weight);
  w.closure.inputs.version = v2 ? 2 : 1;
  w.closure.inputs.keeps_normal = v2;
  w.closure.inputs.distribution = distribution(b, node, v2 ? Distribution::MultiGgx : Distribution::Ggx);
  w.color(offsetof(Inputs, base_color), "Base Color", ::ajar::Color(0.8f));
  w.number(offsetof(Inputs, metallic), "Metallic", 0.0f);
  w.number(offsetof(Inputs, roughness), "Roughness", 0.5f);
  w.number(offsetof(Inputs, ior), "IOR", v2 ? 1.5f : 1.45f);
  w.number(offsetof(Inputs, transmission), v2 ? "Transmission Weight" : "Transmission", 0.0f);
  const Value anisotropy = w.number(offsetof(Inputs, anisotropic), "Anisotropic", 0.0f);
  w.number(offsetof(Inputs, anisotropic_rotation), "Anisotropic Rotation", 0.0f);
  const Value coat = w.number(offsetof(Inputs, clearcoat), v2 ? "Coat Weight" : "Clearcoat", 0.0f);
  w.number(offsetof(Inputs, clearcoat_roughness), v2 ? "Coat Roughness" : "Clearcoat Roughness", 0.03f);
  const Value sheen_weight = w.number(offsetof(Inputs, sheen), v2 ? "Sheen Weight" : "Sheen", 0.0f);
  if (v2) {
    w.number(offsetof(Inputs, diffuse_roughness), "Diffuse Roughness", 0.0f);
    w.number(offsetof(Inputs, specular_ior_level), "Specular IOR Level", 0.5f);
    w.color(offsetof(Inputs, specular_tint_color), "Specular Tint", ::ajar::Color(1.0f));
    w.number(offsetof(Inputs, sheen_roughness), "Sheen Roughness", 0.5f);
    w.color(offsetof(Inputs, sheen_tint_color), "Sheen Tint", ::ajar::Color(1.0f));
    w.number(offsetof(Inputs, coat_ior), "Coat IOR", 1.5f);
    w.color(offsetof(Inputs, coat_tint), "Coat Tint", ::ajar::Color(1.0f));
    w.number(offsetof(Inputs, thin_wall), "Thin Wall", 0.0f);
    thin_film(w);
    w.closure.inputs.film_on_metal = b.number(node, "film_on_metal", 1.0f) != 0.0f;
  } else {
    w.number(offsetof(Inputs, specular), "Specular", 0.5f);
    w.number(offsetof(Inputs, specular_tint), "Specular Tint", 0.0f);
    w.number(offsetof(Inputs, sheen_tint), "Sheen Tint", 0.5f);
    w.number(offsetof(Inputs, transmission_roughness), "Transmission Roughness", 0.0f);
    w.color(offsetof(Inputs, subsurface_color), "Subsurface Color", ::ajar::Color(0.8f));
  }
  w.number(offsetof(Inputs, subsurface), v2 ? "Subsurface Weight" : "Subsurface", 0.0f);
  w.set(offsetof(Inputs, subsurface_radius), b.input(node, "Subsurface Radius", Vector, Vec4(1.0f, 0.2f, 0.1f, 0.0f)),
        3);
  w.number(offsetof(Inputs, subsurface_scale), "Subsurface Scale", v2 ? 0.05f : 1.0f);
  w.number(offsetof(Inputs, subsurface_ior), "Subsurface IOR", 1.4f);
  w.number(offsetof(Inputs, subsurface_anisotropy), "Subsurface Anisotropy", 0.0f);
  set_subsurface_method(b, node, "subsurface_method", w.closure.inputs);
  w.normal("Normal", w.closure.normal);
  w.normal(v2 ? "Coat Normal" : "Clearcoat Normal", w.closure.coat_normal);
  w.tangent(anisotropy);

  const Value strength = b.input(node, "Emission Strength", Float, Vec4(v2 ? 0.0f : 1.0f));
  if (!strength.is_constant() || b.constant_value(strength) > 0.0f) {
    const Value emitted = b.emit(
        Op::Scale, Color,
        {b.input(node, v2 ? "Emission Color" : "Emission", Color, v2 ? Vec4(1.0f) : Vec4(0.0f)), strength});
    const bool is_coated = v2 && (may_be_positive(b, coat) || may_be_positive(b, sheen_weight));
    if (is_coated)
      add_coated_emission(w.closure, emitted, b, out);
    else
      add_colored(b, ClosureKind::Emission, node, emitted, weight, out);
  }
  out.push_back(std::move(w.closure));
}

struct ClosureType {
  std::string_view name;
  ClosureFunction function;
};
constexpr ClosureType kNodes[] = {
    {"ShaderNodeBsdfPrincipled", principled},
    {"ShaderNodeBsdfDiffuse", diffuse},
    {"ShaderNodeBsdfGlossy", glossy},
    {"ShaderNodeBsdfAnisotropic", glossy},
    {"ShaderNodeBsdfGlass", dielectric<ClosureKind::Glass>},
    {"ShaderNodeBsdfRefraction", dielectric<ClosureKind::Refraction>},
    {"ShaderNodeBsdfTranslucent", translucent},
    {"ShaderNodeBsdfTransparent", transparent},
    {"ShaderNodeBsdfVelvet", velvet},
    {"ShaderNodeBsdfToon", toon},
    {"ShaderNodeBsdfMetallic", metallic},
    {"ShaderNodeBsdfSheen", sheen},
    {"ShaderNodeBsdfHair", hair},
    {"ShaderNodeBsdfHairPrincipled", principled_hair},
    {"ShaderNodeSubsurfaceScattering", subsurface},
    {"ShaderNodeBsdfRayPortal", ray_portal},
    {"ShaderNodeEmission", emission},
    {"ShaderNodeBackground", emission},
    {"ShaderNodeHoldout", holdout},
};

/// A diffuse closure with the colour socket of the node, or grey.
void unknown_closure(ProgramBuilder& b, int node, Value weight, std::vector<Closure>& out) {
  const char* socket = nullptr;
  for (const NodeInput& input : b.node(node).inputs)
    if (input.socket == "Color" || input.socket == "Base Color")
      socket = input.socket == "Color" ? "Color" : "Base Color";
  b.report(node, socket ? std::string("is not supported yet; rendered as diffuse of its '") + socket + "'"
                        : std::string("is not supported yet; rendered as grey diffuse"));
  ClosureWriter w(b, node, ClosureKind::Diffuse, weight);
  w.closure.inputs.roughness = 0.0f;
  w.color(offsetof(Inputs, base_color), socket ? socket : "", ::ajar::Color(0.8f));
  w.normal("Normal", w.closure.normal);
  out.push_back(std::move(w.closure));
}

}  // namespace

ClosureFunction find_closure_node(std::string_view type) {
  for (const ClosureType& known : kNodes)
    if (known.name == type) return known.function;
  return nullptr;
}

void add_closures(ProgramBuilder& b, int node, const std::string& output, Value weight,
                  std::vector<Closure>& closures) {
  if (const ClosureFunction function = find_closure_node(b.node(node).type)) {
    function(b, node, weight, closures);
  } else if (b.catalog().value(b.node(node).type)) {
    const Value value = b.output(node, output);
    if (value.type != SocketType::Closure)
      add_colored(b, ClosureKind::Emission, node, b.convert(value, Color), weight, closures);
  } else if (is_volume_node(b.node(node).type)) {
    b.report(node, "is a volume shader; it has no effect on a surface");
  } else {
    unknown_closure(b, node, weight, closures);
  }
}

std::vector<Closure> flatten_closures(ProgramBuilder& b) {
  std::vector<Closure> closures;
  for_each_closure(b, b.graph().surface, "surface", [&](int node, const std::string& output, Value weight) {
    add_closures(b, node, output, weight, closures);
  });
  for (Closure& closure : closures) make_valid(closure.inputs);
  return closures;
}

}  // namespace ajar::nodes
