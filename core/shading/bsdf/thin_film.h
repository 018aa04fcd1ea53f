// Interference in a thin film on a facet, after Belcour and Barla 2017 ("A Practical Extension to Microfacet Theory for
// the Modeling of Varying Iridescence"). The reflectance is a series over the number of passes through the film. Its
// terms are integrated over the spectrum in advance, as Fourier transforms of the colour matching functions over
// frequencies.
#pragma once

#include "math/types.h"
#include "shading/bsdf/bsdf.h"

namespace ajar::thin_film {

/// Thinner films have no effect, as in Cycles.
constexpr float kThinnest = 0.1f;

/// The reflectance of a film on a dielectric of index `eta`, without polarization. 1 beyond a critical angle.
Color on_dielectric(const ThinFilm& film, float cos_incident, float eta);
/// The same on a conductor of index n + ik.
Color on_conductor(const ThinFilm& film, float cos_incident, Color n, Color k);
/// The same on a metal with the reflectance `f0` along the normal and `f82` at the cosine 1/7. Its index is estimated
/// from both (Gulbrandsen 2014, "Artist Friendly Metallic Fresnel"), and its reflectance below the film is the curve
/// fresnel::f82.
Color on_metal(const ThinFilm& film, float cos_incident, Color f0, Color f82);

/// The reflectance of the facets of a lobe with a film, for a kind of Fresnel curve; white if it is None. `eta` is the
/// index of the lobe, or its inverse for light from the other side.
Color on_lobe(const Lobe& lobe, FresnelKind kind, float cosine, float eta);

}  // namespace ajar::thin_film
