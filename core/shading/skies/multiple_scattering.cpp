// Multiple scattering in an atmosphere (García Liñán 2022, the thesis and sky renderer that Blender's Sky Texture follows
// since 5.0): single scattering with a fit of all further scattering, at four wavelengths, 630, 560, 490 and 430 nm, from
// which a matrix computes XYZ. The radiance along a ray is
//   L = E integral T(eye, p) (s_air (P_air T(p, sun) + M) + s_aerosol (P_aerosol T(p, sun) + M)) dt,
//   M = fit of the air's light + light of the sun that the ground below p reflects.
// Constants, steps and sizes of tables are those of Blender, because its images depend on them.
//
// What depends on altitudes only is the same for all azimuths of a row. So a row computes it once, and a direction only
// adds up the transmittances towards the sun.
#include <algorithm>
#include <array>
#include <cmath>

#include <tbb/parallel_for.h>

#include "shading/skies/atmosphere.h"

namespace ajar::nodes {
namespace {

constexpr float kEarth = 6371.0f, kThickness = 1e-3f * kMultipleAtmosphere;  // kilometres, like all lengths here
constexpr int kSteps = 64;
constexpr float kAnisotropy = 0.8f;  // of aerosols
constexpr float kGroundAlbedo = 0.3f;

const Vec4 kSunIrradiance(1.679f, 1.828f, 1.986f, 1.307f);
const Vec4 kAirScattering(6.605e-3f, 1.067e-2f, 1.842e-2f, 3.156e-2f);  // per kilometre on the ground
/// Cross sections in square centimetres, times the unit of the densities below.
const Vec4 kOzoneAbsorption(3.472e-25f, 3.914e-25f, 1.349e-25f, 1.103e-26f);
const Vec4 kAerosolAbsorption(2.8722e-24f, 4.6168e-24f, 7.9706e-24f, 1.3578e-23f);
const Vec4 kAerosolScattering(1.5908e-22f, 1.7711e-22f, 2.0942e-22f, 2.4033e-22f);
constexpr float kOzoneColumn = 334.5f, kOzoneDensity = 3.78547397e20f;  // Dobson units, and the peak of one unit
constexpr float kAerosolDensity = 1.3681e20f, kAerosolBackground = 2e6f, kAerosolScale = 0.73f;
/// What further scattering by the air adds, relative to the sun's irradiance.
const Vec4 kFurtherScattering(0.02f * 0.217f, 0.02f * 0.347f, 0.02f * 0.594f, 0.02f);
const Vec3 kXyz[4] = {{53.38691774f, 22.98133751f, 0.0f},
                      {43.90484447f, 71.3477957f, 0.10250687f},
                      {1.61372783f, 18.42296059f, 31.74292119f},
                      {20.76266867f, 2.36142135f, 110.48009643f}};

Vec3 to_xyz(Vec4 spectrum) {
  Vec3 xyz(0.0f);
  for (int i = 0; i < 4; ++i) xyz += kXyz[i] * spectrum[i];
  return xyz;
}

/// Coefficients at an altitude, per kilometre.
struct Coefficients {
  Vec4 air, aerosol, extinction;  ///< scattering by air and aerosols; scattering and absorption
};

/// The profiles of air, aerosols and ozone over the altitude, in steps of 12 metres.
class Profiles {
 public:
  explicit Profiles(const Atmosphere& a) : amounts_(kCount + 1) {
    for (int i = 0; i <= kCount; ++i) {
      const float altitude = kThickness * float(i) / kCount, logarithm = std::log(std::max(altitude, 1e-4f));
      amounts_[size_t(i)] = {a.air_density * std::exp(-0.07771971f * std::pow(altitude, 1.16364243f)),
                             a.dust_density * kAerosolDensity *
                                 (std::exp(-altitude / kAerosolScale) + kAerosolBackground / kAerosolDensity),
                             a.ozone_density * kOzoneColumn * kOzoneDensity *
                                 std::exp(-5.55555555f * sqr(logarithm - 3.22261f) - logarithm)};
    }
  }

  Coefficients at(float altitude) const {
    const float place = std::clamp(altitude / kThickness, 0.0f, 1.0f) * kCount;
    const int i = std::min(int(place), kCount - 1);
    const Vec3 amount = glm::mix(amounts_[size_t(i)], amounts_[size_t(i) + 1], place - float(i));
    const Vec4 air = kAirScattering * amount.x, aerosol = kAerosolScattering * amount.y;
    return {air, aerosol, air + aerosol + kAerosolAbsorption * amount.y + kOzoneAbsorption * amount.z};
  }

 private:
  static constexpr int kCount = 8192;
  std::vector<Vec3> amounts_;  ///< air, aerosols, ozone
};

/// The altitude at distance t on a ray from radius r. `cosine` is that between the ray and the vertical.
float altitude_at(float t, float r, float cosine) {
  const float altitude = r - kEarth, gain = altitude * (2.0f * kEarth + altitude) + t * (t + 2.0f * r * cosine);
  return std::max(gain / (std::sqrt(std::max(sqr(kEarth) + gain, 0.0f)) + kEarth), 0.0f);
}

/// The distance from a point of the atmosphere to its end.
float distance_to_end(float r, float cosine) {
  const float rise = r * cosine;
  return std::sqrt(std::max(sqr(rise) + (kEarth + kThickness - r) * (kEarth + kThickness + r), 0.0f)) - rise;
}

/// The part of the sun's light that arrives at an altitude. Rays that pass through the Earth get the density of the
/// ground there, which leaves nothing.
Vec4 transmittance(const Profiles& profiles, float altitude, float cosine) {
  const float r = kEarth + altitude, step = distance_to_end(r, cosine) / kSteps;
  Vec4 depth(0.0f);
  for (int i = 0; i < kSteps; ++i) depth += profiles.at(altitude_at((float(i) + 0.5f) * step, r, cosine)).extinction;
  return glm::exp(-step * depth);
}

/// transmittance() over the cosine, from -1 to 1, and the altitude.
class TransmittanceTable {
 public:
  explicit TransmittanceTable(const Profiles& profiles) : values_(size_t(kCosines) * kAltitudes) {
    tbb::parallel_for(0, kAltitudes, [&](int y) {
      for (int x = 0; x < kCosines; ++x)
        values_[size_t(y) * kCosines + size_t(x)] = transmittance(profiles, kThickness * float(y) / (kAltitudes - 1),
                                                                  2.0f * float(x) / (kCosines - 1) - 1.0f);
    });
  }

  /// Where a value is between two places of the table.
  struct Place {
    int index;
    float part;
  };
  static Place cosine_place(float cosine) { return place(0.5f * cosine + 0.5f, kCosines); }
  static Place altitude_place(float altitude) { return place(altitude / kThickness, kAltitudes); }

  Vec4 at(Place cosine, Place altitude) const {
    const Vec4 *low = values_.data() + size_t(altitude.index) * kCosines + cosine.index, *high = low + kCosines;
    return glm::mix(glm::mix(low[0], low[1], cosine.part), glm::mix(high[0], high[1], cosine.part), altitude.part);
  }
  Vec4 on_ground(Place cosine) const {
    const Vec4* row = values_.data() + cosine.index;
    return glm::mix(row[0], row[1], cosine.part);
  }
  Vec4 from_zenith(float altitude) const { return at({kCosines - 2, 1.0f}, altitude_place(altitude)); }

 private:
  static constexpr int kCosines = 256, kAltitudes = 64;
  static Place place(float t, int size) {
    const float x = std::clamp(t, 0.0f, 1.0f) * float(size - 1);
    const int index = std::min(int(x), size - 2);
    return {index, x - float(index)};
  }
  std::vector<Vec4> values_;
};

/// A step of all rays of one elevation.
struct Step {
  float cosine_offset, cosine_slope;  ///< of the sun there, over the cosine between the ray and the sun
  TransmittanceTable::Place altitude;
  Vec4 air, aerosol;  ///< scattering towards the eye, times the irradiance of the sun
  Vec4 ground;        ///< light of the ground per transmittance and cosine of the sun
};

/// The length of a ray from a radius, to the ground or the end of the atmosphere. Blender subtracts squares in single
/// precision, which matters for the distance of the ground from an eye a few metres above it.
float length_of_ray(float radius, float sine) {
  const float fall = -radius * sine, rest = sqr(fall) - (sqr(radius) - sqr(kEarth));
  return fall >= 0.0f && rest >= 0.0f ? fall - std::sqrt(rest) : distance_to_end(radius, sine);
}

std::array<Step, kSteps> steps_of(const Profiles& profiles, const TransmittanceTable& table, float radius, float sine,
                                  float sun_sine) {
  std::array<Step, kSteps> steps;
  const float length = length_of_ray(radius, sine) / kSteps;
  const Vec4 zenith_of_ground = table.from_zenith(0.0f);
  Vec4 seen_through(1.0f);
  for (int i = 0; i < kSteps; ++i) {
    Step& step = steps[size_t(i)];
    const float t = (float(i) + 0.5f) * length, altitude = altitude_at(t, radius, sine), r = kEarth + altitude;
    const Coefficients here = profiles.at(altitude);
    step.cosine_offset = radius * sun_sine / r;
    step.cosine_slope = t / r;
    step.altitude = TransmittanceTable::altitude_place(altitude);
    // The exact integral of constant scattering and extinction over the step.
    const Vec4 passed = glm::exp(-length * here.extinction);
    const Vec4 weight = seen_through * kSunIrradiance * (1.0f - passed) / glm::max(here.extinction, Vec4(1e-7f));
    step.air = weight * here.air;
    step.aerosol = weight * here.aerosol;
    seen_through *= passed;
    // The ground's light is spread evenly over all directions. The light from the zenith tells what passes between
    // the ground and here.
    const float solid_angle = 2.0f * kPi * (1.0f - safe_sqrt(1.0f - sqr(kEarth / r)));
    step.ground = solid_angle / (4.0f * kPi) * (kGroundAlbedo / kPi) * zenith_of_ground /
                  glm::max(table.from_zenith(altitude), Vec4(1e-30f));
  }
  return steps;
}

/// The radiance in the direction at a cosine to the sun.
Vec4 scattered(const std::array<Step, kSteps>& steps, const TransmittanceTable& table, float view_sun_cosine) {
  const float g = kAnisotropy, spread = 1.0f + g * g - 2.0f * g * view_sun_cosine;
  const float air_phase = 3.0f / (16.0f * kPi) * (1.0f + sqr(view_sun_cosine));
  const float aerosol_phase = (1.0f - g * g) / (4.0f * kPi * spread * std::sqrt(spread));  // Henyey and Greenstein 1941
  Vec4 radiance(0.0f);
  for (const Step& step : steps) {
    const float cosine = step.cosine_offset + step.cosine_slope * view_sun_cosine;
    const TransmittanceTable::Place place = TransmittanceTable::cosine_place(cosine);
    const Vec4 further = kFurtherScattering / (1.0f + 5.0f * std::exp(-17.92f * cosine)) +
                         step.ground * (cosine * table.on_ground(place));
    radiance += (step.air * air_phase + step.aerosol * aerosol_phase) * table.at(place, step.altitude) +
                (step.air + step.aerosol) * further;
  }
  return radiance;
}

}  // namespace

float dip_of_horizon(float altitude) { return 0.5f * kPi - std::asin(kEarth / (kEarth + 1e-3f * altitude)); }

std::vector<Vec3> multiply_scattered_rows(const Atmosphere& a) {
  const Profiles profiles(a);
  const TransmittanceTable transmittances(profiles);
  const float sun_sine = std::sin(a.sun_elevation), sun_cosine = std::cos(a.sun_elevation);
  std::vector<Vec3> table(size_t(kSkyWidth) * 2 * kSkyRows);
  tbb::parallel_for(0, 2 * kSkyRows, [&](int y) {
    const float height = (float(y) + 0.5f) / kSkyRows - 1.0f, elevation = 0.5f * kPi * height * std::abs(height);
    const float sine = std::sin(elevation), cosine = std::cos(elevation);
    const auto steps = steps_of(profiles, transmittances, kEarth + a.altitude / 1000.0f, sine, sun_sine);
    Vec3* row = table.data() + size_t(y) * kSkyWidth;
    for (int x = 0; x < kSkyWidth / 2; ++x) {
      const float azimuth = 2.0f * kPi * (float(x) + 0.5f) / kSkyWidth - kPi;  // relative to the sun
      const float view_sun_cosine = sine * sun_sine + cosine * sun_cosine * std::cos(azimuth);
      row[x] = row[kSkyWidth - 1 - x] = to_xyz(scattered(steps, transmittances, view_sun_cosine));
    }
  });
  return table;
}

Vec3 multiply_scattered_sun(const Atmosphere& a, float elevation) {
  const float solid_angle = 2.0f * kPi * (1.0f - std::cos(0.5f * a.sun_size));
  return to_xyz(kSunIrradiance * transmittance(Profiles(a), a.altitude / 1000.0f, std::sin(elevation)) / solid_angle);
}

}  // namespace ajar::nodes
