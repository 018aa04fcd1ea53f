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
// The sun disc of a sky is smaller than a cell, or covers a part of several. It has a share of the samples of its own,
// which are uniform over its solid angle. The density of a direction is the sum of that of the grid and of the discs
// that contain it. Cells with much of the light, such as those of the sun in a photograph, and the cells around them are
// divided further.
//
// The program sees `position` = the unit direction that is looked at, and `ng` = `ns` = `wo` = its negative.
#pragma once

#include <vector>

#include "math/distribution.h"
#include "math/frame.h"
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
  /// Share of the samples that is taken from sun discs.
  float disc_share() const { return disc_share_; }
  /// Memory of the grid; 0 for a constant world.
  size_t table_bytes() const;

 private:
  static constexpr int kWidth = 1024, kHeight = 512;
  static constexpr float kFloor = 0.05f;
  static constexpr int kCoarse = 4;
  static constexpr int kFine = 16;               ///< parts of a divided cell to each side
  static constexpr double kHeavy = 1.0 / 512.0;  ///< part of the light above the mean, from which a cell is divided
  static constexpr double
      kContrast = 0.5;  ///< between corners, as a fraction of the mean, above which all are evaluated
  struct Disc {
    Frame frame;           ///< its normal is the direction of the middle
    float one_minus_cos;   ///< of the angular radius
    double light;          ///< integral of the luminance, as a mean over the sphere
    float chosen = 0.0f;   ///< cumulative share of the samples of all discs
    float density = 0.0f;  ///< of its samples among those of all discs, per solid angle

    float part_of_sphere() const { return 0.5f * one_minus_cos; }
    bool contains(Vec3 wi) const { return length_squared(wi - frame.n) < 2.0f * one_minus_cos; }
  };
  /// A cell that is divided: uniform steps of azimuth and of the cosine of the polar angle.
  struct FineCell {
    uint32_t cell = 0;
    std::vector<float> values;  ///< luminances, until they are in the distribution
    Distribution2D distribution;
  };
  /// The discs that emit.
  std::vector<Disc> find_discs() const;
  /// Luminance of what the map distributes: the sky without its discs.
  float map_luminance(Vec3 wi) const;
  std::vector<float> evaluate_corners() const;
  /// The luminance of the map as a mean over the sphere, and the part of it above that mean.
  double sum_of(const std::vector<float>& cells) const;
  double excess_of(const std::vector<float>& cells) const;
  /// Divides cells with much of the light, and gives them their mean luminance.
  void divide_cells(std::vector<float>& cells);
  /// The weight of a cell or a part of one, for its luminance.
  float sampled(float luminance) const {
    return std::max(0.0f, luminance - mean_luminance_) + kFloor * mean_luminance_;
  }
  /// Null if the cell is not divided.
  const FineCell* fine_cell(int column, int row) const;
  void build_map();
  /// Distributes samples between the discs and the map, by their luminance above the mean.
  void share_samples(double excess_of_map);
  float part_of_sphere(int row) const;  ///< the solid angle of a cell; the sphere has 1
  float map_pdf(Vec3 wi) const;         ///< per solid angle
  float disc_pdf(Vec3 wi) const;        ///< per solid angle, of all samples

  const ShaderProgram* program_ = nullptr;
  uint32_t visibility_ = 0;
  bool constant_ = true;
  Color constant_radiance_{0.0f};
  float mean_luminance_ = 0.0f, excess_luminance_ = 0.0f;
  std::vector<Disc> discs_;
  float disc_share_ = 0.0f;
  std::vector<FineCell> fine_cells_;
  std::vector<int32_t> fine_of_cell_;  // -1: not divided; empty if none is
  Distribution2D map_;                 // rows from +z to -z, columns by azimuth from +x
  std::vector<float> cos_rows_;        // cosine of the polar angle at the edges of the rows
};

}  // namespace ajar
