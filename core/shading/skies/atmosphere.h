// The light of the sun that an atmosphere scatters, as tables over the directions from the eye.
#pragma once

#include <vector>

#include "math/types.h"

namespace ajar::nodes {

/// The constituents of an atmosphere. Densities are relative to the Earth's, angles are in radians.
struct Atmosphere {
  float sun_elevation = 0.261799f, sun_rotation = 0.0f;
  float altitude = 0.0f;  ///< metres
  float air_density = 1.0f, dust_density = 1.0f, ozone_density = 1.0f;
  bool sun_disc = true;
  float sun_size = 0.009512f;  ///< angle of the sun's diameter
  float sun_intensity = 1.0f;
};

/// The tables have a row of kSkyWidth radiances for each elevation, over all azimuths; the sun is in the middle. A
/// hemisphere has kSkyRows rows. The elevation grows with the square of the index, so that rows are denser near the
/// horizon. All radiances are in XYZ.
constexpr int kSkyWidth = 512, kSkyRows = 128;
/// Altitudes of the ends of the atmospheres in metres.
constexpr float kSingleAtmosphere = 60e3f, kMultipleAtmosphere = 100e3f;

/// Single scattering [Nishita et al. 1993] above the horizon, from the horizon up. The elevations of the rows are
/// multiplied by `stretch`.
std::vector<Vec3> singly_scattered_rows(const Atmosphere& atmosphere, float stretch);
/// The radiance of the sun at an elevation, at least at the horizon. Ozone does not dim it, as in Blender.
Vec3 singly_scattered_sun(const Atmosphere& atmosphere, float elevation);

/// Multiple scattering with light from the ground, of all directions, from the nadir up (`multiple_scattering.cpp`).
std::vector<Vec3> multiply_scattered_rows(const Atmosphere& atmosphere);
Vec3 multiply_scattered_sun(const Atmosphere& atmosphere, float elevation);

/// The angle between the horizontal plane of an eye and its horizon on the ground.
float dip_of_horizon(float altitude);

}  // namespace ajar::nodes
