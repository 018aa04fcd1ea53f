// Gradient noise (Perlin 2002) in one to four dimensions, and sums of its octaves: fractional Brownian motion and
// Musgrave's multifractals (Ebert et al., Texturing and Modeling, 3rd ed., chapter 16). Gradients, scales and offsets
// are those of Blender's nodes.
#pragma once

#include "math/types.h"

namespace ajar::nodes {

enum class Fractal : uint8_t { Multifractal, Fbm, HybridMultifractal, RidgedMultifractal, HeteroTerrain };

struct NoiseParameters {
  int dimensions = 3;
  Fractal fractal = Fractal::Fbm;
  bool normalize = true;     ///< fbm only: the sum is scaled to [0, 1]
  float octaves = 1.0f;      ///< the fractional part is the weight of the last octave
  float persistence = 0.5f;  ///< amplitude of an octave divided by that of the previous one
  float lacunarity = 2.0f;   ///< frequency of an octave divided by that of the previous one
  float offset = 0.0f, gain = 1.0f, distortion = 0.0f;
};

float noise_value(const NoiseParameters& parameters, Vec3 p, float w);
/// Three noises at distant positions. The first is noise_value.
Color noise_color(const NoiseParameters& parameters, Vec3 p, float w);
/// fbm in three dimensions, in [0, 1].
float normalized_fbm(Vec3 p, float octaves, float persistence);

}  // namespace ajar::nodes
