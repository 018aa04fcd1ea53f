#include "transport/photons/path_photons.h"

#include <cmath>

#include "transport/direct/lobe_split.h"
#include "transport/paths/ray_events.h"

namespace ajar {

namespace {

/// Scattering of an inner vertex by its rough lobes and by its sharp lobes.
struct Events {
  glm::dvec3 rough{0.0}, sharp{0.0};
  bool continues = false;  ///< walks from the eye look up no photons here: all lobes are followed
  bool is_caustic = true;  ///< photons that the sharp lobes scatter are in the caustic map
  bool gathers = false;    ///< a medium: gather rays start here, unless the walk is one already
};

/// `visibility`: of the light at the other end of the edge towards the light, else all.
Events events_at(const Path& path, int i, uint32_t visibility) {
  const PathVertex& vertex = path.vertices[size_t(i)];
  const glm::dvec3 f(path.scattering[size_t(i)].f);
  if (vertex.kind == VertexKind::Medium) return {.rough = f, .continues = true, .gathers = true};
  if (on_strand_or_point(vertex.point)) return {f, glm::dvec3(0.0), true};
  if (vertex.specular) return {glm::dvec3(0.0), f};
  if (!has_rough_lobe(vertex.shading.bsdf))
    return {glm::dvec3(0.0), f, false, !seen_by_bent_lobes(vertex.point, vertex.shading.bsdf, path.to_eye(i))};
  const LobeSplit split(vertex.shading.bsdf, path.to_eye(i));
  if (!split.sharp() || !split.sharp()->has_non_delta()) return {f, glm::dvec3(0.0)};
  const auto scattered_by = [&](const Bsdf& lobes) {
    return glm::dvec3(visibility == kVisibleAll ? lobes.evaluate(path.to_eye(i), path.to_light(i)).f_cos
                                                : visible_to(visibility, lobes, path.to_eye(i), path.to_light(i)));
  };
  const glm::dvec3 rough = scattered_by(*split.rough()), sharp = scattered_by(*split.sharp());
  return {rough, sharp, false, !seen_by_bent_lobes(vertex.point, *split.sharp(), path.to_eye(i))};
}

SeenFrom seen_from(const Path& path, int i) {
  const PathVertex& vertex = path.vertices[size_t(i)];
  const Vec3 ng = glm::dot(vertex.point.ng, path.to_light(i)) < 0.0f ? -vertex.point.ng : vertex.point.ng;
  const Bsdf& bsdf = vertex.shading.bsdf;
  if (!transmits(bsdf)) return {ng, 0};
  const LobeSplit split(bsdf, path.to_eye(i));
  return split.rough() ? seen_from(*split.rough(), ng) : SeenFrom{ng, 0};
}

/// Throughputs to the eye by way of a rough event: of each place where gather rays start, its own.
class Gathered {
 public:
  void start(Vec3 from, const glm::dvec3& throughput) {
    if (glm::any(glm::notEqual(throughput, glm::dvec3(0.0)))) rays_[size_t(count_++)] = {from, throughput};
  }
  Gathered& operator*=(const glm::dvec3& factor) {
    for (int i = 0; i < count_; ++i) rays_[size_t(i)].throughput *= factor;
    return *this;
  }
  /// The sum of those that come from `shortest` or further.
  glm::dvec3 at(Vec3 position, float shortest) const {
    glm::dvec3 sum(0.0);
    for (int i = 0; i < count_; ++i)
      if (length_squared(position - rays_[size_t(i)].from) >= sqr(shortest)) sum += rays_[size_t(i)].throughput;
    return sum;
  }

 private:
  struct Ray {
    Vec3 from;
    glm::dvec3 throughput;
  };
  std::array<Ray, kMaxPathVertices> rays_;
  int count_ = 0;
};

}  // namespace

int photons_of(const PathSpace& space, const Path& path, float shortest, PathPhoton* out, uint64_t& refused) {
  const PhotonKernels kernels = photon_kernels(space.scene);
  const int n = path.count;
  uint32_t visibility = kVisibleAll;
  if (path.light.partial) visibility = space.scene.lights().flags(uint32_t(path.vertices[0].light)).visibility;
  // Light that arrives at each vertex, and its part that was scattered by sharp lobes only.
  std::array<glm::dvec3, kMaxPathVertices> arriving, arriving_sharp;
  std::array<Events, kMaxPathVertices> events;
  glm::dvec3 light(path.light.radiance), sharp(light);
  for (int i = 1; i <= n - 1; ++i) {
    const PathEdge& edge = path.edges[size_t(i - 1)];
    const glm::dvec3 through = glm::dvec3(edge.transmittance) * double(edge.to_light_area());
    arriving[size_t(i)] = light *= through;
    arriving_sharp[size_t(i)] = sharp *= through;
    if (i == n - 1) break;
    events[size_t(i)] = events_at(path, i, i == 1 ? visibility : uint32_t(kVisibleAll));
    light *= glm::dvec3(path.scattering[size_t(i)].f);
    sharp *= events[size_t(i)].is_caustic ? events[size_t(i)].sharp : glm::dvec3(0.0);
  }
  // The part of the path's contribution that the bounce limits leave.
  const double lens = double(path.film_density) * double(space.pdf_lens_area()),
               whole = luminance(glm::abs(light * lens));
  const double limits = whole > 0.0 ? path.energy() / whole : 0.0;

  // Throughput from each vertex to the eye: without a rough event (`seen`) and with one (`gathered`).
  const double pixels = lens * double(space.filter_sum(path.film));
  glm::dvec3 seen(pixels);
  Gathered gathered;
  int count = 0;
  for (int i = n - 2; i >= 1; --i) {
    const PathEdge& edge = path.edges[size_t(i)];
    const glm::dvec3 through = glm::dvec3(edge.transmittance) * double(edge.to_light_area());
    seen *= through;
    gathered *= through;
    const PathVertex& vertex = path.vertices[size_t(i)];
    const auto leave = [&](ArrivalMap::Place place, const glm::dvec3& flux, const glm::dvec3& throughput) {
      // Phi [Fan 2006, section 4.2.2]
      const Color power(flux * (limits * luminance(throughput) / double(path.target)));
      if (is_black(power)) return;
      if (!is_finite(power)) {
        ++refused;
        return;
      }
      const SeenFrom side = seen_from(path, i);
      const float way = path.vertices[size_t(i - 1)].distant
                            ? kInfinity
                            : 1.0f / std::sqrt(path.edges[size_t(i - 1)].inverse_square);
      out[count++] = {place,
                      {surface_point(vertex.point, side.normal), power,
                       pack_direction_short(path.to_light(i)) | kernels.packed(way) | side.flags | Photon::kOfChain},
                      &vertex};
    };
    const Events& e = events[size_t(i)];
    if (vertex.kind == VertexKind::Surface && vertex.shading.bsdf.has_subsurface() && !on_strand_or_point(vertex.point))
      break;
    if (e.gathers) {
      gathered.start(vertex.position(), seen);
      seen = glm::dvec3(0.0);
    }
    if (e.continues) {
      gathered *= e.rough;
      seen *= e.rough;
      continue;
    }
    if (!vertex.specular && has_rough_lobe(vertex.shading.bsdf)) {
      if (i > 1) leave(ArrivalMap::kSeen, arriving_sharp[size_t(i)], seen);
      // Lookups would not separate the kinds of lobes: they sample such a light themselves.
      if ((i > 1 || !path.light.partial) && scatters_evenly(vertex.shading.bsdf))
        leave(ArrivalMap::kGathered, arriving[size_t(i)], gathered.at(vertex.position(), shortest));
    }
    gathered *= e.sharp;
    gathered.start(vertex.position(), seen * e.rough);
    seen *= e.sharp;
  }
  return count;
}

}  // namespace ajar
