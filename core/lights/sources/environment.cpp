#include "lights/sources/environment.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

#include "math/frame.h"
#include "math/warps.h"

namespace ajar {

namespace {

Color evaluate(const ShaderProgram& program, Vec3 wi, uint32_t ray_kind) {
  ShadingPoint point;
  point.position = wi;
  point.wo = point.ng = point.ns = -wi;
  point.ray_kind = ray_kind;
  return program.evaluate_emission(point);
}

/// Weight of a radiance for sampling: non-negative and finite.
float weight(Color radiance) {
  const float y = luminance(glm::abs(radiance));
  return std::isfinite(y) ? y : 0.0f;
}

}  // namespace

Environment::Environment(const ShaderProgram& program, uint32_t visibility)
    : program_(&program), visibility_(visibility) {
  if (!program.emits()) return;
  constant_ = program.emission_is_constant();
  if (constant_) {
    constant_radiance_ = evaluate(program, Vec3(0, 0, 1), 0);
    mean_luminance_ = weight(constant_radiance_);
    return;
  }
  build_map();
}

Environment::Environment(Environment&& same, const ShaderProgram& program, uint32_t visibility)
    : Environment(std::move(same)) {
  program_ = &program;
  visibility_ = visibility;
}

std::vector<Environment::Disc> Environment::find_discs() const {
  constexpr int kPoints = 1024;
  constexpr double kGoldenTurn = 0.6180339887498949;
  // The rounding of the sky's own test whether a direction is in the disc must not leave light outside of the density.
  constexpr float kMargin = 1.0005f;
  std::vector<Disc> discs;
  for (const SkyDisc& sun : program_->sky_discs()) {
    Disc disc{Frame(sun.direction), warp::one_minus_cos(kMargin * sun.angular_radius), 0.0};
    for (int i = 0; i < kPoints; ++i) {  // a spiral with equal areas [Vogel 1979]
      const Vec2 u((float(i) + 0.5f) / kPoints, float(i * kGoldenTurn - std::floor(i * kGoldenTurn)));
      const Vec3 wi = disc.frame.to_world(warp::square_to_cone(u, disc.one_minus_cos));
      disc.light += double(weight(evaluate(*program_, wi, 0)) * disc.part_of_sphere()) / kPoints;
    }
    if (disc.light > 0.0) discs.push_back(disc);
  }
  return discs;
}

float Environment::map_luminance(Vec3 wi) const {
  const bool in_disc = std::any_of(discs_.begin(), discs_.end(), [&](const Disc& disc) { return disc.contains(wi); });
  return in_disc ? 0.0f : weight(evaluate(*program_, wi, 0));
}

std::vector<float> Environment::evaluate_corners() const {
  std::vector<float> corners(size_t(kWidth) * (kHeight + 1));
  const auto corner = [&](int x, int y) -> float& { return corners[size_t(y) * kWidth + size_t(x % kWidth)]; };
  const auto evaluate_at = [&](int x, int y) {
    const double theta = M_PI * y / kHeight, phi = 2.0 * M_PI * x / kWidth, sin_theta = std::sin(theta);
    const Vec3 wi(float(sin_theta * std::cos(phi)), float(sin_theta * std::sin(phi)), float(std::cos(theta)));
    corner(x, y) = map_luminance(wi);
  };
  const int step = program_->emission_is_slow() ? kCoarse : 1, columns = kWidth / step, rows = kHeight / step;
  tbb::parallel_for(0, rows + 1, [&](int y) {
    for (int x = 0; x < columns; ++x) evaluate_at(x * step, y * step);
  });
  if (step == 1) return corners;

  double mean = 0.0;
  for (int y = 0; y <= rows; ++y)
    for (int x = 0; x < columns; ++x)
      mean += double(corner(x * step, y * step)) * std::sin(M_PI * y / rows) * 0.5 * M_PI / (double(rows) * columns);
  std::vector<uint8_t> fine(size_t(columns) * size_t(rows), 0);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const auto [least,
                  most] = std::minmax({corner(x * step, y * step), corner((x + 1) * step, y * step),
                                       corner(x * step, (y + 1) * step), corner((x + 1) * step, (y + 1) * step)});
      if (!(double(most - least) > kContrast * mean)) continue;
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, rows - 1); ++v)
        for (int u = x - 1; u <= x + 1; ++u) fine[size_t(v) * size_t(columns) + size_t((u + columns) % columns)] = 1;
    }
  tbb::parallel_for(0, rows + 1, [&](int row) {
    for (int x = 0; x < kWidth; ++x)
      for (int y = row * step; y < std::min((row + 1) * step, kHeight + 1); ++y) {
        const int dx = x % step, dy = y % step, left = x - dx, top = y - dy;
        if (dx == 0 && dy == 0) continue;
        if (row < rows && fine[size_t(row) * size_t(columns) + size_t(x / step)]) {
          evaluate_at(x, y);
          continue;
        }
        const float u = float(dx) / float(step), v = float(dy) / float(step);
        const int bottom = std::min(top + step, kHeight);
        corner(x, y) = (1.0f - v) * ((1.0f - u) * corner(left, top) + u * corner(left + step, top)) +
                       v * ((1.0f - u) * corner(left, bottom) + u * corner(left + step, bottom));
      }
  });
  return corners;
}

void Environment::build_map() {
  cos_rows_.resize(kHeight + 1);
  for (int y = 0; y <= kHeight; ++y) cos_rows_[size_t(y)] = float(std::cos(M_PI * y / kHeight));

  discs_ = find_discs();
  const std::vector<float> corners = evaluate_corners();

  std::vector<float> cells(size_t(kWidth) * kHeight);
  for (int y = 0; y < kHeight; ++y) {
    const float* above = corners.data() + size_t(y) * kWidth;
    const float* below = above + kWidth;
    for (int x = 0; x < kWidth; ++x) {
      const int next = (x + 1) % kWidth;
      cells[size_t(y) * kWidth + size_t(x)] = 0.25f * (above[x] + above[next] + below[x] + below[next]);
    }
  }
  // If all corners are black, there can still be radiance between them. The density then has only the floor.
  const auto mean_of = [&] {
    double sum = sum_of(cells);
    for (const Disc& disc : discs_) sum += disc.light;
    return sum > 0.0 ? float(sum) : 1e-6f;
  };
  mean_luminance_ = mean_of();
  divide_cells(cells);
  mean_luminance_ = mean_of();
  share_samples(excess_of(cells));
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      float& cell = cells[size_t(y) * kWidth + size_t(x)];
      cell = sampled(cell) * part_of_sphere(y);
    }
  for (FineCell& fine : fine_cells_) {
    double sum = 0.0;
    for (float& value : fine.values) sum += double(value = sampled(value));
    // The density is not linear in the luminance, so that the cell has the mean of its parts.
    cells[fine.cell] = float(sum / double(fine.values.size())) * part_of_sphere(int(fine.cell) / kWidth);
    fine.distribution = Distribution2D(fine.values, kFine, kFine);
    fine.values = {};
  }
  map_ = Distribution2D(cells, kWidth, kHeight);
}

double Environment::sum_of(const std::vector<float>& cells) const {
  double sum = 0.0;
  for (size_t i = 0; i < cells.size(); ++i) sum += double(cells[i]) * part_of_sphere(int(i) / kWidth);
  return sum;
}

double Environment::excess_of(const std::vector<float>& cells) const {
  double excess = 0.0;
  for (size_t i = 0; i < cells.size(); ++i)
    excess += double(std::max(0.0f, cells[i] - mean_luminance_)) * part_of_sphere(int(i) / kWidth);
  return excess;
}

void Environment::divide_cells(std::vector<float>& cells) {
  const double least = kHeavy * excess_of(cells);
  fine_of_cell_.assign(cells.size(), -1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const float above_mean = cells[size_t(y) * kWidth + size_t(x)] - mean_luminance_;
      if (!(above_mean > 0.0f) || !(double(above_mean) * part_of_sphere(y) > least)) continue;
      // A bright disc reaches a little into cells of which no corner is bright.
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, kHeight - 1); ++v)
        for (int u = x - 1; u <= x + 1; ++u) {
          const size_t cell = size_t(v) * kWidth + size_t((u + kWidth) % kWidth);
          if (fine_of_cell_[cell] >= 0) continue;
          fine_of_cell_[cell] = int32_t(fine_cells_.size());
          fine_cells_.push_back({uint32_t(cell), {}, {}});
        }
    }
  if (fine_cells_.empty()) fine_of_cell_ = {};
  tbb::parallel_for(size_t(0), fine_cells_.size(), [&](size_t i) {
    FineCell& fine = fine_cells_[i];
    const int row = int(fine.cell) / kWidth, column = int(fine.cell) % kWidth;
    const float top = cos_rows_[size_t(row)], bottom = cos_rows_[size_t(row) + 1];
    float corners[kFine + 1][kFine + 1];
    for (int y = 0; y <= kFine; ++y)
      for (int x = 0; x <= kFine; ++x) {
        const float z = top + (bottom - top) * (float(y) / kFine), r = safe_sqrt((1.0f - z) * (1.0f + z));
        const float phi = 2.0f * kPi * (float(column) + float(x) / kFine) / float(kWidth);
        corners[y][x] = map_luminance({r * std::cos(phi), r * std::sin(phi), z});
      }
    fine.values.resize(size_t(kFine) * kFine);
    double sum = 0.0;
    for (int y = 0; y < kFine; ++y)
      for (int x = 0; x < kFine; ++x) {
        const float mean = 0.25f * (corners[y][x] + corners[y][x + 1] + corners[y + 1][x] + corners[y + 1][x + 1]);
        fine.values[size_t(y) * kFine + size_t(x)] = mean;
        sum += double(mean);
      }
    cells[fine.cell] = float(sum / double(fine.values.size()));
  });
}

const Environment::FineCell* Environment::fine_cell(int column, int row) const {
  if (fine_of_cell_.empty()) return nullptr;
  const int32_t index = fine_of_cell_[size_t(row) * kWidth + size_t(column)];
  return index >= 0 ? &fine_cells_[size_t(index)] : nullptr;
}

size_t Environment::table_bytes() const {
  size_t bytes = map_.memory_bytes() + cos_rows_.size() * sizeof(float) + fine_of_cell_.size() * sizeof(int32_t) +
                 discs_.size() * sizeof(Disc);
  for (const FineCell& fine : fine_cells_) bytes += sizeof(FineCell) + fine.distribution.memory_bytes();
  return bytes;
}

void Environment::share_samples(double excess_of_map) {
  // Shares that are multiples of an eighth keep the stratification of samples. The map has at least a quarter: where the
  // sun is hidden, the rest of the sky is all of the light.
  constexpr float kSteps = 8.0f, kLargest = 0.75f;
  double excess = 0.0;
  for (Disc& disc : discs_) {
    excess += std::max(0.0, disc.light - double(mean_luminance_) * disc.part_of_sphere());
    disc.chosen = float(excess);
  }
  excess_luminance_ = float(excess_of_map + excess);
  disc_share_ = excess > 0.0 ? float(excess / (excess_of_map + excess)) : 0.0f;
  if (disc_share_ > 1.0f / kSteps) disc_share_ = std::min(kLargest, std::round(kSteps * disc_share_) / kSteps);
  float before = 0.0f;
  for (Disc& disc : discs_) {
    disc.chosen = excess > 0.0 ? disc.chosen / float(excess) : 0.0f;
    disc.density = (disc.chosen - before) * warp::cone_pdf_solid_angle(disc.one_minus_cos);
    before = disc.chosen;
  }
}

float Environment::part_of_sphere(int row) const {
  return 0.5f * (cos_rows_[size_t(row)] - cos_rows_[size_t(row) + 1]) / float(kWidth);
}

Color Environment::radiance(Vec3 wi, uint32_t ray_kind) const {
  if (!program_ || visibility_ == 0) return Color(0.0f);
  if (visibility_ != kVisibleAll) {
    const auto hidden_from = [&](uint32_t kinds, uint32_t bit) { return (ray_kind & kinds) && !(visibility_ & bit); };
    if (hidden_from(kRayCamera, kVisibleCamera) || hidden_from(kRayDiffuse, kVisibleDiffuse) ||
        ((ray_kind & kRayReflection) && hidden_from(kRayGlossy, kVisibleGlossy)) ||
        hidden_from(kRayTransmission, kVisibleTransmission) || hidden_from(kRayVolumeScatter, kVisibleVolumeScatter))
      return Color(0.0f);
  }
  return constant_ ? constant_radiance_ : evaluate(*program_, wi, ray_kind);
}

Vec3 Environment::sample(Vec2 u, float& pdf) const {
  if (constant_) {
    pdf = warp::sphere_pdf_solid_angle();
    return warp::square_to_sphere(u);
  }
  if (u.x < disc_share_) {
    float x = u.x / disc_share_, before = 0.0f;
    const Disc* disc = &discs_.front();
    for (; disc != &discs_.back() && x >= disc->chosen; ++disc) before = disc->chosen;
    x = std::clamp((x - before) / (disc->chosen - before), 0.0f, kOneMinusEpsilon);
    const Vec3 wi = disc->frame.to_world(warp::square_to_cone({x, u.y}, disc->one_minus_cos));
    pdf = pdf_solid_angle(wi);
    if (!disc->contains(wi)) pdf += disc_share_ * disc->density;  // by rounding, at the rim
    return wi;
  }
  u.x = std::min((u.x - disc_share_) / (1.0f - disc_share_), kOneMinusEpsilon);
  float pdf_square;
  const Vec2 point = map_.sample(u, pdf_square);
  const float x = point.x * float(kWidth), y = point.y * float(kHeight);
  const int column = std::min(int(x), kWidth - 1), row = std::min(int(y), kHeight - 1);
  // At an edge of a cell, rounding can lead to the next one.
  pdf_square = map_.pdf_square({(float(column) + 0.5f) / kWidth, (float(row) + 0.5f) / kHeight});
  Vec2 within(x - float(column), y - float(row));
  if (const FineCell* fine = fine_cell(column, row)) {
    float of_part;
    within = fine->distribution.sample(within, of_part);
    pdf_square *= of_part;
  }
  const float top = cos_rows_[size_t(row)], bottom = cos_rows_[size_t(row) + 1];
  const float z = top + within.y * (bottom - top);
  const float r = safe_sqrt((1.0f - z) * (1.0f + z)), phi = 2.0f * kPi * (float(column) + within.x) / float(kWidth);
  const Vec3 wi(r * std::cos(phi), r * std::sin(phi), z);
  pdf = (1.0f - disc_share_) * pdf_square / (2.0f * kPi * float(kHeight) * (top - bottom)) + disc_pdf(wi);
  return wi;
}

float Environment::pdf_solid_angle(Vec3 wi) const {
  if (constant_) return warp::sphere_pdf_solid_angle();
  return (1.0f - disc_share_) * map_pdf(wi) + disc_pdf(wi);
}

float Environment::disc_pdf(Vec3 wi) const {
  float pdf = 0.0f;
  for (const Disc& disc : discs_)
    if (disc.contains(wi)) pdf += disc_share_ * disc.density;
  return pdf;
}

float Environment::map_pdf(Vec3 wi) const {
  // The polar angle gives the row; atan2 keeps it exact at the poles.
  const float theta = std::atan2(std::sqrt(wi.x * wi.x + wi.y * wi.y), wi.z);
  float phi = std::atan2(wi.y, wi.x);
  if (phi < 0.0f) phi += 2.0f * kPi;
  const Vec2 point(phi * (0.5f * kInvPi), theta * kInvPi);
  const int row = std::clamp(int(point.y * float(kHeight)), 0, kHeight - 1);
  const float top = cos_rows_[size_t(row)], bottom = cos_rows_[size_t(row) + 1];
  float pdf_square = map_.pdf_square(point);
  const float x = point.x * float(kWidth);
  const int column = std::clamp(int(x), 0, kWidth - 1);
  if (const FineCell* fine = fine_cell(column, row))
    pdf_square *= fine->distribution.pdf_square({std::clamp(x - float(column), 0.0f, kOneMinusEpsilon),
                                                 std::clamp((top - wi.z) / (top - bottom), 0.0f, kOneMinusEpsilon)});
  return pdf_square / (2.0f * kPi * float(kHeight) * (top - bottom));
}

}  // namespace ajar
