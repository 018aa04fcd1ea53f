// Unidirectional path tracing with multiple importance sampling of lights and BSDFs.
//
// Computes the radiance of every pixel by paths from the eye [Kajiya 1986; Veach 1997, chapter 9]. Unbiased (without
// clamping). It is the reference for all other integrators, and the best choice for open scenes and visible lights. It
// finds caustics of small lights and light behind narrow openings only with small probability, and never finds delta
// lights behind specular surfaces. Small lights out of focus are found by light samples as well
// (transport/bidirectional/lens_light.h). Media between surfaces: transport/media/media.h; then the default method samples
// direct light. With guiding (transport/guiding/path_guide.h), directions at surfaces and in media are drawn from a
// learned mixture. This is unbiased too, and better where most light comes from few directions that light sampling does
// not reach.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_path_tracer();

/// For each pixel of the region: an estimate of its luminance, and the same with the light of each source times its
/// importance (Scene::light_importance). Uses its own samples, which are part of no image. Pixels without samples are
/// 0.
std::vector<Vec2> measure_important_light(std::shared_ptr<const Scene> scene, uint32_t seed, float samples_per_pixel,
                                          const std::atomic<bool>& stop);

}  // namespace ajar
