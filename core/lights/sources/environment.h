// The light that arrives from infinity in every direction: the program of the world.
//
// Importance sampling by luminance on an equirectangular grid (z up; rows of equal polar angle). The density is
// constant over the solid angle of each cell, so poles need no special case. The program is evaluated at the corners of
// the cells; a program that computes noise is evaluated at each fourth corner of a row and a column, and at all of them
// where these differ much. Light sampling is always combined with BSDF sampling, which is better for an even sky. The density
// therefore follows the luminance above the mean (MIS compensation, Karlik et al. 2019), plus a floor of kFloor of the
// mean, so that it is positive wherever there can be radiance. A constant world has no grid, is sampled uniformly over
// the sphere and never exceeds its mean.
//
// The program sees `position` = the unit direction that is looked at, and `ng` = `ns` = `wo` = its negative.
#pragma once

#include "math/distribution.h"
#include "shading/shader_program.h"

namespace ajar {

class Environment {
 public:
  Environment() = default;
  Environment(const ShaderProgram& program, uint32_t visibility);
  /// For a program that emits exactly the same as that of `same`: takes over its tables.
  Environment(Environment&& same, const ShaderProgram& program, uint32_t visibility);

  bool has_map() const { return program_ && !constant_; }
  bool black() const { return !(mean_luminance_ > 0.0f); }
  /// Radiance from direction `wi` for a ray of `ray_kind`; zero if the world is not visible to it.
  Color radiance(Vec3 wi, uint32_t ray_kind) const;
  Vec3 sample(Vec2 u, float& pdf_solid_angle) const;
  float pdf_solid_angle(Vec3 wi) const;
  /// Averages over the sphere: of the luminance, and of the luminance above that mean.
  float mean_luminance() const { return mean_luminance_; }
  float excess_luminance() const { return excess_luminance_; }
  /// Memory of the grid; 0 for a constant world.
  size_t table_bytes() const { return map_.memory_bytes() + cos_rows_.size() * sizeof(float); }

 private:
  static constexpr int kWidth = 1024, kHeight = 512;
  static constexpr float kFloor = 0.05f;
  static constexpr int kCoarse = 4;
  static constexpr double
      kContrast = 0.5;  ///< between corners, as a fraction of the mean, above which all are evaluated
  std::vector<float> evaluate_corners(const std::vector<SkyDisc>& discs) const;
  void build_map();
  /// Adds the light of a sun to the cells of the map. Returns it as a mean over the sphere.
  double add_disc(const SkyDisc& disc, std::vector<float>& cells) const;
  float part_of_sphere(int row) const;  ///< the solid angle of a cell; the sphere has 1

  const ShaderProgram* program_ = nullptr;
  uint32_t visibility_ = 0;
  bool constant_ = true;
  Color constant_radiance_{0.0f};
  float mean_luminance_ = 0.0f, excess_luminance_ = 0.0f;
  Distribution2D map_;           // rows from +z to -z, columns by azimuth from +x
  std::vector<float> cos_rows_;  // cosine of the polar angle at the edges of the rows
};

}  // namespace ajar
