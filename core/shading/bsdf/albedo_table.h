// How much light single scattering of GGX loses between the facets: directional albedo E(cos, alpha) and its
// cosine-weighted mean, for a white mirror and for glass with its own Fresnel reflectance.
//
// Used to put the lost energy back (Kulla and Conty 2017; Turquin 2019). The tables are integrated by quadrature at
// first use (milliseconds; thread-safe) and read by linear interpolation.
#pragma once

#include "math/types.h"

namespace ajar::albedo_table {

float ggx(float cosine, float alpha);
float ggx_mean(float alpha);
/// The same under height-correlated masking (microfacet.h).
float ggx_correlated(float cosine, float alpha);
float ggx_correlated_mean(float alpha);
/// Reflected plus transmitted; eta as in fresnel.h.
float ggx_glass(float cosine, float alpha, float eta);
float ggx_glass_mean(float alpha, float eta);

}  // namespace ajar::albedo_table
