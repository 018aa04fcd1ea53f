// Clear skies, as in Blender's Sky Texture: the analytic models of Preetham et al. (1999) and of Hosek and Wilkie
// (2012), and single scattering in an atmosphere (Nishita et al. 1993) with a sun disc, which is computed once and
// stored in a table. Directions have z up.
#pragma once

#include <memory>
#include <optional>
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

class Sky {
 public:
  static Sky preetham(Vec3 to_sun, float turbidity);
  static Sky hosek_wilkie(Vec3 to_sun, float turbidity, float ground_albedo);
  static Sky nishita(const Atmosphere& atmosphere);

  Color radiance(Vec3 direction) const;

  /// The sun disc, if it is visible: a small part of the sky that emits most of its light.
  struct Disc {
    Vec3 direction;
    float angular_radius;
  };
  std::optional<Disc> sun() const;

 private:
  enum class Model : uint8_t { Preetham, HosekWilkie, Nishita } model_ = Model::Preetham;
  float sun_theta_ = 0.0f, sun_phi_ = 0.0f;  // phi from y to x
  Vec3 zenith_{0.0f};                        // components in the model's colour space
  float shape_[3][9] = {};
  // Only for the model of Nishita et al.:
  Atmosphere atmosphere_;
  Vec3 sun_direction_{0, 0, 1};
  Color sun_bottom_{0.0f}, sun_top_{0.0f};
  std::vector<Vec3> table_;  // XYZ; rows go up from the horizon

  Color analytic(Vec3 direction) const;
  Color atmospheric(Vec3 direction) const;
  Vec3 lookup(float x, float y) const;
};

}  // namespace ajar::nodes
