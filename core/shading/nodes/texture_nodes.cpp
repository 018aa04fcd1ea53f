// Texture nodes. An unlinked Vector is replaced by UV for images, by the direction or position for environments, and by
// generated coordinates for patterns.
#include "shading/functions/texture_functions.h"
#include "shading/nodes/node_type.h"

namespace ajar::nodes {
namespace {

using enum SocketType;

uint32_t image_lookup(ProgramBuilder& b, int node, bool environment) {
  if (const auto found = b.node_data.find(node); found != b.node_data.end()) return found->second;
  ImageLookup lookup;
  lookup.interpolation = std::array{
      Interpolation::Linear, Interpolation::Closest, Interpolation::Cubic,
      Interpolation::Cubic}[b.choice(node, "interpolation", {"Linear", "Closest", "Cubic", "Smart"})];
  if (!environment) {
    lookup.extension = Extension(b.choice(node, "extension", {"REPEAT", "EXTEND", "CLIP", "MIRROR"}));
    lookup.unassociate = b.is_read(node, "Alpha");
    lookup.blend = saturate(b.number(node, "projection_blend"));
  }
  const float index = b.number(node, "image", -1.0f);
  if (index < 0.0f) b.report(node, "has no image; magenta is used");
  lookup.image = index >= 0.0f && index < 1e9f ? int(index) : -1;
  lookup.texture = b.textures().load(lookup.image, b.shown_by(), b.diagnostics());
  b.tables.images.push_back(lookup);
  return b.node_data[node] = uint32_t(b.tables.images.size() - 1);
}

bool image_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int projection = b.choice(node, "projection", {"FLAT", "BOX", "SPHERE", "TUBE"});
  const auto place = [&] {
    const Value p = b.place(node, Op::ActiveUv);
    if (projection == 2) return b.emit(Op::ProjectSphere, Vector, {p});
    if (projection == 3) return b.emit(Op::ProjectTube, Vector, {p});
    return p;
  };
  const uint32_t lookup = image_lookup(b, node, false);
  Value p[3];
  const bool over = b.takes_means(*b.tables.images[lookup].texture) && b.beside(place, p);
  const Value whole = over ? b.emit(projection == 1 ? Op::ImageBoxOver : Op::ImageOver, Color, {p[0], p[1], p[2]}, 0,
                                    lookup)
                           : b.emit(projection == 1 ? Op::ImageBox : Op::Image, Color, {place()}, 0, lookup);
  value = output == "Alpha" ? b.part(whole, 3) : whole;
  return output == "Color" || output == "Alpha";
}

bool environment_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int projection = b.choice(node, "projection", {"EQUIRECTANGULAR", "MIRROR_BALL"});
  const Value direction = b.place(node, Op::Position);
  value = b.emit(Op::Environment, Color, {direction}, projection, image_lookup(b, node, true));
  return output == "Color";
}

bool checker_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const Value p = b.place(node, Op::Generated);
  value = b.emit(Op::Checker, Float, {p, b.input(node, "Scale", Float, Vec4(5.0f))});
  if (output == "Color")
    value = b.emit(Op::SelectColor, Color,
                   {value, b.input(node, "Color1", Color, Vec4(0.8f)), b.input(node, "Color2", Color, Vec4(0.2f))});
  return output == "Color" || output == "Fac";
}

bool gradient_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int kind = b.choice(node, "gradient_type",
                            {"LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL"});
  value = b.emit(Op::Gradient, Float, {b.place(node, Op::Generated)}, kind);
  return output == "Color" || output == "Fac";
}

bool sky_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  uint32_t index;
  if (const auto found = b.node_data.find(node); found != b.node_data.end()) {
    index = found->second;
  } else {
    const auto number = [&](const char* property, float fallback) { return b.number(node, property, fallback); };
    // Blender before 5.0 has NISHITA, and since then the last two.
    const int model = b.choice(node, "sky_type",
                               {"PREETHAM", "HOSEK_WILKIE", "NISHITA", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING"}, 2);
    if (model < 2) {
      const std::vector<float>* sun = b.numbers(node, "sun_direction");
      Vec3 to_sun = sun && sun->size() >= 3 ? Vec3((*sun)[0], (*sun)[1], (*sun)[2]) : Vec3(0, 0, 1);
      to_sun = is_finite(to_sun) && length_squared(to_sun) > 0.0f ? glm::normalize(to_sun) : Vec3(0, 0, 1);
      const float turbidity = number("turbidity", 2.2f);
      b.tables.skies.push_back(model == 0 ? Sky::preetham(to_sun, turbidity)
                                          : Sky::hosek_wilkie(to_sun, turbidity, number("ground_albedo", 0.3f)));
    } else {
      Atmosphere a;
      a.sun_elevation = number("sun_elevation", a.sun_elevation);
      a.sun_rotation = number("sun_rotation", a.sun_rotation);
      a.altitude = number("altitude", model == 2 ? a.altitude : 100.0f);
      a.air_density = number("air_density", a.air_density);
      a.dust_density = number("dust_density", number("aerosol_density", a.dust_density));
      a.ozone_density = number("ozone_density", a.ozone_density);
      a.sun_disc = number("sun_disc", 1.0f) != 0.0f;
      a.sun_size = number("sun_size", a.sun_size);
      a.sun_intensity = number("sun_intensity", a.sun_intensity);
      b.tables.skies.push_back(model == 2   ? Sky::nishita(a)
                               : model == 3 ? Sky::single_scattering(a)
                                            : Sky::multiple_scattering(a));
    }
    index = b.node_data[node] = uint32_t(b.tables.skies.size() - 1);
  }
  value = b.in_working_space(b.emit(Op::Sky, Color, {b.place(node, Op::Generated)}, 0, index));
  return output == "Color";
}

/// Files that cannot be used emit evenly in all directions, as in Cycles.
bool ies_texture(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  constexpr uint32_t kNoProfile = ~0u;
  if (!b.node_data.contains(node)) {
    std::string problem;
    IesProfile profile;
    if (const std::string_view unreadable = b.text(node, "unreadable"); !unreadable.empty())
      problem = unreadable;
    else if (const std::string_view text = b.text(node, "ies"); !text.empty())
      profile = IesProfile::read(text, problem);
    else
      problem = "it has no IES file";
    if (profile.empty()) {
      b.report(node, "its IES file cannot be used (" + problem + "); the light of " + b.shown_by() +
                         " is equal in all directions");
      b.node_data[node] = kNoProfile;
    } else {
      b.tables.ies_profiles.push_back(std::move(profile));
      b.node_data[node] = uint32_t(b.tables.ies_profiles.size() - 1);
    }
  }
  const uint32_t profile = b.node_data[node];
  const bool seen_from_eye = b.number(node, "seen_from_eye") != 0.0f;
  const Value direction = b.is_linked(node, "Vector") ? b.input(node, "Vector", Vector)
                          : seen_from_eye             ? b.object_incoming()
                                                      : b.object_normal();
  value = profile == kNoProfile ? b.constant(kWithoutIes) : b.emit(Op::Ies, Float, {direction}, 0, profile);
  value = b.emit(Op::Product, Float, {value, b.input(node, "Strength", Float, Vec4(1.0f))});
  return output == "Fac";
}

constexpr NodeType kNodes[] = {
    {"ShaderNodeTexImage", image_texture},     {"ShaderNodeTexEnvironment", environment_texture},
    {"ShaderNodeTexSky", sky_texture},         {"ShaderNodeTexIES", ies_texture},
    {"ShaderNodeTexChecker", checker_texture}, {"ShaderNodeTexGradient", gradient_texture},
};

}  // namespace

std::span<const NodeType> texture_nodes() { return kNodes; }

}  // namespace ajar::nodes
