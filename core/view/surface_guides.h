// The guides of a denoiser for each pixel, without light: the first rough surface that a camera ray meets, as the passes
// "Denoising Albedo" and "Denoising Normal" have it (transport/paths/record.h). It takes a fifth of a sample with light.
#pragma once

#include <atomic>
#include <vector>

#include "scene/scene.h"

namespace ajar {

struct SurfaceGuides {
  std::vector<float> albedo, normal;  ///< RGB and XYZ, rows from the bottom up over the region of the settings
};

/// One ray through the centre of each pixel of `view`, whose size and region are those of `settings`. The scene may have
/// another camera.
/// Incomplete when `stop` is set.
SurfaceGuides trace_surface_guides(const Scene& scene, const CameraDescription& view, const RenderSettings& settings,
                                   const std::atomic<bool>& stop);

}  // namespace ajar
