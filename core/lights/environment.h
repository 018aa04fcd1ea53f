// The light that comes from infinitely far away in every direction: the world's program.
//
// Importance sampling by luminance on an equirectangular grid (z up; rows of equal polar
// angle). The density is constant over each cell's solid angle, so poles need no care. The program is evaluated at the
// corners of the cells. Light sampling is always combined with BSDF sampling, which finds an even sky better: so the
// density follows what exceeds the mean luminance (MIS compensation, Karlik et al. 2019), above a floor of
// kFloor of the mean: wherever there may be radiance the density is positive. A constant world is
// sampled uniformly over the sphere, has no grid, and exceeds its mean nowhere.
//
// The program sees `position` = unit direction looked at, and `ng` = `ns` = `wo` = its negative.
#pragma once

#include "math/distribution.h"
#include "shading/shader_program.h"

namespace ajar {

class Environment {
 public:
  Environment() = default;
  Environment(const ShaderProgram& program, uint32_t visibility);
  /// For a program that emits exactly what that of `same` does: its tables are taken over.
  Environment(Environment&& same, const ShaderProgram& program, uint32_t visibility);

  bool has_map() const { return program_ && !constant_; }
  bool black() const { return !(mean_luminance_ > 0.0f); }
  /// Radiance from direction `wi` as a ray of `ray_kind` sees it; zero where the world is not visible to it.
  Color radiance(Vec3 wi, uint32_t ray_kind) const;
  Vec3 sample(Vec2 u, float& pdf_solid_angle) const;
  float pdf_solid_angle(Vec3 wi) const;
  /// Averages over the sphere: of the luminance, and of what exceeds that mean.
  float mean_luminance() const { return mean_luminance_; }
  float excess_luminance() const { return excess_luminance_; }
  /// Of the grid; none of a constant world.
  size_t table_bytes() const { return map_.memory_bytes() + cos_rows_.size() * sizeof(float); }

 private:
  static constexpr int kWidth = 1024, kHeight = 512;
  static constexpr float kFloor = 0.05f;
  void build_map();

  const ShaderProgram* program_ = nullptr;
  uint32_t visibility_ = 0;
  bool constant_ = true;
  Color constant_radiance_{0.0f};
  float mean_luminance_ = 0.0f, excess_luminance_ = 0.0f;
  Distribution2D map_;           // rows from +z to -z, columns by azimuth from +x
  std::vector<float> cos_rows_;  // cosine of the polar angle at the edges of the rows
};

}  // namespace ajar
