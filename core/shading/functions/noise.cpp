#include "shading/functions/noise.h"

#include <algorithm>
#include <bit>

#include "math/hash.h"

namespace ajar::nodes {
namespace {

// The hash of a lattice point selects its gradient g. The lattice point contributes the dot product of g and the
// distance d from it. In three dimensions the gradients are those of Perlin 2002 ("Improving Noise"): the directions to
// the centres of the twelve edges of a cube. In four dimensions one component is zero and the others are 1 or -1. In
// one and two dimensions the gradients are Blender's: slopes from 1 to 8 with both signs, and (1, 2) and (2, 1) with
// all signs. The numbering is part of the definition. There are no tables, so the compiler can vectorise over the
// corners of a cell.

/// x or -x; the given bit of the number is the sign.
inline float with_sign(float x, uint32_t number, int bit) {
  return std::bit_cast<float>(std::bit_cast<uint32_t>(x) ^ (number >> bit << 31));
}

inline float contribution(uint32_t hash, const float (&d)[1]) {
  return with_sign(float(int(hash % 8) + 1) * d[0], hash, 3);
}
inline float contribution(uint32_t hash, const float (&d)[2]) {
  const bool along_y = hash % 8 < 4;  // the axis of the component 2
  return with_sign(along_y ? d[0] : d[1], hash, 0) + 2.0f * with_sign(along_y ? d[1] : d[0], hash, 1);
}
inline float contribution(uint32_t hash, const float (&d)[3]) {
  // Numbers 0 to 3 have no component along z, 4 to 7 none along y, 8 to 11 none along x. Perlin extends these twelve
  // edges to sixteen numbers by four that form a tetrahedron: 12 and 14 are in the plane of x and y, 13 and 15 in that
  // of y and z.
  const uint32_t number = hash & 15u;
  const float first = number < 8 ? d[0] : d[1];
  const float second = number < 4 ? d[1] : (number & 13u) == 12 ? d[0] : d[2];
  return with_sign(first, hash, 0) + with_sign(second, hash, 1);
}
/// The component that is 0 is w for numbers 0 to 7, then z, y, x. The lowest three bits are the signs of the others.
inline float contribution(uint32_t hash, const float (&d)[4]) {
  const uint32_t number = hash & 31u;
  return with_sign(number < 24 ? d[0] : d[1], hash, 0) + with_sign(number < 16 ? d[1] : d[2], hash, 1) +
         with_sign(number < 8 ? d[2] : d[3], hash, 2);
}

/// Scales the range to about [-1, 1]. The authors of Open Shading Language found these values by experiment.
template <int N>
constexpr float kRange = N == 1   ? 0.2500f
                         : N == 2 ? 0.6616f
                         : N == 3 ? 0.9820f
                                  : 0.8344f;

using Float4 = float __attribute__((vector_size(16)));
using Int4 = int32_t __attribute__((vector_size(16)));

template <class Number>
Number fade(Number t) {
  return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
}

/// The noise in a cell of the lattice. The arguments have one number per axis; `cell` is modulo 2^32.
template <int N, class Words, class Numbers>
float noise_in_cell(const Words& cell, const Numbers& fraction, const Numbers& faded) {
  // Each bit of the index of a corner is its side along one axis. In three dimensions the highest bit is that of x, so
  // that each step of the interpolation is between the halves of a vector. In the others the lowest bit is: measured,
  // the compiler's code is faster then (docs/research/speed.md).
  constexpr int kCorners = 1 << N;
  constexpr bool kHalves = N == 3;
  float value[kCorners];
  for (int corner = 0; corner < kCorners; ++corner) {
    uint32_t key[N];
    float d[N];
    for (int axis = 0; axis < N; ++axis) {
      const int side = corner >> (kHalves ? N - 1 - axis : axis) & 1;
      key[axis] = uint32_t(cell[axis]) + uint32_t(side);
      d[axis] = fraction[axis] - float(side);
    }
    value[corner] = contribution(hash_words(key), d);
  }
  for (int axis = 0, count = kCorners / 2; axis < N; ++axis, count /= 2)
    for (int i = 0; i < count; ++i) {
      const float low = value[kHalves ? i : 2 * i], high = value[kHalves ? i + count : 2 * i + 1];
      value[i] = low + faded[axis] * (high - low);
    }
  return kRange<N> * value[0];
}

/// One axis after the other; coordinates need not fit in 32 bits.
template <int N>
float noise_by_axes(Point<N> p) {
  uint32_t cell[N];
  float fraction[N], faded[N];
  for (int axis = 0; axis < N; ++axis) {
    const float low = std::floor(p[axis]);
    if (!(std::abs(low) < 9e18f)) return 0.0f;
    cell[axis] = uint32_t(int64_t(low));
    fraction[axis] = p[axis] - low;
    faded[axis] = fade(fraction[axis]);
  }
  return noise_in_cell<N>(cell, fraction, faded);
}

template <int N>
float signed_noise(Point<N> p) {
  return noise_by_axes(p);
}

/// Noise is mostly in three dimensions. All axes are in one vector, which stays in registers.
template <>
float signed_noise<3>(Point<3> p) {
  bool is_near = true;
  for (int axis = 0; axis < 3; ++axis) is_near &= std::abs(p[axis]) < 0x1p30f;
  if (!is_near) return noise_by_axes(p);
  const Float4 all{p[0], p[1], p[2], 0.0f};
  Int4 low = __builtin_convertvector(all, Int4);
  low += __builtin_convertvector(low, Float4) > all;  // conversion rounds negative numbers up; true is -1
  const Float4 fraction = all - __builtin_convertvector(low, Float4);
  return noise_in_cell<3>(low, fraction, fade(fraction));
}

template <int N>
float fbm(const NoiseParameters& n, Point<N> p) {
  float sum = 0.0f, amplitude = 1.0f, total = 0.0f, frequency = 1.0f;
  for (int i = 0; i < int(n.octaves); ++i) {
    sum += amplitude * signed_noise(frequency * p);
    total += amplitude;
    amplitude *= n.persistence;
    frequency *= n.lacunarity;
  }
  const auto scaled = [&](float value, float range) { return n.normalize ? 0.5f * value / range + 0.5f : value; };
  const float part = n.octaves - std::floor(n.octaves);
  if (part == 0.0f) return scaled(sum, total);
  const float more = sum + amplitude * signed_noise(frequency * p);
  // Without a whole octave the divisor would be 0, so only the fractional octave counts.
  return (total > 0.0f || !n.normalize ? (1.0f - part) * scaled(sum, total) : 0.0f) +
         part * scaled(more, total + amplitude);
}

template <int N>
float multifractal(const NoiseParameters& n, Point<N> p) {
  float value = 1.0f, amplitude = 1.0f;
  for (int i = 0; i < int(n.octaves); ++i, amplitude *= n.persistence, p *= n.lacunarity)
    value *= amplitude * signed_noise(p) + 1.0f;
  const float part = n.octaves - std::floor(n.octaves);
  return part == 0.0f ? value : value * (part * amplitude * signed_noise(p) + 1.0f);
}

template <int N>
float hetero_terrain(const NoiseParameters& n, Point<N> p) {
  float value = n.offset + signed_noise(p), amplitude = n.persistence;
  p *= n.lacunarity;
  const auto increment = [&] { return (signed_noise(p) + n.offset) * amplitude * value; };
  for (int i = 1; i < int(n.octaves); ++i, amplitude *= n.persistence, p *= n.lacunarity) value += increment();
  const float part = n.octaves - std::floor(n.octaves);
  return part == 0.0f ? value : value + part * increment();
}

// Musgrave (Texturing and Modeling, 3rd ed., chapter 16): an octave counts less where the octaves before it were small,
// so that valleys stay smooth. The weight of an octave is the product of gain * signal over the octaves before it, and
// at most 1.
template <int N>
float hybrid_multifractal(const NoiseParameters& n, Point<N> p) {
  constexpr float kInvisible = 0.001f;  // octaves with a smaller weight are left out, as in Blender
  float sum = 0.0f, weight = 1.0f, amplitude = 1.0f;
  for (float left = n.octaves; left > 0.0f && weight > kInvisible; left -= 1.0f) {
    const float signal = amplitude * (signed_noise(p) + n.offset), share = std::min(left, 1.0f);
    weight = std::min(weight, 1.0f);
    sum += share * weight * signal;
    weight *= n.gain * signal;
    amplitude *= n.persistence;
    p *= n.lacunarity;
  }
  return sum;
}

template <int N>
float ridged_multifractal(const NoiseParameters& n, Point<N> p) {
  const auto ridge = [&] { return sqr(n.offset - std::abs(signed_noise(p))); };
  float signal = ridge(), value = signal, amplitude = n.persistence;
  for (int i = 1; i < int(n.octaves); ++i, amplitude *= n.persistence) {
    p *= n.lacunarity;
    signal = ridge() * saturate(signal * n.gain);
    value += amplitude * signal;
  }
  return value;
}

template <int N>
float fractal(const NoiseParameters& n, Point<N> p) {
  switch (n.fractal) {
    case Fractal::Multifractal: return multifractal<N>(n, p);
    case Fractal::Fbm: return fbm<N>(n, p);
    case Fractal::HybridMultifractal: return hybrid_multifractal<N>(n, p);
    case Fractal::RidgedMultifractal: return ridged_multifractal<N>(n, p);
    case Fractal::HeteroTerrain: return hetero_terrain<N>(n, p);
  }
  return 0.0f;
}

/// An offset between 100 and 200 on every axis, which separates the noises of one node.
template <int N>
Point<N> apart(int seed) {
  Point<N> offset;
  for (int axis = 0; axis < N; ++axis)
    offset[axis] = 100.0f + 100.0f * (N == 1 ? hash_unit(seed) : hash_unit(seed, axis));
  return offset;
}

template <int N>
Point<N> distorted(const NoiseParameters& n, Point<N> p) {
  if (n.distortion == 0.0f) return p;
  Point<N> shift;
  for (int axis = 0; axis < N; ++axis) shift[axis] = signed_noise(p + apart<N>(axis));
  return p + n.distortion * shift;
}

}  // namespace

float noise_value(const NoiseParameters& n, Vec3 p, float w) {
  return with_dimensions(n.dimensions, p, w, [&]<int N>(Point<N> q) { return fractal<N>(n, distorted<N>(n, q)); });
}

Color noise_color(const NoiseParameters& n, Vec3 p, float w) {
  return with_dimensions(n.dimensions, p, w, [&]<int N>(Point<N> q) {
    q = distorted<N>(n, q);
    return Color(fractal<N>(n, q), fractal<N>(n, q + apart<N>(N)), fractal<N>(n, q + apart<N>(N + 1)));
  });
}

float normalized_fbm(Vec3 p, float octaves, float persistence) {
  NoiseParameters n;
  n.octaves = octaves;
  n.persistence = persistence;
  return fbm<3>(n, p);
}

}  // namespace ajar::nodes
