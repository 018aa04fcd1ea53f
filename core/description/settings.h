// How a scene is rendered: limits, samples, techniques, passes.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "description/bump_terminator.h"

namespace ajar {

enum class FilterKind : uint8_t { Box, Gaussian, BlackmanHarris };

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
  int width = 640, height = 480;          ///< full frame
  std::array<int, 4> region{0, 0, 0, 0};  ///< x0, y0, x1, y1 in pixels, y up; all 0 is the full frame
  FilterKind filter = FilterKind::BlackmanHarris;
  float filter_width = 1.5f;  ///< Blender's value; film/filter.h converts it to pixels
  float exposure = 1.0f;      ///< factor on the film
  bool transparent_film = false;
  BounceLimits bounces;
  float clamp_direct = 0.0f, clamp_indirect = 0.0f;  ///< 0 is off
  bool reflective_caustics = true, refractive_caustics = true;
  BumpTerminator bump_terminator = BumpTerminator::Cubic;
  std::string integrator = "path", direct = "mis", image = "uniform";
  /// For bdpt, erpt, pmc_pt and metropolis: off, on (transport/bidirectional/vertex_merging.h).
  std::string vertex_merging = "off";
  std::string guiding = "off";                         ///< for the path tracer: off, on, auto
  int direct_samples = 1;                              ///< direct light samples at the surfaces that the camera sees
  std::string image_error = "relative";                ///< the error that pmc_ip reduces: "relative" or "perceptual"
  std::array<float, 4> importance_region{0, 0, 0, 0};  ///< x0, y0, x1, y1 in fractions of the frame, y up
  float importance_factor = 1.0f;                      ///< importance of the pixels in that region
  int samples = 64;                                    ///< per pixel; 0: until the time or the error ends the render
  double seconds = 0.0, target_error = 0.0;            ///< 0 is off
  int photons = 0;             ///< emitted for each sample of the image; 0: derived from the image size
  float photon_radius = 0.0f;  ///< radius of the first pass in metres; 0: derived from the photon density
  int gather_rays = 8;         ///< per sample, at the first rough surface, if photon maps are used
  uint32_t seed = 0;
  int threads = 0;  ///< 0: all
  /// MiB; a render that needs more is refused before it is built (render/memory_estimate.h); 0: no limit
  int memory_limit = 0;
  std::vector<std::string> passes{"Combined"};
  MistDescription mist;
  bool operator==(const RenderSettings&) const = default;
};

}  // namespace ajar
