// The volume output of a graph, flattened: each volume node once, with the product of the mix factors above it as its
// weight.
//
// Definitions are Cycles': Scatter is density * colour, Absorption density * (1 - colour), Principled both, with an
// absorption of density * max(0, 1 - colour) * max(0, 1 - sqrt(absorption colour)), and emission that does not depend
// on density. Blackbody radiance is that of a surface of one millionth of its strength, per metre. Grids (smoke,
// OpenVDB) and what reads them are not known.
#pragma once

#include "shading/bsdf/medium.h"
#include "shading/program/program_builder.h"

namespace ajar {

enum class VolumeKind : uint8_t { Scatter, Absorption, Principled, Emission, Blackbody };

/// Inputs are operands, constants or not; what a kind does not have is kNoOperand.
struct VolumeClosure {
  VolumeKind kind = VolumeKind::Scatter;
  Operand weight = kNoOperand;
  Operand color = kNoOperand;       ///< scattering; absorption; emitted radiance per metre; tint of the blackbody
  Operand second = kNoOperand;      ///< Principled: absorption colour; Blackbody: colour of the temperature
  Operand density = kNoOperand;     ///< Blackbody: intensity
  Operand anisotropy = kNoOperand;  ///< Blackbody: temperature
  std::array<Operand, 5> operands() const { return {weight, color, second, density, anisotropy}; }
};

bool is_volume_node(std::string_view type);

/// All closures under the graph's volume output.
std::vector<VolumeClosure> flatten_volumes(ProgramBuilder& builder);

/// Does the instruction read where in the volume it is, and not only in whose, or along which ray?
bool varies_inside(Op op);

void add_volumes(const std::vector<VolumeClosure>& closures, const float* registers, const float* constants,
                 MediumPoint& medium);

}  // namespace ajar
