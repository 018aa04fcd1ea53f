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

/// Dot product with the gradient that is 0 along one axis. Its signs along the other axes are the lowest bits of
/// `number`.
template <int N>
float along_edge(uint32_t number, uint32_t zero_axis, const float (&d)[N]) {
  float sum = 0.0f;
  for (int i = 0; i < N - 1; ++i) sum += with_sign(uint32_t(i) < zero_axis ? d[i] : d[i + 1], number, i);
  return sum;
}

inline float contribution(uint32_t hash, const float (&d)[1]) {
  return with_sign(float(int(hash % 8) + 1) * d[0], hash, 3);
}
inline float contribution(uint32_t hash, const float (&d)[2]) {
  const bool along_y = hash % 8 < 4;  // the axis of the component 2
  return with_sign(along_y ? d[0] : d[1], hash, 0) + 2.0f * with_sign(along_y ? d[1] : d[0], hash, 1);
}
inline float contribution(uint32_t hash, const float (&d)[3]) {
  // Perlin extends the twelve edges to sixteen numbers by repeating four that form a tetrahedron: 12 to 15 are 0, 9, 1
  // and 11, the digits of the constant.
  const uint32_t low = hash % 16, number = low < 12 ? low : 0xb190u >> 4 * (low - 12) & 15;
  return along_edge(number, 2 - number / 4, d);
}
inline float contribution(uint32_t hash, const float (&d)[4]) { return along_edge(hash, 3 - hash % 32 / 8, d); }

/// Scales the range to about [-1, 1]. The authors of Open Shading Language found these values by experiment.
template <int N>
constexpr float kRange = N == 1   ? 0.2500f
                         : N == 2 ? 0.6616f
                         : N == 3 ? 0.9820f
                                  : 0.8344f;

template <int N>
float signed_noise(Point<N> p) {
  constexpr int kCorners = 1 << N;
  uint32_t cell[N];
  float fraction[N], fade[N];
  for (int axis = 0; axis < N; ++axis) {
    const float low = std::floor(p[axis]);
    if (!(std::abs(low) < 9e18f)) return 0.0f;
    cell[axis] = uint32_t(int64_t(low));
    const float t = fraction[axis] = p[axis] - low;
    fade[axis] = t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
  }
  // Bit k of the index of a corner is its side along axis k.
  float value[kCorners];
  for (int corner = 0; corner < kCorners; ++corner) {
    uint32_t key[N];
    float d[N];
    for (int axis = 0; axis < N; ++axis) {
      const int side = corner >> axis & 1;
      key[axis] = cell[axis] + uint32_t(side);
      d[axis] = fraction[axis] - float(side);
    }
    value[corner] = contribution(hash_words(key), d);
  }
  for (int axis = 0, count = kCorners / 2; axis < N; ++axis, count /= 2)
    for (int i = 0; i < count; ++i) value[i] = value[2 * i] + fade[axis] * (value[2 * i + 1] - value[2 * i]);
  return kRange<N> * value[0];
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
