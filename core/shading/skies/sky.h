// Clear skies, as in Blender's Sky Texture: the analytic models of Preetham et al. (1999) and of Hosek and Wilkie
// (2012), and atmospheres with a sun disc, which are computed once and stored in a table. Directions have z up.
#pragma once

#include <optional>
#include <vector>

#include "math/types.h"
#include "shading/skies/atmosphere.h"

namespace ajar::nodes {

class Sky {
 public:
  static Sky preetham(Vec3 to_sun, float turbidity);
  static Sky hosek_wilkie(Vec3 to_sun, float turbidity, float ground_albedo);
  /// Single scattering as in Blender before 5.0: the sun covers the sky behind it and ends at the horizon.
  static Sky nishita(const Atmosphere& atmosphere);
  /// Blender since 5.0: the sky is added to the sun, and the ground is below the horizon of the eye's altitude.
  static Sky single_scattering(const Atmosphere& atmosphere);
  static Sky multiple_scattering(const Atmosphere& atmosphere);

  Color radiance(Vec3 direction) const;

  /// The sun disc, if it is visible: a small part of the sky that emits most of its light.
  struct Disc {
    Vec3 direction;
    float angular_radius;
  };
  std::optional<Disc> sun() const;

 private:
  enum class Model : uint8_t { Preetham, HosekWilkie, Nishita, Atmospheric } model_ = Model::Preetham;
  float sun_theta_ = 0.0f, sun_phi_ = 0.0f;  // phi from y to x
  Vec3 zenith_{0.0f};                        // components in the model's colour space
  float shape_[3][9] = {};
  // Only for atmospheres:
  Atmosphere atmosphere_;
  Vec3 sun_direction_{0, 0, 1};
  float ground_elevation_ = 0.0f;  // the ground hides the sun below this elevation
  Color sun_bottom_{0.0f}, sun_top_{0.0f};
  int rows_ = 0;
  std::vector<Vec3> table_;  // XYZ; rows go up

  explicit Sky(Model model) : model_(model) {}
  Sky(Model model, const Atmosphere& atmosphere);
  Color analytic(Vec3 direction) const;
  Color nishita(Vec3 direction) const;
  Color atmospheric(Vec3 direction) const;
  float column_of(Vec3 direction) const;
  float angle_to_sun(Vec3 direction) const;
  Vec3 sun_radiance(float part, float angle) const;
  Vec3 lookup(float x, float y) const;
};

}  // namespace ajar::nodes
