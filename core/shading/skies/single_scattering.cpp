#include "shading/skies/atmosphere.h"

#include <array>
#include <cmath>

#include <tbb/parallel_for.h>

namespace ajar::nodes {
namespace {

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
constexpr int kViewSteps = 32;
constexpr float kEarthRadius = 6360e3f;                                              // metres
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
        length_(forward_root(excess_of(kSingleAtmosphere) - excess_)) {}

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

}  // namespace

std::vector<Vec3> singly_scattered_rows(const Atmosphere& a, float stretch) {
  const float sun_sine = std::sin(a.sun_elevation), sun_cosine = std::cos(a.sun_elevation);
  std::vector<Vec3> table(size_t(kSkyWidth) * kSkyRows);
  tbb::parallel_for(0, kSkyRows, [&](int y) {
    const float elevation = 0.5f * kPi * stretch * sqr(float(y) / kSkyRows);
    const float view_sine = std::sin(elevation), view_cosine = std::cos(elevation);
    Vec3* row = table.data() + size_t(y) * kSkyWidth;
    for (int x = 0; x < kSkyWidth / 2; ++x) {
      const float azimuth = 2.0f * kPi * float(x) / kSkyWidth - kPi;  // relative to the sun
      const float view_sun_cosine = view_sine * sun_sine + view_cosine * sun_cosine * std::cos(azimuth);
      row[x] = row[kSkyWidth - 1 - x] = scattered(a, view_sine, sun_sine, view_sun_cosine);
    }
  });
  return table;
}

Vec3 singly_scattered_sun(const Atmosphere& a, float elevation) {
  Constituents through = scaled(AtmosphericRay(a.altitude, std::sin(std::max(elevation, 0.0f))).column(), a);
  through.ozone = 0.0f;
  const float solid_angle = 2.0f * kPi * (1.0f - std::cos(0.5f * a.sun_size));
  Spectrum radiance;
  for (int k = 0; k < kWavelengths; ++k)
    radiance[size_t(k)] = kSunIrradiance[k] / solid_angle * through.transmittance(k);
  return to_xyz(radiance);
}

}  // namespace ajar::nodes
