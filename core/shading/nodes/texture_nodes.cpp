// Texture nodes. An unlinked Vector means: UV for pictures, the direction or position for environments,
// generated coordinates for patterns.
#include "shading/node_registry.h"
#include "shading/nodes/texture_functions.h"

namespace ajar::nodes {
namespace {

using enum SocketType;

Value coordinate(ProgramBuilder& b, int node, Op unlinked) {
  return b.is_linked(node, "Vector") ? b.input(node, "Vector", Vector) : b.emit(unlinked, Vector, {});
}

uint32_t image_lookup(ProgramBuilder& b, int node, bool environment) {
  if (const auto found = b.node_data.find(node); found != b.node_data.end()) return found->second;
  ImageLookup lookup;
  lookup.interpolation = std::array{Interpolation::Linear, Interpolation::Closest, Interpolation::Cubic,
                                    Interpolation::Cubic}[b.choice(node, "interpolation",
                                                                   {"Linear", "Closest", "Cubic", "Smart"})];
  if (!environment) {
    lookup.extension = Extension(b.choice(node, "extension", {"REPEAT", "EXTEND", "CLIP", "MIRROR"}));
    lookup.unassociate = b.is_read(node, "Alpha");
    lookup.blend = saturate(b.number(node, "projection_blend"));
  }
  const float index = b.number(node, "image", -1.0f);
  if (index < 0.0f) b.report(node, "has no image; magenta is used");
  lookup.texture = b.textures().load(index >= 0.0f && index < 1e9f ? int(index) : -1, "", b.diagnostics());
  b.tables.images.push_back(lookup);
  return b.node_data[node] = uint32_t(b.tables.images.size() - 1);
}

bool image_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int projection = b.choice(node, "projection", {"FLAT", "BOX", "SPHERE", "TUBE"});
  Value p = coordinate(b, node, Op::ActiveUv);
  if (projection == 2) p = b.emit(Op::ProjectSphere, Vector, {p});
  if (projection == 3) p = b.emit(Op::ProjectTube, Vector, {p});
  const uint32_t lookup = image_lookup(b, node, false);
  const Value whole = b.emit(projection == 1 ? Op::ImageBox : Op::Image, Color, {p}, 0, lookup);
  value = output == "Alpha" ? b.part(whole, 3) : whole;
  return output == "Color" || output == "Alpha";
}

bool environment_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int projection = b.choice(node, "projection", {"EQUIRECTANGULAR", "MIRROR_BALL"});
  const Value direction = coordinate(b, node, Op::Position);
  value = b.emit(Op::Environment, Color, {direction}, projection, image_lookup(b, node, true));
  return output == "Color";
}

bool checker_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const Value p = coordinate(b, node, Op::Generated);
  value = b.emit(Op::Checker, Float, {p, b.input(node, "Scale", Float, Vec4(5.0f))});
  if (output == "Color")
    value = b.emit(Op::SelectColor, Color, {value, b.input(node, "Color1", Color, Vec4(0.8f)),
                                            b.input(node, "Color2", Color, Vec4(0.2f))});
  return output == "Color" || output == "Fac";
}

bool gradient_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int kind = b.choice(node, "gradient_type", {"LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL",
                                                    "QUADRATIC_SPHERE", "RADIAL"});
  value = b.emit(Op::Gradient, Float, {coordinate(b, node, Op::Generated)}, kind);
  return output == "Color" || output == "Fac";
}

constexpr NodeType kNodes[] = {
    {"ShaderNodeTexImage", image_texture},
    {"ShaderNodeTexEnvironment", environment_texture},
    {"ShaderNodeTexChecker", checker_texture},
    {"ShaderNodeTexGradient", gradient_texture},
};

}  // namespace

std::span<const NodeType> texture_nodes() { return kNodes; }

}  // namespace ajar::nodes
