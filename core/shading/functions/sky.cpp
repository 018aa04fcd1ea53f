#include "shading/functions/sky.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <tbb/parallel_for.h>

#include "shading/functions/color_functions.h"
#include "shading/functions/sky_hosek_data.h"

namespace ajar::nodes {
namespace {

float safe_acos(float x) { return std::acos(std::clamp(x, -1.0f, 1.0f)); }

/// The angle from the zenith, and the azimuth from y towards x.
Vec2 spherical(Vec3 d) { return {safe_acos(d.z), std::atan2(d.x, d.y)}; }

// ---- Single scattering [Nishita et al. 1993] with ozone, at 21 wavelengths from 380 to 780 nm ---------------------
//
// The radiance along a ray is the sunlight that each of its points scatters towards the eye:
//   L = E integral T(eye, p) (beta_air rho_air(p) P_air + beta_dust rho_dust(p) P_dust) T(p, sun) dt,
//   T = exp(-sum of columns * coefficients).
// The Earth is a sphere, so a point needs no coordinates: its altitude, and the cosine between the vertical and a
// direction, determine everything along that direction. Constants and quadratures are those of Blender, because its
// images depend on them.

constexpr int kWavelengths = 21;
constexpr float kWavelengthStep = 20.0f;
constexpr int kWidth = 512, kHeight = 128;  // size of the table: azimuth, elevation (denser near the horizon)
constexpr int kViewSteps = 32;
constexpr float kEarthRadius = 6360e3f, kAtmosphere = 60e3f;  // metres; kAtmosphere is the altitude of its end
constexpr float kDustScattering = 2e-5f, kDustExtinction = 1.11f * kDustScattering;  // Mie, per metre
constexpr float kDustAnisotropy = 0.76f;

/// Irradiance above the atmosphere in W m^-2 nm^-1.
constexpr float kSunIrradiance[kWavelengths] = {
    1.4575683f, 1.565963f,   1.6514845f, 1.71496243f, 1.75797984f, 1.782564f,   1.7909511f,
    1.7854155f, 1.76815555f, 1.7412207f, 1.7064713f,  1.6655609f,  1.61993437f, 1.570836f,
    1.5193234f, 1.466285f,   1.4124585f, 1.3584496f,  1.3047491f,  1.2517496f,  1.19976f};
/// Scattering by air and absorption by ozone per metre, at their maximum densities.
constexpr float kAirScattering[kWavelengths] = {
    5.42482e-05f,    4.4185499e-05f, 3.6351519e-05f,  3.017929e-05f,  2.5263202e-05f, 2.1308593e-05f, 1.809838e-05f,
    1.54705713e-05f, 1.330285e-05f,  1.15018478e-05f, 9.995574e-06f,  8.728e-06f,     7.655137e-06f,  6.742172e-06f,
    5.9613413e-06f,  5.290346e-06f,  4.711157e-06f,   4.2091048e-06f, 3.7721838e-06f, 3.3905126e-06f, 3.0559153e-06f};
constexpr float kOzoneAbsorption[kWavelengths] = {
    3.2512685e-09f, 5.8539537e-09f, 1.9771912e-08f, 7.30956876e-08f, 2.0084562e-07f,  4.0383958e-07f,  6.3551336e-07f,
    9.670704e-07f,  1.547974e-06f,  2.0903865e-06f, 2.46128056e-06f, 2.735513e-06f,   2.15125863e-06f, 1.5905184e-06f,
    1.123562e-06f,  7.3527551e-07f, 4.645013e-07f,  3.309608e-07f,   2.25126123e-07f, 1.4879129e-07f,  1.6828623e-07f};
/// The colour matching functions of the CIE 1931 observer.
constexpr float kObserver[kWavelengths][3] = {{0.001368f, 3.9e-05f, 0.006450001f},
                                              {0.01431f, 0.000396f, 0.06785001f},
                                              {0.13438f, 0.004f, 0.6456f},
                                              {0.34828f, 0.023f, 1.74706f},
                                              {0.2908f, 0.06f, 1.6692f},
                                              {0.09564f, 0.13902f, 0.8129501f},
                                              {0.0049f, 0.323f, 0.272f},
                                              {0.06327f, 0.71f, 0.07824999f},
                                              {0.2904f, 0.954f, 0.0203f},
                                              {0.5945f, 0.995f, 0.0039f},
                                              {0.9163f, 0.87f, 0.001650001f},
                                              {1.0622f, 0.631f, 0.0008f},
                                              {0.8544499f, 0.381f, 0.00019f},
                                              {0.4479f, 0.175f, 2e-05f},
                                              {0.1649f, 0.061f, 0.0f},
                                              {0.04677f, 0.017f, 0.0f},
                                              {0.01135916f, 0.004102f, 0.0f},
                                              {0.002899327f, 0.001047f, 0.0f},
                                              {0.0006900786f, 0.0002492f, 0.0f},
                                              {0.0001661505f, 6e-05f, 0.0f},
                                              {4.150994e-05f, 1.499e-05f, 0.0f}};

using Spectrum = std::array<float, kWavelengths>;

Vec3 to_xyz(const Spectrum& spectrum) {
  Vec3 xyz(0.0f);
  for (size_t i = 0; i < spectrum.size(); ++i)
    xyz += spectrum[i] * Vec3(kObserver[i][0], kObserver[i][1], kObserver[i][2]);
  return xyz * kWavelengthStep;
}

/// Amounts of the three constituents: densities relative to their maxima, or columns, which are densities times metres.
struct Constituents {
  float air = 0.0f, dust = 0.0f, ozone = 0.0f;

  Constituents& add(const Constituents& other, float factor) {
    air += other.air * factor, dust += other.dust * factor, ozone += other.ozone * factor;
    return *this;
  }
  /// For a column: the fraction of the light of a wavelength that passes it.
  float transmittance(int wavelength) const {
    return std::exp(
        -(air * kAirScattering[wavelength] + dust * kDustExtinction + ozone * kOzoneAbsorption[wavelength]));
  }
};

/// The densities of air and dust decrease exponentially, with scale heights of 8 and 1.2 km. Ozone is a layer around 25
/// km, from 10 to 40 km.
Constituents densities_at(float altitude) {
  return {std::exp(-altitude / 8e3f), std::exp(-altitude / 1.2e3f),
          std::max(1.0f - std::abs(altitude - 25e3f) / 15e3f, 0.0f)};
}
Constituents scaled(const Constituents& c, const Atmosphere& a) {
  return {c.air * a.air_density, c.dust * a.dust_density, c.ozone * a.ozone_density};
}

/// A ray from a given altitude. `cosine` is the cosine between the ray and the vertical.
class AtmosphericRay {
 public:
  AtmosphericRay(float altitude, float cosine)
      : rise_((kEarthRadius + altitude) * cosine),
        excess_(excess_of(altitude)),
        length_(forward_root(excess_of(kAtmosphere) - excess_)) {}

  /// Distance to the end of the atmosphere.
  float length() const { return length_; }

  /// The altitude at distance t. It uses only the part of the squared radius beyond that of the Earth, because
  /// subtracting radii of thousands of kilometres would lose the metres.
  float altitude_at(float t) const {
    const float excess = excess_ + t * (t + 2.0f * rise_);
    return excess / (std::sqrt(sqr(kEarthRadius) + excess) + kEarthRadius);
  }

  /// True if the line of the ray, in both directions, passes through the Earth.
  bool line_meets_earth() const { return sqr(rise_) >= excess_; }

  /// The densities, integrated over the ray by Gauss-Laguerre quadrature, which suits functions that decrease
  /// exponentially. The nodes (Abramowitz and Stegun, table 25.9, n = 8) are divided by 25, so that the last node is
  /// still inside the atmosphere. The weights are those of the table that contain exp(x).
  Constituents column() const {
    static constexpr float kNodes[8] = {0.170279632305f, 0.903701776799f, 2.251086629866f,  4.266700170288f,
                                        7.045905402393f, 10.75851601018f, 15.740678641278f, 22.863131736889f};
    static constexpr float kWeights[8] = {0.437723410493f, 1.033869347666f, 1.669709765659f, 2.376924701759f,
                                          3.208540913348f, 4.268575510825f, 5.818083368672f, 8.906226215292f};
    const float scale = length_ / 25.0f;
    Constituents sum;
    for (int i = 0; i < 8; ++i) sum.add(densities_at(altitude_at(kNodes[i] * scale)), kWeights[i] * scale);
    return sum;
  }

 private:
  /// (R + altitude)^2 - R^2
  static float excess_of(float altitude) { return altitude * (2.0f * kEarthRadius + altitude); }
  /// The positive root t of t^2 + 2 rise t = gain, without cancellation.
  float forward_root(float gain) const {
    const float root = std::sqrt(sqr(rise_) + gain);
    return rise_ > 0.0f ? gain / (root + rise_) : root - rise_;
  }

  float rise_;    ///< radius times cosine: half of the increase of the squared radius per metre at the start
  float excess_;  ///< excess_of the altitude at the start
  float length_;
};

float rayleigh_phase(float cosine) { return 3.0f / (16.0f * kPi) * (1.0f + sqr(cosine)); }

/// Cornette and Shanks 1992, which Nishita et al. use for dust.
float dust_phase(float cosine) {
  const float g = kDustAnisotropy, normalization = 3.0f * (1.0f - g * g) / (8.0f * kPi * (2.0f + g * g));
  return normalization * (1.0f + sqr(cosine)) / std::pow(1.0f + g * g - 2.0f * g * cosine, 1.5f);
}

/// The radiance of the sky in XYZ. Only three numbers of the directions are needed: the sines of the elevations of the
/// ray and of the sun, and the cosine between both.
Vec3 scattered(const Atmosphere& a, float view_sine, float sun_sine, float view_sun_cosine) {
  const AtmosphericRay view(a.altitude, view_sine);
  const float step = view.length() / kViewSteps, air_phase = rayleigh_phase(view_sun_cosine),
              dust = dust_phase(view_sun_cosine);
  Spectrum radiance{};
  Constituents seen_through;
  for (int i = 0; i < kViewSteps; ++i) {
    const float t = (float(i) + 0.5f) * step, altitude = view.altitude_at(t);
    const Constituents here = scaled(densities_at(altitude), a);
    seen_through.add(here, step);
    // The projections on the direction of the sun are summed along the ray.
    const float sun_cosine = ((kEarthRadius + a.altitude) * sun_sine + t * view_sun_cosine) / (kEarthRadius + altitude);
    const AtmosphericRay to_sun(altitude, sun_cosine);
    // As in Blender, there is no shadow while the sun is above the eye's horizontal plane. Otherwise a point is in
    // shadow if the Earth is on the line to the sun, in front of the point or behind it.
    if (sun_sine < 0.0f && to_sun.line_meets_earth()) continue;
    const Constituents through = scaled(to_sun.column(), a).add(seen_through, 1.0f);
    for (int k = 0; k < kWavelengths; ++k) {
      const float scattering = here.air * kAirScattering[k] * air_phase + here.dust * kDustScattering * dust;
      radiance[size_t(k)] += step * kSunIrradiance[k] * scattering * through.transmittance(k);
    }
  }
  return to_xyz(radiance);
}

/// The radiance of the sun at an elevation, in XYZ. Ozone does not dim it, as in Blender.
Vec3 sun_radiance(const Atmosphere& a, float elevation) {
  Constituents through = scaled(AtmosphericRay(a.altitude, std::sin(elevation)).column(), a);
  through.ozone = 0.0f;
  const float solid_angle = 2.0f * kPi * (1.0f - std::cos(0.5f * a.sun_size));
  Spectrum radiance;
  for (int k = 0; k < kWavelengths; ++k)
    radiance[size_t(k)] = kSunIrradiance[k] / solid_angle * through.transmittance(k);
  return to_xyz(radiance);
}

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
  Sky sky;
  sky.model_ = Model::Preetham;
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
  Sky sky;
  sky.model_ = Model::HosekWilkie;
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

Sky Sky::nishita(const Atmosphere& given) {
  Sky sky;
  sky.model_ = Model::Nishita;
  Atmosphere& a = sky.atmosphere_ = given;
  a.altitude = std::clamp(a.altitude, 1.0f, 59999.0f);  // above the ground and below the end of the atmosphere
  a.sun_size = std::max(a.sun_size, 0.0005f);
  a.sun_rotation = std::fmod(a.sun_rotation, 2.0f * kPi);
  if (a.sun_rotation < 0.0f) a.sun_rotation += 2.0f * kPi;
  a.sun_rotation = 2.0f * kPi - a.sun_rotation;  // from clockwise to counterclockwise
  const float sun_sine = std::sin(a.sun_elevation), sun_cosine = std::cos(a.sun_elevation),
              turn = a.sun_rotation + 0.5f * kPi;
  sky.sun_direction_ = {sun_cosine * std::cos(turn), sun_cosine * std::sin(turn), sun_sine};

  const float radius = 0.5f * a.sun_size;
  sky.sun_bottom_ = sun_radiance(a, std::max(a.sun_elevation - radius, 0.0f));
  sky.sun_top_ = sun_radiance(a, std::max(a.sun_elevation + radius, 0.0f));

  // The sky is symmetric about the sun, so half of each row is computed. The elevation of a row grows with the square
  // of its index.
  sky.table_.resize(size_t(kWidth) * kHeight);
  tbb::parallel_for(0, kHeight, [&](int y) {
    const float elevation = 0.5f * kPi * (1.0f + 0.5f / kHeight) * sqr(float(y) / kHeight);
    const float view_sine = std::sin(elevation), view_cosine = std::cos(elevation);
    Vec3* row = sky.table_.data() + size_t(y) * kWidth;
    for (int x = 0; x < kWidth / 2; ++x) {
      const float azimuth = 2.0f * kPi * float(x) / kWidth - kPi;  // relative to the sun
      const float view_sun_cosine = view_sine * sun_sine + view_cosine * sun_cosine * std::cos(azimuth);
      row[x] = row[kWidth - 1 - x] = scattered(a, view_sine, sun_sine, view_sun_cosine);
    }
  });
  return sky;
}

Color Sky::radiance(Vec3 direction) const {
  if (!is_finite(direction)) return Color(0.0f);
  return model_ == Model::Nishita ? atmospheric(direction) : analytic(direction);
}

std::optional<Sky::Disc> Sky::sun() const {
  if (model_ != Model::Nishita || !atmosphere_.sun_disc ||
      atmosphere_.sun_elevation + 0.5f * atmosphere_.sun_size <= 0.0f)
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

Vec3 Sky::lookup(float x, float y) const {
  const auto place = [](float t, int size, int& i, int& j) {
    t = std::clamp(t * float(size) - 0.5f, 0.0f, float(size - 1));
    i = std::min(int(t), size - 1), j = std::min(i + 1, size - 1);
    return t - float(i);
  };
  int x0, x1, y0, y1;
  const float tx = place(x, kWidth, x0, x1), ty = place(y, kHeight, y0, y1);
  const auto row = [&](int k) {
    return (1.0f - tx) * table_[size_t(k) * kWidth + size_t(x0)] + tx * table_[size_t(k) * kWidth + size_t(x1)];
  };
  return (1.0f - ty) * row(y0) + ty * row(y1);
}

Color Sky::atmospheric(Vec3 direction) const {
  const Atmosphere& a = atmosphere_;
  const Vec2 d = spherical(direction);
  float x = (d.y + kPi + a.sun_rotation) / (2.0f * kPi);
  if (x > 1.0f) x -= 1.0f;
  if (direction.z < 0.0f) {  // below the horizon the sky fades to black
    if (direction.z < -0.4f) return Color(0.0f);
    const float fade = 1.0f + 2.5f * direction.z;
    return glm::max(xyz_to_rgb(lookup(x, -0.5f) * fade * fade * fade), 0.0f);
  }
  const float elevation = 0.5f * kPi - d.x, radius = 0.5f * a.sun_size;
  if (a.sun_disc) {
    // The half angle from two chords is accurate where cosines are not.
    const float angle = 2.0f *
                        std::atan2(glm::length(direction - sun_direction_), glm::length(direction + sun_direction_));
    if (angle < radius && a.sun_elevation + radius > 0.0f) {
      const float bottom = std::max(a.sun_elevation - radius, 0.0f);
      const float t = bottom > 0.0f ? (elevation - a.sun_elevation) / a.sun_size + 0.5f
                                    : elevation / (a.sun_elevation + radius);
      const float limb = 1.0f - 0.6f * (1.0f - safe_sqrt(1.0f - sqr(angle / radius)));
      return glm::max(xyz_to_rgb((sun_bottom_ + t * (sun_top_ - sun_bottom_)) * a.sun_intensity * limb), 0.0f);
    }
  }
  return glm::max(xyz_to_rgb(lookup(x, safe_sqrt(elevation / (0.5f * kPi)))), 0.0f);
}

}  // namespace ajar::nodes
