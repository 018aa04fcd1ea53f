// The volume output of a graph, as a list. Each volume node occurs once; its weight is the product of the mix factors
// above it.
//
// The definitions are those of Cycles:
// - Scatter: scattering of density * colour.
// - Absorption: absorption of density * (1 - colour).
// - Principled: scattering of density * colour, absorption of density * max(0, 1 - colour) * max(0, 1 - sqrt(absorption
//   colour)), and emission that does not depend on the density.
// - Coefficients (Blender 5): scattering and absorption per metre.
// - Blackbody: the radiance per metre is that of a surface, times 1e-6 and the strength.
//
// Principled multiplies its density, colour and temperature by the grids that it names, if the volume has them.
#pragma once

#include "shading/media/medium.h"
#include "shading/program/program_builder.h"

namespace ajar {

enum class VolumeKind : uint8_t { Scatter, Absorption, Principled, Coefficients, Emission, Blackbody };
/// Of scattering. The order is that of VolumeReader::set_phase.
enum class PhaseKind : uint8_t { HenyeyGreenstein, FournierForand, Draine, Rayleigh, Mie };

/// The inputs are operands, constant or not. Inputs that a kind does not have are kNoOperand.
struct VolumeClosure {
  VolumeKind kind = VolumeKind::Scatter;
  PhaseKind phase = PhaseKind::HenyeyGreenstein;
  Operand weight = kNoOperand;
  Operand color = kNoOperand;       ///< of scattering or absorption; emitted radiance per metre; tint of the blackbody
  Operand second = kNoOperand;      ///< Principled: absorption colour; Coefficients: absorption; Blackbody: its colour
  Operand density = kNoOperand;     ///< Blackbody: intensity
  Operand anisotropy = kNoOperand;  ///< Fournier-Forand: backscatter; Mie: diameter; Blackbody: temperature
  Operand shape = kNoOperand;       ///< Draine: alpha; Fournier-Forand: index of refraction
  std::array<Operand*, 6> operands() { return {&weight, &color, &second, &density, &anisotropy, &shape}; }
};

bool is_volume_node(std::string_view type);

/// All closures below the graph's volume output.
std::vector<VolumeClosure> flatten_volumes(ProgramBuilder& builder);

/// Returns true if the instruction reads the position inside the volume. Instructions that read only the object or the
/// ray return false.
bool varies_inside(Op op);

void add_volumes(const std::vector<VolumeClosure>& closures, const float* registers, const float* constants,
                 MediumPoint& medium);

}  // namespace ajar
