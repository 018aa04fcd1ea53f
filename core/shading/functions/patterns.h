// Patterns that are given by formulas: waves, magic, bricks. Also the colour of a wavelength. The definitions are
// Blender's, as in Cycles.
#pragma once

#include "math/types.h"

namespace ajar {

/// The node whose inputs a noise instruction has: the Noise of Blender 3.x, the Musgrave of Blender 3.x (whose
/// roughness is the exponent "dimension"), or the Noise of Blender 4.x.
enum class NoiseGeneration : uint8_t { First, Musgrave, Second };

}  // namespace ajar

namespace ajar::nodes {

enum class WaveAxis : uint8_t { X, Y, Z, All };  ///< All: for bands the diagonal, for rings a sphere
enum class WaveProfile : uint8_t { Sine, Saw, Triangle };

struct WaveParameters {
  bool rings = false;
  WaveAxis axis = WaveAxis::X;
  WaveProfile profile = WaveProfile::Sine;
  float distortion = 0.0f, detail = 2.0f /* 0 to 15 */, detail_scale = 1.0f, detail_roughness = 0.5f, phase = 0.0f;
};
float wave(const WaveParameters& parameters, Vec3 p);

/// Sines of sines, nested `depth` times (0 to 10).
Color magic(Vec3 p, float scale, int depth, float distortion);

struct BrickParameters {
  float mortar_size = 0.02f, mortar_smooth = 0.1f, bias = 0.0f;
  float width = 0.5f, row_height = 0.25f;
  float offset = 0.5f, squash = 1.0f;  ///< of every offset_frequency-th and every squash_frequency-th row
  int offset_frequency = 2, squash_frequency = 2;
};
/// x: the share of the second colour in the brick. y: the share of mortar.
Vec2 brick(const BrickParameters& parameters, Vec3 p);

Color wavelength(float nanometres, bool clip = true);

}  // namespace ajar::nodes
