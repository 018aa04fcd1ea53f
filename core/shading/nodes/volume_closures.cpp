#include "shading/nodes/volume_closures.h"

#include <algorithm>
#include <cmath>

#include "shading/functions/math_functions.h"
#include "shading/nodes/closure_tree.h"

namespace ajar {

namespace {

constexpr std::string_view kScatter = "ShaderNodeVolumeScatter", kAbsorption = "ShaderNodeVolumeAbsorption",
                           kPrincipled = "ShaderNodeVolumePrincipled", kCoefficients = "ShaderNodeVolumeCoefficients",
                           kEmission = "ShaderNodeEmission";
constexpr SocketType Float = SocketType::Float, Vector = SocketType::Color;
constexpr float kMaxExtinction = 1e12f;
constexpr float kMaxAnisotropy = 1.0f - 1e-3f;  // value of Cycles
constexpr float kMin = 1e-5f;                   // smaller densities and strengths count as 0, as in Cycles
/// The Stefan-Boltzmann constant divided by pi, times 1e-6: the scale that Cycles uses for fire.
constexpr float kBlackbodyScale = 5.670373e-8f * 1e-6f * kInvPi;

class VolumeReader {
 public:
  VolumeReader(ProgramBuilder& builder, std::vector<VolumeClosure>& closures) : b_(builder), closures_(closures) {}

  void read(int node, const std::string& output, Value weight) {
    const std::string_view type = b_.node(node).type;
    if (type == kScatter)
      scatter(node, weight);
    else if (type == kAbsorption)
      absorption(node, weight);
    else if (type == kPrincipled)
      principled(node, weight);
    else if (type == kCoefficients)
      coefficients(node, weight);
    else if (type == kEmission)
      emit(weight, b_.input(node, "Color", Vector, Vec4(1.0f)), b_.input(node, "Strength", Float, Vec4(1.0f)));
    else if (b_.catalog().value(type))
      value(node, output, weight);
    else if (type.starts_with("ShaderNodeVolume"))
      b_.report(node, "is not supported yet; this part of the volume is left out");
    else
      b_.report(node, "is not a volume shader; it has no effect in a volume");
  }

 private:
  bool is_zero(Value v) const { return v.is_constant() && !(b_.constant_value(v) > 0.0f); }

  /// Scattering by the node's phase function.
  void set_phase(int node, VolumeClosure& closure) {
    constexpr std::string_view kNoInput = "";
    constexpr struct {
      std::string_view first, second;
      float value, second_value;
    } kInputs[] = {{"Anisotropy", kNoInput, 0.0f, 0.0f},
                   {"Backscatter", "IOR", 0.1f, 1.33f},
                   {"Anisotropy", "Alpha", 0.0f, 0.5f},
                   {kNoInput, kNoInput, 0.0f, 0.0f},
                   {"Diameter", kNoInput, 20.0f, 0.0f}};
    const int phase = b_.choice(node, "phase", {"HENYEY_GREENSTEIN", "FOURNIER_FORAND", "DRAINE", "RAYLEIGH", "MIE"});
    const auto& inputs = kInputs[phase];
    closure.phase = PhaseKind(phase);
    const auto read = [&](std::string_view socket, float value) {
      return socket.empty() ? kNoOperand : b_.input(node, socket, Float, Vec4(value)).at;
    };
    closure.anisotropy = read(inputs.first, inputs.value);
    closure.shape = read(inputs.second, inputs.second_value);
  }

  void scatter(int node, Value weight) {
    const Value density = b_.input(node, "Density", Float, Vec4(1.0f));
    if (is_zero(density)) return;
    VolumeClosure closure{.kind = VolumeKind::Scatter, .weight = weight.at, .density = density.at};
    closure.color = b_.input(node, "Color", Vector, Vec4(0.8f)).at;
    set_phase(node, closure);
    closures_.push_back(closure);
  }

  void coefficients(int node, Value weight) {
    VolumeClosure closure{.kind = VolumeKind::Coefficients, .weight = weight.at};
    closure.color = b_.input(node, "Scatter Coefficients", Vector, Vec4(1.0f)).at;
    closure.second = b_.input(node, "Absorption Coefficients", Vector, Vec4(1.0f)).at;
    set_phase(node, closure);
    closures_.push_back(closure);
    emit(weight, b_.input(node, "Emission Coefficients", Vector, Vec4(0.0f)), b_.constant(1.0f));
  }

  void absorption(int node, Value weight) {
    const Value density = b_.input(node, "Density", Float, Vec4(1.0f));
    if (is_zero(density)) return;
    closures_.push_back({.kind = VolumeKind::Absorption,
                         .weight = weight.at,
                         .color = b_.input(node, "Color", Vector, Vec4(0.8f)).at,
                         .density = density.at});
  }

  /// A value times the grid that the property names, if the volume has that grid.
  Value times_grid(int node, const char* property, Value value) const {
    const std::string name(b_.text(node, property));
    if (!b_.context().has_grid(name)) return value;
    Value grid = b_.emit(Op::NamedAttribute, Vector, {}, 2, b_.add_name(name));
    if (value.type == Float) return b_.emit(Op::Product, Float, {value, b_.part(grid, 0)});
    return b_.emit(Op::VectorMath, Vector, {value, grid, b_.constant(Vec3(0.0f), Vector), b_.constant(1.0f)},
                   int(nodes::VectorOperation::Multiply));
  }

  void principled(int node, Value weight) {
    const Value density = times_grid(node, "Density Attribute", b_.input(node, "Density", Float, Vec4(1.0f)));
    if (!is_zero(density))
      closures_.push_back({.kind = VolumeKind::Principled,
                           .weight = weight.at,
                           .color = times_grid(node, "Color Attribute", b_.input(node, "Color", Vector, Vec4(0.5f))).at,
                           .second = b_.input(node, "Absorption Color", Vector, Vec4(0.0f)).at,
                           .density = density.at,
                           .anisotropy = b_.input(node, "Anisotropy", Float, Vec4(0.0f)).at});
    emit(weight, b_.input(node, "Emission Color", Vector, Vec4(1.0f)),
         b_.input(node, "Emission Strength", Float, Vec4(0.0f)));
    const Value intensity = b_.input(node, "Blackbody Intensity", Float, Vec4(0.0f));
    if (is_zero(intensity)) return;
    const Value temperature = times_grid(node, "Temperature Attribute",
                                         b_.input(node, "Temperature", Float, Vec4(1000.0f)));
    closures_.push_back({.kind = VolumeKind::Blackbody,
                         .weight = weight.at,
                         .color = b_.input(node, "Blackbody Tint", Vector, Vec4(1.0f)).at,
                         .second = b_.spectral(Op::Blackbody, temperature).at,
                         .density = intensity.at,
                         .anisotropy = temperature.at});
  }

  void value(int node, const std::string& output, Value weight) {
    const Value color = b_.output(node, output);
    if (color.type != SocketType::Closure) emit(weight, b_.convert(color, Vector), b_.constant(1.0f));
  }

  void emit(Value weight, Value color, Value strength) {
    if (is_zero(strength)) return;
    closures_.push_back(
        {.kind = VolumeKind::Emission, .weight = weight.at, .color = b_.emit(Op::Scale, Vector, {color, strength}).at});
  }

  ProgramBuilder& b_;
  std::vector<VolumeClosure>& closures_;
};

}  // namespace

bool is_volume_node(std::string_view type) {
  return type == kScatter || type == kAbsorption || type == kPrincipled || type == kCoefficients;
}

std::vector<VolumeClosure> flatten_volumes(ProgramBuilder& b) {
  std::vector<VolumeClosure> closures;
  VolumeReader reader(b, closures);
  for_each_closure(b, b.graph().volume, "volume",
                   [&](int node, const std::string& output, Value weight) { reader.read(node, output, weight); });
  return closures;
}

bool varies_inside(Op op) {
  switch (op) {
    case Op::ObjectLocation:
    case Op::ObjectColor:
    case Op::ObjectIndex:
    case Op::ObjectRandom:
    case Op::ObjectProperty:
    case Op::FromInstancer:
    case Op::LightPath:
    case Op::LightFalloff:
    case Op::Incoming:
    case Op::ObjectIncoming:
    case Op::Backfacing: return false;
    default: return info(op).needs_point;
  }
}

namespace {

/// The values of closures at a point. Values that are not numbers are counted, and are 0.
struct VolumeValues {
  const float *registers, *constants;
  MediumPoint& medium;

  float number(Operand o) const {
    const float x = *operand(o, registers, constants);
    if (std::isfinite(x)) return x;
    ++medium.refused;
    return 0.0f;
  }
  Color color(Operand o) const {
    const Color c = load3(operand(o, registers, constants));
    if (is_finite(c)) return c;
    ++medium.refused;
    return Color(0.0f);
  }
  /// The product of two numbers can be NaN: 0 times infinity.
  Color limit(Color c) const {
    for (int i = 0; i < 3; ++i)
      if (std::isnan(c[i])) ++medium.refused, c[i] = 0.0f;
    return glm::clamp(c, 0.0f, kMaxExtinction);
  }

  void add_scattering(const VolumeClosure& closure, Color amount) const {
    const auto anisotropy = [&] { return glm::clamp(number(closure.anisotropy), -kMaxAnisotropy, kMaxAnisotropy); };
    amount = limit(amount);
    switch (closure.phase) {
      case PhaseKind::HenyeyGreenstein:
        medium.add_scattering(amount, PhaseShape::henyey_greenstein(anisotropy()));
        break;
      case PhaseKind::Draine:
        medium.add_scattering(amount, PhaseShape::draine(anisotropy(), std::max(number(closure.shape), 0.0f)));
        break;
      case PhaseKind::Rayleigh: medium.add_scattering(amount, PhaseShape::rayleigh()); break;
      case PhaseKind::FournierForand:
        medium.add_scattering(amount, PhaseShape::fournier_forand(number(closure.anisotropy), number(closure.shape)));
        break;
      case PhaseKind::Mie: {
        const MieShapes shapes = mie_shapes(number(closure.anisotropy));
        medium.add_scattering(amount * (1.0f - shapes.draine_share), shapes.henyey_greenstein);
        medium.add_scattering(amount * shapes.draine_share, shapes.draine);
        break;
      }
    }
  }

  void add(const VolumeClosure& closure) const {
    const float weight = number(closure.weight);
    if (!(weight > 0.0f)) return;
    switch (closure.kind) {
      case VolumeKind::Scatter:
      case VolumeKind::Absorption:
      case VolumeKind::Principled: {
        const float density = weight * number(closure.density);
        if (!(density > 0.0f)) break;
        const Color c = color(closure.color);
        if (closure.kind != VolumeKind::Absorption) add_scattering(closure, c * density);
        if (closure.kind == VolumeKind::Absorption) medium.extinction += limit((Color(1.0f) - c) * density);
        if (closure.kind == VolumeKind::Principled) {
          const Color kept = glm::sqrt(glm::max(color(closure.second), 0.0f));
          medium.extinction += limit(glm::max(Color(1.0f) - c, 0.0f) * glm::max(Color(1.0f) - kept, 0.0f) * density);
        }
        break;
      }
      case VolumeKind::Coefficients:
        add_scattering(closure, color(closure.color) * weight);
        medium.extinction += limit(color(closure.second) * weight);
        break;
      case VolumeKind::Emission: medium.emission += limit(color(closure.color) * weight); break;
      case VolumeKind::Blackbody: {
        const float intensity = number(closure.density), t = std::max(number(closure.anisotropy), 0.0f);
        if (!(intensity > kMin)) break;
        const float radiance = kBlackbodyScale * (1.0f - intensity + intensity * sqr(sqr(t)));
        if (radiance > kMin) medium.emission += limit(color(closure.color) * color(closure.second) * radiance * weight);
        break;
      }
    }
  }
};

}  // namespace

void add_volumes(const std::vector<VolumeClosure>& closures, const float* registers, const float* constants,
                 MediumPoint& medium) {
  const VolumeValues values{registers, constants, medium};
  for (const VolumeClosure& closure : closures) values.add(closure);
}

}  // namespace ajar
