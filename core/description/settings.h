// How a scene is rendered: limits, samples, techniques, passes.
//
// Each field has a row in settings_table.cpp with its unit, range, meaning and its place in files.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "description/choices.h"

namespace ajar {

struct BounceLimits {
  int total = 12, diffuse = 4, glossy = 4, transmission = 12, transparent = 8, volume = 0;
  bool operator==(const BounceLimits&) const = default;
};

/// The mist pass: (distance beyond start / depth)^exponent.
struct MistDescription {
  float start = 5.0f, depth = 25.0f, exponent = 2.0f;
  bool operator==(const MistDescription&) const = default;
};

struct RenderSettings {
  int width = 640, height = 480;
  std::array<int, 4> region{0, 0, 0, 0};
  FilterKind filter = FilterKind::BlackmanHarris;
  float filter_width = 1.5f;  ///< Blender's value; film/filter.h converts it to pixels
  float exposure = 1.0f;
  float view_exposure = 1.0f;
  bool transparent_film = false;
  BounceLimits bounces;
  float clamp_direct = 0.0f, clamp_indirect = 0.0f;
  bool reflective_caustics = true, refractive_caustics = true;
  BumpTerminator bump_terminator = BumpTerminator::Cubic;
  std::string integrator = "path";  ///< a name that find_integrator looks up (integrators/integrator.h)
  DirectMethod direct = DirectMethod::Mis;
  ImageSampling image = ImageSampling::Uniform;
  Merging vertex_merging = Merging::Off;
  Guiding guiding = Guiding::Off;
  int direct_samples = 1;
  ErrorMeasure image_error = ErrorMeasure::Relative;
  std::array<float, 4> importance_region{0, 0, 0, 0};
  float importance_factor = 1.0f;
  int samples = 64;
  double seconds = 0.0, target_error = 0.0;
  int photons = 0;
  float photon_radius = 0.0f;
  int gather_rays = 3;
  uint32_t seed = 0;
  int threads = 0;
  int memory_limit = 0;
  std::vector<std::string> passes{"Combined"};
  MistDescription mist;
  bool denoised = false;  ///< the owner denoises the image
  float pass_alpha_threshold = 0.5f;
  float ao_distance = 10.0f;
  bool transparent_glass = false;
  float transparent_glass_roughness = 0.1f;
  bool texture_cache = false, texture_cache_generate = false;  ///< shading/images/tile_cache.h
  std::string texture_cache_folder;
  int texture_cache_size = 1024;
  bool compact_bvh = false;  ///< scene/accel.h
  bool operator==(const RenderSettings&) const = default;
};

/// Light times this is displayed.
inline float shown_exposure(const RenderSettings& settings) { return settings.exposure * settings.view_exposure; }

}  // namespace ajar
