// Voronoi cells around one random point per unit cell (Worley 1996): distances to the nearest points or edges in one to
// four dimensions, smooth minima and octaves. The definitions are those of Blender's node.
#pragma once

#include "math/types.h"

namespace ajar::nodes {

enum class VoronoiFeature : uint8_t { F1, F2, SmoothF1, DistanceToEdge, NSphereRadius };
enum class VoronoiMetric : uint8_t { Euclidean, Manhattan, Chebychev, Minkowski };

/// Blender 3.x has one octave and a maximum distance of 8 cells. 4.x has octaves. 5.x has other random points.
enum class VoronoiGeneration : uint8_t { First, Second, Third };

struct VoronoiParameters {
  int dimensions = 3;
  VoronoiFeature feature = VoronoiFeature::F1;
  VoronoiMetric metric = VoronoiMetric::Euclidean;
  bool normalize = false;
  VoronoiGeneration generation = VoronoiGeneration::Second;
  float scale = 1.0f;  ///< factor by which the position was multiplied; positions are divided by it
  float smoothness = 1.0f, exponent = 0.5f, randomness = 1.0f;
  float detail = 0.0f, roughness = 0.5f, lacunarity = 2.0f;  ///< octaves after the first, their amplitude and frequency
};

struct VoronoiResult {
  float distance = 0.0f;  ///< distance, or the radius for NSphereRadius
  Color color{0.0f};
  Vec4 position{0.0f};  ///< w is the output W
};

VoronoiResult voronoi(const VoronoiParameters& parameters, Vec3 p, float w);

}  // namespace ajar::nodes
