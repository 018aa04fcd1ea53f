// Unidirectional path tracing with multiple importance sampling of lights and BSDFs.
//
// Computes the radiance through every pixel by paths from the eye [Kajiya 1986; Veach 1997, chapter 9].
// Unbiased (with clamping off). The reference for all others, and the best choice for open
// scenes and easily seen lights. Finds caustics of small lights and light behind
// narrow openings only by luck, delta lights behind specular surfaces never. Media between surfaces:
// transport/media/media.h; then direct light is sampled by the default method, and paths are not guided. Grids are not
// known. With guiding (transport/guiding/path_guide.h) directions are drawn from a learned mixture as well: unbiased,
// too, and better where most light comes from few directions that light sampling does not reach.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_path_tracer();

/// Estimates of each pixel of the region: its luminance, and the same with the light of each source times its
/// importance (Scene::light_importance). Of its own samples, which are in no picture; pixels that got none are 0.
std::vector<Vec2> measure_important_light(std::shared_ptr<const Scene> scene, uint32_t seed, float samples_per_pixel,
                                          const std::atomic<bool>& stop);

}  // namespace ajar
