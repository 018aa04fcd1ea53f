#include "shading/nodes/volume_closures.h"

#include <algorithm>
#include <cmath>

#include "shading/nodes/closure_tree.h"

namespace ajar {

namespace {

constexpr std::string_view kScatter = "ShaderNodeVolumeScatter", kAbsorption = "ShaderNodeVolumeAbsorption",
                           kPrincipled = "ShaderNodeVolumePrincipled", kEmission = "ShaderNodeEmission";
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

  void scatter(int node, Value weight) {
    const Value density = b_.input(node, "Density", Float, Vec4(1.0f));
    if (is_zero(density)) return;
    closures_.push_back({VolumeKind::Scatter, weight.at, b_.input(node, "Color", Vector, Vec4(0.8f)).at, kNoOperand,
                         density.at, b_.input(node, "Anisotropy", Float, Vec4(0.0f)).at});
  }

  void absorption(int node, Value weight) {
    const Value density = b_.input(node, "Density", Float, Vec4(1.0f));
    if (is_zero(density)) return;
    closures_.push_back({VolumeKind::Absorption, weight.at, b_.input(node, "Color", Vector, Vec4(0.8f)).at, kNoOperand,
                         density.at, kNoOperand});
  }

  void principled(int node, Value weight) {
    const Value density = b_.input(node, "Density", Float, Vec4(1.0f));
    if (!is_zero(density))
      closures_.push_back({VolumeKind::Principled, weight.at, b_.input(node, "Color", Vector, Vec4(0.5f)).at,
                           b_.input(node, "Absorption Color", Vector, Vec4(0.0f)).at, density.at,
                           b_.input(node, "Anisotropy", Float, Vec4(0.0f)).at});
    emit(weight, b_.input(node, "Emission Color", Vector, Vec4(1.0f)),
         b_.input(node, "Emission Strength", Float, Vec4(0.0f)));
    const Value intensity = b_.input(node, "Blackbody Intensity", Float, Vec4(0.0f));
    if (is_zero(intensity)) return;
    const Value temperature = b_.input(node, "Temperature", Float, Vec4(1000.0f));
    closures_.push_back({VolumeKind::Blackbody, weight.at, b_.input(node, "Blackbody Tint", Vector, Vec4(1.0f)).at,
                         b_.spectral(Op::Blackbody, temperature).at, intensity.at, temperature.at});
  }

  void value(int node, const std::string& output, Value weight) {
    const Value color = b_.output(node, output);
    if (color.type != SocketType::Closure) emit(weight, b_.convert(color, Vector), b_.constant(1.0f));
  }

  void emit(Value weight, Value color, Value strength) {
    if (is_zero(strength)) return;
    closures_.push_back({VolumeKind::Emission, weight.at, b_.emit(Op::Scale, Vector, {color, strength}).at, kNoOperand,
                         kNoOperand, kNoOperand});
  }

  ProgramBuilder& b_;
  std::vector<VolumeClosure>& closures_;
};

}  // namespace

bool is_volume_node(std::string_view type) { return type == kScatter || type == kAbsorption || type == kPrincipled; }

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
    case Op::LightPath:
    case Op::LightFalloff:
    case Op::Incoming:
    case Op::Backfacing: return false;
    default: return info(op).needs_point;
  }
}

void add_volumes(const std::vector<VolumeClosure>& closures, const float* registers, const float* constants,
                 MediumPoint& medium) {
  const auto number = [&](Operand o) {
    const float x = *operand(o, registers, constants);
    if (std::isfinite(x)) return x;
    ++medium.refused;
    return 0.0f;
  };
  const auto color = [&](Operand o) {
    Color c = load3(operand(o, registers, constants));
    if (!is_finite(c)) {
      ++medium.refused;
      c = Color(0.0f);
    }
    return c;
  };
  // The product of two numbers can be NaN: 0 times infinity.
  const auto limit = [&](Color c) {
    for (int i = 0; i < 3; ++i)
      if (std::isnan(c[i])) ++medium.refused, c[i] = 0.0f;
    return glm::clamp(c, 0.0f, kMaxExtinction);
  };
  for (const VolumeClosure& closure : closures) {
    const float weight = number(closure.weight);
    if (!(weight > 0.0f)) continue;
    switch (closure.kind) {
      case VolumeKind::Scatter:
      case VolumeKind::Absorption:
      case VolumeKind::Principled: {
        const float density = weight * number(closure.density);
        if (!(density > 0.0f)) break;
        const Color c = color(closure.color);
        if (closure.kind != VolumeKind::Absorption)
          medium.add_scattering(limit(c * density),
                                glm::clamp(number(closure.anisotropy), -kMaxAnisotropy, kMaxAnisotropy));
        if (closure.kind == VolumeKind::Absorption) medium.extinction += limit((Color(1.0f) - c) * density);
        if (closure.kind == VolumeKind::Principled) {
          const Color kept = glm::sqrt(glm::max(color(closure.second), 0.0f));
          medium.extinction += limit(glm::max(Color(1.0f) - c, 0.0f) * glm::max(Color(1.0f) - kept, 0.0f) * density);
        }
        break;
      }
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
}

}  // namespace ajar
