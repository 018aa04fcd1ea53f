#include "shading/bsdf/thin_film.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "math/observer.h"
#include "shading/models/fresnel.h"

namespace ajar::thin_film {
namespace {

using Complex = std::complex<float>;

/// The colour matching functions of RGB as Fourier transforms of their dependence on the frequency 1 / wavelength, by
/// optical path difference. They are normalized to 1 for a difference of 0.
struct Sensitivity {
  static constexpr int kCount = 512;
  static constexpr float kLongest = 60000.0f / (2.0f * kPi);  ///< optical path difference in nanometres
  std::array<std::array<Complex, kCount>, 3> at_difference;

  Sensitivity() {
    constexpr int kWaves = 4 * (observer::kCount - 1);
    std::array<Color, kWaves> matching;
    std::array<double, kWaves> frequency;
    for (int i = 0; i < kWaves; ++i) {
      const float wavelength = observer::kFirst + observer::kStep * (float(i) + 0.5f) / 4.0f;
      frequency[i] = 1.0 / double(wavelength);
      matching[i] = xyz_to_rgb(observer::xyz(wavelength));
    }
    for (int d = 0; d < kCount; ++d) {
      const double difference = double(kLongest) * d / (kCount - 1);
      std::complex<double> sum[3] = {};
      for (int i = 0; i < kWaves; ++i) {
        const std::complex<double> wave = std::polar(1.0, 2.0 * double(kPi) * difference * frequency[i]);
        for (int c = 0; c < 3; ++c) sum[c] += double(matching[i][c]) * wave;
      }
      for (int c = 0; c < 3; ++c) at_difference[c][d] = Complex(sum[c]);
    }
    for (auto& channel : at_difference) {
      const float whole = channel[0].real();
      for (Complex& value : channel) value /= whole;
    }
  }
  Complex at(int channel, float difference) const {
    const float place = std::min(difference / kLongest, 1.0f) * float(kCount - 1);
    const int i = std::clamp(int(place), 0, kCount - 2);
    const float t = place - float(i);
    return (1.0f - t) * at_difference[channel][i] + t * at_difference[channel][i + 1];
  }
};

const Sensitivity& sensitivity() {
  static const Sensitivity table;
  return table;
}

/// A reflection of polarized light.
struct Reflection {
  float reflectance;
  Complex phase;  ///< exp(i phi); 1 for light that keeps its phase
};
struct Polarized {
  Reflection s, p;
};

Reflection reflection(Complex numerator, Complex denominator) {
  // phase = numerator / denominator, of length 1.
  const Complex product = numerator * std::conj(denominator);
  const float below = std::norm(denominator), length = std::abs(product);
  return {below > 0.0f ? std::norm(numerator) / below : 1.0f, length > 0.0f ? product / length : Complex(1.0f)};
}

/// Fresnel's equations between the indices n1 and n2 + ik2 (Born and Wolf, Principles of Optics, section 14.4).
Polarized reflect(float cosine, float n1, float n2, float k2) {
  const Complex index2(n2 * n2 - k2 * k2, 2.0f * n2 * k2);                           // squared index
  const Complex refracted = std::sqrt(index2 - n1 * n1 * (1.0f - cosine * cosine));  // index times cosine below
  return {reflection(n1 * cosine - refracted, n1 * cosine + refracted),
          reflection(index2 * cosine - n1 * refracted, index2 * cosine + n1 * refracted)};
}

/// The sum over light that passes the film up to three more times (Belcour and Barla 2017, eq. 10).
float airy_sum(int channel, const Reflection& top, const Reflection& bottom, float difference) {
  constexpr int kTerms = 3;
  const float passed = 1.0f - top.reflectance, both = top.reflectance * bottom.reflectance;
  if (!(both < 1.0f)) return 1.0f;
  const float through = passed * passed * bottom.reflectance / (1.0f - both), ratio = std::sqrt(both);
  // Light inside the film is reflected at its top with the opposite sign.
  const Complex shift = -bottom.phase * top.phase;
  float sum = top.reflectance + through, factor = through - passed;
  Complex turned = 1.0f;
  for (int m = 1; m <= kTerms; ++m) {
    factor *= ratio;
    turned *= shift;
    sum += 2.0f * factor * (turned * sensitivity().at(channel, float(m) * difference)).real();
  }
  return sum;
}

/// The film from light's side. Below 1 nm its index goes to that of the outside.
struct Path {
  float ior, cos_inside, difference;
  Polarized top;
  bool enters;
};
Path path_into(const ThinFilm& film, float cosine) {
  Path path{film.ior, 0.0f, 0.0f, {}, false};
  if (film.thickness < 1.0f) {
    const float t = saturate(film.thickness);
    path.ior = glm::mix(1.0f, film.ior, t * t * (3.0f - 2.0f * t));
  }
  const float sin2 = (1.0f - cosine * cosine) / (path.ior * path.ior);
  path.enters = sin2 < 1.0f;
  path.cos_inside = safe_sqrt(1.0f - sin2);
  path.difference = 2.0f * path.ior * film.thickness * path.cos_inside;
  path.top = reflect(cosine, 1.0f, path.ior, 0.0f);
  return path;
}

float reflectance(int channel, const Path& path, const Polarized& bottom) {
  return saturate(0.5f * (airy_sum(channel, path.top.s, bottom.s, path.difference) +
                          airy_sum(channel, path.top.p, bottom.p, path.difference)));
}

}  // namespace

Color on_dielectric(const ThinFilm& film, float cos_incident, float eta) {
  const float cosine = std::min(cos_incident, 1.0f);
  const Path path = path_into(film, cosine);
  if (!path.enters || 1.0f - cosine * cosine >= eta * eta) return Color(1.0f);
  const Polarized bottom = reflect(path.cos_inside, path.ior, eta, 0.0f);
  return {reflectance(0, path, bottom), reflectance(1, path, bottom), reflectance(2, path, bottom)};
}

Color on_conductor(const ThinFilm& film, float cos_incident, Color n, Color k) {
  const Path path = path_into(film, std::min(cos_incident, 1.0f));
  Color result(1.0f);
  if (!path.enters) return result;
  for (int c = 0; c < 3; ++c) result[c] = reflectance(c, path, reflect(path.cos_inside, path.ior, n[c], k[c]));
  return result;
}

Color on_metal(const ThinFilm& film, float cos_incident, Color f0, Color f82) {
  const Path path = path_into(film, std::min(cos_incident, 1.0f));
  Color result(1.0f);
  if (!path.enters) return result;
  for (int c = 0; c < 3; ++c) {
    const float r = std::min(f0[c], 0.999f), root = std::sqrt(r);
    const float n = glm::mix((1.0f + root) / (1.0f - root), (1.0f - r) / (1.0f + r), f82[c]);
    const float k = safe_sqrt((r * sqr(n + 1.0f) - sqr(n - 1.0f)) / (1.0f - r));
    Polarized bottom = reflect(path.cos_inside, path.ior, n, k);
    const float below = fresnel::f0_of_conductor(n / path.ior, k / path.ior);
    const Color curve = fresnel::f82(path.cos_inside, Color(below),
                                     fresnel::f82_coefficient_of(Color(below), Color(f82[c])));
    bottom.s.reflectance = bottom.p.reflectance = curve.x;
    result[c] = reflectance(c, path, bottom);
  }
  return result;
}

namespace {

/// The film on the facets of a lobe. `eta` is the lobe's index, or its inverse for light from the other side.
ThinFilm film_of(const Lobe& lobe, float eta) {
  return {lobe.film.thickness, eta == lobe.eta ? lobe.film.ior : lobe.film.ior * eta};
}

/// The reflectance of a dielectric with a film. Where it is near the reflectance f of the bare facet along the normal,
/// it is scaled by f0 / f; where it is near 1, it stays as it is. (As in Cycles; there is no physical model.)
Color dielectric_tint_with_film(const Lobe& lobe, float cosine, float eta) {
  Color reflected = on_dielectric(film_of(lobe, eta), cosine, eta);
  const float at_normal = fresnel::f0_from_eta(eta);
  if (!(at_normal > 1e-5f)) return reflected;
  const Color closeness = glm::clamp((1.0f - reflected) / (1.0f - at_normal), 0.0f, 1.0f);
  return reflected * glm::mix(Color(1.0f), lobe.f0 / at_normal, closeness);
}

}  // namespace

Color on_lobe(const Lobe& lobe, FresnelKind kind, float cosine, float eta) {
  switch (kind) {
    case FresnelKind::DielectricTint: return dielectric_tint_with_film(lobe, cosine, eta);
    case FresnelKind::Conductor: return on_conductor(film_of(lobe, eta), cosine, lobe.f0, lobe.f90);
    case FresnelKind::F82Tint:
      return on_metal(film_of(lobe, eta), cosine, lobe.f0, fresnel::f82(fresnel::kF82Cosine, lobe.f0, lobe.f90));
    case FresnelKind::Dielectric:
    case FresnelKind::None: break;
  }
  return Color(1.0f);
}

}  // namespace ajar::thin_film
