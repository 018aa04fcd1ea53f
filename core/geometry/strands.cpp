#include "geometry/strands.h"

#include <algorithm>
#include <cmath>

#include "geometry/deformation.h"

namespace ajar {

namespace {

/// Weights of four keys at u [Catmull and Rom 1974], tension 1/2.
Vec4 catmull_rom(float u) {
  const float t = 1.0f - u;
  return 0.5f * Vec4(-u * t * t, 2.0f + u * u * (3.0f * u - 5.0f), 2.0f + t * t * (3.0f * t - 5.0f), -t * u * u);
}

Vec4 catmull_rom_derivative(float u) {
  const float t = 1.0f - u;
  return 0.5f * Vec4(-t * t + 2.0f * u * t, u * (9.0f * u - 10.0f), -t * (9.0f * t - 10.0f), -2.0f * t * u + u * u);
}

Vec4 sum(const Vec4* keys, Vec4 weights) {
  return weights.x * keys[0] + weights.y * keys[1] + weights.z * keys[2] + weights.w * keys[3];
}

}  // namespace

const Vec4* Strands::control(uint32_t segment, float time, std::array<Vec4, 4>& mixed) const {
  const uint32_t first = first_key[segment];
  if (motion.empty()) return &keys[first];
  const KeyPair at = keys_at(time, motion.size());
  for (uint32_t i = 0; i < 4; ++i)
    mixed[i] = (1.0f - at.share) * motion[at.first][first + i] + at.share * motion[at.first + 1][first + i];
  return mixed.data();
}

Vec3 Strands::center(uint32_t segment, float u, float time) const {
  std::array<Vec4, 4> mixed;
  const Vec4* const k = control(segment, time, mixed);
  return Vec3(shape == StrandShape::Linear ? k[1] + u * (k[2] - k[1]) : sum(k, catmull_rom(u)));
}

Vec3 Strands::tangent(uint32_t segment, float u, float time) const {
  std::array<Vec4, 4> mixed;
  const Vec4* const k = control(segment, time, mixed);
  const Vec3 along(shape == StrandShape::Linear ? k[2] - k[1] : sum(k, catmull_rom_derivative(u)));
  if (length_squared(along) > 0.0f) return along;
  // Where points coincide, use the direction between their neighbours.
  const Vec3 neighbours(k[3] - k[0]);
  return length_squared(neighbours) > 0.0f ? neighbours : Vec3(0, 0, 1);
}

float Strands::radius(uint32_t segment, float u, float time) const {
  std::array<Vec4, 4> mixed;
  const Vec4* const k = control(segment, time, mixed);
  return k[1].w + u * (k[2].w - k[1].w);
}

size_t Strands::memory_bytes() const {
  return keys.size() * (1 + motion.size()) * sizeof(Vec4) + (first_key.size() + roots.size()) * sizeof(uint32_t) +
         (intercepts.size() + lengths.size()) * sizeof(float);
}

std::shared_ptr<const Strands> make_strands(const MeshDescription& mesh) {
  auto made = std::make_shared<Strands>();
  Strands& s = *made;
  s.shape = mesh.strand_shape;
  s.subdivisions = mesh.strand_subdivisions;
  const size_t points = mesh.positions.size(), strands = mesh.strands.size();
  s.keys.reserve(points + 2 * strands);
  s.first_key.reserve(points - strands);
  s.roots.reserve(strands);
  s.intercepts.reserve(points);
  s.lengths.reserve(strands);
  for (size_t i = 0; i < strands; ++i) {
    const size_t first = mesh.strands[i], end = i + 1 < strands ? mesh.strands[i + 1] : points;
    const auto key = [&](size_t point) { s.keys.emplace_back(mesh.positions[point], mesh.radii[point]); };
    key(first);
    s.roots.push_back(uint32_t(s.keys.size()));
    float length = 0.0f;
    for (size_t point = first; point < end; ++point) {
      if (point + 1 < end) s.first_key.push_back(uint32_t(s.keys.size()) - 1);
      if (point > first) length += glm::length(mesh.positions[point] - mesh.positions[point - 1]);
      s.intercepts.push_back(length);
      key(point);
    }
    key(end - 1);
    if (length > 0.0f)
      for (size_t point = first; point < end; ++point) s.intercepts[point] /= length;
    s.lengths.push_back(length);
  }
  const size_t shapes = shape_count(mesh);
  for (size_t shape = 0; shapes > 1 && shape < shapes; ++shape) {
    std::vector<Vec4> moved;
    moved.reserve(s.keys.size());
    const Vec3* const positions = mesh.motion_positions.data() + shape * points;
    const float* const radii = mesh.motion_radii.empty() ? mesh.radii.data() : &mesh.motion_radii[shape * points];
    for (size_t i = 0; i < strands; ++i) {
      const size_t first = mesh.strands[i], end = i + 1 < strands ? mesh.strands[i + 1] : points;
      const auto key = [&](size_t point) { moved.emplace_back(positions[point], radii[point]); };
      key(first);
      for (size_t point = first; point < end; ++point) key(point);
      key(end - 1);
    }
    s.motion.push_back(std::move(moved));
  }
  return made;
}

std::shared_ptr<const Strands> transformed(const Strands& strands, const Mat4& matrix) {
  auto moved = std::make_shared<Strands>(strands);
  const float growth = std::cbrt(std::abs(glm::determinant(Mat3(matrix))));
  const auto move = [&](std::vector<Vec4>& keys) {
    for (Vec4& key : keys) key = Vec4(transform_point(matrix, Vec3(key)), key.w * growth);
  };
  move(moved->keys);
  for (std::vector<Vec4>& keys : moved->motion) move(keys);
  return moved;
}

}  // namespace ajar
