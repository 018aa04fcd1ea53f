// Irradiance caching: the indirect light of diffuse surfaces, gathered at few points and interpolated.
//
// Traces paths from the eye like path tracing. Where they hit a diffuse lobe, its indirect light is interpolated from
// records [Ward et al. 1988; Fan 2006, section 6.4.1]. Direct light is estimated by the direct light method at every
// sample, and at the hits of the rays of records, so MIS and OCV can be compared here. Glossy lobes are path traced.
// *Biased*: interpolation smooths what changes within the radius of a record (light in corners, caustics); the bias is
// about one per cent of the mean in rooms (tests/core/test_irradiance_cache.cpp). Every sample of a pixel has its own
// records at other positions, so noise and blotches continue to decrease. Prefer it in diffuse rooms if a smooth image
// is needed early. All records and samples of a pass have the same time. Bumped surfaces, hair and walks below surfaces
// are path traced. In a scene with media nothing is cached: all light is path traced.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_irradiance_cache();

}  // namespace ajar
