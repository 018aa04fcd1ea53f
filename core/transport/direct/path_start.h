// What one path of the path tracer (path_walk.h) begins with, and what it can find besides its radiance.
#pragma once

#include "film/film.h"
#include "sampling/sampler.h"
#include "scene/catchers.h"
#include "transport/direct/media_light.h"
#include "transport/media/path_in_media.h"

namespace ajar {

class LensLight;  // transport/bidirectional/lens_light.h

/// Dimensions of the path tracer's sampler: those of the camera, then a fixed number for each vertex, at these offsets.
struct PathDimensions {
  static constexpr uint32_t kTime = 4, kCamera = 6, kVertex = 8;
  static constexpr uint32_t kDirectLight = 0, kLobe = kDirectDimensions, kRoulette = 6, kGuide = 7;
  static constexpr uint32_t kEnter = 8192;  ///< plus the vertex: whether light enters the subsurface
  static constexpr uint32_t kScatter = 12288, kStretch = 2 + kMediumLightDimensions;  ///< for each segment in media
};

struct NoParts {};
/// The light of a sample by paths LS*E and L(D)S*E, with delta lobes S.
struct DirectPart {
  Color direct_paths{0.0f};
};
/// Luminance of a sample with the light of each source times its importance. Emission of media is not a source.
struct ImportantLight {
  float luminance = 0.0f;
  float of_source = 1.0f;  ///< importance of the light that is added next
};

/// Input of a path.
struct PathStart {
  const Scene& scene;
  Ray ray;
  int pixel_x, pixel_y;  ///< of the full frame
  Sampler& sampler;
  SampleAux* aux;  ///< null if no pass needs it
  PathCounters& counters;
  bool ends_early;               ///< RenderPlan::ends_early
  CaughtPath* caught = nullptr;  ///< null: the scene has no shadow catchers
  /// Shares the light that the camera sees directly with light samples; null: camera rays find all of it.
  const LensLight* lens_light = nullptr;
  Vec2 film{0.0f};  ///< point of the ray, for lens_light
};

}  // namespace ajar
