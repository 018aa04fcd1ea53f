// Irradiance caching: the light that diffuse surfaces receive from other surfaces, gathered at few points and
// interpolated.
//
// Computes paths from the eye as path tracing does, but where they meet a diffuse lobe, the light it scatters that
// comes from other surfaces is read from records [Ward et al. 1988; Fan 2006, section 6.4.1]. Light that comes from
// lamps is estimated at every sample by the method of direct light, and at what the rays of records meet; so MIS and
// OCV can be compared inside of it. Glossy lobes are path traced. *Biased*: interpolation smooths what changes within a
// record's radius (light in corners, caustics); about one per cent of the mean in rooms
// (tests/core/test_irradiance_cache.cpp). Every sample of a pixel has records of its own, at other places, so noise and
// blotches go on falling. Prefer it in diffuse rooms, where a smooth picture is wanted early. Does not handle motion
// blur, volumes, light below surfaces (it is taken for diffuse), nor bumped surfaces, which are path traced.
#pragma once

#include "integrators/integrator.h"

namespace ajar {

std::unique_ptr<Integrator> make_irradiance_cache();

}  // namespace ajar
