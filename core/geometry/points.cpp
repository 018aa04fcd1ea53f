#include "geometry/points.h"

#include <algorithm>
#include <cmath>

namespace ajar {

std::shared_ptr<const Points> make_points(const MeshDescription& mesh) {
  auto made = std::make_shared<Points>();
  made->spheres.reserve(mesh.positions.size());
  for (size_t i = 0; i < mesh.positions.size(); ++i)
    made->spheres.emplace_back(mesh.positions[i], mesh.radii[i] > 0.0f ? mesh.radii[i] : -1.0f);
  const size_t shapes = shape_count(mesh), count = mesh.positions.size();
  for (size_t shape = 0; shapes > 1 && shape < shapes; ++shape) {
    std::vector<Vec4> moved;
    moved.reserve(count);
    for (size_t i = 0; i < count; ++i) {
      const float radius = mesh.motion_radii.empty() ? mesh.radii[i] : mesh.motion_radii[shape * count + i];
      moved.emplace_back(mesh.motion_positions[shape * count + i], radius > 0.0f ? radius : -1.0f);
    }
    made->motion.push_back(std::move(moved));
  }
  return made;
}

std::shared_ptr<const Points> transformed(const Points& points, const Mat4& matrix) {
  auto moved = std::make_shared<Points>(points);
  const float growth = std::cbrt(std::abs(glm::determinant(Mat3(matrix))));
  const auto move = [&](std::vector<Vec4>& spheres) {
    for (Vec4& sphere : spheres) sphere = Vec4(transform_point(matrix, Vec3(sphere)), sphere.w * growth);
  };
  move(moved->spheres);
  for (std::vector<Vec4>& spheres : moved->motion) move(spheres);
  return moved;
}

bool scales_evenly(const Mat4& m) {
  const Mat3 products = glm::transpose(Mat3(m)) * Mat3(m);
  const float scale = (products[0][0] + products[1][1] + products[2][2]) / 3.0f;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!(std::abs(products[i][j] - (i == j ? scale : 0.0f)) <= 1e-5f * scale)) return false;
  return true;
}

Vec3 entry_of_sphere(Vec4 sphere, Vec3 origin, Vec3 direction) {
  // Single precision would lose a small sphere that is far from the origin of the ray.
  const glm::dvec3 d = glm::normalize(glm::dvec3(direction));
  const glm::dvec3 to_center = glm::dvec3(Vec3(sphere)) - glm::dvec3(origin);
  const glm::dvec3 across = glm::dot(to_center, d) * d - to_center;
  const double depth = std::sqrt(std::max(0.0, double(sphere.w) * sphere.w - glm::dot(across, across)));
  const glm::dvec3 entry = across - depth * d;
  const double length = glm::length(entry);
  return length > 0.0 ? Vec3(entry / length) : -Vec3(d);
}

}  // namespace ajar
