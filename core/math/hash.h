// The hashes of Blender's procedural textures: Bob Jenkins' lookup3 (public domain), and the permuted congruential
// generators in two to four dimensions of Jarzynski and Olano ("Hash Functions for GPU Rendering", JCGT 9(3), 2020).
// The latter are in signed arithmetic; the cells of Voronoi textures use them since Blender 5.0.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "math/types.h"

namespace ajar::nodes {

/// A point of a texture space of N dimensions.
template <int N>
using Point = glm::vec<N, float>;

/// lookup3's hashword of N words with seed 0.
template <int N>
constexpr uint32_t hash_words(const uint32_t (&key)[N]) {
  static_assert(N >= 1 && N <= 4);
  uint32_t a = 0xdeadbeefu + (uint32_t(N) << 2) + 13u, b = a, c = a;
  const auto turn = [](uint32_t& x, uint32_t y, int bits) { x -= y, x ^= std::rotl(y, bits); };
  int i = 0;
  if constexpr (N > 3) {
    a += key[0], b += key[1], c += key[2], i = 3;
    turn(a, c, 4), c += b;
    turn(b, a, 6), a += c;
    turn(c, b, 8), b += a;
    turn(a, c, 16), c += b;
    turn(b, a, 19), a += c;
    turn(c, b, 4), b += a;
  }
  if (N - i > 2) c += key[i + 2];
  if (N - i > 1) b += key[i + 1];
  a += key[i];
  const auto finish = [](uint32_t& x, uint32_t y, int bits) { x ^= y, x -= std::rotl(y, bits); };
  finish(c, b, 14), finish(a, c, 11), finish(b, a, 25), finish(c, b, 16), finish(a, c, 4), finish(b, a, 14),
      finish(c, b, 24);
  return c;
}

/// A number in [0, 1] from the bits of floats.
template <class... Numbers>
float hash_unit(Numbers... numbers) {
  const uint32_t key[] = {std::bit_cast<uint32_t>(float(numbers))...};
  return float(hash_words(key)) * 0x1p-32f;
}

/// Three independent numbers per point; the first is the hash of the point itself.
inline Color hash_color(Point<1> p) { return {hash_unit(p.x), hash_unit(p.x, 1), hash_unit(p.x, 2)}; }
inline Color hash_color(Point<2> p) { return {hash_unit(p.x, p.y), hash_unit(p.x, p.y, 1), hash_unit(p.x, p.y, 2)}; }
inline Color hash_color(Point<3> p) {
  return {hash_unit(p.x, p.y, p.z), hash_unit(p.x, p.y, p.z, 1), hash_unit(p.x, p.y, p.z, 2)};
}
inline Color hash_color(Point<4> p) {
  return {hash_unit(p.x, p.y, p.z, p.w), hash_unit(p.z, p.x, p.w, p.y), hash_unit(p.w, p.z, p.y, p.x)};
}

/// A point of the unit cube for each cell.
inline Point<1> hash_point(Point<1> p) { return Point<1>(hash_unit(p.x)); }
inline Point<2> hash_point(Point<2> p) { return {hash_unit(p.x, p.y), hash_unit(p.x, p.y, 1)}; }
inline Point<3> hash_point(Point<3> p) { return hash_color(p); }
inline Point<4> hash_point(Point<4> p) {
  return {hash_unit(p.x, p.y, p.z, p.w), hash_unit(p.w, p.x, p.y, p.z), hash_unit(p.z, p.w, p.x, p.y),
          hash_unit(p.y, p.z, p.w, p.x)};
}

/// PCG in N dimensions, in place: N words to N independent ones. Words wrap around; the right shift is arithmetic and
/// keeps their sign.
template <int N>
constexpr void permute(uint32_t (&v)[N]) {
  static_assert(N >= 2 && N <= 4);
  for (uint32_t& word : v) word = word * 1664525u + 1013904223u;
  for (int round = 0; round < 2; ++round) {
    if constexpr (N == 2)
      v[0] += v[1] * 1664525u, v[1] += v[0] * 1664525u;
    else if constexpr (N == 3)
      v[0] += v[1] * v[2], v[1] += v[2] * v[0], v[2] += v[0] * v[1];
    else
      v[0] += v[1] * v[3], v[1] += v[2] * v[0], v[2] += v[0] * v[1], v[3] += v[1] * v[2];
    if (round == 0)
      for (uint32_t& word : v) word ^= uint32_t(int32_t(word) >> 16);
  }
}
/// A number in [0, 1] from a word of `permute`.
constexpr float permuted_unit(uint32_t word) { return float(int32_t(word & 0x7fffffffu)) * 0x1p-31f; }

/// The integer coordinate of a cell, as a word; 0 if it is not finite.
inline uint32_t cell_word(float x) {
  return std::isfinite(x) ? uint32_t(int32_t(std::clamp(x, -0x1p31f, 0x1.fffffep30f))) : 0u;
}

/// N independent numbers in [0, 1] for a cell with integer coordinates.
template <int N>
Point<N> hash_cell(Point<N> cell) {
  uint32_t v[N];
  for (int axis = 0; axis < N; ++axis) v[axis] = cell_word(cell[axis]);
  permute(v);
  Point<N> unit;
  for (int axis = 0; axis < N; ++axis) unit[axis] = permuted_unit(v[axis]);
  return unit;
}

/// Calls `f` with the coordinates that a texture node uses in each number of dimensions: W, XY, XYZ, or XYZW.
template <class F>
auto with_dimensions(int dimensions, Vec3 p, float w, F&& f) {
  switch (dimensions) {
    case 1: return f(Point<1>(w));
    case 2: return f(Point<2>(p));
    case 3: return f(Point<3>(p));
    default: return f(Point<4>(p, w));
  }
}

inline Color white_noise(int dimensions, Vec3 p, float w) {
  return with_dimensions(dimensions, p, w, [](auto point) { return hash_color(point); });
}

}  // namespace ajar::nodes
