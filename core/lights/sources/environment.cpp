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

std::vector<float> Environment::evaluate_corners(const std::vector<SkyDisc>& discs) const {
  std::vector<float> corners(size_t(kWidth) * (kHeight + 1));
  const auto corner = [&](int x, int y) -> float& { return corners[size_t(y) * kWidth + size_t(x % kWidth)]; };
  const auto evaluate_at = [&](int x, int y) {
    const double theta = M_PI * y / kHeight, phi = 2.0 * M_PI * x / kWidth, sin_theta = std::sin(theta);
    const Vec3 wi(float(sin_theta * std::cos(phi)), float(sin_theta * std::sin(phi)), float(std::cos(theta)));
    const bool in_disc = std::any_of(discs.begin(), discs.end(), [&](const SkyDisc& disc) {
      return glm::dot(wi, disc.direction) > std::cos(disc.angular_radius);
    });
    corner(x, y) = in_disc ? 0.0f : weight(evaluate(*program_, wi, 0));
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

  const std::vector<SkyDisc> discs = program_->sky_discs();
  const std::vector<float> corners = evaluate_corners(discs);

  std::vector<float> cells(size_t(kWidth) * kHeight);
  double sum = 0.0;
  for (int y = 0; y < kHeight; ++y) {
    const float* above = corners.data() + size_t(y) * kWidth;
    const float* below = above + kWidth;
    for (int x = 0; x < kWidth; ++x) {
      const int next = (x + 1) % kWidth;
      const float mean = 0.25f * (above[x] + above[next] + below[x] + below[next]);
      cells[size_t(y) * kWidth + size_t(x)] = mean;
      sum += double(mean) * part_of_sphere(y);
    }
  }
  for (const SkyDisc& disc : discs) sum += add_disc(disc, cells);
  // If all corners are black, there can still be radiance between them. The density then has only the floor.
  mean_luminance_ = sum > 0.0 ? float(sum) : 1e-6f;
  double excess = 0.0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      float& cell = cells[size_t(y) * kWidth + size_t(x)];
      const float above_mean = std::max(0.0f, cell - mean_luminance_);
      excess += double(above_mean) * part_of_sphere(y);
      cell = (above_mean + kFloor * mean_luminance_) * part_of_sphere(y);
    }
  }
  excess_luminance_ = float(excess);
  map_ = Distribution2D(cells, kWidth, kHeight);
}

float Environment::part_of_sphere(int row) const {
  return 0.5f * (cos_rows_[size_t(row)] - cos_rows_[size_t(row) + 1]) / float(kWidth);
}

// A small sun can be between the corners of cells, or count for whole cells. The light of suns is therefore added at
// points of spirals with equal areas (Vogel 1979). A cell of the rim that got no light would be sampled too rarely for
// its radiance, so the points of the rim are denser.
double Environment::add_disc(const SkyDisc& disc, std::vector<float>& cells) const {
  constexpr float kInside = 16.0f, kRim = 256.0f;  // points for each cell at the horizon
  constexpr float kRimWidth = 2.0f * kPi / kHeight;
  constexpr double kGoldenTurn = 0.6180339887498949;
  const Frame frame(disc.direction);
  double sum = 0.0;
  const auto add = [&](float inner, float outer, float density) {
    const float low = warp::one_minus_cos(inner),
                area = 0.5f * (warp::one_minus_cos(outer) - low);  // as a part of the sphere
    const int count = std::max(1024, int(density * area / part_of_sphere(kHeight / 2)));
    for (int i = 0; i < count; ++i) {
      const float height = low + 2.0f * area * (float(i) + 0.5f) / float(count),
                  r = safe_sqrt(height * (2.0f - height));
      const float phi = 2.0f * kPi * float(i * kGoldenTurn - std::floor(i * kGoldenTurn));
      const Vec3 wi = frame.to_world({r * std::cos(phi), r * std::sin(phi), 1.0f - height});
      const float azimuth = std::atan2(wi.y, wi.x) * (0.5f * kInvPi);
      const int x = int((azimuth < 0.0f ? azimuth + 1.0f : azimuth) * kWidth);
      const int y = std::clamp(int(std::acos(std::clamp(wi.z, -1.0f, 1.0f)) * kInvPi * kHeight), 0, kHeight - 1);
      const float sent = weight(evaluate(*program_, wi, 0)) * area / float(count);
      // Near the poles, a point stands for all the narrow cells that are as wide as one at the horizon.
      const int wide = std::clamp(int(1.0f / std::max(std::hypot(wi.x, wi.y), 1e-4f)), 1, kWidth);
      for (int k = 0; k < wide; ++k)
        cells[size_t(y) * kWidth + size_t((x - wide / 2 + k + kWidth) % kWidth)] += sent /
                                                                                    (part_of_sphere(y) * float(wide));
      sum += double(sent);
    }
  };
  const float inside = std::max(disc.angular_radius - kRimWidth, 0.0f);
  if (inside > 0.0f) add(0.0f, inside, kInside);
  add(inside, disc.angular_radius, kRim);
  return sum;
}

Color Environment::radiance(Vec3 wi, uint32_t ray_kind) const {
  if (!program_ || visibility_ == 0) return Color(0.0f);
  if (visibility_ != kVisibleAll) {
    const auto hidden_from = [&](uint32_t kinds, uint32_t bit) { return (ray_kind & kinds) && !(visibility_ & bit); };
    if (hidden_from(kRayCamera, kVisibleCamera) || hidden_from(kRayDiffuse, kVisibleDiffuse) ||
        hidden_from(kRayGlossy, kVisibleGlossy) || hidden_from(kRayTransmission, kVisibleTransmission) ||
        hidden_from(kRayVolumeScatter, kVisibleVolumeScatter))
      return Color(0.0f);
  }
  return constant_ ? constant_radiance_ : evaluate(*program_, wi, ray_kind);
}

Vec3 Environment::sample(Vec2 u, float& pdf) const {
  if (constant_) {
    pdf = warp::sphere_pdf_solid_angle();
    return warp::square_to_sphere(u);
  }
  float pdf_square;
  const Vec2 point = map_.sample(u, pdf_square);
  const float y = point.y * float(kHeight);
  const int row = std::min(int(y), kHeight - 1);
  const float top = cos_rows_[size_t(row)], bottom = cos_rows_[size_t(row) + 1];
  const float z = top + (y - float(row)) * (bottom - top);
  const float r = safe_sqrt((1.0f - z) * (1.0f + z)), phi = 2.0f * kPi * point.x;
  pdf = pdf_square / (2.0f * kPi * float(kHeight) * (top - bottom));
  return {r * std::cos(phi), r * std::sin(phi), z};
}

float Environment::pdf_solid_angle(Vec3 wi) const {
  if (constant_) return warp::sphere_pdf_solid_angle();
  // The polar angle gives the row; atan2 keeps it exact at the poles.
  const float theta = std::atan2(std::sqrt(wi.x * wi.x + wi.y * wi.y), wi.z);
  float phi = std::atan2(wi.y, wi.x);
  if (phi < 0.0f) phi += 2.0f * kPi;
  const Vec2 point(phi * (0.5f * kInvPi), theta * kInvPi);
  const int row = std::clamp(int(point.y * float(kHeight)), 0, kHeight - 1);
  const float top = cos_rows_[size_t(row)], bottom = cos_rows_[size_t(row) + 1];
  return map_.pdf_square(point) / (2.0f * kPi * float(kHeight) * (top - bottom));
}

}  // namespace ajar
