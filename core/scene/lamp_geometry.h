// The shapes of lamps in Embree.
#pragma once

#include "lights/sources/light.h"
#include "scene/embree.h"

namespace ajar {

/// Whether rays can hit the lamp.
bool has_shape(const Light& light);
/// A new geometry, not committed. It refers to `light`, which must outlive it. Its rays have `Ray::travelled` as id.
RTCGeometry lamp_geometry(RTCDevice device, const Light& light);

}  // namespace ajar
