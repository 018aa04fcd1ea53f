// Gabor noise (Lagae et al. 2009, "Procedural Noise using Sparse Gabor Convolution") with the same number of impulses
// in each cell and weights of -1 and 1 (Tavernier et al. 2019, "Making Gabor Noise Fast and Normalized"), and its phase
// and intensity (Tricard et al. 2019, "Procedural Phasor Noise"). The definitions are those of Blender's node.
#pragma once

#include "math/types.h"

namespace ajar::nodes {

struct GaborParameters {
  int dimensions = 2;  ///< 2 or 3
  float frequency = 2.0f;
  float anisotropy = 1.0f;                     ///< 1: all waves have the given direction. 0: any direction
  float angle = 0.25f * kPi;                   ///< of the waves, in two dimensions
  Vec3 direction{1.414214f, 1.414214f, 0.0f};  ///< of the waves, in three dimensions
};

/// x: value, y: phase, z: intensity. All are in [0, 1], apart from rare peaks of value and intensity.
Vec3 gabor(const GaborParameters& parameters, Vec3 p);

}  // namespace ajar::nodes
