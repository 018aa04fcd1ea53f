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

/// The mean of the position between f0 and f90 (fresnel::dielectric_position) over the visible facets of a dielectric. Facets
/// that reflect light below the surface count as 0. Light that is lost between facets does not matter. With eta and 1 / eta
/// the result is the same. As in Cycles, 16 values along each axis are interpolated linearly: cosine, roughness, and the
/// fourth root of f0. A slice for one f0 is made when it is first used.
float dielectric_position(float cosine, float alpha, float eta);

}  // namespace ajar::albedo_table
