// Parts of walks that mutations share: growing a path from either end, and connecting.
#pragma once

#include <algorithm>
#include <cmath>

#include "transport/paths/light_walk_guide.h"
#include "transport/paths/path.h"

namespace ajar {

/// Random displacement whose length has a uniform logarithm [Veach 1997, section 11.4.3].
struct LogarithmicStep {
  float smallest, largest;
  /// In pixels, up to the radius of a circle with a twentieth of the film's area. Steps inside a pixel find nothing
  /// new, so the smallest step is one pixel, and less for small films.
  static LogarithmicStep on_film(const PathSpace& space) {
    const float largest = std::max(1.0f, float(std::sqrt(0.05 * space.film_area() / M_PI)));
    return {std::clamp(largest / 12.0f, 0.1f, 1.0f), largest};
  }
  float sample(float u) const { return smallest * std::pow(largest / smallest, u); }
  /// Density of the length r, per unit of length.
  double pdf_length(double r) const {
    return r >= double(smallest) && r <= double(largest) ? 1.0 / (r * std::log(double(largest) / double(smallest)))
                                                         : 0.0;
  }
  /// Density per unit of area around the centre, and per solid angle when r is an angle.
  double pdf_area(double r) const { return pdf_length(r) / (2.0 * M_PI * r); }
  double pdf_solid_angle(double angle) const { return pdf_length(angle) / (2.0 * M_PI * std::sin(angle)); }
};

/// Angle between unit vectors, exact for small angles.
inline double angle_between(Vec3 a, Vec3 b) { return 2.0 * std::asin(std::min(1.0, 0.5 * double(glm::length(a - b)))); }

/// `direction` turned by `angle` towards the azimuth 2 pi u.
inline Vec3 turn(Vec3 direction, float angle, float u) {
  const float phi = 2.0f * kPi * u, s = std::sin(angle);
  return glm::normalize(Frame(direction).to_world(Vec3(s * std::cos(phi), s * std::sin(phi), std::cos(angle))));
}

/// How a path grows: towards the light (from vertex index + 1), the same from the lens, or towards the eye (from index -
/// 1). With media: which collisions there are.
struct Growth {
  enum Direction : uint8_t { ToLight, ToLightFromLens, ToEye } direction;
  Collisions collisions{};
};

/// Finds the vertex `index` along a ray from its neighbour, and fills the edge between them.
inline bool grow(const PathSpace& space, const Ray& ray, Growth growth, Path& path, int index, Sampler& sampler,
                 uint64_t& rays) {
  const PathScene where = space.path_scene();
  const bool towards_light = growth.direction != Growth::ToEye;
  PathVertex& vertex = path.vertices[size_t(index)];
  vertex.point = ShadingPoint();
  vertex.point.ray_kind = growth.direction == Growth::ToLightFromLens ? uint32_t(kRayCamera) : kLightWalkKind;
  const PathVertex& from = path.vertices[size_t(towards_light ? index + 1 : index - 1)];
  enter_media(where, from, ray.direction, vertex);
  Through through;
  through.collisions = growth.collisions;
  if (growth.direction == Growth::ToEye && index == 1) through.by_kind = RayKindSurfaces::FromLight;
  if (!find_vertex(where, ray, sampler, vertex, through, rays)) return false;
  PathEdge& edge = path.edges[size_t(towards_light ? index : index - 1)];
  edge = towards_light ? join(vertex, from) : join(from, vertex);
  set_edge(edge, through, from, vertex, towards_light);
  return edge.inverse_square > 0.0f && edge.cos_light_end > 0.0f && edge.cos_eye_end > 0.0f;
}
/// Collisions of a walk that keeps the kind of vertex `index` of a path, and the distance of a collision.
inline Collisions collisions_like(const Path& like, int index, bool towards_light) {
  if (like.vertices[size_t(index)].kind != VertexKind::Medium) return {Collisions::Kind::None};
  const PathEdge& edge = like.edges[size_t(towards_light ? index : index - 1)];
  return {Collisions::Kind::AtDistance, 1.0f / std::sqrt(edge.inverse_square)};
}

/// The same for the light at the end of a walk from the eye (vertex 0).
inline bool grow_light(const PathSpace& space, const Ray& ray, Path& path, Sampler& sampler, uint64_t& rays) {
  Through through;
  path.vertices[0].point.ray_kind = kind_towards_light(space.scene, path.vertices[1], path.to_eye(1), ray.direction);
  if (!find_light_end(space.path_scene(), path.vertices[1], ray, sampler, path.vertices[0], through, rays))
    return false;
  path.edges[0] = join(path.vertices[0], path.vertices[1]);
  set_edge(path.edges[0], through, path.vertices[1], path.vertices[0], true);
  return path.edges[0].inverse_square > 0.0f;
}

/// Connects vertices index and index + 1 by a straight edge. Returns false if they do not see each other.
inline bool join_at(const PathSpace& space, Path& path, int index, uint64_t& rays) {
  PathEdge& edge = path.edges[size_t(index)];
  edge = join(path.vertices[size_t(index)], path.vertices[size_t(index + 1)]);
  if (!(edge.inverse_square > 0.0f && edge.cos_light_end > 0.0f && edge.cos_eye_end > 0.0f)) return false;
  return look_along(space.path_scene(), path.vertices[size_t(index)], path.vertices[size_t(index + 1)], edge, rays);
}

/// Sets the point on the film that the last edge reaches. Returns false when it is outside the film.
inline bool arrive_on_film(const PathSpace& space, Path& path) {
  const auto film = space.scene.camera().film_of(path.vertices[size_t(path.count - 1)].point.barycentric,
                                                 path.vertices[size_t(path.count - 2)].position(), path.time());
  if (!film || !space.on_film(*film)) return false;
  path.film = *film;
  const PathVertex& seen = path.vertices[size_t(path.count - 2)];
  return seen.kind != VertexKind::Surface || shows_on_film(seen.point);
}

/// Probability that a sharp reflection is repeated about the same half vector (in the frame of the normal), turned by a
/// small angle. Otherwise the BSDF draws the direction.
constexpr float kSameHalfVector = 0.7f;
constexpr LogarithmicStep kHalfVectorStep{0.0005f, 0.1f};

/// The direction of the reflection at `vertex` of light that arrives from `wo`, about the half vector that the path
/// `like` has at this index.
inline Vec3 reflect_alike(const Path& like, int index, const PathVertex& vertex, Vec3 wo) {
  const Vec3 half = Frame(vertex.point.ns)
                        .to_world(Frame(like.vertices[size_t(index)].point.ns)
                                      .to_local(glm::normalize(like.to_light(index) + like.to_eye(index))));
  return 2.0f * glm::dot(wo, half) * half - wo;
}

/// The next direction of a walk from the light, drawn by a hint or by the BSDF.
struct WalkDirection {
  bool found = false, specular = false;
  Vec3 direction{0.0f};
};
inline WalkDirection sample_walk_direction(const LightWalkGuide* guide, const PathVertex& vertex, Vec3 wo,
                                           Sampler& sampler) {
  float u_lobe = sampler.get_1d();
  const Vec2 u = sampler.get_2d();
  if (guide && vertex.kind == VertexKind::Surface && vertex.connectable())
    if (const auto along = guide->direction_at(vertex.position(), u_lobe, u)) return {true, false, *along};
  const auto drawn = sample_direction(vertex, wo, u_lobe, u);
  if (!drawn || (drawn->flags & kTransparent)) return {};
  return {true, drawn->specular, drawn->wi};
}

/// The next direction of a walk at `vertex` that repeats the bounce of the path `like` at this index: it follows
/// specular lobes of the same kind and repeats sharp reflections.
inline std::optional<Vec3> repeat_bounce(const Path& like, int index, const PathVertex& vertex, Vec3 wo,
                                         Sampler& sampler) {
  const float u_lobe = sampler.get_1d();
  if (vertex.specular) {
    const auto followed = follow_direction(vertex, wo, like.transmits(index), u_lobe);
    if (!followed) return {};
    return followed->wi;
  }
  const float u_kind = sampler.get_1d();
  const Vec2 u = sampler.get_2d();
  if (!like.transmits(index) && u_kind < kSameHalfVector)
    return turn(reflect_alike(like, index, vertex, wo), kHalfVectorStep.sample(u.x), u.y);
  const auto drawn = sample_direction(vertex, wo, u_lobe, u);
  if (!drawn || drawn->specular || (drawn->flags & kTransparent)) return {};
  return drawn->wi;
}

/// Density of repeat_bounce, per solid angle (discrete when specular), for walks towards the light or towards the eye.
inline double pdf_of_repeated(const Path& like, const Path& to, int index, bool towards_light) {
  const Scattering& s = to.scattering[size_t(index)];
  if (!to.joinable(index)) return double(towards_light ? s.follow_to_light : s.follow_to_eye);
  const double drawn = double(towards_light ? s.pdf_to_light : s.pdf_to_eye);
  if (like.transmits(index)) return drawn;
  const Vec3 wo = towards_light ? to.to_eye(index) : to.to_light(index),
             wi = towards_light ? to.to_light(index) : to.to_eye(index);
  const double repeated = kHalfVectorStep.pdf_solid_angle(
      angle_between(reflect_alike(like, index, to.vertices[size_t(index)], wo), wi));
  return double(kSameHalfVector) * repeated + double(1.0f - kSameHalfVector) * drawn;
}

/// Whether two paths have the same kind of bounce at each vertex: specular (and to which side), sharp, or rough.
inline bool same_configuration(const Path& a, const Path& b) {
  if (a.count != b.count) return false;
  for (int i = 1; i < a.count - 1; ++i)
    if (a.vertices[size_t(i)].kind != b.vertices[size_t(i)].kind || a.joinable(i) != b.joinable(i) ||
        a.rough(i) != b.rough(i) || (!a.joinable(i) && a.transmits(i) != b.transmits(i)))
      return false;
  return true;
}

}  // namespace ajar
