#include "shading/skies/sky.h"

#include <algorithm>
#include <cmath>

#include "shading/functions/color_functions.h"
#include "shading/skies/sky_hosek_data.h"

namespace ajar::nodes {
namespace {

float safe_acos(float x) { return std::acos(std::clamp(x, -1.0f, 1.0f)); }

/// The angle from the zenith, and the azimuth from y towards x.
Vec2 spherical(Vec3 d) { return {safe_acos(d.z), std::atan2(d.x, d.y)}; }

// ---- Analytic models ----------------------------------------------------------------------------------------------

/// Perez et al. (1993): a factor that darkens towards the horizon, times a factor that brightens towards the sun.
float perez(const float* k, float theta, float gamma) {
  const float cosine = std::cos(gamma);
  return (1.0f + k[0] * std::exp(k[1] / std::cos(theta))) *
         (1.0f + k[2] * std::exp(k[3] * gamma) + k[4] * cosine * cosine);
}

/// Hosek and Wilkie (2012), eq. 8.
float hosek(const float* k, float theta, float gamma) {
  const float ct = std::cos(theta), cg = std::cos(gamma);
  const float mie = (1.0f + cg * cg) / std::pow(1.0f + k[8] * k[8] - 2.0f * k[8] * cg, 1.5f);
  return (1.0f + k[0] * std::exp(k[1] / (ct + 0.01f))) *
         (k[2] + k[3] * std::exp(k[4] * gamma) + k[5] * cg * cg + k[6] * mie + k[7] * std::sqrt(ct));
}

/// A quintic Bézier curve over the cube root of the sun's elevation, interpolated linearly in turbidity and ground
/// albedo.
double hosek_coefficient(const float* table, int parameters, int parameter, double turbidity, double albedo,
                         double elevation) {
  const double t = std::cbrt(elevation / (0.5 * M_PI)), s = 1.0 - t;
  const double bernstein[6] = {s * s * s * s * s,        5.0 * s * s * s * s * t, 10.0 * s * s * s * t * t,
                               10.0 * s * s * t * t * t, 5.0 * s * t * t * t * t, t * t * t * t * t};
  const int low = std::min(int(turbidity), 10);
  const double part = turbidity - low;
  double sum = 0.0;
  for (int ground = 0; ground < 2; ++ground)
    for (int high = 0; high < 2; ++high) {
      const double weight = (ground ? albedo : 1.0 - albedo) * (high ? part : 1.0 - part);
      if (weight == 0.0) continue;
      const float* control = table + ((ground * 10 + low - 1 + high) * 6) * parameters + parameter;
      for (int i = 0; i < 6; ++i) sum += weight * bernstein[i] * double(control[i * parameters]);
    }
  return sum;
}

}  // namespace

Sky Sky::preetham(Vec3 to_sun, float turbidity) {
  Sky sky(Model::Preetham);
  const Vec2 sun = spherical(to_sun);
  sky.sun_theta_ = sun.x;
  sky.sun_phi_ = sun.y;
  const float T = turbidity, t = sun.x;
  // Table 2 of the paper's appendix, for the luminance Y and the chromaticities x and y.
  static constexpr float kSlope[3][5] = {{0.1787f, -0.3554f, -0.0227f, 0.1206f, -0.0670f},
                                         {-0.0193f, -0.0665f, -0.0004f, -0.0641f, -0.0033f},
                                         {-0.0167f, -0.0950f, -0.0079f, -0.0441f, -0.0109f}};
  static constexpr float kConstant[3][5] = {{-1.4630f, 0.4275f, 5.3251f, -2.5771f, 0.3703f},
                                            {-0.2592f, 0.0008f, 0.2125f, -0.8989f, 0.0452f},
                                            {-0.2608f, 0.0092f, 0.2102f, -1.6537f, 0.0529f}};
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < 5; ++i) sky.shape_[c][i] = kSlope[c][i] * T + kConstant[c][i];
  const auto cubic = [t](float a, float b, float c, float d) { return ((a * t + b) * t + c) * t + d; };
  const float chi = (4.0f / 9.0f - T / 120.0f) * (kPi - 2.0f * t);
  sky.zenith_ = {
      0.06f * ((4.0453f * T - 4.9710f) * std::tan(chi) - 0.2155f * T + 2.4192f),
      (cubic(0.00166f, -0.00375f, 0.00209f, 0.0f) * T + cubic(-0.02903f, 0.06377f, -0.03202f, 0.00394f)) * T +
          cubic(0.11693f, -0.21196f, 0.06052f, 0.25886f),
      (cubic(0.00275f, -0.00610f, 0.00317f, 0.0f) * T + cubic(-0.04214f, 0.08970f, -0.04153f, 0.00516f)) * T +
          cubic(0.15346f, -0.26756f, 0.06670f, 0.26688f)};
  for (int c = 0; c < 3; ++c) sky.zenith_[c] /= perez(sky.shape_[c], 0.0f, t);
  return sky;
}

Sky Sky::hosek_wilkie(Vec3 to_sun, float turbidity, float ground_albedo) {
  Sky sky(Model::HosekWilkie);
  const Vec2 sun = spherical(to_sun);
  sky.sun_theta_ = std::min(sun.x, 0.5f * kPi);
  sky.sun_phi_ = sun.y;
  const double T = std::clamp(turbidity, 1.0f, 10.0f), elevation = std::max(0.5f * kPi - sky.sun_theta_, 0.0f);
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < 9; ++i)
      sky.shape_[c][i] = float(hosek_coefficient(kHosekConfiguration + c * 1080, 9, i, T, ground_albedo, elevation));
    sky.zenith_[c] = float(hosek_coefficient(kHosekRadiance + c * 120, 1, 0, T, ground_albedo, elevation));
  }
  return sky;
}

namespace {

/// Values in the ranges of Blender, and angles in those that the tables need, for the same sun.
Atmosphere normalized(Atmosphere a, float end) {
  a.altitude = std::clamp(a.altitude, 1.0f, end - 1.0f);  // above the ground and below the end of the atmosphere
  a.sun_size = std::clamp(a.sun_size, 0.0005f, 0.5f * kPi);
  for (float* density : {&a.air_density, &a.dust_density, &a.ozone_density})
    *density = std::clamp(*density, 0.0f, 1000.0f);
  a.sun_elevation = std::remainder(a.sun_elevation, 2.0f * kPi);
  if (std::abs(a.sun_elevation) >= 0.5f * kPi) {  // behind the zenith or the nadir
    a.sun_elevation = std::copysign(kPi, a.sun_elevation) - a.sun_elevation;
    a.sun_rotation += kPi;
  }
  a.sun_rotation = std::fmod(a.sun_rotation, 2.0f * kPi);
  if (a.sun_rotation < 0.0f) a.sun_rotation += 2.0f * kPi;
  a.sun_rotation = 2.0f * kPi - a.sun_rotation;  // from clockwise to counterclockwise
  return a;
}

}  // namespace

Sky::Sky(Model model, const Atmosphere& atmosphere) : model_(model), atmosphere_(atmosphere) {
  const float turn = atmosphere_.sun_rotation + 0.5f * kPi, sun_cosine = std::cos(atmosphere_.sun_elevation);
  sun_direction_ = {sun_cosine * std::cos(turn), sun_cosine * std::sin(turn), std::sin(atmosphere_.sun_elevation)};
}

Sky Sky::nishita(const Atmosphere& given) {
  Sky sky(Model::Nishita, normalized(given, kSingleAtmosphere));
  const Atmosphere& a = sky.atmosphere_;
  sky.sun_bottom_ = singly_scattered_sun(a, a.sun_elevation - 0.5f * a.sun_size);
  sky.sun_top_ = singly_scattered_sun(a, a.sun_elevation + 0.5f * a.sun_size);
  sky.rows_ = kSkyRows;
  sky.table_ = singly_scattered_rows(a, 1.0f + 0.5f / kSkyRows);
  return sky;
}

Sky Sky::single_scattering(const Atmosphere& given) {
  Sky sky(Model::Atmospheric, normalized(given, kSingleAtmosphere));
  const Atmosphere& a = sky.atmosphere_;
  sky.ground_elevation_ = -dip_of_horizon(given.altitude);
  if (a.sun_elevation + 0.5f * a.sun_size > 0.0f) {
    sky.sun_bottom_ = singly_scattered_sun(a, a.sun_elevation - 0.5f * a.sun_size);
    sky.sun_top_ = singly_scattered_sun(a, a.sun_elevation + 0.5f * a.sun_size);
  }
  // Below the horizon the lowest row fades to black.
  const std::vector<Vec3> above = singly_scattered_rows(a, 1.0f);
  sky.rows_ = 2 * kSkyRows;
  sky.table_.reserve(2 * above.size());
  for (int y = 0; y < kSkyRows; ++y) {
    const float depth = std::sin(0.5f * kPi * sqr(float(kSkyRows - y) / kSkyRows));
    const float fade = std::max(1.0f - 2.5f * depth, 0.0f);
    for (int x = 0; x < kSkyWidth; ++x) sky.table_.push_back(above[size_t(x)] * (fade * fade * fade));
  }
  sky.table_.insert(sky.table_.end(), above.begin(), above.end());
  return sky;
}

Sky Sky::multiple_scattering(const Atmosphere& given) {
  Sky sky(Model::Atmospheric, normalized(given, kMultipleAtmosphere));
  const Atmosphere& a = sky.atmosphere_;
  sky.ground_elevation_ = -dip_of_horizon(given.altitude);
  sky.sun_bottom_ = multiply_scattered_sun(a, a.sun_elevation - 0.5f * a.sun_size);
  sky.sun_top_ = multiply_scattered_sun(a, a.sun_elevation + 0.5f * a.sun_size);
  sky.rows_ = 2 * kSkyRows;
  sky.table_ = multiply_scattered_rows(a);
  return sky;
}

Color Sky::radiance(Vec3 direction) const {
  if (!is_finite(direction)) return Color(0.0f);
  switch (model_) {
    case Model::Nishita: return nishita(direction);
    case Model::Atmospheric: return atmospheric(direction);
    default: return analytic(direction);
  }
}

std::optional<Sky::Disc> Sky::sun() const {
  const bool atmosphere = model_ == Model::Nishita || model_ == Model::Atmospheric;
  if (!atmosphere || !atmosphere_.sun_disc ||
      atmosphere_.sun_elevation + 0.5f * atmosphere_.sun_size <= ground_elevation_)
    return {};
  return Disc{sun_direction_, 0.5f * atmosphere_.sun_size};
}

Color Sky::analytic(Vec3 direction) const {
  const Vec2 d = spherical(direction);
  const float gamma = safe_acos(std::sin(d.x) * std::sin(sun_theta_) * std::cos(sun_phi_ - d.y) +
                                std::cos(d.x) * std::cos(sun_theta_));
  const float theta = std::min(d.x, 0.5f * kPi - 0.001f);  // stays at the horizon below it
  Vec3 v;
  for (int c = 0; c < 3; ++c)
    v[c] = zenith_[c] * (model_ == Model::Preetham ? perez(shape_[c], theta, gamma) : hosek(shape_[c], theta, gamma));
  if (model_ == Model::HosekWilkie) return glm::max(xyz_to_rgb(v), 0.0f) * (2.0f * kPi / 683.0f);
  const float Y = v.x, x = v.y, y = v.z;
  return glm::max(xyz_to_rgb(y != 0.0f ? Vec3(x / y * Y, Y, (1.0f - x - y) / y * Y) : Vec3(0.0f, Y, 0.0f)), 0.0f);
}

/// The place in the rows of the table, from 0 to 1.
float Sky::column_of(Vec3 direction) const {
  const float x = (spherical(direction).y + kPi + atmosphere_.sun_rotation) / (2.0f * kPi);
  return x > 1.0f ? x - 1.0f : x;
}

/// From two chords, which are accurate where cosines are not.
float Sky::angle_to_sun(Vec3 direction) const {
  return 2.0f * std::atan2(glm::length(direction - sun_direction_), glm::length(direction + sun_direction_));
}

/// The radiance of the sun at a part of its height and an angle to its centre, with its dark limb.
Vec3 Sky::sun_radiance(float part, float angle) const {
  const float limb = 1.0f - 0.6f * (1.0f - safe_sqrt(1.0f - sqr(2.0f * angle / atmosphere_.sun_size)));
  return (sun_bottom_ + part * (sun_top_ - sun_bottom_)) * atmosphere_.sun_intensity * limb;
}

Vec3 Sky::lookup(float x, float y) const {
  const auto place = [](float t, int size, int& i, int& j) {
    t = std::clamp(t * float(size) - 0.5f, 0.0f, float(size - 1));
    i = std::min(int(t), size - 1), j = std::min(i + 1, size - 1);
    return t - float(i);
  };
  int x0, x1, y0, y1;
  const float tx = place(x, kSkyWidth, x0, x1), ty = place(y, rows_, y0, y1);
  const auto row = [&](int k) {
    return (1.0f - tx) * table_[size_t(k) * kSkyWidth + size_t(x0)] + tx * table_[size_t(k) * kSkyWidth + size_t(x1)];
  };
  return (1.0f - ty) * row(y0) + ty * row(y1);
}

Color Sky::nishita(Vec3 direction) const {
  const Atmosphere& a = atmosphere_;
  const float x = column_of(direction);
  if (direction.z < 0.0f) {  // below the horizon the sky fades to black
    if (direction.z < -0.4f) return Color(0.0f);
    const float fade = 1.0f + 2.5f * direction.z;
    return glm::max(xyz_to_rgb(lookup(x, -0.5f) * fade * fade * fade), 0.0f);
  }
  const float elevation = 0.5f * kPi - spherical(direction).x, radius = 0.5f * a.sun_size;
  if (a.sun_disc) {
    const float angle = angle_to_sun(direction);
    if (angle < radius && a.sun_elevation + radius > 0.0f) {
      const float t = a.sun_elevation > radius ? (elevation - a.sun_elevation) / a.sun_size + 0.5f
                                               : elevation / (a.sun_elevation + radius);
      return glm::max(xyz_to_rgb(sun_radiance(t, angle)), 0.0f);
    }
  }
  return glm::max(xyz_to_rgb(lookup(x, safe_sqrt(elevation / (0.5f * kPi)))), 0.0f);
}

Color Sky::atmospheric(Vec3 direction) const {
  const Atmosphere& a = atmosphere_;
  const float elevation = 0.5f * kPi - spherical(direction).x;
  const float height = std::copysign(std::sqrt(std::abs(elevation) / (0.5f * kPi)), elevation);
  Vec3 xyz = lookup(column_of(direction), 0.5f + 0.5f * height);
  if (a.sun_disc && elevation > ground_elevation_)
    if (const float angle = angle_to_sun(direction); angle < 0.5f * a.sun_size)
      xyz += sun_radiance((elevation - a.sun_elevation) / a.sun_size + 0.5f, angle);
  return glm::max(xyz_to_rgb(xyz), 0.0f);
}

}  // namespace ajar::nodes
