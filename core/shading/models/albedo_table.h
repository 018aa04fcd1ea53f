// The light that single scattering of GGX loses between facets: the directional albedo E(cos, alpha) and its
// cosine-weighted mean, for a white mirror and for glass with its own Fresnel reflectance.
//
// Lobes use it to compensate the lost energy (Kulla and Conty 2017; Turquin 2019). The tables are integrated by
// quadrature at the first use, which takes milliseconds and is thread-safe. They are read by linear interpolation.
#pragma once

#include "math/types.h"

namespace ajar::albedo_table {

float ggx(float cosine, float alpha);
float ggx_mean(float alpha);
/// The same for height-correlated masking (microfacet.h).
float ggx_correlated(float cosine, float alpha);
float ggx_correlated_mean(float alpha);
/// Albedo of reflection and transmission together; eta as in fresnel.h.
float ggx_glass(float cosine, float alpha, float eta);
float ggx_glass_mean(float alpha, float eta);
float ggx_glass_correlated(float cosine, float alpha, float eta);
float ggx_glass_correlated_mean(float alpha, float eta);

}  // namespace ajar::albedo_table
